//! Operations of the engine and their codes in a microcode word.

use orbsoc::real::Opcode;

/// An operation of a lane or a divider.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)] // docs/pl-machine.md, "Operations"
pub enum Code {
    Move,
    Neg,
    Abs,
    Mul,
    Add,
    Sub,
    AddMul,
    SubMul,
    Min,
    Max,
    Compare,
    And,
    Select,
    Div,
    Sqrt,
}

impl Code {
    /// All of them: those of a lane in the order of their codes from 1, then those of a divider.
    pub const ALL: [Self; 15] = [
        Self::Move,
        Self::Neg,
        Self::Abs,
        Self::Mul,
        Self::Add,
        Self::Sub,
        Self::AddMul,
        Self::SubMul,
        Self::Min,
        Self::Max,
        Self::Compare,
        Self::And,
        Self::Select,
        Self::Div,
        Self::Sqrt,
    ];
    const ON_LANES: usize = 13;

    /// The name that docs/pl-machine.md gives it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Move => "move",
            Self::Neg => "neg",
            Self::Abs => "abs",
            Self::Mul => "mul",
            Self::Add => "add",
            Self::Sub => "sub",
            Self::AddMul => "add_mul",
            Self::SubMul => "sub_mul",
            Self::Min => "min",
            Self::Max => "max",
            Self::Compare => "compare",
            Self::And => "and",
            Self::Select => "select",
            Self::Div => "div",
            Self::Sqrt => "sqrt",
        }
    }

    /// Runs on a divider.
    pub fn on_divider(self) -> bool {
        matches!(self, Self::Div | Self::Sqrt)
    }

    /// The number in a lane's or a divider's opcode field; 0 is no operation.
    pub fn field(self) -> u8 {
        let position = self as u8;
        1 + if self.on_divider() { position - Self::ON_LANES as u8 } else { position }
    }

    /// The operation of a field's number; none for 0 and for numbers that are no operation.
    pub fn of_field(field: u64, divider: bool) -> Option<Self> {
        let (first, count) =
            if divider { (Self::ON_LANES, Self::ALL.len() - Self::ON_LANES) } else { (0, Self::ON_LANES) };
        let position = usize::try_from(field).ok()?.checked_sub(1)?;
        (position < count).then(|| Self::ALL[first + position])
    }

    /// Which of the operands a, b and c it reads.
    pub fn reads(self) -> [bool; 3] {
        match self {
            Self::Move | Self::Neg | Self::Abs | Self::Sqrt => [true, false, false],
            Self::Mul | Self::Min | Self::Max | Self::Compare | Self::And | Self::Div => [true, true, false],
            Self::Add | Self::Sub => [true, false, true],
            Self::AddMul | Self::SubMul | Self::Select => [true, true, true],
        }
    }

    /// The multiply-add with the same result, bit for bit: a·b = −0 + a·b and c ± a = c ± a·1.
    pub fn as_multiply_add(self) -> Option<Self> {
        match self {
            Self::Mul | Self::Add => Some(Self::AddMul),
            Self::Sub => Some(Self::SubMul),
            _ => None,
        }
    }

    /// Whether a and b may be exchanged without changing a bit.
    pub fn commutes(self) -> bool {
        matches!(self, Self::Mul | Self::AddMul | Self::SubMul | Self::And)
    }
}

impl From<Opcode> for Code {
    fn from(opcode: Opcode) -> Self {
        match opcode {
            Opcode::Neg => Self::Neg,
            Opcode::Abs => Self::Abs,
            Opcode::Mul => Self::Mul,
            Opcode::Add => Self::Add,
            Opcode::Sub => Self::Sub,
            Opcode::AddMul => Self::AddMul,
            Opcode::SubMul => Self::SubMul,
            Opcode::Div => Self::Div,
            Opcode::Sqrt => Self::Sqrt,
            Opcode::Min => Self::Min,
            Opcode::Max => Self::Max,
            Opcode::Compare => Self::Compare,
            Opcode::And => Self::And,
            Opcode::Select => Self::Select,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_name_operations_one_to_one() {
        for code in Code::ALL {
            assert_eq!(Code::of_field(u64::from(code.field()), code.on_divider()), Some(code));
        }
        for (field, divider) in [(0, false), (0, true), (14, false), (15, false), (3, true)] {
            assert_eq!(Code::of_field(field, divider), None);
        }
        let known = [(Code::Move, 1), (Code::SubMul, 8), (Code::Select, 13), (Code::Div, 1), (Code::Sqrt, 2)];
        assert!(known.iter().all(|(code, field)| code.field() == *field));
    }
}

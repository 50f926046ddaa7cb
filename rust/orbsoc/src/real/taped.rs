//! A datapath without numbers that records the operations themselves: the operation stream of the
//! hardware is nothing else than what a kernel asked of this scalar.
//!
//! Values are in single-assignment form: every operation makes a new one, and copies make none. Which
//! word of storage a value lives in is the scheduler's business.

use super::scalar::Real;
use crate::symbolic::indices::index;
use core::cell::RefCell;
use core::ops::{Add, Div, Mul, Neg, Sub};
use std::collections::HashMap;

/// Where a value comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Value {
    /// What a buffer's word held before the stage.
    Word {
        /// The buffer's place in [`crate::Buffer::ALL`].
        buffer: u16,
        /// Which of its words.
        index: u32,
    },
    /// An entry of the tape's constants.
    Constant(u32),
    /// The result of an operation.
    Result(u32),
}

/// What an operation does with its operands `a`, `b`, `c`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Opcode {
    /// −a.
    Neg,
    /// |a|.
    Abs,
    /// a·b.
    Mul,
    /// c + a.
    Add,
    /// c − a.
    Sub,
    /// c + a·b, two roundings.
    AddMul,
    /// c − a·b, two roundings.
    SubMul,
    /// a / b.
    Div,
    /// √a.
    Sqrt,
    /// b < a ? b : a.
    Min,
    /// a < b ? b : a.
    Max,
    /// a < b, a mask.
    Compare,
    /// a ∧ b, masks.
    And,
    /// c ? a : b, c a mask.
    Select,
}

/// One scalar operation. Operands that its opcode does not use are absent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)] // the operands of `Opcode`
pub struct Operation {
    pub opcode: Opcode,
    pub a: Value,
    pub b: Option<Value>,
    pub c: Option<Value>,
}

/// What [`record`] saw: constants and operations in the order in which they were asked for.
#[derive(Clone, Debug, Default)]
pub(crate) struct Record {
    pub constants: Vec<f64>,
    pub operations: Vec<Operation>,
    known: HashMap<u64, u32>,
}

impl Record {
    fn constant(&mut self, value: f64) -> Value {
        let constants = &mut self.constants;
        let at = self.known.entry(value.to_bits()).or_insert_with(|| {
            constants.push(value);
            index(constants.len() - 1)
        });
        Value::Constant(*at)
    }

    fn push(&mut self, operation: Operation) -> Value {
        self.operations.push(operation);
        Value::Result(index(self.operations.len() - 1))
    }
}

thread_local! {
    static RECORD: RefCell<Option<Record>> = const { RefCell::new(None) };
}

/// Run `kernel` and return the operations on [`Taped`] scalars made on this thread meanwhile.
pub(crate) fn record(kernel: impl FnOnce()) -> Record {
    let outer = RECORD.replace(Some(Record::default()));
    kernel();
    RECORD.replace(outer).unwrap_or_default()
}

fn with_record(make: impl FnOnce(&mut Record) -> Value) -> Taped {
    // Outside of a recording there is nothing to name: such a value is replaced before it is used.
    RECORD.with_borrow_mut(|record| Taped(record.as_mut().map_or(Value::Constant(u32::MAX), make)))
}

/// A scalar that is only the name of its value.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Taped(pub Value);

/// A comparison outcome that is only the name of its mask.
#[derive(Clone, Copy)]
pub(crate) struct TapedMask(Value);

fn operate(opcode: Opcode, a: Value, b: Option<Value>, c: Option<Value>) -> Taped {
    with_record(|record| record.push(Operation { opcode, a, b, c }))
}

macro_rules! binary {
    ($($trait:ident $name:ident |$x:ident, $y:ident| $a:expr, $b:expr, $c:expr;)*) => {$(
        impl $trait for Taped {
            type Output = Self;
            fn $name(self, other: Self) -> Self {
                let ($x, $y) = (self.0, other.0);
                operate(Opcode::$trait, $a, $b, $c)
            }
        }
    )*};
}

binary! {
    Add add |x, y| y, None, Some(x);
    Sub sub |x, y| y, None, Some(x);
    Mul mul |x, y| x, Some(y), None;
    Div div |x, y| x, Some(y), None;
}

impl Neg for Taped {
    type Output = Self;
    fn neg(self) -> Self {
        operate(Opcode::Neg, self.0, None, None)
    }
}

impl Real for Taped {
    type Mask = TapedMask;
    const TILE_COLS: usize = 4;

    fn vectorize<W: pulp::WithSimd>(work: W) -> W::Output {
        work.with_simd(pulp::Scalar)
    }

    fn constant(value: f64) -> Self {
        with_record(|record| record.constant(value))
    }
    fn sqrt(self) -> Self {
        operate(Opcode::Sqrt, self.0, None, None)
    }
    fn abs(self) -> Self {
        operate(Opcode::Abs, self.0, None, None)
    }
    fn lt(self, other: Self) -> TapedMask {
        TapedMask(operate(Opcode::Compare, self.0, Some(other.0), None).0)
    }
    fn and(a: TapedMask, b: TapedMask) -> TapedMask {
        TapedMask(operate(Opcode::And, a.0, Some(b.0), None).0)
    }
    fn select(mask: TapedMask, yes: Self, no: Self) -> Self {
        operate(Opcode::Select, yes.0, Some(no.0), Some(mask.0))
    }
    fn add_mul(self, a: Self, b: Self) -> Self {
        operate(Opcode::AddMul, a.0, Some(b.0), Some(self.0))
    }
    fn sub_mul(self, a: Self, b: Self) -> Self {
        operate(Opcode::SubMul, a.0, Some(b.0), Some(self.0))
    }
    fn max(self, other: Self) -> Self {
        operate(Opcode::Max, self.0, Some(other.0), None)
    }
    fn min(self, other: Self) -> Self {
        operate(Opcode::Min, self.0, Some(other.0), None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn word(index: u32) -> Value {
        Value::Word { buffer: 3, index }
    }

    #[test]
    fn every_operation_is_recorded_as_itself() {
        let (x, y, z) = (Taped(word(0)), Taped(word(1)), Taped(word(2)));
        let recorded = record(|| {
            let _ = (-x, x.abs(), x.sqrt(), x * y, x + y, x - y, x / y);
            let _ = (x.add_mul(y, z), x.sub_mul(y, z), Real::min(x, y), Real::max(x, y));
            let mask = Taped::and(x.lt(y), y.lt(x));
            let _ = Taped::select(mask, x, y);
        });
        let expected = |opcode, operands: [Option<u32>; 3]| {
            let [a, b, c] = operands.map(|operand| operand.map(word));
            Operation { opcode, a: a.unwrap(), b, c }
        };
        let results =
            |opcode, a, b| Operation { opcode, a: Value::Result(a), b: Some(Value::Result(b)), c: None };
        let mut select = expected(Opcode::Select, [Some(0), Some(1), None]);
        select.c = Some(Value::Result(13));
        assert_eq!(
            recorded.operations,
            [
                expected(Opcode::Neg, [Some(0), None, None]),
                expected(Opcode::Abs, [Some(0), None, None]),
                expected(Opcode::Sqrt, [Some(0), None, None]),
                expected(Opcode::Mul, [Some(0), Some(1), None]),
                expected(Opcode::Add, [Some(1), None, Some(0)]),
                expected(Opcode::Sub, [Some(1), None, Some(0)]),
                expected(Opcode::Div, [Some(0), Some(1), None]),
                expected(Opcode::AddMul, [Some(1), Some(2), Some(0)]),
                expected(Opcode::SubMul, [Some(1), Some(2), Some(0)]),
                expected(Opcode::Min, [Some(0), Some(1), None]),
                expected(Opcode::Max, [Some(0), Some(1), None]),
                expected(Opcode::Compare, [Some(0), Some(1), None]),
                expected(Opcode::Compare, [Some(1), Some(0), None]),
                results(Opcode::And, 11, 12),
                select,
            ]
        );
    }

    #[test]
    fn equal_constants_are_one_and_the_sign_of_zero_counts() {
        let recorded = record(|| {
            let _ = (Taped::one() + Taped::zero()) * Taped::one() - Taped::constant(-0.0);
        });
        assert_eq!(recorded.constants.len(), 3);
        assert_eq!(recorded.operations[1].b, Some(Value::Constant(0)));
    }

    #[test]
    fn recordings_do_not_see_each_other() {
        let outer = record(|| {
            let inner = record(|| {
                let _ = Taped::one() + Taped::one();
            });
            assert_eq!(inner.operations.len(), 1);
            let _ = Taped::one() * Taped::one();
        });
        assert_eq!(outer.operations.len(), 1);
        let unrecorded = Taped::one() + Taped::one();
        assert_eq!(unrecorded.0, Value::Constant(u32::MAX));
    }
}

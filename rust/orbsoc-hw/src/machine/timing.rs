//! Latencies, read from the files that the RTL includes; no number of them is written here.

use super::operation::Code;
use crate::error::Error;
use std::sync::OnceLock;

/// Word format of the datapath.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub enum Precision {
    F64,
    F32,
}

impl Precision {
    /// Bits of a word.
    pub fn bits(self) -> u32 {
        match self {
            Self::F64 => 64,
            Self::F32 => 32,
        }
    }
}

/// Latencies and depths, in cycles, and widths, in bits; docs/pl-machine.md.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)] // the names are those of the contract
pub struct Timing {
    pub add: u32,
    pub mul: u32,
    pub div: u32,
    pub sqrt: u32,
    pub div_interval: u32,
    pub sqrt_interval: u32,
    pub simple: u32,
    pub read: u32,
    pub write: u32,
    pub startup: u32,
    pub decode: u32,
    pub finish: u32,
    pub queue_depth: u32,
    pub short_bits: u32,
    pub template_bits: u32,
    pub headers_ahead: u32,
    pub template_width: u32,
}

const UNITS: &str = include_str!("../../../../rtl/latency.svh");
const ENGINE: &str = include_str!("../../../../rtl/engine.svh");
const MOST_CYCLES: u32 = 50;
const UNITS_MISREAD: &str = "add, mul, div, sqrt, div_interval, sqrt_interval or simple";

/// A number of `rtl/engine.svh`.
pub(crate) fn engine_parameter(name: &str) -> u32 {
    parameter(ENGINE, name)
}

impl Timing {
    /// The RTL's own.
    pub fn of(precision: Precision) -> &'static Self {
        static TIMINGS: OnceLock<[Timing; 2]> = OnceLock::new();
        let timings = TIMINGS.get_or_init(|| [Self::read("F64"), Self::read("F32")]);
        &timings[usize::from(precision == Precision::F32)]
    }

    fn read(prefix: &str) -> Self {
        let unit = |name: &str| parameter(UNITS, &format!("{prefix}_{name}_CYCLES"));
        let engine = engine_parameter;
        Self {
            add: unit("ADD"),
            mul: unit("MUL"),
            div: unit("DIV"),
            sqrt: unit("SQRT"),
            div_interval: unit("DIV_INTERVAL"),
            sqrt_interval: unit("SQRT_INTERVAL"),
            simple: engine("SIMPLE_CYCLES"),
            read: engine("READ_CYCLES"),
            write: engine("WRITE_CYCLES"),
            startup: engine("STARTUP_CYCLES"),
            decode: engine("DECODE_CYCLES"),
            finish: engine("FINISH_CYCLES"),
            queue_depth: engine("QUEUE_DEPTH"),
            short_bits: engine("SHORT_BITS"),
            template_bits: engine("TEMPLATE_BITS"),
            headers_ahead: engine("HEADERS_AHEAD"),
            template_width: engine("TEMPLATE_WIDTH"),
        }
    }

    /// What of it a program depends on, in the order of the RTL's `axi_contract::identity`.
    pub fn contract(&self) -> [u32; 15] {
        [
            self.add,
            self.mul,
            self.div,
            self.sqrt,
            self.div_interval,
            self.sqrt_interval,
            self.simple,
            self.read,
            self.write,
            self.startup,
            self.decode,
            self.headers_ahead,
            self.short_bits,
            self.template_bits,
            self.template_width,
        ]
    }

    /// The same table with one unit's latency changed by `by`, as a wrong model would have it.
    ///
    /// # Errors
    /// [`Error::Configuration`] for an unknown unit, and for a latency out of range.
    pub fn misread(mut self, unit: &str, by: i32) -> Result<Self, Error> {
        let (field, cycles) = match unit {
            "add" => ("add", &mut self.add),
            "mul" => ("mul", &mut self.mul),
            "div" => ("div", &mut self.div),
            "sqrt" => ("sqrt", &mut self.sqrt),
            "div_interval" => ("div_interval", &mut self.div_interval),
            "sqrt_interval" => ("sqrt_interval", &mut self.sqrt_interval),
            "simple" => ("simple", &mut self.simple),
            _ => return Err(Error::Configuration { field: "misread", value: 0, allowed: UNITS_MISREAD }),
        };
        *cycles = cycles.saturating_add_signed(by);
        if (1..=MOST_CYCLES).contains(cycles) {
            return Ok(self);
        }
        Err(Error::Configuration { field, value: (*cycles).into(), allowed: "1 to 50 cycles" })
    }

    /// Cycles from the operands at a unit to its result.
    pub fn latency(&self, code: Code) -> u32 {
        match code {
            Code::Mul => self.mul,
            Code::Add | Code::Sub => self.add,
            Code::AddMul | Code::SubMul => self.mul + self.add,
            Code::Div => self.div,
            Code::Sqrt => self.sqrt,
            _ => self.simple,
        }
    }

    /// Cycles from an issue to the next that the same divider, or lane, may take.
    pub fn interval(&self, code: Code) -> u32 {
        match code {
            Code::Div => self.div_interval,
            Code::Sqrt => self.sqrt_interval,
            _ => 1,
        }
    }

    /// Cycles from an issue to that of an operation that reads the result.
    pub fn distance(&self, code: Code) -> u32 {
        self.latency(code) + self.read + self.write
    }

    /// The longest distance.
    pub fn longest(&self) -> u32 {
        Code::ALL.iter().map(|&code| self.distance(code)).max().unwrap_or(0)
    }
}

/// The value of `localparam int NAME = N;`.
fn parameter(text: &str, name: &str) -> u32 {
    let value = text.lines().find_map(|line| {
        let (left, right) = line.trim().strip_prefix("localparam int ")?.split_once('=')?;
        (left.trim() == name).then(|| right.split(';').next().unwrap_or("").trim().parse().ok())?
    });
    value.unwrap_or_else(|| panic!("the RTL's parameter files have no number `{name}`"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_is_found_and_positive() {
        for precision in [Precision::F64, Precision::F32] {
            let t = Timing::of(precision);
            let units = [t.add, t.mul, t.div, t.sqrt, t.div_interval, t.sqrt_interval];
            let all = [t.simple, t.read, t.write, t.startup, t.decode, t.queue_depth];
            assert!(units.iter().chain(&all).all(|&cycles| cycles >= 1), "{t:?}");
        }
    }

    #[test]
    fn parameters_are_read_by_their_whole_name() {
        let text =
            "// localparam int A = 9;\nlocalparam int AB = 1;\n  localparam int A = 23;  // note = 5;\n";
        assert_eq!(parameter(text, "A"), 23);
    }

    #[test]
    fn a_misread_table_differs_in_one_unit() {
        let t = *Timing::of(Precision::F32);
        let wrong = t.misread("add", -1).unwrap();
        assert_eq!(wrong, Timing { add: t.add - 1, ..t });
        assert_eq!(wrong.misread("add", 1), Ok(t));
        assert_eq!(t.misread("sqrt", 2).unwrap().sqrt, t.sqrt + 2);
        for (unit, by) in [("simple", -2), ("div", 100), ("mul", i32::MIN), ("lanes", 1)] {
            assert!(matches!(t.misread(unit, by), Err(Error::Configuration { .. })), "{unit} {by}");
        }
    }

    #[test]
    fn a_multiply_add_is_a_product_and_then_a_sum() {
        let t = Timing::of(Precision::F64);
        assert_eq!(t.latency(Code::SubMul), t.latency(Code::Mul) + t.latency(Code::Sub));
        assert_eq!(t.distance(Code::Move), t.simple + t.read + t.write);
    }
}

//! A datapath without numbers: it counts the operations of a kernel and measures the longest
//! chain of dependent ones.
//!
//! Counting works because kernels never look at data: the operations they ask for are the same
//! for every value, so they may be asked for with no value at all.

use super::Real;
use core::cell::Cell;
use core::ops::{Add, Div, Mul, Neg, Sub};

/// How many of each operation ran. `add_mul` and `sub_mul` are single lane operations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(missing_docs)] // the names are the operations
pub struct OperationCounts {
    pub neg: u64,
    pub abs: u64,
    pub mul: u64,
    pub add: u64,
    pub sub: u64,
    pub add_mul: u64,
    pub sub_mul: u64,
    pub div: u64,
    pub sqrt: u64,
    pub min: u64,
    pub max: u64,
    pub compare: u64,
    pub and: u64,
    pub select: u64,
}

/// Latency of each operation in cycles, for the critical path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub struct Latency {
    pub neg: u32,
    pub abs: u32,
    pub mul: u32,
    pub add: u32,
    pub sub: u32,
    pub add_mul: u32,
    pub sub_mul: u32,
    pub div: u32,
    pub sqrt: u32,
    pub min: u32,
    pub max: u32,
    pub compare: u32,
    pub and: u32,
    pub select: u32,
}

impl Latency {
    /// Every operation takes one cycle: the critical path is then a number of operations.
    pub const UNIT: Self = Self {
        neg: 1,
        abs: 1,
        mul: 1,
        add: 1,
        sub: 1,
        add_mul: 1,
        sub_mul: 1,
        div: 1,
        sqrt: 1,
        min: 1,
        max: 1,
        compare: 1,
        and: 1,
        select: 1,
    };
}

/// What [`count`] measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tally {
    /// Operations by kind.
    pub operations: OperationCounts,
    /// Cycles of the longest chain of dependent operations; inputs are ready at cycle 0.
    pub critical_path: u64,
}

#[derive(Clone, Copy)]
struct Meter {
    counts: OperationCounts,
    latency: Latency,
    longest: u64,
}

thread_local! {
    static METER: Cell<Option<Meter>> = const { Cell::new(None) };
}

/// Run `kernel` and report the operations on [`Counted`] scalars made on this thread meanwhile.
pub fn count(latency: Latency, kernel: impl FnOnce()) -> Tally {
    let meter = Meter { counts: OperationCounts::default(), latency, longest: 0 };
    let outer = METER.replace(Some(meter));
    kernel();
    let meter = METER.replace(outer).unwrap_or(meter);
    Tally { operations: meter.counts, critical_path: meter.longest }
}

/// A scalar that is only the cycle at which its value would be ready.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counted {
    ready: u64,
}

/// A comparison outcome that is only the cycle at which it would be known.
#[derive(Clone, Copy)]
pub struct CountedMask {
    ready: u64,
}

fn record(ready: u64, tick: impl FnOnce(&mut OperationCounts, &Latency) -> u32) -> u64 {
    METER.with(|cell| {
        let Some(mut meter) = cell.get() else {
            return ready;
        };
        let done = ready + u64::from(tick(&mut meter.counts, &meter.latency));
        meter.longest = meter.longest.max(done);
        cell.set(Some(meter));
        done
    })
}

macro_rules! operation {
    ($ready:expr, $name:ident) => {
        record($ready, |counts, latency| {
            counts.$name += 1;
            latency.$name
        })
    };
}

macro_rules! binary {
    ($trait:ident, $method:ident) => {
        impl $trait for Counted {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                Self { ready: operation!(self.ready.max(other.ready), $method) }
            }
        }
    };
}

binary!(Add, add);
binary!(Sub, sub);
binary!(Mul, mul);
binary!(Div, div);

impl Neg for Counted {
    type Output = Self;
    fn neg(self) -> Self {
        Self { ready: operation!(self.ready, neg) }
    }
}

impl Real for Counted {
    type Mask = CountedMask;

    fn constant(_: f64) -> Self {
        Self { ready: 0 }
    }
    fn sqrt(self) -> Self {
        Self { ready: operation!(self.ready, sqrt) }
    }
    fn abs(self) -> Self {
        Self { ready: operation!(self.ready, abs) }
    }
    fn lt(self, other: Self) -> CountedMask {
        CountedMask { ready: operation!(self.ready.max(other.ready), compare) }
    }
    fn and(a: CountedMask, b: CountedMask) -> CountedMask {
        CountedMask { ready: operation!(a.ready.max(b.ready), and) }
    }
    fn select(mask: CountedMask, yes: Self, no: Self) -> Self {
        Self { ready: operation!(mask.ready.max(yes.ready).max(no.ready), select) }
    }
    fn add_mul(self, a: Self, b: Self) -> Self {
        Self { ready: operation!(self.ready.max(a.ready).max(b.ready), add_mul) }
    }
    fn sub_mul(self, a: Self, b: Self) -> Self {
        Self { ready: operation!(self.ready.max(a.ready).max(b.ready), sub_mul) }
    }
    fn max(self, other: Self) -> Self {
        Self { ready: operation!(self.ready.max(other.ready), max) }
    }
    fn min(self, other: Self) -> Self {
        Self { ready: operation!(self.ready.max(other.ready), min) }
    }
}

//! A datapath without numbers: it counts the operations of a kernel and measures the longest
//! chain of dependent ones.
//!
//! Counting works because kernels never look at data: the operations they ask for are the same
//! for every value, so they may be asked for with no value at all.

use super::scalar::Real;
use core::cell::Cell;
use core::ops::{Add, Div, Mul, Neg, Sub};

macro_rules! for_each_operation {
    ($($name:ident)*) => {
        /// Number of runs of each operation. `add_mul` and `sub_mul` are single lane operations.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        #[allow(missing_docs)] // the names are the operations
        pub struct OperationCounts { $(pub $name: u64,)* }

        /// Latency of each operation in cycles, for the critical path.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[allow(missing_docs)]
        pub struct Latency { $(pub $name: u32,)* }

        impl Latency {
            /// Every operation takes one cycle: the critical path is then a number of operations.
            pub const UNIT: Self = Self { $($name: 1,)* };
        }
    };
}

for_each_operation! { neg abs mul add sub add_mul sub_mul div sqrt min max compare and select }

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
    const TILE_COLS: usize = 4;

    fn vectorize<W: pulp::WithSimd>(work: W) -> W::Output {
        work.with_simd(pulp::Scalar)
    }

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

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(kernel: impl FnOnce()) -> Tally {
        count(Latency::UNIT, kernel)
    }

    #[test]
    fn every_operation_is_counted_as_itself() {
        let (a, b) = (Counted::constant(1.0), Counted::constant(2.0));
        let tally = unit(|| {
            let _ = (-a, a.abs(), a * b, a + b, a - b, a.add_mul(a, b), a.sub_mul(a, b));
            let _ = (a / b, a.sqrt(), Real::min(a, b), Real::max(a, b));
            let (less, more) = (a.lt(b), b.lt(a));
            let _ = Counted::select(Counted::and(less, more), a, b);
        });
        let each_once = OperationCounts {
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
            compare: 2,
            and: 1,
            select: 1,
        };
        assert_eq!(tally.operations, each_once);
        assert_eq!(tally.critical_path, 3, "compare, and, select");
    }

    #[test]
    fn a_chain_is_as_long_as_its_operations() {
        let tally = unit(|| {
            (0..100).fold(Counted::zero(), |sum, _| sum + Counted::one());
        });
        assert_eq!((tally.operations.add, tally.critical_path), (100, 100));
    }

    #[test]
    fn independent_operations_are_as_long_as_the_longest() {
        let latency = Latency { mul: 5, div: 20, ..Latency::UNIT };
        let tally = count(latency, || {
            let one = Counted::one();
            for _ in 0..100 {
                let _ = one * one;
            }
            let _ = one / one;
        });
        assert_eq!((tally.operations.mul, tally.operations.div, tally.critical_path), (100, 1, 20));
    }

    #[test]
    fn a_path_takes_the_later_operand_and_the_operations_latency() {
        // (a·b) is ready at 5, its root at 5 + 9; adding a fresh entry to it ends at 14 + 3.
        let latency = Latency { mul: 5, sqrt: 9, add: 3, ..Latency::UNIT };
        let (a, b) = (Counted::one(), Counted::one());
        let tally = count(latency, || {
            let _ = a + (a * b).sqrt();
        });
        assert_eq!(tally.critical_path, 17);
    }

    #[test]
    fn a_tree_is_shorter_than_a_chain() {
        let entries = [Counted::one(); 64];
        let tally = unit(|| {
            crate::kernels::reduce::dot(&entries, &entries);
        });
        // Eight accumulators take eight terms each; the tree joins them in three levels.
        assert_eq!((tally.operations.mul, tally.operations.add_mul, tally.operations.add), (8, 56, 7));
        assert_eq!(tally.critical_path, 8 + 3);
    }

    #[test]
    fn counting_nests_and_ends() {
        let a = Counted::one();
        let mut inner = None;
        let outer = unit(|| {
            let _ = a + a;
            inner = Some(unit(|| {
                let _ = a * a;
            }));
            let _ = a + a;
        });
        let _ = a / a;
        assert_eq!((outer.operations.add, outer.operations.mul, outer.operations.div), (2, 0, 0));
        assert_eq!(inner.map(|tally| tally.operations.mul), Some(1));
    }
}

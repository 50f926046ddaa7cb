//! Scalars the kernels are generic over. **The datapath is a type**: one kernel source runs on
//! `f64`, on `f32`, on [`Lanes`], eight problems at once, on [`Counted`], which carries no number and counts the operations,
//! and on `Taped`, which records them.
//!
//! The bits of a result are defined by the operations a kernel asks for and nothing else: every
//! operation below rounds once, `c ± a·b` rounds twice, and nothing here is ever fused.

mod counted;
mod ieee;
mod lanes;
mod narrow;
mod taped;
pub mod tiles;

pub use counted::{count, Counted, Latency, OperationCounts, Tally};
pub use lanes::{EightLanes, Lanes};
pub use narrow::Reduced;
pub(crate) use taped::{record, Taped};
pub use taped::{Opcode, Operation, Value};

use core::ops::{Add, Div, Mul, Neg, Sub};

/// A scalar of the datapath.
///
/// Comparisons yield an opaque [`Real::Mask`] which only [`Real::select`] and [`Real::and`]
/// consume, so a kernel cannot branch on data: the compiler enforces it.
pub trait Real:
    Copy
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Outcome of a comparison.
    type Mask: Copy;

    /// Rows and columns of the tiles that kernels keep at hand: four where they fit, else two. It changes
    /// no bit.
    const TILE: usize;
    /// Whether eight rows fit, too.
    const TALL: bool = false;
    /// Whether two dots with a vector in common are made abreast: their sums fit, and that vector is far. It changes no
    /// bit.
    const ABREAST: bool = false;

    /// Run `work`, compiled for the instruction set that these words want.
    fn vectorize<W: pulp::WithSimd>(work: W) -> W::Output;

    /// A literal or an input word.
    fn constant(value: f64) -> Self;
    /// Square root, correctly rounded.
    fn sqrt(self) -> Self;
    /// Magnitude: clears the sign bit.
    fn abs(self) -> Self;
    /// `self < other`; false when either is NaN.
    fn lt(self, other: Self) -> Self::Mask;
    /// Both masks.
    fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// `if mask { yes } else { no }`, without a branch.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// `self + a·b`, two roundings.
    #[inline(always)]
    fn add_mul(self, a: Self, b: Self) -> Self {
        self + a * b
    }

    /// `self − a·b`, two roundings.
    #[inline(always)]
    fn sub_mul(self, a: Self, b: Self) -> Self {
        self - a * b
    }

    /// As [`tiles::subtract`], bit for bit; a datapath may have a quicker way.
    #[inline(always)]
    fn subtract_products<const M: usize, const N: usize, const LOWER: bool>(
        words: &mut [[Self; M]; N],
        factors: tiles::Factors<Self>,
    ) {
        tiles::subtract::<Self, M, N, LOWER>(words, factors);
    }

    /// As [`tiles::accumulate`], bit for bit; a datapath may have a quicker way.
    #[inline(always)]
    fn accumulate<const R: usize>(sums: &mut [[Self; R]; 8], a: &[[Self; 8]], x: &[[[Self; R]; 8]]) {
        tiles::accumulate(sums, a, x);
    }

    /// As [`tiles::subtract_multiple`], bit for bit; a datapath may have a quicker way.
    #[inline(always)]
    fn subtract_multiple<const R: usize>(words: &mut [[Self; R]], by: &[Self], x: [Self; R]) {
        tiles::subtract_multiple(words, by, x);
    }

    /// `select(self < other, other, self)`; a NaN in `other` is dropped.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(self.lt(other), other, self)
    }

    /// `select(other < self, other, self)`; a NaN in `other` is dropped.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(other.lt(self), other, self)
    }

    /// The additive identity.
    #[inline(always)]
    fn zero() -> Self {
        Self::constant(0.0)
    }

    /// The multiplicative identity.
    #[inline(always)]
    fn one() -> Self {
        Self::constant(1.0)
    }
}

/// Arithmetic that is compiled as a function of its own, by [`apart`].
pub(crate) trait Apart {
    /// Do it; `#[inline(always)]`, as a kernel.
    fn run(self);
}

/// Do what a kernel does rarely apart from it, for the same instruction set: loops of one function share its registers.
#[inline(always)]
pub(crate) fn apart<T: Real>(work: impl Apart) {
    T::vectorize(Dispatched(work));
}

struct Dispatched<W>(W);

impl<W: Apart> pulp::WithSimd for Dispatched<W> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        self.0.run();
    }
}

/// A scalar whose value control flow may look at. Only PS code asks for it; recording
/// datapaths do not implement it.
pub trait Decide: Real {
    /// Problems side by side in one word.
    const LANES: usize;
    /// The value of one of them, widened to double precision exactly.
    fn lane(&self, lane: usize) -> f64;
    /// Replace the value of one of them.
    fn set_lane(&mut self, lane: usize, value: f64);
    /// The value of the first.
    #[inline(always)]
    fn value(&self) -> f64 {
        self.lane(0)
    }
    /// Unit roundoff times two: the spacing of numbers at one.
    fn epsilon() -> f64;
}

//! The scalar of a datapath as a trait, and the plain loops over tiles of it.

use super::tiles::Factors;
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

    /// Columns of a register tile: four where they fit, else two. It changes no bit.
    const TILE_COLS: usize;
    /// Rows of its tallest tile.
    const TILE_ROWS: usize = Self::TILE_COLS;
    /// Register blocking over two right-hand sides: two dots share the loads of a common vector. It changes no
    /// bit.
    const RHS_BLOCK: bool = false;

    /// Run `work`, compiled for the instruction set of these scalars.
    fn vectorize<W: pulp::WithSimd>(work: W) -> W::Output;

    /// A literal or an input value.
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

    /// As `subtract` below, bit for bit; a datapath may have a quicker way.
    #[inline(always)]
    fn subtract_products<const M: usize, const N: usize, const LOWER: bool>(
        entries: &mut [[Self; M]; N],
        factors: Factors<Self>,
    ) {
        subtract::<Self, M, N, LOWER>(entries, factors);
    }

    /// As `accumulate` below, bit for bit; a datapath may have a quicker way.
    #[inline(always)]
    fn accumulate<const R: usize>(sums: &mut [[Self; R]; 8], a: &[[Self; 8]], x: &[[[Self; R]; 8]]) {
        accumulate(sums, a, x);
    }

    /// As `subtract_multiple` below, bit for bit; a datapath may have a quicker way.
    #[inline(always)]
    fn subtract_multiple<const R: usize>(entries: &mut [[Self; R]], by: &[Self], x: [Self; R]) {
        subtract_multiple(entries, by, x);
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

    /// Whether a flag (0 or 1) is known to be down everywhere, so that selects by it change nothing. A recording never knows.
    #[inline(always)]
    fn is_down(_flag: Self) -> bool {
        false
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

/// A scalar whose value control flow may read. Only PS code asks for it; recording
/// datapaths do not implement it.
pub trait Decide: Real {
    /// Problems side by side in one scalar.
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

/// `entries[n][m] −= Σ_k l_k[m]·y_k[n]`, the k in order, each product rounded. With `LOWER`, only the entries of
/// m ≥ n are asked for, and the others come out as anything.
#[inline(always)]
pub fn subtract<T: Real, const M: usize, const N: usize, const LOWER: bool>(
    entries: &mut [[T; M]; N],
    factors: Factors<T>,
) {
    factors.pairs::<M, N>(
        #[inline(always)]
        |l, y| {
            for n in 0..N {
                let mut column = entries[n];
                for m in if LOWER { n } else { 0 }..M {
                    column[m] = column[m].sub_mul(l[m], y[n]);
                }
                entries[n] = column;
            }
        },
    );
}

/// `sums[k][r] += a[k]·x[k][r]`, of each eight in turn.
#[inline(always)]
pub fn accumulate<T: Real, const R: usize>(sums: &mut [[T; R]; 8], a: &[[T; 8]], x: &[[[T; R]; 8]]) {
    for (a, x) in a.iter().zip(x) {
        for k in 0..8 {
            for r in 0..R {
                sums[k][r] = sums[k][r].add_mul(a[k], x[k][r]);
            }
        }
    }
}

/// `entries[k][r] −= by[k]·x[r]`.
#[inline(always)]
pub fn subtract_multiple<T: Real, const R: usize>(entries: &mut [[T; R]], by: &[T], x: [T; R]) {
    for (entries, &by) in entries.iter_mut().zip(by) {
        for r in 0..R {
            entries[r] = entries[r].sub_mul(by, x[r]);
        }
    }
}

//! N problems of one sparsity pattern side by side: every operation acts on N words.
//!
//! The compiler turns the loops below into vector instructions once they are inlined into the SIMD
//! dispatch. No lane ever looks at another, so each has the bits of its own single solve.

use super::{Decide, Real};
use core::ops::{Add, Div, Mul, Neg, Sub};

/// One word of each of `N` problems.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct Lanes<const N: usize>([f64; N]);

/// One comparison outcome of each of `N` problems.
#[derive(Clone, Copy)]
pub struct LanesMask<const N: usize>([bool; N]);

macro_rules! lanewise {
    ($trait:ident, $method:ident, $op:tt) => {
        impl<const N: usize> $trait for Lanes<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: Self) -> Self {
                for i in 0..N {
                    self.0[i] $op other.0[i];
                }
                self
            }
        }
    };
}

lanewise!(Add, add, +=);
lanewise!(Sub, sub, -=);
lanewise!(Mul, mul, *=);
lanewise!(Div, div, /=);

impl<const N: usize> Neg for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(mut self) -> Self {
        for i in 0..N {
            self.0[i] = -self.0[i];
        }
        self
    }
}

impl<const N: usize> Real for Lanes<N> {
    type Mask = LanesMask<N>;

    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self([value; N])
    }
    #[inline(always)]
    fn sqrt(mut self) -> Self {
        for i in 0..N {
            self.0[i] = self.0[i].sqrt();
        }
        self
    }
    #[inline(always)]
    fn abs(mut self) -> Self {
        for i in 0..N {
            self.0[i] = self.0[i].abs();
        }
        self
    }
    #[inline(always)]
    fn lt(self, other: Self) -> LanesMask<N> {
        LanesMask(core::array::from_fn(|i| self.0[i] < other.0[i]))
    }
    #[inline(always)]
    fn and(mut a: LanesMask<N>, b: LanesMask<N>) -> LanesMask<N> {
        for i in 0..N {
            a.0[i] &= b.0[i];
        }
        a
    }
    #[inline(always)]
    fn select(mask: LanesMask<N>, mut yes: Self, no: Self) -> Self {
        for i in 0..N {
            yes.0[i] = if mask.0[i] { yes.0[i] } else { no.0[i] };
        }
        yes
    }
    #[inline(always)]
    fn sub_mul(mut self, a: Self, b: Self) -> Self {
        for i in 0..N {
            self.0[i] -= a.0[i] * b.0[i];
        }
        self
    }
    #[inline(always)]
    fn add_mul(mut self, a: Self, b: Self) -> Self {
        for i in 0..N {
            self.0[i] += a.0[i] * b.0[i];
        }
        self
    }
}

impl<const N: usize> Decide for Lanes<N> {
    const LANES: usize = N;

    #[inline(always)]
    fn lane(self, lane: usize) -> f64 {
        self.0[lane]
    }
    #[inline(always)]
    fn set_lane(&mut self, lane: usize, value: f64) {
        self.0[lane] = value;
    }
    fn epsilon() -> f64 {
        f64::EPSILON
    }
}

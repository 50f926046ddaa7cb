//! SplitMix64 of fewer significant bits: what a narrower multiplier and adder would compute.

use super::scalar::{Decide, Real};
use core::ops::{Add, Div, Mul, Neg, Sub};

/// A number of `P` significant bits, 2 ≤ P ≤ 25, with the exponents of binary64.
///
/// Each operation is computed in binary64 and rounded to `P` bits, to nearest and ties to even. With
/// P ≤ 25, twice the bits and two more fit into binary64, so the second rounding does no harm: the
/// result is the correctly rounded one (Figueroa 1995). At P = 24 it is binary32's, as long as that has
/// the exponent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reduced<const P: u32>(f64);

impl<const P: u32> Reduced<P> {
    const DROPPED: u32 = {
        assert!(P >= 2 && P <= 25, "significant bits must be 2 to 25");
        53 - P
    };

    #[inline(always)]
    fn round(value: f64) -> Self {
        let bits = value.to_bits();
        let odd = (bits >> Self::DROPPED) & 1;
        let half = (1 << (Self::DROPPED - 1)) - 1;
        let rounded = (bits + half + odd) & !((1 << Self::DROPPED) - 1);
        // Infinities and NaN have nothing to round.
        Self(if value.is_finite() { f64::from_bits(rounded) } else { value })
    }
}

macro_rules! operator {
    ($($trait:ident $name:ident $op:tt)*) => {$(
        impl<const P: u32> $trait for Reduced<P> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self::round(self.0 $op other.0)
            }
        }
    )*};
}
operator!(Add add + Sub sub - Mul mul * Div div /);

impl<const P: u32> Neg for Reduced<P> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl<const P: u32> Real for Reduced<P> {
    type Mask = <f64 as Real>::Mask;
    const TILE_COLS: usize = 2;

    // Rounding by hand is what takes the time: one copy of each kernel, for any instruction set.
    fn vectorize<W: pulp::WithSimd>(work: W) -> W::Output {
        work.with_simd(pulp::Scalar)
    }

    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self::round(value)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::round(self.0.sqrt())
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Self::Mask {
        self.0.lt(other.0)
    }
    #[inline(always)]
    fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        <f64 as Real>::and(a, b)
    }
    #[inline(always)]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
        Self(<f64 as Real>::select(mask, yes.0, no.0))
    }
}

impl<const P: u32> Decide for Reduced<P> {
    const LANES: usize = 1;

    #[inline(always)]
    fn lane(&self, _: usize) -> f64 {
        self.0
    }
    #[inline(always)]
    fn set_lane(&mut self, _: usize, value: f64) {
        *self = Self::round(value);
    }
    fn epsilon() -> f64 {
        f64::EPSILON * (1u64 << Self::DROPPED) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn same(a: Reduced<24>, b: f32) -> bool {
        a.0.to_bits() == f64::from(b).to_bits() || (a.0.is_nan() && b.is_nan())
    }

    proptest! {
        #[test]
        fn twenty_four_bits_are_binary32(a in -1e9f32..1e9, b in -1e9f32..1e9) {
            let (x, y) = (Reduced::<24>::constant(f64::from(a)), Reduced::<24>::constant(f64::from(b)));
            prop_assume!(a.abs() > 1e-6 && b.abs() > 1e-6);
            prop_assert!(same(x + y, a + b) && same(x - y, a - b));
            prop_assert!(same(x * y, a * b) && same(x / y, a / b));
            prop_assert!(same(x.abs().sqrt(), a.abs().sqrt()));
            prop_assert!(same(x.add_mul(y, y), a + b * b));
        }

        #[test]
        fn rounding_is_to_nearest_and_idempotent(value in proptest::num::f64::NORMAL) {
            let rounded = Reduced::<12>::constant(value).0;
            prop_assert_eq!(Reduced::<12>::constant(rounded).0.to_bits(), rounded.to_bits());
            if rounded.is_finite() {
                prop_assert!(((rounded - value) / value).abs() <= 0.5 * Reduced::<12>::epsilon());
            }
        }
    }

    #[test]
    fn ties_go_to_even_and_overflow_to_infinity() {
        let round = |value: f64| Reduced::<2>::constant(value).0;
        assert_eq!([1.25, 1.75, 2.5, 3.5, 5.0, 7.0].map(round), [1.0, 2.0, 2.0, 4.0, 4.0, 8.0]);
        assert_eq!(round(f64::MAX), f64::INFINITY);
        assert!(round(f64::NAN).is_nan());
        assert_eq!(round(-0.0).to_bits(), (-0.0f64).to_bits());
        assert_eq!(Reduced::<24>::epsilon(), f64::from(f32::EPSILON));
    }
}

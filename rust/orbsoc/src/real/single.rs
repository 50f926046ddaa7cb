//! IEEE binary64 and binary32 as datapaths.

use super::{Decide, Real};

/// A comparison's outcome for one scalar; opaque outside this module.
#[derive(Clone, Copy)]
pub struct Bit(bool);

macro_rules! ieee {
    ($t:ty) => {
        impl Real for $t {
            type Mask = Bit;
            // A vector of them counts as one.
            const TILE: usize = 4;

            #[inline(always)]
            fn vectorize<W: pulp::WithSimd>(work: W) -> W::Output {
                pulp::Arch::new().dispatch(work)
            }

            #[inline(always)]
            #[allow(clippy::cast_possible_truncation)] // binary32 input words are rounded once, here
            fn constant(value: f64) -> Self {
                value as $t
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                <$t>::sqrt(self)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                <$t>::abs(self)
            }
            #[inline(always)]
            fn lt(self, other: Self) -> Bit {
                Bit(self < other)
            }
            #[inline(always)]
            fn and(a: Bit, b: Bit) -> Bit {
                Bit(a.0 & b.0)
            }
            #[inline(always)]
            fn select(mask: Bit, yes: Self, no: Self) -> Self {
                if mask.0 {
                    yes
                } else {
                    no
                }
            }
        }

        impl Decide for $t {
            const LANES: usize = 1;

            #[inline(always)]
            fn lane(self, _: usize) -> f64 {
                f64::from(self)
            }
            #[inline(always)]
            #[allow(clippy::cast_possible_truncation)] // what is set came from a word of this type
            fn set_lane(&mut self, _: usize, value: f64) {
                *self = value as $t;
            }
            fn epsilon() -> f64 {
                f64::from(<$t>::EPSILON)
            }
        }
    };
}

ieee!(f64);
ieee!(f32);

#[cfg(test)]
mod tests {
    use super::*;

    fn contract<T: Decide>() {
        let c = T::constant;
        let value = |x: T| x.value();
        assert_eq!(value(c(2.0).max(c(3.0))), 3.0);
        assert_eq!(value(c(2.0).min(c(3.0))), 2.0);
        assert_eq!(value(T::select(c(1.0).lt(c(2.0)), c(5.0), c(6.0))), 5.0);
        assert_eq!(value(T::select(c(2.0).lt(c(2.0)), c(5.0), c(6.0))), 6.0);
        let (yes, no) = (c(0.0).lt(c(1.0)), c(1.0).lt(c(0.0)));
        let both = |a, b| value(T::select(T::and(a, b), T::one(), T::zero()));
        assert_eq!([both(yes, yes), both(yes, no), both(no, yes), both(no, no)], [1.0, 0.0, 0.0, 0.0]);
        // Sign operations act on the bit, zero's included.
        assert_eq!(value(c(-0.0).abs()).to_bits(), 0.0f64.to_bits());
        assert_eq!(value(-c(0.0)).to_bits(), (-0.0f64).to_bits());
    }

    #[test]
    fn both_precisions_keep_the_contract() {
        contract::<f64>();
        contract::<f32>();
        assert_eq!((f64::epsilon(), f32::epsilon()), (2f64.powi(-52), 2f64.powi(-23)));
    }

    #[test]
    fn max_and_min_drop_a_nan_on_the_right_and_keep_one_on_the_left() {
        let (nan, one) = (f64::NAN, 1.0);
        assert_eq!((Real::max(one, nan), Real::min(one, nan)), (1.0, 1.0));
        assert!(Real::max(nan, one).is_nan() && Real::min(nan, one).is_nan());
    }

    #[test]
    fn equal_operands_yield_the_left_one() {
        let (plus, minus) = (0.0f64, -0.0f64);
        assert_eq!(Real::max(plus, minus).to_bits(), plus.to_bits());
        assert_eq!(Real::max(minus, plus).to_bits(), minus.to_bits());
    }

    #[test]
    fn products_are_added_with_two_roundings() {
        // (1 + 2⁻³⁰)² = 1 + 2⁻²⁹ + 2⁻⁶⁰: the last term is lost before the addition, not after it.
        let a = 1.0 + 2f64.powi(-30);
        let square = 1.0 + 2f64.powi(-29);
        assert_eq!((-square).add_mul(a, a), 0.0);
        assert_eq!(square.sub_mul(a, a), 0.0);
        assert_eq!(a.mul_add(a, -square), 2f64.powi(-60));
    }

    #[test]
    fn single_precision_rounds_input_words_once() {
        assert_eq!(<f32 as Real>::constant(0.1), 0.1f32);
        assert_eq!(<f32 as Real>::constant(1e300), f32::INFINITY);
        assert_eq!(<f32 as Real>::constant(1e-30), 1e-30f32);
    }
}

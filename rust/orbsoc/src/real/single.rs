//! IEEE binary64 and binary32 as datapaths.

use super::{Decide, Real};

/// A comparison's outcome for one scalar; opaque outside this module.
#[derive(Clone, Copy)]
pub struct Bit(bool);

macro_rules! ieee {
    ($t:ty) => {
        impl Real for $t {
            type Mask = Bit;

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
            #[inline(always)]
            fn value(self) -> f64 {
                f64::from(self)
            }
            fn epsilon() -> f64 {
                f64::from(<$t>::EPSILON)
            }
        }
    };
}

ieee!(f64);
ieee!(f32);

//! Pivots: their regularisation by known signs, and division by them.

use crate::real::Real;

/// Regularisation of the pivots, whose signs are known from the pattern.
#[derive(Clone, Copy)]
pub struct Regularization<T> {
    /// Added to diagonal entries of positive pivots …
    pub shift_up: T,
    /// … and subtracted from those of negative ones.
    pub shift_down: T,
    /// Pivots below this, in the direction of their sign, …
    pub floor: T,
    /// … become this, or [`REPLACEMENT_FACTOR`] times as large as they were, whichever is more.
    pub replacement: T,
}

/// A pivot of the wrong sign is the rounding error of the terms that cancelled. A replacement that is smaller than this
/// error would make the factor explode; one that is larger only damps a direction that is unknown anyway.
const REPLACEMENT_FACTOR: f64 = 5.0;

/// The pivot with static and dynamic regularisation, by its known sign. What replaces it comes from the pivot before its
/// shift, so that product and maximum run beside shift and comparison.
#[inline(always)]
pub fn regularized<T: Real>(pivot: T, positive: bool, by: Regularization<T>) -> T {
    let enlarged = T::constant(-REPLACEMENT_FACTOR) * pivot;
    if positive {
        let shifted = pivot + by.shift_up;
        T::select(shifted.lt(by.floor), enlarged.max(by.replacement), shifted)
    } else {
        let shifted = pivot - by.shift_down;
        T::select((-by.floor).lt(shifted), enlarged.min(-by.replacement), shifted)
    }
}

/// The column as it is into `y`, and divided by its pivot.
#[inline(always)]
pub fn divide<T: Real>(column: &mut [T], y: &mut [T], inverse: T) {
    for (l, y) in column.iter_mut().zip(y) {
        *y = *l;
        *l = *y * inverse;
    }
}

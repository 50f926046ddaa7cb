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
    /// … become this.
    pub replacement: T,
}

/// The pivot with static and dynamic regularisation, by its known sign.
#[inline(always)]
pub fn regularized<T: Real>(pivot: T, positive: bool, by: Regularization<T>) -> T {
    if positive {
        let pivot = pivot + by.shift_up;
        T::select(pivot.lt(by.floor), by.replacement, pivot)
    } else {
        let (pivot, ceiling) = (pivot - by.shift_down, -by.floor);
        T::select(ceiling.lt(pivot), -by.replacement, pivot)
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

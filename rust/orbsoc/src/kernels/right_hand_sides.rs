//! Right-hand sides of the KKT system, in permuted order, and its solutions back in natural order.
//!
//! `position` holds the permuted position of each natural unknown (x, y, z), `n` of them x; q = (c, b, h).

use crate::real::Real;

/// Bounds beyond this, in scaled data, count as this in the starting point of a quadratic cost.
const START_BOUND: f64 = 100.0;

/// h of an R₊ row, and what a starting point leaves out of it: a bound that is far away must not attract x, and must not
/// make the dual variables as large as it is.
#[inline(always)]
fn bounded<T: Real>(h: T) -> (T, T) {
    let bounded = h.min(T::constant(START_BOUND));
    (bounded, h - bounded)
}

/// For the starting point, two sides. With a `linear` cost, x and s come from (0, b, h) and y and z from (−c, 0, 0);
/// with a quadratic one all of them come from (−c, b, h), where the R₊ rows, `orthant` among (x, y, z), are bounded.
#[inline(always)]
pub fn starting<T: Real>(
    position: &[u32],
    n: usize,
    orthant: core::ops::Range<usize>,
    linear: bool,
    q: &[T],
    rhs: &mut [[T; 2]],
) {
    let zero = T::zero();
    rhs.fill([zero, zero]);
    for (i, (&to, &q)) in position.iter().zip(q).enumerate() {
        let q = if i < n { -q } else { q };
        rhs[to as usize] = match (linear, i < n) {
            (false, _) if orthant.contains(&i) => [bounded(q).0; 2],
            (false, _) => [q, q],
            (true, true) => [zero, q],
            (true, false) => [q, zero],
        };
    }
}

/// s of a starting point with a quadratic cost: what its bounded rows leave out is added.
#[inline(always)]
pub fn unbounded<T: Real>(h: &[T], slack: &mut [T]) {
    for (s, &h) in slack.iter_mut().zip(h) {
        *s = *s + bounded(h).1;
    }
}

/// (−c, b, h) and the predictor's, minus the residual, with s added in the rows of z.
#[inline(always)]
pub fn predictor<T: Real>(
    (position, expansions): (&[u32], &[u32]),
    n: usize,
    q: &[T],
    residual: &[T],
    slack: &[T],
    rhs: &mut [[T; 2]],
) {
    // Rows of the sparse expansions; all others follow.
    for &at in expansions {
        rhs[at as usize] = [T::zero(), T::zero()];
    }
    let rows = position.len() - slack.len();
    let entries = position.iter().zip(q).zip(residual);
    for ((&to, &q), &residual) in entries.clone().take(n) {
        rhs[to as usize] = [-q, -residual];
    }
    for ((&to, &q), &residual) in entries.clone().take(rows).skip(n) {
        rhs[to as usize] = [q, -residual];
    }
    for (((&to, &q), &residual), &s) in entries.skip(rows).zip(slack) {
        rhs[to as usize] = [q, s - residual];
    }
}

/// The corrector's: minus the damped residual, and `lifted` = W(λ∖d) added in the rows of z.
#[inline(always)]
pub fn corrector<T: Real>(
    (position, expansions): (&[u32], &[u32]),
    damping: T,
    residual: &[T],
    lifted: &[T],
    rhs: &mut [T],
) {
    for &at in expansions {
        rhs[at as usize] = T::zero();
    }
    let rows = position.len() - lifted.len();
    for (&to, &residual) in position[..rows].iter().zip(residual) {
        rhs[to as usize] = -(damping * residual);
    }
    for ((&to, &residual), &g) in position[rows..].iter().zip(&residual[rows..]).zip(lifted) {
        rhs[to as usize] = g.sub_mul(damping, residual);
    }
}

/// (−c, b, h − 2s): Newton's equations from a central pair, for x, y and z themselves, with
/// s + ds = 2s − W²z⁺ because W²z = s.
#[inline(always)]
pub fn newton_start<T: Real>(position: &[u32], n: usize, q: &[T], slack: &[T], rhs: &mut [T]) {
    rhs.fill(T::zero());
    for (i, (&to, &q)) in position.iter().zip(q).enumerate() {
        rhs[to as usize] = if i < n { -q } else { q };
    }
    for (&to, &slack) in position[position.len() - slack.len()..].iter().zip(slack) {
        let entry = &mut rhs[to as usize];
        *entry = *entry - (slack + slack);
    }
}

/// Unknowns in natural order from column `r` of the permuted solutions; expansion rows are left behind.
#[inline(always)]
pub fn unload<T: Real, const R: usize>(position: &[u32], permuted: &[[T; R]], r: usize, natural: &mut [T]) {
    for (entry, &from) in natural.iter_mut().zip(position) {
        *entry = permuted[from as usize][r];
    }
}

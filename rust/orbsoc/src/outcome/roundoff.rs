//! Rounding-error bounds: where the terms of a sum are far larger than the sum, another order of addition, as in an
//! independent verification, gives another sum.

use crate::problem::{Csc, Problem};

/// Deterministic bound γₙ on the rounding error of a sum of `terms`, in any two orders of addition, as a factor of the sum of their
/// magnitudes.
pub(crate) fn deterministic_bound(terms: usize) -> f64 {
    2.0 * f64::EPSILON * (terms + 2) as f64
}

/// Probabilistic bound √n on it: errors of either sign cancel. Enough for a residual: the deterministic bound of
/// a thousand terms assumes a thousand errors of the same sign.
pub(crate) fn probabilistic_bound(terms: usize) -> f64 {
    2.0 * f64::EPSILON * ((terms as f64).sqrt() + 2.0)
}

/// Rounding error bound of a product with a matrix whose sums have at most `terms` terms of the magnitude that `term` gives.
pub(crate) fn roundoff_in_product(
    matrix: &Csc,
    terms: usize,
    term: impl Fn(f64, usize, usize) -> f64,
) -> f64 {
    deterministic_bound(terms) * matrix.triplets().map(|(i, j, value)| term(value, i, j)).sum::<f64>()
}

/// Bounds on the rounding error of any one entry of a point's residuals.
#[derive(Clone, Copy, Default)]
pub(crate) struct RoundoffBound {
    pub equality: f64,
    pub conic: f64,
    pub dual: f64,
}

impl RoundoffBound {
    /// Of x, y, z and s, entry by entry; absent rows have none.
    pub fn of(problem: &Problem, x: &[f64], y: &[f64], z: &[f64], s: &[f64]) -> Self {
        let mut equality = Sums::new(&problem.b);
        let mut conic = Sums::new(&problem.h);
        let mut dual = Sums::new(&problem.c);
        for (i, j, value) in problem.a.triplets() {
            equality.add(i, value * x[j]);
            dual.add(j, value * y[i]);
        }
        for (i, j, value) in problem.g.triplets() {
            conic.add(i, value * x[j]);
            dual.add(j, value * z[i]);
        }
        for (i, j, value) in problem.p.triplets() {
            dual.add(j, value * x[i]);
            if i != j {
                dual.add(i, value * x[j]);
            }
        }
        for (i, &s) in s.iter().enumerate() {
            conic.add(i, s);
        }
        let present = |i: usize| problem.h[i].is_finite();
        Self { equality: equality.most(|_| true), conic: conic.most(present), dual: dual.most(|_| true) }
    }
}

/// Magnitudes of the terms of several sums.
struct Sums(Vec<(f64, usize)>);

impl Sums {
    /// Each with its first term.
    fn new(first: &[f64]) -> Self {
        Self(first.iter().map(|term| (term.abs(), 1)).collect())
    }

    fn add(&mut self, at: usize, term: f64) {
        let (sum, terms) = &mut self.0[at];
        *sum += term.abs();
        *terms += 1;
    }

    /// The most that rounding may make of any of them that is `wanted`; infinite where a sum is not finite.
    fn most(&self, wanted: impl Fn(usize) -> bool) -> f64 {
        let bound = |&(sum, terms): &(f64, usize)| {
            if sum.is_finite() {
                probabilistic_bound(terms) * sum
            } else {
                f64::INFINITY
            }
        };
        let wanted = self.0.iter().enumerate().filter(|&(i, _)| wanted(i));
        wanted.map(|(_, sum)| bound(sum)).fold(0.0, f64::max)
    }
}

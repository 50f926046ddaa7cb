//! PL module *matrix scaling*: Ruiz equilibration of the problem data, and its undoing.
//!
//! P̂ = γDPD, Â = EAD, Ĝ = FGD, ĉ = γDc, b̂ = Eb, ĥ = Fh with diagonal D, E, F and one factor per
//! second-order cone, so that every row and column of the KKT matrix has maximum entry about one.

use super::reduce::max_abs;
use crate::real::Real;
use crate::structure::{Pattern, Structure};

/// The user's data, or their scaled copy: P (upper), A, G as values; q = (c, b, h).
pub struct Data<'a, T> {
    pub p: &'a mut [T],
    pub a: &'a mut [T],
    pub g: &'a mut [T],
    pub q: &'a mut [T],
}

/// Scale `data` in place. Outputs: (D, E, F) and its reciprocals over the unknowns, (γ, 1/γ).
#[inline(always)]
pub fn equilibrate<T: Real>(
    structure: &Structure,
    passes: u32,
    data: &mut Data<T>,
    norms: &mut [T],
    scale: &mut [T],
    scale_inverse: &mut [T],
    cost_scale: &mut [T],
) {
    let (n, p) = (structure.n, structure.p);
    scale.fill(T::one());
    for _ in 0..passes {
        norms.fill(T::zero());
        largest(n, &structure.cost, data.p, 0, norms);
        largest(n, &structure.equality, data.a, n, norms);
        largest(n, &structure.conic, data.g, n + p, norms);
        for soc in &structure.cones.soc {
            let rows = &mut norms[n + p + soc.start..n + p + soc.start + soc.dim];
            let top = max_abs(rows);
            rows.fill(top);
        }
        for (norm, scale) in norms.iter_mut().zip(scale.iter_mut()) {
            *norm = T::one() / nonzero(*norm).sqrt();
            *scale = *scale * *norm;
        }
        multiply(n, &structure.cost, norms, 0, data.p);
        multiply(n, &structure.equality, norms, n, data.a);
        multiply(n, &structure.conic, norms, n + p, data.g);
    }
    for (q, &scale) in data.q.iter_mut().zip(scale.iter()) {
        *q = *q * scale;
    }
    let gamma = T::one() / nonzero(max_abs(&data.q[..n]).max(max_abs(data.p)));
    for word in data.p.iter_mut().chain(&mut data.q[..n]) {
        *word = *word * gamma;
    }
    for (inverse, &scale) in scale_inverse.iter_mut().zip(scale.iter()) {
        *inverse = T::one() / scale;
    }
    cost_scale[0] = gamma;
    cost_scale[1] = T::one() / gamma;
}

/// One where a norm vanishes (nothing to scale), the norm elsewhere.
#[inline(always)]
fn nonzero<T: Real>(norm: T) -> T {
    T::select(T::zero().lt(norm), norm, T::one())
}

/// Raise each row's and column's norm to the entries of one matrix whose rows begin at `row0`.
#[inline(always)]
fn largest<T: Real>(n: usize, pattern: &Pattern, values: &[T], row0: usize, norms: &mut [T]) {
    for j in 0..n {
        for k in pattern.column(j) {
            let i = row0 + pattern.rows(k..k + 1)[0] as usize;
            let size = values[k].abs();
            norms[i] = norms[i].max(size);
            norms[j] = norms[j].max(size);
        }
    }
}

/// Multiply each entry by its row's and column's factor.
#[inline(always)]
fn multiply<T: Real>(n: usize, pattern: &Pattern, factors: &[T], row0: usize, values: &mut [T]) {
    for j in 0..n {
        for k in pattern.column(j) {
            let i = row0 + pattern.rows(k..k + 1)[0] as usize;
            values[k] = values[k] * (factors[i] * factors[j]);
        }
    }
}

/// The user's (x, y, z) and s from a scaled point: x = Dx̂/τ, (y, z) = (E, F)ŷ/(γτ), s = F⁻¹ŝ/τ.
#[inline(always)]
pub fn undo<T: Real>(
    structure: &Structure,
    scale: &[T],
    scale_inverse: &[T],
    cost_scale: &[T],
    (point, slack, tau): (&[T], &[T], T),
    (out_point, out_slack): (&mut [T], &mut [T]),
) {
    let primal = T::one() / tau;
    let dual = cost_scale[1] * primal;
    for (i, (out, &word)) in out_point.iter_mut().zip(point).enumerate() {
        let factor = if i < structure.n { primal } else { dual };
        *out = (word * scale[i]) * factor;
    }
    let inverse = &scale_inverse[structure.n + structure.p..];
    for ((out, &word), &inverse) in out_slack.iter_mut().zip(slack).zip(inverse) {
        *out = (word * inverse) * primal;
    }
}

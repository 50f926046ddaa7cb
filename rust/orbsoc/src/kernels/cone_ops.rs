//! PL module *cone operations*: Nesterov–Todd scaling and what is done with it.
//!
//! Nonnegative rows: w = √(s/z), λ = √(sz). Second-order cones: W = η·P(w) with w₀² − ‖w₁‖² = 1,
//! W⁻¹s = Wz = λ, and res(v) = (v₀ − ‖v₁‖)(v₀ + ‖v₁‖), factored to avoid cancellation.

use super::reduce::{dot, norm2};
use crate::cones::{ConeLayout, Soc};
use crate::real::Real;

/// Words kept per second-order cone, and which is which.
pub const SCALARS: usize = 9;
pub const ETA: usize = 0;
pub const ETA_INV: usize = 1;
pub const ETA_SQ: usize = 2;
/// λ₀/√res(λ).
pub const GAMMA: usize = 3;
/// 1/√res(λ).
pub const LAMBDA_ROOT_INV: usize = 4;
/// 1/res(λ).
pub const LAMBDA_RES_INV: usize = 5;
/// 1/λ₀.
pub const LAMBDA_HEAD_INV: usize = 6;
pub const INV_ONE_PLUS_W0: usize = 7;
pub const INV_ONE_PLUS_GAMMA: usize = 8;

/// Scaling point of (s, z). Outputs over all rows: `w`, `lambda`; over the nonnegative rows:
/// `lambda_inverse`; over the cones: [`SCALARS`] words each. One division and one root a row.
#[inline(always)]
pub fn nt_scaling<T: Real>(
    cones: &ConeLayout,
    s: &[T],
    z: &[T],
    w: &mut [T],
    lambda: &mut [T],
    lambda_inverse: &mut [T],
    cone: &mut [T],
) {
    for i in 0..cones.l {
        let product = s[i] * z[i];
        let root_inverse = (T::one() / product).sqrt();
        lambda[i] = product * root_inverse;
        lambda_inverse[i] = root_inverse;
        w[i] = s[i] * root_inverse;
    }
    for (soc, scalars) in cones.soc.iter().zip(cone.chunks_exact_mut(SCALARS)) {
        let rows = soc.rows();
        nt_scaling_soc(&s[rows.clone()], &z[rows.clone()], &mut w[rows.clone()], &mut lambda[rows], scalars);
    }
}

/// One second-order cone: three divisions and eight roots.
#[inline(always)]
fn nt_scaling_soc<T: Real>(s: &[T], z: &[T], w: &mut [T], lambda: &mut [T], scalars: &mut [T]) {
    let one = T::one();
    let (res_s, res_z) = (residual_root(s), residual_root(z));
    let res_lambda_inv = one / (res_s * res_z);
    let (s_by, z_by) = (res_z * res_lambda_inv, res_s * res_lambda_inv);
    let (s0, z0) = (s[0] * s_by, z[0] * z_by);
    let half = T::constant(0.5);
    // (1 + s̄ᵀz̄)/2 ≥ 1: both are on the upper sheet of the unit hyperboloid.
    let cosine = (dot(&s[1..], &z[1..]) * s_by) * z_by;
    let gamma = (half * ((one + s0 * z0) + cosine)).sqrt();
    let two_gamma = gamma + gamma;
    let head_sum = (s0 + z0) + two_gamma;
    let pair = one / (two_gamma * head_sum);
    let (w_by, lambda_by) = (pair * head_sum, pair * two_gamma);

    let root_inv = res_lambda_inv.sqrt();
    let root = (res_s * res_z) * root_inv;
    let from_s = ((gamma + z0) * lambda_by) * (s_by * root);
    let from_z = ((gamma + s0) * lambda_by) * (z_by * root);
    lambda[0] = gamma * root;
    let (s_by, z_by) = (s_by * w_by, z_by * w_by);
    for i in 1..s.len() {
        lambda[i] = (from_s * s[i]).add_mul(from_z, z[i]);
        w[i] = (s_by * s[i]).sub_mul(z_by, z[i]);
    }
    w[0] = (one + dot(&w[1..], &w[1..])).sqrt();

    let (one_plus_w0, one_plus_gamma) = (one + w[0], one + gamma);
    let pair = one / (one_plus_w0 * one_plus_gamma);
    let eta_sq = (res_s * res_s) * res_lambda_inv;
    let eta = eta_sq.sqrt();
    scalars[ETA] = eta;
    scalars[ETA_SQ] = eta_sq;
    scalars[ETA_INV] = eta * ((res_z * res_z) * res_lambda_inv);
    scalars[GAMMA] = gamma;
    scalars[LAMBDA_ROOT_INV] = root_inv;
    scalars[LAMBDA_RES_INV] = res_lambda_inv;
    scalars[LAMBDA_HEAD_INV] = root_inv * (w_by + w_by);
    scalars[INV_ONE_PLUS_W0] = pair * one_plus_gamma;
    scalars[INV_ONE_PLUS_GAMMA] = pair * one_plus_w0;
}

/// √res(v), kept away from zero: on the boundary rounding may make it vanish.
#[inline(always)]
fn residual_root<T: Real>(v: &[T]) -> T {
    let tail = norm2(&v[1..]);
    let floor = T::constant(1e-30);
    (v[0] - tail).max(floor * v[0]).sqrt() * (v[0] + tail).sqrt()
}

/// `out = W x`.
#[inline(always)]
pub fn scale<T: Real>(cones: &ConeLayout, w: &[T], cone: &[T], x: &[T], out: &mut [T]) {
    for ((out, &w), &x) in out[..cones.l].iter_mut().zip(w).zip(x) {
        *out = w * x;
    }
    for (soc, scalars) in cones.soc.iter().zip(cone.chunks_exact(SCALARS)) {
        let (w, x, out) = (&w[soc.rows()], &x[soc.rows()], &mut out[soc.rows()]);
        let (eta, zeta) = (scalars[ETA], dot(&w[1..], &x[1..]));
        out[0] = eta * zeta.add_mul(w[0], x[0]);
        let along = x[0].add_mul(zeta, scalars[INV_ONE_PLUS_W0]);
        for i in 1..x.len() {
            out[i] = eta * x[i].add_mul(along, w[i]);
        }
    }
}

/// `out = λ \ d`: the Jordan quotient, λ ∘ out = d.
#[inline(always)]
pub fn divide<T: Real>(
    cones: &ConeLayout,
    lambda: &[T],
    lambda_inverse: &[T],
    cone: &[T],
    d: &[T],
    out: &mut [T],
) {
    for ((out, &inverse), &d) in out[..cones.l].iter_mut().zip(lambda_inverse).zip(d) {
        *out = inverse * d;
    }
    for (soc, scalars) in cones.soc.iter().zip(cone.chunks_exact(SCALARS)) {
        let (lambda, d, out) = (&lambda[soc.rows()], &d[soc.rows()], &mut out[soc.rows()]);
        let head = (lambda[0] * d[0] - dot(&lambda[1..], &d[1..])) * scalars[LAMBDA_RES_INV];
        out[0] = head;
        for i in 1..d.len() {
            out[i] = d[i].sub_mul(head, lambda[i]) * scalars[LAMBDA_HEAD_INV];
        }
    }
}

/// `out = −x − y`.
#[inline(always)]
pub fn negative_sum<T: Real>(x: &[T], y: &[T], out: &mut [T]) {
    for ((out, &x), &y) in out.iter_mut().zip(x).zip(y) {
        *out = (-x) - y;
    }
}

/// `out = direction + step·other`.
#[inline(always)]
pub fn add_scaled<T: Real>(step: T, other: &[T], direction: &mut [T]) {
    for (word, &other) in direction.iter_mut().zip(other) {
        *word = word.add_mul(step, other);
    }
}

/// Shift `v` along the cone's identity until its distance to the boundary is at least 1 and at
/// least a tenth of the mean positive distance.
#[inline(always)]
pub fn shift_into_cone<T: Real>(cones: &ConeLayout, v: &mut [T]) {
    if cones.degree() == 0 {
        return;
    }
    let margin = |v: &[T], soc: &Soc| v[soc.start] - norm2(&v[soc.rows()][1..]);
    let large = T::constant(f64::from(f32::MAX));
    let (mut least, mut positive) = (large, T::zero());
    for &v in &v[..cones.l] {
        least = least.min(v);
        positive = positive + v.max(T::zero());
    }
    for soc in &cones.soc {
        let margin = margin(v, soc);
        least = least.min(margin);
        positive = positive + margin.max(T::zero());
    }
    let target = T::one().max(positive * T::constant(0.1 / cones.degree() as f64));
    let shift = (target - least).max(T::zero());
    for v in &mut v[..cones.l] {
        *v = *v + shift;
    }
    for soc in &cones.soc {
        v[soc.start] = v[soc.start] + shift;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::{inside, jordan, layout, margin, norm, pairs, rows, seeded, Pair};
    use proptest::collection::vec;
    use proptest::prelude::*;

    pub(super) struct Scaling<T> {
        pub w: Vec<T>,
        pub lambda: Vec<T>,
        pub lambda_inverse: Vec<T>,
        pub cone: Vec<T>,
    }

    fn scaling<T: Real>(cones: &ConeLayout, s: &[T], z: &[T]) -> Scaling<T> {
        let zeros = |len| vec![T::zero(); len];
        let mut at = Scaling {
            w: zeros(s.len()),
            lambda: zeros(s.len()),
            lambda_inverse: zeros(cones.l),
            cone: zeros(cones.soc.len() * SCALARS),
        };
        nt_scaling(cones, s, z, &mut at.w, &mut at.lambda, &mut at.lambda_inverse, &mut at.cone);
        at
    }

    fn scaled(cones: &ConeLayout, at: &Scaling<f64>, x: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; x.len()];
        scale(cones, &at.w, &at.cone, x, &mut out);
        out
    }

    /// W⁻¹x by its own formula: (w₀x₀ − ζ)/η and (x₁ + (−x₀ + ζ/(1 + w₀))w₁)/η with ζ = w₁ᵀx₁.
    fn unscaled(cones: &ConeLayout, at: &Scaling<f64>, x: &[f64]) -> Vec<f64> {
        let mut out: Vec<f64> = x.iter().zip(&at.w).map(|(x, w)| x / w).collect();
        for (soc, scalars) in cones.soc.iter().zip(at.cone.chunks(SCALARS)) {
            let (w, x, out) = (&at.w[soc.rows()], &x[soc.rows()], &mut out[soc.rows()]);
            let zeta = crate::oracle::dot(&w[1..], &x[1..]);
            out[0] = (w[0] * x[0] - zeta) * scalars[ETA_INV];
            for i in 1..x.len() {
                out[i] = (x[i] + (zeta / (1.0 + w[0]) - x[0]) * w[i]) * scalars[ETA_INV];
            }
        }
        out
    }

    /// Per cone: the rows, how far s and z are inside relative to their heads, and ‖W‖.
    fn per_cone(pair: &Pair, at: &Scaling<f64>) -> Vec<(core::ops::Range<usize>, f64, f64)> {
        let relative = |v: &[f64]| (v[0] - norm(&v[1..])) / v[0];
        let orthant = (0..pair.cones.l).map(|i| (i..i + 1, 1.0, at.w[i]));
        let soc = pair.cones.soc.iter().zip(at.cone.chunks(SCALARS)).map(|(soc, scalars)| {
            let near = relative(&pair.s[soc.rows()]).min(relative(&pair.z[soc.rows()]));
            let w = &at.w[soc.rows()];
            (soc.rows(), near, scalars[ETA] * (w[0] + norm(&w[1..])))
        });
        orthant.chain(soc).collect()
    }

    proptest! {
        #![proptest_config(seeded(256))]

        /// The bounds: s and z are given with relative error ε, which res(·) magnifies by 1/margin.
        #[test]
        fn scaled_z_and_unscaled_s_are_lambda(pair in pairs(-6.0)) {
            let at = scaling(&pair.cones, &pair.s, &pair.z);
            let (wz, ws) = (scaled(&pair.cones, &at, &pair.z), unscaled(&pair.cones, &at, &pair.s));
            for (rows, near, w) in per_cone(&pair, &at) {
                let error = |v: &[f64]| {
                    rows.clone().map(|i| (v[i] - at.lambda[i]).abs()).fold(0.0, f64::max)
                };
                let inverse = w / (at.w[rows.start] * at.w[rows.start]).max(1e-300);
                prop_assert!(error(&wz) <= 64.0 * f64::EPSILON / near * w * norm(&pair.z[rows.clone()]));
                let _ = inverse;
                let size = norm(&at.lambda[rows.clone()]) + norm(&pair.s[rows.clone()]) / w;
                prop_assert!(error(&ws) <= 64.0 * f64::EPSILON / near * size.max(norm(&ws[rows.clone()])));
            }
        }
    }
}

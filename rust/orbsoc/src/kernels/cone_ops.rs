//! PL module *cone operations*: Nesterov–Todd scaling and what is done with it.
//!
//! Nonnegative rows: w = √(s/z), λ = √(sz). Second-order cones: W = η·P(w) with w₀² − ‖w₁‖² = 1,
//! W⁻¹s = Wz = λ, and res(v) = (v₀ − ‖v₁‖)(v₀ + ‖v₁‖), factored to avoid cancellation.

use super::reduce::{dot, norm2};
use crate::problem::cones::ConeLayout;
use crate::real::Real;

/// Entries kept per second-order cone, and which is which.
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
/// `lambda_inverse`; over the cones: [`SCALARS`] entries each. One division and one root a row.
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
    let scalars = cone.as_chunks_mut::<SCALARS>().0;
    cones.each_soc(
        #[inline(always)]
        |rows, k| {
            let (s, z) = (&s[rows.clone()], &z[rows.clone()]);
            nt_scaling_soc(s, z, &mut w[rows.clone()], &mut lambda[rows], &mut scalars[k]);
        },
    );
}

/// One second-order cone: three divisions and ten roots, three of either residual's.
#[inline(always)]
fn nt_scaling_soc<T: Real>(s: &[T], z: &[T], w: &mut [T], lambda: &mut [T], scalars: &mut [T; SCALARS]) {
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
    let scalars = cone.as_chunks::<SCALARS>().0;
    cones.each_soc(
        #[inline(always)]
        |rows, k| {
            let (w, x, out) = (&w[rows.clone()], &x[rows.clone()], &mut out[rows]);
            let (eta, zeta) = (scalars[k][ETA], dot(&w[1..], &x[1..]));
            out[0] = eta * zeta.add_mul(w[0], x[0]);
            let along = x[0].add_mul(zeta, scalars[k][INV_ONE_PLUS_W0]);
            for i in 1..x.len() {
                out[i] = eta * x[i].add_mul(along, w[i]);
            }
        },
    );
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
    let scalars = cone.as_chunks::<SCALARS>().0;
    cones.each_soc(
        #[inline(always)]
        |rows, k| {
            let (lambda, d, out) = (&lambda[rows.clone()], &d[rows.clone()], &mut out[rows]);
            let head = (lambda[0] * d[0] - dot(&lambda[1..], &d[1..])) * scalars[k][LAMBDA_RES_INV];
            out[0] = head;
            for i in 1..d.len() {
                out[i] = d[i].sub_mul(head, lambda[i]) * scalars[k][LAMBDA_HEAD_INV];
            }
        },
    );
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
    for (entry, &other) in direction.iter_mut().zip(other) {
        *entry = entry.add_mul(step, other);
    }
}

/// v₀ − ‖v₁‖, negative outside the second-order cone.
#[inline(always)]
fn distance_to_boundary<T: Real>(v: &[T]) -> T {
    v[0] - norm2(&v[1..])
}

/// Shift `v` along the cone's identity until its distance to the boundary is at least 1 and at
/// least a tenth of the mean positive distance.
#[inline(always)]
pub fn shift_into_cone<T: Real>(cones: &ConeLayout, v: &mut [T]) {
    if cones.degree() == 0 {
        return;
    }
    let large = T::constant(f64::from(f32::MAX));
    let (mut least, mut positive) = (large, T::zero());
    for &v in &v[..cones.l] {
        least = least.min(v);
        positive = positive + v.max(T::zero());
    }
    for soc in &cones.soc {
        let margin = distance_to_boundary(&v[soc.rows()]);
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
    use crate::tests::reference::{
        self, jordan, layout, margin, norm, pairs, scaling, seeded, Pair, Scaling,
    };
    use core::ops::Range;
    use proptest::collection::vec;
    use proptest::prelude::*;

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
            let zeta = reference::dot(&w[1..], &x[1..]);
            out[0] = (w[0] * x[0] - zeta) / scalars[ETA];
            for i in 1..x.len() {
                out[i] = (x[i] + (zeta / (1.0 + w[0]) - x[0]) * w[i]) / scalars[ETA];
            }
        }
        out
    }

    struct Block {
        rows: Range<usize>,
        /// Rounding of s and z, magnified by res(·): ε over their smaller relative margin.
        rounding: f64,
        /// ‖W‖ and ‖W⁻¹‖.
        norms: (f64, f64),
    }

    fn blocks(pair: &Pair, at: &Scaling<f64>) -> Vec<Block> {
        let relative = |v: &[f64]| (v[0] - norm(&v[1..])) / v[0];
        let orthant = (0..pair.cones.l).map(|i| Block {
            rows: i..i + 1,
            rounding: f64::EPSILON,
            norms: (at.w[i], 1.0 / at.w[i]),
        });
        let soc = pair.cones.soc.iter().zip(at.cone.chunks(SCALARS)).map(|(soc, scalars)| {
            let near = relative(&pair.s[soc.rows()]).min(relative(&pair.z[soc.rows()]));
            let (w, eta) = (at.w[soc.start] + norm(&at.w[soc.rows()][1..]), scalars[ETA]);
            Block { rows: soc.rows(), rounding: f64::EPSILON / near, norms: (eta * w, w / eta) }
        });
        orthant.chain(soc).collect()
    }

    proptest! {
        #![proptest_config(seeded(256))]

        #[test]
        fn scaled_z_and_unscaled_s_are_lambda(pair in pairs(-6.0)) {
            let at = scaling(&pair.cones, &pair.s, &pair.z);
            let (from_z, from_s) = (scaled(&pair.cones, &at, &pair.z), unscaled(&pair.cones, &at, &pair.s));
            for Block { rows, rounding, norms } in blocks(&pair, &at) {
                let size = (norms.0 * norm(&pair.z[rows.clone()]), norms.1 * norm(&pair.s[rows.clone()]));
                for i in rows {
                    prop_assert!((from_z[i] - at.lambda[i]).abs() <= 16.0 * rounding * size.0);
                    prop_assert!((from_s[i] - at.lambda[i]).abs() <= 16.0 * rounding * size.1);
                }
            }
        }

        #[test]
        fn the_scaling_points_are_on_the_unit_hyperboloid(pair in pairs(-6.0)) {
            let at = scaling(&pair.cones, &pair.s, &pair.z);
            for (soc, scalars) in pair.cones.soc.iter().zip(at.cone.chunks(SCALARS)) {
                let (w, lambda) = (&at.w[soc.rows()], &at.lambda[soc.rows()]);
                let unit = (w[0] - norm(&w[1..])) * (w[0] + norm(&w[1..]));
                prop_assert!(w[0] >= 1.0 && (unit - 1.0).abs() <= 16.0 * f64::EPSILON * w[0] * w[0]);
                let close = |entry: usize, value: f64| (scalars[entry] / value - 1.0).abs() <= 1e-9;
                prop_assert!(close(ETA_INV, 1.0 / scalars[ETA]));
                prop_assert!(close(ETA_SQ, scalars[ETA] * scalars[ETA]));
                prop_assert!(close(GAMMA, lambda[0] * scalars[LAMBDA_ROOT_INV]));
                prop_assert!(close(LAMBDA_RES_INV, scalars[LAMBDA_ROOT_INV] * scalars[LAMBDA_ROOT_INV]));
                prop_assert!(close(LAMBDA_HEAD_INV, 1.0 / lambda[0]));
                prop_assert!(close(INV_ONE_PLUS_W0, 1.0 / (1.0 + w[0])));
                prop_assert!(close(INV_ONE_PLUS_GAMMA, 1.0 / (1.0 + scalars[GAMMA])));
                // res(λ)² = res(s)·res(z), the invariant that makes λ central when s and z are.
                let res = |v: &[f64]| (v[0] - norm(&v[1..])) * (v[0] + norm(&v[1..]));
                let both = res(&pair.s[soc.rows()]) * res(&pair.z[soc.rows()]);
                prop_assert!((both * scalars[LAMBDA_RES_INV] * scalars[LAMBDA_RES_INV] - 1.0).abs() <= 1e-8);
            }
        }

        #[test]
        fn division_undoes_the_jordan_product(
            (pair, d) in pairs(-4.0).prop_flat_map(|pair| {
                let m = pair.s.len();
                (Just(pair), vec(-1.0..1.0f64, m))
            })
        ) {
            let at = scaling(&pair.cones, &pair.s, &pair.z);
            let mut quotient = vec![0.0; d.len()];
            divide(&pair.cones, &at.lambda, &at.lambda_inverse, &at.cone, &d, &mut quotient);
            let product = jordan(&pair.cones, &at.lambda, &quotient);
            for Block { rows, rounding, .. } in blocks(&pair, &at) {
                let size = norm(&at.lambda[rows.clone()]) * norm(&quotient[rows.clone()]);
                for i in rows {
                    prop_assert!((product[i] - d[i]).abs() <= 16.0 * rounding * size);
                }
            }
        }

        #[test]
        fn shifting_moves_along_the_identity_just_far_enough(
            (cones, v) in (0usize..=4, vec(1usize..=16, 0..=3)).prop_flat_map(|(l, dims)| {
                let m = l + dims.iter().sum::<usize>();
                (Just(layout(l, &dims)), vec(-100.0..100.0f64, m))
            })
        ) {
            let mut shifted = v.clone();
            shift_into_cone(&cones, &mut shifted);
            let heads: Vec<usize> = (0..cones.l).chain(cones.soc.iter().map(|soc| soc.start)).collect();
            let step = heads.first().map_or(0.0, |&i| shifted[i] - v[i]);
            for i in 0..v.len() {
                let expected = if heads.contains(&i) { v[i] + step } else { v[i] };
                prop_assert!((shifted[i] - expected).abs() <= 1e-14 * (1.0 + expected.abs()));
            }
            if !heads.is_empty() {
                let single = |i: usize| {
                    let soc = cones.soc.iter().find(|soc| soc.start == i);
                    soc.map_or(v[i], |soc| v[i] - norm(&v[soc.rows()][1..]))
                };
                let mean = heads.iter().map(|&i| single(i).max(0.0)).sum::<f64>() / heads.len() as f64;
                let target = f64::max(1.0, 0.1 * mean);
                let before = margin(&cones, &v);
                let expected = before.max(target);
                prop_assert!((margin(&cones, &shifted) - expected).abs() <= 1e-12 * expected);
            }
        }
    }

    #[test]
    fn sums_of_directions_are_entrywise() {
        let mut out = [0.0; 3];
        negative_sum(&[1.0, -2.0, 4.0], &[0.5, 0.25, -8.0], &mut out);
        assert_eq!(out.map(f64::to_bits), [-1.5, 1.75, 4.0].map(f64::to_bits));
        add_scaled(2.0, &[1.0, 1.0, -1.0], &mut out);
        assert_eq!(out.map(f64::to_bits), [0.5, 3.75, 2.0].map(f64::to_bits));
    }
}

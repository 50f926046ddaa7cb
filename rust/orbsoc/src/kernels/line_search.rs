//! PL module *line search*: the largest step that stays in the cone.

use super::cone_ops::{GAMMA, INV_ONE_PLUS_GAMMA, LAMBDA_ROOT_INV, SCALARS};
use super::reduce::{dot, max_negative_product, norm2};
use crate::problem::cones::ConeLayout;
use crate::real::Real;

/// Reciprocal of the largest α with λ + αδ ∈ K, zero when every step stays inside.
///
/// Branch-free and without the quadratic formula, whose discriminant lies in floating point:
/// with λ̄ = λ/√res(λ), ρ₀ = λ̄ᵀJδ/√res(λ) and
/// ρ₁ = (δ₁ − (λ̄ᵀJδ + δ₀)/(λ̄₀ + 1)·λ̄₁)/√res(λ), it is max(0, ‖ρ₁‖ − ρ₀) per cone.
#[inline(always)]
pub fn inverse_step<T: Real>(
    cones: &ConeLayout,
    lambda: &[T],
    lambda_inverse: &[T],
    cone: &[T],
    delta: &[T],
    scratch: &mut [T],
) -> T {
    let mut inverse = max_negative_product(&delta[..cones.l], lambda_inverse);
    let scalars = cone.as_chunks::<SCALARS>().0;
    cones.each_soc(
        #[inline(always)]
        |rows, k| {
            let (lambda, delta) = (&lambda[rows.clone()], &delta[rows]);
            let root_inverse = scalars[k][LAMBDA_ROOT_INV];
            let product = (scalars[k][GAMMA] * delta[0]) - root_inverse * dot(&lambda[1..], &delta[1..]);
            let factor = ((product + delta[0]) * scalars[k][INV_ONE_PLUS_GAMMA]) * root_inverse;
            let rho = &mut scratch[..delta.len() - 1];
            for ((rho, &d), &l) in rho.iter_mut().zip(&delta[1..]).zip(&lambda[1..]) {
                *rho = d.sub_mul(factor, l);
            }
            inverse = inverse.max((norm2(rho) - product) * root_inverse);
        },
    );
    inverse
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::cones::Soc;
    use crate::tests::reference::{
        dot as plain_dot, inside, layout, norm, pairs, scaling, seeded, Pair, Scaling, SplitMix64,
    };
    use core::ops::Range;
    use proptest::collection::vec;
    use proptest::prelude::*;

    fn inverse<T: Real>(cones: &ConeLayout, at: &Scaling<T>, delta: &[T]) -> T {
        let mut scratch = vec![T::zero(); delta.len()];
        inverse_step(cones, &at.lambda, &at.lambda_inverse, &at.cone, delta, &mut scratch)
    }

    /// Per cone: the margin of λ + αδ, and what rounding, magnified by the nearness of s and z to
    /// the boundary, may do to it.
    fn margins(pair: &Pair, lambda: &[f64], delta: &[f64], alpha: f64) -> Vec<(f64, f64)> {
        let moved: Vec<f64> = lambda.iter().zip(delta).map(|(l, d)| l + alpha * d).collect();
        let near = |v: &[f64]| 1.0 - norm(&v[1..]) / v[0];
        let see = |rows: Range<usize>| {
            let (l, d, moved) = (&lambda[rows.clone()], &delta[rows.clone()], &moved[rows.clone()]);
            let rounding = 16.0 * f64::EPSILON / near(&pair.s[rows.clone()]).min(near(&pair.z[rows]));
            (moved[0] - norm(&moved[1..]), rounding * (norm(l) + alpha * norm(d)))
        };
        let orthant = (0..pair.cones.l).map(|i| i..i + 1);
        orthant.chain(pair.cones.soc.iter().map(Soc::rows)).map(see).collect()
    }

    /// A cone's λ on its own: s = z = λ, so W = I.
    fn central<T: Real>(cones: &ConeLayout, lambda: &[T]) -> Scaling<T> {
        let mut at = scaling(cones, lambda, lambda);
        at.lambda.copy_from_slice(lambda);
        at
    }

    fn directions(nearest: f64) -> impl Strategy<Value = (Pair, Vec<f64>)> {
        pairs(nearest).prop_flat_map(|pair| {
            let m = pair.s.len();
            let delta = (vec(-1.0..1.0f64, m), -3.0..3.0f64)
                .prop_map(|(d, size)| d.into_iter().map(|d| d * 10f64.powf(size)).collect::<Vec<_>>());
            (Just(pair), delta)
        })
    }

    proptest! {
        #![proptest_config(seeded(512))]

        /// The margin f(α) is concave, so with f(α*) = 0 for the cone that stops the step:
        /// f(0.999 α*) ≥ 0.001 f(0) for all cones, and f(1.001 α*) ≤ −0.001 f(0) for that one.
        #[test]
        fn the_step_is_feasible_and_a_thousandth_more_is_not((pair, delta) in directions(-4.0)) {
            let at = scaling(&pair.cones, &pair.s, &pair.z);
            let inverse = inverse(&pair.cones, &at, &delta);
            prop_assert!(inverse >= 0.0);
            prop_assume!(inverse > 0.0);
            let see = |alpha: f64| margins(&pair, &at.lambda, &delta, alpha);
            let (start, at_step) = (see(0.0), see(1.0 / inverse));
            let (short, long) = (see(0.999 / inverse), see(1.001 / inverse));
            for i in 0..start.len() {
                prop_assert!(at_step[i].0 >= -at_step[i].1);
                prop_assert!(short[i].0 >= 0.001 * start[i].0 - short[i].1);
            }
            let stops = |i: usize| long[i].0 <= -0.001 * start[i].0 + long[i].1;
            prop_assert!((0..start.len()).any(stops));
        }

        #[test]
        fn directions_inside_the_cone_never_end(pair in pairs(-6.0)) {
            let at = scaling(&pair.cones, &pair.s, &pair.z);
            prop_assert_eq!(inverse(&pair.cones, &at, &pair.s).to_bits(), 0.0f64.to_bits());
        }

        /// The trap: δ = −t·λ leaves through the apex at α = 1/t, where the quadratic
        /// ‖·‖² has a double root and its discriminant, zero in truth, may come out negative.
        #[test]
        fn rays_through_the_apex_stop_there(lambda in (1usize..=16).prop_flat_map(|dim| inside(dim, -4.0)),
                                            t in 1e-3..1e3f64) {
            let cones = layout(0, &[lambda.len()]);
            let at = central(&cones, &lambda);
            let delta: Vec<f64> = lambda.iter().map(|l| -t * l).collect();
            let found = inverse(&cones, &at, &delta);
            let near = 1.0 - norm(&lambda[1..]) / lambda[0];
            prop_assert!((found / t - 1.0).abs() <= 16.0 * f64::EPSILON / near, "{found} for {t}");
        }

        /// a = res(δ) = 0: the quadratic becomes linear, and its formula divides by zero.
        #[test]
        fn lightlike_directions_have_their_single_root(lambda in (2usize..=16).prop_flat_map(|dim| inside(dim, -3.0)),
                                                       tail in vec(-1.0..1.0f64, 15)) {
            let cones = layout(0, &[lambda.len()]);
            let at = central(&cones, &lambda);
            let tail = &tail[..lambda.len() - 1];
            prop_assume!(norm(tail) > 1e-3);
            let delta: Vec<f64> = core::iter::once(-norm(tail)).chain(tail.iter().copied()).collect();
            // res(λ + αδ) = res(λ) + 2α λᵀJδ: the root is −res(λ)/(2λᵀJδ), and λᵀJδ < 0.
            let product = lambda[0] * delta[0] - plain_dot(&lambda[1..], tail);
            let res = (lambda[0] - norm(&lambda[1..])) * (lambda[0] + norm(&lambda[1..]));
            let found = inverse(&cones, &at, &delta);
            prop_assert!((found * res / (-2.0 * product) - 1.0).abs() <= 1e-9, "{found}");
        }

        /// Size 2 in binary32: with u = v₀ + v₁ and w = v₀ − v₁ the cone is R₊², where the step is plain.
        #[test]
        fn two_dimensional_cones_near_the_boundary_are_safe_in_single_precision(
            head in 0.5..2.0f32, near in -4.0..0.0f32, up in any::<bool>(), delta in [-2.0..2.0f32, -2.0..2.0f32],
        ) {
            let cones = layout(0, &[2]);
            let lambda = [head, (1.0 - 10f32.powf(near)) * if up { head } else { -head }];
            let found = f64::from(inverse(&cones, &central(&cones, &lambda), &delta));
            let wide = |v: [f32; 2]| [f64::from(v[0]) + f64::from(v[1]), f64::from(v[0]) - f64::from(v[1])];
            let (l, d) = (wide(lambda), wide(delta));
            let exact = f64::max(0.0, f64::max(-d[0] / l[0], -d[1] / l[1]));
            // Error: ε·‖δ‖/res(λ), which is what the nearer face divides by.
            let allowed = 32.0 * f64::from(f32::EPSILON) / (l[0] * l[1]);
            prop_assert!((found - exact).abs() <= allowed, "{found} for {exact}, allowed {allowed}");
        }
    }

    #[test]
    fn the_quadratic_rule_would_step_through_the_apex() {
        // Why the kernel has no discriminant: the same rays, judged by "discriminant < 0: no root".
        let mut numbers = SplitMix64(1);
        let misjudged = (0..1000).filter(|_| {
            let tail = numbers.list(3);
            let lambda: Vec<f64> = core::iter::once(norm(&tail) + numbers.unit()).chain(tail).collect();
            let delta: Vec<f64> = lambda.iter().map(|l| -0.7 * l).collect();
            let product = |x: &[f64], y: &[f64]| x[0] * y[0] - plain_dot(&x[1..], &y[1..]);
            let (a, b, c) = (product(&delta, &delta), product(&lambda, &delta), product(&lambda, &lambda));
            b * b - a * c < 0.0
        });
        assert!(misjudged.count() > 100);
    }

    #[test]
    fn a_point_on_the_boundary_gives_a_finite_tiny_step() {
        let cones = layout(1, &[3]);
        let on_boundary = [1e-300f64, 5.0, 3.0, 4.0];
        let at = scaling(&cones, &on_boundary, &[1.0, 1.0, 0.0, 0.0]);
        let outward = inverse(&cones, &at, &[0.0, -1.0, 0.6, 0.8]);
        assert!(outward.is_finite() && outward > 1e6, "{outward}");
        assert_eq!(inverse(&cones, &at, &[1.0, 1.0, 0.0, 0.0]).to_bits(), 0.0f64.to_bits());
    }
}

//! PL module *cone operations*: the pair on the central path that is nearest to a given one.
//!
//! For v = s − z, the pair s = (v + √(v² + 4μe))/2, z = (−v + √(v² + 4μe))/2 (square and root those of
//! the cone's Jordan algebra) is inside the cone, keeps s − z and has s∘z = μe. With μ = 0 it is the
//! projection of ±v; with μ > 0, Chen and Harker's and Kanzow's smoothing of it.

use super::reduce::norm2;
use crate::problem::cones::ConeLayout;
use crate::real::Real;

/// Replace (s, z) by the pair with the same difference and s∘z = μe. One root and one division a
/// nonnegative row; three of either (and the norm's) a cone. Neither member suffers cancellation: the
/// larger is a sum of like signs, the smaller μ times its inverse.
#[inline(always)]
pub fn central_pair<T: Real>(cones: &ConeLayout, mu: T, s: &mut [T], z: &mut [T]) {
    let zero = T::zero();
    let four_mu = T::constant(4.0) * mu;
    for (s, z) in s[..cones.l].iter_mut().zip(z.iter_mut()) {
        let v = *s - *z;
        let (large, small, _) = roots(v.abs(), mu, four_mu);
        let negative = v.lt(zero);
        *s = T::select(negative, small, large);
        *z = T::select(negative, large, small);
    }
    for soc in &cones.soc {
        central_pair_soc(mu, four_mu, &mut s[soc.rows()], &mut z[soc.rows()]);
    }
}

/// With |v₀| in place of v₀: `f` is the larger member, `g = μf⁻¹` the smaller; v₀ < 0 swaps them.
#[inline(always)]
fn central_pair_soc<T: Real>(mu: T, four_mu: T, s: &mut [T], z: &mut [T]) {
    let (zero, half) = (T::zero(), T::constant(0.5));
    for (s, &z) in s.iter_mut().zip(z.iter()) {
        *s = *s - z;
    }
    let (head, tail) = (s[0].abs(), norm2(&s[1..]));
    let negative = s[0].lt(zero);
    let (f_outer, g_outer, root_outer) = roots(head + tail, mu, four_mu);
    let inner = head - tail;
    let (large, small, root_inner) = roots(inner.abs(), mu, four_mu);
    let outside = inner.lt(zero);
    let (f_inner, g_inner) = (T::select(outside, small, large), T::select(outside, large, small));
    // (f(a) − f(b))/(a − b) without the difference: a = |v₀| + ‖v₁‖, b = |v₀| − ‖v₁‖.
    let slope = half + head / (root_outer + root_inner);
    let slope_inverse = slope * (g_inner / f_outer);
    let (f_head, g_head) = (half * (f_outer + f_inner), half * (g_outer + g_inner));
    let s_by = T::select(negative, slope_inverse, slope);
    let z_by = -T::select(negative, slope, slope_inverse);
    s[0] = T::select(negative, g_head, f_head);
    z[0] = T::select(negative, f_head, g_head);
    for (s, z) in s[1..].iter_mut().zip(&mut z[1..]) {
        let v = *s;
        *s = s_by * v;
        *z = z_by * v;
    }
}

/// For v ≥ 0: (v + √(v² + 4μ))/2, μ over it, and the root.
#[inline(always)]
fn roots<T: Real>(v: T, mu: T, four_mu: T) -> (T, T, T) {
    let root = four_mu.add_mul(v, v).sqrt();
    let large = T::constant(0.5) * (v + root);
    (large, mu / large, root)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::reference::{self, jordan, layout, margin, norm, seeded};
    use proptest::collection::vec;
    use proptest::prelude::*;

    fn anywhere() -> impl Strategy<Value = (ConeLayout, Vec<f64>, Vec<f64>, f64)> {
        (0usize..=4, vec(2usize..=16, 0..=3)).prop_flat_map(|(l, dims)| {
            let m = l + dims.iter().sum::<usize>();
            let point = || (vec(-1.0..1.0f64, m), -6.0..3.0f64).prop_map(|(v, size)| scaled(&v, size));
            (Just(layout(l, &dims)), point(), point(), (-12.0..0.0f64).prop_map(|e| 10f64.powf(e)))
        })
    }

    fn scaled(v: &[f64], decades: f64) -> Vec<f64> {
        v.iter().map(|v| v * 10f64.powf(decades)).collect()
    }

    proptest! {
        #![proptest_config(seeded(512))]

        #[test]
        fn the_pair_is_central_and_keeps_the_difference((cones, s, z, mu) in anywhere()) {
            let (mut s_new, mut z_new) = (s.clone(), z.clone());
            central_pair(&cones, mu, &mut s_new, &mut z_new);
            let size = norm(&s) + norm(&z) + mu.sqrt();
            for i in 0..s.len() {
                prop_assert!(((s_new[i] - z_new[i]) - (s[i] - z[i])).abs() <= 1e-15 * 8.0 * size);
            }
            let product = jordan(&cones, &s_new, &z_new);
            let heads: Vec<usize> = (0..cones.l).chain(cones.soc.iter().map(|soc| soc.start)).collect();
            for (i, &product) in product.iter().enumerate() {
                let expected = if heads.contains(&i) { mu } else { 0.0 };
                prop_assert!((product - expected).abs() <= 1e-15 * 8.0 * size * size + 1e-14 * mu);
            }
            prop_assert!(margin(&cones, &s_new) > -1e-16 * 8.0 * size);
            prop_assert!(margin(&cones, &z_new) > -1e-16 * 8.0 * size);
        }

        #[test]
        fn with_no_mu_left_the_pair_projects((cones, s, z, _) in anywhere()) {
            let (mut s_new, mut z_new) = (s.clone(), z.clone());
            central_pair(&cones, 1e-300, &mut s_new, &mut z_new);
            let size = norm(&s) + norm(&z);
            // s ∈ K, z ∈ K and sᵀz = 0: the characterisation of Π(v) and Π(−v).
            prop_assert!(reference::dot(&s_new, &z_new).abs() <= 1e-14 * size * size);
            prop_assert!(margin(&cones, &s_new) >= -1e-15 * size);
            prop_assert!(margin(&cones, &z_new) >= -1e-15 * size);
        }

        #[test]
        fn a_central_pair_stays_where_it_is((cones, s, z, mu) in anywhere()) {
            let (mut once, mut other) = (s, z);
            central_pair(&cones, mu, &mut once, &mut other);
            let (mut twice, mut again) = (once.clone(), other.clone());
            central_pair(&cones, mu, &mut twice, &mut again);
            let size = norm(&once) + norm(&other);
            for (a, b) in once.iter().zip(&twice).chain(other.iter().zip(&again)) {
                prop_assert!((a - b).abs() <= 1e-14 * size);
            }
        }
    }
}

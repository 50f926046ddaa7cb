//! PL module *line search*: the largest step that stays in the cone.

use super::cone_ops::{GAMMA, INV_ONE_PLUS_GAMMA, LAMBDA_ROOT_INV, SCALARS};
use super::reduce::{dot, max_negative_product, norm2};
use crate::cones::ConeLayout;
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
    for (soc, scalars) in cones.soc.iter().zip(cone.chunks_exact(SCALARS)) {
        let (lambda, delta) = (&lambda[soc.rows()], &delta[soc.rows()]);
        let root_inverse = scalars[LAMBDA_ROOT_INV];
        let product = (scalars[GAMMA] * delta[0]) - root_inverse * dot(&lambda[1..], &delta[1..]);
        let factor = ((product + delta[0]) * scalars[INV_ONE_PLUS_GAMMA]) * root_inverse;
        let rho = &mut scratch[..soc.dim - 1];
        for ((rho, &d), &l) in rho.iter_mut().zip(&delta[1..]).zip(&lambda[1..]) {
            *rho = d.sub_mul(factor, l);
        }
        inverse = inverse.max((norm2(rho) - product) * root_inverse);
    }
    inverse
}

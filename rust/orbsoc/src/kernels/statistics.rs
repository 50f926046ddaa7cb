//! PL module *statistics*: residuals and the numbers of termination, the embedding's scalar equation, centring, cone
//! product, advance. In the paper's computer the processing system does this.
//!
//! Sums go through the fixed reduction tree; `decisions` decides on what comes of them.

use super::layout::{centering, embedding, norm, parameter, regularization, stat};
use super::reduce::{dot, max_abs, max_abs_weighted, non_finite_flag, sum_abs_weighted};
use super::sparse::{products_of, symmetric_product};
use crate::kkt::structure::Structure;
use crate::problem::cones::ConeLayout;
use crate::real::Real;

/// What the statistics stage reads.
pub(crate) struct Iterate<'a, T> {
    pub p: &'a [T],
    pub a: &'a [T],
    pub g: &'a [T],
    pub q: &'a [T],
    pub norms: &'a [T],
    pub scale_inverse: &'a [T],
    pub cost_scale: &'a [T],
    pub point: &'a [T],
    pub slack: &'a [T],
    pub homogenizer: &'a [T],
}

/// Residuals of the embedding, and the numbers that termination compares.
#[inline(always)]
#[allow(clippy::too_many_arguments)] // structure and iterate in, scratch, five buffers out
pub(crate) fn statistics<T: Real>(
    structure: &Structure,
    at: &Iterate<T>,
    products: &mut [T],
    residual: &mut [T],
    cost_product: &mut [T],
    embed: &mut [T],
    center: &mut [T],
    stats: &mut [T],
) {
    let (n, p) = (structure.n, structure.p);
    let (x, yz) = at.point.split_at(n);
    let (c, bh) = at.q.split_at(n);
    let (y, z) = yz.split_at(p);
    let (tau, kappa) = (at.homogenizer[0], at.homogenizer[1]);
    let (duals, rows) = products.split_at_mut(2 * n);
    let (aty, gtz) = duals.split_at_mut(n);
    let (ax, gx) = rows.split_at_mut(p);
    symmetric_product(&structure.cost, at.p, x, cost_product);
    products_of(&structure.equality, at.a, x, y, ax, aty);
    products_of(&structure.conic, at.g, x, z, gx, gtz);

    let (scale_x, scale_rows) = at.scale_inverse.split_at(n);
    let (scale_y, scale_z) = scale_rows.split_at(p);
    // Norms of the products before they are overwritten by the sums that follow.
    let size_ax = max_abs_weighted(scale_y, ax);
    let size_gx = max_abs_weighted(scale_z, gx);
    let size_px = max_abs_weighted(scale_x, cost_product);
    let size_aty = max_abs_weighted(scale_x, aty);
    let size_gtz = max_abs_weighted(scale_x, gtz);
    let ray_rows = sum_abs_weighted(scale_y, ax);
    let ray_cost = sum_abs_weighted(scale_x, cost_product);
    for (sum, &other) in aty.iter_mut().zip(gtz.iter()) {
        *sum = *sum + other;
    }
    for (sum, &slack) in gx.iter_mut().zip(at.slack) {
        *sum = *sum + slack;
    }
    let ray_cone = sum_abs_weighted(scale_z, gx);
    let farkas_residual = sum_abs_weighted(scale_x, aty);

    let (residual_x, residual_rows) = residual.split_at_mut(n);
    for (((out, &px), &dual), &c) in residual_x.iter_mut().zip(cost_product.iter()).zip(aty.iter()).zip(c) {
        *out = (px + dual).add_mul(tau, c);
    }
    for ((out, &product), &rhs) in residual_rows.iter_mut().zip(rows.iter()).zip(bh) {
        *out = product.sub_mul(tau, rhs);
    }
    let size_x = max_abs_weighted(scale_x, residual_x);
    let size_y = max_abs_weighted(scale_y, &residual_rows[..p]);
    let size_z = max_abs_weighted(scale_z, &residual_rows[p..]);

    let (one, half) = (T::one(), T::constant(0.5));
    let cost = dot(c, x);
    let support = dot(bh, yz);
    let tau_inv = one / tau;
    let curvature = (dot(x, cost_product) * tau_inv) * tau_inv;
    let degree = T::constant(structure.cones.degree() as f64 + 1.0);
    let complement = dot(at.slack, z);
    let mu = complement.add_mul(tau, kappa) / degree;

    embed[embedding::RESIDUAL] = ((kappa + cost) + support).add_mul(curvature, tau);
    embed[embedding::TAU_INV] = tau_inv;
    embed[embedding::CURVATURE] = curvature;
    center[centering::DAMPING] = one;
    center[centering::TARGET] = T::zero();
    center[centering::COMPLEMENT] = kappa * tau;
    center[centering::CORRECTION] = one;

    let (norm_b, norm_h, norm_c) = (at.norms[norm::B], at.norms[norm::H], at.norms[norm::C]);
    let gamma_inv = at.cost_scale[1];
    let dual_by = gamma_inv * tau_inv;
    let (size_x, size_y, size_z) = (size_x * dual_by, size_y * tau_inv, size_z * tau_inv);
    let equality = size_y / (one + norm_b.max(size_ax * tau_inv));
    let conic = size_z / (one + norm_h.max(size_gx * tau_inv));
    let dual_size = norm_c.max(size_px.max(size_aty).max(size_gtz) * dual_by);
    let dual = size_x / (one + dual_size);
    let objective = (half * curvature).add_mul(cost, tau_inv) * gamma_inv;
    let dual_objective = -((half * curvature).add_mul(support, tau_inv) * gamma_inv);
    let gap = (objective - dual_objective).abs() / (one + objective.abs().min(dual_objective.abs()));
    let referee_primal = size_y.max(size_z) / (one + norm_b.max(norm_h));
    let referee_dual = size_x / (one + norm_c);
    let primal = equality.max(conic).max(referee_primal);
    let dual = dual.max(referee_dual);
    stats[stat::PRIMAL] = primal;
    stats[stat::DUAL] = dual;
    stats[stat::GAP] = gap;
    stats[stat::STRICT] = primal.max(dual).max(gap);
    stats[stat::OBJECTIVE] = objective;
    stats[stat::DUAL_OBJECTIVE] = dual_objective;
    stats[stat::MU] = mu;
    stats[stat::PRIMAL_RADIUS] = radius(support, farkas_residual, at.norms[norm::PRIMAL_SCALE]);
    let dual_residual = (ray_rows + ray_cone).add_mul(ray_cost, gamma_inv);
    stats[stat::DUAL_RADIUS] = radius(cost * gamma_inv, dual_residual, at.norms[norm::DUAL_SCALE]);
    stats[stat::NON_FINITE] =
        non_finite_flag(at.point) + (non_finite_flag(at.slack) + non_finite_flag(at.homogenizer));
}

/// Radius that a certificate of this value and residual size proves, over a scale.
#[inline(always)]
fn radius<T: Real>(value: T, size: T, scale: T) -> T {
    (-value).max(T::zero()) / (size.max(T::constant(1e-30)) * scale)
}

/// Pivot of the scalar equation, from the solution of K d = (−c, b, h):
/// κ/τ − qᵀd − (2/τ)(Px)ᵀdₓ + xᵀPx/τ².
#[inline(always)]
pub(crate) fn embedding_pivot<T: Real>(
    q: &[T],
    constant: &[T],
    cost_product: &[T],
    homogenizer: &[T],
    embed: &mut [T],
) {
    let tau_inv = embed[embedding::TAU_INV];
    let bend = dot(cost_product, &constant[..cost_product.len()]) * (tau_inv + tau_inv);
    embed[embedding::PIVOT] =
        ((homogenizer[1] * tau_inv) + embed[embedding::CURVATURE]) - (dot(q, constant) + bend);
}

/// dτ and dκ of the direction whose unknowns, for dτ = 0, are `step`.
#[inline(always)]
pub(crate) fn tau_step<T: Real>(
    q: &[T],
    step: &[T],
    cost_product: &[T],
    homogenizer: &[T],
    embed: &[T],
    center: &[T],
    out: &mut [T],
) {
    let tau_inv = embed[embedding::TAU_INV];
    let bend = dot(cost_product, &step[..cost_product.len()]) * (tau_inv + tau_inv);
    let complement = center[centering::COMPLEMENT];
    let known = (center[centering::DAMPING] * embed[embedding::RESIDUAL]).sub_mul(complement, tau_inv);
    let d_tau = (known + (dot(q, step) + bend)) / embed[embedding::PIVOT];
    out[0] = d_tau;
    out[1] = -(complement.add_mul(homogenizer[1], d_tau) * tau_inv);
}

/// The homogenizer's entry that is 0 before the first step was taken and 1 from then on.
pub(crate) const STEPPED: usize = 2;

/// σ from the predictor's step.
#[inline(always)]
fn sigma<T: Real>(step_length: T) -> T {
    let short = T::one() - step_length.min(T::one());
    short * short
}

/// σ = (1 − α)² from the predictor's step, and what follows from it for the corrector.
#[inline(always)]
pub(crate) fn centering<T: Real>(step_length: T, mu: T, homogenizer: &[T], tau_step: &[T], center: &mut [T]) {
    let affine = step_length.min(T::one());
    let sigma = sigma(step_length);
    let target = sigma * mu;
    center[centering::DAMPING] = T::one() - sigma;
    center[centering::TARGET] = target;
    // The starting point may be badly centred: there, the correction is damped by the affine step.
    let weight = affine.max(homogenizer[STEPPED]);
    center[centering::CORRECTION] = weight;
    center[centering::COMPLEMENT] =
        (homogenizer[0] * homogenizer[1]).add_mul(weight * tau_step[0], tau_step[1]) - target;
}

/// `out = λ∘λ + ω·ds∘dz − σμ·e`, the corrector's complementarity in the scaled space.
#[inline(always)]
pub(crate) fn cone_product<T: Real>(
    cones: &ConeLayout,
    lambda: &[T],
    scaled_s: &[T],
    scaled_z: &[T],
    center: &[T],
    out: &mut [T],
) {
    let (target, weight) = (center[centering::TARGET], center[centering::CORRECTION]);
    for i in 0..cones.l {
        out[i] = (lambda[i] * lambda[i]).add_mul(weight * scaled_s[i], scaled_z[i]) - target;
    }
    cones.each_soc(
        #[inline(always)]
        |rows, _| {
            let (l, ds, dz) = (&lambda[rows.clone()], &scaled_s[rows.clone()], &scaled_z[rows.clone()]);
            let out = &mut out[rows];
            out[0] = dot(l, l).add_mul(weight, dot(ds, dz)) - target;
            let twice = l[0] + l[0];
            for i in 1..l.len() {
                let mixed = (ds[0] * dz[i]).add_mul(dz[0], ds[i]);
                out[i] = (twice * l[i]).add_mul(weight, mixed);
            }
        },
    );
}

/// Refinement tolerance of the linear solves: a fraction of the residual that the step is to reduce, as the error adds
/// to it, and of no less than the floor, once divided by τ.
///
/// An error e also moves dτ by up to ‖(x, y, z)‖ e over the complementarity sᵀz + τκ. Where the point is more than a thousand
/// times as large as τ, on the way to a solution (κ below τ/1000), it may take no more than the same fraction of that.
#[inline(always)]
pub(crate) fn refinement_tolerance<T: Real>(
    residual: &[T],
    complementarity: T,
    (size_x, size_yz): (T, T),
    homogenizer: &[T],
    parameters: &[T],
) -> T {
    let fraction = parameters[parameter::REFINEMENT_SHARE];
    let (tau, kappa) = (homogenizer[0], homogenizer[1]);
    let tolerance = fraction * max_abs(residual).max(parameters[parameter::RESIDUAL_FLOOR] * tau);
    let size = size_x.max(size_yz);
    let far = (T::constant(1e3) * tau.max(T::constant(1e3) * kappa)).lt(size);
    T::select(far, tolerance.min(fraction * (complementarity / size)), tolerance)
}

/// How large x is, and (y, z).
#[inline(always)]
pub(crate) fn sizes<T: Real>(n: usize, point: &[T]) -> (T, T) {
    (max_abs(&point[..n]), max_abs(&point[n..]))
}

/// Fraction to the boundary of the corrector's step: `most` where the predictor promises a whole step, and less where it
/// promises a short one. Once the predictor promises fast convergence it is 1 − 10σ, and at most 1 − 1e-4.
#[inline(always)]
pub(crate) fn fraction_to_boundary<T: Real>(step_length: T, most: T) -> T {
    let short = T::one() - step_length.min(T::one());
    let left = (T::constant(10.0) * sigma(step_length)).max(T::constant(1e-4));
    (most - T::constant(0.05) * short).max(T::one() - left)
}

/// Regularisation as the settings have it, before there is a point.
#[inline(always)]
pub(crate) fn first_regularization<T: Real>(parameters: &[T], out: &mut [T]) {
    out[regularization::UP] = parameters[parameter::STATIC_REGULARIZATION];
    out[regularization::DOWN] = parameters[parameter::STATIC_REGULARIZATION];
    out[regularization::FLOOR] = parameters[parameter::PIVOT_FLOOR];
    out[regularization::REPLACEMENT] = parameters[parameter::DYNAMIC_REGULARIZATION];
}

/// Regularisation divided between positive and negative pivots so that what it adds to the rows of x, up·‖x‖,
/// and to those of y and z, down·‖(y, z)‖, is of one size, its geometric mean being the setting. `up` is never
/// the larger one: directions in which the cost is flat are what refinement mends last.
#[inline(always)]
pub(crate) fn balance_regularization<T: Real>((size_x, size_yz): (T, T), parameters: &[T], out: &mut [T]) {
    first_regularization(parameters, out);
    let level = parameters[parameter::STATIC_REGULARIZATION];
    let one = T::one();
    let tilt = (size_yz.max(one) / size_x.max(one)).min(one).max(T::constant(1e-6)).sqrt();
    out[regularization::UP] = level * tilt;
    out[regularization::DOWN] = level / tilt;
}

/// The length of the step taken: all of it, or `fraction` of the way to the boundary.
#[inline(always)]
pub(crate) fn step_taken<T: Real>(largest: T, fraction: T) -> T {
    T::one().min(fraction * largest)
}

/// `x += α·dx`.
#[inline(always)]
pub(crate) fn advance<T: Real>(alpha: T, step: &[T], x: &mut [T]) {
    for (entry, &step) in x.iter_mut().zip(step) {
        *entry = entry.add_mul(alpha, step);
    }
}

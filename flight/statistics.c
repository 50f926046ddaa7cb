/* Statistics: residuals and the numbers of termination, the embedding's scalar equation, centring,
 * cone product. Sums go through the fixed reduction tree; decisions.c decides on what comes of
 * them. */
#include "kernels.h"
#include "reduce.h"

/* out = P x, P symmetric and given by its upper triangle. */
static void symmetric_product(pattern_t pattern, const orbsoc_real *values, const orbsoc_real *x,
                              orbsoc_real *out) {
  for (size_t j = 0; j < pattern->n; j++) { out[j] = 0; }
  for (size_t j = 0; j < pattern->n; j++) {
    for (size_t k = pattern->cost.begins[j]; k < pattern->cost.begins[j + 1]; k++) {
      const size_t i = pattern->cost.rows[k];
      out[i] = out[i] + values[k] * x[j];
      if (i != j) {
        out[j] = out[j] + values[k] * x[i];
      }
    }
  }
}

/* by_rows = M x and by_columns = M' y in one pass over M. */
static void products_of(const orbsoc_matrix *matrix, size_t rows, size_t columns,
                        const orbsoc_real *restrict values, const orbsoc_real *restrict x,
                        const orbsoc_real *restrict y, orbsoc_real *restrict by_rows,
                        orbsoc_real *restrict by_columns) {
  for (size_t i = 0; i < rows; i++) { by_rows[i] = 0; }
  for (size_t j = 0; j < columns; j++) {
    const size_t begin = matrix->begins[j], count = matrix->begins[j + 1] - begin;
    const orbsoc_index *at = &matrix->rows[begin];
    if (adjacent(count, at) != 0) {
      const size_t first = at[0];
      by_columns[j] = dot(count, &values[begin], &y[first]);
      for (size_t k = 0; k < count; k++) {
        by_rows[first + k] = by_rows[first + k] + values[begin + k] * x[j];
      }
      continue;
    }
    by_columns[j] = dot_indexed(count, &values[begin], at, y);
    for (size_t k = 0; k < count; k++) {
      by_rows[at[k]] = by_rows[at[k]] + values[begin + k] * x[j];
    }
  }
}

/* Radius that a certificate of this value and residual size proves, over a scale. */
static orbsoc_real radius(orbsoc_real value, orbsoc_real size, orbsoc_real scale) {
  return larger(-value, 0) / (larger(size, real(1e-30)) * scale);
}

/* Weighted sizes of the products and residuals of an iterate. */
typedef struct {
  orbsoc_real ax, gx, px, aty, gtz, x, y, z, ray_rows, ray_cost, ray_cone, farkas;
} sizes_t;

/* Residuals of the embedding, and the sizes of products before they are overwritten by sums. */
static sizes_t residuals(pattern_t pattern, const orbsoc_iterate *at,
                         const orbsoc_statistics_out *out) {
  const size_t n = pattern->n, p = pattern->p, m = pattern->m;
  const orbsoc_real *x = at->point, *c = at->q, *rhs = &at->q[n];
  const orbsoc_real *by_x = at->scale_inverse, *by_y = &by_x[n], *by_z = &by_y[p];
  orbsoc_real *aty = out->products, *gtz = &aty[n], *ax = &gtz[n], *gx = &ax[p];
  orbsoc_real *px = out->cost_product, *residual = out->residual;
  const orbsoc_real tau = at->homogenizer[TAU];
  sizes_t size;
  symmetric_product(pattern, at->p, x, px);
  products_of(&pattern->equality, p, n, at->a, x, &x[n], ax, aty);
  products_of(&pattern->conic, m, n, at->g, x, &x[n + p], gx, gtz);
  size.ax = max_abs_weighted(p, by_y, ax);
  size.gx = max_abs_weighted(m, by_z, gx);
  size.px = max_abs_weighted(n, by_x, px);
  size.aty = max_abs_weighted(n, by_x, aty);
  size.gtz = max_abs_weighted(n, by_x, gtz);
  size.ray_rows = sum_abs_weighted(p, by_y, ax);
  size.ray_cost = sum_abs_weighted(n, by_x, px);
  for (size_t i = 0; i < n; i++) { aty[i] = aty[i] + gtz[i]; }
  for (size_t i = 0; i < m; i++) { gx[i] = gx[i] + at->slack[i]; }
  size.ray_cone = sum_abs_weighted(m, by_z, gx);
  size.farkas = sum_abs_weighted(n, by_x, aty);
  for (size_t i = 0; i < n; i++) { residual[i] = (px[i] + aty[i]) + tau * c[i]; }
  for (size_t i = 0; i < p + m; i++) { residual[n + i] = ax[i] - tau * rhs[i]; }
  size.x = max_abs_weighted(n, by_x, residual);
  size.y = max_abs_weighted(p, by_y, &residual[n]);
  size.z = max_abs_weighted(m, by_z, &residual[n + p]);
  return size;
}

/* The ratios that termination compares, from sizes and the values of costs. */
static void ratios(const orbsoc_iterate *at, sizes_t size, orbsoc_real curvature, orbsoc_real cost,
                   orbsoc_real support, orbsoc_real *stats) {
  const orbsoc_real half = real(0.5), tau_inv = 1 / at->homogenizer[TAU];
  const orbsoc_real norm_b = at->norms[NORM_B], norm_h = at->norms[NORM_H];
  const orbsoc_real norm_c = at->norms[NORM_C];
  const orbsoc_real gamma_inv = at->cost_scale[1], dual_by = gamma_inv * tau_inv;
  const orbsoc_real x = size.x * dual_by, y = size.y * tau_inv, z = size.z * tau_inv;
  const orbsoc_real equality = y / (1 + larger(norm_b, size.ax * tau_inv));
  const orbsoc_real conic = z / (1 + larger(norm_h, size.gx * tau_inv));
  const orbsoc_real dual_size =
      larger(norm_c, larger(larger(size.px, size.aty), size.gtz) * dual_by);
  const orbsoc_real objective = (half * curvature + cost * tau_inv) * gamma_inv;
  const orbsoc_real dual_objective = -((half * curvature + support * tau_inv) * gamma_inv);
  const orbsoc_real gap = magnitude(objective - dual_objective) /
                          (1 + smaller(magnitude(objective), magnitude(dual_objective)));
  const orbsoc_real plain_primal = larger(y, z) / (1 + larger(norm_b, norm_h));
  const orbsoc_real primal = larger(larger(equality, conic), plain_primal);
  const orbsoc_real dual = larger(x / (1 + dual_size), x / (1 + norm_c));
  stats[STAT_PRIMAL] = primal;
  stats[STAT_DUAL] = dual;
  stats[STAT_GAP] = gap;
  stats[STAT_STRICT] = larger(larger(primal, dual), gap);
  stats[STAT_OBJECTIVE] = objective;
  stats[STAT_DUAL_OBJECTIVE] = dual_objective;
  stats[STAT_PRIMAL_RADIUS] = radius(support, size.farkas, at->norms[PRIMAL_SCALE]);
  stats[STAT_DUAL_RADIUS] =
      radius(cost * gamma_inv, (size.ray_rows + size.ray_cone) + size.ray_cost * gamma_inv,
             at->norms[DUAL_SCALE]);
}

/* Refinement tolerance of the linear solves: a fraction of the residual that the step is to reduce;
 * far out on the way to a solution, no more than the same fraction of the complementarity over the
 * point's size. */
static orbsoc_real refinement_tolerance(size_t count, const orbsoc_real *residual,
                                        orbsoc_real complementarity, orbsoc_real size,
                                        const orbsoc_iterate *at) {
  const orbsoc_real fraction = at->parameters[REFINEMENT_SHARE], thousand = real(1e3);
  const orbsoc_real tau = at->homogenizer[TAU], kappa = at->homogenizer[KAPPA];
  const orbsoc_real tolerance =
      fraction * larger(max_abs(count, residual), at->parameters[RESIDUAL_FLOOR] * tau);
  const int far_out = thousand * larger(tau, thousand * kappa) < size;
  return far_out ? smaller(tolerance, fraction * (complementarity / size)) : tolerance;
}

/* Regularisation as the settings have it, before there is a point. */
void orbsoc_first_regularization(const orbsoc_real *parameters, orbsoc_real *out) {
  out[SHIFT_UP] = parameters[STATIC_REGULARIZATION];
  out[SHIFT_DOWN] = parameters[STATIC_REGULARIZATION];
  out[FLOOR] = parameters[PIVOT_FLOOR];
  out[REPLACEMENT] = parameters[DYNAMIC_REGULARIZATION];
}

/* Regularisation divided between positive and negative pivots so that what it adds to either rows
 * is of one size. */
static void balance_regularization(orbsoc_real size_x, orbsoc_real size_yz,
                                   const orbsoc_real *parameters, orbsoc_real *out) {
  const orbsoc_real level = parameters[STATIC_REGULARIZATION];
  const orbsoc_real quotient = larger(size_yz, 1) / larger(size_x, 1);
  const orbsoc_real tilt = ORBSOC_SQRT(larger(smaller(quotient, 1), real(1e-6)));
  orbsoc_first_regularization(parameters, out);
  out[SHIFT_UP] = level * tilt;
  out[SHIFT_DOWN] = level / tilt;
}

void orbsoc_statistics(pattern_t pattern, const orbsoc_iterate *at,
                       const orbsoc_statistics_out *out) {
  const size_t n = pattern->n, p = pattern->p, m = pattern->m;
  const orbsoc_real *x = at->point, *yz = &x[n], *z = &yz[p];
  const orbsoc_real tau = at->homogenizer[TAU], kappa = at->homogenizer[KAPPA];
  const sizes_t size = residuals(pattern, at, out);
  const orbsoc_real cost = dot(n, at->q, x), support = dot(p + m, &at->q[n], yz);
  const orbsoc_real tau_inv = 1 / tau;
  const orbsoc_real curvature = (dot(n, x, out->cost_product) * tau_inv) * tau_inv;
  const orbsoc_real degree = real((double)degree_of(pattern) + 1.0);
  const orbsoc_real mu = (dot(m, at->slack, z) + tau * kappa) / degree;
  out->embedding[EMBEDDING_RESIDUAL] = ((kappa + cost) + support) + curvature * tau;
  out->embedding[TAU_INV] = tau_inv;
  out->embedding[CURVATURE] = curvature;
  out->centering[DAMPING] = 1;
  out->centering[TARGET] = 0;
  out->centering[COMPLEMENT] = kappa * tau;
  out->centering[CORRECTION] = 1;
  ratios(at, size, curvature, cost, support, out->statistics);
  out->statistics[STAT_MU] = mu;
  out->statistics[STAT_NON_FINITE] =
      non_finite_strided(n + p + m, at->point, 1) +
      (non_finite_strided(m, at->slack, 1) +
       non_finite_strided(HOMOGENIZER_WORDS, at->homogenizer, 1));
  const orbsoc_real size_x = max_abs(n, x), size_yz = max_abs(p + m, yz);
  out->refinement_tolerance[0] = refinement_tolerance(n + p + m, out->residual, mu * degree,
                                                      larger(size_x, size_yz), at);
  balance_regularization(size_x, size_yz, at->parameters, out->regularization);
}

/* Pivot of the scalar equation, from the solution of K d = (-c, b, h). */
void orbsoc_embedding_pivot(pattern_t pattern, const orbsoc_real *q, const orbsoc_real *constant,
                            const orbsoc_real *cost_product, const orbsoc_real *homogenizer,
                            orbsoc_real *embedding) {
  const orbsoc_real tau_inv = embedding[TAU_INV];
  const orbsoc_real bend = dot(pattern->n, cost_product, constant) * (tau_inv + tau_inv);
  embedding[EMBEDDING_PIVOT_WORD] = ((homogenizer[KAPPA] * tau_inv) + embedding[CURVATURE]) -
                                    (dot(unknowns_of(pattern), q, constant) + bend);
}

/* dtau and dkappa of the direction whose unknowns, for dtau = 0, are `step`. */
void orbsoc_tau_step(pattern_t pattern, const orbsoc_real *q, const orbsoc_real *step,
                     const orbsoc_real *cost_product, const orbsoc_real *homogenizer,
                     const orbsoc_real *embedding, const orbsoc_real *centering,
                     orbsoc_real *tau_step) {
  const orbsoc_real tau_inv = embedding[TAU_INV], complement = centering[COMPLEMENT];
  const orbsoc_real bend = dot(pattern->n, cost_product, step) * (tau_inv + tau_inv);
  const orbsoc_real known =
      centering[DAMPING] * embedding[EMBEDDING_RESIDUAL] - complement * tau_inv;
  const orbsoc_real d_tau =
      (known + (dot(unknowns_of(pattern), q, step) + bend)) / embedding[EMBEDDING_PIVOT_WORD];
  tau_step[0] = d_tau;
  tau_step[1] = -((complement + homogenizer[KAPPA] * d_tau) * tau_inv);
}

/* sigma = (1 - a)^2 from the predictor's step, what follows from it for the corrector, and the
 * fraction of the way to the boundary that its step may go: `most` where the predictor promises a
 * whole step. */
void orbsoc_centering(orbsoc_real step_length, orbsoc_real mu, const orbsoc_real *homogenizer,
                      const orbsoc_real *tau_step, orbsoc_real most, orbsoc_real *centering,
                      orbsoc_real *boundary_fraction) {
  const orbsoc_real affine = smaller(step_length, 1), missing = 1 - affine;
  const orbsoc_real sigma = missing * missing, target = sigma * mu;
  const orbsoc_real weight = larger(affine, homogenizer[STEPPED]);
  const orbsoc_real left = larger(10 * sigma, real(1e-4));
  centering[DAMPING] = 1 - sigma;
  centering[TARGET] = target;
  centering[CORRECTION] = weight;
  centering[COMPLEMENT] = (homogenizer[TAU] * homogenizer[KAPPA] +
                           (weight * tau_step[0]) * tau_step[1]) - target;
  boundary_fraction[0] = larger(most - real(0.05) * missing, 1 - left);
}

/* out = lambda o lambda + weight ds o dz - sigma mu e, in the scaled space. */
void orbsoc_cone_product(pattern_t pattern, const orbsoc_real *lambda,
                         const orbsoc_real *scaled_s, const orbsoc_real *scaled_z,
                         const orbsoc_real *centering, orbsoc_real *out) {
  const orbsoc_real target = centering[TARGET], weight = centering[CORRECTION];
  for (size_t i = 0; i < pattern->l; i++) {
    out[i] = (lambda[i] * lambda[i] + (weight * scaled_s[i]) * scaled_z[i]) - target;
  }
  size_t at = pattern->l;
  for (size_t k = 0; k < pattern->cones; k++) {
    const size_t dim = pattern->cone_dims[k];
    const orbsoc_real *l = &lambda[at], *ds = &scaled_s[at], *dz = &scaled_z[at];
    const orbsoc_real twice = l[0] + l[0];
    out[at] = (dot(dim, l, l) + weight * dot(dim, ds, dz)) - target;
    for (size_t i = 1; i < dim; i++) {
      out[at + i] = twice * l[i] + weight * (ds[0] * dz[i] + dz[0] * ds[i]);
    }
    at += dim;
  }
}

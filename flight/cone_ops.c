/* Cone operations: Nesterov-Todd scaling and what is done with it.
 *
 * Nonnegative rows: w = sqrt(s/z), lambda = sqrt(s z). Second-order cones: W = eta P(w) with w0^2 -
 * |w1|^2 = 1, W^-1 s = W z = lambda, and res(v) = (v0 - |v1|)(v0 + |v1|), factored to avoid
 * cancellation. */
#include "kernels.h"
#include "reduce.h"

/* sqrt(res(v)), kept away from zero: on the boundary rounding may make it vanish. */
static orbsoc_real residual_root(size_t dim, const orbsoc_real *v) {
  const orbsoc_real tail = norm2(dim - 1, &v[1]), least = real(1e-30);
  return ORBSOC_SQRT(larger(v[0] - tail, least * v[0])) * ORBSOC_SQRT(v[0] + tail);
}

/* One second-order cone: three divisions and ten roots, three of either residual's. */
static void nt_scaling_cone(size_t dim, const orbsoc_real *s, const orbsoc_real *z, orbsoc_real *w,
                            orbsoc_real *lambda, orbsoc_real *scalars) {
  const orbsoc_real res_s = residual_root(dim, s), res_z = residual_root(dim, z);
  const orbsoc_real res_lambda_inv = 1 / (res_s * res_z);
  orbsoc_real s_by = res_z * res_lambda_inv, z_by = res_s * res_lambda_inv;
  const orbsoc_real s0 = s[0] * s_by, z0 = z[0] * z_by;
  const orbsoc_real cosine = (dot(dim - 1, &s[1], &z[1]) * s_by) * z_by;
  const orbsoc_real gamma = ORBSOC_SQRT(real(0.5) * ((1 + s0 * z0) + cosine));
  const orbsoc_real two_gamma = gamma + gamma;
  const orbsoc_real head_sum = (s0 + z0) + two_gamma;
  orbsoc_real pair = 1 / (two_gamma * head_sum);
  const orbsoc_real w_by = pair * head_sum, lambda_by = pair * two_gamma;

  const orbsoc_real root_inv = ORBSOC_SQRT(res_lambda_inv);
  const orbsoc_real root = (res_s * res_z) * root_inv;
  const orbsoc_real from_s = ((gamma + z0) * lambda_by) * (s_by * root);
  const orbsoc_real from_z = ((gamma + s0) * lambda_by) * (z_by * root);
  lambda[0] = gamma * root;
  s_by = s_by * w_by;
  z_by = z_by * w_by;
  for (size_t i = 1; i < dim; i++) {
    lambda[i] = from_s * s[i] + from_z * z[i];
    w[i] = s_by * s[i] - z_by * z[i];
  }
  w[0] = ORBSOC_SQRT(1 + dot(dim - 1, &w[1], &w[1]));

  const orbsoc_real one_plus_w0 = 1 + w[0], one_plus_gamma = 1 + gamma;
  pair = 1 / (one_plus_w0 * one_plus_gamma);
  const orbsoc_real eta_sq = (res_s * res_s) * res_lambda_inv;
  const orbsoc_real eta = ORBSOC_SQRT(eta_sq);
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

/* Scaling point of (s, z). */
void orbsoc_nt_scaling(pattern_t pattern, const orbsoc_real *s, const orbsoc_real *z,
                       const orbsoc_scaling *out) {
  for (size_t i = 0; i < pattern->l; i++) {
    const orbsoc_real product = s[i] * z[i];
    const orbsoc_real root_inverse = ORBSOC_SQRT(1 / product);
    out->lambda[i] = product * root_inverse;
    out->lambda_inverse[i] = root_inverse;
    out->w[i] = s[i] * root_inverse;
  }
  size_t at = pattern->l;
  for (size_t k = 0; k < pattern->cones; k++) {
    const size_t dim = pattern->cone_dims[k];
    nt_scaling_cone(dim, &s[at], &z[at], &out->w[at], &out->lambda[at],
                    &out->cone[k * CONE_SCALARS]);
    at += dim;
  }
}

/* out = W x. */
void orbsoc_scale(pattern_t pattern, const orbsoc_real *w, const orbsoc_real *cone,
                  const orbsoc_real *x, orbsoc_real *out) {
  for (size_t i = 0; i < pattern->l; i++) { out[i] = w[i] * x[i]; }
  size_t at = pattern->l;
  for (size_t k = 0; k < pattern->cones; k++) {
    const size_t dim = pattern->cone_dims[k];
    const orbsoc_real *wk = &w[at], *xk = &x[at], *scalars = &cone[k * CONE_SCALARS];
    const orbsoc_real eta = scalars[ETA], zeta = dot(dim - 1, &wk[1], &xk[1]);
    out[at] = eta * (zeta + wk[0] * xk[0]);
    const orbsoc_real along = xk[0] + zeta * scalars[INV_ONE_PLUS_W0];
    for (size_t i = 1; i < dim; i++) { out[at + i] = eta * (xk[i] + along * wk[i]); }
    at += dim;
  }
}

/* out = lambda \ d, the Jordan quotient: lambda o out = d. */
void orbsoc_cone_divide(pattern_t pattern, const orbsoc_scaling *at, const orbsoc_real *d,
                        orbsoc_real *out) {
  for (size_t i = 0; i < pattern->l; i++) { out[i] = at->lambda_inverse[i] * d[i]; }
  size_t row = pattern->l;
  for (size_t k = 0; k < pattern->cones; k++) {
    const size_t dim = pattern->cone_dims[k];
    const orbsoc_real *lambda = &at->lambda[row], *dk = &d[row];
    const orbsoc_real *scalars = &at->cone[k * CONE_SCALARS];
    const orbsoc_real head =
        (lambda[0] * dk[0] - dot(dim - 1, &lambda[1], &dk[1])) * scalars[LAMBDA_RES_INV];
    out[row] = head;
    for (size_t i = 1; i < dim; i++) {
      out[row + i] = (dk[i] - head * lambda[i]) * scalars[LAMBDA_HEAD_INV];
    }
    row += dim;
  }
}

/* direction <- direction + step other. */
void orbsoc_add_scaled(size_t count, orbsoc_real step, const orbsoc_real *other,
                       orbsoc_real *direction) {
  for (size_t i = 0; i < count; i++) { direction[i] = direction[i] + step * other[i]; }
}

/* Shift v along the cone's identity until its distance to the boundary is at least 1 and at least a
 * tenth of the mean positive distance. */
void orbsoc_shift_into_cone(pattern_t pattern, orbsoc_real *v) {
  if (degree_of(pattern) == 0u) {
    return;
  }
  orbsoc_real least = real((double)FLT_MAX), positive = 0;
  for (size_t i = 0; i < pattern->l; i++) {
    least = smaller(least, v[i]);
    positive = positive + larger(v[i], 0);
  }
  size_t at = pattern->l;
  for (size_t k = 0; k < pattern->cones; k++) {
    const size_t dim = pattern->cone_dims[k];
    const orbsoc_real margin = v[at] - norm2(dim - 1, &v[at + 1]);
    least = smaller(least, margin);
    positive = positive + larger(margin, 0);
    at += dim;
  }
  const orbsoc_real target = larger(1, positive * real(0.1 / (double)degree_of(pattern)));
  const orbsoc_real shift = larger(target - least, 0);
  for (size_t i = 0; i < pattern->l; i++) { v[i] = v[i] + shift; }
  at = pattern->l;
  for (size_t k = 0; k < pattern->cones; k++) {
    v[at] = v[at] + shift;
    at += pattern->cone_dims[k];
  }
}

/* (-c, b, h) and the predictor's: minus the residual, with s added in the rows of z. */
void orbsoc_predictor_rhs(pattern_t pattern, const orbsoc_real *q, const orbsoc_real *residual,
                          const orbsoc_real *slack, orbsoc_real *rhs) {
  const size_t n = pattern->n, rows = n + pattern->p, all = unknowns_of(pattern);
  for (size_t i = all; i < pattern->dim; i++) {
    rhs[2u * (size_t)pattern->position[i]] = 0;
    rhs[2u * (size_t)pattern->position[i] + 1] = 0;
  }
  for (size_t i = 0; i < all; i++) {
    orbsoc_real *to = &rhs[2u * (size_t)pattern->position[i]];
    to[0] = (i < n) ? -q[i] : q[i];
    to[1] = (i < rows) ? -residual[i] : slack[i - rows] - residual[i];
  }
}

/* The corrector's: minus the damped residual, and W(lambda \ d) added in the rows of z. */
void orbsoc_corrector_rhs(pattern_t pattern, orbsoc_real damping, const orbsoc_real *residual,
                          const orbsoc_real *lifted, orbsoc_real *rhs) {
  const size_t rows = (size_t)pattern->n + pattern->p, all = unknowns_of(pattern);
  for (size_t i = all; i < pattern->dim; i++) { rhs[pattern->position[i]] = 0; }
  for (size_t i = 0; i < rows; i++) { rhs[pattern->position[i]] = -(damping * residual[i]); }
  for (size_t i = rows; i < all; i++) {
    rhs[pattern->position[i]] = lifted[i - rows] - damping * residual[i];
  }
}

/* ---- the pair on the central path that is nearest to a given one ---- */

/* For v >= 0: (v + sqrt(v^2 + 4 mu))/2, mu over it, and the root. */
typedef struct {
  orbsoc_real large, small, root;
} roots_t;

static roots_t roots_of(orbsoc_real v, orbsoc_real mu, orbsoc_real four_mu) {
  roots_t out;
  out.root = ORBSOC_SQRT(four_mu + v * v);
  out.large = real(0.5) * (v + out.root);
  out.small = mu / out.large;
  return out;
}

static void central_pair_cone(size_t dim, orbsoc_real mu, orbsoc_real four_mu, orbsoc_real *s,
                              orbsoc_real *z) {
  const orbsoc_real half = real(0.5);
  for (size_t i = 0; i < dim; i++) { s[i] = s[i] - z[i]; }
  const orbsoc_real head = magnitude(s[0]), tail = norm2(dim - 1, &s[1]);
  const int negative = s[0] < 0;
  const roots_t outer = roots_of(head + tail, mu, four_mu);
  const orbsoc_real inside = head - tail;
  const roots_t inner = roots_of(magnitude(inside), mu, four_mu);
  const orbsoc_real f_inner = (inside < 0) ? inner.small : inner.large;
  const orbsoc_real g_inner = (inside < 0) ? inner.large : inner.small;
  const orbsoc_real slope = half + head / (outer.root + inner.root);
  const orbsoc_real slope_inverse = slope * (g_inner / outer.large);
  const orbsoc_real f_head = half * (outer.large + f_inner);
  const orbsoc_real g_head = half * (outer.small + g_inner);
  const orbsoc_real s_by = negative ? slope_inverse : slope;
  const orbsoc_real z_by = -(negative ? slope : slope_inverse);
  s[0] = negative ? g_head : f_head;
  z[0] = negative ? f_head : g_head;
  for (size_t i = 1; i < dim; i++) {
    const orbsoc_real v = s[i];
    s[i] = s_by * v;
    z[i] = z_by * v;
  }
}

/* Replace (s, z) by the pair with the same difference and s o z = mu e. */
void orbsoc_central_pair(pattern_t pattern, orbsoc_real mu, orbsoc_real *s, orbsoc_real *z) {
  const orbsoc_real four_mu = 4 * mu;
  for (size_t i = 0; i < pattern->l; i++) {
    const orbsoc_real v = s[i] - z[i];
    const roots_t roots = roots_of(magnitude(v), mu, four_mu);
    s[i] = (v < 0) ? roots.small : roots.large;
    z[i] = (v < 0) ? roots.large : roots.small;
  }
  size_t at = pattern->l;
  for (size_t k = 0; k < pattern->cones; k++) {
    central_pair_cone(pattern->cone_dims[k], mu, four_mu, &s[at], &z[at]);
    at += pattern->cone_dims[k];
  }
}

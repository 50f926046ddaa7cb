/* Matrix scaling: Ruiz equilibration of the problem data, and its undoing.
 *
 * P^ = gamma D P D, A^ = E A D, G^ = F G D, c^ = gamma D c, b^ = E b, h^ = F h with diagonal D, E,
 * F and one factor a second-order cone, so that every row and column of the KKT matrix has maximum
 * entry about one. */
#include "kernels.h"
#include "reduce.h"

/* No cost becomes smaller than this that is not smaller already; one below NO_COST of the largest
 * is rounding. */
#define LEAST_COST 1e-3
#define NO_COST 1e-12

/* A number as given; zero where it is subnormal, for its inverse would be infinite. */
static orbsoc_real loaded(double value) {
  return (value != 0.0 && fabs(value) < DBL_MIN) ? 0 : real(value);
}

/* One where a norm vanishes, the norm elsewhere. */
static orbsoc_real nonzero(orbsoc_real norm) { return (0 < norm) ? norm : 1; }

/* Raise each row's and column's norm to the entries of a matrix whose rows begin at row0. */
static void raise_norms(const orbsoc_matrix *matrix, size_t columns, const orbsoc_real *values,
                        size_t row0, orbsoc_real *norms) {
  for (size_t j = 0; j < columns; j++) {
    const size_t begin = matrix->begins[j], count = matrix->begins[j + 1] - begin;
    orbsoc_real top = 0;
    if (adjacent(count, &matrix->rows[begin]) != 0) {
      orbsoc_real *norm = &norms[row0 + matrix->rows[begin]];
      for (size_t k = 0; k < count; k++) {
        norm[k] = larger(norm[k], magnitude(values[begin + k]));
      }
      norms[j] = larger(norms[j], max_abs(count, &values[begin]));
      continue;
    }
    for (size_t k = begin; k < begin + count; k++) {
      orbsoc_real *norm = &norms[row0 + matrix->rows[k]];
      const orbsoc_real size = magnitude(values[k]);
      *norm = larger(*norm, size);
      top = larger(top, size);
    }
    norms[j] = larger(norms[j], top);
  }
}

/* Multiply each entry by its row's and column's factor. */
static void multiply(const orbsoc_matrix *matrix, size_t columns,
                     const orbsoc_real *restrict factors, size_t row0,
                     orbsoc_real *restrict values) {
  for (size_t j = 0; j < columns; j++) {
    const orbsoc_real factor = factors[j];
    const size_t begin = matrix->begins[j], count = matrix->begins[j + 1] - begin;
    if (adjacent(count, &matrix->rows[begin]) != 0) {
      const orbsoc_real *row = &factors[row0 + matrix->rows[begin]];
      for (size_t k = 0; k < count; k++) {
        values[begin + k] = values[begin + k] * (row[k] * factor);
      }
      continue;
    }
    for (size_t k = begin; k < begin + count; k++) {
      values[k] = values[k] * (factors[row0 + matrix->rows[k]] * factor);
    }
  }
}

/* gamma, which makes the largest entry of the scaled P and c one, within LEAST_COST. */
static orbsoc_real cost_factor(size_t n, const orbsoc_real *c, size_t nnz, const orbsoc_real *p) {
  const orbsoc_real most = nonzero(larger(max_abs(n, c), max_abs(nnz, p)));
  const orbsoc_real least = min_abs_above(n, c, real(NO_COST) * most, most);
  return larger(1 / most, real(LEAST_COST) / larger(least, 1));
}

/* Values as given, in another order where `origin` is no null pointer. */
ORBSOC_SHARED void load_values(const double *values, const orbsoc_index *origin, size_t count,
                               orbsoc_real *out) {
  for (size_t k = 0; k < count; k++) {
    out[k] = loaded(values[(origin != NULL) ? origin[k] : k]);
  }
}

static void load_matrices(pattern_t pattern, const orbsoc_numbers *given,
                          const orbsoc_scaled *out) {
  load_values(given->p, NULL, pattern->nnz_p, out->p);
  load_values(given->a, NULL, pattern->nnz_a, out->a);
  load_values(given->g, pattern->g_origin, pattern->nnz_g, out->g);
}

static void load_vectors(pattern_t pattern, const orbsoc_numbers *given, orbsoc_real *q) {
  const size_t n = pattern->n, p = pattern->p;
  load_values(given->c, NULL, n, q);
  load_values(given->b, NULL, p, &q[n]);
  load_values(given->h, pattern->row_origin, pattern->m, &q[n + p]);
}

/* The data as they are before equilibration, in the buffers that it writes. */
void orbsoc_load_given(const orbsoc_solver *solver) {
  orbsoc_real *const *b = solver->buffer;
  const orbsoc_scaled out = {b[ORBSOC_P], b[ORBSOC_A], b[ORBSOC_G], b[ORBSOC_Q], NULL, NULL, NULL};
  load_matrices(solver->pattern, &solver->numbers, &out);
  load_vectors(solver->pattern, &solver->numbers, out.q);
}

/* All rows of a second-order cone have its largest norm. */
static void join_cones(pattern_t pattern, orbsoc_real *norms) {
  size_t start = (size_t)pattern->n + pattern->p + pattern->l;
  for (size_t k = 0; k < pattern->cones; k++) {
    const size_t dim = pattern->cone_dims[k];
    const orbsoc_real top = max_abs(dim, &norms[start]);
    for (size_t i = 0; i < dim; i++) { norms[start + i] = top; }
    start += dim;
  }
}

void orbsoc_equilibrate(pattern_t pattern, const orbsoc_numbers *given, uint32_t passes,
                        const orbsoc_scaled *out, orbsoc_real *norms) {
  const size_t n = pattern->n, rows = n + pattern->p, all = unknowns_of(pattern);
  load_matrices(pattern, given, out);
  for (size_t i = 0; i < all; i++) { out->scale[i] = 1; }
  for (uint32_t pass = 0; pass < passes; pass++) {
    for (size_t i = 0; i < all; i++) { norms[i] = 0; }
    raise_norms(&pattern->cost, n, out->p, 0, norms);
    raise_norms(&pattern->equality, n, out->a, n, norms);
    raise_norms(&pattern->conic, n, out->g, rows, norms);
    join_cones(pattern, norms);
    for (size_t i = 0; i < all; i++) {
      norms[i] = 1 / ORBSOC_SQRT(nonzero(norms[i]));
      out->scale[i] = out->scale[i] * norms[i];
    }
    multiply(&pattern->cost, n, norms, 0, out->p);
    multiply(&pattern->equality, n, norms, n, out->a);
    multiply(&pattern->conic, n, norms, rows, out->g);
  }
  for (size_t i = 0; i < all; i++) { out->scale_inverse[i] = 1 / out->scale[i]; }
  orbsoc_rescale(pattern, given, out);
}

/* (c, b, h) beside matrices that are equilibrated, and P by the cost's factor. */
void orbsoc_rescale(pattern_t pattern, const orbsoc_numbers *given, const orbsoc_scaled *out) {
  const size_t n = pattern->n, all = unknowns_of(pattern);
  load_vectors(pattern, given, out->q);
  for (size_t i = 0; i < all; i++) { out->q[i] = out->q[i] * out->scale[i]; }
  const orbsoc_real gamma = cost_factor(n, out->q, pattern->nnz_p, out->p);
  for (size_t k = 0; k < pattern->nnz_p; k++) { out->p[k] = out->p[k] * gamma; }
  for (size_t i = 0; i < n; i++) { out->q[i] = out->q[i] * gamma; }
  out->cost_scale[0] = gamma;
  out->cost_scale[1] = 1 / gamma;
}

/* How many times farther than a row lets an unknown be the data's scale may reach, or how many
 * times less far; and the smallest share of it that is left. */
#define SCALE_RANGE 100.0
#define SCALE_SHARE 1e-4

/* Smallest and largest magnitude of entries; those that are no normal number count as zero. */
typedef struct {
  double least, most;
} entries_t;

/* Add values to a range, in another order where `origin` is no null pointer, and return their
 * largest magnitude. */
ORBSOC_SHARED double add_entries(const double *values, const orbsoc_index *origin, size_t count,
                                 entries_t *range) {
  double top = 0.0;
  for (size_t k = 0; k < count; k++) {
    const double size = fabs(values[(origin != NULL) ? origin[k] : k]);
    top = (size > top) ? size : top;
    if (size >= DBL_MIN && size < range->least) { range->least = size; }
  }
  range->most = (top >= DBL_MIN && top > range->most) ? top : range->most;
  return top;
}

/* What the iteration compares a radius with, where `side` is the largest right-hand side: at least
 * one, but in units far from one near what a row's right-hand side leaves an unknown. */
ORBSOC_SHARED double radius_scale(double side, const entries_t *entries) {
  double scale = (side > 1.0) ? side : 1.0;
  if (side > 0.0 && entries->most > 0.0) {
    const double nearest = side / entries->most / SCALE_RANGE;
    double farthest = side / entries->least * SCALE_RANGE;
    farthest = (farthest > SCALE_SHARE * scale) ? farthest : SCALE_SHARE * scale;
    scale = (nearest > scale) ? nearest : scale;
    scale = (farthest < scale) ? farthest : scale;
  }
  return scale;
}

void orbsoc_norms(pattern_t pattern, const orbsoc_numbers *given, orbsoc_real *norms) {
  entries_t sides = {INFINITY, 0.0}, entries = sides;
  const double b = add_entries(given->b, NULL, pattern->p, &sides);
  const double h = add_entries(given->h, pattern->row_origin, pattern->m, &sides);
  const double c = add_entries(given->c, NULL, pattern->n, &sides);
  norms[NORM_B] = real(b);
  norms[NORM_H] = real(h);
  norms[NORM_C] = real(c);
  (void)add_entries(given->a, NULL, pattern->nnz_a, &entries);
  (void)add_entries(given->g, pattern->g_origin, pattern->nnz_g, &entries);
  norms[PRIMAL_SCALE] = real(radius_scale((b > h) ? b : h, &entries));
  (void)add_entries(given->p, NULL, pattern->nnz_p, &entries);
  norms[DUAL_SCALE] = real(radius_scale(c, &entries));
}

/* The user's point in the scaling of the new data: x^ = x/D, (y^, z^) = gamma (y, z)/(E, F), s^ = F
 * s. */
void orbsoc_load_start(pattern_t pattern, const orbsoc_real *start, const orbsoc_scaled *scales,
                       orbsoc_real *point, orbsoc_real *slack, orbsoc_real *homogenizer) {
  const size_t n = pattern->n, rows = n + pattern->p, all = unknowns_of(pattern);
  for (size_t i = 0; i < all; i++) {
    const orbsoc_real scaled = start[i] * scales->scale_inverse[i];
    point[i] = (i < n) ? scaled : scaled * scales->cost_scale[0];
  }
  for (size_t i = 0; i < pattern->m; i++) { slack[i] = start[all + i] * scales->scale[rows + i]; }
  homogenizer[TAU] = 1;
  homogenizer[KAPPA] = 0;
  homogenizer[STEPPED] = 0;
}

/* The user's (x, y, z) from a scaled point: x = D x^/tau, (y, z) = (E, F) y^/(gamma tau). */
void orbsoc_undo(pattern_t pattern, const orbsoc_scaled *scales, const orbsoc_real *point,
                 orbsoc_real tau, orbsoc_real *out) {
  const orbsoc_real primal = 1 / tau;
  const orbsoc_real dual = scales->cost_scale[1] * primal;
  const size_t all = unknowns_of(pattern);
  for (size_t i = 0; i < all; i++) {
    out[i] = (point[i] * scales->scale[i]) * ((i < pattern->n) ? primal : dual);
  }
}

/* The user's s = s^/(F tau). */
void orbsoc_undo_slack(pattern_t pattern, const orbsoc_scaled *scales, const orbsoc_real *slack,
                       orbsoc_real tau, orbsoc_real *out) {
  const orbsoc_real primal = 1 / tau;
  const orbsoc_real *inverse = &scales->scale_inverse[(size_t)pattern->n + pattern->p];
  for (size_t i = 0; i < pattern->m; i++) { out[i] = (slack[i] * inverse[i]) * primal; }
}

/* The residuals behind a status, recomputed on the user's own data after the fact, always in
 * binary64. Nothing here is shared with the iteration: other products, other sums, the matrices as
 * given. */
#include "kernels.h"

/* A certificate with at least this radius, over the data's scale or over its own, is accepted at
 * the end of a solve. */
#define RADIUS_CLAIMED 50.0
/* How many times `tol` the common formula's ratio of a solution may be: its denominators leave out
 * products. */
#define INDEPENDENT_FACTOR 100.0
#define SCALE_RANGE 100.0
#define SUMS 8u

typedef struct {
  double primal, dual, gap, independent, objective, dual_objective;
} residuals_t;

/* A certificate of infeasibility on the user's data. */
typedef struct {
  orbsoc_status status;
  double radius, relative, own; /* the others over the data's scale, and over its own */
} proof_t;

/* (x, y, z, s) in the user's units and rows. */
typedef struct {
  double *x, *y, *z, *s;
} point_t;

/* The larger; NaN on either side is dropped. */
ORBSOC_SHARED double most(double a, double b) { return (a < b || a != a) ? b : a; }
static double least(double a, double b) { return (b < a || a != a) ? b : a; }
static int is_finite(double a) { return a - a == 0.0; }

static double deterministic_bound(size_t terms) {
  return 2.0 * DBL_EPSILON * (double)(terms + 2u);
}

static double probabilistic_bound(double terms) {
  return 2.0 * DBL_EPSILON * (sqrt(terms) + 2.0);
}

/* ---- sums and norms ---- */

/* a'b: eight sums side by side. */
ORBSOC_SHARED double dot_of(size_t count, const double *a, const double *b) {
  double way[SUMS] = {0.0}, sum = 0.0;
  size_t k = 0;
  for (; k + SUMS <= count; k += SUMS) {
    for (size_t v = 0; v < SUMS; v++) { way[v] += a[k + v] * b[k + v]; }
  }
  for (size_t v = 0; v < SUMS / 2u; v++) { sum += way[v] + way[v + SUMS / 2u]; }
  for (; k < count; k++) { sum += a[k] * b[k]; }
  return sum;
}

/* Sum of |a_k|; with b, of |a_k b_k|. */
ORBSOC_SHARED double size_of(size_t count, const double *a, const double *b) {
  double way[SUMS] = {0.0}, sum = 0.0, rest = 0.0;
  size_t k = 0;
  for (; k + SUMS <= count; k += SUMS) {
    for (size_t v = 0; v < SUMS; v++) {
      way[v] += fabs((b == NULL) ? a[k + v] : a[k + v] * b[k + v]);
    }
  }
  for (size_t v = 0; v < SUMS; v++) { sum += way[v]; }
  for (; k < count; k++) { rest += fabs((b == NULL) ? a[k] : a[k] * b[k]); }
  return sum + rest;
}

/* The sum of magnitudes, one after the other. */
ORBSOC_SHARED double one_norm(size_t count, const double *a) {
  double sum = 0.0;
  for (size_t k = 0; k < count; k++) { sum += fabs(a[k]); }
  return sum;
}

/* The largest magnitude; infinite when an entry is not finite, zero when there is none. */
ORBSOC_SHARED double norm_of(size_t count, const double *a) {
  double top = 0.0, zero = 0.0;
  for (size_t k = 0; k < count; k++) {
    top = (top < fabs(a[k])) ? fabs(a[k]) : top;
    zero += a[k] * 0.0;
  }
  return (zero == 0.0) ? top : (double)INFINITY;
}

/* The largest magnitude, NaN left out. */
ORBSOC_SHARED double peak_of(size_t count, const double *a, double top) {
  for (size_t k = 0; k < count; k++) { top = most(top, fabs(a[k])); }
  return top;
}

/* v of rows that are present, zero elsewhere. */
ORBSOC_SHARED void present(pattern_t pattern, const double *v, double *out) {
  for (size_t i = 0; i < pattern->given_m; i++) {
    out[i] = (pattern->absent[i] == 0u) ? v[i] : 0.0;
  }
}

/* ---- products ---- */

/* Sum of values_k y[row_k], four sums side by side. */
static double column_dot(size_t count, const double *values, const orbsoc_index *rows,
                         const double *y) {
  double four[4] = {0.0, 0.0, 0.0, 0.0}, rest = 0.0;
  size_t k = 0;
  for (; k + 4u <= count; k += 4u) {
    for (size_t v = 0; v < 4u; v++) { four[v] += values[k + v] * y[rows[k + v]]; }
  }
  for (; k < count; k++) { rest += values[k] * y[rows[k]]; }
  return rest + ((four[0] + four[2]) + (four[1] + four[3]));
}

/* M'y. */
ORBSOC_SHARED void transposed_product(const orbsoc_matrix *matrix, size_t columns,
                                      const double *values, const double *y, double *out) {
  for (size_t j = 0; j < columns; j++) {
    const size_t begin = matrix->begins[j];
    out[j] = column_dot(matrix->begins[j + 1] - begin, &values[begin], &matrix->rows[begin], y);
  }
}

/* M x. */
ORBSOC_SHARED void product(const orbsoc_matrix *matrix, size_t rows, size_t columns,
                           const double *values, const double *x, double *out) {
  for (size_t i = 0; i < rows; i++) { out[i] = 0.0; }
  for (size_t j = 0; j < columns; j++) {
    for (size_t k = matrix->begins[j]; k < matrix->begins[j + 1]; k++) {
      out[matrix->rows[k]] += values[k] * x[j];
    }
  }
}

/* P x, from P's upper triangle. */
ORBSOC_SHARED void symmetric_product(pattern_t pattern, const double *values, const double *x,
                              double *out) {
  for (size_t j = 0; j < pattern->n; j++) { out[j] = 0.0; }
  for (size_t j = 0; j < pattern->n; j++) {
    for (size_t k = pattern->cost.begins[j]; k < pattern->cost.begins[j + 1]; k++) {
      const size_t i = pattern->cost.rows[k];
      out[i] += values[k] * x[j];
      if (i != j) {
        out[j] += values[k] * x[i];
      }
    }
  }
}

/* ---- cones ---- */

/* What the projection onto a cone makes of the head, and by what it multiplies the tail; 0 where
 * the point is inside. */
ORBSOC_SHARED int onto_cone(size_t dim, const double *v, double *head, double *factor) {
  double square = 0.0;
  for (size_t i = 1; i < dim; i++) { square += v[i] * v[i]; }
  const double size = sqrt(square);
  if (size <= v[0]) {
    return 0;
  }
  if (size <= -v[0]) {
    *head = 0.0;
    *factor = 0.0;
  } else {
    const int large = fabs(v[0]) > DBL_MAX / 2.0 || size > DBL_MAX / 2.0;
    *head = large ? v[0] / 2.0 + size / 2.0 : (v[0] + size) / 2.0;
    *factor = *head / size;
  }
  return 1;
}

/* Projection of v onto K. */
static void project(pattern_t pattern, double *v) {
  size_t at = pattern->given_l;
  for (size_t i = 0; i < pattern->given_l; i++) { v[i] = most(v[i], 0.0); }
  for (size_t k = 0; k < pattern->given_cones; k++) {
    const size_t dim = pattern->given_cone_dims[k];
    double head = 0.0, factor = 0.0;
    if (onto_cone(dim, &v[at], &head, &factor) != 0) {
      v[at] = head;
      for (size_t i = 1; i < dim; i++) { v[at + i] *= factor; }
    }
    at += dim;
  }
}

/* The largest entry of what the projection of v onto K would move. */
ORBSOC_SHARED double outside(pattern_t pattern, const double *v) {
  double moved = 0.0;
  size_t at = pattern->given_l;
  for (size_t i = 0; i < pattern->given_l; i++) { moved = (moved < -v[i]) ? -v[i] : moved; }
  for (size_t k = 0; k < pattern->given_cones; k++) {
    const size_t dim = pattern->given_cone_dims[k];
    double head = 0.0, factor = 0.0;
    if (onto_cone(dim, &v[at], &head, &factor) != 0) {
      double tail = 0.0;
      for (size_t i = 1; i < dim; i++) { tail = (tail < fabs(v[at + i])) ? fabs(v[at + i]) : tail; }
      tail = (1.0 - factor) * tail;
      moved = (moved < fabs(head - v[at])) ? fabs(head - v[at]) : moved;
      moved = (moved < tail) ? tail : moved;
    }
    at += dim;
  }
  return moved;
}

/* ---- rounding-error bounds: another order of addition gives another sum ---- */

typedef struct {
  double equality, conic, dual;
} bound_t;

/* Add a term's magnitude to a sum, and to its number of terms. */
static void add_term(double *sums, double *terms, size_t at, double term) {
  sums[at] += fabs(term);
  terms[at] += 1.0;
}

ORBSOC_SHARED void first_terms(size_t count, const double *first, double *sums, double *terms) {
  for (size_t i = 0; i < count; i++) {
    sums[i] = fabs(first[i]);
    terms[i] = 1.0;
  }
}

ORBSOC_SHARED double worst_bound(size_t count, const double *sums, const double *terms,
                          const uint8_t *absent) {
  double worst = 0.0;
  for (size_t i = 0; i < count; i++) {
    if (absent == NULL || absent[i] == 0u) {
      const double bound =
          is_finite(sums[i]) ? probabilistic_bound(terms[i]) * sums[i] : (double)INFINITY;
      worst = most(worst, bound);
    }
  }
  return worst;
}

/* The terms of one matrix: in its rows' sums, and in those of columns. */
ORBSOC_SHARED void add_terms(const orbsoc_matrix *matrix, size_t columns, const double *values,
                      const double *x, const double *dual, double *rows, double *row_terms,
                      double *sums, double *terms) {
  for (size_t j = 0; j < columns; j++) {
    for (size_t k = matrix->begins[j]; k < matrix->begins[j + 1]; k++) {
      const size_t i = matrix->rows[k];
      add_term(rows, row_terms, i, values[k] * x[j]);
      add_term(sums, terms, j, values[k] * dual[i]);
    }
  }
}

/* Bounds on the rounding error of any one entry of a point's residuals. `work` has 2 (n + p +
 * given_m) words. */
static bound_t roundoff_of(pattern_t pattern, const orbsoc_numbers *given, const point_t *at,
                           const double *slack, double *work) {
  const size_t n = pattern->n, p = pattern->p, m = pattern->given_m;
  double *dual = work, *dual_terms = &dual[n], *rows = &dual_terms[n], *row_terms = &rows[p];
  double *conic = &row_terms[p], *conic_terms = &conic[m];
  first_terms(n, given->c, dual, dual_terms);
  first_terms(p, given->b, rows, row_terms);
  first_terms(m, given->h, conic, conic_terms);
  add_terms(&pattern->equality, n, given->a, at->x, at->y, rows, row_terms, dual, dual_terms);
  add_terms(&pattern->given_conic, n, given->g, at->x, at->z, conic, conic_terms, dual,
            dual_terms);
  for (size_t j = 0; j < n; j++) {
    for (size_t k = pattern->cost.begins[j]; k < pattern->cost.begins[j + 1]; k++) {
      const size_t i = pattern->cost.rows[k];
      add_term(dual, dual_terms, j, given->p[k] * at->x[i]);
      if (i != j) {
        add_term(dual, dual_terms, i, given->p[k] * at->x[j]);
      }
    }
  }
  for (size_t i = 0; i < m; i++) { add_term(conic, conic_terms, i, slack[i]); }
  const bound_t out = {worst_bound(p, rows, row_terms, NULL),
                       worst_bound(m, conic, conic_terms, pattern->absent),
                       worst_bound(n, dual, dual_terms, NULL)};
  return out;
}

/* ---- residuals of a point ---- */

/* An error over 1 + the size of what it is an error of; infinite when it is, whatever the size. */
ORBSOC_SHARED double ratio(double error, double size) {
  return is_finite(error) ? error / (1.0 + size) : (double)INFINITY;
}

ORBSOC_SHARED double worst_of(double primal, double dual, double gap) {
  return is_finite(primal + dual + gap) ? most(most(primal, dual), gap) : (double)INFINITY;
}

/* Norms of the data and of the products at a point. */
typedef struct {
  double b, h, s, c, ax, gx, px, aty, gtz;
} norms_t;

/* Vectors of the residuals, in the certificate's work space. */
typedef struct {
  double *px, *aty, *gtz, *ax, *gx, *h, *slack, *beyond, *rest;
} vectors_t;

/* Primal and dual objective, and the gap; what rounding may hide counts where it could matter. */
static void objectives(pattern_t pattern, const orbsoc_numbers *given, const point_t *at,
                       const vectors_t *v, double tol, double factor, residuals_t *out) {
  const size_t n = pattern->n, p = pattern->p, m = pattern->given_m;
  const double half = 0.5 * dot_of(n, at->x, v->px);
  out->objective = half + dot_of(n, given->c, at->x);
  out->dual_objective = -half - dot_of(p, given->b, at->y) - dot_of(m, v->h, at->z);
  const double terms = size_of(n, at->x, v->px) + size_of(n, given->c, at->x) +
                       size_of(p, given->b, at->y) + size_of(m, v->h, at->z);
  const double scale = 1.0 + least(fabs(out->objective), fabs(out->dual_objective));
  const double difference = fabs(out->objective - out->dual_objective);
  out->gap = (factor * terms <= 0.1 * tol * scale) ? difference / scale
                                                   : (difference + factor * terms) / scale;
}

/* Bounds on rounding, zero where they could be no more than a tenth of the tolerance. */
static bound_t needed_bound(pattern_t pattern, const orbsoc_numbers *given, const point_t *at,
                            const vectors_t *v, const norms_t *norm, double tol, double factor) {
  const size_t n = pattern->n, p = pattern->p, m = pattern->given_m;
  const double in_p = norm_of(pattern->nnz_p, given->p), in_a = norm_of(pattern->nnz_a, given->a);
  const double in_g = norm_of(pattern->given_nnz_g, given->g), size_x = size_of(n, at->x, NULL);
  const double row = (in_a + in_g) * size_x + norm->b + norm->h + norm->s;
  const double column = in_a * size_of(p, at->y, NULL) + in_g * size_of(m, at->z, NULL) +
                        in_p * size_x + norm->c;
  const bound_t none = {0.0, 0.0, 0.0};
  const int negligible = factor * row <= 0.1 * tol * (1.0 + most(norm->b, norm->h)) &&
                         factor * column <= 0.1 * tol * (1.0 + norm->c);
  return negligible ? none : roundoff_of(pattern, given, at, v->slack, v->rest);
}

/* The products at a point and their norms. */
static norms_t products_at(pattern_t pattern, const orbsoc_numbers *given, const point_t *at,
                           const vectors_t *v) {
  const size_t n = pattern->n, p = pattern->p, m = pattern->given_m;
  norms_t norm;
  present(pattern, given->h, v->h);
  present(pattern, at->s, v->slack);
  symmetric_product(pattern, given->p, at->x, v->px);
  product(&pattern->equality, p, n, given->a, at->x, v->ax);
  transposed_product(&pattern->equality, n, given->a, at->y, v->aty);
  product(&pattern->given_conic, m, n, given->g, at->x, v->gx);
  transposed_product(&pattern->given_conic, n, given->g, at->z, v->gtz);
  present(pattern, v->gx, v->gx);
  norm.b = norm_of(p, given->b);
  norm.h = norm_of(m, v->h);
  norm.s = norm_of(m, v->slack);
  norm.c = norm_of(n, given->c);
  norm.ax = norm_of(p, v->ax);
  norm.gx = norm_of(m, v->gx);
  norm.px = norm_of(n, v->px);
  norm.aty = norm_of(n, v->aty);
  norm.gtz = norm_of(n, v->gtz);
  return norm;
}

static residuals_t residuals_of(pattern_t pattern, const orbsoc_numbers *given, const point_t *at,
                                double tol) {
  const size_t n = pattern->n, p = pattern->p, m = pattern->given_m;
  double *w = given->work;
  const vectors_t v = {w, &w[n], &w[2 * n], &w[3 * n], &w[3 * n + p], &w[3 * n + p + m],
                       &w[3 * n + p + 2 * m], &w[3 * n + p + 3 * m], &w[3 * n + p + 4 * m]};
  const norms_t norm = products_at(pattern, given, at, &v);
  const double factor = probabilistic_bound((double)(n + p + m));
  residuals_t out;
  objectives(pattern, given, at, &v, tol, factor, &out);
  const bound_t bound = needed_bound(pattern, given, at, &v, &norm, tol, factor);
  for (size_t i = 0; i < p; i++) { v.ax[i] = v.ax[i] - given->b[i]; }
  for (size_t i = 0; i < m; i++) {
    v.beyond[i] = v.h[i] - v.gx[i];
    v.gx[i] = (v.gx[i] + v.slack[i]) - v.h[i];
  }
  for (size_t i = 0; i < n; i++) { v.px[i] = ((v.px[i] + given->c[i]) + v.aty[i]) + v.gtz[i]; }
  const double equality = bound.equality + norm_of(p, v.ax);
  const double beyond = bound.conic + outside(pattern, v.beyond);
  const double conic = bound.conic + norm_of(m, v.gx);
  const double dual = bound.dual + norm_of(n, v.px);
  const double dual_outside = outside(pattern, at->z);
  out.primal = most(most(ratio(equality, most(norm.ax, norm.b)),
                         ratio(conic, most(norm.gx, norm.h))),
                    ratio(outside(pattern, v.slack), norm.s));
  out.dual = most(ratio(dual, most(most(most(norm.px, norm.aty), norm.gtz), norm.c)),
                  ratio(dual_outside, norm_of(m, at->z)));
  out.independent = worst_of(ratio(most(equality, beyond), most(norm.b, norm.h)),
                             ratio(most(dual, dual_outside), norm.c), out.gap);
  return out;
}

/* ---- certificates of infeasibility ---- */

/* Of a certificate of this value, of which the size of what it misses, the data's scale, the
 * magnitude of the value's terms, and the sum of all shares. */
ORBSOC_SHARED proof_t radius(orbsoc_status status, double value, double size, double scale,
                             double terms, double share) {
  proof_t out = {status, 0.0, 0.0, 0.0};
  if (value < 0.0 && is_finite(value) && is_finite(size)) {
    out.radius = (size > 0.0) ? -value / size : (double)INFINITY;
    out.relative = out.radius / scale;
    out.own = (share > 0.0) ? -value / terms / share : (double)INFINITY;
  }
  return out;
}

/* The data's scale that a radius is compared with: at least 1, and no less than how near points can
 * be where entries are small. With a quadratic cost a dual point has an x in it. h without the rows
 * that do not constrain is left in `h`. */
ORBSOC_SHARED double scale_of(pattern_t pattern, const orbsoc_numbers *given, int dual, double *h) {
  const double entry = peak_of(pattern->given_conic.begins[pattern->n], given->g,
                               peak_of(pattern->nnz_a, given->a, 0.0));
  double side = dual ? peak_of(pattern->n, given->c, 0.0) : 0.0;
  present(pattern, given->h, h);
  if (!dual || pattern->nnz_p > 0u) {
    side = peak_of(pattern->given_m, h, peak_of(pattern->p, given->b, side));
  }
  return (entry >= DBL_MIN) ? most(most(side, 1.0), side / entry / SCALE_RANGE) : most(side, 1.0);
}

/* An error over the magnitude of the terms that it is left of; zero where there are none. */
static double share_of(double error, double terms) {
  return (terms > 0.0) ? error / terms : 0.0;
}

/* Sum of |value v[row]| in one column. */
static double column_size(const orbsoc_matrix *matrix, size_t column, const double *values,
                          const double *v) {
  double sum = 0.0;
  for (size_t k = matrix->begins[column]; k < matrix->begins[column + 1]; k++) {
    sum += fabs(values[k] * v[matrix->rows[k]]);
  }
  return sum;
}

/* Sum of |value x[column]| in each row, of an upper triangle those of the whole matrix. */
static void row_sizes(const orbsoc_matrix *matrix, size_t rows, size_t columns,
                      const double *values, const double *x, int symmetric, double *out) {
  for (size_t i = 0; i < rows; i++) {
    out[i] = 0.0;
  }
  for (size_t j = 0; j < columns; j++) {
    for (size_t k = matrix->begins[j]; k < matrix->begins[j + 1]; k++) {
      const size_t i = matrix->rows[k];
      out[i] += fabs(values[k] * x[j]);
      if (symmetric != 0 && i != j) {
        out[j] += fabs(values[k] * x[i]);
      }
    }
  }
}

/* Absent rows have no size, and rows of a cone that of all. */
static void by_cone(pattern_t pattern, double *sizes) {
  size_t at = pattern->given_l;
  present(pattern, sizes, sizes);
  for (size_t k = 0; k < pattern->given_cones; k++) {
    const size_t end = at + pattern->given_cone_dims[k];
    double all = 0.0;
    for (size_t i = at; i < end; i++) {
      all += sizes[i];
    }
    for (; at < end; at++) {
      sizes[at] = all;
    }
  }
}

/* `sum` and the shares of errors to which rounding adds so much of their terms. */
ORBSOC_SHARED double add_shares(size_t count, const double *errors, const double *sizes,
                                double rounding, double sum) {
  for (size_t i = 0; i < count; i++) {
    sum += share_of(fabs(errors[i]) + rounding * sizes[i], sizes[i]);
  }
  return sum;
}

/* Sum over a matrix's entries of |value v[column]|, without absent rows. */
static double lost_by_columns(const orbsoc_matrix *matrix, size_t columns, const double *values,
                              const double *v, const uint8_t *absent) {
  double sum = 0.0;
  for (size_t j = 0; j < columns; j++) {
    for (size_t k = matrix->begins[j]; k < matrix->begins[j + 1]; k++) {
      const int counts = absent == NULL || absent[matrix->rows[k]] == 0u;
      sum += counts ? fabs(values[k] * v[j]) : 0.0;
    }
  }
  return sum;
}

/* That no x is feasible: z is projected onto K, and the certificate scaled to size one. What sums
 * may have lost in rounding counts against it. */
ORBSOC_SHARED proof_t primal_proof(pattern_t pattern, const orbsoc_numbers *given, double *y,
                                   double *z) {
  const size_t n = pattern->n, p = pattern->p, m = pattern->given_m;
  double *aty = given->work, *gtz = &aty[n], *h = &gtz[n];
  double terms = 0.0, share = 0.0, lost = 0.0;
  present(pattern, z, z);
  project(pattern, z);
  const double size = most(norm_of(p, y), norm_of(m, z));
  for (size_t i = 0; i < p; i++) { y[i] = y[i] / size; }
  for (size_t i = 0; i < m; i++) { z[i] = z[i] / size; }
  const double scale = scale_of(pattern, given, 0, h);
  const double support = dot_of(p, given->b, y) + dot_of(m, h, z);
  transposed_product(&pattern->equality, n, given->a, y, aty);
  transposed_product(&pattern->given_conic, n, given->g, z, gtz);
  for (size_t j = 0; j < n; j++) { aty[j] = aty[j] + gtz[j]; }
  for (size_t i = 0; i < p; i++) { terms += fabs(given->b[i] * y[i]); }
  for (size_t i = 0; i < m; i++) { terms += fabs(h[i] * z[i]); }
  for (size_t j = 0; j < n; j++) {
    const double in_a = column_size(&pattern->equality, j, given->a, y);
    const double in_g = column_size(&pattern->given_conic, j, given->g, z);
    const double rounding = deterministic_bound(p) * in_a + deterministic_bound(m) * in_g;
    share += share_of(fabs(aty[j]) + rounding, in_a + in_g);
    lost += rounding;
  }
  return radius(ORBSOC_PRIMAL_INFEASIBLE, support + deterministic_bound(p + m) * terms,
                one_norm(n, aty) + lost, scale, terms, share);
}

/* Rounding in the products of a direction with P, A and G. */
static double lost_along(pattern_t pattern, const orbsoc_numbers *given, const double *x) {
  const size_t n = pattern->n;
  const double bound = deterministic_bound(n);
  double sum = 0.0;
  for (size_t j = 0; j < n; j++) {
    for (size_t k = pattern->cost.begins[j]; k < pattern->cost.begins[j + 1]; k++) {
      sum += 2.0 * most(fabs(given->p[k] * x[pattern->cost.rows[k]]), fabs(given->p[k] * x[j]));
    }
  }
  return bound * sum + bound * lost_by_columns(&pattern->equality, n, given->a, x, NULL) +
         bound * lost_by_columns(&pattern->given_conic, n, given->g, x, pattern->absent);
}

/* That no dual point is feasible; x is scaled to size one. */
ORBSOC_SHARED proof_t dual_proof(pattern_t pattern, const orbsoc_numbers *given, double *x) {
  const size_t n = pattern->n, p = pattern->p, m = pattern->given_m;
  double *px = given->work, *ax = &px[n], *recession = &ax[p], *inside = &recession[m];
  double *sizes = &inside[m], terms = 0.0, share = 0.0;
  const double size = norm_of(n, x);
  for (size_t j = 0; j < n; j++) { x[j] = x[j] / size; }
  const double cost = dot_of(n, given->c, x);
  symmetric_product(pattern, given->p, x, px);
  product(&pattern->equality, p, n, given->a, x, ax);
  product(&pattern->given_conic, m, n, given->g, x, recession);
  present(pattern, recession, recession);
  for (size_t i = 0; i < m; i++) {
    recession[i] = -recession[i];
    inside[i] = recession[i];
  }
  project(pattern, inside);
  for (size_t i = 0; i < m; i++) { recession[i] = recession[i] - inside[i]; }
  const double distance = one_norm(n, px) + one_norm(p, ax) + one_norm(m, recession);
  for (size_t j = 0; j < n; j++) { terms += fabs(given->c[j] * x[j]); }
  const double rounding = deterministic_bound(n);
  row_sizes(&pattern->cost, n, n, given->p, x, 1, sizes);
  share = add_shares(n, px, sizes, 2.0 * rounding, share);
  row_sizes(&pattern->equality, p, n, given->a, x, 0, sizes);
  share = add_shares(p, ax, sizes, rounding, share);
  row_sizes(&pattern->given_conic, m, n, given->g, x, 0, sizes);
  by_cone(pattern, sizes);
  share = add_shares(m, recession, sizes, rounding, share);
  return radius(ORBSOC_DUAL_INFEASIBLE, cost + deterministic_bound(n) * terms,
                distance + lost_along(pattern, given, x), scale_of(pattern, given, 1, sizes), terms,
                share);
}

/* ---- the outcome ---- */

/* Whether a point is too large to be excluded by a certificate of infeasibility with this radius.
 * */
static int norm_exceeds(pattern_t pattern, orbsoc_status status, double radius_, const double *x,
                        const double *y, const double *z) {
  const double size = (status == ORBSOC_PRIMAL_INFEASIBLE)
                          ? peak_of(pattern->n, x, 0.0)
                          : most(peak_of(pattern->p, y, 0.0), peak_of(pattern->given_m, z, 0.0));
  return size >= radius_;
}

/* (x, y, z) of words in the iteration's rows, into the user's rows; absent ones zero. */
ORBSOC_SHARED void read_point(pattern_t pattern, const orbsoc_real *words, double *x, double *y,
                       double *z) {
  const size_t n = pattern->n, p = pattern->p;
  for (size_t j = 0; j < n; j++) { x[j] = (double)words[j]; }
  for (size_t i = 0; i < p; i++) { y[i] = (double)words[n + i]; }
  for (size_t i = 0; i < pattern->given_m; i++) { z[i] = 0.0; }
  for (size_t i = 0; i < pattern->m; i++) { z[pattern->row_origin[i]] = (double)words[n + p + i]; }
}

ORBSOC_SHARED void fill(size_t count, double value, double *out) {
  for (size_t k = 0; k < count; k++) { out[k] = value; }
}

/* The stronger certificate of those that the original data support and an `apparent` solution does
 * not speak against: its status, or ORBSOC_SOLVED; its point in `at`. Of those that no radius in
 * their own scale supports, the larger over the data's scale is the stronger. */
static proof_t infeasible(const orbsoc_solver *solver, const point_t *apparent, point_t *at) {
  pattern_t pattern = solver->pattern;
  const orbsoc_numbers *given = &solver->numbers;
  const size_t n = pattern->n, p = pattern->p, m = pattern->given_m;
  const orbsoc_real *words = solver->buffer[ORBSOC_UNSCALED_CERTIFICATES];
  double *x = given->certificate, *y = &x[n], *z = &y[p];
  proof_t found = {ORBSOC_SOLVED, 0.0, 0.0, 0.0};
  for (uint32_t side = 0; side < 2u; side++) {
    const size_t word = (side == 0u) ? WORD_PRIMAL_RADIUS : WORD_DUAL_RADIUS;
    if (!(solver->buffer[ORBSOC_CONTROL][word] > 0)) {
      continue;
    }
    read_point(pattern, &words[side * unknowns_of(pattern)], x, y, z);
    proof_t proof =
        (side == 0u) ? primal_proof(pattern, given, y, z) : dual_proof(pattern, given, x);
    const int stands =
        most(proof.relative, proof.own) >= RADIUS_CLAIMED &&
        (apparent == NULL || norm_exceeds(pattern, proof.status, proof.radius, apparent->x,
                                          apparent->y, apparent->z) == 0);
    proof.own = (proof.own >= RADIUS_CLAIMED) ? proof.own : 0.0;
    if (stands && (proof.own > found.own ||
                   (proof.own == found.own && proof.relative >= found.relative))) {
      found = proof;
    }
  }
  if (found.status == ORBSOC_PRIMAL_INFEASIBLE) {
    read_point(pattern, words, x, at->y, at->z);
    (void)primal_proof(pattern, given, at->y, at->z);
    fill(n, (double)NAN, at->x);
    fill(m, (double)NAN, at->s);
  } else if (found.status == ORBSOC_DUAL_INFEASIBLE) {
    read_point(pattern, &words[unknowns_of(pattern)], at->x, y, z);
    (void)dual_proof(pattern, given, at->x);
    fill(p, (double)NAN, at->y);
    fill(m, (double)NAN, at->z);
    fill(m, (double)NAN, at->s);
  }
  return found;
}

/* What the status of a point that is not solved is, by why the attempt ended. */
static orbsoc_status unsolved(uint32_t stop) {
  switch (stop) {
    case STOP_MAX_ITERATIONS:
      return ORBSOC_MAX_ITERATIONS;
    case STOP_MAX_TIME:
      return ORBSOC_MAX_TIME;
    case STOP_INTERRUPTED:
      return ORBSOC_INTERRUPTED;
    default:
      return ORBSOC_NUMERICAL_LIMIT;
  }
}

static void assemble(orbsoc_status status, double radius_, const residuals_t *residuals,
                     orbsoc_solution *out) {
  out->status = status;
  out->objective = residuals->objective;
  out->dual_objective = residuals->dual_objective;
  out->primal_residual = residuals->primal;
  out->dual_residual = residuals->dual;
  out->gap = residuals->gap;
  out->radius = radius_;
}

/* The outcome of the attempt that ended, with the status that the numbers support. */
static void verify(const orbsoc_solver *solver, point_t *at, orbsoc_solution *out) {
  pattern_t pattern = solver->pattern;
  const orbsoc_settings *settings = &solver->settings;
  const orbsoc_real *words = solver->buffer[ORBSOC_UNSCALED_ITERATE];
  const double tol = settings->tol, loose = settings->tol_inaccurate;
  read_point(pattern, words, at->x, at->y, at->z);
  fill(pattern->given_m, (double)INFINITY, at->s);
  for (size_t i = 0; i < pattern->m; i++) {
    at->s[pattern->row_origin[i]] = (double)words[unknowns_of(pattern) + i];
  }
  const residuals_t found = residuals_of(pattern, &solver->numbers, at, tol);
  const double worst = worst_of(found.primal, found.dual, found.gap);
  const int solved = worst <= tol && found.independent <= INDEPENDENT_FACTOR * tol;
  const int usable = worst <= loose && found.independent <= loose &&
                     solver->stop != (uint32_t)STOP_INTERRUPTED;
  const int by_certificate = solver->stop == (uint32_t)STOP_PRIMAL_CERTIFICATE ||
                             solver->stop == (uint32_t)STOP_DUAL_CERTIFICATE;
  const int stalled = solver->stop == (uint32_t)STOP_STALLED ||
                      solver->stop == (uint32_t)STOP_NOT_FINITE;
  if (by_certificate || (stalled && !solved)) {
    const proof_t proof = infeasible(solver, (!by_certificate && worst <= loose) ? at : NULL, at);
    if (proof.status != ORBSOC_SOLVED) {
      const double none = (double)NAN, infinite = (double)INFINITY;
      const double value = (proof.status == ORBSOC_PRIMAL_INFEASIBLE) ? infinite : -infinite;
      const residuals_t unknown = {none, none, none, none, value, value};
      assemble(proof.status, proof.radius, &unknown, out);
      return;
    }
  }
  orbsoc_status status = unsolved(solver->stop);
  status = usable ? ORBSOC_SOLVED_INACCURATE : status;
  assemble(solved ? ORBSOC_SOLVED : status, (double)NAN, &found, out);
}

static int is_infeasible(orbsoc_status status) {
  return status == ORBSOC_PRIMAL_INFEASIBLE || status == ORBSOC_DUAL_INFEASIBLE;
}

ORBSOC_SHARED double worst_ratio(const orbsoc_solution *of) {
  return worst_of(of->primal_residual, of->dual_residual, of->gap);
}

/* Whether a nearly solved point speaks against a certificate. */
static int stands_against(const orbsoc_solver *solver, const orbsoc_solution *point,
                          const orbsoc_solution *proof) {
  return worst_ratio(point) <= solver->settings.tol_inaccurate &&
         norm_exceeds(solver->pattern, proof->status, proof->radius, point->x, point->y,
                      point->z) != 0;
}

/* Whether the later outcome is worth more than that of an earlier attempt, which stalled. */
static int replaces(const orbsoc_solver *solver, const orbsoc_solution *later,
                    const orbsoc_solution *earlier) {
  const int usable = earlier->status == ORBSOC_SOLVED_INACCURATE;
  if (later->status == earlier->status && is_infeasible(later->status)) {
    return later->radius > earlier->radius;
  }
  if (is_infeasible(earlier->status) != 0) {
    return !is_infeasible(later->status) && stands_against(solver, later, earlier);
  }
  if (later->status == ORBSOC_SOLVED) {
    return 1;
  }
  if (is_infeasible(later->status) != 0) {
    return !(usable || stands_against(solver, earlier, later));
  }
  if ((later->status == ORBSOC_SOLVED_INACCURATE) != usable) {
    return !usable;
  }
  return worst_ratio(later) < worst_ratio(earlier);
}

/* The better outcome of this attempt and an earlier one of the same solve, with the counts of both.
 * */
void orbsoc_conclude(orbsoc_solver *solver) {
  pattern_t pattern = solver->pattern;
  const orbsoc_real *words = solver->buffer[ORBSOC_CONTROL];
  double *const *slot = solver->numbers.point;
  const int second = solver->has_earlier != 0u && solver->earlier.x == slot[0];
  double *memory = slot[second];
  point_t at = {memory, &memory[pattern->n], NULL, NULL};
  at.z = &at.y[pattern->p];
  at.s = &at.z[pattern->given_m];
  orbsoc_solution later;
  later.x = at.x;
  later.y = at.y;
  later.z = at.z;
  later.s = at.s;
  later.place = ORBSOC_ON_CORE;
  later.event[0] = 0;
  later.event[1] = 0;
  later.warm_start = solver->warm_start;
  later.iterations = solver->spent + orbsoc_count(words[WORD_ITERATION]);
  later.refinements = solver->refined_before + orbsoc_count(words[WORD_REFINEMENTS]);
  later.attempts = solver->restarts + 1u;
  verify(solver, &at, &later);
  const orbsoc_solution *earlier = &solver->earlier;
  solver->solution = later;
  if (solver->has_earlier != 0u && replaces(solver, &later, earlier) == 0) {
    const int stopped = (later.status == ORBSOC_MAX_TIME)
                            ? earlier->status == ORBSOC_NUMERICAL_LIMIT
                            : later.status == ORBSOC_INTERRUPTED && !is_infeasible(earlier->status);
    solver->solution = *earlier;
    solver->solution.status = stopped ? later.status : earlier->status;
    solver->solution.iterations = later.iterations;
    solver->solution.refinements = later.refinements;
    solver->solution.attempts = later.attempts;
    solver->solution.warm_start = later.warm_start;
  }
}

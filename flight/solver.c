/* A solver's memory and data: every word from the caller, every number checked before it is taken.
 * */
#include "kernels.h"
#include "method.h"

#define VERSION 1u

/* Words of each buffer, in their order. */
ORBSOC_SHARED size_t words_of(pattern_t pattern, orbsoc_buffer buffer) {
  const size_t n = pattern->n, m = pattern->m, all = unknowns_of(pattern), dim = pattern->dim;
  switch (buffer) {
    case ORBSOC_RAW_P: case ORBSOC_RAW_A: case ORBSOC_RAW_G: case ORBSOC_RAW_Q:
      return 0;
    case ORBSOC_START: case ORBSOC_DUAL_CERTIFICATE: case ORBSOC_UNSCALED_ITERATE:
      return all + m;
    case ORBSOC_NORMS:
      return NORM_WORDS;
    case ORBSOC_HOMOGENIZER: case ORBSOC_REFINEMENT:
      return 3;
    case ORBSOC_PARAMETERS:
      return PARAMETER_WORDS;
    case ORBSOC_P:
      return pattern->nnz_p;
    case ORBSOC_A:
      return pattern->nnz_a;
    case ORBSOC_G:
      return pattern->nnz_g;
    case ORBSOC_Q: case ORBSOC_SCALE: case ORBSOC_SCALE_INVERSE: case ORBSOC_POINT:
    case ORBSOC_RESIDUAL: case ORBSOC_CONSTANT_SOLUTION: case ORBSOC_STEP:
    case ORBSOC_PRIMAL_CERTIFICATE:
      return all;
    case ORBSOC_COST_SCALE: case ORBSOC_TAU_STEP:
      return 2;
    case ORBSOC_SLACK: case ORBSOC_W: case ORBSOC_LAMBDA: case ORBSOC_SCALED_Z:
    case ORBSOC_SCALED_S: case ORBSOC_SLACK_STEP: case ORBSOC_COMPLEMENTARITY_RHS:
    case ORBSOC_CONE_DIVISION:
      return m;
    case ORBSOC_COST_PRODUCT:
      return n;
    case ORBSOC_EMBEDDING: case ORBSOC_CENTERING: case ORBSOC_REGULARIZATION:
      return 4;
    case ORBSOC_STATISTICS:
      return STAT_WORDS;
    case ORBSOC_LAMBDA_INVERSE:
      return pattern->l;
    case ORBSOC_CONE:
      return (size_t)pattern->cones * CONE_SCALARS;
    case ORBSOC_KKT_VALUES:
      return pattern->nnz_kkt;
    case ORBSOC_FACTOR_L:
      return pattern->panel_entries;
    case ORBSOC_PIVOT_INVERSE: case ORBSOC_KKT_RHS: case ORBSOC_KKT_SOLUTION:
    case ORBSOC_KKT_ERROR:
      return dim;
    case ORBSOC_MULTI_RHS: case ORBSOC_MULTI_SOLUTION: case ORBSOC_MULTI_ERROR:
      return 2 * dim;
    case ORBSOC_MULTI_REFINEMENT:
      return 6;
    case ORBSOC_CONTROL:
      return CONTROL_WORDS;
    case ORBSOC_BEST:
      return all + m + 1;
    case ORBSOC_UNSCALED_CERTIFICATES:
      return 2 * all;
    default: /* single words */
      return 1;
  }
}

static int positive(double value) { return value > 0.0 && value - value == 0.0; }

/* Whether every setting is in its range, as `orbsoc.Settings` asks. */
static int valid(const orbsoc_settings *s) {
  return positive(s->tol) && positive(s->tol_inaccurate) && positive(s->static_regularization) &&
         positive(s->pivot_floor) && positive(s->dynamic_regularization) &&
         positive(s->refinement_tol) && positive(s->refinement_share) &&
         positive(s->step_fraction) && s->step_fraction < 1.0 && s->max_iterations >= 1u &&
         s->max_iterations <= 100000u && s->refinement_max <= 100u && s->ruiz_passes <= 100u &&
         s->max_restarts <= 100u;
}

/* Whether products are rounded before they are added: the compiler may have fused them, whatever it
 * was told. */
static int rounds_products(void) {
  static const volatile orbsoc_real almost[2] = {
      1 + 16 * (orbsoc_real)((ORBSOC_FP == 64) ? DBL_EPSILON : FLT_EPSILON),
      1 - 16 * (orbsoc_real)((ORBSOC_FP == 64) ? DBL_EPSILON : FLT_EPSILON)};
  const orbsoc_real a = almost[0], b = almost[1], c = almost[0] * 0 + 1;
  return a * b - c == 0;
}

/* What the certificate would not notice, whatever the checksum says: rows that no cone has. */
static size_t rows_of_cones(size_t rows, size_t cones, const orbsoc_index *dims) {
  for (size_t k = 0; k < cones; k++) { rows += dims[k]; }
  return rows;
}

static void lay_out_numbers(pattern_t pattern, double *at, orbsoc_numbers *out) {
  const size_t n = pattern->n, p = pattern->p, m = pattern->given_m;
  out->p = at;
  out->a = &out->p[pattern->nnz_p];
  out->g = &out->a[pattern->nnz_a];
  out->c = &out->g[pattern->given_nnz_g];
  out->b = &out->c[n];
  out->h = &out->b[p];
  out->point[0] = &out->h[m];
  out->point[1] = &out->point[0][n + p + 2 * m];
  out->certificate = &out->point[1][n + p + 2 * m];
  out->work = &out->certificate[n + p + m];
}

static size_t number_words(pattern_t pattern) {
  const size_t n = pattern->n, p = pattern->p, m = pattern->given_m;
  return (size_t)pattern->nnz_p + pattern->nnz_a + pattern->given_nnz_g + 9 * n + 7 * p + 12 * m;
}

orbsoc_error orbsoc_open(orbsoc_solver *solver, const orbsoc_pattern *pattern,
                         const orbsoc_settings *settings, orbsoc_real *work, size_t work_words,
                         double *numbers, size_t numbers_count) {
  if (solver == NULL || pattern == NULL || settings == NULL || work == NULL || numbers == NULL) {
    return ORBSOC_NO_POINTER;
  }
  solver->pattern = NULL;
  if (pattern->version != VERSION || pattern->index_bits != (uint32_t)ORBSOC_INDEX_BITS) {
    return ORBSOC_WRONG_WIDTH;
  }
  if (orbsoc_size_checksum(pattern) != pattern->size_checksum ||
      orbsoc_checksum(pattern) != pattern->checksum) {
    return ORBSOC_TABLES_CHANGED;
  }
  if (rows_of_cones(pattern->l, pattern->cones, pattern->cone_dims) != pattern->m ||
      rows_of_cones(pattern->given_l, pattern->given_cones, pattern->given_cone_dims) !=
          pattern->given_m) {
    return ORBSOC_TABLES_CHANGED;
  }
  if (valid(settings) == 0) {
    return ORBSOC_BAD_SETTING;
  }
  if (rounds_products() == 0) {
    return ORBSOC_WRONG_ARITHMETIC;
  }
  size_t at = 0;
  for (uint32_t k = 0; k < (uint32_t)ORBSOC_BUFFERS; k++) {
    solver->buffer[k] = &work[at];
    at += words_of(pattern, (orbsoc_buffer)k);
    if (at > work_words) {
      return ORBSOC_SMALL_MEMORY;
    }
  }
  if (at + pattern->scratch > work_words || number_words(pattern) > numbers_count) {
    return ORBSOC_SMALL_MEMORY;
  }
  solver->scratch = &work[at];
  for (size_t k = 0; k < at + pattern->scratch; k++) { work[k] = 0; }
  for (size_t k = 0; k < number_words(pattern); k++) { numbers[k] = 0.0; }
  lay_out_numbers(pattern, numbers, &solver->numbers);
  solver->pattern = pattern;
  solver->settings = *settings;
  solver->given = (pattern->nnz_p == 0u ? 1u : 0u) | (pattern->nnz_a == 0u ? 2u : 0u) |
                  (pattern->given_nnz_g == 0u ? 4u : 0u) | (pattern->p == 0u ? 16u : 0u) |
                  (pattern->given_m == 0u ? 32u : 0u);
  solver->ask = NULL;
  solver->context = NULL;
  solver->kept = 0;
  solver->partition = NULL;
  solver->away = 0;
  solver->loaded = 0;
  solver->event = 0;
  orbsoc_begin(solver, ATTEMPT_COLD);
  return ORBSOC_OK;
}

#define MATRICES 7u

/* Take numbers that are all finite. */
ORBSOC_SHARED orbsoc_error take(orbsoc_solver *solver, uint32_t bit, size_t count,
                                const double *values, double *to) {
  for (size_t k = 0; k < count; k++) {
    if (values[k] - values[k] != 0.0) {
      return ORBSOC_BAD_VALUE;
    }
  }
  for (size_t k = 0; k < count; k++) { to[k] = values[k]; }
  solver->given |= bit;
  solver->kept = ((bit & MATRICES) != 0u) ? 0u : solver->kept;
  return ORBSOC_OK;
}

static int missing(const orbsoc_solver *solver, const double *values) {
  return solver == NULL || solver->pattern == NULL || values == NULL;
}

orbsoc_error orbsoc_set_p(orbsoc_solver *solver, const double *values) {
  return missing(solver, values)
             ? ORBSOC_NO_POINTER
             : take(solver, 1u, solver->pattern->nnz_p, values, solver->numbers.p);
}

orbsoc_error orbsoc_set_a(orbsoc_solver *solver, const double *values) {
  return missing(solver, values)
             ? ORBSOC_NO_POINTER
             : take(solver, 2u, solver->pattern->nnz_a, values, solver->numbers.a);
}

orbsoc_error orbsoc_set_g(orbsoc_solver *solver, const double *values) {
  return missing(solver, values)
             ? ORBSOC_NO_POINTER
             : take(solver, 4u, solver->pattern->given_nnz_g, values, solver->numbers.g);
}

orbsoc_error orbsoc_set_c(orbsoc_solver *solver, const double *values) {
  return missing(solver, values) ? ORBSOC_NO_POINTER
                                 : take(solver, 8u, solver->pattern->n, values, solver->numbers.c);
}

orbsoc_error orbsoc_set_b(orbsoc_solver *solver, const double *values) {
  return missing(solver, values) ? ORBSOC_NO_POINTER
                                 : take(solver, 16u, solver->pattern->p, values, solver->numbers.b);
}

/* A bound of this size or more is none: +infinity, and so is its row's in the pattern. */
#define ABSENT_FROM 1e20

orbsoc_error orbsoc_set_h(orbsoc_solver *solver, const double *values) {
  if (missing(solver, values) != 0) {
    return ORBSOC_NO_POINTER;
  }
  pattern_t pattern = solver->pattern;
  for (size_t i = 0; i < pattern->given_m; i++) {
    const int none = i < pattern->given_l && values[i] >= ABSENT_FROM;
    const int known = values[i] - values[i] == 0.0 && !none;
    if ((pattern->absent[i] != 0u) ? !none : !known) {
      return ORBSOC_BAD_VALUE;
    }
  }
  for (size_t i = 0; i < pattern->given_m; i++) {
    solver->numbers.h[i] = (pattern->absent[i] != 0u) ? (double)INFINITY : values[i];
  }
  solver->given |= 32u;
  return ORBSOC_OK;
}

const char *orbsoc_status_name(orbsoc_status status) {
  static const char *const names[] = {"SOLVED", "SOLVED_INACCURATE", "PRIMAL_INFEASIBLE",
                                      "DUAL_INFEASIBLE", "MAX_ITERATIONS", "MAX_TIME",
                                      "NUMERICAL_LIMIT", "INTERRUPTED"};
  return ((uint32_t)status < 8u) ? names[status] : "UNKNOWN";
}

/* The kernels, module by module. Sizes come from the pattern, outputs are last and alias no input.
 * A kernel branches on sizes and tables; where one branches on data, its comment says so. */
#ifndef ORBSOC_KERNELS_H
#define ORBSOC_KERNELS_H

#include "layout.h"
#include "real.h"

typedef const orbsoc_pattern *pattern_t;

/* Cones of more dimensions than this are written with two more unknowns. */
#define ORBSOC_DENSE_CONE 4u

static inline size_t unknowns_of(pattern_t pattern) {
  return (size_t)pattern->n + pattern->p + pattern->m;
}

/* Barrier degree: one a nonnegative row and one a second-order cone. */
static inline size_t degree_of(pattern_t pattern) { return (size_t)pattern->l + pattern->cones; }

/* Whether rows are many and adjacent, so that a loop over them needs no table; the sums are the
 * same. */
static inline int adjacent(size_t count, const orbsoc_index *rows) {
  return count >= 16u && (size_t)rows[count - 1] - rows[0] + 1u == count;
}

/* A word that counts, as a number; 0 for what counts nothing, as a device may have left it. */
static inline uint32_t orbsoc_count(orbsoc_real word) {
  return (0 <= word && word < 4294967040) ? (uint32_t)word : 0u;
}

/* matrix_scaling: Ruiz equilibration and its undoing */
typedef struct {
  orbsoc_real *p, *a, *g, *q;
  orbsoc_real *scale, *scale_inverse, *cost_scale;
} orbsoc_scaled;
void orbsoc_equilibrate(pattern_t pattern, const orbsoc_numbers *given, uint32_t passes,
                        const orbsoc_scaled *out, orbsoc_real *norms);
void orbsoc_rescale(pattern_t pattern, const orbsoc_numbers *given, const orbsoc_scaled *out);
void orbsoc_load_given(const orbsoc_solver *solver);
void orbsoc_norms(pattern_t pattern, const orbsoc_numbers *given, orbsoc_real *norms);
void orbsoc_load_start(pattern_t pattern, const orbsoc_real *start, const orbsoc_scaled *scales,
                       orbsoc_real *point, orbsoc_real *slack, orbsoc_real *homogenizer);
void orbsoc_undo(pattern_t pattern, const orbsoc_scaled *scales, const orbsoc_real *point,
                 orbsoc_real tau, orbsoc_real *out);
void orbsoc_undo_slack(pattern_t pattern, const orbsoc_scaled *scales, const orbsoc_real *slack,
                       orbsoc_real tau, orbsoc_real *out);

/* matrix_update: data and scaling blocks into the KKT matrix */
void orbsoc_load_kkt(pattern_t pattern, const orbsoc_real *p, const orbsoc_real *a,
                     const orbsoc_real *g, orbsoc_real *values);
void orbsoc_identity_blocks(pattern_t pattern, const orbsoc_real *parameters, orbsoc_real *values,
                            orbsoc_real *regularization);
void orbsoc_scaling_blocks(pattern_t pattern, const orbsoc_real *w, const orbsoc_real *cone,
                           orbsoc_real *values);

/* factorization: K + regularisation = LDL' */
void orbsoc_factorize(pattern_t pattern, const orbsoc_real *values,
                      const orbsoc_real *regularization, orbsoc_real *l,
                      orbsoc_real *pivot_inverse, orbsoc_real *y);

/* linear_solve: substitution and refinement, for `sides` right-hand sides side by side, 1 or 2 */
typedef struct {
  pattern_t pattern;
  const orbsoc_real *values;
  const orbsoc_real *l;
  const orbsoc_real *pivot_inverse;
  orbsoc_real *scratch;
} orbsoc_system;
void orbsoc_linear_solve(const orbsoc_system *system, size_t sides, const orbsoc_real *rhs,
                         orbsoc_real *x);
void orbsoc_measure(const orbsoc_system *system, size_t sides, const orbsoc_real *rhs,
                    orbsoc_real relative, orbsoc_real tolerance, const orbsoc_real *x,
                    orbsoc_real *error, orbsoc_real *state);
void orbsoc_refine(const orbsoc_system *system, size_t sides, const orbsoc_real *rhs,
                   orbsoc_real active, orbsoc_real *x, orbsoc_real *error, orbsoc_real *state);
void orbsoc_start_rhs(pattern_t pattern, const orbsoc_real *q, orbsoc_real *rhs,
                      orbsoc_real *tolerance);
void orbsoc_start_point(pattern_t pattern, const orbsoc_real *q, const orbsoc_real *solution,
                        orbsoc_real *point, orbsoc_real *slack);
void orbsoc_newton_start_rhs(pattern_t pattern, const orbsoc_real *q, const orbsoc_real *slack,
                             orbsoc_real *rhs);
void orbsoc_unload(pattern_t pattern, size_t count, const orbsoc_real *permuted, size_t sides,
                   size_t side, orbsoc_real *natural);

/* cone_ops: Nesterov-Todd scaling and what is done with it */
typedef struct {
  orbsoc_real *w, *lambda, *lambda_inverse, *cone;
} orbsoc_scaling;
void orbsoc_nt_scaling(pattern_t pattern, const orbsoc_real *s, const orbsoc_real *z,
                       const orbsoc_scaling *out);
void orbsoc_scale(pattern_t pattern, const orbsoc_real *w, const orbsoc_real *cone,
                  const orbsoc_real *x, orbsoc_real *out);
void orbsoc_cone_divide(pattern_t pattern, const orbsoc_scaling *at, const orbsoc_real *d,
                        orbsoc_real *out);
void orbsoc_shift_into_cone(pattern_t pattern, orbsoc_real *v);
void orbsoc_predictor_rhs(pattern_t pattern, const orbsoc_real *q, const orbsoc_real *residual,
                          const orbsoc_real *slack, orbsoc_real *rhs);
void orbsoc_corrector_rhs(pattern_t pattern, orbsoc_real damping, const orbsoc_real *residual,
                          const orbsoc_real *lifted, orbsoc_real *rhs);
void orbsoc_central_pair(pattern_t pattern, orbsoc_real mu, orbsoc_real *s, orbsoc_real *z);
void orbsoc_add_scaled(size_t count, orbsoc_real step, const orbsoc_real *other,
                       orbsoc_real *direction);

/* line_search: the largest step that stays in the cone */
orbsoc_real orbsoc_inverse_step(pattern_t pattern, const orbsoc_scaling *at,
                                const orbsoc_real *delta, orbsoc_real *rho);

/* statistics: residuals, scalars of the embedding, decisions */
typedef struct {
  const orbsoc_real *p, *a, *g, *q, *norms, *scale_inverse, *cost_scale;
  const orbsoc_real *point, *slack, *homogenizer, *parameters;
} orbsoc_iterate;
typedef struct {
  orbsoc_real *products, *residual, *cost_product, *embedding, *centering, *statistics;
  orbsoc_real *refinement_tolerance, *regularization;
} orbsoc_statistics_out;
void orbsoc_statistics(pattern_t pattern, const orbsoc_iterate *at,
                       const orbsoc_statistics_out *out);
void orbsoc_embedding_pivot(pattern_t pattern, const orbsoc_real *q, const orbsoc_real *constant,
                            const orbsoc_real *cost_product, const orbsoc_real *homogenizer,
                            orbsoc_real *embedding);
void orbsoc_tau_step(pattern_t pattern, const orbsoc_real *q, const orbsoc_real *step,
                     const orbsoc_real *cost_product, const orbsoc_real *homogenizer,
                     const orbsoc_real *embedding, const orbsoc_real *centering,
                     orbsoc_real *tau_step);
void orbsoc_centering(orbsoc_real step_length, orbsoc_real mu, const orbsoc_real *homogenizer,
                      const orbsoc_real *tau_step, orbsoc_real most, orbsoc_real *centering,
                      orbsoc_real *boundary_fraction);
void orbsoc_cone_product(pattern_t pattern, const orbsoc_real *lambda,
                         const orbsoc_real *scaled_s, const orbsoc_real *scaled_z,
                         const orbsoc_real *centering, orbsoc_real *out);
void orbsoc_first_regularization(const orbsoc_real *parameters, orbsoc_real *out);

/* decisions, the second half of statistics */
typedef struct {
  orbsoc_real best, primal, dual;
} orbsoc_keep;
orbsoc_keep orbsoc_judge(const orbsoc_real *stats, const orbsoc_real *homogenizer,
                         orbsoc_real tolerance, orbsoc_real *words);
void orbsoc_refine_again(size_t sides, const orbsoc_real *entries, orbsoc_real *active,
                         orbsoc_real *words);
orbsoc_real orbsoc_judge_start(orbsoc_real mu, double highest);
void orbsoc_count_step(orbsoc_real taken, orbsoc_real *words);

/* certificate on the original data */
void orbsoc_conclude(orbsoc_solver *solver);

#endif

/* From a stage's number to its kernels: which buffers each call gets. */
#include "kernels.h"
#include "method.h"
#include "reduce.h"

/* A start is rejected from this barrier parameter on, in scaled data, and from the second after its
 * step. */
#define WARM_START_MU_MAX 0.5
#define WARM_STEP_MU_MAX 1e3

typedef orbsoc_real *const *buffers_t;

static void set_homogenizer(orbsoc_real kappa, orbsoc_real *homogenizer) {
  homogenizer[TAU] = 1;
  homogenizer[KAPPA] = kappa;
  homogenizer[STEPPED] = 0;
}

static orbsoc_scaled scaled_of(buffers_t b) {
  const orbsoc_scaled out = {b[ORBSOC_P], b[ORBSOC_A], b[ORBSOC_G], b[ORBSOC_Q],
                             b[ORBSOC_SCALE], b[ORBSOC_SCALE_INVERSE], b[ORBSOC_COST_SCALE]};
  return out;
}

static void matrix_scaling(const orbsoc_solver *solver, orbsoc_stage stage, int anew) {
  pattern_t pattern = solver->pattern;
  buffers_t b = solver->buffer;
  const size_t all = unknowns_of(pattern);
  const orbsoc_scaled scaled = scaled_of(b);
  if (stage == STAGE_EQUILIBRATE && anew == 0) {
    orbsoc_rescale(pattern, &solver->numbers, &scaled);
  } else if (stage == STAGE_EQUILIBRATE) {
    orbsoc_equilibrate(pattern, &solver->numbers, solver->settings.ruiz_passes, &scaled,
                       solver->scratch);
  } else if (stage == STAGE_LOAD_START) {
    orbsoc_load_start(pattern, b[ORBSOC_START], &scaled, b[ORBSOC_POINT], b[ORBSOC_SLACK],
                      b[ORBSOC_HOMOGENIZER]);
  } else {
    const orbsoc_real *best = b[ORBSOC_BEST], tau = best[all + pattern->m];
    orbsoc_undo(pattern, &scaled, best, tau, b[ORBSOC_UNSCALED_ITERATE]);
    orbsoc_undo_slack(pattern, &scaled, &best[all], tau, &b[ORBSOC_UNSCALED_ITERATE][all]);
    orbsoc_undo(pattern, &scaled, b[ORBSOC_PRIMAL_CERTIFICATE], 1,
                b[ORBSOC_UNSCALED_CERTIFICATES]);
    orbsoc_undo(pattern, &scaled, b[ORBSOC_DUAL_CERTIFICATE], 1,
                &b[ORBSOC_UNSCALED_CERTIFICATES][all]);
  }
}

static void matrix_update(const orbsoc_solver *solver, orbsoc_stage stage, int anew) {
  buffers_t b = solver->buffer;
  if (stage == STAGE_LOAD_KKT) {
    if (anew != 0) {
      orbsoc_load_kkt(solver->pattern, b[ORBSOC_P], b[ORBSOC_A], b[ORBSOC_G],
                      b[ORBSOC_KKT_VALUES]);
    }
  } else if (stage == STAGE_IDENTITY_BLOCKS) {
    orbsoc_identity_blocks(solver->pattern, b[ORBSOC_PARAMETERS], b[ORBSOC_KKT_VALUES],
                           b[ORBSOC_REGULARIZATION]);
  } else {
    orbsoc_scaling_blocks(solver->pattern, b[ORBSOC_W], b[ORBSOC_CONE], b[ORBSOC_KKT_VALUES]);
  }
}

static orbsoc_system system_of(const orbsoc_solver *solver) {
  buffers_t b = solver->buffer;
  const orbsoc_system out = {solver->pattern, b[ORBSOC_KKT_VALUES], b[ORBSOC_FACTOR_L],
                             b[ORBSOC_PIVOT_INVERSE], solver->scratch};
  return out;
}

/* Substitute `sides` right-hand sides; measure the residual where a decision needs it. */
static void solve_sides(const orbsoc_solver *solver, size_t sides, int measured) {
  buffers_t b = solver->buffer;
  const orbsoc_system system = system_of(solver);
  const orbsoc_real *rhs = b[(sides == 1u) ? ORBSOC_KKT_RHS : ORBSOC_MULTI_RHS];
  orbsoc_real *x = b[(sides == 1u) ? ORBSOC_KKT_SOLUTION : ORBSOC_MULTI_SOLUTION];
  orbsoc_linear_solve(&system, sides, rhs, x);
  if (measured != 0) {
    orbsoc_measure(&system, sides, rhs, b[ORBSOC_PARAMETERS][REFINEMENT_TOL],
                   b[ORBSOC_REFINEMENT_TOLERANCE][0], x,
                   b[(sides == 1u) ? ORBSOC_KKT_ERROR : ORBSOC_MULTI_ERROR],
                   b[(sides == 1u) ? ORBSOC_REFINEMENT : ORBSOC_MULTI_REFINEMENT]);
    b[ORBSOC_REFINEMENT_ACTIVE][0] = 1;
  }
}

static void refine_sides(const orbsoc_solver *solver, size_t sides) {
  buffers_t b = solver->buffer;
  const orbsoc_system system = system_of(solver);
  const orbsoc_real active = b[ORBSOC_REFINEMENT_ACTIVE][0];
  if (sides == 1u) {
    orbsoc_refine(&system, 1, b[ORBSOC_KKT_RHS], active, b[ORBSOC_KKT_SOLUTION],
                  b[ORBSOC_KKT_ERROR], b[ORBSOC_REFINEMENT]);
  } else {
    orbsoc_refine(&system, 2, b[ORBSOC_MULTI_RHS], active, b[ORBSOC_MULTI_SOLUTION],
                  b[ORBSOC_MULTI_ERROR], b[ORBSOC_MULTI_REFINEMENT]);
  }
}

static void linear_solve(const orbsoc_solver *solver, orbsoc_stage stage, int measured) {
  pattern_t pattern = solver->pattern;
  buffers_t b = solver->buffer;
  const size_t all = unknowns_of(pattern);
  switch (stage) {
    case STAGE_START_RHS:
      orbsoc_start_rhs(pattern, b[ORBSOC_Q], b[ORBSOC_MULTI_RHS], b[ORBSOC_REFINEMENT_TOLERANCE]);
      break;
    case STAGE_START_POINT:
      orbsoc_start_point(pattern, b[ORBSOC_Q], b[ORBSOC_MULTI_SOLUTION], b[ORBSOC_POINT],
                         b[ORBSOC_SLACK]);
      break;
    case STAGE_NEWTON_START_RHS:
      orbsoc_newton_start_rhs(pattern, b[ORBSOC_Q], b[ORBSOC_SLACK], b[ORBSOC_KKT_RHS]);
      break;
    case STAGE_SOLVE_PAIR:
      solve_sides(solver, 2, measured);
      break;
    case STAGE_SOLVE_KKT:
      solve_sides(solver, 1, measured);
      break;
    case STAGE_REFINE_PAIR:
      refine_sides(solver, 2);
      break;
    case STAGE_REFINE_KKT:
      refine_sides(solver, 1);
      break;
    case STAGE_STORE_PAIR:
      orbsoc_unload(pattern, all, b[ORBSOC_MULTI_SOLUTION], 2, 0, b[ORBSOC_CONSTANT_SOLUTION]);
      orbsoc_unload(pattern, all, b[ORBSOC_MULTI_SOLUTION], 2, 1, b[ORBSOC_STEP]);
      break;
    default:
      orbsoc_unload(pattern, all, b[ORBSOC_KKT_SOLUTION], 1, 0, b[ORBSOC_STEP]);
      break;
  }
}

/* Onto the central path: s from Gx + s = h, and mu from the residuals. */
static void center_start(const orbsoc_solver *solver) {
  pattern_t pattern = solver->pattern;
  buffers_t b = solver->buffer;
  const size_t n = pattern->n, rows = n + pattern->p, all = unknowns_of(pattern);
  const orbsoc_real *residual = b[ORBSOC_RESIDUAL];
  const orbsoc_real dual = max_abs(n, residual), primal = max_abs(all - n, &residual[n]);
  const orbsoc_real worst = larger(primal, dual);
  const orbsoc_real product = real(0.3) * (primal * dual), square = real(1e-4) * (worst * worst);
  const orbsoc_real mu = larger(larger(b[ORBSOC_PARAMETERS][START_FLOOR], product), square);
  for (size_t i = 0; i < pattern->m; i++) {
    b[ORBSOC_SLACK][i] = b[ORBSOC_SLACK][i] - residual[rows + i];
  }
  orbsoc_central_pair(pattern, mu, b[ORBSOC_SLACK], &b[ORBSOC_POINT][rows]);
  set_homogenizer(mu, b[ORBSOC_HOMOGENIZER]);
  b[ORBSOC_VERDICT][0] = orbsoc_judge_start(mu, WARM_START_MU_MAX);
}

/* Take the Newton step, and move onto the central path again, at a mu from the square of a long
 * move. */
static void newton_start(const orbsoc_solver *solver) {
  pattern_t pattern = solver->pattern;
  buffers_t b = solver->buffer;
  const size_t m = pattern->m, rows = (size_t)pattern->n + pattern->p;
  orbsoc_real *z = &b[ORBSOC_POINT][rows], *slack = b[ORBSOC_SLACK];
  orbsoc_real *delta = solver->scratch, *scaled = &delta[m];
  orbsoc_real mu = b[ORBSOC_HOMOGENIZER][KAPPA];
  orbsoc_unload(pattern, rows, b[ORBSOC_KKT_SOLUTION], 1, 0, b[ORBSOC_POINT]);
  for (size_t i = 0; i < m; i++) {
    const orbsoc_real stepped = b[ORBSOC_KKT_SOLUTION][pattern->position[rows + i]];
    delta[i] = stepped - z[i];
    z[i] = stepped;
  }
  orbsoc_scale(pattern, b[ORBSOC_W], b[ORBSOC_CONE], delta, scaled);
  orbsoc_scale(pattern, b[ORBSOC_W], b[ORBSOC_CONE], scaled, delta);
  for (size_t i = 0; i < m; i++) {
    slack[i] = slack[i] - delta[i];
    delta[i] = slack[i];
  }
  orbsoc_central_pair(pattern, mu, slack, z);
  for (size_t i = 0; i < m; i++) { delta[i] = delta[i] - slack[i]; }
  const orbsoc_real distance = max_abs(m, delta);
  mu = larger(mu, real(0.5) * (distance * distance));
  orbsoc_central_pair(pattern, mu, slack, z);
  const orbsoc_real kappa = (mu < real(WARM_STEP_MU_MAX)) ? smaller(mu, 1) : mu;
  set_homogenizer(kappa, b[ORBSOC_HOMOGENIZER]);
  b[ORBSOC_VERDICT][0] = orbsoc_judge_start(kappa, WARM_STEP_MU_MAX);
}

static orbsoc_scaling scaling_of(buffers_t b) {
  const orbsoc_scaling out = {b[ORBSOC_W], b[ORBSOC_LAMBDA], b[ORBSOC_LAMBDA_INVERSE],
                              b[ORBSOC_CONE]};
  return out;
}

/* The direction with dtau, and W dz, W^-1 ds. */
static void direction(const orbsoc_solver *solver) {
  pattern_t pattern = solver->pattern;
  buffers_t b = solver->buffer;
  const size_t rows = (size_t)pattern->n + pattern->p;
  orbsoc_add_scaled(unknowns_of(pattern), b[ORBSOC_TAU_STEP][0], b[ORBSOC_CONSTANT_SOLUTION],
                    b[ORBSOC_STEP]);
  orbsoc_scale(pattern, b[ORBSOC_W], b[ORBSOC_CONE], &b[ORBSOC_STEP][rows], b[ORBSOC_SCALED_Z]);
  for (size_t i = 0; i < pattern->m; i++) {
    b[ORBSOC_SCALED_S][i] = (-b[ORBSOC_CONE_DIVISION][i]) - b[ORBSOC_SCALED_Z][i];
  }
}

static void cone_ops(const orbsoc_solver *solver, orbsoc_stage stage) {
  pattern_t pattern = solver->pattern;
  buffers_t b = solver->buffer;
  const orbsoc_scaling at = scaling_of(b);
  const size_t rows = (size_t)pattern->n + pattern->p;
  switch (stage) {
    case STAGE_START_SHIFT:
      orbsoc_shift_into_cone(pattern, b[ORBSOC_SLACK]);
      orbsoc_shift_into_cone(pattern, &b[ORBSOC_POINT][rows]);
      set_homogenizer(1, b[ORBSOC_HOMOGENIZER]);
      break;
    case STAGE_CENTER_START:
      center_start(solver);
      break;
    case STAGE_NEWTON_START:
      newton_start(solver);
      break;
    case STAGE_NT_SCALING:
      orbsoc_nt_scaling(pattern, b[ORBSOC_SLACK], &b[ORBSOC_POINT][rows], &at);
      break;
    case STAGE_PREDICTOR_RHS:
      for (size_t i = 0; i < pattern->m; i++) { b[ORBSOC_CONE_DIVISION][i] = b[ORBSOC_LAMBDA][i]; }
      orbsoc_predictor_rhs(pattern, b[ORBSOC_Q], b[ORBSOC_RESIDUAL], b[ORBSOC_SLACK],
                           b[ORBSOC_MULTI_RHS]);
      break;
    case STAGE_CORRECTOR_RHS:
      orbsoc_cone_divide(pattern, &at, b[ORBSOC_COMPLEMENTARITY_RHS], b[ORBSOC_CONE_DIVISION]);
      orbsoc_scale(pattern, b[ORBSOC_W], b[ORBSOC_CONE], b[ORBSOC_CONE_DIVISION],
                   solver->scratch);
      orbsoc_corrector_rhs(pattern, b[ORBSOC_CENTERING][DAMPING], b[ORBSOC_RESIDUAL],
                           solver->scratch, b[ORBSOC_KKT_RHS]);
      break;
    case STAGE_DIRECTION:
      direction(solver);
      break;
    default:
      orbsoc_scale(pattern, b[ORBSOC_W], b[ORBSOC_CONE], b[ORBSOC_SCALED_S],
                   b[ORBSOC_SLACK_STEP]);
      break;
  }
}

static void line_search(const orbsoc_solver *solver) {
  buffers_t b = solver->buffer;
  const orbsoc_scaling at = scaling_of(b);
  const orbsoc_real *step = b[ORBSOC_TAU_STEP], *homogenizer = b[ORBSOC_HOMOGENIZER];
  orbsoc_real inverse = larger(-step[0] / homogenizer[TAU], -step[1] / homogenizer[KAPPA]);
  inverse = larger(inverse, orbsoc_inverse_step(solver->pattern, &at, b[ORBSOC_SCALED_S],
                                                solver->scratch));
  inverse = larger(inverse, orbsoc_inverse_step(solver->pattern, &at, b[ORBSOC_SCALED_Z],
                                                solver->scratch));
  b[ORBSOC_STEP_LENGTH][0] = 1 / larger(inverse, real(1e-6));
}

/* Keep a vector in place of the one kept so far where the flag is raised: a branch on data around a
 * copy. */
static void keep(orbsoc_real flag, size_t count, const orbsoc_real *from, orbsoc_real *to) {
  for (size_t i = 0; i < count && 0 < flag; i++) { to[i] = from[i]; }
}

/* Residuals and ratios, whether the attempt ends, and what of the iterate is better than what was
 * kept. */
static void residuals_and_verdict(const orbsoc_solver *solver) {
  pattern_t pattern = solver->pattern;
  buffers_t b = solver->buffer;
  const size_t all = unknowns_of(pattern), m = pattern->m;
  const orbsoc_iterate at = {b[ORBSOC_P], b[ORBSOC_A], b[ORBSOC_G], b[ORBSOC_Q], b[ORBSOC_NORMS],
                             b[ORBSOC_SCALE_INVERSE], b[ORBSOC_COST_SCALE], b[ORBSOC_POINT],
                             b[ORBSOC_SLACK], b[ORBSOC_HOMOGENIZER], b[ORBSOC_PARAMETERS]};
  const orbsoc_statistics_out out = {solver->scratch, b[ORBSOC_RESIDUAL], b[ORBSOC_COST_PRODUCT],
                                     b[ORBSOC_EMBEDDING], b[ORBSOC_CENTERING],
                                     b[ORBSOC_STATISTICS], b[ORBSOC_REFINEMENT_TOLERANCE],
                                     b[ORBSOC_REGULARIZATION]};
  orbsoc_statistics(pattern, &at, &out);
  const orbsoc_keep found =
      orbsoc_judge(b[ORBSOC_STATISTICS], b[ORBSOC_HOMOGENIZER],
                   b[ORBSOC_REFINEMENT_TOLERANCE][0], b[ORBSOC_CONTROL]);
  keep(found.best, all, b[ORBSOC_POINT], b[ORBSOC_BEST]);
  keep(found.best, m, b[ORBSOC_SLACK], &b[ORBSOC_BEST][all]);
  keep(found.best, 1, b[ORBSOC_HOMOGENIZER], &b[ORBSOC_BEST][all + m]);
  keep(found.primal, all, b[ORBSOC_POINT], b[ORBSOC_PRIMAL_CERTIFICATE]);
  keep(found.dual, all, b[ORBSOC_POINT], b[ORBSOC_DUAL_CERTIFICATE]);
  keep(found.dual, m, b[ORBSOC_SLACK], &b[ORBSOC_DUAL_CERTIFICATE][all]);
}

/* Take the step: all of it, or the allowed fraction of the way to the boundary. */
static void advance(const orbsoc_solver *solver) {
  pattern_t pattern = solver->pattern;
  buffers_t b = solver->buffer;
  const orbsoc_real alpha =
      smaller(1, b[ORBSOC_BOUNDARY_FRACTION][0] * b[ORBSOC_STEP_LENGTH][0]);
  b[ORBSOC_STEP_TAKEN][0] = alpha;
  orbsoc_add_scaled(unknowns_of(pattern), alpha, b[ORBSOC_STEP], b[ORBSOC_POINT]);
  orbsoc_add_scaled(pattern->m, alpha, b[ORBSOC_SLACK_STEP], b[ORBSOC_SLACK]);
  orbsoc_add_scaled(2, alpha, b[ORBSOC_TAU_STEP], b[ORBSOC_HOMOGENIZER]);
  b[ORBSOC_HOMOGENIZER][STEPPED] = 1;
  orbsoc_count_step(alpha, b[ORBSOC_CONTROL]);
}

static void statistics(const orbsoc_solver *solver, orbsoc_stage stage) {
  pattern_t pattern = solver->pattern;
  buffers_t b = solver->buffer;
  switch (stage) {
    case STAGE_STATISTICS:
      residuals_and_verdict(solver);
      break;
    case STAGE_CHECK_PAIR:
      orbsoc_refine_again(2, b[ORBSOC_MULTI_REFINEMENT], b[ORBSOC_REFINEMENT_ACTIVE],
                          b[ORBSOC_CONTROL]);
      break;
    case STAGE_CHECK_SOLVE:
      orbsoc_refine_again(1, b[ORBSOC_REFINEMENT], b[ORBSOC_REFINEMENT_ACTIVE],
                          b[ORBSOC_CONTROL]);
      break;
    case STAGE_EMBEDDING_PIVOT:
      orbsoc_embedding_pivot(pattern, b[ORBSOC_Q], b[ORBSOC_CONSTANT_SOLUTION],
                             b[ORBSOC_COST_PRODUCT], b[ORBSOC_HOMOGENIZER], b[ORBSOC_EMBEDDING]);
      break;
    case STAGE_TAU_STEP:
      orbsoc_tau_step(pattern, b[ORBSOC_Q], b[ORBSOC_STEP], b[ORBSOC_COST_PRODUCT],
                      b[ORBSOC_HOMOGENIZER], b[ORBSOC_EMBEDDING], b[ORBSOC_CENTERING],
                      b[ORBSOC_TAU_STEP]);
      break;
    case STAGE_CENTERING:
      orbsoc_centering(b[ORBSOC_STEP_LENGTH][0], b[ORBSOC_STATISTICS][STAT_MU],
                       b[ORBSOC_HOMOGENIZER], b[ORBSOC_TAU_STEP],
                       b[ORBSOC_PARAMETERS][STEP_FRACTION], b[ORBSOC_CENTERING],
                       b[ORBSOC_BOUNDARY_FRACTION]);
      break;
    case STAGE_CONE_PRODUCT:
      orbsoc_cone_product(pattern, b[ORBSOC_LAMBDA], b[ORBSOC_SCALED_S], b[ORBSOC_SCALED_Z],
                          b[ORBSOC_CENTERING], b[ORBSOC_COMPLEMENTARITY_RHS]);
      break;
    default:
      advance(solver);
      break;
  }
}

/* The module of each stage, in the order of their numbers. */
enum { MATRIX_UPDATE = 1, MATRIX_SCALING, FACTORIZATION, LINEAR_SOLVE, CONE_OPS, LINE_SEARCH,
       STATISTICS };
static const uint8_t module_of[ORBSOC_STAGES] = {
    MATRIX_SCALING, MATRIX_UPDATE, MATRIX_UPDATE, MATRIX_UPDATE, FACTORIZATION, LINEAR_SOLVE,
    LINEAR_SOLVE, CONE_OPS, MATRIX_SCALING, CONE_OPS, LINEAR_SOLVE, CONE_OPS, STATISTICS, CONE_OPS,
    CONE_OPS, LINEAR_SOLVE, LINEAR_SOLVE, STATISTICS, LINEAR_SOLVE, LINEAR_SOLVE, LINEAR_SOLVE,
    STATISTICS, STATISTICS, LINEAR_SOLVE, STATISTICS, CONE_OPS, LINE_SEARCH, STATISTICS, STATISTICS,
    CONE_OPS, CONE_OPS, STATISTICS, MATRIX_SCALING};

/* `whole`: with nothing left out that a decision does not need, or that is there already. */
static void execute(orbsoc_solver *solver, orbsoc_stage stage, int whole) {
  buffers_t b = solver->buffer;
  const uint32_t needed = (stage == STAGE_EQUILIBRATE) ? 1u : 2u;
  const int anew = whole != 0 || solver->kept < needed;
  const int measured = whole != 0 || b[ORBSOC_CONTROL][WORD_NEEDS_RESIDUAL] != 0;
  switch (module_of[stage]) {
    case MATRIX_SCALING:
      matrix_scaling(solver, stage, anew);
      break;
    case MATRIX_UPDATE:
      matrix_update(solver, stage, anew);
      break;
    case FACTORIZATION:
      orbsoc_factorize(solver->pattern, b[ORBSOC_KKT_VALUES], b[ORBSOC_REGULARIZATION],
                       b[ORBSOC_FACTOR_L], b[ORBSOC_PIVOT_INVERSE], solver->scratch);
      break;
    case LINEAR_SOLVE:
      linear_solve(solver, stage, measured);
      break;
    case CONE_OPS:
      cone_ops(solver, stage);
      break;
    case LINE_SEARCH:
      line_search(solver);
      break;
    default:
      statistics(solver, stage);
      break;
  }
  /* A cost's factor is in P: what has P is made anew each time. */
  if ((stage == STAGE_EQUILIBRATE || stage == STAGE_LOAD_KKT) && solver->kept < needed) {
    solver->kept = (solver->pattern->nnz_p == 0u && solver->away == 0u) ? needed : 0u;
  }
}

uint32_t orbsoc_or_from_outside(const orbsoc_solver *solver, uint32_t reason) {
  uint32_t answer = 0;
  if (solver->ask != NULL) {
    answer = (uint32_t)solver->ask(solver->context);
  }
  return (answer != 0u && (reason == 0u || reason > answer)) ? answer : reason;
}

/* Run a stage where the partition has it; the core needs the flag that a decision leaves. */
static void execute_partitioned(orbsoc_solver *solver, orbsoc_stage stage, uint64_t flag) {
  if (orbsoc_runs_there(solver, module_of[stage]) != 0) {
    orbsoc_stage_there(solver, stage);
    orbsoc_move_here(solver, flag);
  } else {
    orbsoc_before_stage_here(solver, stage);
    execute(solver, stage, 1);
    orbsoc_after_stage_here(solver, stage);
  }
}

orbsoc_outcome orbsoc_run(orbsoc_solver *solver, orbsoc_stage stage, int whole) {
  buffers_t b = solver->buffer;
  const int repeats = stage == STAGE_CHECK_PAIR || stage == STAGE_CHECK_SOLVE;
  const int judges = stage == STAGE_CENTER_START || stage == STAGE_NEWTON_START;
  uint32_t reason = 0;
  if (solver->away == 0u) {
    execute(solver, stage, whole);
  } else {
    const uint32_t flag = (repeats != 0) ? ORBSOC_REFINEMENT_ACTIVE
                                  : ((judges != 0) ? ORBSOC_VERDICT : ORBSOC_CONTROL);
    const int decides = repeats || judges || stage == STAGE_STATISTICS;
    execute_partitioned(solver, stage, (decides != 0) ? (uint64_t)1 << flag : 0u);
    if (orbsoc_try_is_over(solver) != 0) {
      return ORBSOC_DONE;
    }
  }
  if (repeats != 0) {
    return (b[ORBSOC_REFINEMENT_ACTIVE][0] != 0) ? ORBSOC_REPEAT : ORBSOC_NEXT;
  }
  if (stage == STAGE_STATISTICS) {
    reason = orbsoc_or_from_outside(solver, orbsoc_count(b[ORBSOC_CONTROL][WORD_STOP]));
  } else if (judges != 0) {
    reason = orbsoc_count(b[ORBSOC_VERDICT][0]);
  }
  if (reason == 0u) {
    return ORBSOC_NEXT;
  }
  solver->stop = reason;
  b[ORBSOC_CONTROL][WORD_STOP] = (orbsoc_real)reason;
  return ORBSOC_DONE;
}

/* The lists of the method, attempts and restarts. */
#include "method.h"

#include "kernels.h"

#define ONCE(stage) {(stage), (stage)}
#define COUNT(list) (sizeof(list) / sizeof((list)[0]))

/* A solve that meets the tolerance, but not this fraction of it, takes one iteration more; after a
 * warm start, the second. */
#define TOLERANCE_MARGIN 0.2
#define WARM_TOLERANCE_MARGIN 0.5
/* Least barrier parameter of a warm start. */
#define LEAST_START 1e-10

static const orbsoc_step startup[] = {
    ONCE(STAGE_EQUILIBRATE), ONCE(STAGE_LOAD_KKT), ONCE(STAGE_IDENTITY_BLOCKS),
    ONCE(STAGE_FACTORIZE), ONCE(STAGE_START_RHS), ONCE(STAGE_SOLVE_PAIR),
    {STAGE_REFINE_PAIR, STAGE_CHECK_PAIR}, ONCE(STAGE_START_POINT), ONCE(STAGE_START_SHIFT)};

static const orbsoc_step warm_startup[] = {
    ONCE(STAGE_EQUILIBRATE), ONCE(STAGE_LOAD_KKT), ONCE(STAGE_LOAD_START), ONCE(STAGE_STATISTICS),
    ONCE(STAGE_CENTER_START), ONCE(STAGE_NT_SCALING), ONCE(STAGE_SCALING_BLOCKS),
    ONCE(STAGE_FACTORIZE), ONCE(STAGE_NEWTON_START_RHS), ONCE(STAGE_SOLVE_KKT),
    {STAGE_REFINE_KKT, STAGE_CHECK_SOLVE}, ONCE(STAGE_NEWTON_START)};

static const orbsoc_step iteration[] = {
    ONCE(STAGE_STATISTICS), ONCE(STAGE_NT_SCALING), ONCE(STAGE_SCALING_BLOCKS),
    ONCE(STAGE_FACTORIZE), ONCE(STAGE_PREDICTOR_RHS), ONCE(STAGE_SOLVE_PAIR),
    {STAGE_REFINE_PAIR, STAGE_CHECK_PAIR}, ONCE(STAGE_STORE_PAIR), ONCE(STAGE_EMBEDDING_PIVOT),
    ONCE(STAGE_TAU_STEP), ONCE(STAGE_DIRECTION), ONCE(STAGE_STEP_LENGTH), ONCE(STAGE_CENTERING),
    ONCE(STAGE_CONE_PRODUCT), ONCE(STAGE_CORRECTOR_RHS), ONCE(STAGE_SOLVE_KKT),
    {STAGE_REFINE_KKT, STAGE_CHECK_SOLVE}, ONCE(STAGE_STORE_STEP), ONCE(STAGE_TAU_STEP),
    ONCE(STAGE_DIRECTION), ONCE(STAGE_SLACK_STEP), ONCE(STAGE_STEP_LENGTH), ONCE(STAGE_ADVANCE)};

static const orbsoc_step closing[] = {ONCE(STAGE_UNSCALE)};

const orbsoc_list orbsoc_startup = {startup, COUNT(startup)};
const orbsoc_list orbsoc_warm_startup = {warm_startup, COUNT(warm_startup)};
const orbsoc_list orbsoc_iteration = {iteration, COUNT(iteration)};
const orbsoc_list orbsoc_closing = {closing, COUNT(closing)};

#define BIT(k) (1u << (uint32_t)(k))
#define UNSETTLED \
  (BIT(ORBSOC_SOLVED_INACCURATE) | BIT(ORBSOC_MAX_ITERATIONS) | BIT(ORBSOC_NUMERICAL_LIMIT))
#define INFEASIBLE (BIT(ORBSOC_PRIMAL_INFEASIBLE) | BIT(ORBSOC_DUAL_INFEASIBLE))

const orbsoc_restart orbsoc_restarts[ORBSOC_RESTARTS] = {
    {BIT(ATTEMPT_WARM), 0, UNSETTLED, ATTEMPT_COLD, 1.0, 1.0},
    {BIT(ATTEMPT_WARM), 1, INFEASIBLE, ATTEMPT_COLD, 1.0, 1.0},
    {BIT(ATTEMPT_COLD) | BIT(ATTEMPT_REFINED), 1, INFEASIBLE, ATTEMPT_LIGHT, 0.1, 0.01},
    {BIT(ATTEMPT_COLD), 1, UNSETTLED, ATTEMPT_REFINED, 0.1, 1.0},
    {BIT(ATTEMPT_REFINED), 1, BIT(ORBSOC_NUMERICAL_LIMIT), ATTEMPT_REGULARIZED, 0.1, 10.0},
    {BIT(ATTEMPT_REFINED) | BIT(ATTEMPT_REGULARIZED), 1, UNSETTLED, ATTEMPT_LIGHT, 0.1, 0.01}};

static double least(double a, double b) { return (b < a) ? b : a; }
static double most(double a, double b) { return (a < b) ? b : a; }

/* Parameters of an attempt: factors of its row of the restart policy on the settings. */
static void set_parameters(const orbsoc_solver *solver, orbsoc_attempt attempt) {
  const orbsoc_settings *settings = &solver->settings;
  orbsoc_real *entries = solver->buffer[ORBSOC_PARAMETERS];
  const double share = settings->refinement_share * least(settings->tol / 1e-8, 1.0);
  double refinement = 1.0, regularization = 1.0;
  for (size_t k = ORBSOC_RESTARTS; k-- > 0u;) {
    if (orbsoc_restarts[k].attempt == (uint32_t)attempt) {
      refinement = orbsoc_restarts[k].refinement_factor;
      regularization = orbsoc_restarts[k].regularization_factor;
    }
  }
  entries[STATIC_REGULARIZATION] = real(regularization * settings->static_regularization);
  entries[PIVOT_FLOOR] = real(settings->pivot_floor);
  entries[DYNAMIC_REGULARIZATION] = real(settings->dynamic_regularization);
  entries[STEP_FRACTION] = real(settings->step_fraction);
  entries[REFINEMENT_TOL] = real(settings->refinement_tol);
  entries[REFINEMENT_SHARE] = real(refinement * share);
  entries[RESIDUAL_FLOOR] = real(0.01 * settings->tol);
  entries[START_FLOOR] = real(most(LEAST_START, 0.01 * settings->tol));
}

/* Forget what an attempt decided and kept, and set its limits. */
static void prepare(const orbsoc_solver *solver, orbsoc_attempt attempt) {
  pattern_t pattern = solver->pattern;
  const orbsoc_settings *settings = &solver->settings;
  orbsoc_real *words = solver->buffer[ORBSOC_CONTROL];
  const size_t all = unknowns_of(pattern), m = pattern->m;
  const double margin = (attempt == ATTEMPT_WARM) ? WARM_TOLERANCE_MARGIN : TOLERANCE_MARGIN;
  set_parameters(solver, attempt);
  solver->buffer[ORBSOC_VERDICT][0] = 0;
  for (size_t i = 0; i < all + m + 1; i++) { solver->buffer[ORBSOC_BEST][i] = 0; }
  for (size_t i = 0; i < all; i++) { solver->buffer[ORBSOC_PRIMAL_CERTIFICATE][i] = 0; }
  for (size_t i = 0; i < all + m; i++) { solver->buffer[ORBSOC_DUAL_CERTIFICATE][i] = 0; }
  for (size_t k = 0; k < CONTROL_WORDS; k++) { words[k] = 0; }
  /* Before there is a tolerance, every residual is checked. */
  words[WORD_NEEDS_RESIDUAL] = 1;
  words[WORD_BEST] = real((double)INFINITY);
  for (size_t k = 0; k < 3u; k++) { words[WORD_LEAST + k] = real((double)INFINITY); }
  words[WORD_TOLERANCE_AIM] = real(margin * settings->tol);
  words[WORD_TOLERANCE_MET] = real(settings->tol);
  words[WORD_MAX_ITERATIONS] = real((double)settings->max_iterations);
  words[WORD_MAX_REFINEMENTS] = real((double)settings->refinement_max);
  /* Only a plain cold attempt skips residuals: a warm one begins where they are large. */
  words[WORD_TRUSTING] = (attempt == ATTEMPT_COLD) ? 1 : 0;
  words[WORD_WARM] = (attempt == ATTEMPT_WARM) ? 1 : 0;
}

void orbsoc_begin(orbsoc_solver *solver, orbsoc_attempt attempt) {
  orbsoc_norms(solver->pattern, &solver->numbers, solver->buffer[ORBSOC_NORMS]);
  solver->attempt = (uint32_t)attempt;
  solver->spent = 0;
  solver->refined_before = 0;
  solver->restarts = 0;
  solver->stop = STOP_NONE;
  solver->has_earlier = 0;
  solver->warm_start = (attempt == ATTEMPT_WARM) ? ORBSOC_START_USED : ORBSOC_NO_START;
  prepare(solver, attempt);
}

int orbsoc_begin_again(orbsoc_solver *solver) {
  const uint32_t stalled = (solver->stop == (uint32_t)STOP_STALLED ||
                            solver->stop == (uint32_t)STOP_NOT_FINITE) ? 1u : 0u;
  const orbsoc_real *words = solver->buffer[ORBSOC_CONTROL];
  const orbsoc_restart *found = NULL;
  for (size_t k = 0; k < ORBSOC_RESTARTS && found == NULL; k++) {
    const orbsoc_restart *row = &orbsoc_restarts[k];
    if ((row->after & BIT(solver->attempt)) != 0u && stalled >= row->stalled &&
        (row->statuses & BIT((uint32_t)solver->solution.status)) != 0u) {
      found = row;
    }
  }
  if (found == NULL || solver->restarts >= solver->settings.max_restarts) {
    return 0;
  }
  if (found->attempt != (uint32_t)ATTEMPT_COLD) {
    solver->earlier = solver->solution;
    solver->has_earlier = 1;
  }
  solver->attempt = found->attempt;
  solver->spent += orbsoc_count(words[WORD_ITERATION]);
  solver->refined_before += orbsoc_count(words[WORD_REFINEMENTS]);
  solver->restarts += 1u;
  solver->stop = STOP_NONE;
  if (solver->warm_start != ORBSOC_NO_START) {
    solver->warm_start = ORBSOC_START_FELL_BACK;
  }
  prepare(solver, (orbsoc_attempt)found->attempt);
  return 1;
}

int orbsoc_load_point(orbsoc_solver *solver, const double *x, const double *y, const double *z,
                      const double *s) {
  pattern_t pattern = solver->pattern;
  orbsoc_real *to = solver->buffer[ORBSOC_START];
  double finite = 0.0;
  for (size_t i = 0; i < pattern->n; i++) {
    finite += 0.0 * x[i];
    to[i] = real(x[i]);
  }
  for (size_t i = 0; i < pattern->p; i++) {
    finite += 0.0 * y[i];
    to[pattern->n + i] = real(y[i]);
  }
  to = &to[pattern->n + pattern->p];
  for (size_t i = 0; i < pattern->m; i++) {
    finite += 0.0 * z[pattern->row_origin[i]] + 0.0 * s[pattern->row_origin[i]];
    to[i] = real(z[pattern->row_origin[i]]);
    to[pattern->m + i] = real(s[pattern->row_origin[i]]);
  }
  return finite == 0.0 && pattern->p + pattern->m > 0u;
}

/* Perform the steps of a list, up to one that asks to leave the iteration: 1. */
static int follow(orbsoc_solver *solver, const orbsoc_list *list) {
  for (size_t k = 0; k < list->count; k++) {
    const orbsoc_stage stage = (orbsoc_stage)list->steps[k].stage;
    const orbsoc_stage until = (orbsoc_stage)list->steps[k].until;
    orbsoc_outcome outcome = orbsoc_run(solver, until, 0);
    while (outcome == ORBSOC_REPEAT) {
      (void)orbsoc_run(solver, stage, 0);
      outcome = orbsoc_run(solver, until, 0);
    }
    if (outcome == ORBSOC_DONE) {
      return 1;
    }
  }
  return 0;
}

/* One attempt: a start-up list, iterations, the closing list; on the device, where it can. */
static void make_attempt(orbsoc_solver *solver, const orbsoc_list *list) {
  if (solver->away != 0u) {
    orbsoc_begin_attempt_there(solver);
    if (orbsoc_attempt_there(solver, list == &orbsoc_warm_startup) != 0) {
      orbsoc_fetch_answer(solver);
      return;
    }
  }
  int ended = follow(solver, list);
  while (ended == 0) {
    ended = follow(solver, &orbsoc_iteration);
  }
  if (solver->event == 0u) {
    (void)follow(solver, &orbsoc_closing);
  }
  if (solver->away != 0u) {
    orbsoc_fetch_answer(solver);
  }
}

/* Attempt from a start-up list, then restart for as long as a restart follows. */
static void solve_with_restarts(orbsoc_solver *solver, const orbsoc_list *list) {
  int again = 1;
  while (again != 0) {
    make_attempt(solver, list);
    if (solver->event != 0u) {
      return;
    }
    orbsoc_conclude(solver);
    again = orbsoc_begin_again(solver);
    list = &orbsoc_startup;
  }
}

#define TRIES 2u

/* Two tries on the device, where there is one, and then one on the core. */
static void solve_somewhere(orbsoc_solver *solver, orbsoc_attempt attempt, orbsoc_warm_start warm) {
  const orbsoc_list *list = (attempt == ATTEMPT_WARM) ? &orbsoc_warm_startup : &orbsoc_startup;
  uint32_t events[TRIES] = {0, 0}, place = (solver->partition == NULL) ? ORBSOC_ON_CORE : 1u;
  int believed = 0;
  for (; place >= 1u && place <= TRIES && believed == 0; place++) {
    orbsoc_begin(solver, attempt);
    solver->warm_start = warm;
    solver->away = 1;
    solver->kept = 0;
    orbsoc_begin_there(solver);
    if (solver->event == 0u) {
      solve_with_restarts(solver, list);
    }
    solver->away = 0;
    believed = solver->event == 0u && orbsoc_is_believed(solver) != 0;
    events[place - 1u] = (solver->event != 0u) ? solver->event : (uint32_t)ORBSOC_ANSWER_REFUSED;
    solver->loaded = believed ? 1u : 0u;
    solver->event = 0;
  }
  if (believed == 0) {
    orbsoc_begin(solver, attempt);
    solver->warm_start = warm;
    solve_with_restarts(solver, list);
  } else {
    place -= 1u;
    events[place - 1u] = 0;
  }
  /* What a solve without a certificate leaves is not built upon. */
  solver->kept = (orbsoc_is_believed(solver) != 0) ? solver->kept : 0u;
  solver->solution.place = (orbsoc_place)place;
  solver->solution.event[0] = events[0];
  solver->solution.event[1] = events[1];
}

#define ALL_GIVEN 0x3fu

orbsoc_error orbsoc_solve(orbsoc_solver *solver) {
  if (solver == NULL || solver->pattern == NULL) {
    return ORBSOC_NO_POINTER;
  }
  if (solver->given != ALL_GIVEN) {
    return ORBSOC_NO_DATA;
  }
  solve_somewhere(solver, ATTEMPT_COLD, ORBSOC_NO_START);
  return ORBSOC_OK;
}

orbsoc_error orbsoc_solve_from(orbsoc_solver *solver, const double *x, const double *y,
                               const double *z, const double *s) {
  if (solver == NULL || solver->pattern == NULL || x == NULL || y == NULL || z == NULL ||
      s == NULL) {
    return ORBSOC_NO_POINTER;
  }
  if (solver->given != ALL_GIVEN) {
    return ORBSOC_NO_DATA;
  }
  if (orbsoc_load_point(solver, x, y, z, s) != 0) {
    solve_somewhere(solver, ATTEMPT_WARM, ORBSOC_START_USED);
  } else {
    solve_somewhere(solver, ATTEMPT_COLD, ORBSOC_START_FELL_BACK);
  }
  return ORBSOC_OK;
}

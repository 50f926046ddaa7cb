/* The sequence: solve a convex subproblem about a reference, move the reference, repeat, and end
 * with a reason; then fly what came out. As orbsoc.guidance.scp.sequential_convex does it. */
#include "insertion.h"

#include "vectors.h"

static double largest_of(double a, double b) { return (a < b) ? b : a; }

/* Where the data, and the states and the controls of the plan's arc, stand in the memory. */
static void lay_out(const orbsoc_insertion *mission, double *memory, orbsoc_planner *planner) {
  planner->a = memory;
  planner->b = &planner->a[mission->entries_a];
  planner->h = &planner->b[mission->equality_rows];
  planner->plan.arc.states = &planner->h[mission->cone_rows];
  planner->plan.arc.controls = &planner->plan.arc.states[6u * (size_t)mission->nodes];
}

static size_t words_of(const orbsoc_insertion *mission) {
  return (size_t)mission->entries_a + mission->equality_rows + mission->cone_rows +
         9u * (size_t)mission->nodes;
}

static int fits(const orbsoc_insertion *mission, const orbsoc_pattern *pattern) {
  return mission->entries_a == pattern->nnz_a && mission->entries_g == pattern->given_nnz_g &&
         mission->variables == pattern->n && mission->equality_rows == pattern->p &&
         mission->cone_rows == pattern->given_m && pattern->nnz_p == 0u;
}

static int all_below(const orbsoc_index *places, size_t count, size_t limit) {
  int inside = 1;
  for (size_t k = 0; k < count; k++) { inside = inside && places[k] < limit; }
  return inside;
}

/* Whether every place, column and row is inside what it points into, whatever the checksum says. */
static int is_inside(const orbsoc_insertion *m) {
  const size_t nodes = m->nodes, by_state = (size_t)ORBSOC_BY_STATE * nodes;
  const size_t rows = (size_t)ORBSOC_TARGET_ROWS, limit = m->entries_a;
  return all_below(m->place.state, by_state, limit) &&
         all_below(m->place.control, 3u * nodes, limit) &&
         all_below(m->place.duration, 6u * nodes, limit) &&
         all_below(m->place.end_state, by_state, limit) &&
         all_below(m->place.end_control, 3u * nodes, limit) &&
         all_below(m->place.end_duration, 6, limit) &&
         all_below(m->place.target, 6u * rows, limit) && 6u * nodes <= m->control_column &&
         m->control_column + 3u * nodes <= m->variables && m->end_column + 6u <= m->variables &&
         m->duration_column < m->variables && m->above_column + rows <= m->variables &&
         m->below_column + rows <= m->variables && 6u * nodes <= m->end_row &&
         m->end_row + 6u <= m->equality_rows && m->target_row + rows <= m->equality_rows &&
         m->longest_row < m->cone_rows;
}

orbsoc_error orbsoc_insertion_open(orbsoc_planner *planner, const orbsoc_insertion *mission,
                                   orbsoc_solver *solver, double *memory, size_t words) {
  if (planner == NULL || mission == NULL || solver == NULL || memory == NULL ||
      solver->pattern == NULL) {
    return ORBSOC_NO_POINTER;
  }
  planner->mission = NULL;
  if (orbsoc_insertion_checksum(mission) != mission->checksum ||
      fits(mission, solver->pattern) == 0 || is_inside(mission) == 0) {
    return ORBSOC_TABLES_CHANGED;
  }
  if (words < words_of(mission)) {
    return ORBSOC_SMALL_MEMORY;
  }
  lay_out(mission, memory, planner);
  planner->plan.arc.duration = -1.0; /* there is no plan yet */
  planner->solver = solver;
  const orbsoc_error set_c = orbsoc_set_c(solver, mission->fixed.c);
  const orbsoc_error set_g = orbsoc_set_g(solver, mission->fixed.g);
  planner->mission = mission;
  return (set_c != ORBSOC_OK) ? set_c : set_g;
}

/* ---- one subproblem ---- */

/* Whether a solution is called solved, or its residuals on the original data are within a limit. */
static int within_residual(const orbsoc_solution *solution, double limit) {
  return solution->status == ORBSOC_SOLVED ||
         (solution->primal_residual <= limit && solution->dual_residual <= limit &&
          solution->gap <= limit);
}

/* Whether to move to a solution: solved, or near by its residuals. */
static int usable(const orbsoc_solution *solution, double limit) {
  const orbsoc_status status = solution->status;
  const int near = status == ORBSOC_SOLVED || status == ORBSOC_SOLVED_INACCURATE ||
                   status == ORBSOC_NUMERICAL_LIMIT || status == ORBSOC_MAX_ITERATIONS;
  return near && within_residual(solution, limit);
}

static orbsoc_error solve_subproblem(orbsoc_planner *planner) {
  orbsoc_solver *solver = planner->solver;
  orbsoc_insertion_linearise(planner);
  solver->settings.tol = planner->tolerance;
  orbsoc_error error = orbsoc_set_a(solver, planner->a);
  if (error == ORBSOC_OK) {
    error = orbsoc_set_b(solver, planner->b);
  }
  if (error == ORBSOC_OK) {
    error = orbsoc_set_h(solver, planner->h);
  }
  return (error == ORBSOC_OK) ? orbsoc_solve(solver) : error;
}

/* Copy numbers, and the largest change of one. */
static double take(size_t count, const double *from, double *to) {
  double change = 0.0;
  for (size_t k = 0; k < count; k++) {
    change = largest_of(change, fabs(from[k] - to[k]));
    to[k] = from[k];
  }
  return change;
}

/* Move the reference to a solution; note how far it moved and the slack of the terminal rows. */
static void read_solution(orbsoc_planner *planner) {
  const orbsoc_insertion *mission = planner->mission;
  const double *x = planner->solver->solution.x;
  orbsoc_plan *plan = &planner->plan;
  const double duration = largest_of(x[mission->duration_column], mission->shortest);
  const size_t nodes = mission->nodes;
  plan->change = take(6u * nodes, x, plan->arc.states);
  plan->change = largest_of(plan->change, take(6, &x[mission->end_column], plan->arc.end));
  plan->change = largest_of(plan->change, take(1, &duration, &plan->arc.duration));
  (void)take(3u * nodes, &x[mission->control_column], plan->arc.controls); /* they do not count */
  plan->slack = 0.0;
  for (size_t k = 0; k < (size_t)ORBSOC_TARGET_ROWS; k++) {
    const double signed_slack = x[mission->below_column + k] - x[mission->above_column + k];
    plan->violation[k] = signed_slack / mission->slack_weight;
    plan->slack += fabs(plan->violation[k]);
  }
}

static orbsoc_plan_exit failure(orbsoc_status status) {
  if (status == ORBSOC_INTERRUPTED) {
    return ORBSOC_PLAN_INTERRUPTED;
  }
  return (status == ORBSOC_PRIMAL_INFEASIBLE) ? ORBSOC_PLAN_SUBPROBLEM_INFEASIBLE
                                              : ORBSOC_PLAN_SUBPROBLEM_FAILED;
}

/* ---- the sequence ---- */

/* Whether the last step ends the sequence, and why: it was small, in a subproblem solved tightly,
 * and its slack says on or beside the target. Between the two the sequence goes on. */
static int settled(const orbsoc_planner *planner, orbsoc_plan_exit *exit) {
  const orbsoc_sequence_rules *rules = &planner->mission->rules;
  const orbsoc_plan *plan = &planner->plan;
  if (!(plan->change < rules->step_tol && planner->tolerance <= rules->tight_tol) ||
      within_residual(&planner->solver->solution, rules->final_residual) == 0) {
    return 0;
  }
  *exit = (plan->slack < rules->slack_tol) ? ORBSOC_PLAN_CONVERGED : ORBSOC_PLAN_UNREACHED;
  return plan->slack < rules->slack_tol || plan->slack >= rules->infeasible_slack;
}

/* Solve and move once; `ended` says whether that was the last time. */
static orbsoc_error advance(orbsoc_planner *planner, int *ended) {
  const orbsoc_sequence_rules *rules = &planner->mission->rules;
  orbsoc_plan *plan = &planner->plan;
  const orbsoc_error error = solve_subproblem(planner);
  if (error != ORBSOC_OK) {
    return error;
  }
  const orbsoc_solution *solution = &planner->solver->solution;
  plan->subproblems++;
  plan->iterations += solution->iterations;
  if (usable(solution, rules->usable_residual) == 0) {
    plan->change = (double)NAN;
    plan->slack = (double)NAN;
    plan->exit = failure(solution->status);
    *ended = 1;
    return ORBSOC_OK;
  }
  read_solution(planner);
  *ended = settled(planner, &plan->exit);
  if (plan->change < rules->tighten_below) {
    planner->tolerance = rules->tight_tol;
  }
  return ORBSOC_OK;
}

static orbsoc_error run_sequence(orbsoc_planner *planner) {
  const orbsoc_insertion *mission = planner->mission;
  int ended = 0;
  planner->tolerance = mission->rules.loose_tol;
  for (uint32_t k = 0; k < mission->max_subproblems && ended == 0; k++) {
    const orbsoc_error error = advance(planner, &ended);
    if (error != ORBSOC_OK) {
      return error;
    }
  }
  if (ended == 0) {
    planner->plan.exit = ORBSOC_PLAN_MAX_ITERATIONS;
  }
  return ORBSOC_OK;
}

/* ---- a plan ---- */

static void begin(orbsoc_planner *planner) {
  orbsoc_plan *plan = &planner->plan;
  plan->exit = ORBSOC_PLAN_SUBPROBLEM_FAILED;
  plan->objections = (uint32_t)ORBSOC_NOT_FLOWN;
  plan->subproblems = 0;
  plan->iterations = 0;
  plan->change = (double)NAN;
  plan->slack = (double)NAN;
  for (size_t k = 0; k < (size_t)ORBSOC_TARGET_ROWS; k++) { plan->violation[k] = (double)NAN; }
  plan->momentum_rel = (double)NAN;
  plan->laplace = (double)NAN;
  plan->thrust_excess = 0.0;
  plan->lowest_radius = norm(planner->start);
}

/* A burn of no time, where the state is on the target orbit. */
static int is_on_target(orbsoc_planner *planner) {
  orbsoc_plan *plan = &planner->plan;
  orbsoc_insertion_judge(planner->mission, planner->start, plan);
  if (plan->objections != 0u) {
    return 0;
  }
  plan->exit = ORBSOC_PLAN_NOTHING_TO_BURN;
  plan->arc.duration = 0.0;
  (void)take(6, planner->start, plan->arc.end);
  for (size_t node = 0; node < planner->mission->nodes; node++) {
    (void)take(6, planner->start, &plan->arc.states[6u * node]);
  }
  return 1;
}

orbsoc_error orbsoc_insertion_plan(orbsoc_planner *planner, const double position_m[3],
                                   const double velocity_m_s[3]) {
  if (planner == NULL || planner->mission == NULL || position_m == NULL || velocity_m_s == NULL) {
    return ORBSOC_NO_POINTER;
  }
  for (size_t i = 0; i < 3u; i++) {
    planner->start[i] = position_m[i] / planner->mission->length_m;
    planner->start[3u + i] = velocity_m_s[i] / planner->mission->speed_m_s;
  }
  begin(planner);
  orbsoc_insertion_fly_guess(planner);
  orbsoc_error error = ORBSOC_OK;
  if (is_on_target(planner) == 0) {
    begin(planner);
    error = run_sequence(planner);
    if (error == ORBSOC_OK && planner->plan.exit == ORBSOC_PLAN_CONVERGED) {
      orbsoc_insertion_fly_plan(planner);
    }
  }
  planner->plan.duration_s = planner->plan.arc.duration * planner->mission->time_s;
  return error;
}

orbsoc_error orbsoc_insertion_direction(const orbsoc_planner *planner, double elapsed_s,
                                        double direction[3]) {
  if (planner == NULL || planner->mission == NULL || direction == NULL) {
    return ORBSOC_NO_POINTER;
  }
  const orbsoc_plan *plan = &planner->plan;
  if (plan->arc.duration < 0.0) {
    return ORBSOC_NO_DATA;
  }
  if (!(elapsed_s >= 0.0 && elapsed_s <= plan->duration_s)) {
    return ORBSOC_BAD_VALUE; /* beside the burn the interpolant says nothing */
  }
  const orbsoc_insertion *mission = planner->mission;
  orbsoc_insertion_programme(mission, &plan->arc, elapsed_s / mission->time_s, direction);
  const double size = norm(direction);
  for (size_t i = 0; i < 3u; i++) { direction[i] /= size; }
  return ORBSOC_OK;
}

const char *orbsoc_plan_exit_name(orbsoc_plan_exit exit) {
  static const char *const names[] = {
      "CONVERGED",      "UNREACHED",   "SUBPROBLEM_INFEASIBLE", "SUBPROBLEM_FAILED",
      "MAX_ITERATIONS", "INTERRUPTED", "NOTHING_TO_BURN"};
  return ((uint32_t)exit < 7u) ? names[exit] : "UNKNOWN";
}

/* A mission for a test in Python: one planner in static memory. */
#include <string.h>

#include "mission.h"

static orbsoc_mission_arena arena;
static orbsoc_solver solver;
static orbsoc_planner planner;

int mission_open(void) {
  const orbsoc_error opened =
      orbsoc_open(&solver, &orbsoc_tables, &orbsoc_defaults, arena.solver.work, ORBSOC_WORK_WORDS,
                  arena.solver.numbers, ORBSOC_NUMBER_WORDS);
  const orbsoc_error planned =
      orbsoc_insertion_open(&planner, &orbsoc_mission, &solver, arena.plan, ORBSOC_PLAN_WORDS);
  return 16 * (int)opened + (int)planned;
}

orbsoc_solver *mission_solver(void) { return &solver; }

/* Plan; counts are exit, objections, subproblems, iterations. */
int mission_plan(const double *start, int *counts, double *numbers, double *controls, double *states) {
  const int error = (int)orbsoc_insertion_plan(&planner, start, &start[3]);
  const orbsoc_plan *plan = &planner.plan;
  const double found[] = {plan->duration_s, plan->change, plan->slack, plan->momentum_rel,
                          plan->laplace, plan->thrust_excess, plan->lowest_radius,
                          plan->arc.duration};
  counts[0] = (int)plan->exit;
  counts[1] = (int)plan->objections;
  counts[2] = (int)plan->subproblems;
  counts[3] = (int)plan->iterations;
  memcpy(numbers, found, sizeof found);
  memcpy(&numbers[8], plan->violation, sizeof plan->violation);
  memcpy(controls, plan->arc.controls, sizeof(double) * 3u * (size_t)ORBSOC_NODES);
  memcpy(states, plan->arc.states, sizeof(double) * 6u * (size_t)ORBSOC_NODES);
  return error;
}

/* The data of the subproblem about a reference; `reference` has states, controls, end and duration. */
void mission_data(const double *start, const double *reference, double *a, double *b, double *h) {
  orbsoc_arc *arc = &planner.plan.arc;
  const size_t nodes = ORBSOC_NODES;
  memcpy(planner.start, start, sizeof planner.start);
  memcpy(arc->states, reference, sizeof(double) * 6u * nodes);
  memcpy(arc->controls, &reference[6u * nodes], sizeof(double) * 3u * nodes);
  memcpy(arc->end, &reference[9u * nodes], sizeof arc->end);
  arc->duration = reference[9u * nodes + 6u];
  orbsoc_insertion_linearise(&planner);
  memcpy(a, planner.a, sizeof(double) * ORBSOC_NNZ_A);
  memcpy(b, planner.b, sizeof(double) * ORBSOC_ROWS);
  memcpy(h, planner.h, sizeof(double) * ORBSOC_M);
}

/* The first reference from a canonical state, in the same order. */
void mission_guess(const double *start, double *reference) {
  const orbsoc_arc *arc = &planner.plan.arc;
  const size_t nodes = ORBSOC_NODES;
  memcpy(planner.start, start, sizeof planner.start);
  orbsoc_insertion_fly_guess(&planner);
  memcpy(reference, arc->states, sizeof(double) * 6u * nodes);
  memcpy(&reference[6u * nodes], arc->controls, sizeof(double) * 3u * nodes);
  memcpy(&reference[9u * nodes], arc->end, sizeof arc->end);
  reference[9u * nodes + 6u] = arc->duration;
}

int mission_direction(double elapsed_s, double *direction) {
  return (int)orbsoc_insertion_direction(&planner, elapsed_s, direction);
}

static orbsoc_answer stop(void *context) {
  (void)context;
  return ORBSOC_STOP_NOW;
}

void mission_ask(int stops) { solver.ask = (stops != 0) ? stop : NULL; }

/* Open a planner on tables of which one number is changed: what it says. */
int mission_change(int which) {
  orbsoc_insertion other = orbsoc_mission;
  static double weights[ORBSOC_NODES];
  static orbsoc_planner refused;
  memcpy(weights, other.grid.weight, sizeof weights);
  weights[ORBSOC_NODES - 1] *= 1.0 + 0x1p-52;
  switch (which) {
    case 0: other.nodes--; break;
    case 1: other.flow *= 1.0 + 0x1p-52; break;
    case 2: other.target.ahead[2] *= 1.0 + 0x1p-52; break;
    case 3: other.limits.thrust_excess *= 2.0; break;
    case 4: other.rules.step_tol *= 2.0; break;
    case 5: other.grid.weight = weights; break;
    case 6: other.place.target = other.place.state; break;
    default: other.fixed.h = other.fixed.c; break;
  }
  return (int)orbsoc_insertion_open(&refused, &other, &solver, arena.plan, ORBSOC_PLAN_WORDS);
}

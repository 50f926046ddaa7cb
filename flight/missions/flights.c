/* Flights of a burn: the first guess, and the one that judges a plan. Runge and Kutta's method of
 * order 4 in steps of one length; nothing of the collocation is in it. */
#include "insertion.h"
#include "vectors.h"

/* The interpolant of the nodal controls at a time after the ignition: the second barycentric
 * formula (Berrut and Trefethen 2004, (4.2)). A burn of no time has one direction. */
void orbsoc_insertion_programme(const orbsoc_insertion *mission, const orbsoc_arc *arc,
                                double elapsed, double vector[3]) {
  const double tau = (arc->duration > 0.0) ? 2.0 * elapsed / arc->duration - 1.0 : -1.0;
  double sum = 0.0, whole[3] = {0.0, 0.0, 0.0};
  for (size_t node = 0; node < mission->nodes; node++) {
    const double gap = tau - mission->grid.node[node];
    const double *u = &arc->controls[3u * node];
    if (gap == 0.0) {
      vector[0] = u[0];
      vector[1] = u[1];
      vector[2] = u[2];
      return;
    }
    const double share = mission->grid.barycentric[node] / gap;
    sum += share;
    for (size_t i = 0; i < 3u; i++) { whole[i] += share * u[i]; }
  }
  for (size_t i = 0; i < 3u; i++) { vector[i] = whole[i] / sum; }
}

/* d(state)/dt after a time; `programme` is a burn whose controls steer, or null: along the
 * velocity. */
static void rate_of(const orbsoc_insertion *mission, const orbsoc_arc *programme, double elapsed,
                    const double *state, double *rate) {
  const double *r = state, *v = &state[3];
  const double radius = norm(r), cube = radius * radius * radius;
  const double thrust = mission->acceleration / (1.0 - mission->flow * elapsed);
  double direction[3] = {v[0], v[1], v[2]};
  if (programme != NULL) {
    orbsoc_insertion_programme(mission, programme, elapsed, direction);
  }
  const double size = norm(direction);
  for (size_t i = 0; i < 3u; i++) {
    rate[i] = v[i];
    rate[3u + i] = thrust * direction[i] / size - r[i] / cube;
  }
}

/* state + step * rate */
static void moved(const double *state, double step, const double *rate, double *out) {
  for (size_t k = 0; k < 6u; k++) { out[k] = state[k] + step * rate[k]; }
}

/* Fly from one time to another in equal steps. */
static void fly(const orbsoc_insertion *mission, const orbsoc_arc *programme, double from,
                double to, uint32_t steps, double *state) {
  const double step = (to - from) / (double)steps;
  for (uint32_t k = 0; k < steps; k++) {
    const double now = from + (double)k * step, half = now + 0.5 * step;
    double first[ORBSOC_STATE], second[ORBSOC_STATE], third[ORBSOC_STATE], last[ORBSOC_STATE];
    double there[ORBSOC_STATE];
    rate_of(mission, programme, now, state, first);
    moved(state, 0.5 * step, first, there);
    rate_of(mission, programme, half, there, second);
    moved(state, 0.5 * step, second, there);
    rate_of(mission, programme, half, there, third);
    moved(state, step, third, there);
    rate_of(mission, programme, now + step, there, last);
    for (size_t i = 0; i < 6u; i++) {
      state[i] += step / 6.0 * (first[i] + 2.0 * (second[i] + third[i]) + last[i]);
    }
  }
}

void orbsoc_insertion_fly_guess(orbsoc_planner *planner) {
  const orbsoc_insertion *mission = planner->mission;
  orbsoc_arc *arc = &planner->plan.arc;
  double state[ORBSOC_STATE], last = 0.0;
  for (size_t k = 0; k < 6u; k++) { state[k] = planner->start[k]; }
  for (size_t node = 0; node < mission->nodes; node++) {
    const double next = 0.5 * mission->guess * (mission->grid.node[node] + 1.0);
    fly(mission, NULL, last, next, mission->guess_steps, state);
    last = next;
    const double speed = norm(&state[3]);
    for (size_t k = 0; k < 6u; k++) { arc->states[6u * node + k] = state[k]; }
    for (size_t i = 0; i < 3u; i++) { arc->controls[3u * node + i] = state[3u + i] / speed; }
  }
  fly(mission, NULL, last, mission->guess, mission->guess_steps, state);
  for (size_t k = 0; k < 6u; k++) { arc->end[k] = state[k]; }
  arc->duration = mission->guess;
}

/* Note what a flight shows on its way. */
static void note_sample(const orbsoc_insertion *mission, orbsoc_plan *plan, double elapsed,
                        const double *state) {
  double vector[3];
  orbsoc_insertion_programme(mission, &plan->arc, elapsed, vector);
  const double excess = norm(vector) - 1.0, radius = norm(state);
  plan->thrust_excess = (excess > plan->thrust_excess) ? excess : plan->thrust_excess;
  plan->lowest_radius = (radius < plan->lowest_radius) ? radius : plan->lowest_radius;
}

/* A bit where a value is not within its limit; NaN is not. */
static uint32_t objection(double value, double limit, uint32_t bit) {
  return (value <= limit) ? 0u : bit;
}

void orbsoc_insertion_judge(const orbsoc_insertion *mission, const double end[ORBSOC_STATE],
                            orbsoc_plan *plan) {
  const orbsoc_target_orbit *target = &mission->target;
  const orbsoc_flight_limits *limits = &mission->limits;
  double momentum[3], laplace[3], across[3], momentum_gap[3], laplace_gap[3];
  cross(end, &end[3], momentum);
  laplace_vector(end, laplace);
  cross(momentum, target->normal, across);
  for (size_t i = 0; i < 3u; i++) {
    momentum_gap[i] = momentum[i] - target->momentum * target->normal[i];
    laplace_gap[i] = laplace[i] - target->eccentricity * target->perigee[i];
  }
  plan->momentum_rel = norm(momentum_gap) / target->momentum;
  plan->laplace = norm(laplace_gap);
  const double along = dot(momentum, target->normal);
  plan->objections =
      objection(plan->momentum_rel, limits->momentum_rel, (uint32_t)ORBSOC_MOMENTUM_OFF) |
      objection(plan->laplace, limits->laplace, (uint32_t)ORBSOC_LAPLACE_OFF) |
      objection(norm(across), limits->plane_slope * along, (uint32_t)ORBSOC_PLANE_OFF) |
      objection(plan->thrust_excess, limits->thrust_excess, (uint32_t)ORBSOC_THRUST_EXCESS) |
      objection(-plan->lowest_radius, -1.0, (uint32_t)ORBSOC_BELOW_GROUND);
}

void orbsoc_insertion_fly_plan(orbsoc_planner *planner) {
  const orbsoc_insertion *mission = planner->mission;
  orbsoc_plan *plan = &planner->plan;
  double state[ORBSOC_STATE];
  for (size_t k = 0; k < 6u; k++) { state[k] = planner->start[k]; }
  plan->lowest_radius = norm(state);
  plan->thrust_excess = -1.0;
  note_sample(mission, plan, 0.0, state);
  for (uint32_t k = 0; k < mission->check_samples; k++) {
    const double piece = plan->arc.duration / (double)mission->check_samples;
    const double from = (double)k * piece, to = (double)(k + 1u) * piece;
    fly(mission, &plan->arc, from, to, mission->check_steps, state);
    note_sample(mission, plan, to, state);
  }
  orbsoc_insertion_judge(mission, state, plan);
}

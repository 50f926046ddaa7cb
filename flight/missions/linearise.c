/* The data of a subproblem: dynamics and terminal conditions to first order about a reference. The
 * order of operations is that of orbsoc.guidance.powered_flight. */
#include "insertion.h"
#include "vectors.h"

/* dx/dtau at a node, about constant + by_state x + by_control u + by_duration T. */
typedef struct {
  double constant[ORBSOC_STATE];
  double by_state[ORBSOC_BY_STATE]; /* of the position's rows by velocity, then 3 x 3 by position */
  double by_control;
  double by_duration[ORBSOC_STATE];
} linear_t;

/* How the pull changes with the position, and the velocity's own rows. */
static void linearise_state(double half, const double *r, linear_t *out) {
  const double radius = norm(r), cube = radius * radius * radius;
  const double fifth = cube * radius * radius;
  for (size_t i = 0; i < 3u; i++) {
    out->by_state[i] = half;
    for (size_t j = 0; j < 3u; j++) {
      const double tidal = 3.0 * (r[i] * r[j]) / fifth;
      out->by_state[3u + 3u * i + j] = half * (tidal - ((i == j) ? 1.0 / cube : 0.0));
    }
  }
}

static void linearise_node(const orbsoc_insertion *mission, const orbsoc_arc *arc, size_t node,
                           linear_t *out) {
  const double *r = &arc->states[6u * node], *v = &r[3], *u = &arc->controls[3u * node];
  const double duration = arc->duration, half = 0.5 * duration;
  const double elapsed = half * (mission->grid.node[node] + 1.0);
  const double left = 1.0 - mission->flow * elapsed; /* of the mass */
  const double thrust = mission->acceleration / left;
  /* A longer burn moves every node later, where the vehicle is lighter. */
  const double lightening = thrust * mission->flow * (elapsed / duration) / left;
  const double radius = norm(r), cube = radius * radius * radius;
  linearise_state(half, r, out);
  out->by_control = half * thrust;
  for (size_t i = 0; i < 3u; i++) {
    const double climb = half * v[i], turn = half * (thrust * u[i] - r[i] / cube);
    const double *by_position = &out->by_state[3u + 3u * i];
    out->by_duration[i] = climb / duration;
    out->by_duration[3u + i] = turn / duration + half * lightening * u[i];
    out->constant[i] = climb - half * v[i] - out->by_duration[i] * duration;
    out->constant[3u + i] = turn - dot(by_position, r) - out->by_duration[3u + i] * duration -
                            out->by_control * u[i];
  }
}

/* A node's own rows: sum_j D_ij x_j - g_i = 0, where the initial state is data. */
static void write_node(orbsoc_planner *planner, size_t node, const linear_t *linear) {
  const orbsoc_places *place = &planner->mission->place;
  for (size_t k = 0; k < (size_t)ORBSOC_BY_STATE; k++) {
    planner->a[place->state[(size_t)ORBSOC_BY_STATE * node + k]] = -linear->by_state[k];
  }
  for (size_t k = 0; k < 3u; k++) {
    planner->a[place->control[3u * node + k]] = -linear->by_control;
  }
  for (size_t k = 0; k < 6u; k++) {
    const double known = planner->mission->grid.from_start[node] * planner->start[k];
    planner->a[place->duration[6u * node + k]] = -linear->by_duration[k];
    planner->b[6u * node + k] = linear->constant[k] - known;
  }
}

/* A node's share of x(1) = x(-1) + sum_i w_i g_i. */
static void write_share(orbsoc_planner *planner, size_t node, const linear_t *linear,
                        double *constant, double *by_duration) {
  const orbsoc_places *place = &planner->mission->place;
  const double weight = planner->mission->grid.weight[node];
  for (size_t k = 0; k < (size_t)ORBSOC_BY_STATE; k++) {
    planner->a[place->end_state[(size_t)ORBSOC_BY_STATE * node + k]] =
        -weight * linear->by_state[k];
  }
  for (size_t k = 0; k < 3u; k++) {
    planner->a[place->end_control[3u * node + k]] = -weight * linear->by_control;
  }
  for (size_t k = 0; k < 6u; k++) {
    constant[k] += weight * linear->constant[k];
    by_duration[k] += weight * linear->by_duration[k];
  }
}

static void write_dynamics(orbsoc_planner *planner) {
  const orbsoc_insertion *mission = planner->mission;
  double constant[ORBSOC_STATE] = {0.0}, by_duration[ORBSOC_STATE] = {0.0};
  for (size_t node = 0; node < mission->nodes; node++) {
    linear_t linear;
    linearise_node(mission, &planner->plan.arc, node, &linear);
    write_node(planner, node, &linear);
    write_share(planner, node, &linear, constant, by_duration);
  }
  for (size_t k = 0; k < 6u; k++) {
    planner->a[mission->place.end_duration[k]] = -by_duration[k];
    planner->b[mission->end_row + k] = planner->start[k] + constant[k];
  }
}

/* Rows i of dH/d(r, v) = [-[v]x, [r]x]. */
static void momentum_row(const double *state, size_t i, double *row) {
  const double *r = state, *v = &state[3];
  const size_t j = (i + 1u) % 3u, k = (i + 2u) % 3u;
  for (size_t at = 0; at < 6u; at++) { row[at] = 0.0; }
  row[j] = v[k];
  row[k] = -v[j];
  row[3u + j] = -r[k];
  row[3u + k] = r[j];
}

/* Row i of dL/d(r, v): by r (v.v) I - v v' - (I/|r| - r r'/|r|^3), by v 2 r v' - v r' - (r.v) I. */
static void laplace_row(const double *state, size_t i, double *row) {
  const double *r = state, *v = &state[3];
  const double square = dot(v, v), radial = dot(r, v), radius = norm(r);
  const double cube = radius * radius * radius;
  for (size_t j = 0; j < 3u; j++) {
    const double same = (i == j) ? 1.0 : 0.0;
    row[j] = square * same - v[i] * v[j] - (same / radius - r[i] * r[j] / cube);
    row[3u + j] = 2.0 * (r[i] * v[j]) - v[i] * r[j] - radial * same;
  }
}

/* One terminal row: direction . (vector + jacobian (x - end)) = goal. */
static void write_condition(orbsoc_planner *planner, size_t condition, const double *direction,
                            const double *vector, double jacobian[3][ORBSOC_STATE], double goal) {
  const orbsoc_insertion *mission = planner->mission;
  const double *end = planner->plan.arc.end;
  double known = 0.0;
  for (size_t k = 0; k < 6u; k++) {
    double entry = 0.0;
    for (size_t i = 0; i < 3u; i++) { entry += direction[i] * jacobian[i][k]; }
    planner->a[mission->place.target[6u * condition + k]] = entry;
  }
  for (size_t i = 0; i < 3u; i++) {
    double linear = 0.0;
    for (size_t k = 0; k < 6u; k++) { linear += jacobian[i][k] * end[k]; }
    known += direction[i] * (vector[i] - linear);
  }
  planner->b[mission->target_row + condition] = goal - known;
}

/* l.H = 0, q.H = 0, n.H = |H|, l.L = e, q.L = 0 of the target orbit. */
static void write_target(orbsoc_planner *planner) {
  const orbsoc_target_orbit *target = &planner->mission->target;
  const double *end = planner->plan.arc.end;
  double vector[3], jacobian[3][ORBSOC_STATE];
  cross(end, &end[3], vector);
  for (size_t i = 0; i < 3u; i++) { momentum_row(end, i, jacobian[i]); }
  write_condition(planner, 0, target->perigee, vector, jacobian, 0.0);
  write_condition(planner, 1, target->ahead, vector, jacobian, 0.0);
  write_condition(planner, 2, target->normal, vector, jacobian, target->momentum);
  laplace_vector(end, vector);
  for (size_t i = 0; i < 3u; i++) { laplace_row(end, i, jacobian[i]); }
  write_condition(planner, 3, target->perigee, vector, jacobian, target->eccentricity);
  write_condition(planner, 4, target->ahead, vector, jacobian, 0.0);
}

void orbsoc_insertion_linearise(orbsoc_planner *planner) {
  const orbsoc_insertion *mission = planner->mission;
  const double doubled = 2.0 * planner->plan.arc.duration;
  for (size_t k = 0; k < mission->entries_a; k++) { planner->a[k] = mission->fixed.a[k]; }
  for (size_t k = 0; k < mission->cone_rows; k++) { planner->h[k] = mission->fixed.h[k]; }
  write_dynamics(planner);
  write_target(planner);
  planner->h[mission->longest_row] = (doubled < mission->longest) ? doubled : mission->longest;
}

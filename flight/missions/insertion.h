/* The shortest burn onto a target orbit, planned on board: a sequence of convex subproblems about a
 * reference (linearisation by collocation), solved by the library, and a flight of its result.
 *
 * Usage: orbsoc_open a solver on the tables of pattern.c, orbsoc_insertion_open a planner on it,
 * then orbsoc_insertion_plan for each state; read `plan`. Nothing is allocated, nothing is global.
 * Units: SI where a name ends in one; all else is canonical, with lengths in radii of the body and
 * a gravitational parameter of 1. Axes are those of the scenario's plans, inertial. */
#ifndef ORBSOC_INSERTION_H
#define ORBSOC_INSERTION_H

#include "orbsoc_flight.h"

#if ORBSOC_FP != 64
#error "the mission's tolerances are below the resolution of binary32: compile with -DORBSOC_FP=64"
#endif

/* Entries of the linearised dynamics at a node, in the order of their places. */
enum { ORBSOC_STATE = 6, ORBSOC_BY_STATE = 12, ORBSOC_TARGET_ROWS = 5 };

/* The orbit to reach: orthonormal directions, |H| and |L| (the eccentricity). */
typedef struct {
  double normal[3];
  double perigee[3];
  double ahead[3]; /* normal x perigee */
  double momentum;
  double eccentricity;
} orbsoc_target_orbit;

/* When the sequence ends, and how exactly subproblems are solved: orbsoc.guidance.scp.Rules. */
typedef struct {
  double step_tol;
  double slack_tol;
  double infeasible_slack;
  double loose_tol;
  double tight_tol;
  double tighten_below;
  double usable_residual;
  double final_residual;
} orbsoc_sequence_rules;

/* What the flight of a plan may miss, as in the scenario's [verification]. */
typedef struct {
  double momentum_rel;
  double laplace;
  double plane_slope; /* tangent of the allowed angle between the planes */
  double thrust_excess;
} orbsoc_flight_limits;

/* The grid of Legendre-Gauss nodes on [-1, 1]; all lists have one number a node. */
typedef struct {
  const double *node;
  const double *weight;      /* of the quadrature */
  const double *from_start;  /* first column of the collocation matrix, for the initial state */
  const double *barycentric; /* weights of the interpolant of the controls */
} orbsoc_grid;

/* The data of a subproblem that no reference changes, the collocation matrix among them; zero where
 * the planner writes. */
typedef struct {
  const double *a;
  const double *g;
  const double *c;
  const double *h;
} orbsoc_fixed_data;

/* Where the entries of the linearised dynamics stand in the data of A. */
typedef struct {
  const orbsoc_index *state;        /* ORBSOC_BY_STATE a node: of the node's own rows, */
  const orbsoc_index *control;      /* 3 a node */
  const orbsoc_index *duration;     /* 6 a node */
  const orbsoc_index *end_state;    /* and the same of the rows of the end state, */
  const orbsoc_index *end_control;
  const orbsoc_index *end_duration; /* 6 */
  const orbsoc_index *target;       /* ORBSOC_TARGET_ROWS rows of 6 */
} orbsoc_places;

/* A mission's constants and tables; generated, constant, and covered by a checksum. */
typedef struct {
  uint32_t nodes;
  uint32_t entries_a;  /* sizes of the pattern that the tables were made for */
  uint32_t entries_g;
  uint32_t variables;
  uint32_t equality_rows;
  uint32_t cone_rows;
  uint32_t control_column;  /* first of each group of unknowns; the states have the first */
  uint32_t end_column;
  uint32_t duration_column;
  uint32_t above_column;    /* slack of the target rows */
  uint32_t below_column;
  uint32_t end_row;         /* first of each group of equalities; the dynamics have the first */
  uint32_t target_row;
  uint32_t longest_row;     /* of the cones: the longest burn that a subproblem allows */
  uint32_t max_subproblems;
  uint32_t guess_steps;     /* of the flight of the first guess, between two nodes */
  uint32_t check_steps;     /* of the flight that judges a plan, between two samples */
  uint32_t check_samples;   /* of that flight, beside its start */
  uint32_t checksum;        /* CRC-32 of all that is here but itself */
  double length_m;
  double speed_m_s;
  double time_s;
  double acceleration;   /* thrust over initial mass */
  double flow;           /* mass flow over initial mass */
  double longest;        /* burn that leaves the dry mass */
  double guess;          /* burn of the first guess, with thrust along the velocity */
  double shortest;       /* burn that a linearisation can still be made about */
  double slack_weight;
  orbsoc_target_orbit target;
  orbsoc_sequence_rules rules;
  orbsoc_flight_limits limits;
  orbsoc_grid grid;
  orbsoc_fixed_data fixed;
  orbsoc_places place;
} orbsoc_insertion;

/* Why a plan ended: the reasons of orbsoc.guidance.scp.ExitReason, and one more. */
typedef enum {
  ORBSOC_PLAN_CONVERGED = 0,
  ORBSOC_PLAN_UNREACHED = 1, /* INFEASIBLE there: converged beside the target, see `violation` */
  ORBSOC_PLAN_SUBPROBLEM_INFEASIBLE = 2, /* a certificate says so: see the solver's solution */
  ORBSOC_PLAN_SUBPROBLEM_FAILED = 3,
  ORBSOC_PLAN_MAX_ITERATIONS = 4,
  ORBSOC_PLAN_INTERRUPTED = 5,           /* by solver.ask */
  ORBSOC_PLAN_NOTHING_TO_BURN = 6        /* the state is on the target orbit: a burn of 0 s */
} orbsoc_plan_exit;

/* What the flight of a plan found amiss; bits. */
enum {
  ORBSOC_MOMENTUM_OFF = 1,
  ORBSOC_LAPLACE_OFF = 2,
  ORBSOC_PLANE_OFF = 4,
  ORBSOC_THRUST_EXCESS = 8,
  ORBSOC_BELOW_GROUND = 16,
  ORBSOC_NOT_FLOWN = 32 /* there was no plan to fly */
};

/* A burn on the grid. */
typedef struct {
  double *states;   /* 6 a node */
  double *controls; /* 3 a node */
  double end[ORBSOC_STATE];
  double duration;
} orbsoc_arc;

typedef struct {
  orbsoc_plan_exit exit;
  uint32_t objections;  /* of the flight; 0: it ends on the target orbit, the plan is verified */
  uint32_t subproblems; /* solved; at most max_subproblems */
  uint32_t iterations;  /* of all of them */
  double change;        /* of the last step, and its total slack; NaN where it gave no point */
  double slack;
  double violation[ORBSOC_TARGET_ROWS]; /* of l.H, q.H, n.H, l.L, q.L, signed */
  double momentum_rel;  /* as flown: |dH|/|H|, |dL|, largest |u| - 1, smallest radius */
  double laplace;
  double thrust_excess;
  double lowest_radius;
  double duration_s;
  orbsoc_arc arc; /* the last reference that was accepted; its controls are the programme */
} orbsoc_plan;

typedef struct {
  const orbsoc_insertion *mission;
  orbsoc_solver *solver;
  double start[ORBSOC_STATE];
  double tolerance; /* of the next subproblem */
  double *a;        /* data of the subproblem */
  double *b;
  double *h;
  orbsoc_plan plan;
} orbsoc_planner;

/* Lay a planner's memory out, on a solver that is open: `words` doubles, as the mission's header
 * says. The tables are checked against their checksum and against the solver's pattern. From then
 * on the planner sets the solver's data and its tolerance; solver.ask and orbsoc_attach are yours.
 */
orbsoc_error orbsoc_insertion_open(orbsoc_planner *planner, const orbsoc_insertion *mission,
                                   orbsoc_solver *solver, double *memory, size_t words);

/* Plan from a state; the outcome is planner->plan. ORBSOC_BAD_VALUE: the state, or a reference that
 * the sequence came to, is not finite. */
orbsoc_error orbsoc_insertion_plan(orbsoc_planner *planner, const double position_m[3],
                                   const double velocity_m_s[3]);

/* The commanded thrust direction, a unit vector, at a time after the ignition: in s, from 0 to
 * plan.duration_s, or else ORBSOC_BAD_VALUE. ORBSOC_NO_DATA: there is no plan. */
orbsoc_error orbsoc_insertion_direction(const orbsoc_planner *planner, double elapsed_s,
                                        double direction[3]);

/* ---- parts of a plan, in the order in which it makes them ---- */

/* The first reference: what thrust along the velocity flies, at the nodes and at the end. */
void orbsoc_insertion_fly_guess(orbsoc_planner *planner);

/* The data of the subproblem about the plan's arc, into the planner's a, b and h. */
void orbsoc_insertion_linearise(orbsoc_planner *planner);

/* Fly the plan as it is commanded, independently of the collocation, and judge where it ends. */
void orbsoc_insertion_fly_plan(orbsoc_planner *planner);

/* Judge an end state, once the flight has noted its thrust excess and its lowest radius. */
void orbsoc_insertion_judge(const orbsoc_insertion *mission, const double end[ORBSOC_STATE],
                            orbsoc_plan *plan);

/* The interpolant of a burn's nodal thrusts after a canonical time, not yet of unit length. */
void orbsoc_insertion_programme(const orbsoc_insertion *mission, const orbsoc_arc *arc,
                                double elapsed, double vector[3]);

/* The checksum of a mission's tables as they are in memory. */
uint32_t orbsoc_insertion_checksum(const orbsoc_insertion *mission);

/* The name of an exit, as reports have it. */
const char *orbsoc_plan_exit_name(orbsoc_plan_exit exit);

#endif

/* The method as data: stages, lists of steps, attempts. Any caller that runs the lists runs the
 * same solve. */
#ifndef ORBSOC_METHOD_H
#define ORBSOC_METHOD_H

#include "orbsoc_flight.h"

typedef enum {
  STAGE_EQUILIBRATE, STAGE_LOAD_KKT, STAGE_IDENTITY_BLOCKS, STAGE_SCALING_BLOCKS, STAGE_FACTORIZE,
  STAGE_START_RHS, STAGE_START_POINT, STAGE_START_SHIFT, STAGE_LOAD_START, STAGE_CENTER_START,
  STAGE_NEWTON_START_RHS, STAGE_NEWTON_START, STAGE_STATISTICS, STAGE_NT_SCALING,
  STAGE_PREDICTOR_RHS, STAGE_SOLVE_PAIR, STAGE_REFINE_PAIR, STAGE_CHECK_PAIR, STAGE_STORE_PAIR,
  STAGE_SOLVE_KKT, STAGE_REFINE_KKT, STAGE_CHECK_SOLVE, STAGE_EMBEDDING_PIVOT, STAGE_STORE_STEP,
  STAGE_TAU_STEP, STAGE_DIRECTION, STAGE_STEP_LENGTH, STAGE_CENTERING, STAGE_CONE_PRODUCT,
  STAGE_CORRECTOR_RHS, STAGE_SLACK_STEP, STAGE_ADVANCE, STAGE_UNSCALE, ORBSOC_STAGES
} orbsoc_stage;

/* Run a stage once; with `until` another stage, run that one, and while it asks to repeat, `stage`
 * and it again. */
typedef struct {
  uint8_t stage;
  uint8_t until; /* `stage` itself: once */
} orbsoc_step;

typedef struct {
  const orbsoc_step *steps;
  size_t count;
} orbsoc_list;

extern const orbsoc_list orbsoc_startup, orbsoc_warm_startup, orbsoc_iteration, orbsoc_closing;

typedef enum { ATTEMPT_WARM, ATTEMPT_COLD, ATTEMPT_REFINED, ATTEMPT_REGULARIZED, ATTEMPT_LIGHT,
               ORBSOC_ATTEMPTS } orbsoc_attempt;

/* A row of the restart policy; the first that fits decides. */
typedef struct {
  uint32_t after;    /* bits of the attempts that ended */
  uint32_t stalled;  /* 1: only where it stalled */
  uint32_t statuses; /* bits of the solve's outcome so far */
  uint32_t attempt;  /* what follows, from the cold start */
  double refinement_factor;
  double regularization_factor;
} orbsoc_restart;

#define ORBSOC_RESTARTS 6u
extern const orbsoc_restart orbsoc_restarts[ORBSOC_RESTARTS];

typedef enum { ORBSOC_NEXT = 0, ORBSOC_REPEAT = 1, ORBSOC_DONE = 2 } orbsoc_outcome;

/* Run one stage. `whole`: with the residual of a linear solve even if no decision needs it. */
orbsoc_outcome orbsoc_run(orbsoc_solver *solver, orbsoc_stage stage, int whole);

/* Forget the last solve; the first attempt is `attempt`. */
void orbsoc_begin(orbsoc_solver *solver, orbsoc_attempt attempt);

/* Load a point in the user's units and rows; 1 where it is of use. */
int orbsoc_load_point(orbsoc_solver *solver, const double *x, const double *y, const double *z,
                      const double *s);

/* Get ready for the restart that is to follow the outcome so far, where there is one: 1. */
int orbsoc_begin_again(orbsoc_solver *solver);

/* The reason to end, with one from outside in its place. */
uint32_t orbsoc_or_from_outside(const orbsoc_solver *solver, uint32_t reason);

/* device.c: a try on the device, as long as solver->event is 0. */
void orbsoc_begin_there(orbsoc_solver *solver);
void orbsoc_begin_attempt_there(orbsoc_solver *solver);
int orbsoc_attempt_there(orbsoc_solver *solver, int warm); /* 0: stage by stage */
int orbsoc_runs_there(const orbsoc_solver *solver, uint32_t module);
void orbsoc_stage_there(orbsoc_solver *solver, orbsoc_stage stage);
void orbsoc_before_stage_here(orbsoc_solver *solver, orbsoc_stage stage);
void orbsoc_after_stage_here(orbsoc_solver *solver, orbsoc_stage stage);
void orbsoc_move_here(orbsoc_solver *solver, uint64_t buffers);
void orbsoc_fetch_answer(orbsoc_solver *solver);
int orbsoc_try_is_over(orbsoc_solver *solver);
int orbsoc_is_believed(const orbsoc_solver *solver);

#endif

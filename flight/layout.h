/* Which word is which in the small buffers. */
#ifndef ORBSOC_LAYOUT_H
#define ORBSOC_LAYOUT_H

enum { STATIC_REGULARIZATION, PIVOT_FLOOR, DYNAMIC_REGULARIZATION, STEP_FRACTION, REFINEMENT_TOL,
       REFINEMENT_SHARE, RESIDUAL_FLOOR, START_FLOOR, PARAMETER_WORDS };

enum { STAT_STRICT, STAT_PRIMAL, STAT_DUAL, STAT_GAP, STAT_OBJECTIVE, STAT_DUAL_OBJECTIVE, STAT_MU,
       STAT_PRIMAL_RADIUS, STAT_DUAL_RADIUS, STAT_NON_FINITE, STAT_WORDS };

enum { EMBEDDING_RESIDUAL, TAU_INV, CURVATURE, EMBEDDING_PIVOT_WORD, EMBEDDING_WORDS };

enum { DAMPING, TARGET, COMPLEMENT, CORRECTION, CENTERING_WORDS };

enum { SHIFT_UP, SHIFT_DOWN, FLOOR, REPLACEMENT, REGULARIZATION_WORDS };

enum { ERROR_NORM, ALLOWED, WORTHWHILE, REFINEMENT_WORDS };

/* Largest b, h and c; what radii of primal and dual infeasibility are compared with. */
enum { NORM_B, NORM_H, NORM_C, PRIMAL_SCALE, DUAL_SCALE, NORM_WORDS };

/* tau, kappa, and whether a step was taken. */
enum { TAU, KAPPA, STEPPED, HOMOGENIZER_WORDS };

/* What an attempt decides by, and what it has decided. */
enum {
  WORD_STOP,              /* why it ends, a STOP_*; 0 while it goes on */
  WORD_NEEDS_RESIDUAL,    /* of the next linear solve */
  WORD_KNOWN_ERROR,       /* largest known error before refinement; 0: none */
  WORD_SAME_FACTORS,      /* the factors of the last check are still in use */
  WORD_TOLERANCE,         /* refinement tolerance of this iteration */
  WORD_TRUSTED,           /* it may tell that a residual needs no check */
  WORD_RISEN,             /* it is no smaller than that of the iteration before */
  WORD_REFINED,           /* refinement steps of the linear solve under way */
  WORD_REFINEMENTS,       /* and of the attempt */
  WORD_BEST,              /* the smallest worst ratio so far */
  WORD_MET,               /* it meets the tolerance */
  WORD_STALLED_ITERATIONS,
  WORD_SHORT_STEPS,
  WORD_ITERATION,
  WORD_STEP,
  WORD_PRIMAL_RADIUS,
  WORD_DUAL_RADIUS,
  WORD_TOLERANCE_AIM,
  WORD_TOLERANCE_MET,
  WORD_MAX_ITERATIONS,
  WORD_MAX_REFINEMENTS,
  WORD_TRUSTING,
  WORD_WARM,
  WORD_LEAST,             /* least primal, dual and gap ratio that was progress */
  CONTROL_WORDS = WORD_LEAST + 3
};

/* Why an attempt ends, in the order in which the reasons are tested. */
enum { STOP_NONE, STOP_NOT_FINITE, STOP_CONVERGED, STOP_PRIMAL_CERTIFICATE, STOP_DUAL_CERTIFICATE,
       STOP_WARM_START_REJECTED, STOP_INTERRUPTED, STOP_MAX_ITERATIONS, STOP_MAX_TIME,
       STOP_STALLED };

/* Scalars of each second-order cone. */
enum { ETA, ETA_INV, ETA_SQ, GAMMA, LAMBDA_ROOT_INV, LAMBDA_RES_INV, LAMBDA_HEAD_INV,
       INV_ONE_PLUS_W0, INV_ONE_PLUS_GAMMA, CONE_SCALARS };

#endif

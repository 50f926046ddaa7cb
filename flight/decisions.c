/* Statistics, second half: the decisions of a solve, as words. When to stop, when to refine once
 * more, what to keep: comparisons, selections and counts on the words of the control buffer. A flag
 * is 1 or 0. */
#include "kernels.h"

#define RADIUS_CONCLUSIVE 1e8  /* a certified radius, over the data's scale, that is enough, */
#define RADIUS_SUFFICIENT 1e6  /* and one that does where kappa/tau exceeds */
#define EMBEDDING_CONCLUSIVE 1e10
#define EMBEDDING_RATIO 1e3    /* kappa/tau from which the embedding leans towards infeasibility */
#define MAX_STALLED_ITERATIONS 15.0
#define SHORT_STEPS 3.0        /* consecutive steps shorter than SHORT_STEP that end an attempt */
#define SHORT_STEP 1e-4
#define WARM_START_MIN_STEP 0.01
#define SKIP_MARGIN 1e4        /* a residual is skipped from this many known errors on */
#define SAME_FACTORS_MARGIN 10.0
#define REASONS 8u

static int raised(orbsoc_real flag) { return 0 < flag; }
static orbsoc_real flag_of(int holds) { return holds ? 1 : 0; }
static orbsoc_real not(orbsoc_real flag) { return flag_of(!raised(flag)); }
static orbsoc_real below(orbsoc_real a, orbsoc_real b) { return flag_of(a < b); }

/* a <= b; raised for what is not a number, too. */
static orbsoc_real at_most(orbsoc_real a, orbsoc_real b) { return not(below(b, a)); }
static orbsoc_real either(orbsoc_real a, orbsoc_real b) { return larger(a, b); }
static orbsoc_real both(orbsoc_real a, orbsoc_real b) { return smaller(a, b); }

static orbsoc_real pick(orbsoc_real flag, orbsoc_real yes, orbsoc_real no) {
  return raised(flag) ? yes : no;
}

/* Whether the next linear solve needs its residual. */
static void need_residual(orbsoc_real *w) {
  const orbsoc_real margin =
      pick(w[WORD_SAME_FACTORS], real(SAME_FACTORS_MARGIN), real(SKIP_MARGIN));
  const orbsoc_real known = w[WORD_KNOWN_ERROR];
  const orbsoc_real little = both(below(0, known), at_most(margin * known, w[WORD_TOLERANCE]));
  w[WORD_NEEDS_RESIDUAL] = either(w[WORD_RISEN], not(both(w[WORD_TRUSTED], little)));
}

/* An iteration begins, with new factors and a new refinement tolerance. */
static void renew(orbsoc_real tolerance, orbsoc_real *w) {
  w[WORD_RISEN] = both(w[WORD_TRUSTED], at_most(w[WORD_TOLERANCE], tolerance));
  w[WORD_TOLERANCE] = tolerance;
  w[WORD_TRUSTED] = w[WORD_TRUSTING];
  w[WORD_SAME_FACTORS] = 0;
  need_residual(w);
}

/* Whether what is not yet within the tolerance became smaller by a tenth. */
static orbsoc_real progressed(const orbsoc_real *stats, orbsoc_real going, orbsoc_real progress,
                              orbsoc_real *w) {
  for (size_t k = 0; k < 3u; k++) {
    const orbsoc_real ratio = stats[STAT_PRIMAL + k], least = w[WORD_LEAST + k];
    const orbsoc_real much = both(going, both(below(w[WORD_TOLERANCE_MET], ratio),
                                              below(ratio, real(0.9) * least)));
    w[WORD_LEAST + k] = pick(much, ratio, least);
    progress = either(progress, much);
  }
  return progress;
}

/* The reason to stop: the first that holds. */
static orbsoc_real reason_of(orbsoc_real finite, orbsoc_real met_before, int clear,
                             const orbsoc_real *w) {
  const orbsoc_real conclusive = clear ? real(RADIUS_SUFFICIENT) : real(RADIUS_CONCLUSIVE);
  const orbsoc_real late = below(real(MAX_STALLED_ITERATIONS), w[WORD_STALLED_ITERATIONS]);
  const orbsoc_real jammed = at_most(real(SHORT_STEPS), w[WORD_SHORT_STEPS]);
  const orbsoc_real shorter = both(below(0, w[WORD_ITERATION]),
                                   below(w[WORD_STEP], real(WARM_START_MIN_STEP)));
  const orbsoc_real converged =
      either(met_before, at_most(w[WORD_BEST], w[WORD_TOLERANCE_AIM]));
  /* From the last that is tested to the first. */
  const orbsoc_real holds[REASONS] = {
      either(late, jammed),
      at_most(w[WORD_MAX_ITERATIONS], w[WORD_ITERATION]),
      both(w[WORD_WARM], shorter),
      at_most(conclusive, w[WORD_DUAL_RADIUS]),
      at_most(conclusive, w[WORD_PRIMAL_RADIUS]),
      converged,
      not(finite),
      w[WORD_STOP],
  };
  const orbsoc_real codes[REASONS] = {
      STOP_STALLED, STOP_MAX_ITERATIONS, STOP_WARM_START_REJECTED, STOP_DUAL_CERTIFICATE,
      STOP_PRIMAL_CERTIFICATE, STOP_CONVERGED, STOP_NOT_FINITE, w[WORD_STOP],
  };
  orbsoc_real reason = 0;
  for (size_t k = 0; k < REASONS; k++) { reason = pick(holds[k], codes[k], reason); }
  return reason;
}

/* After the statistics: whether the attempt ends, and what of the iterate to keep. */
orbsoc_keep orbsoc_judge(const orbsoc_real *stats, const orbsoc_real *homogenizer,
                         orbsoc_real tolerance, orbsoc_real *w) {
  orbsoc_keep keep;
  renew(tolerance, w);
  const orbsoc_real strict = stats[STAT_STRICT];
  const orbsoc_real number = either(below(strict, 1), below(0, strict));
  const orbsoc_real finite = both(below(magnitude(stats[STAT_NON_FINITE]), 1), number);
  const orbsoc_real going = both(finite, not(w[WORD_STOP]));
  keep.best = both(going, below(strict, w[WORD_BEST]));
  w[WORD_BEST] = pick(keep.best, strict, w[WORD_BEST]);

  /* A radius counts only where the embedding, too, says "infeasible". */
  const orbsoc_real tau = homogenizer[TAU], kappa = homogenizer[KAPPA];
  const orbsoc_real leaning = both(going, below(tau * real(EMBEDDING_RATIO), kappa));
  const orbsoc_real radius_p = stats[STAT_PRIMAL_RADIUS], radius_d = stats[STAT_DUAL_RADIUS];
  keep.primal = both(leaning, below(w[WORD_PRIMAL_RADIUS], radius_p));
  keep.dual = both(leaning, below(w[WORD_DUAL_RADIUS], radius_d));
  w[WORD_PRIMAL_RADIUS] = pick(keep.primal, radius_p, w[WORD_PRIMAL_RADIUS]);
  w[WORD_DUAL_RADIUS] = pick(keep.dual, radius_d, w[WORD_DUAL_RADIUS]);

  /* A larger radius is progress, but not where the embedding is clear. */
  const int clear = tau * real(EMBEDDING_CONCLUSIVE) < kappa;
  const orbsoc_real larger_radius = clear ? 0 : either(keep.primal, keep.dual);
  const orbsoc_real progress = progressed(stats, going, larger_radius, w);
  w[WORD_STALLED_ITERATIONS] = pick(progress, 0, w[WORD_STALLED_ITERATIONS] + 1);
  const orbsoc_real met_before = w[WORD_MET];
  w[WORD_MET] = at_most(w[WORD_BEST], w[WORD_TOLERANCE_MET]);
  w[WORD_STOP] = reason_of(finite, met_before, clear, w);
  return keep;
}

/* After a linear solve or a refinement step: whether to refine once more, as `active`. */
void orbsoc_refine_again(size_t sides, const orbsoc_real *entries, orbsoc_real *active,
                         orbsoc_real *w) {
  const orbsoc_real infinite = real((double)INFINITY);
  const orbsoc_real first = not(w[WORD_REFINED]);
  const orbsoc_real noted = both(first, w[WORD_NEEDS_RESIDUAL]);
  orbsoc_real known = w[WORD_KNOWN_ERROR], enough = 1;
  for (size_t r = 0; r < sides; r++) {
    const orbsoc_real *own = &entries[r * REFINEMENT_WORDS];
    const orbsoc_real error = own[ERROR_NORM];
    const orbsoc_real finite = below(magnitude(error), infinite);
    known = larger(known, pick(finite, error, infinite));
    const orbsoc_real worthwhile = either(first, at_most(error, own[WORTHWHILE]));
    const orbsoc_real little = at_most(error, own[ALLOWED]);
    enough = both(enough, either(little, either(not(finite), not(worthwhile))));
  }
  w[WORD_KNOWN_ERROR] = pick(noted, known, w[WORD_KNOWN_ERROR]);
  w[WORD_SAME_FACTORS] = either(w[WORD_SAME_FACTORS], noted);
  const orbsoc_real checked = either(not(first), w[WORD_NEEDS_RESIDUAL]);
  const orbsoc_real possible =
      both(below(w[WORD_REFINED], w[WORD_MAX_REFINEMENTS]), flag_of(raised(active[0])));
  const orbsoc_real more = both(both(checked, not(enough)), both(possible, not(w[WORD_STOP])));
  active[0] = more;
  w[WORD_REFINED] = pick(more, w[WORD_REFINED] + 1, 0);
  w[WORD_REFINEMENTS] = w[WORD_REFINEMENTS] + more;
  need_residual(w);
}

/* Reject a warm start whose barrier parameter is too large. */
orbsoc_real orbsoc_judge_start(orbsoc_real mu, double highest) {
  return (mu < real(highest)) ? 0 : STOP_WARM_START_REJECTED;
}

/* A step was taken. */
void orbsoc_count_step(orbsoc_real taken, orbsoc_real *w) {
  w[WORD_ITERATION] = w[WORD_ITERATION] + 1;
  w[WORD_STEP] = taken;
  w[WORD_SHORT_STEPS] = (taken < real(SHORT_STEP)) ? w[WORD_SHORT_STEPS] + 1 : 0;
}

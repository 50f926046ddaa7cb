//! PL module *statistics*, second half: the decisions of a solve, as words.
//!
//! When to stop, when to refine once more, what to keep: comparisons, selects and counts on the entries of the control
//! buffer, without a branch on data. What runs the lists reads three words and obeys ([`crate::Stage::flag`]): the
//! loop in Rust, a processing system, or the operation control of programmable logic. A flag is 1 or 0.

use super::layout::{control as word, refinement, stat, stop};
use crate::real::Real;

/// A solve that meets the tolerance, but not this fraction of it, takes one iteration more: near the end an iteration
/// gains two digits.
pub(crate) const TOLERANCE_MARGIN: f64 = 0.2;
/// The same after a warm start: the next problem of a sequence moves further than that.
pub(crate) const WARM_TOLERANCE_MARGIN: f64 = 0.5;
/// From a certified radius this many times the data's scale on, iterating further is pointless.
const RADIUS_CONCLUSIVE: f64 = 1e8;
/// … and so is a radius this many times its scale where κ/τ says "infeasible" as clearly as `EMBEDDING_CONCLUSIVE`.
const RADIUS_SUFFICIENT: f64 = 1e6;
const EMBEDDING_CONCLUSIVE: f64 = 1e10;
/// κ/τ from which the embedding leans towards infeasibility.
const EMBEDDING_RATIO: f64 = 1e3;
/// Iterations without progress before a solve counts as stalled.
const MAX_STALLED_ITERATIONS: f64 = 15.0;
/// Consecutive steps shorter than `SHORT_STEP` before a solve counts as stalled.
const SHORT_STEPS: f64 = 3.0;
const SHORT_STEP: f64 = 1e-4;
/// A shorter step after a warm start rejects it: the point was too near the boundary.
const WARM_START_MIN_STEP: f64 = 0.01;
/// A start is rejected from this barrier parameter on, in scaled data, …
pub(crate) const WARM_START_MU_MAX: f64 = 0.5;
/// … and from this one on after its Newton step.
pub(crate) const WARM_STEP_MU_MAX: f64 = 1e3;
/// A linear solve skips its residual where the tolerance is this factor of the attempt's largest known error …
const SKIP_MARGIN: f64 = 1e4;
/// … or this factor, where a residual with the same factors is known.
const SAME_FACTORS_MARGIN: f64 = 10.0;

#[inline(always)]
fn flag<T: Real>(mask: T::Mask) -> T {
    T::select(mask, T::one(), T::zero())
}

#[inline(always)]
fn raised<T: Real>(flag: T) -> T::Mask {
    T::zero().lt(flag)
}

#[inline(always)]
fn not<T: Real>(flag: T) -> T {
    T::select(raised(flag), T::zero(), T::one())
}

#[inline(always)]
fn below<T: Real>(a: T, b: T) -> T {
    flag(a.lt(b))
}

/// `a ≤ b`; raised for what is not a number, too.
#[inline(always)]
fn at_most<T: Real>(a: T, b: T) -> T {
    not(below(b, a))
}

#[inline(always)]
fn either<T: Real>(a: T, b: T) -> T {
    a.max(b)
}

#[inline(always)]
fn both<T: Real>(a: T, b: T) -> T {
    a.min(b)
}

/// What of an iterate is to be kept.
#[derive(Clone, Copy)]
pub(crate) struct Keep<T> {
    /// It is the best so far.
    pub best: T,
    /// Its radius of primal infeasibility is the largest so far …
    pub primal: T,
    /// … and that of dual infeasibility.
    pub dual: T,
}

/// After the statistics: whether the attempt ends, and what of the iterate to keep.
#[inline(always)]
pub(crate) fn judge<T: Real>(stats: &[T], homogenizer: &[T], tolerance: T, w: &mut [T]) -> Keep<T> {
    let (zero, one) = (T::zero(), T::one());
    renew(tolerance, w);
    let strict = stats[stat::STRICT];
    let number = either(below(strict, one), below(zero, strict));
    let finite = both(below(stats[stat::NON_FINITE].abs(), one), number);
    let going = both(finite, not(w[word::STOP]));

    let best = w[word::BEST];
    let improved = both(going, below(strict, best));
    let best = T::select(raised(improved), strict, best);
    w[word::BEST] = best;

    // The embedding of a solvable problem ends with τ ≫ κ, whatever radius it passes by: a radius counts only where the
    // embedding, too, says "infeasible".
    let (tau, kappa) = (homogenizer[0], homogenizer[1]);
    let leaning = both(going, below(tau * T::constant(EMBEDDING_RATIO), kappa));
    let (radius_p, radius_d) = (stats[stat::PRIMAL_RADIUS], stats[stat::DUAL_RADIUS]);
    let primal = both(leaning, below(w[word::PRIMAL_RADIUS], radius_p));
    let dual = both(leaning, below(w[word::DUAL_RADIUS], radius_d));
    w[word::PRIMAL_RADIUS] = T::select(raised(primal), radius_p, w[word::PRIMAL_RADIUS]);
    w[word::DUAL_RADIUS] = T::select(raised(dual), radius_d, w[word::DUAL_RADIUS]);

    // Progress is what is not yet within the tolerance becoming smaller by a tenth: the worst ratio may rise, the gap's
    // for one, while others fall. A larger radius is progress, too, but not where κ/τ is clear: in units far from one it
    // would rise to the iteration limit.
    let clear = (tau * T::constant(EMBEDDING_CONCLUSIVE)).lt(kappa);
    let mut progress = T::select(clear, zero, either(primal, dual));
    for (k, at) in [stat::PRIMAL, stat::DUAL, stat::GAP].into_iter().enumerate() {
        let (ratio, least) = (stats[at], w[word::LEAST + k]);
        let much = both(below(w[word::TOLERANCE_MET], ratio), below(ratio, T::constant(0.9) * least));
        let much = both(going, much);
        w[word::LEAST + k] = T::select(raised(much), ratio, least);
        progress = either(progress, much);
    }
    let stalled_iterations = T::select(raised(progress), zero, w[word::STALLED_ITERATIONS] + one);
    w[word::STALLED_ITERATIONS] = stalled_iterations;
    let met_before = w[word::MET];
    w[word::MET] = at_most(best, w[word::TOLERANCE_MET]);

    let conclusive = T::select(clear, T::constant(RADIUS_SUFFICIENT), T::constant(RADIUS_CONCLUSIVE));
    let short_steps = at_most(T::constant(SHORT_STEPS), w[word::SHORT_STEPS]);
    let slow = below(T::constant(MAX_STALLED_ITERATIONS), stalled_iterations);
    let short = both(below(zero, w[word::ITERATION]), below(w[word::STEP], T::constant(WARM_START_MIN_STEP)));
    // From the last that is tested to the first.
    let reasons = [
        (either(slow, short_steps), stop::STALLED),
        (at_most(w[word::MAX_ITERATIONS], w[word::ITERATION]), stop::MAX_ITERATIONS),
        (both(w[word::WARM], short), stop::WARM_START_REJECTED),
        (at_most(conclusive, w[word::DUAL_RADIUS]), stop::DUAL_CERTIFICATE),
        (at_most(conclusive, w[word::PRIMAL_RADIUS]), stop::PRIMAL_CERTIFICATE),
        (either(met_before, at_most(best, w[word::TOLERANCE_AIM])), stop::CONVERGED),
        (not(finite), stop::NOT_FINITE),
        (w[word::STOP], stop::NONE),
    ];
    let mut reason = zero;
    for (k, (holds, code)) in reasons.into_iter().enumerate() {
        let code = if k + 1 == reasons.len() { w[word::STOP] } else { T::constant(code) };
        reason = T::select(raised(holds), code, reason);
    }
    w[word::STOP] = reason;
    Keep { best: improved, primal, dual }
}

/// Keep these vectors, one after the other, in place of those kept so far where a flag is raised.
#[inline(always)]
pub(crate) fn keep<T: Real>(where_: T, vectors: &[&[T]], mut kept: &mut [T]) {
    if T::is_down(where_) {
        return;
    }
    for entries in vectors {
        let here;
        (here, kept) = kept.split_at_mut(entries.len());
        for (kept, &entry) in here.iter_mut().zip(*entries) {
            *kept = T::select(raised(where_), entry, *kept);
        }
    }
}

/// An iteration begins, with new factors and a new refinement tolerance.
#[inline(always)]
pub(crate) fn renew<T: Real>(tolerance: T, w: &mut [T]) {
    w[word::RISEN] = both(w[word::TRUSTED], at_most(w[word::TOLERANCE], tolerance));
    w[word::TOLERANCE] = tolerance;
    w[word::TRUSTED] = w[word::TRUSTING];
    w[word::SAME_FACTORS] = T::zero();
    need_residual(w);
}

/// Whether the next linear solve needs its residual. From one iteration to the next errors change little, as a rule, while
/// tolerances fall. Where one does not, a skipped residual may be why, and all are checked; so are those of an attempt
/// that knows no error above zero.
#[inline(always)]
fn need_residual<T: Real>(w: &mut [T]) {
    let (same, skip) = (T::constant(SAME_FACTORS_MARGIN), T::constant(SKIP_MARGIN));
    let margin = T::select(raised(w[word::SAME_FACTORS]), same, skip);
    let known = w[word::KNOWN_ERROR];
    let small = both(below(T::zero(), known), at_most(margin * known, w[word::TOLERANCE]));
    w[word::NEEDS_RESIDUAL] = either(w[word::RISEN], not(both(w[word::TRUSTED], small)));
}

/// After a linear solve or a refinement step, whose entries these are, three for each right-hand side: whether to refine
/// once more, as `active`.
#[inline(always)]
pub(crate) fn refine_again<T: Real>(entries: &[T], active: &mut T, w: &mut [T]) {
    let (zero, one, infinite) = (T::zero(), T::one(), T::constant(f64::INFINITY));
    let first = not(w[word::REFINED]);
    let noted = both(first, w[word::NEEDS_RESIDUAL]);
    let (mut known, mut enough) = (w[word::KNOWN_ERROR], one);
    for entries in entries.chunks_exact(refinement::WORDS) {
        let error = entries[refinement::ERROR];
        let finite = below(error.abs(), infinite);
        // What is not a number is above every tolerance.
        known = known.max(T::select(raised(finite), error, infinite));
        let worthwhile = either(first, at_most(error, entries[refinement::WORTHWHILE]));
        let small = at_most(error, entries[refinement::ALLOWED]);
        enough = both(enough, either(small, either(not(finite), not(worthwhile))));
    }
    w[word::KNOWN_ERROR] = T::select(raised(noted), known, w[word::KNOWN_ERROR]);
    w[word::SAME_FACTORS] = either(w[word::SAME_FACTORS], noted);
    let checked = either(not(first), w[word::NEEDS_RESIDUAL]);
    let possible = both(below(w[word::REFINED], w[word::MAX_REFINEMENTS]), flag(raised(*active)));
    // Whatever other lanes still refine leaves one alone that has enough.
    let more = both(both(checked, not(enough)), both(possible, not(w[word::STOP])));
    *active = more;
    w[word::REFINED] = T::select(raised(more), w[word::REFINED] + one, zero);
    w[word::REFINEMENTS] = w[word::REFINEMENTS] + more;
    need_residual(w);
}

/// Reject a warm start whose barrier parameter is too large.
#[inline(always)]
pub(crate) fn judge_start<T: Real>(mu: T, highest: f64) -> T {
    T::select(mu.lt(T::constant(highest)), T::zero(), T::constant(stop::WARM_START_REJECTED))
}

/// A step was taken.
#[inline(always)]
pub(crate) fn count_step<T: Real>(taken: T, w: &mut [T]) {
    w[word::ITERATION] = w[word::ITERATION] + T::one();
    w[word::STEP] = taken;
    let short = taken.lt(T::constant(SHORT_STEP));
    w[word::SHORT_STEPS] = T::select(short, w[word::SHORT_STEPS] + T::one(), T::zero());
}

//! The decisions of a solve: when to stop, when to refine, what to keep. Decisions compare entries that
//! a stage computed and copy buffers; they do no arithmetic on iterates.

use crate::kernels::layout::stat;
use crate::method::restart::{self, Attempt, Restart};
use crate::method::stage::{Outcome, Stage};
use crate::method::{refinement::Accuracy, workspace::Workspace};
use crate::outcome::solution::{Status, WarmStart};
use crate::outcome::verification::Stop;
use crate::problem::Settings;
use crate::real::{Decide, Real};
use std::time::{Duration, Instant};

/// From a certified radius this many times the data's scale on, iterating further is pointless.
const RADIUS_CONCLUSIVE: f64 = 1e8;
/// … and so is a radius this many times its scale where κ/τ says "infeasible" as clearly as `EMBEDDING_CONCLUSIVE`.
const RADIUS_SUFFICIENT: f64 = 1e6;
/// A solve that meets the tolerance, but not this fraction of it, takes one iteration more: near the end an iteration
/// gains two digits.
const TOLERANCE_MARGIN: f64 = 0.2;
/// The same after a warm start: the next problem of a sequence moves further than that.
const WARM_TOLERANCE_MARGIN: f64 = 0.5;
const EMBEDDING_CONCLUSIVE: f64 = 1e10;
/// κ/τ from which the embedding leans towards infeasibility.
const EMBEDDING_RATIO: f64 = 1e3;
/// Iterations without a better iterate or a larger radius before a solve counts as stalled.
const MAX_STALLED_ITERATIONS: u32 = 15;
/// Consecutive steps shorter than `SHORT_STEP` before a solve counts as stalled.
const SHORT_STEPS: u32 = 3;
const SHORT_STEP: f64 = 1e-4;
/// A start is rejected from this barrier parameter on, in scaled data, …
const WARM_START_MU_MAX: f64 = 0.5;
/// … and from this one on after its Newton step.
pub(crate) const WARM_STEP_MU_MAX: f64 = 1e3;
/// A shorter step after a warm start rejects it: the point was too near the boundary.
const WARM_START_MIN_STEP: f64 = 0.01;
#[derive(Clone, Debug, Default)]
#[allow(clippy::struct_excessive_bools)] // independent facts about one attempt, no state machine
pub(crate) struct Control {
    /// Steps taken since the last start.
    pub iteration: u32,
    /// Steps of earlier attempts of the same solve.
    spent: u32,
    pub warm_start: WarmStart,
    pub attempt: Attempt,
    /// Attempts of the same solve before this one.
    pub restarts: u32,
    /// Refinement steps of the whole solve.
    pub refinements: u32,
    /// Set from outside to stop at the next statistics.
    pub interrupted: bool,
    pub best: f64,
    /// The least primal, dual and gap ratio that was progress.
    least: [f64; 3],
    pub primal_radius: f64,
    pub dual_radius: f64,
    /// Why the iteration ended, once it has.
    pub stop: Option<Stop>,
    /// Length of the last step; 0 before the first.
    pub step: f64,
    /// The last statistics were the best so far: the iterate is to be kept.
    improved: bool,
    /// The best iterate meets the tolerance.
    met: bool,
    stalled_iterations: u32,
    short_steps: u32,
    accuracy: Accuracy,
    deadline: Option<Instant>,
    /// Since when the attempt is suspended.
    suspended: Option<Instant>,
}

impl Control {
    pub fn new(settings: &Settings) -> Self {
        let deadline = Duration::try_from_secs_f64(settings.max_time_s)
            .ok()
            .and_then(|limit| Instant::now().checked_add(limit));
        Self { best: f64::INFINITY, least: [f64::INFINITY; 3], deadline, ..Self::default() }
    }

    /// The restart that is to follow this attempt, after which the outcome so far has this `status`.
    pub fn next_restart(&self, status: Status, settings: &Settings) -> Option<&'static Restart> {
        let stalled = self.stop == Some(Stop::Stalled);
        restart::next(self.attempt, stalled, status).filter(|_| self.restarts < settings.max_restarts)
    }

    /// The control of that restart, from cold: the clock and the counts go on.
    pub fn restarted(&self, attempt: Attempt) -> Self {
        let warm = self.warm_start != WarmStart::None;
        Self {
            attempt,
            restarts: self.restarts + 1,
            warm_start: if warm { WarmStart::FellBack } else { WarmStart::None },
            best: f64::INFINITY,
            least: [f64::INFINITY; 3],
            deadline: self.deadline,
            suspended: self.suspended,
            interrupted: self.interrupted,
            refinements: self.refinements,
            spent: self.spent + self.iteration,
            ..Self::default()
        }
    }

    /// Start from a point that is given, or from cold where it is not `useful`.
    pub fn start_warm(&mut self, useful: bool) {
        (self.attempt, self.warm_start) =
            if useful { (Attempt::Warm, WarmStart::Used) } else { (Attempt::Cold, WarmStart::FellBack) };
    }

    /// Suspend the attempt; its clock stands still.
    pub fn suspend(&mut self, now: Instant) {
        self.suspended = Some(now);
    }

    /// Resume a suspended attempt.
    pub fn resume(&mut self, now: Instant) {
        if let (Some(deadline), Some(since)) = (&mut self.deadline, self.suspended.take()) {
            *deadline += now - since;
        }
    }

    /// Whether a certificate of infeasibility has been kept, whatever it is worth.
    pub fn has_certificate(&self) -> bool {
        self.primal_radius > 0.0 || self.dual_radius > 0.0
    }

    /// Steps taken in the whole solve.
    pub fn total_iterations(&self) -> u32 {
        self.spent + self.iteration
    }

    /// The attempt has ended: what the stages compute for other lanes meanwhile is not kept.
    pub fn mask(&mut self) {
        self.improved = false;
    }

    /// Whether a decision needs the residual of the linear solve that a stage makes, if it makes one.
    pub fn needs_residual(&self, stage: Stage) -> bool {
        !matches!(stage, Stage::SolveConstantAndPredictor | Stage::SolveKkt) || self.accuracy.needs_residual()
    }

    /// What a stage that has run asks of the loop, for the problem in one lane.
    pub fn decide<T: Decide>(
        &mut self,
        lane: usize,
        stage: Stage,
        settings: &Settings,
        work: &mut Workspace<T>,
    ) -> Outcome {
        let active = &mut work.refinement_active[0];
        let outcome = match stage {
            Stage::Statistics => self.judge(lane, settings, work),
            Stage::CheckSolve => self.judge_refinement(lane, settings, &work.refinement, active),
            Stage::CheckConstantAndPredictor => {
                self.judge_refinement(lane, settings, &work.multi_refinement, active)
            }
            Stage::CenterStart => judge_start(work.homogenizer[1].lane(lane), WARM_START_MU_MAX),
            Stage::NewtonStart => judge_start(work.homogenizer[1].lane(lane), WARM_STEP_MU_MAX),
            Stage::Advance => {
                self.note_step(work.step_taken[0].lane(lane));
                Outcome::Next
            }
            _ => Outcome::Next,
        };
        if let Outcome::Done(stop) = outcome {
            self.stop = Some(stop);
        }
        outcome
    }

    /// After the statistics: keep what is better than anything before, and stop or go on.
    fn judge<T: Decide>(&mut self, lane: usize, settings: &Settings, w: &mut Workspace<T>) -> Outcome {
        let entry = |k: usize| w.statistics[k].lane(lane);
        let (strict, primal, dual) =
            (entry(stat::STRICT), entry(stat::PRIMAL_RADIUS), entry(stat::DUAL_RADIUS));
        self.improved = false;
        // Only a plain cold attempt skips residuals: a warm one begins where they are large.
        let trusting = self.attempt == Attempt::Cold;
        self.accuracy.renew(trusting.then(|| w.refinement_tolerance[0].lane(lane)));
        if entry(stat::NON_FINITE) != 0.0 || strict.is_nan() {
            return Outcome::Done(Stop::Stalled);
        }
        self.stalled_iterations += 1;
        // Progress is what is not yet within the tolerance becoming smaller by a tenth: the worst ratio may rise, the gap's
        // for one, while others fall.
        for (k, least) in [stat::PRIMAL, stat::DUAL, stat::GAP].into_iter().zip(&mut self.least) {
            let ratio = entry(k);
            if ratio > settings.tol && ratio < 0.9 * *least {
                *least = ratio;
                self.stalled_iterations = 0;
            }
        }
        if strict < self.best {
            self.best = strict;
            self.improved = true;
        }
        // The embedding of a solvable problem ends with τ ≫ κ, whatever radius it passes by: a radius
        // counts only where the embedding, too, says "infeasible".
        let (tau, kappa) = (w.homogenizer[0].lane(lane), w.homogenizer[1].lane(lane));
        let leaning = tau * EMBEDDING_RATIO < kappa;
        if leaning && primal > self.primal_radius {
            self.primal_radius = primal;
            self.stalled_iterations = 0;
            copy_lane(lane, w.point.iter(), &mut w.primal_certificate);
        }
        if leaning && dual > self.dual_radius {
            self.dual_radius = dual;
            self.stalled_iterations = 0;
            copy_lane(lane, w.point.iter().chain(&w.slack), &mut w.dual_certificate);
        }
        let clear = tau * EMBEDDING_CONCLUSIVE < kappa;
        match self.reason(settings, if clear { RADIUS_SUFFICIENT } else { RADIUS_CONCLUSIVE }) {
            Some(stop) => Outcome::Done(stop),
            None => Outcome::Next,
        }
    }

    fn reason(&mut self, settings: &Settings, conclusive: f64) -> Option<Stop> {
        let met_before = core::mem::replace(&mut self.met, self.best <= settings.tol);
        let aim = if self.attempt == Attempt::Warm { WARM_TOLERANCE_MARGIN } else { TOLERANCE_MARGIN };
        if self.best <= aim * settings.tol || met_before {
            Some(Stop::Converged)
        } else if self.primal_radius >= conclusive {
            Some(Stop::PrimalCertificate)
        } else if self.dual_radius >= conclusive {
            Some(Stop::DualCertificate)
        } else if self.warm_start_fails() {
            Some(Stop::WarmStartRejected)
        } else if self.interrupted {
            Some(Stop::Interrupted)
        } else if self.iteration >= settings.max_iterations {
            Some(Stop::MaxIterations)
        } else if self.deadline.is_some_and(|at| Instant::now() >= at) {
            Some(Stop::MaxTime)
        } else if self.stalled_iterations > MAX_STALLED_ITERATIONS || self.short_steps >= SHORT_STEPS {
            Some(Stop::Stalled)
        } else {
            None
        }
    }

    /// Whether the last step rejects the warm start.
    fn warm_start_fails(&self) -> bool {
        self.attempt == Attempt::Warm && self.iteration > 0 && self.step < WARM_START_MIN_STEP
    }

    /// After a solve or a refinement step: refine (once more), or go on.
    fn judge_refinement<T: Decide>(
        &mut self,
        lane: usize,
        settings: &Settings,
        entries: &[T],
        active: &mut T,
    ) -> Outcome {
        if !self.accuracy.wants_more(lane, settings.refinement_max, entries, active) {
            return Outcome::Next;
        }
        self.refinements += 1;
        Outcome::Repeat
    }

    fn note_step(&mut self, taken: f64) {
        self.iteration += 1;
        self.step = taken;
        self.short_steps = if taken < SHORT_STEP { self.short_steps + 1 } else { 0 };
    }
}

/// After the statistics: keep the iterates that are better than anything before in their lanes. Entries of
/// lanes without a problem mean nothing.
pub(crate) fn keep_best<'a, T: Decide>(
    lanes: impl Iterator<Item = Option<&'a Control>> + Clone,
    w: &mut Workspace<T>,
) {
    if lanes.clone().flatten().all(|control| control.improved) {
        let (point, rest) = w.best.split_at_mut(w.point.len());
        let (slack, tau) = rest.split_at_mut(w.slack.len());
        point.copy_from_slice(&w.point);
        slack.copy_from_slice(&w.slack);
        tau.copy_from_slice(&w.homogenizer[..1]);
        return;
    }
    let mut improved = T::zero();
    for (lane, control) in lanes.enumerate() {
        improved.set_lane(lane, f64::from(u8::from(control.is_some_and(|control| control.improved))));
    }
    T::vectorize(Keep { improved, work: w });
}

/// Keep the iterates of the lanes where `improved` is positive.
struct Keep<'a, T> {
    improved: T,
    work: &'a mut Workspace<T>,
}

impl<T: Real> pulp::WithSimd for Keep<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let improved = T::zero().lt(self.improved);
        let Workspace { best, point, slack, homogenizer, .. } = self.work;
        for (best, &new) in best.iter_mut().zip(point.iter().chain(&*slack).chain(&homogenizer[..1])) {
            *best = T::select(improved, new, *best);
        }
    }
}

/// Reject a warm start whose barrier parameter is too large.
fn judge_start(mu: f64, highest: f64) -> Outcome {
    if mu < highest {
        Outcome::Next
    } else {
        Outcome::Done(Stop::WarmStartRejected)
    }
}

/// Copy one lane's entries.
fn copy_lane<'a, T: Decide>(lane: usize, from: impl Iterator<Item = &'a T>, to: &mut [T]) {
    for (to, from) in to.iter_mut().zip(from) {
        to.set_lane(lane, from.lane(lane));
    }
}

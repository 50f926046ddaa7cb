//! What a solve's loop does with its decisions, which the stages make as words: count, stop, restart.

use crate::kernels::layout::{control as word, stop as code};
use crate::method::restart::{self, Attempt, Restart};
use crate::method::stage::{Flag, Outcome, Stage};
use crate::method::workspace::Workspace;
use crate::outcome::solution::{Status, WarmStart};
use crate::outcome::verification::Stop;
use crate::problem::Settings;
use crate::real::Decide;
use std::time::{Duration, Instant};

/// The reasons and their words.
const STOPS: &[(f64, Stop)] = &[
    (code::NOT_FINITE, Stop::Stalled),
    (code::CONVERGED, Stop::Converged),
    (code::PRIMAL_CERTIFICATE, Stop::PrimalCertificate),
    (code::DUAL_CERTIFICATE, Stop::DualCertificate),
    (code::WARM_START_REJECTED, Stop::WarmStartRejected),
    (code::INTERRUPTED, Stop::Interrupted),
    (code::MAX_ITERATIONS, Stop::MaxIterations),
    (code::MAX_TIME, Stop::MaxTime),
    (code::STALLED, Stop::Stalled),
];

#[derive(Clone, Debug, Default)]
pub(crate) struct Control {
    /// Steps taken since the last start.
    pub iteration: u32,
    /// Steps of earlier attempts of the same solve.
    spent: u32,
    pub warm_start: WarmStart,
    pub attempt: Attempt,
    /// Attempts of the same solve before this one.
    pub restarts: u32,
    /// Refinement steps of the whole solve …
    pub refinements: u32,
    /// … and of its attempts before this one.
    refined_before: u32,
    /// Set from outside to stop at the next statistics.
    pub interrupted: bool,
    pub best: f64,
    pub primal_radius: f64,
    pub dual_radius: f64,
    /// Why the iteration ended, once it has.
    pub stop: Option<Stop>,
    /// Length of the last step; 0 before the first.
    pub step: f64,
    deadline: Option<Instant>,
    /// Since when the attempt is suspended.
    suspended: Option<Instant>,
}

impl Control {
    pub fn new(settings: &Settings) -> Self {
        let deadline = Duration::try_from_secs_f64(settings.max_time_s)
            .ok()
            .and_then(|limit| Instant::now().checked_add(limit));
        Self { best: f64::INFINITY, deadline, ..Self::default() }
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
            deadline: self.deadline,
            suspended: self.suspended,
            interrupted: self.interrupted,
            refinements: self.refinements,
            refined_before: self.refinements,
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

    /// Whether a decision needs the residual of the linear solve that a stage makes, if it makes one.
    pub fn needs_residual<T: Decide>(lane: usize, stage: Stage, work: &Workspace<T>) -> bool {
        !matches!(stage, Stage::SolveConstantAndPredictor | Stage::SolveKkt)
            || work.control[word::NEEDS_RESIDUAL].lane(lane) != 0.0
    }

    /// What a stage that has run asks of the loop, for the problem in one lane.
    pub fn decide<T: Decide>(&mut self, lane: usize, stage: Stage, work: &mut Workspace<T>) -> Outcome {
        if stage == Stage::Advance {
            self.take_over(lane, &work.control);
        }
        let value = |buffer| work.get(buffer)[0].lane(lane);
        let mut reason = match stage.flag() {
            None => return Outcome::Next,
            Some(Flag::Repeat(buffer)) if value(buffer) == 0.0 => return Outcome::Next,
            Some(Flag::Repeat(_)) => return Outcome::Repeat,
            Some(Flag::Stop(buffer)) => value(buffer),
        };
        self.take_over(lane, &work.control);
        if stage == Stage::Statistics {
            reason = self.or_from_outside(reason);
        }
        self.end(lane, reason, work)
    }

    /// End the attempt, if there is a reason to.
    pub fn end<T: Decide>(&mut self, lane: usize, reason: f64, work: &mut Workspace<T>) -> Outcome {
        let Some(stop) = stop_of(reason) else { return Outcome::Next };
        self.stop = Some(stop);
        // What the stages compute for other lanes meanwhile is not kept.
        work.control[word::STOP].set_lane(lane, reason);
        Outcome::Done(stop)
    }

    /// The attempt ran elsewhere, and has left these words.
    pub fn ended<T: Decide>(&mut self, lane: usize, work: &Workspace<T>) {
        self.take_over(lane, &work.control);
        let rejected = work.verdict[0].lane(lane);
        let reason = if rejected == code::NONE { work.control[word::STOP].lane(lane) } else { rejected };
        self.stop = stop_of(self.or_from_outside(reason));
    }

    /// The counts and sizes that the stages have left in the control buffer.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // counts, below 2³²
    fn take_over<T: Decide>(&mut self, lane: usize, words: &[T]) {
        let entry = |k: usize| words[k].lane(lane);
        let count = |k: usize| entry(k) as u32;
        self.iteration = count(word::ITERATION);
        self.refinements = self.refined_before + count(word::REFINEMENTS);
        (self.best, self.step) = (entry(word::BEST), entry(word::STEP));
        (self.primal_radius, self.dual_radius) = (entry(word::PRIMAL_RADIUS), entry(word::DUAL_RADIUS));
    }

    /// The reason to end the attempt, with those that come from outside in their places.
    pub fn or_from_outside(&self, reason: f64) -> f64 {
        let before = |other: f64| reason == code::NONE || reason > other;
        let late = || self.deadline.is_some_and(|at| Instant::now() >= at);
        if self.interrupted && before(code::INTERRUPTED) {
            code::INTERRUPTED
        } else if before(code::MAX_TIME) && late() {
            code::MAX_TIME
        } else {
            reason
        }
    }
}

/// The reason that a word names.
fn stop_of(reason: f64) -> Option<Stop> {
    STOPS.iter().find(|(word, _)| *word == reason).map(|&(_, stop)| stop)
}

//! The decisions of a solve: when to stop, when to refine, what to keep. Decisions compare words that
//! a stage computed and copy buffers; they do no arithmetic on iterates.

use crate::kernels::linear_solve::refinement;
use crate::ps::stat;
use crate::real::Decide;
use crate::settings::Settings;
use crate::stage::{Outcome, Stop};
use crate::workspace::Workspace;
use std::time::{Duration, Instant};

/// A certified radius this many times the data's scale is claimed (at the end of a solve) …
pub(crate) const RADIUS_CLAIMED: f64 = 50.0;
/// … and from here on iterating further is pointless.
const RADIUS_CONCLUSIVE: f64 = 1e6;
/// κ/τ from which the embedding leans towards infeasibility.
const EMBEDDING_RATIO: f64 = 1e3;
/// Iterations without a better iterate or a larger radius before a solve counts as stalled.
const PATIENCE: u32 = 12;
/// Consecutive steps shorter than `SHORT_STEP` before a solve counts as stalled.
const SHORT_STEPS: u32 = 3;
const SHORT_STEP: f64 = 1e-4;

#[derive(Clone, Debug, Default)]
pub(crate) struct Control {
    /// Steps taken.
    pub iteration: u32,
    /// Refinement steps of the whole solve.
    pub refinements: u32,
    /// Set from outside to stop at the next statistics.
    pub interrupted: bool,
    pub best: f64,
    pub primal_radius: f64,
    pub dual_radius: f64,
    idle: u32,
    short_steps: u32,
    refined: u32,
    deadline: Option<Instant>,
}

impl Control {
    pub fn new(settings: &Settings) -> Self {
        let deadline = Duration::try_from_secs_f64(settings.max_time_s)
            .ok()
            .and_then(|limit| Instant::now().checked_add(limit));
        Self { best: f64::INFINITY, deadline, ..Self::default() }
    }

    /// After the statistics: keep what is better than anything before, and stop or go on.
    pub fn judge<T: Decide>(&mut self, settings: &Settings, w: &mut Workspace<T>) -> Outcome {
        let word = |k: usize| w.statistics[k].value();
        let (strict, primal, dual) = (word(stat::STRICT), word(stat::PRIMAL_RADIUS), word(stat::DUAL_RADIUS));
        if word(stat::WITNESS) != 0.0 || strict.is_nan() {
            return Outcome::Done(Stop::Stalled);
        }
        self.idle += 1;
        if strict < self.best {
            // Creeping is not progress.
            if strict < 0.9 * self.best {
                self.idle = 0;
            }
            self.best = strict;
            w.keep_best();
        }
        // The embedding of a solvable problem ends with τ ≫ κ, whatever radius it passes by: a radius
        // that is not conclusive counts only where the embedding, too, says "infeasible".
        let leaning = w.homogenizer[0].value() * EMBEDDING_RATIO < w.homogenizer[1].value();
        let counts = |radius: f64| leaning || radius >= RADIUS_CONCLUSIVE;
        if counts(primal) && primal > self.primal_radius {
            self.primal_radius = primal;
            self.idle = 0;
            w.farkas.copy_from_slice(&w.point);
        }
        if counts(dual) && dual > self.dual_radius {
            self.dual_radius = dual;
            self.idle = 0;
            let unknowns = w.point.len();
            w.ray[..unknowns].copy_from_slice(&w.point);
            w.ray[unknowns..].copy_from_slice(&w.slack);
        }
        match self.reason(settings, strict) {
            Some(stop) => Outcome::Done(stop),
            None => Outcome::Next,
        }
    }

    fn reason(&self, settings: &Settings, strict: f64) -> Option<Stop> {
        if strict <= settings.tol {
            Some(Stop::Converged)
        } else if self.primal_radius >= RADIUS_CONCLUSIVE {
            Some(Stop::PrimalCertificate)
        } else if self.dual_radius >= RADIUS_CONCLUSIVE {
            Some(Stop::DualCertificate)
        } else if self.interrupted {
            Some(Stop::Interrupted)
        } else if self.iteration >= settings.max_iterations {
            Some(Stop::MaxIterations)
        } else if self.deadline.is_some_and(|at| Instant::now() >= at) {
            Some(Stop::MaxTime)
        } else if self.idle > PATIENCE || self.short_steps >= SHORT_STEPS {
            Some(Stop::Stalled)
        } else {
            None
        }
    }

    /// After a solve or a refinement step: refine (once more), or go on.
    pub fn judge_refinement<T: Decide>(&mut self, settings: &Settings, w: &Workspace<T>) -> Outcome {
        let word = |k: usize| w.refinement[k].value();
        let error = word(refinement::ERROR);
        let worthwhile = error.is_finite() && (self.refined == 0 || error <= word(refinement::WORTHWHILE));
        if error <= word(refinement::ALLOWED) || !worthwhile || self.refined >= settings.refinement_max {
            self.refined = 0;
            return Outcome::Next;
        }
        self.refined += 1;
        self.refinements += 1;
        Outcome::Repeat
    }

    /// After a step of length `taken`.
    pub fn note_step(&mut self, taken: f64) {
        self.iteration += 1;
        self.short_steps = if taken < SHORT_STEP { self.short_steps + 1 } else { 0 };
    }
}

impl<T: Copy> Workspace<T> {
    fn keep_best(&mut self) {
        let (unknowns, rows) = (self.point.len(), self.slack.len());
        self.best[..unknowns].copy_from_slice(&self.point);
        self.best[unknowns..unknowns + rows].copy_from_slice(&self.slack);
        self.best[unknowns + rows] = self.homogenizer[0];
    }
}

//! One solve's state, and the only door to the kernels: [`Engine::run`].

use crate::error::Error;
use crate::kernels::layout::{stat, stop};
use crate::kkt::known::structure_of;
use crate::kkt::structure::Structure;
use crate::method::control::Control;
use crate::method::observer::{Observer, Progress};
use crate::method::restart::{Attempt, Restart, LONGEST};
use crate::method::stage::{Outcome, Stage, Step, CLOSING, ITERATION, STARTUP, WARM_STARTUP};
use crate::method::workspace::Buffer;
use crate::method::{compiled::Compiled, datapath::Datapath, events::Event, warm_start::Start};
use crate::outcome::solution::{better_of, Solution};
use crate::problem::{Problem, Settings};
use crate::symbolic::{ordering::FactorShape, supernodes::Panels};
use core::ops::ControlFlow;
use std::sync::Arc;

/// A problem's pattern, its buffers in arithmetic `T`, and where the solve stands.
///
/// Everything is allocated by [`Engine::new`]; from the first `run` of an attempt to its last, nothing is.
///
/// ```
/// # use orbsoc::*;
/// # let problem = Problem::new(None, vec![1.0], None, vec![], Some(Csc::from_dense(&[&[-1.0]], 1)),
/// #     vec![-2.0], Cones { l: 1, q: vec![] })?;
/// let mut engine = Engine::<f64>::new(&problem, &Settings::default())?;
/// let solution = engine.solve();
/// assert!((solution.x[0] - 2.0).abs() < 1e-7);
/// assert_eq!(engine.events()[0].stage, Stage::Equilibrate);
/// # Ok::<(), Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Engine<T> {
    pub(crate) path: Datapath<T>,
    problem: Arc<Problem>,
    pub(crate) control: Control,
    /// The outcome of an earlier attempt of this solve, which stalled.
    earlier: Option<Solution>,
    events: Vec<Event>,
    /// Multiply–subtracts from which on a factorization is watched.
    pub(crate) long: usize,
}

/// Multiply–subtracts of some tens of milliseconds.
pub(crate) const LONG: usize = 1 << 27;

impl<T: Compiled> Engine<T> {
    /// Analyse the pattern, allocate, load the data.
    ///
    /// # Errors
    /// A setting outside its range, or a pattern too large.
    pub fn new(problem: &Problem, settings: &Settings) -> Result<Self, Error> {
        Self::shared(&Arc::new(problem.clone()), settings)
    }

    /// As [`Engine::new`], without a copy of the data.
    ///
    /// # Errors
    /// As [`Engine::new`].
    pub fn shared(problem: &Arc<Problem>, settings: &Settings) -> Result<Self, Error> {
        Self::with_structure(problem, settings, structure_of(problem, settings.ordering)?)
    }

    /// As [`Engine::new`], with the factor that tapes record: no stored zeros, so that its buffers
    /// are laid out as the tapes' are, and every entry, the sign of a zero included, is theirs.
    ///
    /// # Errors
    /// As [`Engine::new`].
    pub fn exact(problem: &Problem, settings: &Settings) -> Result<Self, Error> {
        Self::with_panels(problem, settings, Panels::Exact)
    }

    pub(crate) fn with_panels(problem: &Problem, settings: &Settings, panels: Panels) -> Result<Self, Error> {
        let structure = Arc::new(Structure::new(problem, settings.ordering, panels)?);
        Self::with_structure(&Arc::new(problem.clone()), settings, structure)
    }

    fn with_structure(
        problem: &Arc<Problem>,
        settings: &Settings,
        structure: Arc<Structure>,
    ) -> Result<Self, Error> {
        let path = Datapath::new(structure, settings)?;
        let mut engine = Self {
            events: Vec::with_capacity(most_events(settings)),
            path,
            problem: Arc::clone(problem),
            control: Control::new(settings),
            earlier: None,
            long: LONG,
        };
        engine.path.load(&[Some(&**problem)]);
        Ok(engine)
    }

    /// Take other numbers in the same pattern; the next solve is that of a fresh engine.
    ///
    /// # Errors
    /// [`Error::PatternChanged`] naming the matrix, or cones or absent rows that differ.
    pub fn update(&mut self, problem: &Problem) -> Result<(), Error> {
        self.problem.same_pattern(problem)?;
        Arc::make_mut(&mut self.problem).clone_from(problem);
        self.path.load(&[Some(problem)]);
        self.reset();
        Ok(())
    }

    pub(crate) fn reset(&mut self) {
        self.control = Control::new(&self.path.settings);
        self.earlier = None;
        self.events.clear();
        self.path.reset(0);
    }

    /// The data that the next solve solves.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// The entries of a buffer as they stand.
    pub fn buffer(&self, buffer: Buffer) -> &[T] {
        self.path.work.get(buffer)
    }

    /// The entries of a buffer, for a caller that computes a stage elsewhere.
    pub fn buffer_mut(&mut self, buffer: Buffer) -> &mut [T] {
        self.path.forget_matrices();
        self.path.work.get_mut(buffer)
    }

    /// What ran since the engine was made, updated or solved anew.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// Steps taken so far.
    pub fn iteration(&self) -> u32 {
        self.control.total_iterations()
    }

    /// Entries of the KKT matrix's upper triangle, and of L below the diagonal.
    pub fn kkt_sizes(&self) -> (usize, usize) {
        (self.path.structure.kkt.nnz(), self.path.structure.kkt.symbolic.nnz_l)
    }

    /// Multiply–subtracts of one factorisation, from the column counts of L.
    pub fn factorization_multiply_subtracts(&self) -> usize {
        self.path.structure.kkt.symbolic.multiply_subtracts
    }

    /// Run one stage, with every entry that it declares, and say how to go on.
    ///
    /// A whole solve skips residuals of linear solves that no decision needs, and equilibrates matrices that have not changed
    /// since the one before no more; its numbers are the same otherwise.
    pub fn run(&mut self, stage: Stage) -> Outcome {
        self.run_with(stage, |path, _| T::execute(path, stage))
    }

    /// As [`Engine::run`], with `execute` for the arithmetic; it is told whether a decision needs the residual of a
    /// linear solve.
    pub(crate) fn run_with(&mut self, stage: Stage, execute: impl FnOnce(&mut Datapath<T>, bool)) -> Outcome {
        self.events.push(Event { stage, iteration: self.control.total_iterations() });
        let needs_residual = Control::needs_residual(0, stage, &self.path.work);
        execute(&mut self.path, needs_residual);
        self.control.decide(0, stage, &mut self.path.work)
    }

    /// Run the lists from start to end, with restarts.
    pub fn solve(&mut self) -> Solution {
        self.solve_observed(|_| ControlFlow::Continue(()))
    }

    /// As [`Engine::solve`], showing each iteration to `observe`, which may end the solve.
    pub fn solve_observed(&mut self, mut observe: impl FnMut(&Progress) -> ControlFlow<()>) -> Solution {
        self.solve_watched(&mut observe)
    }

    /// The same, for an observer that is asked within long factorizations, too.
    pub fn solve_watched(&mut self, observer: &mut impl Observer) -> Solution {
        self.reset();
        self.solve_with_restarts(STARTUP, observer)
    }

    /// As [`Engine::solve`], from a point nearby. Never a worse status than from cold: a start that
    /// does not pay, or does not end with a solution or a certificate, is followed by a cold one, and
    /// [`Solution::warm_start`] says so.
    ///
    /// # Errors
    /// [`Error::Dimension`] naming the vector whose length does not fit.
    pub fn solve_from(&mut self, start: &Start) -> Result<Solution, Error> {
        self.solve_from_observed(start, |_| ControlFlow::Continue(()))
    }

    /// As [`Engine::solve_from`], showing each iteration to `observe`, which may end the solve.
    ///
    /// # Errors
    /// As [`Engine::solve_from`].
    pub fn solve_from_observed(
        &mut self,
        start: &Start,
        mut observe: impl FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<Solution, Error> {
        self.solve_from_watched(start, &mut observe)
    }

    /// The same, for an observer that is asked within long factorizations, too.
    ///
    /// # Errors
    /// As [`Engine::solve_from`].
    pub fn solve_from_watched(
        &mut self,
        start: &Start,
        observer: &mut impl Observer,
    ) -> Result<Solution, Error> {
        let startup = if self.start_from(start)? { WARM_STARTUP } else { STARTUP };
        Ok(self.solve_with_restarts(startup, observer))
    }

    /// Forget the last solve and load a point to start from. A caller that runs the lists goes on with
    /// [`WARM_STARTUP`] if the answer is true, with [`STARTUP`] if it is false: the point is not finite
    /// (a certificate, say) or the problem has no rows, and the solve counts as fallen back.
    ///
    /// # Errors
    /// [`Error::Dimension`] naming the vector whose length does not fit.
    pub fn start_from(&mut self, start: &Start) -> Result<bool, Error> {
        start.fit(self.problem())?;
        self.reset();
        let useful = self.path.load_start(0, start);
        self.control.start_warm(useful);
        self.path.prepare(0, self.control.attempt);
        Ok(useful)
    }

    /// Attempt from a start-up list, then restart for as long as a restart follows.
    pub(crate) fn solve_with_restarts(&mut self, startup: &[Step], observer: &mut impl Observer) -> Solution {
        self.attempt(startup, observer);
        let mut solution = self.conclude();
        while self.restart(&solution) {
            self.attempt(STARTUP, observer);
            solution = self.conclude();
        }
        solution
    }

    /// One attempt: a start-up list, iterations, the closing list.
    fn attempt(&mut self, startup: &[Step], observer: &mut impl Observer) {
        let mut ended = self.follow(startup, observer);
        while !ended {
            ended = self.follow(ITERATION, observer);
            if !ended && observer.iterated(&self.progress()).is_break() {
                self.interrupt();
            }
        }
        self.follow(CLOSING, observer);
    }

    /// Perform the steps of a list, up to one that asks to leave the iteration; whether one did.
    fn follow(&mut self, steps: &[Step], observer: &mut impl Observer) -> bool {
        let long = self.factorization_multiply_subtracts() >= self.long;
        let mut run = |stage| {
            if long && stage == Stage::Factorize {
                return self.factorize_watched(observer);
            }
            self.run_with(stage, |path, needs_residual| T::execute_as_needed(path, stage, needs_residual))
        };
        steps.iter().any(|step| matches!(step.perform(&mut run), Outcome::Done(_)))
    }

    /// A long factorization, which ends early at the deadline, or where the observer asks for it.
    fn factorize_watched(&mut self, observer: &mut impl Observer) -> Outcome {
        let (mut control, mut reason) = (self.control.clone(), stop::NONE);
        self.run_with(Stage::Factorize, |path, _| {
            T::factorize_watched(path, &mut || {
                control.interrupted |= observer.waited().is_break();
                reason = control.or_from_outside(stop::NONE);
                reason != stop::NONE
            });
        });
        self.control.end(0, reason, &mut self.path.work)
    }

    /// Stop at the next statistics, with the best iterate.
    pub fn interrupt(&mut self) {
        self.control.interrupted = true;
    }

    /// Take over the outcome of an attempt that ran elsewhere from the words that it left in this engine's buffers: the
    /// control words, the verdict on a warm start, and what the closing stages write.
    pub fn take_over(&mut self) {
        self.control.ended(0, &self.path.work);
    }

    /// The last statistics in the user's units.
    pub fn progress(&self) -> Progress {
        let entry = |k: usize| self.path.work.statistics[k].value();
        Progress {
            iteration: self.control.total_iterations(),
            objective: entry(stat::OBJECTIVE),
            dual_objective: entry(stat::DUAL_OBJECTIVE),
            primal_residual: entry(stat::PRIMAL),
            dual_residual: entry(stat::DUAL),
            gap: entry(stat::GAP),
            mu: entry(stat::MU),
            step: self.control.step,
            refinements: self.control.refinements,
        }
    }

    /// The outcome of the attempt that ended, with the status that its numbers support; an earlier attempt's of the same
    /// solve, where that is the better one.
    pub fn conclude(&self) -> Solution {
        let solution = self.path.finished(0, &self.problem, &self.control).verify();
        better_of(self.earlier.as_ref(), solution, self.path.settings.tol_inaccurate)
    }

    /// The restart that is to follow the attempt that ended with `solution`, by [`RESTARTS`](crate::RESTARTS) and
    /// `max_restarts`.
    pub fn next_restart(&self, solution: &Solution) -> Option<&'static Restart> {
        self.control.next_restart(solution.status, &self.path.settings)
    }

    /// Get ready for that restart, from [`STARTUP`] on, where there is one, and say so; its parameters are other ones.
    pub fn restart(&mut self, solution: &Solution) -> bool {
        let Some(&Restart { attempt, .. }) = self.next_restart(solution) else {
            return false;
        };
        if attempt != Attempt::Cold {
            self.earlier = Some(solution.clone());
        }
        self.path.reset(0);
        self.path.prepare(0, attempt);
        self.control = self.control.restarted(attempt);
        true
    }
}

/// More stage runs than any solve with these settings makes.
fn most_events(settings: &Settings) -> usize {
    let per_repeat = 2 * settings.refinement_max as usize + 1;
    let runs = |steps: &[Step]| {
        steps.iter().map(|s| if matches!(s, Step::Run(_)) { 1 } else { per_repeat }).sum::<usize>()
    };
    let once =
        |startup| runs(startup) + (settings.max_iterations as usize + 1) * runs(ITERATION) + runs(CLOSING);
    once(WARM_STARTUP) + settings.max_restarts.min(LONGEST) as usize * once(STARTUP)
}

/// How much there is to factor in a problem's KKT matrix, in the order that the settings ask for.
///
/// # Errors
/// A pattern too large.
pub fn factor_shape(problem: &Problem, settings: &Settings) -> Result<FactorShape, Error> {
    Ok(Structure::new(problem, settings.ordering, Panels::Exact)?.kkt.factor_shape())
}

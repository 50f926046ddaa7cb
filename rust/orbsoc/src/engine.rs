//! One solve's state, and the only door to the kernels: [`Engine::run`].

use crate::control::Control;
use crate::error::Error;
use crate::execute::{execute, parameter};
use crate::problem::Problem;
use crate::ps::{self, stat};
use crate::real::{count, Counted, Decide, Latency, Real, Tally};
use crate::settings::Settings;
use crate::solution::Solution;
use crate::stage::{Outcome, Stage, Step, Stop, CLOSING, ITERATION, STARTUP};
use crate::structure::Structure;
use crate::symbolic::Panels;
use crate::trace::Event;
use crate::workspace::{Buffer, Workspace};
use core::ops::ControlFlow;

/// A problem's pattern, its buffers in arithmetic `T`, and where the solve stands.
///
/// Everything is allocated by [`Engine::new`]; from the first `run` to the last, nothing is.
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
    pub(crate) structure: Structure,
    pub(crate) settings: Settings,
    pub(crate) problem: Problem,
    pub(crate) work: Workspace<T>,
    pub(crate) control: Control,
    pub(crate) stop: Option<Stop>,
    events: Vec<Event>,
    simd: pulp::Arch,
}

/// Where a solve stands, for whoever watches it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs)]
pub struct Progress {
    pub iteration: u32,
    pub objective: f64,
    pub dual_objective: f64,
    pub primal_residual: f64,
    pub dual_residual: f64,
    pub gap: f64,
    pub mu: f64,
    /// Length of the step that led here; 0 before the first.
    pub step: f64,
    pub refinements: u32,
}

impl<T: Real> Engine<T> {
    /// Analyse the pattern, allocate, load the data.
    ///
    /// # Errors
    /// A setting outside its range, or a pattern too large.
    pub fn new(problem: &Problem, settings: &Settings) -> Result<Self, Error> {
        Self::with_panels(problem, settings, Panels::Relaxed)
    }

    fn with_panels(problem: &Problem, settings: &Settings, panels: Panels) -> Result<Self, Error> {
        settings.validate()?;
        let structure = Structure::new(problem, panels)?;
        let work = Workspace::new(&structure, T::zero());
        let mut engine = Self {
            events: Vec::with_capacity(most_events(settings)),
            structure,
            settings: settings.clone(),
            problem: problem.clone(),
            work,
            control: Control::new(settings),
            stop: None,
            simd: pulp::Arch::new(),
        };
        engine.load();
        Ok(engine)
    }

    /// Take other numbers in the same pattern; the next solve is that of a fresh engine.
    ///
    /// # Errors
    /// [`Error::PatternChanged`] naming the matrix, or cones or absent rows that differ.
    pub fn update(&mut self, problem: &Problem) -> Result<(), Error> {
        let changed = |argument| Err(Error::PatternChanged { argument });
        let old = &self.problem;
        if !old.p.same_pattern(&problem.p) {
            return changed("P");
        } else if !old.a.same_pattern(&problem.a) {
            return changed("A");
        } else if !old.g.same_pattern(&problem.g) {
            return changed("G");
        } else if old.cones != problem.cones {
            return changed("cones");
        }
        let absent = |p: &Problem| p.h.iter().map(|h| h.is_finite()).collect::<Vec<_>>();
        if absent(old) != absent(problem) {
            return changed("h");
        }
        self.problem = problem.clone();
        self.load();
        Ok(())
    }

    /// Words of the problem and the settings into their buffers; forget the last solve.
    fn load(&mut self) {
        let (problem, work, n) = (&self.problem, &mut self.work, self.structure.n);
        let reduced = &self.structure.reduced;
        let fill = |to: &mut [T], from: &mut dyn Iterator<Item = f64>| {
            to.iter_mut().zip(from).for_each(|(word, value)| *word = T::constant(value));
        };
        fill(&mut work.raw_p, &mut problem.p.values().iter().copied());
        fill(&mut work.raw_a, &mut problem.a.values().iter().copied());
        fill(&mut work.raw_g, &mut reduced.g_origin.iter().map(|&k| problem.g.values()[k]));
        let h = || reduced.row_origin.iter().map(|&i| problem.h[i]);
        let (c, bh) = work.raw_q.split_at_mut(n);
        fill(c, &mut problem.c.iter().copied());
        fill(bh, &mut problem.b.iter().copied().chain(h()));
        let largest =
            |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |top: f64, v| top.max(v.abs()));
        work.norms[0] = T::constant(largest(&mut problem.b.iter().copied()));
        work.norms[1] = T::constant(largest(&mut h()));
        work.norms[2] = T::constant(largest(&mut problem.c.iter().copied()));
        work.parameters[parameter::STATIC_REGULARIZATION] = T::constant(self.settings.static_regularization);
        work.parameters[parameter::PIVOT_FLOOR] = T::constant(self.settings.pivot_floor);
        work.parameters[parameter::DYNAMIC_REGULARIZATION] =
            T::constant(self.settings.dynamic_regularization);
        work.parameters[parameter::REFINEMENT_TOL] = T::constant(self.settings.refinement_tol);
        work.parameters[parameter::REFINEMENT_SHARE] = T::constant(self.settings.refinement_share);
        work.parameters[parameter::RESIDUAL_FLOOR] = T::constant(0.01 * self.settings.tol);
        work.parameters[parameter::STEP_FRACTION] = T::constant(self.settings.step_fraction);
        self.reset();
    }

    fn reset(&mut self) {
        self.control = Control::new(&self.settings);
        self.stop = None;
        self.events.clear();
        // A word that a previous solve left behind must never be taken for one of this solve.
        for buffer in [Buffer::Best, Buffer::Farkas, Buffer::Ray, Buffer::RefinementGoal] {
            self.work.get_mut(buffer).fill(T::zero());
        }
    }

    /// Run a stage's arithmetic without deciding anything.
    pub(crate) fn execute(&mut self, stage: Stage) {
        let Self { structure, settings, work, .. } = self;
        self.simd.dispatch(StageRun { structure, settings, work, stage });
    }

    /// The words of a buffer as they stand.
    pub fn buffer(&self, buffer: Buffer) -> &[T] {
        self.work.get(buffer)
    }

    /// What ran since the engine was made, updated or solved anew.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// Steps taken so far.
    pub fn iteration(&self) -> u32 {
        self.control.iteration
    }

    /// Entries of the KKT matrix's upper triangle, and of L below the diagonal.
    pub fn kkt_sizes(&self) -> (usize, usize) {
        (self.structure.kkt.nnz(), self.structure.kkt.symbolic.nnz_l)
    }

    /// Multiply–subtracts of one factorisation, from the column counts of L.
    pub fn factorization_multiply_subtracts(&self) -> usize {
        self.structure.kkt.symbolic.multiply_subtracts
    }
}

impl<T: Decide> Engine<T> {
    /// Run one stage and say how to go on.
    pub fn run(&mut self, stage: Stage) -> Outcome {
        self.events.push(Event { stage, iteration: self.control.iteration });
        self.execute(stage);
        let outcome = match stage {
            Stage::Statistics => self.control.judge(&self.settings, &mut self.work),
            Stage::CheckSolve => self.control.judge_refinement(&self.settings, &self.work),
            Stage::Advance => {
                let taken = self.step_taken();
                self.control.note_step(taken);
                Outcome::Next
            }
            _ => Outcome::Next,
        };
        if let Outcome::Done(stop) = outcome {
            self.stop = Some(stop);
        }
        outcome
    }

    /// Walk the lists from start to end.
    pub fn solve(&mut self) -> Solution {
        self.solve_observed(|_| ControlFlow::Continue(()))
    }

    /// As [`Engine::solve`], showing each iteration to `observe`, which may end the solve.
    pub fn solve_observed(&mut self, mut observe: impl FnMut(&Progress) -> ControlFlow<()>) -> Solution {
        self.reset();
        for step in STARTUP {
            self.perform(*step);
        }
        'iterate: loop {
            for step in ITERATION {
                if let Outcome::Done(_) = self.perform(*step) {
                    break 'iterate;
                }
            }
            if observe(&self.progress()).is_break() {
                self.interrupt();
            }
        }
        for step in CLOSING {
            self.perform(*step);
        }
        self.conclude()
    }

    fn perform(&mut self, step: Step) -> Outcome {
        match step {
            Step::Run(stage) => self.run(stage),
            Step::Repeat { stage, until } => loop {
                match self.run(until) {
                    Outcome::Repeat => self.run(stage),
                    other => return other,
                };
            },
        }
    }

    /// Stop at the next statistics, with the best iterate.
    pub fn interrupt(&mut self) {
        self.control.interrupted = true;
    }

    /// The last statistics in the user's units.
    pub fn progress(&self) -> Progress {
        let word = |k: usize| self.work.statistics[k].value();
        Progress {
            iteration: self.control.iteration,
            objective: word(stat::OBJECTIVE),
            dual_objective: word(stat::DUAL_OBJECTIVE),
            primal_residual: word(stat::PRIMAL),
            dual_residual: word(stat::DUAL),
            gap: word(stat::GAP),
            mu: word(stat::MU),
            step: if self.control.iteration == 0 { 0.0 } else { self.step_taken() },
            refinements: self.control.refinements,
        }
    }

    fn step_taken(&self) -> f64 {
        ps::step_taken(self.work.step_length[0], self.work.parameters[parameter::STEP_FRACTION]).value()
    }
}

/// A stage's arithmetic, to be compiled once for each instruction set and chosen at run time.
struct StageRun<'a, T> {
    structure: &'a Structure,
    settings: &'a Settings,
    work: &'a mut Workspace<T>,
    stage: Stage,
}

impl<T: Real> pulp::WithSimd for StageRun<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        execute(self.structure, self.settings, self.work, self.stage);
    }
}

/// More stage runs than any solve with these settings makes.
fn most_events(settings: &Settings) -> usize {
    let per_repeat = 2 * settings.refinement_max as usize + 1;
    let runs = |steps: &[Step]| {
        steps.iter().map(|s| if matches!(s, Step::Run(_)) { 1 } else { per_repeat }).sum::<usize>()
    };
    runs(STARTUP) + (settings.max_iterations as usize + 1) * runs(ITERATION) + runs(CLOSING)
}

/// Operations of each stage on a problem's pattern, and their longest dependent chain.
///
/// # Errors
/// As [`Engine::new`].
pub fn operation_counts(
    problem: &Problem,
    settings: &Settings,
    latency: Latency,
) -> Result<Vec<(Stage, Tally)>, Error> {
    let mut engine = Engine::<Counted>::with_panels(problem, settings, Panels::Exact)?;
    let inputs_ready = Workspace::new(&engine.structure, Counted::zero());
    let mut tally = |stage| {
        engine.work.clone_from(&inputs_ready);
        (stage, count(latency, || engine.execute(stage)))
    };
    Ok(Stage::ALL.iter().map(|&stage| tally(stage)).collect())
}

//! Snapshots of a solve: the words of every buffer before and after each stage.

use orbsoc::{Buffer, Compiled, Engine, Error, Outcome, Problem, Settings, Stage, Step};
use orbsoc::{Start, CLOSING, ITERATION, STARTUP, WARM_STARTUP};
use std::collections::HashMap;

/// The engine before a stage, and after it.
#[derive(Clone, Debug)]
#[allow(missing_docs)]
pub struct Snapshot<T> {
    pub before: Engine<T>,
    pub after: Engine<T>,
}

impl<T: Compiled> Snapshot<T> {
    fn of(before: &Engine<T>, stages: &[Stage]) -> Self {
        let mut after = before.clone();
        for &stage in stages {
            after.run(stage);
        }
        Self { before: before.clone(), after }
    }

    /// A buffer's words before the stage.
    pub fn before(&self, buffer: Buffer) -> &[T] {
        self.before.buffer(buffer)
    }

    /// A buffer's words after the stage.
    pub fn after(&self, buffer: Buffer) -> &[T] {
        self.after.buffer(buffer)
    }
}

/// The snapshots of a solve.
#[derive(Clone, Debug)]
pub struct Snapshots<T>(HashMap<Stage, Snapshot<T>>);

impl<T> Snapshots<T> {
    /// The snapshot of a stage; none if the solve ended before it.
    pub fn of(&self, stage: Stage) -> Option<&Snapshot<T>> {
        self.0.get(&stage)
    }
}

impl<T: Compiled> Snapshots<T> {
    /// The snapshot of stages that run as one stream, from the state before the last of them; none if the solve ended
    /// before it.
    pub fn joined(&self, stages: &[Stage]) -> Option<Snapshot<T>> {
        Some(Snapshot::of(&self.of(*stages.last()?)?.before, stages))
    }
}

/// Solve a problem with the arithmetic that tapes record, and keep a snapshot of the last run of every stage. A
/// refinement that the solve did not need is run from where it would have been. The stages of a warm start are run from
/// a point near the solution.
///
/// # Errors
/// As [`Engine::new`].
pub fn snapshots<T: Compiled>(problem: &Problem, settings: &Settings) -> Result<Snapshots<T>, Error> {
    let mut cold = Recorder { engine: Engine::<T>::exact(problem, settings)?, last: HashMap::new() };
    cold.steps(STARTUP);
    while cold.steps(ITERATION) {}
    cold.steps(CLOSING);
    let mut near = cold.engine.conclude();
    near.x.iter_mut().for_each(|x| *x += 0.01 * (1.0 + x.abs()));
    let mut warm = Recorder { engine: cold.engine, last: HashMap::new() };
    if warm.engine.start_from(&Start::from(&near))? {
        warm.steps(WARM_STARTUP);
    }
    let mut all = warm.last;
    all.extend(cold.last);
    let both = all.into_iter().map(|(stage, before)| (stage, Snapshot::of(&before, &[stage])));
    Ok(Snapshots(both.collect()))
}

/// A solve that keeps the engine before the last run of every stage.
struct Recorder<T> {
    engine: Engine<T>,
    last: HashMap<Stage, Engine<T>>,
}

impl<T: Compiled> Recorder<T> {
    /// Perform a list; false if a stage ended it.
    fn steps(&mut self, steps: &[Step]) -> bool {
        steps.iter().all(|step| !matches!(self.perform(*step), Outcome::Done(_)))
    }

    fn perform(&mut self, step: Step) -> Outcome {
        step.perform(&mut |next| {
            // A repeated stage may never run: it has a snapshot from before it is decided on.
            match step {
                Step::Repeat { stage, until } if next == until => {
                    self.last.insert(stage, self.engine.clone());
                }
                _ => {}
            }
            self.run(next)
        })
    }

    fn run(&mut self, stage: Stage) -> Outcome {
        self.last.insert(stage, self.engine.clone());
        self.engine.run(stage)
    }
}

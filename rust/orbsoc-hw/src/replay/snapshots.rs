//! Snapshots of a solve: the engine before each stage.

use orbsoc::{Compiled, Engine, Error, Outcome, Problem, Settings, Stage, Step};
use orbsoc::{Start, CLOSING, ITERATION, STARTUP, WARM_STARTUP};
use std::collections::HashMap;

/// The engines of a solve before the last run of every stage.
#[derive(Clone, Debug)]
pub struct Snapshots<T>(HashMap<Stage, Engine<T>>);

impl<T> Snapshots<T> {
    /// The engine from which stages run as one stream: that before the last of them; none if the solve ended before it.
    pub fn before(&self, stages: &[Stage]) -> Option<&Engine<T>> {
        self.0.get(stages.last()?)
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
    Ok(Snapshots(all))
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

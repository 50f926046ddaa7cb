//! Time of a solve by stage: a clock around every stage of the method.

use crate::spread::{microseconds, Spread};
use orbsoc::{Engine, Outcome, Stage, Step, CLOSING, ITERATION};
use std::time::Instant;

/// Name of the last part: the status and its residuals, recomputed on the user's data.
pub const CONCLUDE: &str = "conclude";

/// One stage on one problem: runs in a solve, and their total microseconds.
#[derive(Clone, Debug)]
pub struct StageTimes {
    pub stage: &'static str,
    pub module: &'static str,
    pub calls: usize,
    pub time: Spread,
}

/// Times of repeated solves of one problem, by stage.
#[derive(Clone, Default)]
pub struct Clocks {
    solves: Vec<Vec<(f64, usize)>>,
}

impl Clocks {
    /// Time one attempt that begins with these steps, as `Engine::solve` begins with `STARTUP`.
    pub fn time(&mut self, startup: &[Step], engine: &mut Engine<f64>) {
        let mut attempt = Attempt { engine, times: vec![(0.0, 0); Stage::ALL.len() + 1] };
        for step in startup {
            step.perform(&mut |stage| attempt.run(stage));
        }
        while !ITERATION
            .iter()
            .any(|step| matches!(step.perform(&mut |stage| attempt.run(stage)), Outcome::Done(_)))
        {}
        for step in CLOSING {
            step.perform(&mut |stage| attempt.run(stage));
        }
        let start = Instant::now();
        let solution = attempt.engine.conclude();
        attempt.times[Stage::ALL.len()] = (microseconds(start), 1);
        drop(solution);
        self.solves.push(attempt.times);
    }

    /// The stages that ran, in order of definition.
    pub fn summary(&self) -> Vec<StageTimes> {
        let names = Stage::ALL.iter().map(|s| (s.name(), s.module().name())).chain([(CONCLUDE, "ps")]);
        let Some(first) = self.solves.first() else { return Vec::new() };
        names
            .enumerate()
            .filter(|&(k, _)| first[k].1 > 0)
            .map(|(k, (stage, module))| StageTimes {
                stage,
                module,
                calls: first[k].1,
                time: Spread::of(&self.solves.iter().map(|solve| solve[k].0).collect::<Vec<_>>()),
            })
            .collect()
    }
}

/// A solve attempt; by stage, microseconds and runs.
struct Attempt<'a> {
    engine: &'a mut Engine<f64>,
    times: Vec<(f64, usize)>,
}

impl Attempt<'_> {
    fn run(&mut self, stage: Stage) -> Outcome {
        let start = Instant::now();
        let outcome = self.engine.run(stage);
        let (time, calls) = &mut self.times[stage as usize];
        *time += microseconds(start);
        *calls += 1;
        outcome
    }
}

//! Where a solve's microseconds go: a clock around every stage of the method's lists.

use crate::spread::{microseconds, Spread};
use orbsoc::{Engine, Outcome, Stage, Step, CLOSING, ITERATION, STARTUP};
use std::time::Instant;

/// Name of what follows the lists: the status and its evidence, recomputed on the user's data.
pub const CONCLUDE: &str = "conclude";

/// One stage on one problem: runs in a solve, and microseconds of all of them together.
#[derive(Clone, Debug)]
pub struct StageTimes {
    pub stage: &'static str,
    pub module: &'static str,
    pub calls: usize,
    pub time: Spread,
}

/// Times of repeated solves of one problem, stage by stage.
#[derive(Clone, Default)]
pub struct Clocks {
    solves: Vec<Vec<(f64, usize)>>,
}

impl Clocks {
    /// Solve once, walking the lists as `Engine::solve` does.
    pub fn time(&mut self, engine: Engine<f64>) {
        let mut walk = Walk { engine, times: vec![(0.0, 0); Stage::ALL.len() + 1] };
        for step in STARTUP {
            walk.perform(*step);
        }
        while !ITERATION.iter().any(|step| matches!(walk.perform(*step), Outcome::Done(_))) {}
        for step in CLOSING {
            walk.perform(*step);
        }
        let start = Instant::now();
        let solution = walk.engine.conclude();
        walk.times[Stage::ALL.len()] = (microseconds(start), 1);
        drop(solution);
        self.solves.push(walk.times);
    }

    /// The stages that ran, in the order of their definition.
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

struct Walk {
    engine: Engine<f64>,
    times: Vec<(f64, usize)>,
}

impl Walk {
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

    fn run(&mut self, stage: Stage) -> Outcome {
        let start = Instant::now();
        let outcome = self.engine.run(stage);
        let (time, calls) = &mut self.times[stage as usize];
        *time += microseconds(start);
        *calls += 1;
        outcome
    }
}

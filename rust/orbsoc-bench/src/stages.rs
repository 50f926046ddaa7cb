//! Where a solve's microseconds go: a clock around every stage of the method's lists.

use crate::measure::{microseconds, Measured, Spread};
use orbsoc::{Engine, Outcome, Stage, CLOSING, ITERATION, STARTUP};
use std::fmt::Write;
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
            step.perform(&mut |stage| walk.run(stage));
        }
        while !ITERATION
            .iter()
            .any(|step| matches!(step.perform(&mut |stage| walk.run(stage)), Outcome::Done(_)))
        {}
        for step in CLOSING {
            step.perform(&mut |stage| walk.run(stage));
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
    fn run(&mut self, stage: Stage) -> Outcome {
        let start = Instant::now();
        let outcome = self.engine.run(stage);
        let (time, calls) = &mut self.times[stage as usize];
        *time += microseconds(start);
        *calls += 1;
        outcome
    }
}

/// All problems together, the most expensive stage first: means over the problems of each one's medians.
pub fn table(measured: &[Measured]) -> String {
    let mut rows: Vec<(&str, &str, f64, f64)> = Vec::new();
    let problems = measured.len() as f64;
    for times in measured.iter().flat_map(|m| &m.stages) {
        let (calls, time) = (times.calls as f64 / problems, times.time.median / problems);
        match rows.iter_mut().find(|row| row.0 == times.stage) {
            Some(row) => {
                row.2 += calls;
                row.3 += time;
            }
            None => rows.push((times.stage, times.module, calls, time)),
        }
    }
    rows.sort_by(|a, b| b.3.total_cmp(&a.3));
    let total: f64 = rows.iter().map(|row| row.3).sum();
    let mut out = format!(
        "{:<18} {:<14} {:>10} {:>12} {:>10} {:>7}\n",
        "stage", "module", "runs/solve", "us/solve", "us/run", "share"
    );
    for (stage, module, calls, time) in rows {
        let share = 100.0 * time / total;
        let _ = writeln!(
            out,
            "{stage:<18} {module:<14} {calls:>10.1} {time:>12.2} {:>10.3} {share:>6.1}%",
            time / calls
        );
    }
    let _ = writeln!(out, "{:<18} {:<14} {:>10} {total:>12.2}", "sum", "", "");
    out
}

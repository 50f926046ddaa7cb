//! Warm starts: new numbers and a solve, from cold and from the solution before the change.

use crate::arguments::Plan;
use crate::failure::Failure;
use crate::spread::{microseconds, Spread};
use crate::stages::{Clocks, StageTimes};
use crate::variants::vary;
use orbsoc::{Engine, Problem, Settings, Solution, Start, STARTUP, WARM_STARTUP};
use std::fmt::Write;
use std::time::Instant;

/// How far each number of c, b and h moves, at most.
const CHANGE: f64 = 0.01;

/// Time of new numbers and a solve.
pub struct Solved {
    pub time: Spread,
    pub solution: Solution,
    /// Empty unless stages were requested.
    pub stages: Vec<StageTimes>,
}

/// The measurements on one problem.
pub struct Measured {
    pub problem: String,
    pub cold: Solved,
    pub warm: Solved,
    /// The cold one's time over the warm one's, in turn.
    pub speedup: Spread,
}

/// Time all problems `plan.repeats` times, each in its own variant.
pub fn measure(problems: &[(String, Problem)], plan: &Plan) -> Result<Vec<Measured>, Failure> {
    let settings = Settings { tol: plan.tol, ..Settings::default() };
    let one = |(k, (name, problem)): (usize, &(String, Problem))| {
        measure_one(name, problem, k as u64, plan, &settings).map_err(|e| format!("{name}: {e}"))
    };
    problems.iter().enumerate().map(one).collect()
}

fn measure_one(
    name: &str,
    problem: &Problem,
    seed: u64,
    plan: &Plan,
    settings: &Settings,
) -> Result<Measured, orbsoc::Error> {
    let mut changed = problem.clone();
    vary(&mut changed, CHANGE, seed)?;
    let mut engine = Engine::<f64>::new(problem, settings)?;
    let before = engine.solve();
    let start = Start::from(&before);
    let (mut colds, mut warms, mut speedups) = (Vec::new(), Vec::new(), Vec::new());
    let mut clocks = [Clocks::default(), Clocks::default()];
    let mut solutions = None;
    for _ in 0..plan.repeats {
        let clock = Instant::now();
        engine.update(&changed)?;
        let cold = engine.solve();
        colds.push(microseconds(clock));
        let clock = Instant::now();
        engine.update(&changed)?;
        let warm = engine.solve_from(&start)?;
        warms.push(microseconds(clock));
        speedups.push(colds[colds.len() - 1] / warms[warms.len() - 1]);
        solutions = Some((cold, warm));
        if plan.stages {
            engine.update(&changed)?;
            clocks[0].time(STARTUP, &mut engine);
            if engine.start_from(&start)? {
                clocks[1].time(WARM_STARTUP, &mut engine);
            }
        }
    }
    let (cold, warm) = solutions.unwrap_or_else(|| (before.clone(), before.clone()));
    let [cold_stages, warm_stages] = clocks.map(|clocks| clocks.summary());
    Ok(Measured {
        problem: name.to_string(),
        cold: Solved { time: Spread::of(&colds), solution: cold, stages: cold_stages },
        warm: Solved { time: Spread::of(&warms), solution: warm, stages: warm_stages },
        speedup: Spread::of(&speedups),
    })
}

/// A line a problem, and the median of all.
pub fn table(measured: &[Measured]) -> String {
    let mut out = format!(
        "{:<44} {:>10} {:>11} {:>10} {:>10} {:>9} {:>9} {:>8}\n",
        "problem", "cold iter", "(refine)", "warm iter", "(refine)", "cold us", "warm us", "speedup"
    );
    for m in measured {
        let (cold, warm) = (&m.cold.solution, &m.warm.solution);
        let _ = writeln!(
            out,
            "{:<44} {:>10} {:>11} {:>10} {:>10} {:>9.1} {:>9.1} {:>8.2}",
            m.problem,
            cold.iterations,
            format!("({})", cold.refinements),
            format!("{}{}", warm.iterations, if warm.warm_start.name() == "used" { "" } else { "!" }),
            format!("({})", warm.refinements),
            m.cold.time.median,
            m.warm.time.median,
            m.speedup.median
        );
    }
    let speedups: Vec<f64> = measured.iter().map(|m| m.speedup.median).collect();
    let least = speedups.iter().copied().fold(f64::INFINITY, f64::min);
    let _ = writeln!(
        out,
        "speedup: median {:.2}, least {least:.2}; ! fell back to cold",
        Spread::of(&speedups).median
    );
    out
}

//! Timing of solves: a fresh engine each time, problems interleaved, medians with quartiles.

use crate::arguments::Plan;
use crate::failure::Failure;
use crate::spread::{microseconds, Spread};
use crate::stages::{Clocks, StageTimes};
use crate::variants::vary;
use orbsoc::{BatchSolver, Problem, Settings, Solution, STARTUP};
use std::time::Instant;

/// The measurements on one problem.
pub struct Measured {
    pub problem: String,
    pub setup: Spread,
    pub solve: Spread,
    pub solution: Solution,
    /// Time per problem of a batch, if one was requested.
    pub batch: Option<Spread>,
    /// Empty unless stages were requested.
    pub stages: Vec<StageTimes>,
}

/// Time all problems `plan.repeats` times; stages are timed in separate solves.
pub fn measure(problems: &[(String, Problem)], plan: &Plan) -> Result<Vec<Measured>, Failure> {
    let settings = Settings { tol: plan.tol, ..Settings::default() };
    let mut setups = vec![Vec::with_capacity(plan.repeats); problems.len()];
    let mut solves = setups.clone();
    let mut solutions = Vec::new();
    let mut batches = setups.clone();
    let mut lanes = Vec::new();
    for (name, problem) in problems.iter().filter(|_| plan.batch > 0) {
        lanes.push(BatchSolver::new(problem, &settings, 1).map_err(|e| format!("{name}: {e}"))?);
    }
    let mut other = vec![0u64; if plan.cold { CACHE_WORDS } else { 0 }];
    let mut clocks = vec![Clocks::default(); problems.len()];
    for repeat in 0..plan.repeats {
        for (k, (name, problem)) in problems.iter().enumerate() {
            let refuse = |e: orbsoc::Error| format!("{name}: {e}");
            if plan.cold {
                evict(&mut other);
            }
            let start = Instant::now();
            let mut engine = plan.set_up(problem, &settings).map_err(refuse)?;
            setups[k].push(microseconds(start));
            let start = Instant::now();
            let solution = engine.solve();
            solves[k].push(microseconds(start));
            if repeat == 0 {
                solutions.push(solution);
            }
            if let Some(solver) = lanes.get_mut(k) {
                let start = Instant::now();
                solve_variants(solver, plan.batch).map_err(refuse)?;
                batches[k].push(microseconds(start) / plan.batch as f64);
            }
            if plan.stages {
                clocks[k].time(STARTUP, &mut plan.set_up(problem, &settings).map_err(refuse)?);
            }
        }
    }
    let mut measured = Vec::new();
    for (k, solution) in solutions.into_iter().enumerate() {
        measured.push(Measured {
            problem: problems[k].0.clone(),
            setup: Spread::of(&setups[k]),
            solve: Spread::of(&solves[k]),
            solution,
            batch: (plan.batch > 0).then(|| Spread::of(&batches[k])),
            stages: clocks[k].summary(),
        });
    }
    Ok(measured)
}

/// 64-bit words that fill a core's caches: 16 MiB.
const CACHE_WORDS: usize = 2 << 20;

/// Evict everything else from the caches.
fn evict(other: &mut [u64]) {
    for (k, word) in other.iter_mut().enumerate() {
        *word = word.wrapping_add(k as u64);
    }
    std::hint::black_box(other);
}

/// Solve variants of a problem: each number of c, b and h differs by up to a thousandth.
fn solve_variants(solver: &mut BatchSolver, count: usize) -> Result<Vec<Solution>, orbsoc::Error> {
    solver.solve(count, |k, problem| vary(problem, 1e-3, k as u64))
}

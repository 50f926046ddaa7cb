//! The command line.

use crate::failure::Failure;
use orbsoc::{Engine, Error, Problem, Settings};
use std::path::PathBuf;

pub const HELP: &str = "\
orbsoc-bench FOLDER|FILE … [--repeats N] [--tol T] [--stages] [--exact] [--label TEXT] [--out FILE.csv]
    Times every problem file (orbsoc.problem/1): a fresh engine each time, problems interleaved, medians.
    --repeats N    times that each problem is solved (30)
    --tol T        tolerance (1e-8)
    --stages       time every stage, too
    --cold         before each set-up, touch more memory than a core's caches hold: a solve now and then, not in a loop
    --exact        by the exact engine, whose order of operations the library in C and the PL have
    --batch N      solve N variants of each problem in SIMD lanes on one thread, too; time per problem
    --label TEXT   what is measured, for the header of the file
    --out FILE     write the results as CSV
orbsoc-bench --warm FOLDER|FILE … [--repeats N] [--tol T] [--stages]
    New numbers and a solve, c, b and h changed by up to 1 %: from cold, and from the solution before the change.
    --stages       time every stage of both, too
orbsoc-bench --schedule FOLDER|FILE … [--repeats N]
    Millions of operations a second that the PL's schedulers take in, on engines of 1, 2, 4 and 8 lanes,
    and a fingerprint of the microcode.
orbsoc-bench --marks FOLDER|FILE … [--tol T] [--exact]
    Solves every problem once and marks its stages for an emulator that counts instructions; prints a hash of the answers.
orbsoc-bench --compare BEFORE.csv AFTER.csv
    Ratio after/before for each problem, and for each stage when both files have stages.
";

pub enum Command {
    Help,
    Compare { before: PathBuf, after: PathBuf },
    Measure(Plan),
    Schedule(Plan),
    Warm(Plan),
    Marks(Plan),
}

/// What to measure and where to write it.
pub struct Plan {
    pub paths: Vec<PathBuf>,
    pub repeats: usize,
    pub tol: f64,
    pub stages: bool,
    /// Set-ups begin with cold caches.
    pub cold: bool,
    /// The exact engine instead of the default one.
    pub exact: bool,
    /// Variants of each problem that are solved in one batch; 0: none.
    pub batch: usize,
    pub label: String,
    pub out: Option<PathBuf>,
}

impl Plan {
    /// An engine of the kind that is measured.
    pub fn set_up(&self, problem: &Problem, settings: &Settings) -> Result<Engine<f64>, Error> {
        if self.exact {
            Engine::exact(problem, settings)
        } else {
            Engine::new(problem, settings)
        }
    }
}

impl Command {
    pub fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Self, Failure> {
        let mut plan = Plan {
            paths: Vec::new(),
            repeats: 30,
            tol: 1e-8,
            stages: false,
            cold: false,
            exact: false,
            batch: 0,
            label: String::new(),
            out: None,
        };
        let mut command: fn(Plan) -> Self = Self::Measure;
        while let Some(argument) = arguments.next() {
            let mut value = || arguments.next().ok_or(format!("{argument} needs a value; see --help"));
            match argument.as_str() {
                "--help" | "-h" => return Ok(Self::Help),
                "--compare" => {
                    let (before, after) = (value()?.into(), value()?.into());
                    return Ok(Self::Compare { before, after });
                }
                "--repeats" => plan.repeats = positive(&argument, &value()?)?,
                "--batch" => plan.batch = positive(&argument, &value()?)?,
                "--tol" => plan.tol = positive(&argument, &value()?)?,
                "--label" => plan.label = value()?,
                "--out" => plan.out = Some(value()?.into()),
                "--stages" => plan.stages = true,
                "--cold" => plan.cold = true,
                "--exact" => plan.exact = true,
                "--schedule" => command = Self::Schedule,
                "--warm" => command = Self::Warm,
                "--marks" => command = Self::Marks,
                _ if argument.starts_with('-') => {
                    return Err(format!("unknown option {argument}; see --help"))
                }
                _ => plan.paths.push(argument.into()),
            }
        }
        if plan.paths.is_empty() {
            return Err("no problems: give a folder or a file of orbsoc.problem/1; see --help".into());
        }
        Ok(command(plan))
    }
}

fn positive<N: std::str::FromStr + PartialOrd + Default>(option: &str, text: &str) -> Result<N, Failure> {
    text.parse()
        .ok()
        .filter(|number| *number > N::default())
        .ok_or(format!("{option} is {text:?}; it must be a positive number"))
}

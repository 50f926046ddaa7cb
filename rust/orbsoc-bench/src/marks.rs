//! Solves whose stages an emulator can tell apart: before and after each stage, a seek to a place that names it.
//!
//! Seeks need no `unsafe`, cost some dozens of instructions, and no other part of the program makes any of this kind; what
//! counts the instructions between them is python/orbsoc/flight/count_instructions.c.

use crate::arguments::Plan;
use crate::failure::Failure;
use orbsoc::{Outcome, Problem, Settings, Solution, Stage, CLOSING, ITERATION, STARTUP};
use std::fs::File;
use std::io::{Seek, SeekFrom};

/// The places are from here on: the number of a stage, or one of those below.
const MARK: u64 = 0x4f53_0000;
const STAGES: u64 = Stage::ALL.len() as u64;
/// After a stage.
const OUTSIDE: u64 = STAGES;
/// The closing residuals on the user's data, and the status.
const CONCLUDE: u64 = STAGES + 1;
/// Twice before a problem: the instructions between are those of a mark.
const PROBLEM: u64 = STAGES + 2;

/// Solve every problem once, in one attempt and with marks; a line for each with its iterations and a hash of its
/// answer's bits, after a line with the names of the marks.
pub fn solve(problems: &[(String, Problem)], settings: &Settings, plan: &Plan) -> Result<String, Failure> {
    let mut marks = Marks(File::open("/dev/null").map_err(|e| format!("/dev/null: {e}"))?);
    let names: Vec<&str> = Stage::ALL.iter().map(|stage| stage.name()).collect();
    let mut lines = vec![format!("{MARK} {} outside conclude problem\n", names.join(" "))];
    for (name, problem) in problems {
        marks.at(PROBLEM);
        marks.at(PROBLEM);
        let mut engine = plan.set_up(problem, settings).map_err(|e| format!("{name}: {e}"))?;
        let mut run = |stage: Stage| {
            marks.at(stage as u64);
            let outcome = engine.run(stage);
            marks.at(OUTSIDE);
            outcome
        };
        for step in STARTUP {
            step.perform(&mut run);
        }
        while !ITERATION.iter().any(|step| matches!(step.perform(&mut run), Outcome::Done(_))) {}
        for step in CLOSING {
            step.perform(&mut run);
        }
        marks.at(CONCLUDE);
        let solution = engine.conclude();
        marks.at(OUTSIDE);
        lines.push(format!(
            "{name} {} {:?} {:016x}\n",
            solution.iterations,
            solution.status,
            hash(&solution)
        ));
    }
    Ok(lines.concat())
}

struct Marks(File);

impl Marks {
    /// Seek to a mark's place; a device that does not seek is asked all the same.
    fn at(&mut self, mark: u64) {
        let _ = self.0.seek(SeekFrom::Start(MARK + mark));
    }
}

/// FNV-1a over the bits of x, y, z and s.
fn hash(solution: &Solution) -> u64 {
    let all = [&solution.x, &solution.y, &solution.z, &solution.s];
    let bits = all.into_iter().flatten().map(|value| value.to_bits());
    bits.fold(0xcbf2_9ce4_8422_2325, |sum, bits| (sum ^ bits).wrapping_mul(0x0100_0000_01b3))
}

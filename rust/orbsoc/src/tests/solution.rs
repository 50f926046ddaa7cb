//! Which of two attempts' outcomes counts.

use crate::outcome::solution::better_of;
use crate::{Certificate, Solution, Status, WarmStart};

const INACCURATE: f64 = 1e-5;

fn outcome(status: Status, residual: f64, iterations: u32) -> Solution {
    let certificate =
        Certificate { primal_residual: residual, dual_residual: 0.0, gap: 0.0, radius: f64::NAN };
    let numbers = vec![residual];
    Solution {
        status,
        x: numbers.clone(),
        y: numbers.clone(),
        z: numbers.clone(),
        s: numbers,
        objective: residual,
        dual_objective: residual,
        iterations,
        warm_start: WarmStart::None,
        refinements: iterations,
        attempts: iterations / 10,
        certificate,
        message: format!("residual {residual:.0e}"),
    }
}

/// The status, which attempt's numbers, and the message of the second attempt after the first.
fn after(first: (Status, f64), second: (Status, f64)) -> (Status, f64, String) {
    let first = outcome(first.0, first.1, 10);
    let found = better_of(Some(&first), outcome(second.0, second.1, 30), INACCURATE);
    assert_eq!(
        (found.iterations, found.refinements, found.attempts),
        (30, 30, 3),
        "the second's counts include the first's"
    );
    assert_eq!([found.x[0], found.objective], [found.certificate.primal_residual; 2], "of one attempt");
    (found.status, found.x[0], found.message)
}

#[test]
fn the_better_status_counts_and_among_equals_the_smaller_residual() {
    use Status::{
        DualInfeasible, Interrupted, MaxIterations, MaxTime, NumericalLimit, PrimalInfeasible, Solved,
        SolvedInaccurate,
    };
    let (small, large) = (1e-7, 1e-3);
    for (first, second, status, residual) in [
        ((SolvedInaccurate, small), (Solved, large), Solved, large),
        ((NumericalLimit, small), (Solved, large), Solved, large),
        ((SolvedInaccurate, large), (SolvedInaccurate, small), SolvedInaccurate, small),
        ((SolvedInaccurate, small), (SolvedInaccurate, large), SolvedInaccurate, small),
        ((SolvedInaccurate, large), (NumericalLimit, small), SolvedInaccurate, large),
        ((NumericalLimit, small), (SolvedInaccurate, large), SolvedInaccurate, large),
        ((NumericalLimit, large), (NumericalLimit, small), NumericalLimit, small),
        ((NumericalLimit, small), (MaxIterations, large), NumericalLimit, small),
        ((NumericalLimit, large), (MaxIterations, small), MaxIterations, small),
        ((NumericalLimit, large), (PrimalInfeasible, small), PrimalInfeasible, small),
        ((NumericalLimit, small), (PrimalInfeasible, large), PrimalInfeasible, large),
        ((SolvedInaccurate, small), (PrimalInfeasible, large), SolvedInaccurate, small),
        ((SolvedInaccurate, small), (DualInfeasible, large), SolvedInaccurate, small),
        ((SolvedInaccurate, large), (MaxTime, small), SolvedInaccurate, large),
        ((NumericalLimit, small), (MaxTime, large), MaxTime, small),
        ((SolvedInaccurate, small), (Interrupted, large), Interrupted, small),
        ((NumericalLimit, large), (Interrupted, small), Interrupted, small),
    ] {
        let found = after(first, second);
        assert_eq!((found.0, found.1), (status, residual), "{first:?}, then {second:?}");
    }
}

#[test]
fn a_solve_that_was_stopped_says_so() {
    let (_, _, message) = after((Status::NumericalLimit, 1e-7), (Status::MaxTime, 1e-3));
    assert_eq!(message, "stopped in a restart; the attempt before: residual 1e-7");
    let (_, _, message) = after((Status::NumericalLimit, 1e-3), (Status::NumericalLimit, 1e-7));
    assert_eq!(message, "residual 1e-7");
}

fn claim(status: Status, radius: f64) -> Solution {
    let mut claim = outcome(status, f64::NAN, 30);
    claim.certificate.radius = radius;
    claim
}

/// ‖x‖ = 1e4, ‖(y, z)‖ = 2e3.
fn far(status: Status, residual: f64) -> Solution {
    let mut far = outcome(status, residual, 10);
    (far.x, far.y, far.z) = (vec![-1e4], vec![1.0], vec![2e3]);
    far
}

#[test]
fn a_proof_yields_to_a_later_solution_farther_out_than_it_reaches_and_to_nothing_else() {
    use Status::{
        DualInfeasible, Interrupted, MaxIterations, MaxTime, NumericalLimit, PrimalInfeasible, Solved,
        SolvedInaccurate,
    };
    for (proof, size, other) in
        [(PrimalInfeasible, 1e4, DualInfeasible), (DualInfeasible, 2e3, PrimalInfeasible)]
    {
        let outcome = |radius, status, residual| {
            better_of(Some(&claim(proof, radius)), far(status, residual), INACCURATE).status
        };
        for status in [Solved, SolvedInaccurate, NumericalLimit] {
            assert_eq!(outcome(size, status, 0.5 * INACCURATE), status);
            assert_eq!(outcome(1.01 * size, status, 0.5 * INACCURATE), proof, "the proof speaks of it");
        }
        for status in [NumericalLimit, MaxIterations, MaxTime, Interrupted] {
            assert_eq!(outcome(size, status, 2.0 * INACCURATE), proof, "{status} takes nothing from a proof");
        }
        for (status, radius, kept) in [(proof, 99.0, 100.0), (proof, 101.0, 101.0), (other, 101.0, 100.0)] {
            let found = better_of(Some(&claim(proof, 100.0)), claim(status, radius), INACCURATE);
            assert_eq!((found.status, found.certificate.radius), (proof, kept));
        }
    }
}

#[test]
fn a_proof_does_not_replace_what_appears_to_be_a_solution_farther_out_than_it_reaches() {
    let far = |residual| far(Status::NumericalLimit, residual);
    for (status, size) in [(Status::PrimalInfeasible, 1e4), (Status::DualInfeasible, 2e3)] {
        let outcome =
            |residual, radius| better_of(Some(&far(residual)), claim(status, radius), INACCURATE).status;
        assert_eq!(outcome(0.5 * INACCURATE, size), Status::NumericalLimit);
        assert_eq!(outcome(0.5 * INACCURATE, 1.01 * size), status, "it is nearer than that");
        assert_eq!(outcome(2.0 * INACCURATE, size), status, "it does not appear to be one");
    }
}

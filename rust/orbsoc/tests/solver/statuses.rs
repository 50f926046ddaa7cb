//! Every status, on problems whose answer is known; the evidence is recomputed here.

use crate::known::{generated, infeasible, solvable, unbounded};
use orbsoc::{solve, Settings, Status};

#[test]
fn known_optima_are_found_and_stand_up_to_the_referee() {
    for (name, data, value) in solvable() {
        let solution = solve(&data.problem(), &Settings::default()).unwrap();
        assert_eq!(solution.status, Status::Solved, "{name}: {}", solution.message);
        assert!((solution.objective - value).abs() <= 1e-7 * (1.0 + value.abs()), "{name}");
        let (primal, dual, gap) = data.residuals(&solution);
        assert!(primal.max(dual).max(gap) <= 1e-7, "{name}: {primal:e} {dual:e} {gap:e}");
        let (objective, dual_objective) = data.objectives(&solution);
        assert!((objective - solution.objective).abs() <= 1e-12 * (1.0 + value.abs()), "{name}");
        assert!((dual_objective - solution.dual_objective).abs() <= 1e-12 * (1.0 + value.abs()), "{name}");
        assert!(solution.certificate.worst() <= 1e-8 && solution.certificate.radius.is_nan(), "{name}");
    }
}

#[test]
fn generated_optima_are_found() {
    for seed in 0..20 {
        let (data, value) = generated(seed);
        let solution = solve(&data.problem(), &Settings::default()).unwrap();
        assert_eq!(solution.status, Status::Solved, "seed {seed}: {}", solution.message);
        assert!((solution.objective - value).abs() <= 1e-7 * (1.0 + value.abs()), "seed {seed}");
        let (primal, dual, gap) = data.residuals(&solution);
        assert!(primal.max(dual).max(gap) <= 1e-7, "seed {seed}: {primal:e} {dual:e} {gap:e}");
    }
}

#[test]
fn absent_rows_have_infinite_slack_and_no_multiplier() {
    let (_, data, _) = solvable().pop().unwrap();
    let solution = solve(&data.problem(), &Settings::default()).unwrap();
    assert_eq!((solution.s[0], solution.z[0]), (f64::INFINITY, 0.0));
    assert!((solution.z[1] - 1.0).abs() < 1e-7, "the cone of size one is the active row");
}

#[test]
fn infeasible_problems_get_a_certificate_that_excludes_a_large_ball() {
    for (name, data) in infeasible() {
        let solution = solve(&data.problem(), &Settings::default()).unwrap();
        assert_eq!(solution.status, Status::PrimalInfeasible, "{name}: {}", solution.message);
        let scale = data.b.iter().chain(&data.h).fold(1.0, |top: f64, v| top.max(v.abs()));
        let radius = data.primal_radius(&solution);
        assert!(radius >= 50.0 * scale, "{name}: {radius:e}");
        // Beyond 1e12 the sum that the radius divides by is rounding.
        let stated = solution.certificate.radius;
        assert!(
            radius > 1e12 || (stated / radius - 1.0).abs() < 1e-3,
            "{name}: {radius:e}, stated {stated:e}"
        );
        assert!(solution.x.iter().all(|v| v.is_nan()), "{name}: there is no x");
        assert_eq!((solution.objective, solution.dual_objective), (f64::INFINITY, f64::INFINITY));
        assert!(solution.message.starts_with("no feasible x has"), "{}", solution.message);
    }
}

#[test]
fn unbounded_problems_get_a_ray() {
    for (name, data) in unbounded() {
        let solution = solve(&data.problem(), &Settings::default()).unwrap();
        assert_eq!(solution.status, Status::DualInfeasible, "{name}: {}", solution.message);
        let scale = data.c.iter().fold(1.0, |top: f64, v| top.max(v.abs()));
        assert!(data.dual_radius(&solution) >= 50.0 * scale, "{name}: {:e}", data.dual_radius(&solution));
        assert!(solution.y.iter().chain(&solution.z).all(|v| v.is_nan()), "{name}: there is no dual point");
        assert_eq!((solution.objective, solution.dual_objective), (f64::NEG_INFINITY, f64::NEG_INFINITY));
        assert!(solution.message.starts_with("dual infeasible (unbounded if feasible)"));
    }
}

#[test]
fn a_tolerance_out_of_reach_is_reported_with_the_line_that_failed() {
    let (data, value) = generated(1);
    let settings = Settings { tol: 1e-300, ..Settings::default() };
    let solution = solve(&data.problem(), &settings).unwrap();
    assert_eq!(solution.status, Status::SolvedInaccurate, "{}", solution.message);
    assert!(solution.message.starts_with("meets tol_inaccurate only: "), "{}", solution.message);
    assert!(solution.message.contains("(tol 1e-300)"), "{}", solution.message);
    assert!((solution.objective - value).abs() <= 1e-7 * (1.0 + value.abs()));

    let settings = Settings { tol: 1e-300, tol_inaccurate: 1e-300, ..Settings::default() };
    let solution = solve(&data.problem(), &settings).unwrap();
    assert_eq!(solution.status, Status::NumericalLimit, "{}", solution.message);
    assert!(solution.certificate.worst() <= 1e-8, "the best iterate comes along");
}

#[test]
fn public_names_are_those_of_the_status_table() {
    let names = [
        (Status::Solved, "SOLVED"),
        (Status::SolvedInaccurate, "SOLVED_INACCURATE"),
        (Status::PrimalInfeasible, "PRIMAL_INFEASIBLE"),
        (Status::DualInfeasible, "DUAL_INFEASIBLE"),
        (Status::MaxIterations, "MAX_ITERATIONS"),
        (Status::MaxTime, "MAX_TIME"),
        (Status::NumericalLimit, "NUMERICAL_LIMIT"),
        (Status::Interrupted, "INTERRUPTED"),
    ];
    for (status, name) in names {
        assert_eq!((status.name(), status.to_string().as_str()), (name, name));
    }
}

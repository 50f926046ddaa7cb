//! A counting allocator, in a process of its own: a solve allocates nothing.

use allocation_counter::measure;
use orbsoc::{
    Cones, Csc, Engine, Outcome, Problem, Settings, Solution, Stage, Start, Status, Step, CLOSING, ITERATION,
    STARTUP, WARM_STARTUP,
};

/// Every kind of block: a quadratic cost, an equality, rows, a dense cone and an expanded one.
fn problem(bound: f64) -> Problem {
    let n = 6;
    let row = |k: usize, v: f64| (0..n).map(|j| if j == k { v } else { 0.0 }).collect::<Vec<f64>>();
    let cost: Vec<Vec<f64>> = (0..n).map(|k| row(k, 1.0)).collect();
    let sum = vec![vec![1.0; n]];
    // x ≥ 0; ‖(x₁, x₂)‖ ≤ x₀ + bound; ‖x‖ ≤ bound.
    let mut g: Vec<Vec<f64>> = (0..n).map(|k| row(k, -1.0)).collect();
    g.extend((0..3).map(|k| row(k, -1.0)));
    g.push(vec![0.0; n]);
    g.extend((0..n).map(|k| row(k, -1.0)));
    let mut h = vec![0.0; g.len()];
    (h[6], h[9]) = (bound, bound);
    let sparse = |rows: &[Vec<f64>]| Csc::from_dense(&rows.iter().map(Vec::as_slice).collect::<Vec<_>>(), n);
    let cones = Cones { l: n, q: vec![3, n + 1] };
    let c = vec![-1.0, 0.5, 0.0, -2.0, 1.0, 0.0];
    Problem::new(Some(sparse(&cost)), c, Some(sparse(&sum)), vec![1.0], Some(sparse(&g)), h, cones).unwrap()
}

fn attempt(engine: &mut Engine<f64>, startup: &[Step]) -> u32 {
    let mut run = |stage| engine.run(stage);
    assert!(startup.iter().all(|step| step.perform(&mut run) == Outcome::Next));
    while ITERATION.iter().all(|step| step.perform(&mut run) == Outcome::Next) {}
    assert!(CLOSING.iter().all(|step| step.perform(&mut run) == Outcome::Next));
    engine.iteration()
}

#[test]
fn nothing_is_allocated_from_the_first_stage_to_the_last() {
    // The second problem is infeasible: the sum of x is 1, but ‖x‖ ≤ 0.1 allows 0.25 at most.
    for (bound, least) in [(2.0, 5), (0.1, 3)] {
        let mut engine = Engine::<f64>::new(&problem(bound), &Settings::default()).unwrap();
        let mut iterations = 0;
        let info = measure(|| iterations = attempt(&mut engine, STARTUP));
        assert_eq!((info.count_total, info.bytes_total), (0, 0), "bound {bound}");
        assert!(iterations >= least, "{iterations} iterations");
    }
}

#[test]
fn a_warm_start_allocates_nothing_either() {
    let mut engine = Engine::<f64>::new(&problem(2.0), &Settings::default()).unwrap();
    let before = engine.solve();
    engine.update(&problem(1.98)).unwrap();
    let failed = Solution { status: Status::NumericalLimit, ..before.clone() };
    let mut iterations = 0;
    let info = measure(|| {
        assert!(engine.start_from(&Start::from(&before)).unwrap());
        iterations = attempt(&mut engine, WARM_STARTUP);
        assert!(!engine.restart(&before) && engine.restart(&failed));
        iterations += attempt(&mut engine, STARTUP);
    });
    assert_eq!((info.count_total, info.bytes_total), (0, 0));
    assert!(iterations >= 6, "{iterations} iterations");
}

#[test]
fn an_attempt_of_as_many_events_as_the_limits_allow_does_not_allocate_either() {
    // A tolerance out of reach and refinement to the last step: the longest attempt there is.
    let settings = Settings {
        tol: 1e-300,
        refinement_tol: 1e-300,
        refinement_share: 1e-300,
        max_iterations: 60,
        ..Settings::default()
    };
    let mut engine = Engine::<f64>::new(&problem(2.0), &settings).unwrap();
    let info = measure(|| {
        attempt(&mut engine, STARTUP);
    });
    assert_eq!(info.count_total, 0);
    let refines = |stage| matches!(stage, Stage::RefineKkt | Stage::RefineConstantAndPredictor);
    assert!(engine.events().iter().filter(|event| refines(event.stage)).count() > 20);
}

#[test]
fn the_counter_counts() {
    assert_eq!(measure(|| drop(std::hint::black_box(vec![0.0f64; 10]))).count_total, 1);
}

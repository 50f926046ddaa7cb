//! The method's three lists, run by hand. Every driver of the stages gets the bits of `Engine::solve`:
//! an emulated processor, a debugger, or this loop, which prints a line for each iteration.
//!
//! ```text
//! cargo run --release --example manual_stepping
//! ```

use orbsoc::{
    Buffer, Cones, Csc, Engine, Error, Outcome, Problem, Settings, Stage, Step, CLOSING, ITERATION, STARTUP,
};

fn attempt(engine: &mut Engine<f64>) {
    for step in STARTUP {
        step.perform(&mut |stage| engine.run(stage));
    }
    println!("iteration    primal      dual       gap        μ      step  refined");
    'iterations: loop {
        for step in ITERATION {
            if let Outcome::Done(reason) = step.perform(&mut |stage| engine.run(stage)) {
                println!("left the iteration: {reason:?}");
                break 'iterations;
            }
            if *step == Step::Run(Stage::Statistics) {
                let at = engine.progress();
                println!(
                    "{:>9} {:>9.1e} {:>9.1e} {:>9.1e} {:>8.1e} {:>9.3} {:>8}",
                    at.iteration,
                    at.primal_residual,
                    at.dual_residual,
                    at.gap,
                    at.mu,
                    at.step,
                    at.refinements
                );
            }
        }
    }
    for step in CLOSING {
        step.perform(&mut |stage| engine.run(stage));
    }
}

/// Run the example.
/// Step by hand, then let the engine do it.
pub fn main() -> Result<(), Error> {
    // The least-norm portfolio of three assets: min ½xᵀPx with Σx = 1, mean return ≥ 0.12, ‖x‖ ≤ 0.9.
    let cost = Csc::from_dense(&[&[0.04, 0.01, 0.0], &[0.0, 0.09, 0.02], &[0.0, 0.0, 0.16]], 3);
    let sum = Csc::from_dense(&[&[1.0, 1.0, 1.0]], 3);
    let g = Csc::from_dense(
        &[
            &[-0.08, -0.12, -0.16], // mean return
            &[0.0, 0.0, 0.0],       // 0.9 ≥ ‖x‖
            &[-1.0, 0.0, 0.0],
            &[0.0, -1.0, 0.0],
            &[0.0, 0.0, -1.0],
        ],
        3,
    );
    let (h, cones) = (vec![-0.12, 0.9, 0.0, 0.0, 0.0], Cones { l: 1, q: vec![4] });
    let problem = Problem::new(Some(cost), vec![0.0; 3], Some(sum), vec![1.0], Some(g), h, cones)?;

    let mut engine = Engine::new(&problem, &Settings::default())?;
    attempt(&mut engine);
    let solution = engine.conclude();
    println!("{}: x = {:.6?}, risk {:.6}", solution.status, solution.x, solution.objective);

    // Every word a stage made is there to look at, and everything that ran was recorded.
    let runs = |stage| engine.events().iter().filter(|event| event.stage == stage).count();
    let substitutions = runs(Stage::SolveConstantAndPredictor) + runs(Stage::SolveKkt);
    println!("{} factorisations, {substitutions} substitutions", runs(Stage::Factorize));
    println!(
        "τ = {:.3}, κ = {:.1e}",
        engine.buffer(Buffer::Homogenizer)[0],
        engine.buffer(Buffer::Homogenizer)[1]
    );

    // The same engine, left to itself, computes the same words.
    let by_itself = engine.solve();
    assert!(by_itself.x.iter().zip(&solution.x).all(|(a, b)| a.to_bits() == b.to_bits()));
    Ok(())
}

//! The shortest way from a point to a disc that keeps right of a wall: a second-order cone programme from
//! its data to a checked answer.
//!
//! ```text
//! cargo run --release --example solve_socp
//! ```

use orbsoc::{solve, Cones, Csc, Error, Problem, Settings, Status};

/// Run the example.
/// Build, solve, print, check.
pub fn main() -> Result<(), Error> {
    // Variables (t, x₀, x₁): t is the distance of x from (3, 4).
    //
    //     min t   s.t.   x₀ ≥ 3/2,   ‖x − (3, 4)‖ ≤ t,   ‖x‖ ≤ 2
    //
    // Rows of h − Gx ∈ K: one nonnegative, then two cones of dimension three, the bound first.
    let g = Csc::from_dense(
        &[
            &[0.0, -1.0, 0.0], // x₀ − 3/2 ≥ 0
            &[-1.0, 0.0, 0.0], // t …
            &[0.0, -1.0, 0.0], // … ≥ ‖(x₀ − 3, …
            &[0.0, 0.0, -1.0], // … x₁ − 4)‖
            &[0.0, 0.0, 0.0],  // 2 …
            &[0.0, -1.0, 0.0], // … ≥ ‖(x₀, …
            &[0.0, 0.0, -1.0], // … x₁)‖
        ],
        3,
    );
    let h = vec![-1.5, 0.0, -3.0, -4.0, 2.0, 0.0, 0.0];
    let cones = Cones { l: 1, q: vec![3, 3] };
    let problem = Problem::new(None, vec![1.0, 0.0, 0.0], None, vec![], Some(g), h, cones)?;

    let solution = solve(&problem, &Settings { tol: 1e-10, ..Settings::default() })?;

    println!("{} after {} iterations: {}", solution.status, solution.iterations, solution.message);
    println!("x = ({:.8}, {:.8}), {:.8} from (3, 4)", solution.x[1], solution.x[2], solution.x[0]);
    // The multiplier of x₀ ≥ 3/2: how much shorter the way would be per unit that the wall moved left.
    println!("price of the wall: {:.6}", solution.z[0]);

    // Wall and circle meet at (3/2, √7/2).
    assert_eq!(solution.status, Status::Solved);
    assert!((solution.x[0] - f64::hypot(1.5, 4.0 - 7f64.sqrt() / 2.0)).abs() < 1e-8);
    Ok(())
}

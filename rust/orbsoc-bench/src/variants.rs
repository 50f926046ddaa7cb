//! Problems near a problem.

use orbsoc::{Error, Problem};

/// Change each number of c, b and h by up to `share` of it, as `seed` has it.
pub fn vary(problem: &mut Problem, share: f64, seed: u64) -> Result<(), Error> {
    let mut state = seed;
    let mut varied = |numbers: &[f64]| -> Vec<f64> {
        let mut vary = |&x: &f64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            x * (1.0 + share * ((state >> 40) as f64 / f64::from(1 << 24)))
        };
        numbers.iter().map(&mut vary).collect()
    };
    let [c, b, h] = [problem.c(), problem.b(), problem.h()].map(&mut varied);
    problem.set_c(&c)?;
    problem.set_b(&b)?;
    problem.set_h(&h)
}

//! What a solve may spend and how exact it must be.

use crate::error::Error;
use crate::symbolic::ordering::Ordering;

/// Settings of a solve. Each default was chosen by measurement; see `docs/decisions/`.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Relative tolerance of `Solved`.
    pub tol: f64,
    /// Relative tolerance of `SolvedInaccurate`.
    pub tol_inaccurate: f64,
    /// Iteration limit.
    pub max_iterations: u32,
    /// Wall-clock limit in seconds, checked once per iteration.
    pub max_time_s: f64,
    /// Regularisation added with the pivot's known sign to every diagonal entry of the scaled
    /// KKT matrix (geometric mean of what either sign gets); refinement removes its effect.
    pub static_regularization: f64,
    /// Pivots smaller than this, or of the wrong sign, are replaced by `dynamic_regularization`.
    pub pivot_floor: f64,
    /// What such pivots become, with their known sign.
    pub dynamic_regularization: f64,
    /// Refinement stops at this error relative to the right-hand side, …
    pub refinement_tol: f64,
    /// … or at this fraction of the residual that the step is to reduce.
    pub refinement_share: f64,
    /// Most refinement steps per linear solve.
    pub refinement_max: u32,
    /// Fraction of the step to the cone's boundary that is taken; it falls by up to 0.05 with the predictor's
    /// step, and rises near the end.
    pub step_fraction: f64,
    /// Passes of Ruiz equilibration.
    pub ruiz_passes: u32,
    /// Most restarts, by [`RESTARTS`](crate::RESTARTS), after the first attempt of a solve; 0 where a deadline is hard. A
    /// cold attempt after a warm start that was given up is one of them.
    pub max_restarts: u32,
    /// Order of the KKT matrix's elimination.
    pub ordering: Ordering,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            tol: 1e-8,
            tol_inaccurate: 1e-5,
            max_iterations: 100,
            max_time_s: f64::INFINITY,
            static_regularization: 1e-8,
            pivot_floor: 1e-13,
            dynamic_regularization: 1e-5,
            refinement_tol: 1e-12,
            refinement_share: 0.03,
            refinement_max: 10,
            step_fraction: 0.99,
            ruiz_passes: 4,
            max_restarts: 4,
            ordering: Ordering::Amd,
        }
    }
}

impl Settings {
    /// Defaults for single precision, where 1e-8 is below the arithmetic's resolution.
    pub fn single_precision() -> Self {
        Self {
            tol: 1e-4,
            tol_inaccurate: 1e-2,
            static_regularization: 2e-5,
            pivot_floor: 1e-7,
            dynamic_regularization: 1e-4,
            refinement_tol: 1e-6,
            ..Self::default()
        }
    }

    /// # Errors
    /// [`Error::Setting`] naming the first setting outside its range.
    pub fn validate(&self) -> Result<(), Error> {
        let check = |holds: bool, name, value: f64, allowed| {
            if holds {
                Ok(())
            } else {
                Err(Error::Setting { name, value, allowed })
            }
        };
        let positive = |name, value: f64| {
            check(value > 0.0 && value.is_finite(), name, value, "a positive, finite number")
        };
        positive("tol", self.tol)?;
        positive("tol_inaccurate", self.tol_inaccurate)?;
        check(self.max_time_s > 0.0, "max_time_s", self.max_time_s, "a positive number")?;
        positive("static_regularization", self.static_regularization)?;
        positive("pivot_floor", self.pivot_floor)?;
        positive("dynamic_regularization", self.dynamic_regularization)?;
        positive("refinement_tol", self.refinement_tol)?;
        positive("refinement_share", self.refinement_share)?;
        // Events are allocated in advance, for as many iterations and refinements as there may be.
        let within = |name, value: u32, range: core::ops::RangeInclusive<u32>, allowed| {
            check(range.contains(&value), name, f64::from(value), allowed)
        };
        within("max_iterations", self.max_iterations, 1..=100_000, "1 to 100000")?;
        within("refinement_max", self.refinement_max, 0..=100, "0 to 100")?;
        within("ruiz_passes", self.ruiz_passes, 0..=100, "0 to 100")?;
        within("max_restarts", self.max_restarts, 0..=100, "0 to 100")?;
        let fraction = self.step_fraction;
        check(fraction > 0.0 && fraction < 1.0, "step_fraction", fraction, "between 0 and 1, both excluded")?;
        Ok(())
    }
}

//! Restarts as data: which attempt follows one that ended without a settled outcome.
//!
//! The first row of [`RESTARTS`] that fits decides; where none fits, or `max_restarts` are made, the solve ends with the best
//! outcome of its attempts. A cold attempt after a rejected warm start is a restart. A start that is not finite is not
//! attempted, and counts as none.

use crate::outcome::solution::Status;

/// Factor of `refinement_share` in attempts after one that stalled.
const RETRY_REFINEMENT: f64 = 0.1;
/// Factor of `static_regularization` after two attempts that stalled without a usable iterate …
const RETRY_REGULARIZATION_UP: f64 = 10.0;
/// … and after one that stalled on a certificate that is not conclusive.
const RETRY_REGULARIZATION_DOWN: f64 = 0.01;

/// A solve attempt: from one start-up list to its closing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Attempt {
    /// From a given point, as the settings say.
    Warm,
    /// From the cold start, as the settings say.
    #[default]
    Cold,
    /// Linear solves are refined further.
    Refined,
    /// That, and pivots are regularised more: rounding in the elimination must not hide them.
    Regularized,
    /// Refined, and pivots are regularised less: that must not hide a solution with large multipliers.
    Light,
}

impl Attempt {
    /// The name in documents and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Warm => "warm",
            Self::Cold => "cold",
            Self::Refined => "refined",
            Self::Regularized => "regularized",
            Self::Light => "light",
        }
    }

    /// Factors of `refinement_share` and of `static_regularization`.
    pub(crate) fn factors(self) -> (f64, f64) {
        let row = RESTARTS.iter().find(|row| row.attempt == self);
        row.map_or((1.0, 1.0), |row| (row.refinement_factor, row.regularization_factor))
    }
}

/// A row of the restart policy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Restart {
    /// The attempt that ended is one of these, …
    pub after: &'static [Attempt],
    /// … it stalled, where this is true, …
    pub stalled: bool,
    /// … and the solve's outcome so far has one of these statuses.
    pub statuses: &'static [Status],
    /// The attempt that follows, from the cold start.
    pub attempt: Attempt,
    /// What it multiplies `refinement_share` by.
    pub refinement_factor: f64,
    /// What it multiplies `static_regularization` by.
    pub regularization_factor: f64,
}

const UNSETTLED: &[Status] = &[Status::SolvedInaccurate, Status::MaxIterations, Status::NumericalLimit];
const INFEASIBLE: &[Status] = &[Status::PrimalInfeasible, Status::DualInfeasible];

use Attempt::{Cold, Light, Refined, Regularized, Warm};

/// The restart policy.
pub const RESTARTS: &[Restart] = &[
    row(&[Warm], false, UNSETTLED, Cold, (1.0, 1.0)),
    row(&[Warm], true, INFEASIBLE, Cold, (1.0, 1.0)),
    row(&[Cold, Refined], true, INFEASIBLE, Light, (RETRY_REFINEMENT, RETRY_REGULARIZATION_DOWN)),
    row(&[Cold], true, UNSETTLED, Refined, (RETRY_REFINEMENT, 1.0)),
    row(
        &[Refined],
        true,
        &[Status::NumericalLimit],
        Regularized,
        (RETRY_REFINEMENT, RETRY_REGULARIZATION_UP),
    ),
    row(&[Refined, Regularized], true, UNSETTLED, Light, (RETRY_REFINEMENT, RETRY_REGULARIZATION_DOWN)),
];

const fn row(
    after: &'static [Attempt],
    stalled: bool,
    statuses: &'static [Status],
    attempt: Attempt,
    (refinement_factor, regularization_factor): (f64, f64),
) -> Restart {
    Restart { after, stalled, statuses, attempt, refinement_factor, regularization_factor }
}

/// The most restarts that any solve makes under [`RESTARTS`]: warm, cold, refined, regularized, light.
pub(crate) const LONGEST: u32 = 4;

/// The row that fits an attempt that ended, stalled or not, with the solve's outcome so far at `status`.
pub(crate) fn next(ended: Attempt, stalled: bool, status: Status) -> Option<&'static Restart> {
    let fits = |row: &&Restart| {
        row.after.contains(&ended) && (stalled || !row.stalled) && row.statuses.contains(&status)
    };
    RESTARTS.iter().find(fits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_chain_of_restarts_is_longer_than_the_longest() {
        fn longest(from: Attempt) -> u32 {
            let rows = RESTARTS.iter().filter(|row| row.after.contains(&from));
            rows.map(|row| 1 + longest(row.attempt)).max().unwrap_or(0)
        }
        assert_eq!(longest(Attempt::Warm), LONGEST);
    }

    #[test]
    fn an_attempt_has_the_same_factors_in_every_row() {
        for row in RESTARTS {
            assert_eq!(row.attempt.factors(), (row.refinement_factor, row.regularization_factor));
        }
        assert_eq!(Attempt::Warm.factors(), (1.0, 1.0));
    }
}

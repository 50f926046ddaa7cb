//! What a solve returns.

use crate::problem::Problem;
use core::fmt;

/// Outcome of a solve, supported by numbers recomputed on the original data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Status {
    /// Residuals and gap meet the tolerance.
    Solved,
    /// They meet the reduced tolerance only.
    SolvedInaccurate,
    /// (y, z) is a certificate of primal infeasibility.
    PrimalInfeasible,
    /// x is a certificate: unbounded if feasible.
    DualInfeasible,
    /// The iteration limit; the best iterate comes along.
    MaxIterations,
    /// The time limit; the best iterate comes along.
    MaxTime,
    /// No further progress in this arithmetic; the best iterate comes along, NaN where there was none.
    NumericalLimit,
    /// Stopped from outside; the best iterate comes along, NaN where a batch had not begun the problem.
    Interrupted,
}

impl Status {
    /// The public name, as in other languages and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Solved => "SOLVED",
            Self::SolvedInaccurate => "SOLVED_INACCURATE",
            Self::PrimalInfeasible => "PRIMAL_INFEASIBLE",
            Self::DualInfeasible => "DUAL_INFEASIBLE",
            Self::MaxIterations => "MAX_ITERATIONS",
            Self::MaxTime => "MAX_TIME",
            Self::NumericalLimit => "NUMERICAL_LIMIT",
            Self::Interrupted => "INTERRUPTED",
        }
    }

    pub(crate) fn is_infeasible(self) -> bool {
        matches!(self, Self::PrimalInfeasible | Self::DualInfeasible)
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What became of a point to start from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum WarmStart {
    /// There was none.
    #[default]
    None,
    /// The solution was reached from it.
    Used,
    /// It was rejected, and the solve began anew from the cold start.
    FellBack,
}

impl WarmStart {
    /// The public name, as in other languages and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Used => "used",
            Self::FellBack => "fell_back",
        }
    }
}

/// Ratios of the status table, recomputed on the user's data after the fact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Certificate {
    /// Larger of the equality and cone residual ratios, and how far s is outside K.
    pub primal_residual: f64,
    /// Dual residual ratio, and how far z is outside K.
    pub dual_residual: f64,
    /// |p − d| / (1 + min(|p|, |d|)).
    pub gap: f64,
    /// Certified radius of an infeasibility certificate; NaN otherwise.
    pub radius: f64,
}

impl Certificate {
    /// The worst of the three ratios; NaN and infinity count as infinitely bad.
    pub fn worst(&self) -> f64 {
        let worst = self.primal_residual.max(self.dual_residual).max(self.gap);
        let finite = self.primal_residual + self.dual_residual + self.gap;
        if finite.is_finite() {
            worst
        } else {
            f64::INFINITY
        }
    }
}

/// A primal–dual point with its verified residuals.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Outcome.
    pub status: Status,
    /// Variables (n), or the certificate of dual infeasibility.
    pub x: Vec<f64>,
    /// Multipliers of Ax = b (p), or part of the certificate of primal infeasibility.
    pub y: Vec<f64>,
    /// Multipliers of the cone rows (m).
    pub z: Vec<f64>,
    /// Slacks (m); +∞ on absent rows.
    pub s: Vec<f64>,
    /// ½xᵀPx + cᵀx.
    pub objective: f64,
    /// −½xᵀPx − bᵀy − hᵀz.
    pub dual_objective: f64,
    /// Interior-point iterations of all attempts: those of a rejected warm start and of stalled attempts included.
    pub iterations: u32,
    /// What became of the point the solve was to start from.
    pub warm_start: WarmStart,
    /// Refinement steps over the whole solve.
    pub refinements: u32,
    /// Attempts that the solve took: one, and its restarts; none where it never began.
    pub attempts: u32,
    /// Residuals recomputed on the user's data.
    pub certificate: Certificate,
    /// One sentence: what the status rests on, and which line failed if one did.
    pub message: String,
}

impl Solution {
    /// Of a problem whose batch was stopped before its turn came.
    pub(crate) fn not_begun(problem: &Problem) -> Self {
        let no = f64::NAN;
        let [x, y, z, s] = [problem.n(), problem.p(), problem.m(), problem.m()].map(|len| vec![no; len]);
        Self {
            status: Status::Interrupted,
            x,
            y,
            z,
            s,
            objective: no,
            dual_objective: no,
            iterations: 0,
            warm_start: WarmStart::None,
            refinements: 0,
            attempts: 0,
            certificate: Certificate { primal_residual: no, dual_residual: no, gap: no, radius: no },
            message: "stopped before this problem began".into(),
        }
    }
}

/// The better outcome of two attempts of a solve, of which the `earlier` one, if there is one, stalled; with the counts of both.
pub(crate) fn better_of(earlier: Option<&Solution>, later: Solution, tol_inaccurate: f64) -> Solution {
    let Some(earlier) = earlier.filter(|earlier| !replaces(&later, earlier, tol_inaccurate)) else {
        return later;
    };
    let Solution { iterations, refinements, attempts, warm_start, .. } = later;
    // An interrupted solve says so; a time limit takes nothing from an earlier outcome, and nothing from a certificate.
    let stopped = match later.status {
        Status::MaxTime => earlier.status == Status::NumericalLimit,
        status => status == Status::Interrupted && !earlier.status.is_infeasible(),
    };
    let (status, message) = if stopped {
        (later.status, format!("stopped in a restart; the attempt before: {}", earlier.message))
    } else {
        (earlier.status, earlier.message.clone())
    };
    Solution { status, iterations, warm_start, refinements, attempts, message, ..earlier.clone() }
}

/// Whether the `later` outcome is worth more than that of an `earlier` attempt, which stalled: inaccurate, at a numerical
/// limit, or on a certificate. One that is nearly solved is not infeasible, nor one that appears to be, at a point that the
/// certificate does not exclude.
fn replaces(later: &Solution, earlier: &Solution, tol_inaccurate: f64) -> bool {
    let stands_against = |point: &Solution, proof: &Solution| {
        point.certificate.worst() <= tol_inaccurate
            && norm_exceeds(proof.status, proof.certificate.radius, &point.x, &point.y, &point.z)
    };
    let usable = earlier.status == Status::SolvedInaccurate;
    match later.status {
        status if status == earlier.status && status.is_infeasible() => {
            later.certificate.radius > earlier.certificate.radius
        }
        status if earlier.status.is_infeasible() => !status.is_infeasible() && stands_against(later, earlier),
        Status::Solved => true,
        Status::PrimalInfeasible | Status::DualInfeasible => !(usable || stands_against(earlier, later)),
        status if (status == Status::SolvedInaccurate) != usable => !usable,
        _ => later.certificate.worst() < earlier.certificate.worst(),
    }
}

/// Whether a point is too large to be excluded by a certificate of infeasibility with this radius.
pub(crate) fn norm_exceeds(status: Status, radius: f64, x: &[f64], y: &[f64], z: &[f64]) -> bool {
    let size = |v: &[f64]| v.iter().fold(0.0, |top: f64, v| top.max(v.abs()));
    let size = if status == Status::PrimalInfeasible { size(x) } else { size(y).max(size(z)) };
    size >= radius
}

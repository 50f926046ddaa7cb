//! The residuals behind a status, recomputed on the user's own data after the fact. Nothing here is shared
//! with the iteration: other vectors (nalgebra's), other products, always double precision.

use crate::outcome::norms::{symmetric_product, Sums};
use crate::outcome::point::{outside, present, Point};
use crate::outcome::radius::{dual_radius, primal_radius, Radius};
use crate::outcome::roundoff::{probabilistic_bound, RoundoffBound};
use crate::outcome::solution::{norm_exceeds, Certificate, Solution, Status, WarmStart};
use crate::problem::{Problem, Settings};
use nalgebra::DVector;

/// A certificate with at least this radius, over the data's scale or over its own, is accepted at the end of a solve.
const RADIUS_CLAIMED: f64 = 50.0;

/// Residuals of a point on the user's data.
struct Residuals {
    certificate: Certificate,
    /// Worst ratio by the common formula, s recomputed as h − Gx.
    independent: f64,
    objective: f64,
    dual_objective: f64,
}

/// How many times `tol` the common formula's ratio of a solution may be: its denominators leave out the products.
const INDEPENDENT_FACTOR: f64 = 100.0;

impl Residuals {
    /// Whether the ratios are within a tolerance, and the common formula's within another.
    fn within(&self, tol: f64, independent: f64) -> bool {
        self.certificate.worst() <= tol && self.independent <= independent
    }
}

/// A certificate of infeasibility on the user's data.
struct InfeasibilityCertificate {
    status: Status,
    at: Point,
    radius: Radius,
}

impl InfeasibilityCertificate {
    fn excludes(&self, point: &Point) -> bool {
        let [x, y, z] = [&point.x, &point.y, &point.z].map(DVector::as_slice);
        !norm_exceeds(self.status, self.radius.plain, x, y, z)
    }
}

/// An error over 1 + the size of what it is an error of; infinite when it is, whatever the size (∞/∞ is no number, and a
/// maximum drops it).
fn ratio(error: f64, size: f64) -> f64 {
    if error.is_finite() {
        error / (1.0 + size)
    } else {
        f64::INFINITY
    }
}

/// What rounding may hide in a residual or in the gap counts as its error where that could be more than a tenth of the tolerance.
fn residuals_of(problem: &Problem, at: &Point, tol: f64) -> Residuals {
    let sums = Sums::new();
    let norm = |v: &[f64]| sums.norm(v);
    let (x, y, z) = (at.x.as_slice(), at.y.as_slice(), at.z.as_slice());
    let h = present(problem, DVector::from_column_slice(&problem.h));
    let slack = present(problem, at.s.clone());
    let mut px = symmetric_product(&problem.p, &at.x);
    let (mut ax, aty) = sums.products(&problem.a, &at.x, &at.y);
    let (gx, gtz) = sums.products(&problem.g, &at.x, &at.z);
    let mut gx = present(problem, gx);
    let (norm_b, norm_h, norm_s) = (norm(&problem.b), norm(h.as_slice()), norm(slack.as_slice()));
    let (norm_c, norm_ax, norm_gx) = (norm(&problem.c), norm(ax.as_slice()), norm(gx.as_slice()));
    let (norm_px, norm_aty, norm_gtz) = (norm(px.as_slice()), norm(aty.as_slice()), norm(gtz.as_slice()));

    let half_curvature = 0.5 * sums.dot(x, px.as_slice());
    let objective = half_curvature + sums.dot(&problem.c, x);
    let dual_objective = -half_curvature - sums.dot(&problem.b, y) - sums.dot(h.as_slice(), z);
    let roundoff_factor = probabilistic_bound(problem.n() + problem.p() + problem.m());
    let most_in_gap = sums.magnitude(x, px.as_slice())
        + sums.magnitude(&problem.c, x)
        + sums.magnitude(&problem.b, y)
        + sums.magnitude(h.as_slice(), z);
    let scale = 1.0 + objective.abs().min(dual_objective.abs());
    let difference = (objective - dual_objective).abs();
    let gap = if roundoff_factor * most_in_gap <= 0.1 * tol * scale {
        difference / scale
    } else {
        (difference + roundoff_factor * most_in_gap) / scale
    };

    let [in_p, in_a, in_g] = [&problem.p, &problem.a, &problem.g].map(|matrix| norm(matrix.values()));
    let most_in_row = (in_a + in_g) * sums.size(x) + norm_b + norm_h + norm_s;
    let most_in_column = in_a * sums.size(y) + in_g * sums.size(z) + in_p * sums.size(x) + norm_c;
    let negligible = |most: f64, scale: f64| roundoff_factor * most <= 0.1 * tol * (1.0 + scale);
    let roundoff = if negligible(most_in_row, norm_b.max(norm_h)) && negligible(most_in_column, norm_c) {
        RoundoffBound::default()
    } else {
        RoundoffBound::of(problem, x, y, z, slack.as_slice())
    };
    sums.add(&mut ax, -1.0, &problem.b);
    let equality = roundoff.equality + norm(ax.as_slice());
    let mut beyond = h.clone();
    sums.add(&mut beyond, -1.0, gx.as_slice());
    let beyond = roundoff.conic + outside(problem, &beyond);
    sums.add(&mut gx, 1.0, slack.as_slice());
    sums.add(&mut gx, -1.0, h.as_slice());
    let conic = roundoff.conic + norm(gx.as_slice());
    for term in [&problem.c, aty.as_slice(), gtz.as_slice()] {
        sums.add(&mut px, 1.0, term);
    }
    let dual = roundoff.dual + norm(px.as_slice());
    let dual_outside = outside(problem, &at.z);
    let primal_residual = ratio(equality, norm_ax.max(norm_b))
        .max(ratio(conic, norm_gx.max(norm_h)))
        .max(ratio(outside(problem, &slack), norm_s));
    let dual_residual =
        ratio(dual, norm_px.max(norm_aty).max(norm_gtz).max(norm_c)).max(ratio(dual_outside, norm(z)));
    let certificate = Certificate { primal_residual, dual_residual, gap, radius: f64::NAN };
    let independent = Certificate {
        primal_residual: ratio(equality.max(beyond), norm_b.max(norm_h)),
        dual_residual: ratio(dual.max(dual_outside), norm_c),
        ..certificate
    };
    Residuals { independent: independent.worst(), certificate, objective, dual_objective }
}

/// Why the iteration ended. The status is decided afterwards, on the original data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Stop {
    Converged,
    PrimalCertificate,
    DualCertificate,
    MaxIterations,
    MaxTime,
    Stalled,
    Interrupted,
    /// The warm start was rejected; a cold attempt follows, by the restart policy.
    WarmStartRejected,
}

/// An attempt that has ended, as plain data: numbers in the user's scaling and the iteration's row order, and how it went.
pub(crate) struct FinishedAttempt<'a> {
    pub problem: &'a Problem,
    pub settings: &'a Settings,
    /// The user's row of each of the iteration's.
    pub row_origin: &'a [usize],
    pub stop: Stop,
    /// (x, y, z) and s of the best iterate.
    pub best: Vec<f64>,
    pub any_iterate: bool,
    /// (x, y, z) with the largest radius of primal infeasibility, …
    pub primal: Option<Vec<f64>>,
    /// … and of dual infeasibility.
    pub dual: Option<Vec<f64>>,
    pub iterations: u32,
    pub refinements: u32,
    pub attempts: u32,
    pub warm_start: WarmStart,
}

impl FinishedAttempt<'_> {
    /// The outcome, with the status that the numbers support.
    pub fn verify(&self) -> Solution {
        let (problem, stop) = (self.problem, self.stop);
        let best = self.point(&self.best, true);
        let tol = self.settings.tol;
        let residuals = residuals_of(problem, &best, tol);
        let ratio = residuals.certificate.worst();
        let tol_inaccurate = self.settings.tol_inaccurate;
        let solved = residuals.within(tol, INDEPENDENT_FACTOR * tol);
        // A certificate counts when the solve ended on it or could enlarge it no further; a limit
        // that cut the solve short proves nothing.
        let usable = residuals.within(tol_inaccurate, tol_inaccurate) && stop != Stop::Interrupted;
        let by_certificate = matches!(stop, Stop::PrimalCertificate | Stop::DualCertificate);
        if by_certificate || (stop == Stop::Stalled && !solved) {
            // An apparent solution that is as large as the radius is not excluded by it: a nearly solved problem is not
            // infeasible, however far out its solution lies, nor one whose products hide what is missing.
            let apparent = (!by_certificate && ratio <= tol_inaccurate).then_some(&best);
            if let Some(found) = self.infeasible(apparent) {
                return self.accept(&found);
            }
        }
        if solved {
            let message = format!("verified: worst residual ratio {ratio:.1e} on the original data");
            return self.assemble(Status::Solved, &best, &residuals, message);
        }
        let allowed = if usable { INDEPENDENT_FACTOR * tol } else { tol_inaccurate };
        let failed = failing_lines(&residuals, tol, allowed);
        if usable {
            let message = format!("meets tol_inaccurate only: {failed}");
            return self.assemble(Status::SolvedInaccurate, &best, &residuals, message);
        }
        let (status, advice) = match stop {
            Stop::MaxIterations => {
                (Status::MaxIterations, "raise max_iterations or look at the scaling of the data")
            }
            Stop::MaxTime => (Status::MaxTime, "raise max_time_s"),
            Stop::Interrupted => (Status::Interrupted, "stopped from outside"),
            _ => (Status::NumericalLimit, "no further progress; rescale the data or accept a larger tol"),
        };
        let message = if self.any_iterate {
            format!("best iterate returned: {failed}; {advice}")
        } else {
            let why = match stop {
                Stop::MaxTime | Stop::Interrupted => "the solve ended before there was one",
                _ => "the first linear solve gave no finite numbers",
            };
            format!("no iterate (x is NaN): {why}; {advice}")
        };
        self.assemble(status, &best, &residuals, message)
    }

    /// The stronger certificate of infeasibility, of those that the original data support and an `apparent` solution
    /// does not speak against. Of those that no radius in their own scale supports, the larger over the data's is the stronger.
    fn infeasible(&self, apparent: Option<&Point>) -> Option<InfeasibilityCertificate> {
        let primal = self.primal.as_ref().map(|entries| self.primal_infeasible(entries));
        let dual = self.dual.as_ref().map(|entries| self.dual_infeasible(entries));
        let certificates = primal.into_iter().chain(dual).filter(|found| {
            let Radius { relative, own, .. } = found.radius;
            relative.max(own) >= RADIUS_CLAIMED && apparent.is_none_or(|solution| found.excludes(solution))
        });
        let order = |of: &InfeasibilityCertificate| {
            let Radius { relative, own, .. } = of.radius;
            (if own >= RADIUS_CLAIMED { own } else { 0.0 }, relative)
        };
        certificates.max_by(|one, other| {
            let (one, other) = (order(one), order(other));
            one.0.total_cmp(&other.0).then(one.1.total_cmp(&other.1))
        })
    }

    /// That no x is feasible.
    fn primal_infeasible(&self, entries: &[f64]) -> InfeasibilityCertificate {
        let mut at = self.point(entries, false);
        let radius = primal_radius(self.problem, &mut at);
        at.x.fill(f64::NAN);
        InfeasibilityCertificate { status: Status::PrimalInfeasible, at, radius }
    }

    /// That no dual point is.
    fn dual_infeasible(&self, entries: &[f64]) -> InfeasibilityCertificate {
        let mut at = self.point(entries, false);
        let radius = dual_radius(self.problem, &mut at);
        at.y.fill(f64::NAN);
        at.z.fill(f64::NAN);
        InfeasibilityCertificate { status: Status::DualInfeasible, at, radius }
    }

    /// Read (x, y, z) and perhaps s from entries in the user's scaling, into the user's rows.
    fn point(&self, entries: &[f64], with_slack: bool) -> Point {
        let (problem, m) = (self.problem, self.row_origin.len());
        let (n, p) = (problem.n(), problem.p());
        let take = |from: usize, len: usize| DVector::from_column_slice(&entries[from..from + len]);
        let mut z = DVector::zeros(problem.m());
        let mut s = DVector::from_element(problem.m(), if with_slack { f64::INFINITY } else { f64::NAN });
        for (k, &row) in self.row_origin.iter().enumerate() {
            z[row] = entries[n + p + k];
            if with_slack {
                s[row] = entries[n + p + m + k];
            }
        }
        Point { x: take(0, n), y: take(n, p), z, s }
    }

    fn accept(&self, found: &InfeasibilityCertificate) -> Solution {
        let (none, radius) = (f64::NAN, found.radius.plain);
        let certificate = Certificate { primal_residual: none, dual_residual: none, gap: none, radius };
        let (infinite, message) = if found.status == Status::PrimalInfeasible {
            let proved = if radius.is_finite() {
                format!("no feasible x has ‖x‖∞ < {radius:.3e}")
            } else {
                "no x is feasible, however large".into()
            };
            (f64::INFINITY, proved)
        } else {
            let proved = if radius.is_finite() {
                format!("no dual point has norm below {radius:.3e}")
            } else {
                "there is no dual point, however large".into()
            };
            (f64::NEG_INFINITY, format!("dual infeasible (unbounded if feasible): {proved}"))
        };
        let residuals =
            Residuals { certificate, independent: none, objective: infinite, dual_objective: infinite };
        self.assemble(found.status, &found.at, &residuals, message)
    }

    fn assemble(&self, status: Status, at: &Point, residuals: &Residuals, mut message: String) -> Solution {
        message.push_str(&absent_rows(&self.problem.h));
        Solution {
            status,
            x: at.x.as_slice().to_vec(),
            y: at.y.as_slice().to_vec(),
            z: at.z.as_slice().to_vec(),
            s: at.s.as_slice().to_vec(),
            objective: residuals.objective,
            dual_objective: residuals.dual_objective,
            iterations: self.iterations,
            warm_start: self.warm_start,
            refinements: self.refinements,
            attempts: self.attempts,
            certificate: residuals.certificate,
            message,
        }
    }
}

/// What to say of rows that do not constrain; nothing where all do.
fn absent_rows(h: &[f64]) -> String {
    let absent: Vec<usize> = (0..h.len()).filter(|&i| h[i] == f64::INFINITY).collect();
    if absent.is_empty() {
        return String::new();
    }
    let named: Vec<String> = absent.iter().take(5).map(ToString::to_string).collect();
    let more = if absent.len() > 5 { ", …" } else { "" };
    let rows = if absent.len() == 1 { "row does" } else { "rows do" };
    format!("; {} {rows} not constrain, h being 1e20 or more: {}{more}", absent.len(), named.join(", "))
}

/// The ratios above `tol`, and the common formula's where it is above what is `allowed` for it.
fn failing_lines(residuals: &Residuals, tol: f64, allowed: f64) -> String {
    let c = &residuals.certificate;
    let lines = [("primal residual", c.primal_residual), ("dual residual", c.dual_residual), ("gap", c.gap)];
    let failing: Vec<String> = lines
        .iter()
        .filter(|(_, v)| v.is_nan() || *v > tol)
        .map(|(name, v)| format!("{name} {v:.1e}"))
        .collect();
    let own = (!failing.is_empty()).then(|| format!("{} (tol {tol:.0e})", failing.join(", ")));
    let by_common_formula = (residuals.independent > allowed).then(|| {
        format!("residual by the common formula {:.1e} (at most {allowed:.0e})", residuals.independent)
    });
    own.into_iter().chain(by_common_formula).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_infinite_error_of_something_infinite_is_no_small_one() {
        assert_eq!(ratio(f64::INFINITY, f64::INFINITY), f64::INFINITY);
        assert_eq!(ratio(f64::NAN, 1.0), f64::INFINITY);
        assert_eq!(ratio(1.0, 1.0), 0.5);
    }

    #[test]
    fn rows_that_do_not_constrain_are_named() {
        let (no, all) = (f64::INFINITY, [f64::INFINITY; 7]);
        assert_eq!(absent_rows(&[1.0, 2.0]), "");
        assert_eq!(absent_rows(&[1.0, no]), "; 1 row does not constrain, h being 1e20 or more: 1");
        assert_eq!(absent_rows(&all), "; 7 rows do not constrain, h being 1e20 or more: 0, 1, 2, 3, 4, …");
    }
}

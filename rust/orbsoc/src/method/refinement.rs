//! Residual checks of the linear solves of an attempt: which are skipped, and when a solution is refined.

use crate::kernels::layout::refinement;
use crate::real::Decide;

/// A linear solve skips its residual where the tolerance is this factor of the attempt's largest known error …
pub(crate) const SKIP_MARGIN: f64 = 1e4;
/// … or this factor, where a residual with the same factors is known.
pub(crate) const SAME_FACTORS_MARGIN: f64 = 10.0;

/// What an attempt knows of the errors of its linear solves.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Accuracy {
    /// Refinement steps of the solve under way.
    refined: u32,
    /// Largest known error before any refinement.
    known: Option<f64>,
    /// The factors of the last residual check are still in use.
    same_factors: bool,
    /// Refinement tolerance of this iteration; none where every residual is checked.
    tolerance: Option<f64>,
    /// The tolerance is no smaller than that of the iteration before.
    risen: bool,
}

impl Accuracy {
    /// An iteration begins, with new factors and a new tolerance.
    pub fn renew(&mut self, tolerance: Option<f64>) {
        self.risen = tolerance.zip(self.tolerance).is_some_and(|(now, before)| now >= before);
        (self.same_factors, self.tolerance) = (false, tolerance);
    }

    /// Whether the next linear solve needs its residual. From one iteration to the next errors change
    /// little, as a rule, while tolerances fall. Where one does not, a skipped residual may
    /// be why, and all are checked; so are those of an attempt that knows no error above zero.
    pub fn needs_residual(&self) -> bool {
        let margin = if self.same_factors { SAME_FACTORS_MARGIN } else { SKIP_MARGIN };
        let small = |(tolerance, known): (f64, f64)| known > 0.0 && tolerance >= margin * known;
        self.risen || !self.tolerance.zip(self.known).is_some_and(small)
    }

    /// After a linear solve or a refinement step of one lane, whose entries these are, three for each right-hand side:
    /// whether to refine once more.
    pub fn wants_more<T: Decide>(&mut self, lane: usize, most: u32, entries: &[T], active: &mut T) -> bool {
        let solves = entries.chunks_exact(refinement::WORDS);
        let first = self.refined == 0;
        let needs_residual = !first || self.needs_residual();
        if first && needs_residual {
            self.note(solves.clone().map(|entries| entries[refinement::ERROR].lane(lane)));
        }
        let enough = solves.into_iter().all(|entries| {
            let error = entries[refinement::ERROR].lane(lane);
            let worthwhile = first || error <= entries[refinement::WORTHWHILE].lane(lane);
            error <= entries[refinement::ALLOWED].lane(lane) || !error.is_finite() || !worthwhile
        });
        if !needs_residual || enough || self.refined >= most || active.lane(lane) == 0.0 {
            // Whatever other lanes still refine leaves this one alone.
            active.set_lane(lane, 0.0);
            self.refined = 0;
            return false;
        }
        self.refined += 1;
        true
    }

    fn note(&mut self, errors: impl Iterator<Item = f64>) {
        // What is not a number is above every tolerance.
        let size = |error: f64| if error.is_nan() { f64::INFINITY } else { error };
        self.known = Some(errors.map(size).fold(self.known.unwrap_or(0.0), f64::max));
        self.same_factors = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a solve with this error was checked.
    fn solve(accuracy: &mut Accuracy, error: f64) -> bool {
        let needs_residual = accuracy.needs_residual();
        let mut active: f64 = 1.0;
        accuracy.wants_more(0, 0, &[error, 1e-9, error], &mut active);
        needs_residual
    }

    fn after(error: f64) -> Accuracy {
        let mut accuracy = Accuracy::default();
        assert!(solve(&mut accuracy, error), "the first of an attempt");
        accuracy
    }

    #[test]
    fn a_residual_is_checked_where_the_tolerance_is_near_the_largest_known_error() {
        let mut accuracy = after(1e-8);
        accuracy.renew(Some(1.1e-4));
        assert!(!solve(&mut accuracy, 1.0), "this error is not checked");
        assert!(!solve(&mut accuracy, 1.0), "nor is anything known of these factors");
        accuracy.renew(Some(0.9e-4));
        assert!(solve(&mut accuracy, 1e-9));
        assert!(!solve(&mut accuracy, 1.0), "the same factors");
        accuracy.renew(Some(0.9e-5));
        assert!(solve(&mut accuracy, 1e-5));
        assert!(solve(&mut accuracy, 1e-7));
        assert!(solve(&mut accuracy, 1e-7), "the larger error of both counts");
        accuracy.renew(Some(0.9e-6));
        assert!(solve(&mut accuracy, 1e-12));
        assert!(solve(&mut accuracy, 1e-12), "and that of other factors, too");
    }

    #[test]
    fn where_the_tolerance_does_not_fall_all_are_checked() {
        let mut accuracy = after(1e-8);
        accuracy.renew(Some(1.0));
        assert!(!solve(&mut accuracy, 1e-8));
        for tolerance in [1.0, 2.0] {
            accuracy.renew(Some(tolerance));
            assert!(solve(&mut accuracy, 1e-8));
            assert!(solve(&mut accuracy, 1e-8), "the same factors, too");
        }
        accuracy.renew(Some(1.9));
        assert!(!solve(&mut accuracy, 1e-8));
    }

    #[test]
    fn without_a_tolerance_even_a_solve_like_an_exact_one_is_checked() {
        let mut accuracy = after(0.0);
        accuracy.renew(None);
        assert!(solve(&mut accuracy, 0.0));
        accuracy.renew(Some(1.0));
        assert!(solve(&mut accuracy, 0.0), "nor does it say anything of others");
    }

    #[test]
    fn after_what_is_not_a_number_everything_is_checked() {
        for broken in [f64::NAN, f64::INFINITY] {
            let mut accuracy = after(broken);
            accuracy.renew(Some(f64::MAX));
            assert!(solve(&mut accuracy, broken));
        }
    }

    #[test]
    fn an_unchecked_solve_is_not_refined_whatever_its_entries_are() {
        let mut accuracy = after(1e-8);
        accuracy.renew(Some(1.0));
        let mut active: f64 = 1.0;
        assert!(!accuracy.wants_more(0, 10, &[5.0, 1e-9, 5.0], &mut active));
        assert!(active.abs() < 0.5, "a neighbour's refinement leaves it alone");
        assert!(
            !accuracy.wants_more(0, 10, &[5.0, 1e-9, 5.0], &mut active),
            "nor when the neighbour asks again"
        );
    }
}

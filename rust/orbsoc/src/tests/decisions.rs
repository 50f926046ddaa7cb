//! Which linear solves have their residual checked: decisions on made-up errors and tolerances.

use crate::kernels::decisions::{refine_again, renew};
use crate::kernels::layout::control as word;

/// What an attempt knows of the errors of its linear solves.
struct Accuracy {
    words: [f64; word::WORDS],
}

impl Accuracy {
    /// An iteration begins; without a tolerance, in an attempt that trusts none.
    fn renew(&mut self, tolerance: Option<f64>) {
        self.words[word::TRUSTING] = f64::from(u8::from(tolerance.is_some()));
        renew(tolerance.unwrap_or(1.0), &mut self.words);
    }
}

/// Whether a solve with this error was checked.
fn solve(accuracy: &mut Accuracy, error: f64) -> bool {
    let needs_residual = accuracy.words[word::NEEDS_RESIDUAL] != 0.0;
    refine_again(&[error, 1e-9, error], &mut 1.0, &mut accuracy.words);
    needs_residual
}

fn after(error: f64) -> Accuracy {
    let mut accuracy = Accuracy { words: [0.0; word::WORDS] };
    accuracy.words[word::NEEDS_RESIDUAL] = 1.0;
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
    accuracy.words[word::MAX_REFINEMENTS] = 10.0;
    let mut active: f64 = 1.0;
    for who in ["a neighbour's refinement leaves it alone", "nor when the neighbour asks again"] {
        refine_again(&[5.0, 1e-9, 5.0], &mut active, &mut accuracy.words);
        assert!(active.abs() < 0.5, "{who}");
    }
}

//! The examples run, and what they assert holds.

#[path = "../examples/manual_stepping.rs"]
mod manual_stepping;
#[path = "../examples/solve_socp.rs"]
mod solve_socp;

#[test]
fn a_problem_is_solved_from_its_data_to_a_checked_answer() {
    solve_socp::main().unwrap();
}

#[test]
fn stepping_by_hand_ends_in_the_bits_of_solve() {
    manual_stepping::main().unwrap();
}

//! The stage lists are a legal order by the dataflow table, and the table rejects illegal ones.

use orbsoc::stage::check_schedule;
use orbsoc::{Buffer, Stage, Step, CLOSING, ITERATION, STARTUP, WARM_STARTUP};

#[test]
fn the_methods_lists_read_only_fresh_words() {
    check_schedule(STARTUP, ITERATION, CLOSING).unwrap();
    check_schedule(WARM_STARTUP, ITERATION, CLOSING).unwrap();
}

#[test]
fn leaving_out_any_single_stage_is_rejected() {
    // Without `advance` every entry read is fresh, but no step is taken. Without `center_start` or
    // `newton_start` the point is an earlier one.
    let legal = [Stage::Advance, Stage::CenterStart, Stage::NewtonStart];
    for list in [STARTUP, WARM_STARTUP, ITERATION] {
        for k in 0..list.len() {
            let Step::Run(stage) = list[k] else { continue };
            let mut shorter = list.to_vec();
            shorter.remove(k);
            let result = if list == ITERATION {
                check_schedule(STARTUP, &shorter, CLOSING)
            } else {
                check_schedule(&shorter, ITERATION, CLOSING)
            };
            assert!(result.is_err() != legal.contains(&stage), "leaving out {} at {k} passes", stage.name());
        }
    }
}

#[test]
fn a_rejected_schedule_names_stage_and_buffer() {
    let error = check_schedule(&[Step::Run(Stage::Factorize)], &[], &[]).unwrap_err();
    assert_eq!((error.stage, error.buffer, error.stale), (Stage::Factorize, Buffer::KktValues, false));
    assert_eq!(error.to_string(), "stage `factorize` reads buffer `kkt_values`, which was never written");
}

//! Errors: invalid engines, streams that do not fit, damaged microcode.

use crate::problem::problem;
use orbsoc::{record_tapes, Cones, Csc, Module, Problem, Settings, Stage};
use orbsoc_hw::{
    decompress, flat, snapshots, validation_case, Aim, Configuration, Error, Fault, Format, Gaps, Machine,
    Program, Rule,
};

fn small() -> Program {
    let recording = record_tapes(&problem(1, 6, 2, 3, &[3]), &Settings::default()).unwrap();
    let recording = recording.only(|stage| stage.module() != Module::Statistics);
    let engine = Configuration { address_bits: 12, ..Configuration::default() };
    Program::new(&recording, &engine).unwrap()
}

#[test]
fn an_engine_too_small_is_refused_with_what_it_needs() {
    let recording = record_tapes(&problem(1, 6, 2, 3, &[3]), &Settings::default()).unwrap();
    let of = |engine| Program::new(&recording, &engine).unwrap_err();
    let good = Configuration::default();
    let tiny = of(Configuration { address_bits: 8, ..good });
    assert!(matches!(tiny, Error::Storage { needed_by: "buffers", available: 256, .. }), "{tiny}");
    let short = of(Configuration { microcode_words: 100, ..good });
    assert!(matches!(short, Error::Microcode { available: 100, .. }), "{short}");
    let none = of(Configuration { lanes: 0, ..good });
    assert_eq!(none.to_string(), "configuration `lanes` = 0: allowed is 1 to 16");
}

#[test]
fn gaps_without_end_are_refused_by_field() {
    let words = [snapshots::<f64>(&problem(1, 6, 2, 3, &[3]), &Settings::default()).unwrap()];
    let case = |seed, level| {
        validation_case(&small(), &words, Module::LineSearch, Format::InOrder(Gaps { seed, level }))
    };
    assert!(case(u32::MAX, 255).is_ok());
    let of = |seed, level| case(seed, level).unwrap_err().to_string();
    assert_eq!(of(0, 64), "configuration `seed` = 0: allowed is 1 to 2^32 - 1");
    assert_eq!(of(1, 256), "configuration `level` = 256: allowed is 0 to 255");
}

#[test]
fn a_stage_of_the_processing_system_has_no_segment() {
    let error = small().segment(Stage::Statistics).unwrap_err();
    assert_eq!(error, Error::NoSegment { stage: "statistics".to_owned() });
    assert_eq!(small().segment(Stage::Factorize).unwrap().stage, Stage::Factorize);
}

#[test]
fn words_of_another_pattern_are_refused_be_they_fewer_or_more() {
    for other in [problem(1, 3, 1, 1, &[]), problem(1, 12, 4, 6, &[3, 5])] {
        let words = [snapshots::<f64>(&other, &Settings::default()).unwrap()];
        let error = validation_case(&small(), &words, Module::ConeOps, Format::Flat).unwrap_err();
        assert!(matches!(error, Error::Pattern { found, expected, .. } if found != expected), "{error}");
    }
}

#[test]
fn words_of_another_pattern_with_as_many_words_are_refused_by_the_matrix() {
    let of = |rows: [usize; 2]| {
        let g = Csc::new("G", (2, 2), vec![0, 1, 2], rows.to_vec(), vec![-1.0, -1.0]).unwrap();
        let cones = Cones { l: 2, q: vec![] };
        Problem::new(None, vec![1.0, 1.0], None, vec![], Some(g), vec![-1.0, -2.0], cones).unwrap()
    };
    let (straight, crossed) = (of([0, 1]), of([1, 0]));
    let recording = record_tapes(&straight, &Settings::default()).unwrap();
    let program = Program::new(&recording, &Configuration::default()).unwrap();
    let case = |problem| {
        let words = [snapshots::<f64>(problem, &Settings::default()).unwrap()];
        validation_case(&program, &words, Module::LineSearch, Format::Flat)
    };
    assert!(case(&straight).is_ok());
    let error = case(&crossed).unwrap_err();
    assert_eq!(error, Error::OtherPattern { part: "G" });
    assert!(error.to_string().contains("`G`"), "{error}");
}

#[test]
fn streams_of_no_stage_or_of_one_without_a_segment_are_refused() {
    let recording = record_tapes(&problem(1, 6, 2, 3, &[3]), &Settings::default()).unwrap();
    let recording = recording.only(|stage| stage.module() != Module::Statistics);
    let engine = Configuration { address_bits: 12, ..Configuration::default() };
    let of = |stages: &[Stage]| Program::joined(&recording, &engine, Aim::Fast, stages, None).unwrap_err();
    assert_eq!(of(&[]), Error::NoSegment { stage: String::new() });
    assert_eq!(
        of(&[Stage::Factorize, Stage::Statistics]),
        Error::NoSegment { stage: "statistics".to_owned() }
    );
}

#[test]
fn a_word_with_an_opcode_that_is_none_is_damaged() {
    let program = small();
    let mut words = flat(&program.segment(Stage::LoadKkt).unwrap().schedule, &program.configuration);
    let opcode = 1 + 4 * program.configuration.address_bits as usize;
    words.put(1, opcode, 4, 15);
    let mut machine = Machine::new(&program.configuration);
    (0..program.layout.words()).for_each(|address| machine.load(address, 0));
    match machine.run(&words, 0) {
        Err(Fault::Damaged(error @ Error::Damaged { word: 1, .. })) => {
            assert!(error.to_string().contains("15"), "{error}");
        }
        other => panic!("{other:?}"),
    }
}

/// The rule that the machine reports for a schedule that is changed in one place.
fn fault(change: impl FnOnce(&mut Vec<orbsoc_hw::Issue>, &Configuration)) -> Rule {
    let program = small();
    let mut schedule = program.segment(Stage::Factorize).unwrap().schedule.clone();
    change(&mut schedule.issues, &program.configuration);
    let mut machine = Machine::new(&program.configuration);
    (0..program.layout.words()).for_each(|address| machine.load(address, 1.0f64.to_bits()));
    match machine.run(&flat(&schedule, &program.configuration), 0) {
        Err(Fault::Violation(violation)) => violation.rule,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_broken_rule_is_found_by_name() {
    // A reader issued one cycle after its operand.
    let early = fault(|issues, _| {
        let (producer, reader) = (0..issues.len())
            .flat_map(|k| (k + 1..issues.len()).map(move |j| (k, j)))
            .find(|&(k, j)| {
                let (k, j) = (issues[k], issues[j]);
                j.code.reads()[0] && j.operands[0] == k.destination && j.cycle > k.cycle + 1
            })
            .expect("a dependent pair");
        issues[reader].operands[0] = issues[producer].destination;
        let free = issues[producer].cycle + 1;
        issues.retain(|issue| issue.cycle != free);
        let reader =
            issues.iter().position(|i| i.operands[0] == issues[producer].destination && i.cycle > free);
        issues[reader.expect("still there")].cycle = free;
    });
    assert!(matches!(early, Rule::ReadPending | Rule::ReadUnwritten), "{early:?}");
    // Two lanes read two words of one bank.
    let ports = fault(|issues, engine| {
        let two = issues.windows(2).position(|w| w[0].cycle == w[1].cycle && !w[1].code.on_divider());
        let k = two.expect("two operations in one cycle");
        issues[k].operands[0] = 0;
        issues[k + 1].operands[0] = engine.banks as u32;
    });
    assert_eq!(ports, Rule::ReadConflict);
    let unwritten = fault(|issues, engine| issues[0].operands[0] = engine.words() as u32 - 1);
    assert_eq!(unwritten, Rule::ReadUnwritten);
}

#[test]
fn a_stream_cut_short_is_damaged() {
    let program = small();
    let mut compressed = program.compressed();
    compressed.segments[4].lines = 1;
    let error = decompress(&compressed, 4, &program.configuration).unwrap_err();
    assert!(matches!(error, Error::Damaged { .. }), "{error}");
}

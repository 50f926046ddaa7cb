//! Properties of every schedule on every engine.

use crate::problem::problem;
use orbsoc::{record_tapes, Buffer, Module, Problem, Settings, Stage};
use orbsoc_hw::{
    decompress, run_in_order, snapshots, validation_case, Aim, Configuration, Format, Gaps, Precision,
    Program,
};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

const MODULES: [Module; 7] = [
    Module::Statistics,
    Module::MatrixUpdate,
    Module::MatrixScaling,
    Module::Factorization,
    Module::LinearSolve,
    Module::ConeOps,
    Module::LineSearch,
];

fn problems() -> impl Strategy<Value = Problem> {
    (0u64..1000, 1usize..12, 0usize..4, 0usize..6, proptest::collection::vec(1usize..8, 0..3))
        .prop_filter_map("a cone or a row", |(seed, n, p, l, q)| {
            (l + q.len() > 0).then(|| problem(seed, n, p.min(n - 1), l, &q))
        })
}

fn engines() -> impl Strategy<Value = Configuration> {
    let precision = prop_oneof![Just(Precision::F64), Just(Precision::F32)];
    (precision, 1usize..9, 1usize..3, 1u32..6).prop_map(|(precision, lanes, dividers, banks)| Configuration {
        precision,
        lanes,
        dividers,
        banks: 1 << banks,
        address_bits: 14,
        ..Configuration::default()
    })
}

fn program(problem: &Problem, configuration: &Configuration) -> Program {
    let recording = record_tapes(problem, &Settings::default()).unwrap();
    Program::new(&recording, configuration).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 24, rng_seed: RngSeed::Fixed(5), failure_persistence: None, ..Default::default()
    })]

    /// Replayed on the words of a solve by a machine that checks every rule.
    #[test]
    fn microcode_makes_the_kernels_words_in_the_schedules_cycles(problem in problems(), engine in engines()) {
        let program = program(&problem, &engine);
        let modules = MODULES.into_iter();
        let settings = Settings::default();
        let made = match engine.precision {
            Precision::F64 => {
                let words = [snapshots::<f64>(&problem, &settings).unwrap()];
                modules.map(|m| validation_case(&program, &words, m, Format::Flat)).collect::<Result<Vec<_>, _>>()
            }
            Precision::F32 => {
                let words = [snapshots::<f32>(&problem, &settings).unwrap()];
                modules.map(|m| validation_case(&program, &words, m, Format::Flat)).collect()
            }
        };
        prop_assert!(made.is_ok(), "{:?}", made.err());
    }

    /// The same for compact schedules, whose temporaries have locations.
    #[test]
    fn compact_schedules_make_the_kernels_words_too(problem in problems(), engine in engines()) {
        let settings = Settings::default();
        let recording = record_tapes(&problem, &settings).unwrap();
        let engine = Configuration { precision: Precision::F64, ..engine };
        let program = Program::with_aim(&recording, &engine, Aim::Compact).unwrap();
        let words = [snapshots::<f64>(&problem, &settings).unwrap()];
        for module in MODULES {
            let made = validation_case(&program, &words, module, Format::Compressed);
            prop_assert!(made.is_ok(), "{:?}", made.err());
        }
        let compressed = program.compressed();
        for (k, segment) in program.segments.iter().enumerate() {
            let words = decompress(&compressed, k, &engine).unwrap();
            prop_assert_eq!(&words, &segment.schedule.issues);
        }
    }

    /// Making both programs at once, or streams of both kinds, saves time only.
    #[test]
    fn both_microcodes_at_once_are_those_of_two_programs(problem in problems(), engine in engines()) {
        let recording = record_tapes(&problem, &Settings::default()).unwrap();
        let stages = [Stage::Factorize, Stage::SolveConstantAndPredictor];
        let (fast, compact) = Program::both(&recording, &engine).unwrap();
        let (fast_stream, compact_stream) = Program::streams(&recording, &engine, &[stages.to_vec()], None).unwrap();
        for (aim, all, stream) in [(Aim::Fast, fast, fast_stream), (Aim::Compact, compact, compact_stream)] {
            let alone = Program::with_aim(&recording, &engine, aim).unwrap();
            let joined = Program::joined(&recording, &engine, aim, &stages, None).unwrap();
            for (one, other) in [(all, alone), (stream, joined)] {
                prop_assert_eq!(one.segments.len(), other.segments.len());
                for (one, other) in one.segments.iter().zip(&other.segments) {
                    prop_assert_eq!(one.name(), other.name());
                    prop_assert_eq!(one.start, other.start);
                    prop_assert_eq!(&one.schedule.issues, &other.schedule.issues);
                    prop_assert_eq!(one.schedule.causes, other.schedule.causes);
                }
            }
        }
    }

    #[test]
    fn bounds_stay_below_and_causes_add_up(problem in problems(), engine in engines()) {
        for segment in &program(&problem, &engine).segments {
            let schedule = &segment.schedule;
            prop_assert!(segment.schedule.bounds.cycles() <= schedule.cycles, "{}", segment.stage.name());
            prop_assert_eq!(schedule.causes.total(), schedule.cycles);
            prop_assert_eq!(schedule.slots.total(), schedule.cycles * engine.lanes as u32);
            prop_assert_eq!(schedule.slots.issue, schedule.lane_operations);
        }
    }

    /// List schedules have anomalies: without a conflict, every later choice may change. They stay below a tenth and,
    /// for short segments, below the depth of a lane.
    #[test]
    fn more_of_anything_is_never_much_slower(problem in problems(), engine in engines()) {
        let before = program(&problem, &engine);
        let larger = [
            Configuration { lanes: engine.lanes + 1, ..engine },
            Configuration { dividers: engine.dividers + 1, ..engine },
            Configuration { banks: 2 * engine.banks, ..engine },
        ];
        for engine in larger {
            for (less, more) in before.segments.iter().zip(&program(&problem, &engine).segments) {
                let (less, more) = (less.schedule.cycles, more.schedule.cycles);
                prop_assert!(more <= less + less / 10 + 17, "{less} {more} {engine:?}");
            }
        }
    }

    /// The machine replays the stream on the words of a solve before a case is written.
    #[test]
    fn stages_in_one_stream_make_their_words_in_no_more_time(problem in problems(), engine in engines()) {
        let settings = Settings::default();
        let recording = record_tapes(&problem, &settings).unwrap();
        let stages = [Stage::Factorize, Stage::SolveConstantAndPredictor];
        let leaves = [Buffer::FactorL, Buffer::PivotInverse, Buffer::MultiSolution];
        let of = |leaves| Program::joined(&recording, &engine, Aim::Fast, &stages, leaves).unwrap();
        let (all, some) = (of(None), of(Some(&leaves)));
        let separate = program(&problem, &engine);
        let separate: u32 =
            stages.iter().map(|&stage| separate.segment(stage).unwrap().schedule.cycles).sum();
        let cycles = |program: &Program| program.segments[0].schedule.cycles;
        prop_assert!(cycles(&all) <= separate + separate / 10, "{} {separate}", cycles(&all));
        let operations = |program: &Program| program.segments[0].schedule.issues.len();
        prop_assert!(operations(&some) <= operations(&all));
        let words = [snapshots::<f64>(&problem, &settings).unwrap()];
        if engine.precision == Precision::F64 {
            for program in [all, some] {
                let made = validation_case(&program, &words, Module::Factorization, Format::Flat);
                prop_assert!(made.is_ok_and(|text| text.contains("run factorize_solve_pair ")));
            }
        }
    }

    #[test]
    fn decompressed_words_are_the_schedule(problem in problems(), engine in engines()) {
        let program = program(&problem, &engine);
        let compressed = program.compressed();
        for (k, segment) in program.segments.iter().enumerate() {
            let words = decompress(&compressed, k, &engine).unwrap();
            prop_assert_eq!(&words, &segment.schedule.issues);
            let cost = compressed.segments[k];
            prop_assert_eq!(cost.cycles, segment.schedule.cycles + engine.timing().decode + cost.frozen);
            let freezes = &compressed.freezes[k];
            prop_assert_eq!(freezes.len(), cost.frozen as usize);
            prop_assert!(freezes.is_sorted() && freezes.iter().all(|&word| word < segment.schedule.words));
        }
    }

    #[test]
    fn waiting_in_order_takes_no_less_than_gaps_and_no_gap_costs_nothing_extra(
        problem in problems(), engine in engines(), seed in 1u32..u32::MAX,
    ) {
        for segment in &program(&problem, &engine).segments {
            let of = |level| run_in_order(&segment.schedule, Gaps { seed, level }, &engine);
            let (steady, gappy) = (of(0), of(128));
            prop_assert!(steady.cycles <= gappy.cycles, "{}", segment.stage.name());
            // The queue's first word comes a cycle late; nothing else is slower than planned.
            prop_assert!(steady.cycles <= segment.schedule.cycles + 1 + steady.hazard);
        }
    }
}

#[test]
fn the_same_stream_gives_the_same_schedule() {
    let problem = problem(3, 9, 3, 4, &[3, 6]);
    let engine = Configuration { address_bits: 13, ..Configuration::default() };
    let (one, two) = (program(&problem, &engine), program(&problem, &engine));
    assert_eq!(one.flat(), two.flat());
    assert_eq!(one.layout, two.layout);
}

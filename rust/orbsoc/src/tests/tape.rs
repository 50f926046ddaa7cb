//! A tape is its kernel: same words on every datapath, same reads and writes as declared, same counts.

use crate::kkt::structure::Structure;
use crate::method::datapath::Datapath;
use crate::real::{Latency, Opcode, OperationCounts, Value};
use crate::symbolic::supernodes::Panels;
use crate::tests::reference::{iterate_from_startup, mixed_problem, seeded, SplitMix64};
use crate::{
    operation_counts, record_tapes, Buffer, Compiled, Cones, Csc, Decide, Engine, Problem, Settings, Stage,
    Tape,
};
use proptest::prelude::*;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Equal words: the same bits, or no number both times (IEEE 754 leaves a NaN's payload open).
fn same<T: Decide>(a: T, b: T) -> bool {
    a.value().to_bits() == b.value().to_bits() || (a.value().is_nan() && b.value().is_nan())
}

/// Execute a tape on the words before its stage and compare with all words after it.
fn check<T: Decide>(tape: &Tape, before: impl Fn(Buffer) -> Vec<T>, after: impl Fn(Buffer) -> Vec<T>) {
    let words: Vec<Vec<T>> = Buffer::ALL.iter().map(|&buffer| before(buffer)).collect();
    let left = tape.execute(|buffer, k| words[buffer as usize][k]);
    let mut expected = words.clone();
    for (store, value) in tape.stores.iter().zip(left) {
        expected[store.buffer as usize][store.index as usize] = value;
    }
    for &buffer in Buffer::ALL {
        for (k, (found, expected)) in after(buffer).into_iter().zip(&expected[buffer as usize]).enumerate() {
            assert!(same(found, *expected), "{} {}[{k}]", tape.stage.name(), buffer.name());
        }
    }
}

/// The same pattern with other numbers.
fn other_numbers(problem: &Problem, seed: u64) -> Problem {
    let (mut numbers, mut other) = (SplitMix64(seed), problem.clone());
    let mut near =
        |values: &[f64]| values.iter().map(|v| v * (1.0 + 0.1 * numbers.signed())).collect::<Vec<_>>();
    other.set_a_values(&near(problem.a.values())).unwrap();
    other.set_g_values(&near(problem.g.values())).unwrap();
    other.set_p_values(&near(problem.p.values())).unwrap();
    other.set_c(&near(&problem.c)).unwrap();
    other.set_b(&near(&problem.b)).unwrap();
    other
}

/// Run `iterations` of a solve, comparing every stage of a module with its tape.
fn follow<T: Compiled>(recorded: &Problem, solved: &Problem, iterations: usize) -> HashSet<Stage> {
    let recording = record_tapes(recorded, &Settings::default()).unwrap();
    let mut engine = Engine::<T>::exact(solved, &Settings::default()).unwrap();
    iterate_from_startup(&mut engine, iterations);
    // Every stage once more, from wherever the solve stands: its words are as good as any.
    let mut seen = HashSet::new();
    for &stage in Stage::ALL {
        let before = engine.clone();
        // Without the loop's decision, which may note in the control buffer why it ends.
        engine.path.execute(stage);
        if let Some(tape) = recording.tape(stage) {
            seen.insert(stage);
            check(tape, |b| before.buffer(b).to_vec(), |b| engine.buffer(b).to_vec());
        }
    }
    seen
}

#[test]
fn tapes_make_the_kernels_words_on_other_data_than_recorded() {
    for seed in 0..6 {
        let problem = mixed_problem(seed);
        for iterations in [0, 1, 4] {
            let other = other_numbers(&problem, seed + 100);
            assert_eq!(follow::<f64>(&problem, &other, iterations).len(), Stage::ALL.len());
            follow::<f32>(&problem, &other, iterations);
        }
    }
}

proptest! {
    #![proptest_config(seeded(24))]

    /// Words that no solve would hold: any sizes, zeros of both signs, infinities, no numbers.
    #[test]
    fn tapes_make_the_kernels_words_on_any_words(seed in 0u64..1000, decades in 0.0..60.0f64, odd in 0.0..0.3f64) {
        let problem = mixed_problem(seed % 4);
        let recording = record_tapes(&problem, &Settings::default()).unwrap();
        let structure = Arc::new(Structure::new(&problem, crate::Ordering::Amd, Panels::Exact).unwrap());
        let mut path = Datapath::<f64>::new(structure.clone(), &Settings::default()).unwrap();
        let mut single = Datapath::<f32>::new(structure, &Settings::default()).unwrap();
        let mut numbers = SplitMix64(seed);
        let specials = [0.0, -0.0, f64::INFINITY, f64::NEG_INFINITY, f64::NAN];
        let mut draw = || {
            if numbers.unit() < odd {
                return specials[(numbers.bits() % 5) as usize];
            }
            numbers.signed() * 10f64.powf(decades * numbers.signed())
        };
        for tape in &recording.tapes {
            for &buffer in Buffer::ALL {
                path.work.get_mut(buffer).fill_with(&mut draw);
                for (word, &wide) in single.work.get_mut(buffer).iter_mut().zip(path.work.get(buffer)) {
                    word.set_lane(0, wide);
                }
            }
            let (before, single_before) = (path.clone(), single.clone());
            path.execute(tape.stage);
            single.execute(tape.stage);
            check(tape, |b| before.work.get(b).to_vec(), |b| path.work.get(b).to_vec());
            check(tape, |b| single_before.work.get(b).to_vec(), |b| single.work.get(b).to_vec());
        }
    }
}

#[test]
fn two_tapes_in_one_make_what_they_make_one_after_the_other() {
    let recording = record_tapes(&mixed_problem(2), &Settings::default()).unwrap();
    let tape = |stage| recording.tape(stage).unwrap();
    let both = tape(Stage::ScalingBlocks).then(tape(Stage::Factorize));
    let mut engine = Engine::<f64>::exact(&mixed_problem(2), &Settings::default()).unwrap();
    iterate_from_startup(&mut engine, 2);
    let before = engine.clone();
    engine.run(Stage::ScalingBlocks);
    engine.run(Stage::Factorize);
    check(&both, |b| before.buffer(b).to_vec(), |b| engine.buffer(b).to_vec());
}

/// Patterns of which each stage shows all of its reads in at least one.
fn patterns() -> Vec<Problem> {
    let rows = Csc::from_dense(&[&[-1.0], &[1.0]], 1);
    let linear =
        Problem::new(None, vec![1.0], None, vec![], Some(rows), vec![-1.0, 3.0], Cones { l: 2, q: vec![] });
    vec![mixed_problem(0), linear.unwrap()]
}

/// Buffers in an operand or in a store's value.
fn reads(tape: &Tape) -> HashSet<Buffer> {
    let operands = tape.operations.iter().flat_map(|o| [Some(o.a), o.b, o.c]).flatten();
    let stored = tape.stores.iter().map(|store| store.value);
    let buffer = |value| match value {
        Value::Word { buffer, .. } => Some(Buffer::ALL[usize::from(buffer)]),
        _ => None,
    };
    operands.chain(stored).filter_map(buffer).collect()
}

#[test]
fn what_tapes_read_and_write_is_what_the_table_declares() {
    let mut seen: HashMap<Stage, (HashSet<Buffer>, HashSet<Buffer>)> = HashMap::new();
    for problem in patterns() {
        let recording = record_tapes(&problem, &Settings::default()).unwrap();
        for tape in &recording.tapes {
            let (read, written) = seen.entry(tape.stage).or_default();
            read.extend(reads(tape));
            let mut stored: HashMap<Buffer, usize> = HashMap::new();
            tape.stores.iter().for_each(|store| *stored.entry(store.buffer).or_default() += 1);
            for (&buffer, &count) in &stored {
                written.insert(buffer);
                // A buffer of which words remain is updated, unless the table says that it stays unfinished;
                // the entries of L on and above the diagonal are never read.
                let whole = count == recording.words_of(buffer);
                let unfinished = tape.stage.stales().contains(&buffer) || buffer == Buffer::FactorL;
                if !whole && !unfinished {
                    read.insert(buffer);
                }
            }
        }
    }
    for (stage, (read, written)) in seen {
        let declared = |buffers: &[Buffer]| buffers.iter().copied().collect::<HashSet<_>>();
        assert_eq!(read, declared(stage.reads()), "reads of {}", stage.name());
        assert_eq!(written, declared(stage.writes()), "writes of {}", stage.name());
    }
}

#[test]
fn a_tape_has_the_operations_that_are_counted() {
    for problem in patterns() {
        let counted = operation_counts(&problem, &Settings::default(), Latency::UNIT).unwrap();
        let counted: HashMap<Stage, OperationCounts> =
            counted.into_iter().map(|(stage, tally)| (stage, tally.operations)).collect();
        for tape in &record_tapes(&problem, &Settings::default()).unwrap().tapes {
            assert_eq!(tallied(tape), counted[&tape.stage], "{}", tape.stage.name());
        }
    }
}

fn tallied(tape: &Tape) -> OperationCounts {
    let mut counts = OperationCounts::default();
    for operation in &tape.operations {
        *match operation.opcode {
            Opcode::Neg => &mut counts.neg,
            Opcode::Abs => &mut counts.abs,
            Opcode::Mul => &mut counts.mul,
            Opcode::Add => &mut counts.add,
            Opcode::Sub => &mut counts.sub,
            Opcode::AddMul => &mut counts.add_mul,
            Opcode::SubMul => &mut counts.sub_mul,
            Opcode::Div => &mut counts.div,
            Opcode::Sqrt => &mut counts.sqrt,
            Opcode::Min => &mut counts.min,
            Opcode::Max => &mut counts.max,
            Opcode::Compare => &mut counts.compare,
            Opcode::And => &mut counts.and,
            Opcode::Select => &mut counts.select,
        } += 1;
    }
    counts
}

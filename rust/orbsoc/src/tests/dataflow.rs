//! The dataflow table against reality: what a stage does not declare, it neither reads nor writes.

use crate::tests::reference::mixed_problem;
use crate::{
    Buffer, Engine, Outcome, Settings, Stage, Start, Step, CLOSING, ITERATION, STARTUP, WARM_STARTUP,
};
use std::collections::HashSet;

/// Run every stage of a solve once by `look`, with the engine as it stands before the stage.
fn at_every_stage(seed: u64, mut look: impl FnMut(&Engine<f64>, Stage)) {
    // Both bounds on a solve's error are active somewhere.
    let settings = Settings { refinement_share: 1e-8, refinement_tol: 1e-12, ..Settings::default() };
    let mut engine = Engine::<f64>::new(&mixed_problem(seed), &settings).unwrap();
    attempt(&mut engine, STARTUP, &mut look);
    let mut near = engine.conclude();
    near.x.iter_mut().for_each(|x| *x *= 1.01);
    assert!(engine.start_from(&Start::from(&near)).unwrap());
    attempt(&mut engine, WARM_STARTUP, &mut look);
}

fn attempt(engine: &mut Engine<f64>, startup: &[Step], look: &mut impl FnMut(&Engine<f64>, Stage)) {
    let mut run = |stage| {
        look(engine, stage);
        engine.run(stage)
    };
    assert!(startup.iter().all(|step| step.perform(&mut run) == Outcome::Next));
    while ITERATION.iter().all(|step| step.perform(&mut run) == Outcome::Next) {}
    // Once more, where nothing is better than what was kept.
    run(Stage::Statistics);
    assert!(CLOSING.iter().all(|step| step.perform(&mut run) == Outcome::Next));
}

fn bits(engine: &Engine<f64>, buffer: Buffer) -> Vec<u64> {
    engine.buffer(buffer).iter().map(|entry| entry.to_bits()).collect()
}

fn poison(engine: &mut Engine<f64>, which: impl Fn(Buffer) -> bool) {
    for &buffer in Buffer::ALL {
        if which(buffer) {
            engine.path.work.get_mut(buffer).fill(f64::NAN);
        }
    }
    engine.path.work.scratch.fill(f64::NAN);
}

/// The entries of a buffer that mean something: of a panel of L, those below the diagonal.
fn used(engine: &Engine<f64>, buffer: Buffer) -> Vec<u64> {
    let mut entries = bits(engine, buffer);
    if buffer == Buffer::FactorL {
        let symbolic = &engine.path.structure.kkt.symbolic;
        for node in symbolic.supernodes.iter().filter(|node| node.stored_entries() > 0) {
            for column in 0..node.width {
                let begin = symbolic.column_begin(node, node.first + column);
                entries[begin..=begin + column % node.diagonal_size].fill(0);
            }
        }
    }
    entries
}

/// Buffers that keep what they hold until something better comes along.
const KEPT: [Buffer; 3] = [Buffer::Best, Buffer::PrimalCertificate, Buffer::DualCertificate];

#[test]
fn stages_touch_only_what_they_declare() {
    let mut seen = HashSet::new();
    at_every_stage(0, |before, stage| {
        seen.insert(stage);
        let (reads, writes) = (stage.reads(), stage.writes());
        let (mut plain, mut poisoned) = (before.clone(), before.clone());
        poison(&mut poisoned, |buffer| !reads.contains(&buffer) && !writes.contains(&buffer));
        let untouched = poisoned.clone();
        assert_eq!(plain.run(stage), poisoned.run(stage), "{}", stage.name());
        for &buffer in Buffer::ALL {
            let names = (stage.name(), buffer.name());
            if writes.contains(&buffer) {
                let same = bits(&poisoned, buffer) == bits(&plain, buffer);
                assert!(same, "{names:?} depends on an undeclared read");
            } else {
                let kept = |now: &Engine<f64>, then: &Engine<f64>| bits(now, buffer) == bits(then, buffer);
                let untouched = kept(&poisoned, &untouched) && kept(&plain, before);
                assert!(untouched, "{names:?} is an undeclared write");
            }
        }
    });
    assert_eq!(seen.len(), Stage::ALL.len(), "every stage ran");
}

#[test]
fn what_a_stage_writes_and_does_not_read_it_writes_whole() {
    at_every_stage(1, |before, stage| {
        let (mut plain, mut poisoned) = (before.clone(), before.clone());
        // What it makes stale, too, is left unfinished, as declared.
        let partly = [stage.reads(), stage.stales(), &KEPT].concat();
        poison(&mut poisoned, |buffer| stage.writes().contains(&buffer) && !partly.contains(&buffer));
        assert_eq!(plain.run(stage), poisoned.run(stage), "{}", stage.name());
        for &buffer in stage.writes() {
            let names = (stage.name(), buffer.name());
            assert!(used(&poisoned, buffer) == used(&plain, buffer), "{names:?} keeps old words");
        }
    });
}

/// An idle read would be paid for in every transfer.
#[test]
fn what_a_stage_declares_to_read_it_needs() {
    let mut stalled_iterations: HashSet<(Stage, Buffer)> = Stage::ALL
        .iter()
        .flat_map(|&stage| stage.reads().iter().map(move |&buffer| (stage, buffer)))
        .collect();
    let mut look = |before: &Engine<f64>, stage: Stage| {
        for &buffer in stage.reads() {
            let (mut plain, mut poisoned) = (before.clone(), before.clone());
            poison(&mut poisoned, |other| other == buffer);
            let differs = plain.run(stage) != poisoned.run(stage)
                || stage.writes().iter().any(|&written| bits(&plain, written) != bits(&poisoned, written));
            if differs {
                stalled_iterations.remove(&(stage, buffer));
            }
        }
    };
    (0..3).for_each(|seed| at_every_stage(seed, &mut look));
    let names: Vec<_> =
        stalled_iterations.iter().map(|(stage, buffer)| (stage.name(), buffer.name())).collect();
    assert!(names.is_empty(), "read and never used: {names:?}");
}

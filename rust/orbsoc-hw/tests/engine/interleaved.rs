//! Problems of one pattern in one stream, whole attempts on the machine that checks every rule.

use crate::problem::problem;
use orbsoc::{record_tapes, Buffer, Csc, Engine, Flag, Module, Outcome, Problem, Settings, Stage, Step};
use orbsoc::{CLOSING, ITERATION, STARTUP};
use orbsoc_hw::{
    flat, interleaved, snapshots, validation_case, Configuration, Error, Format, Machine, Program,
};

/// The machine, and what the operation control does: it runs segments and reads one flag of all copies.
struct Attempt {
    program: Program,
    machine: Machine,
    copies: usize,
    words: Vec<usize>,
}

impl Attempt {
    fn new(engines: &[Engine<f64>], problem: &Problem, configuration: &Configuration) -> Self {
        let recording = record_tapes(problem, &Settings::default()).unwrap();
        let copies = engines.len();
        let program = Program::new(&interleaved(&recording, copies as u32), configuration).unwrap();
        let mut machine = Machine::new(configuration);
        for (value, address) in program.layout.constants() {
            machine.load(address, value.to_bits());
        }
        for (buffer, index, address) in program.layout.locations() {
            let (entry, copy) = (index as usize / copies, index as usize % copies);
            let word = engines[copy].buffer(buffer).get(entry);
            machine.load(address, word.map_or(0, |word| word.to_bits()));
        }
        Self { program, machine, copies, words: recording.words }
    }

    fn run(&mut self, stage: Stage) {
        let segment = self.program.segment(stage).unwrap();
        let words = flat(&segment.schedule, &self.program.configuration);
        assert_eq!(self.machine.run(&words, 0).unwrap(), segment.schedule.cycles, "{}", stage.name());
    }

    fn word(&self, buffer: Buffer, index: usize) -> Option<u64> {
        self.program.layout.location(buffer, index as u32).and_then(|address| self.machine.word(address))
    }

    fn raised(&self, stage: Stage) -> bool {
        let Some(Flag::Stop(buffer) | Flag::Repeat(buffer)) = stage.flag() else { return false };
        self.word(buffer, self.words[buffer as usize] * self.copies) != Some(0)
    }

    fn solve(&mut self) {
        let mut steps: Vec<Step> = STARTUP.to_vec();
        'attempt: loop {
            for step in steps {
                match step {
                    Step::Run(stage) => {
                        self.run(stage);
                        if self.raised(stage) {
                            break 'attempt;
                        }
                    }
                    Step::Repeat { stage, until } => {
                        self.run(until);
                        while self.raised(until) {
                            self.run(stage);
                            self.run(until);
                        }
                    }
                }
            }
            steps = ITERATION.to_vec();
        }
        self.run(Stage::Unscale);
    }
}

fn solved(mut engine: Engine<f64>) -> Engine<f64> {
    let mut perform = |steps: &[Step]| {
        steps.iter().all(|step| !matches!(step.perform(&mut |stage| engine.run(stage)), Outcome::Done(_)))
    };
    perform(STARTUP);
    while perform(ITERATION) {}
    perform(CLOSING);
    engine
}

/// The same matrices with another cost, offsets far from it, or none that is feasible.
fn problems() -> Vec<Problem> {
    let first = problem(7, 6, 1, 3, &[4, 3]);
    let other = |cost: f64, offset: f64| {
        let scaled = |values: &[f64], by: f64| values.iter().map(|value| value * by).collect();
        let (a, g) = (first.a().clone(), first.g().clone());
        let rows: Vec<Vec<f64>> =
            (0..6).map(|i| (0..6).map(|j| if i == j { 0.5 } else { 0.0 }).collect()).collect();
        let p = Csc::from_dense(&rows.iter().map(Vec::as_slice).collect::<Vec<_>>(), 6);
        let (c, b, h) = (scaled(first.c(), cost), first.b().to_vec(), scaled(first.h(), offset));
        Problem::new(Some(p), c, Some(a), b, Some(g), h, first.cones().clone()).unwrap()
    };
    vec![first.clone(), other(1e3, 1.0), other(-2.0, 40.0), other(1.0, -30.0)]
}

#[test]
fn every_copy_ends_with_the_words_of_its_own_solve() {
    let settings = Settings::default();
    let problems = problems();
    let engines: Vec<Engine<f64>> =
        problems.iter().map(|problem| Engine::exact(problem, &settings).unwrap()).collect();
    let configuration =
        Configuration { lanes: 8, dividers: 2, clusters: 4, banks: 32, ..Configuration::default() };
    let mut together = Attempt::new(&engines, &problems[0], &configuration);
    together.solve();
    let alone: Vec<Engine<f64>> = engines.into_iter().map(solved).collect();
    let outcome = [
        Buffer::Control,
        Buffer::Best,
        Buffer::PrimalCertificate,
        Buffer::DualCertificate,
        Buffer::UnscaledIterate,
        Buffer::UnscaledCertificates,
    ];
    for (copy, engine) in alone.iter().enumerate() {
        for buffer in outcome {
            for (index, value) in engine.buffer(buffer).iter().enumerate() {
                if let Some(found) = together.word(buffer, index * together.copies + copy) {
                    assert_eq!(found, value.to_bits(), "copy {copy}, {}[{index}] {value}", buffer.name());
                }
            }
        }
    }
    let stops: Vec<f64> = alone.iter().map(|engine| engine.buffer(Buffer::Control)[0]).collect();
    let iterations: Vec<usize> = alone.iter().map(|engine| engine.events().len()).collect();
    assert!(iterations.iter().any(|&n| n != iterations[0]), "all end at once: {iterations:?}");
    assert!(stops.iter().any(|&stop| stop.to_bits() != stops[0].to_bits()), "one reason: {stops:?}");
}

#[test]
fn a_case_has_the_words_of_as_many_solves_as_the_program_interleaves() {
    let settings = Settings::default();
    let problems = problems();
    let recording = record_tapes(&problems[0], &settings).unwrap();
    let program = Program::new(&interleaved(&recording, 3), &Configuration::default()).unwrap();
    let solves: Vec<_> =
        problems[..3].iter().map(|problem| snapshots::<f64>(problem, &settings).unwrap()).collect();
    for module in [Module::ConeOps, Module::Statistics] {
        validation_case(&program, &solves, module, Format::Flat).unwrap();
    }
    for fewer in [1, 2] {
        let error = validation_case(&program, &solves[..fewer], Module::ConeOps, Format::Flat).unwrap_err();
        assert!(matches!(error, Error::Pattern { found, expected, .. } if found < expected), "{error}");
    }
    assert_eq!(interleaved(&recording, 1).words, recording.words);
}

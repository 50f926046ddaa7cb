//! Validation cases: the files that compare a schedule with the RTL; docs/pl-machine.md, "Validation cases".

use super::copies::Copies;
use super::in_order::{run_in_order, Gaps};
use super::machine::{Fault, Machine};
use super::snapshots::Snapshots;
use crate::error::Error;
use crate::machine::configuration::Configuration;
use crate::machine::timing::Precision;
use crate::microcode::compressed::Compressed;
use crate::microcode::flat::{flat, Microcode};
use crate::program::{Program, Segment};
use crate::stream::interleaved::length;
use core::fmt::Write;
use orbsoc::{Buffer, Compiled, Engine, Module};

/// The format of the microcode, and the sequencer that runs it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Format {
    Flat,
    Compressed,
    InOrder(Gaps),
}

/// One segment's run: storage before and after.
struct Run<'a> {
    segment: &'a Segment,
    memory: Vec<(u32, u64)>,
    expect: Vec<(u32, u64)>,
}

/// A case that runs every stage of a module on the words of a solve, or of as many solves as the program's streams
/// interleave. The simulator must reproduce the words of the solver first; an error says what differs.
///
/// # Errors
/// [`Error::Damaged`] if the microcode breaks a rule or computes another word than the kernel; [`Error::Configuration`]
/// as [`Gaps::validate`].
pub fn validation_case<T: Compiled>(
    program: &Program,
    solves: &[Snapshots<T>],
    module: Module,
    format: Format,
) -> Result<String, Error> {
    if let Format::InOrder(gaps) = format {
        gaps.validate()?;
        program.configuration.require_in_order()?;
    }
    let mut sequence = Sequence::new(program, format);
    let mut runs = Vec::new();
    for (number, segment) in program.segments.iter().enumerate() {
        if segment.stage.module() != module {
            continue;
        }
        let before = solves.iter().map(|solve| solve.before(&segment.stages())).collect::<Option<Vec<_>>>();
        let Some(before) = before else { continue };
        let words = flat(&segment.schedule, &program.configuration);
        let run = run(program, segment, &before, &words)?;
        runs.push((sequence.append(number, segment, &words), run));
    }
    Ok(text(&program.configuration, &sequence, &runs))
}

/// Concatenated microcode of segments.
pub(crate) struct Sequence {
    configuration: Configuration,
    format: Format,
    pub compressed: Option<Compressed>,
    pub microcode: Microcode,
}

/// Position of a segment's microcode, and its busy cycles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub struct Entry {
    pub start: usize,
    pub words: usize,
    pub cycles: u32,
}

impl Sequence {
    pub fn new(program: &Program, format: Format) -> Self {
        let compressed = (format == Format::Compressed).then(|| program.compressed());
        let bits = compressed.as_ref().map_or(program.configuration.flat_bits(), |c| c.lines.bits());
        let configuration = program.configuration;
        Self { configuration, format, compressed, microcode: Microcode::new(bits, 0) }
    }

    pub fn append(&mut self, number: usize, segment: &Segment, words: &Microcode) -> Entry {
        let start = self.microcode.len();
        let cycles = match (self.format, &self.compressed) {
            (Format::InOrder(gaps), _) => {
                self.microcode.append(&without_empty_words(words, segment));
                run_in_order(&segment.schedule, gaps, &self.configuration).cycles
            }
            (_, Some(compressed)) => {
                let part = compressed.segments[number];
                self.microcode.append(&compressed.lines.range(part.start, part.lines));
                part.cycles
            }
            (_, None) => {
                self.microcode.append(words);
                segment.schedule.cycles
            }
        };
        Entry { start, words: self.microcode.len() - start, cycles }
    }
}

/// The words that issue something, the last one marked.
fn without_empty_words(words: &Microcode, segment: &Segment) -> Microcode {
    let mut cycles: Vec<usize> = segment.schedule.issues.iter().map(|issue| issue.cycle as usize).collect();
    cycles.dedup();
    words.select(&cycles)
}

fn run<'a, T: Compiled>(
    program: &Program,
    segment: &'a Segment,
    before: &[&Engine<T>],
    words: &Microcode,
) -> Result<Run<'a>, Error> {
    before.iter().try_for_each(|engine| same_pattern(program, engine, before.len()))?;
    let mut copies = Copies::new(before);
    let before = copies.words();
    let configuration = &program.configuration;
    let damaged = |detail: String| Error::Damaged { word: 0, detail };
    let name = segment.name();
    let bits = |value: f64| word_bits(configuration.precision, value);
    let mut machine = Machine::new(configuration);
    let mut memory: Vec<(u32, u64)> =
        program.layout.constants().map(|(value, address)| (address, bits(value))).collect();
    for (buffer, index, address) in program.layout.locations() {
        memory.push((address, bits(before[buffer as usize][index as usize])));
    }
    for &(address, word) in &memory {
        machine.load(address, word);
    }
    let cycles = machine.run(words, 0).map_err(|fault| match fault {
        Fault::Violation(violation) => damaged(format!("{name}: {violation}")),
        Fault::Damaged(error) => error,
    })?;
    if cycles != segment.schedule.cycles {
        return Err(damaged(format!("{name}: {cycles} cycles, not {}", segment.schedule.cycles)));
    }
    segment.stages().into_iter().for_each(|stage| copies.run(stage));
    let after = copies.words();
    for (buffer, index, address) in program.layout.locations() {
        let left = segment.leaves.as_ref().is_none_or(|buffers| buffers.contains(&buffer));
        let words = if left { &after } else { &before };
        let expected = words[buffer as usize][index as usize];
        let found = machine.word(address);
        if found != Some(bits(expected))
            && !(expected.is_nan() && found.is_some_and(|f| is_nan(configuration, f)))
        {
            let detail = format!("{name}: {}[{index}] is {found:x?}, not {expected}", buffer.name());
            return Err(damaged(detail));
        }
    }
    let written = (0..configuration.words() as u32).filter_map(|a| machine.word(a).map(|word| (a, word)));
    Ok(Run { segment, memory, expect: written.collect() })
}

/// Check that the words are those of the program's pattern, in streams of as many problems.
fn same_pattern<T: Compiled>(program: &Program, engine: &Engine<T>, copies: usize) -> Result<(), Error> {
    for &buffer in Buffer::ALL {
        let found = length(buffer, engine.buffer(buffer).len(), copies);
        let expected = program.layout.words_of(buffer);
        if found != expected {
            return Err(Error::Pattern { buffer: buffer.name(), found, expected });
        }
    }
    match program.problem.same_pattern(engine.problem()) {
        Err(orbsoc::Error::PatternChanged { argument }) => Err(Error::OtherPattern { part: argument }),
        _ => Ok(()),
    }
}

/// The bits of a value; those of a single-precision solve are exact in binary32.
pub(crate) fn word_bits(precision: Precision, value: f64) -> u64 {
    match precision {
        Precision::F64 => value.to_bits(),
        Precision::F32 => u64::from((value as f32).to_bits()),
    }
}

fn is_nan(configuration: &Configuration, word: u64) -> bool {
    match configuration.precision {
        Precision::F64 => f64::from_bits(word).is_nan(),
        Precision::F32 => f32::from_bits(word as u32).is_nan(),
    }
}

fn text(configuration: &Configuration, sequence: &Sequence, runs: &[(Entry, Run<'_>)]) -> String {
    let Configuration { precision, lanes, dividers, banks, clusters, address_bits, .. } = *configuration;
    let mut out = String::new();
    let fp = precision.bits();
    let name = match sequence.format {
        Format::Flat => "flat",
        Format::Compressed => "compressed",
        Format::InOrder(_) => "in_order",
    };
    let mut line = |text: String| writeln!(out, "{text}").expect("writing to a string");
    line("orbsoc-pl-case 1".to_owned());
    line(format!(
        "config fp {fp} lanes {lanes} dividers {dividers} banks {banks} clusters {clusters} address_bits {address_bits}"
    ));
    line(format!("format {name}"));
    if let Some(compressed) = &sequence.compressed {
        line(format!("templates {}", compressed.templates().count()));
        compressed.templates().for_each(&mut line);
    }
    let microcode = &sequence.microcode;
    line(format!("microcode {}", microcode.len()));
    (0..microcode.len()).for_each(|word| line(microcode.hex(word)));
    for (Entry { start, words, cycles }, run) in runs {
        line(format!("run {} start {start} words {words} cycles {cycles}", run.segment.name()));
        if let Format::InOrder(gaps) = sequence.format {
            line(format!("gaps seed {} level {}", gaps.seed, gaps.level));
        }
        let digits = fp as usize / 4;
        for (title, list) in [("memory", &run.memory), ("expect", &run.expect)] {
            line(format!("{title} {}", list.len()));
            for (address, word) in list {
                line(format!("{address:x} {word:0digits$x}"));
            }
        }
        line("end".to_owned());
    }
    out
}

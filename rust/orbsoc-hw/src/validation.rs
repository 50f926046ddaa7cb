//! The file in which a schedule meets the RTL; docs/pl-machine.md, "Validation cases".

use crate::configuration::Configuration;
use crate::error::Error;
use crate::in_order::{run_in_order, Gaps};
use crate::machine::{Fault, Machine};
use crate::microcode::{flat, Microcode};
use crate::program::{Program, Segment};
use crate::snapshots::Snapshot;
use crate::timing::Precision;
use core::fmt::Write;
use orbsoc::{Buffer, Decide, Module, Stage};
use std::collections::HashMap;

/// Which sequencer runs the microcode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Format {
    Flat,
    InOrder(Gaps),
}

/// One segment's run: words before, words after, cycles.
struct Run<'a> {
    segment: &'a Segment,
    memory: Vec<(u32, u64)>,
    expect: Vec<(u32, u64)>,
    cycles: u32,
}

/// A case that runs every stage of a module on the words of a solve, or an error that says what differs: the machine
/// in Rust must make the engine's words before the RTL is asked.
///
/// # Errors
/// [`Error::Damaged`] if the microcode breaks a rule or makes another word than the kernel.
pub fn validation_case<T: Decide>(
    program: &Program,
    snapshots: &HashMap<Stage, Snapshot<T>>,
    module: Module,
    format: Format,
) -> Result<String, Error> {
    let mut microcode = Microcode::new(program.configuration.flat_bits(), 0);
    let mut runs = Vec::new();
    for segment in program.segments.iter().filter(|segment| segment.stage.module() == module) {
        let Some(snapshot) = snapshots.get(&segment.stage) else { continue };
        let start = microcode.len();
        let words = flat(&segment.schedule, &program.configuration);
        let run = run(program, segment, snapshot, &words)?;
        match format {
            Format::Flat => microcode.append(&words),
            Format::InOrder(_) => microcode.append(&without_empty_words(&words, segment)),
        }
        runs.push((start, microcode.len() - start, run));
    }
    Ok(text(&program.configuration, format, &microcode, &runs))
}

/// The words that issue something, the last one marked.
fn without_empty_words(words: &Microcode, segment: &Segment) -> Microcode {
    let mut cycles: Vec<usize> = segment.schedule.issues.iter().map(|issue| issue.cycle as usize).collect();
    cycles.dedup();
    words.select(&cycles)
}

fn run<'a, T: Decide>(
    program: &Program,
    segment: &'a Segment,
    snapshot: &Snapshot<T>,
    words: &Microcode,
) -> Result<Run<'a>, Error> {
    let configuration = &program.configuration;
    let damaged = |detail: String| Error::Damaged { word: 0, detail };
    let name = segment.stage.name();
    let bits = |value: f64| word_bits(configuration.precision, value);
    let mut machine = Machine::new(configuration);
    let mut memory: Vec<(u32, u64)> =
        program.layout.constants().map(|(value, address)| (address, bits(value))).collect();
    for (buffer, index, address) in program.layout.homes() {
        memory.push((address, bits(word(snapshot.before(buffer), buffer, index)?)));
    }
    memory.iter().for_each(|&(address, word)| machine.load(address, word));
    let cycles = machine.run(words, 0).map_err(|fault| match fault {
        Fault::Violation(violation) => damaged(format!("{name}: {violation}")),
        Fault::Damaged(error) => error,
    })?;
    if cycles != segment.schedule.cycles {
        return Err(damaged(format!("{name}: {cycles} cycles, not {}", segment.schedule.cycles)));
    }
    for (buffer, index, address) in program.layout.homes() {
        let expected = word(snapshot.after(buffer), buffer, index)?;
        let found = machine.word(address);
        if found != Some(bits(expected))
            && !(expected.is_nan() && found.is_some_and(|f| is_nan(configuration, f)))
        {
            let detail = format!("{name}: {}[{index}] is {found:x?}, not {expected}", buffer.name());
            return Err(damaged(detail));
        }
    }
    let written = (0..configuration.words() as u32).filter_map(|a| machine.word(a).map(|word| (a, word)));
    Ok(Run { segment, memory, expect: written.collect(), cycles })
}

fn word<T: Decide>(words: &[T], buffer: Buffer, index: u32) -> Result<f64, Error> {
    words.get(index as usize).map(|word| word.value()).ok_or(Error::Pattern {
        buffer: buffer.name(),
        found: words.len(),
        expected: index as usize + 1,
    })
}

#[allow(clippy::cast_possible_truncation)] // words of a single-precision solve are binary32 numbers
fn word_bits(precision: Precision, value: f64) -> u64 {
    match precision {
        Precision::F64 => value.to_bits(),
        Precision::F32 => u64::from((value as f32).to_bits()),
    }
}

#[allow(clippy::cast_possible_truncation)]
fn is_nan(configuration: &Configuration, word: u64) -> bool {
    match configuration.precision {
        Precision::F64 => f64::from_bits(word).is_nan(),
        Precision::F32 => f32::from_bits(word as u32).is_nan(),
    }
}

fn text(
    configuration: &Configuration,
    format: Format,
    microcode: &Microcode,
    runs: &[(usize, usize, Run<'_>)],
) -> String {
    let Configuration { precision, lanes, dividers, banks, address_bits, .. } = *configuration;
    let mut out = String::new();
    let fp = precision.bits();
    let name = match format {
        Format::Flat => "flat",
        Format::InOrder(_) => "in_order",
    };
    let mut line = |text: String| writeln!(out, "{text}").expect("writing to a string");
    line("orbsoc-pl-case 1".to_owned());
    line(format!(
        "config fp {fp} lanes {lanes} dividers {dividers} banks {banks} address_bits {address_bits}"
    ));
    line(format!("format {name}"));
    line(format!("microcode {}", microcode.len()));
    (0..microcode.len()).for_each(|word| line(microcode.hex(word)));
    for (start, words, run) in runs {
        let cycles = match format {
            Format::Flat => run.cycles,
            Format::InOrder(gaps) => run_in_order(&run.segment.schedule, gaps, configuration).cycles,
        };
        line(format!("run {} start {start} words {words} cycles {cycles}", run.segment.stage.name()));
        if let Format::InOrder(gaps) = format {
            line(format!("gaps seed {} level {}", gaps.seed, gaps.level));
        }
        let digits = fp as usize / 4;
        for (title, list) in [("memory", &run.memory), ("expect", &run.expect)] {
            line(format!("{title} {}", list.len()));
            list.iter().for_each(|(address, word)| line(format!("{address:x} {word:0digits$x}")));
        }
        line("end".to_owned());
    }
    out
}

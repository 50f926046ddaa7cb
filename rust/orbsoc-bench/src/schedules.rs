//! Speed of the schedulers of the programmable logic, by number of lanes.

use crate::arguments::Plan;
use crate::failure::Failure;
use crate::spread::{microseconds, Spread};
use orbsoc::{record_tapes, Module, Problem, Recording, Settings};
use orbsoc_hw::{schedule, Compressed, Configuration, Graph, Layout, Microcode, Program};
use std::fmt::Write;
use std::time::Instant;

const LANES: [usize; 4] = [1, 2, 4, 8];
const LEAST_ADDRESS_BITS: u32 = 10;
const MOST_ADDRESS_BITS: u32 = 20;

/// One problem on one engine.
pub struct Row {
    problem: String,
    lanes: usize,
    /// Of all stages.
    operations: usize,
    /// Microseconds of the scheduler alone.
    schedule: Spread,
    /// Microseconds of a program: layout, graphs and schedules for the fewest cycles.
    program: Spread,
    /// Microseconds of that and of the compressed program, for which several policies are tried.
    both: Spread,
    /// Hash of all microcode, flat and compressed.
    fingerprint: u64,
}

/// Schedule every stage of every problem `plan.repeats` times, engines interleaved.
pub fn measure(problems: &[(String, Problem)], plan: &Plan) -> Result<Vec<Row>, Failure> {
    let settings = Settings { tol: plan.tol, ..Settings::default() };
    let mut rows = Vec::new();
    for (name, problem) in problems {
        let recording = record_tapes(problem, &settings).map_err(|e| format!("{name}: {e}"))?;
        let recording = recording.only(|stage| stage.module() != Module::Statistics);
        let engines: Vec<Configuration> =
            LANES.iter().map(|&lanes| fitting(&recording, lanes)).collect::<Result<_, _>>()?;
        let mut times = vec![[Vec::new(), Vec::new(), Vec::new()]; engines.len()];
        let (mut operations, mut fingerprints) = (0, vec![0; engines.len()]);
        for _ in 0..plan.repeats {
            for ((engine, [schedules, programs, boths]), print) in
                engines.iter().zip(&mut times).zip(&mut fingerprints)
            {
                let (count, time) = schedule_all(&recording, engine)?;
                operations = count;
                schedules.push(time);
                let start = Instant::now();
                Program::new(&recording, engine).map_err(|e| format!("{name}: {e}"))?;
                programs.push(microseconds(start));
                let start = Instant::now();
                let (fast, compact) =
                    Program::both(&recording, engine).map_err(|e| format!("{name}: {e}"))?;
                let compressed = compact.compressed();
                boths.push(microseconds(start));
                *print = fingerprint(&fast, &compressed);
            }
        }
        for ((engine, [schedules, programs, boths]), fingerprint) in
            engines.iter().zip(&times).zip(fingerprints)
        {
            rows.push(Row {
                problem: name.clone(),
                lanes: engine.lanes,
                operations,
                schedule: Spread::of(schedules),
                program: Spread::of(programs),
                both: Spread::of(boths),
                fingerprint,
            });
        }
    }
    Ok(rows)
}

/// The engine with the least storage that holds a pattern.
fn fitting(recording: &Recording, lanes: usize) -> Result<Configuration, Failure> {
    let engine = |address_bits| Configuration { lanes, address_bits, ..Configuration::default() };
    (LEAST_ADDRESS_BITS..MOST_ADDRESS_BITS)
        .map(engine)
        .find(|engine| Program::new(recording, engine).is_ok())
        .map_or_else(|| Program::new(recording, &engine(MOST_ADDRESS_BITS)).map(|p| p.configuration), Ok)
        .map_err(|e| e.to_string())
}

/// Operations of all stages, and microseconds of their scheduling.
fn schedule_all(recording: &Recording, engine: &Configuration) -> Result<(usize, f64), Failure> {
    let layout = Layout::new(recording, engine).map_err(|e| e.to_string())?;
    let graphs: Vec<_> =
        recording.tapes.iter().map(|tape| (tape.stage.name(), Graph::new(tape, &layout, engine))).collect();
    let start = Instant::now();
    for (stage, graph) in &graphs {
        schedule(stage, graph, &layout, engine).map_err(|e| e.to_string())?;
    }
    let time = microseconds(start);
    Ok((graphs.iter().map(|(_, graph)| graph.nodes.len()).sum(), time))
}

/// FNV-1a over the words of the flat and the lines of the compressed microcode.
fn fingerprint(fast: &Program, compressed: &Compressed) -> u64 {
    let limbs = |microcode: &Microcode| {
        let fields = |word: usize| (0..microcode.bits()).step_by(32).map(move |from| (word, from));
        let all = (0..microcode.len()).flat_map(fields);
        let limb = |(word, from)| microcode.get(word, from, 32.min(microcode.bits() - from));
        all.map(limb).collect::<Vec<_>>()
    };
    let fold = |sum: u64, limb: u64| (sum ^ limb).wrapping_mul(0x0100_0000_01b3);
    let all = limbs(&fast.flat()).into_iter().chain(limbs(&compressed.lines));
    all.fold(0xcbf2_9ce4_8422_2325, fold)
}

/// Millions of operations a second, medians; quartiles of the scheduler alone.
pub fn table(rows: &[Row]) -> String {
    let mut out = format!(
        "{:<32} {:>5} {:>10} {:>10} {:>15} {:>10} {:>10} {:>18}\n",
        "problem", "lanes", "operations", "scheduler", "(quartiles)", "program", "both", "fingerprint"
    );
    for row in rows {
        let speed = |time: f64| row.operations as f64 / time;
        let quartiles = format!("({:.2} {:.2})", speed(row.schedule.q3), speed(row.schedule.q1));
        let _ = writeln!(
            out,
            "{:<32} {:>5} {:>10} {:>10.2} {quartiles:>15} {:>10.2} {:>10.2}   {:016x}",
            row.problem,
            row.lanes,
            row.operations,
            speed(row.schedule.median),
            speed(row.program.median),
            speed(row.both.median),
            row.fingerprint,
        );
    }
    out.push_str("millions of operations a second, one core\n");
    out
}

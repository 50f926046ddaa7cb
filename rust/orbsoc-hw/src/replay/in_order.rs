//! The in-order engine: it issues the same words with a scoreboard, and its fetch has gaps.
//! docs/pl-machine.md, "In-order sequencer".

use crate::error::Error;
use crate::machine::configuration::Configuration;
use crate::schedule::scheduler::{Issue, Schedule};

/// Gaps of the fetch: in each cycle one with probability `level`/256, from a seeded generator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub struct Gaps {
    pub seed: u32,
    pub level: u32,
}

impl Gaps {
    /// No gaps.
    pub const NONE: Self = Self { seed: 1, level: 0 };

    /// # Errors
    /// [`Error::Configuration`] if fetch would never deliver: the generator stays at a `seed` of 0, and no number of
    /// it reaches a `level` above 255.
    pub fn validate(&self) -> Result<(), Error> {
        let wrong =
            |field, value: u32, allowed| Err(Error::Configuration { field, value: value.into(), allowed });
        match *self {
            Self { seed: 0, .. } => wrong("seed", 0, "1 to 2^32 - 1"),
            Self { level: level @ 256.., .. } => wrong("level", level, "0 to 255"),
            Self { .. } => Ok(()),
        }
    }
}

/// Cycles of a run, by cause.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dynamic {
    /// Cycles for which the engine is busy.
    pub cycles: u32,
    /// Cycles in which a word was issued.
    pub issue: u32,
    /// The head of the queue had a hazard.
    pub hazard: u32,
    /// The queue was empty.
    pub fetch: u32,
}

/// The cycles of a schedule's words, issued in order, each as soon as it has no hazard.
///
/// Terminates for gaps that [`Gaps::validate`] allows.
pub fn run_in_order(schedule: &Schedule, gaps: Gaps, configuration: &Configuration) -> Dynamic {
    let timing = configuration.timing();
    let words: Vec<&[Issue]> = schedule.issues.chunk_by(|a, b| a.cycle == b.cycle).collect();
    let mut engine = Scoreboard::new(configuration);
    let (mut random, mut fetched, mut queue, mut issued) = (gaps.seed, 0, 0u32, 0);
    let (mut cycle, mut end) = (0u32, 0);
    let mut out = Dynamic::default();
    while issued < words.len() {
        let valid = fetched < words.len() && {
            random ^= random << 13;
            random ^= random >> 17;
            random ^= random << 5;
            random & 255 >= gaps.level
        };
        let go = queue > 0 && engine.free(words[issued], cycle);
        let push = valid && queue < timing.queue_depth;
        *(if go {
            &mut out.issue
        } else if queue > 0 {
            &mut out.hazard
        } else {
            &mut out.fetch
        }) += 1;
        if go {
            for issue in words[issued] {
                engine.take(issue, cycle);
                end = end.max(cycle + timing.distance(issue.code) + 1);
            }
            issued += 1;
        }
        fetched += usize::from(push);
        queue = queue + u32::from(push) - u32::from(go);
        engine.end_cycle(cycle);
        cycle += 1;
    }
    out.cycles = timing.startup + end.max(cycle) + timing.finish;
    out
}

/// Results in flight, and the ports that they will take.
struct Scoreboard<'a> {
    configuration: &'a Configuration,
    ready_from: Vec<u32>,
    results: Vec<u64>,
    writes: Vec<u64>,
    divider_free: Vec<u32>,
}

const WINDOW: usize = 128;

impl<'a> Scoreboard<'a> {
    fn new(configuration: &'a Configuration) -> Self {
        Self {
            configuration,
            ready_from: vec![0; configuration.words()],
            results: vec![0; WINDOW],
            writes: vec![0; WINDOW],
            divider_free: vec![0; configuration.dividers],
        }
    }

    fn slot(&self, issue: &Issue, cycle: u32) -> usize {
        (cycle + self.configuration.timing().latency(issue.code)) as usize % WINDOW
    }

    /// End a cycle: its slot of the ring buffer is cleared.
    fn end_cycle(&mut self, cycle: u32) {
        (self.results[cycle as usize % WINDOW], self.writes[cycle as usize % WINDOW]) = (0, 0);
    }

    fn free(&self, word: &[Issue], cycle: u32) -> bool {
        word.iter().all(|issue| {
            let reads = issue.operands.iter().zip(issue.code.reads());
            let words = reads.filter_map(|(&address, reads)| reads.then_some(address));
            let ready = words.chain([issue.destination]).all(|a| self.ready_from[a as usize] <= cycle);
            let slot = self.slot(issue, cycle);
            let unit = if issue.code.on_divider() {
                self.divider_free[issue.unit as usize] <= cycle
            } else {
                self.results[slot] >> issue.unit & 1 == 0
            };
            ready && unit && self.writes[slot] >> self.configuration.bank(issue.destination) & 1 == 0
        })
    }

    fn take(&mut self, issue: &Issue, cycle: u32) {
        let timing = self.configuration.timing();
        let slot = self.slot(issue, cycle);
        if issue.code.on_divider() {
            self.divider_free[issue.unit as usize] = cycle + timing.interval(issue.code);
        } else {
            self.results[slot] |= 1 << issue.unit;
        }
        self.writes[slot] |= 1 << self.configuration.bank(issue.destination);
        self.ready_from[issue.destination as usize] = cycle + timing.distance(issue.code);
    }
}

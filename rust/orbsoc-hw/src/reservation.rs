//! What is taken, cycle by cycle: lanes, result registers, read ports, write ports, dividers.

use crate::code::Code;
use crate::configuration::Configuration;
use crate::intervals::Intervals;

/// Why an operation whose operands are there cannot be issued in a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Conflict {
    ReadPort,
    WritePort,
    Result,
}

/// A value to be read: which one, and the bank that it is in. Reading one value twice is reading it once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Read {
    pub value: u32,
    pub bank: u8,
}

/// One cycle's reservations.
#[derive(Clone, Copy, Debug, Default)]
struct Cycle {
    /// Lanes in which an operation begins.
    lanes: u32,
    /// Lanes in which a result appears, counted from the issue that has no latency.
    results: u32,
    /// Banks written by results that appear in this cycle.
    writes: u64,
    /// Banks read in each replica.
    reads: [u64; 3],
}

/// The reservations of a segment. Operations may be placed in any order.
#[derive(Clone, Debug)]
pub(crate) struct Reservation {
    configuration: Configuration,
    cycles: Vec<Cycle>,
    /// What is read: of each cycle and replica as many words as there are units, filled from the first on.
    words: Vec<u32>,
    units: usize,
    dividers: Vec<Intervals>,
    /// The first cycle from each on that is worth a try.
    open: Vec<u32>,
    refusals: Vec<u8>,
}

/// Refusals after which nothing more is tried in a cycle that still has a lane free.
const PATIENCE: u8 = 12;

impl Reservation {
    pub fn new(configuration: &Configuration) -> Self {
        Self {
            configuration: *configuration,
            cycles: Vec::new(),
            words: Vec::new(),
            units: configuration.lanes + configuration.dividers,
            dividers: vec![Intervals::default(); configuration.dividers],
            open: Vec::new(),
            refusals: Vec::new(),
        }
    }

    fn at(&mut self, cycle: u32) -> &mut Cycle {
        let cycle = cycle as usize;
        if cycle >= self.cycles.len() {
            self.cycles.resize(2 * cycle + 64, Cycle::default());
            self.words.resize(3 * self.units * self.cycles.len(), 0);
        }
        &mut self.cycles[cycle]
    }

    /// The first cycle from `from` on in which a lane may be free.
    pub fn open_from(&mut self, from: u32) -> u32 {
        let mut end = from;
        loop {
            while self.open.len() <= end as usize {
                self.open.push(self.open.len() as u32);
                self.refusals.push(0);
            }
            if self.open[end as usize] == end {
                break;
            }
            end = self.open[end as usize];
        }
        let mut at = from;
        while at != end {
            at = core::mem::replace(&mut self.open[at as usize], end);
        }
        end
    }

    fn close(&mut self, cycle: u32) {
        self.open_from(cycle);
        self.open[cycle as usize] = cycle + 1;
    }

    /// Note that an operation found no place in a cycle.
    pub fn refuse(&mut self, cycle: u32) {
        self.refusals[cycle as usize] += 1;
        if self.refusals[cycle as usize] >= PATIENCE {
            self.close(cycle);
        }
    }

    /// Whether all of these reads have a port, operand by operand.
    pub fn may_read(&mut self, cycle: u32, operands: &[Option<Read>; 3]) -> bool {
        let banks = self.at(cycle).reads;
        (0..3).all(|replica| {
            operands[replica].is_none_or(|read| {
                banks[replica] >> read.bank & 1 == 0 || self.is_read(cycle, replica, read.value)
            })
        })
    }

    /// Whether a word is read in a cycle anyway.
    fn is_read(&self, cycle: u32, replica: usize, value: u32) -> bool {
        let count = self.cycles[cycle as usize].reads[replica].count_ones() as usize;
        let from = (3 * cycle as usize + replica) * self.units;
        self.words[from..from + count].contains(&value)
    }

    fn take_port(&mut self, cycle: u32, replica: usize, read: Read) {
        let banks = &mut self.at(cycle).reads[replica];
        if *banks >> read.bank & 1 == 0 {
            let count = banks.count_ones() as usize;
            *banks |= 1 << read.bank;
            self.words[(3 * cycle as usize + replica) * self.units + count] = read.value;
        }
    }

    /// Whether no operation begins in a lane.
    pub fn lane_free(&mut self, cycle: u32, lane: usize) -> bool {
        self.at(cycle).lanes >> lane & 1 == 0
    }

    fn appears(&self, cycle: u32, code: Code) -> u32 {
        cycle + self.configuration.timing().latency(code)
    }

    /// Lanes in which an operation may begin and end, as bits.
    pub fn lanes_for(&mut self, cycle: u32, code: Code) -> u32 {
        let all = (1u32 << self.configuration.lanes) - 1;
        let end = self.appears(cycle, code);
        all & !self.at(cycle).lanes & !self.at(end).results
    }

    /// Banks that may be written by an operation issued in this cycle, as bits.
    pub fn banks_for(&mut self, cycle: u32, code: Code) -> u64 {
        let end = self.appears(cycle, code);
        let all = u64::MAX >> (64 - self.configuration.banks);
        all & !self.at(end).writes
    }

    /// The first cycle from `from` on in which one of the dividers has time for an operation, and the divider.
    pub fn divider_from(&self, from: u32, code: Code) -> (u32, usize) {
        let length = self.configuration.timing().latency(code);
        let firsts = self.dividers.iter().enumerate().map(|(k, busy)| (busy.gap(from, length), k));
        firsts.min().unwrap_or((from, 0))
    }

    /// Take everything that an operation needs.
    pub fn take(&mut self, cycle: u32, code: Code, unit: usize, operands: &[Option<Read>; 3], bank: usize) {
        let end = self.appears(cycle, code);
        self.at(end).writes |= 1 << bank;
        for (replica, read) in operands.iter().enumerate() {
            if let Some(read) = read {
                self.take_port(cycle, replica, *read);
            }
        }
        if code.on_divider() {
            self.dividers[unit].take(cycle, end);
            return;
        }
        self.at(end).results |= 1 << unit;
        self.at(cycle).lanes |= 1 << unit;
        if self.at(cycle).lanes.count_ones() as usize == self.configuration.lanes {
            self.close(cycle);
        }
    }
}

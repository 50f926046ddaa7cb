//! What is taken, cycle by cycle: lanes, result registers, read ports, write ports, dividers.

use crate::code::Code;
use crate::configuration::Configuration;

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

/// Reads of one cycle in one replica: at most one value a bank.
type Ports = Vec<Read>;

/// One cycle's reservations.
#[derive(Clone, Debug, Default)]
struct Cycle {
    /// Lanes in which an operation begins.
    lanes: u32,
    /// Lanes in which a result appears, counted from the issue that has no latency.
    results: u32,
    /// Banks written by results that appear in this cycle.
    writes: u64,
    dividers: u32,
    reads: [Ports; 3],
}

/// The reservations of a segment. Operations may be placed in any order.
#[derive(Clone, Debug)]
pub(crate) struct Reservation {
    configuration: Configuration,
    cycles: Vec<Cycle>,
    /// The first cycle from each on that is worth a try.
    open: Vec<u32>,
    refusals: Vec<u8>,
}

/// Refusals after which nothing more is tried in a cycle that still has a lane free.
const PATIENCE: u8 = 12;

impl Reservation {
    pub fn new(configuration: &Configuration) -> Self {
        Self { configuration: *configuration, cycles: Vec::new(), open: Vec::new(), refusals: Vec::new() }
    }

    fn at(&mut self, cycle: u32) -> &mut Cycle {
        let cycle = cycle as usize;
        if cycle >= self.cycles.len() {
            self.cycles.resize_with(2 * cycle + 64, Cycle::default);
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
        let ports = &self.at(cycle).reads;
        let free = |(read, ports): (&Option<Read>, &Ports)| {
            read.is_none_or(|read| ports.iter().all(|other| other.bank != read.bank || *other == read))
        };
        operands.iter().zip(ports).all(free)
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
    pub fn divider_from(&mut self, from: u32, code: Code) -> (u32, usize) {
        let length = self.configuration.timing().latency(code);
        let first = |this: &mut Self, divider: usize| {
            let mut start = from;
            while let Some(busy) =
                (start..start + length).rev().find(|&cycle| this.at(cycle).dividers >> divider & 1 == 1)
            {
                start = busy + 1;
            }
            start
        };
        let starts = (0..self.configuration.dividers).map(|divider| (first(self, divider), divider));
        starts.min().unwrap_or((from, 0))
    }

    /// Take everything that an operation needs.
    pub fn take(&mut self, cycle: u32, code: Code, unit: usize, operands: &[Option<Read>; 3], bank: usize) {
        let end = self.appears(cycle, code);
        self.at(end).writes |= 1 << bank;
        for (replica, read) in operands.iter().enumerate() {
            if let Some(read) = read {
                let ports = &mut self.at(cycle).reads[replica];
                if !ports.contains(read) {
                    ports.push(*read);
                }
            }
        }
        if code.on_divider() {
            for busy in cycle..end {
                self.at(busy).dividers |= 1 << unit;
            }
            return;
        }
        self.at(end).results |= 1 << unit;
        self.at(cycle).lanes |= 1 << unit;
        if self.at(cycle).lanes.count_ones() as usize == self.configuration.lanes {
            self.close(cycle);
        }
    }
}

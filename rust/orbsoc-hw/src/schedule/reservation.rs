//! Reservation table: lanes, result registers, read ports, write ports and dividers, cycle by cycle.

use super::exports::Exports;
use super::intervals::Intervals;
use super::reads::Reads;
use crate::machine::configuration::Configuration;
use crate::machine::operation::Code;

/// Why a ready operation cannot be issued in a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Conflict {
    ReadPort,
    WritePort,
    Result,
}

/// One cycle's reservations.
#[derive(Clone, Copy, Debug, Default)]
struct Cycle {
    /// Lanes in which an operation begins.
    lanes: u32,
    /// Lanes whose result register is written.
    results: u32,
    /// Banks that receive these results.
    writes: u64,
    /// Banks read in each replica.
    reads: [u64; 3],
    /// Head of the list of words read in each replica, counted from one.
    words: [u32; 3],
}

/// A word that is read, and the next one in the list of its cycle and replica, counted from one.
#[derive(Clone, Copy, Debug)]
struct Word {
    value: u32,
    next: u32,
}

/// The reservations of a segment. Operations may be placed in any order.
#[derive(Clone, Debug)]
pub(crate) struct Reservation {
    /// All lanes and all banks, as bits.
    lanes: u32,
    banks: u64,
    latencies: [u32; Code::ALL.len()],
    intervals: [u32; Code::ALL.len()],
    longest: u32,
    cycles: Vec<Cycle>,
    words: Vec<Word>,
    dividers: Vec<Intervals>,
    exports: Exports,
    /// Disjoint-set forest: the parent of an open cycle is itself, that of a closed cycle a later one.
    open: Vec<u32>,
    refusals: Vec<u8>,
}

/// Refusals after which a cycle is closed although a lane is free.
const MAX_REFUSALS: u8 = 12;

impl Reservation {
    /// An empty table with room for `cycles`.
    pub fn new(configuration: &Configuration, cycles: u32) -> Self {
        let latencies = Code::ALL.map(|code| configuration.timing().latency(code));
        Self {
            lanes: (1 << configuration.lanes) - 1,
            banks: u64::MAX >> (64 - configuration.banks),
            latencies,
            intervals: Code::ALL.map(|code| configuration.timing().interval(code)),
            longest: latencies.into_iter().max().unwrap_or(0),
            cycles: vec![Cycle::default(); cycles as usize],
            words: Vec::new(),
            dividers: vec![Intervals::default(); configuration.dividers],
            exports: Exports::new(configuration),
            open: Vec::new(),
            refusals: Vec::new(),
        }
    }

    /// Make room for operations issued in a cycle.
    pub fn reach(&mut self, cycle: u32) {
        let last = (cycle + self.longest) as usize;
        if last >= self.cycles.len() {
            self.grow(last + last / 2 + 64);
        }
    }

    #[cold]
    fn grow(&mut self, cycles: usize) {
        self.cycles.resize(cycles, Cycle::default());
    }

    fn latency(&self, code: Code) -> u32 {
        self.latencies[code as usize]
    }

    /// The first open cycle from `from` on; paths are compressed.
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

    /// Note that an operation was refused in a cycle.
    pub fn refuse(&mut self, cycle: u32) {
        self.refusals[cycle as usize] += 1;
        if self.refusals[cycle as usize] >= MAX_REFUSALS {
            self.close(cycle);
        }
    }

    /// Whether all of these reads have a port, and a way to a cluster.
    pub fn may_read(&self, cycle: u32, reads: &Reads, cluster: usize) -> bool {
        let taken = &self.cycles[cycle as usize].reads;
        (0..3).all(|replica| {
            taken[replica] & reads.banks[replica] == 0 || self.is_read(cycle, replica, reads.values[replica])
        }) && self.exports.may_read(cycle, reads, cluster)
    }

    /// Whether a word is read in a cycle already.
    fn is_read(&self, cycle: u32, replica: usize, value: u32) -> bool {
        let mut at = self.cycles[cycle as usize].words[replica];
        while at > 0 {
            let word = self.words[at as usize - 1];
            if word.value == value {
                return true;
            }
            at = word.next;
        }
        false
    }

    fn take_ports(&mut self, cycle: u32, reads: &Reads) {
        let taken = &mut self.cycles[cycle as usize];
        for replica in 0..3 {
            let bank = reads.banks[replica];
            if bank & !taken.reads[replica] != 0 {
                taken.reads[replica] |= bank;
                self.words.push(Word { value: reads.values[replica], next: taken.words[replica] });
                taken.words[replica] = self.words.len() as u32;
            }
        }
    }

    /// Lanes in which no operation begins, as bits.
    pub fn free_lanes(&self, cycle: u32) -> u32 {
        self.lanes & !self.cycles[cycle as usize].lanes
    }

    /// Lanes whose issue slot and result register are free, as bits.
    pub fn lanes_for(&self, cycle: u32, code: Code) -> u32 {
        let end = (cycle + self.latency(code)) as usize;
        self.lanes & !self.cycles[cycle as usize].lanes & !self.cycles[end].results
    }

    /// Banks whose write port is free for the result of an operation that a cluster issues in this cycle, as bits: those of
    /// the cluster, and all that its result reaches.
    pub fn banks_for(&self, cycle: u32, code: Code, cluster: usize) -> (u64, u64) {
        let end = cycle + self.latency(code);
        let free = self.banks & !self.cycles[end as usize].writes;
        let local = free & self.exports.banks_of(cluster);
        (local, if self.exports.may_write(end, cluster) { free } else { local })
    }

    /// The first cycle from `from` on in which a divider is free for an operation, and the divider.
    pub fn divider_from(&self, from: u32, code: Code) -> (u32, usize) {
        let length = self.intervals[code as usize];
        let firsts = self.dividers.iter().enumerate().map(|(k, busy)| (busy.gap(from, length), k));
        firsts.min().unwrap_or((from, 0))
    }

    /// Reserve all resources of an operation.
    pub fn take(&mut self, cycle: u32, code: Code, unit: usize, reads: &Reads, bank: usize, cluster: usize) {
        let end = cycle + self.latency(code);
        self.exports.take_words(cycle, reads, cluster);
        self.exports.take_result(end, bank, cluster);
        self.cycles[end as usize].writes |= 1 << bank;
        self.take_ports(cycle, reads);
        if code.on_divider() {
            self.dividers[unit].take(cycle, cycle + self.intervals[code as usize]);
            return;
        }
        self.cycles[end as usize].results |= 1 << unit;
        let begun = &mut self.cycles[cycle as usize].lanes;
        *begun |= 1 << unit;
        if *begun == self.lanes {
            self.close(cycle);
        }
    }
}

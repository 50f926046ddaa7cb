//! Simulator of the engine: it runs flat microcode on words of storage and checks every rule of the contract. Schedules
//! are verified by it, and the RTL is compared with it.

use crate::error::Error;
use crate::machine::arithmetic::compute;
use crate::machine::configuration::Configuration;
use crate::microcode::flat::{decode, Microcode};
use crate::schedule::scheduler::Issue;
use core::fmt;

/// A rule of the contract, named as the RTL's assertion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // docs/pl-machine.md, "One operation in time"
pub enum Rule {
    ReadPending,
    WritePending,
    ReadConflict,
    ResultConflict,
    WriteConflict,
    DividerBusy,
    ReadUnwritten,
}

/// Where a rule was broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Violation {
    /// The rule.
    pub rule: Rule,
    /// The cycle after the first word's.
    pub cycle: u32,
    /// The word of storage.
    pub address: u32,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} in cycle {} at word {:x}", self.rule, self.cycle, self.address)
    }
}

/// Why a run stopped.
#[derive(Clone, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Fault {
    Violation(Violation),
    Damaged(Error),
}

/// An engine with its storage.
#[derive(Clone, Debug)]
pub struct Machine {
    configuration: Configuration,
    storage: Vec<Option<u64>>,
    /// The first cycle in which each word may be read.
    readable_from: Vec<u32>,
    results: Vec<u64>,
    writes: Vec<u64>,
    /// Clusters that export a result, cycle by cycle.
    exports: Vec<u64>,
    divider_free: Vec<u32>,
}

impl Machine {
    /// An engine with uninitialised storage.
    pub fn new(configuration: &Configuration) -> Self {
        Self {
            configuration: *configuration,
            storage: vec![None; configuration.words()],
            readable_from: vec![0; configuration.words()],
            results: Vec::new(),
            writes: Vec::new(),
            exports: Vec::new(),
            divider_free: vec![0; configuration.dividers],
        }
    }

    /// The PS writes a word.
    pub fn load(&mut self, address: u32, word: u64) {
        self.storage[address as usize] = Some(word);
    }

    /// A word, if it is initialised.
    pub fn word(&self, address: u32) -> Option<u64> {
        self.storage[address as usize]
    }

    /// Run a segment. Returns the cycles for which the engine is busy.
    ///
    /// # Errors
    /// The first rule that the microcode breaks.
    pub fn run(&mut self, microcode: &Microcode, start: usize) -> Result<u32, Fault> {
        self.readable_from.fill(0);
        self.results.clear();
        self.writes.clear();
        self.exports.clear();
        self.divider_free.fill(0);
        let timing = *self.configuration.timing();
        let (mut cycle, mut end) = (0, 0);
        loop {
            let (issues, last) = decode(microcode, start + cycle as usize, cycle, &self.configuration)
                .map_err(Fault::Damaged)?;
            self.issue(&issues).map_err(Fault::Violation)?;
            cycle += 1;
            let ends = issues.iter().map(|issue| issue.cycle + timing.distance(issue.code) + 1);
            end = ends.fold(end.max(cycle), u32::max);
            if last {
                return Ok(timing.startup + end + timing.finish);
            }
        }
    }

    fn cluster_of(&self, issue: &Issue) -> usize {
        self.configuration.cluster_of_unit(issue.code.on_divider(), issue.unit as usize)
    }

    /// All operations of one word: first all reads, then all writes.
    fn issue(&mut self, issues: &[Issue]) -> Result<(), Violation> {
        let mut reads = Vec::with_capacity(3 * issues.len());
        let mut results = Vec::with_capacity(issues.len());
        for issue in issues {
            let mut words = [0; 3];
            for (replica, reads_it) in issue.code.reads().into_iter().enumerate() {
                if reads_it {
                    words[replica] = self.read(issue, replica, &mut reads)?;
                }
            }
            results.push(compute(self.configuration.precision, issue.code, words));
        }
        issues.iter().zip(results).try_for_each(|(issue, result)| self.write(issue, result))
    }

    fn read(&self, issue: &Issue, replica: usize, reads: &mut Vec<Read>) -> Result<u64, Violation> {
        let (cycle, address) = (issue.cycle, issue.operands[replica]);
        let broken = |rule| Violation { rule, cycle, address };
        let bank = self.configuration.bank(address);
        let source = self.configuration.cluster_of_bank(bank);
        let exported = self.cluster_of(issue) != source;
        let conflict = |other: &Read| {
            let one_port = other.bank == bank || (exported && other.exported && other.source == source);
            other.replica == replica && other.address != address && one_port
        };
        if reads.iter().any(conflict) {
            return Err(broken(Rule::ReadConflict));
        }
        reads.push(Read { replica, bank, source, exported, address });
        if self.readable_from[address as usize] > cycle {
            return Err(broken(Rule::ReadPending));
        }
        self.storage[address as usize].ok_or(broken(Rule::ReadUnwritten))
    }

    fn write(&mut self, issue: &Issue, result: u64) -> Result<(), Violation> {
        let Issue { cycle, code, destination, unit, .. } = *issue;
        let broken = |rule| Err(Violation { rule, cycle, address: destination });
        let timing = self.configuration.timing();
        let appears = cycle + timing.latency(code);
        if self.readable_from[destination as usize] > cycle {
            return broken(Rule::WritePending);
        }
        if code.on_divider() {
            let free = &mut self.divider_free[unit as usize];
            if *free > cycle {
                return broken(Rule::DividerBusy);
            }
            *free = cycle + timing.interval(code);
        } else if reserve(&mut self.results, appears, unit as usize) {
            return broken(Rule::ResultConflict);
        }
        let (bank, cluster) = (self.configuration.bank(destination), self.cluster_of(issue));
        let exported = self.configuration.cluster_of_bank(bank) != cluster;
        if reserve(&mut self.writes, appears, bank)
            || (exported && reserve(&mut self.exports, appears, cluster))
        {
            return broken(Rule::WriteConflict);
        }
        self.readable_from[destination as usize] = cycle + timing.distance(code);
        self.storage[destination as usize] = Some(result);
        Ok(())
    }
}

/// A word that is read in a cycle.
struct Read {
    replica: usize,
    bank: usize,
    /// The bank's cluster, and whether another cluster reads it.
    source: usize,
    exported: bool,
    address: u32,
}

/// Reserve a bit of a cycle; whether it was reserved already.
fn reserve(reserved: &mut Vec<u64>, cycle: u32, bit: usize) -> bool {
    if reserved.len() <= cycle as usize {
        reserved.resize(cycle as usize + 1, 0);
    }
    let before = reserved[cycle as usize];
    reserved[cycle as usize] |= 1 << bit;
    before >> bit & 1 == 1
}

//! Cycle accounting: every cycle has one cause, and the causes sum to the makespan.

use super::reservation::Conflict;
use crate::machine::configuration::Configuration;

/// Cycles by cause.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Causes {
    /// An operation began.
    pub issue: u32,
    /// No operation had its operands.
    pub dependency: u32,
    /// A bank was already reading another word.
    pub read_port: u32,
    /// A bank was already written in the result's cycle.
    pub write_port: u32,
    /// No lane's result register was free.
    pub result: u32,
    /// A divider was busy, or its result awaited.
    pub divider: u32,
    /// The next word was not fetched yet.
    pub fetch: u32,
    /// Before the first word.
    pub startup: u32,
    /// After the last issue, until its result is in storage.
    pub drain: u32,
    /// After the last result.
    pub finish: u32,
}

impl Causes {
    /// Names and counts.
    pub fn named(&self) -> [(&'static str, u32); 10] {
        [
            ("issue", self.issue),
            ("dependency", self.dependency),
            ("read_port", self.read_port),
            ("write_port", self.write_port),
            ("result", self.result),
            ("divider", self.divider),
            ("fetch", self.fetch),
            ("startup", self.startup),
            ("drain", self.drain),
            ("finish", self.finish),
        ]
    }

    /// All of them.
    pub fn total(&self) -> u32 {
        self.named().iter().map(|(_, cycles)| cycles).sum()
    }

    fn count(&mut self, reason: Reason) -> &mut u32 {
        match reason {
            Reason::Dependency => &mut self.dependency,
            Reason::Conflict(Conflict::ReadPort) => &mut self.read_port,
            Reason::Conflict(Conflict::WritePort) => &mut self.write_port,
            Reason::Conflict(Conflict::Result) => &mut self.result,
            Reason::Divider => &mut self.divider,
        }
    }
}

/// Why a lane was idle.
#[derive(Clone, Copy)]
enum Reason {
    Dependency,
    Divider,
    Conflict(Conflict),
}

/// Stalls noted while operations are placed.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stalls {
    /// The first conflict of each cycle.
    conflicts: Vec<Option<Conflict>>,
    /// Cycles in which an operation's last operand arrived; true: only from dividers.
    arrived: Vec<Option<bool>>,
    /// Difference array of the operations that wait for a busy divider.
    divider_waits: Vec<i32>,
}

fn at<T: Clone + Default>(list: &mut Vec<T>, cycle: u32) -> &mut T {
    if list.len() <= cycle as usize {
        list.resize(cycle as usize + 1, T::default());
    }
    &mut list[cycle as usize]
}

impl Stalls {
    pub fn conflict(&mut self, cycle: u32, conflict: Conflict) {
        at(&mut self.conflicts, cycle).get_or_insert(conflict);
    }

    pub fn arrived(&mut self, cycle: u32, from_divider: bool) {
        let all = at(&mut self.arrived, cycle).get_or_insert(from_divider);
        *all &= from_divider;
    }

    pub fn wait_for_divider(&mut self, from: u32, to: u32) {
        *at(&mut self.divider_waits, from) += 1;
        *at(&mut self.divider_waits, to) -= 1;
    }

    /// Causes of the cycles, and of the lanes within them, of a segment of `words` that ends after `end`. `issued`: the
    /// cycle of every operation, and whether it is on a divider.
    pub fn causes(
        mut self,
        issued: impl Iterator<Item = (u32, bool)>,
        words: u32,
        end: u32,
        configuration: &Configuration,
    ) -> (Causes, Causes) {
        let (timing, lanes) = (configuration.timing(), configuration.lanes as u32);
        let mut began = vec![(0u32, false); words as usize];
        for (cycle, on_divider) in issued {
            let (on_lanes, any) = &mut began[cycle as usize];
            *on_lanes += u32::from(!on_divider);
            *any = true;
        }
        let reasons = self.reasons(words);
        let around = Causes {
            startup: timing.startup,
            drain: end - words,
            finish: timing.finish,
            ..Causes::default()
        };
        let (mut causes, mut slots) = (around, Causes::default());
        (slots.startup, slots.drain, slots.finish) =
            (lanes * around.startup, lanes * around.drain, lanes * around.finish);
        for ((on_lanes, any), reason) in began.into_iter().zip(reasons) {
            slots.issue += on_lanes;
            *slots.count(reason) += lanes - on_lanes;
            *(if any { &mut causes.issue } else { causes.count(reason) }) += 1;
        }
        (causes, slots)
    }

    /// For each cycle the reason why a lane was idle, if one was.
    fn reasons(&mut self, words: u32) -> Vec<Reason> {
        let mut reasons = vec![Reason::Dependency; words as usize];
        let mut waiting = 0;
        for cycle in 0..words {
            waiting += *at(&mut self.divider_waits, cycle);
            if waiting > 0 {
                reasons[cycle as usize] = Reason::Divider;
            }
        }
        let mut next_from_divider = false;
        for cycle in (0..words).rev() {
            next_from_divider = at(&mut self.arrived, cycle).unwrap_or(next_from_divider);
            if let Some(conflict) = at(&mut self.conflicts, cycle) {
                reasons[cycle as usize] = Reason::Conflict(*conflict);
            } else if next_from_divider {
                reasons[cycle as usize] = Reason::Divider;
            }
        }
        reasons
    }
}

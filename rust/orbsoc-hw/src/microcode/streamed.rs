//! Compressed microcode from memory, line by line, as `rtl/axi/axi_stream_port.sv` reads it: which cycles the decoder has a line in.
//! docs/pl-machine.md, "Streamed microcode".

use super::template::Format;
use crate::error::Error;
use crate::machine::timing::engine_parameter;
use std::collections::VecDeque;

/// Ports, and the memory behind each: it answers in order, a burst `latency` cycles after its address at the soonest, and gives `beats`
/// beats in `per` cycles while it has some to give.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub struct Streaming {
    pub ports: usize,
    /// Bits of a beat.
    pub beat_bits: usize,
    pub latency: u32,
    pub beats: u32,
    pub per: u32,
}

impl Streaming {
    /// # Errors
    /// What no port has, or lines of `fetch` bits do not allow.
    pub(crate) fn validate(&self, fetch: usize) -> Result<(), Error> {
        let check = |ok: bool, field, value: usize, allowed| {
            let value = value as u64;
            if ok {
                Ok(())
            } else {
                Err(Error::Configuration { field, value, allowed })
            }
        };
        check([1, 2, 4].contains(&self.ports), "stream_ports", self.ports, "1, 2 or 4")?;
        check([64, 128].contains(&self.beat_bits), "stream_beat_bits", self.beat_bits, "64 or 128")?;
        let whole = (fetch / self.ports).is_multiple_of(self.beat_bits);
        check(whole, "stream_ports", self.ports, "as many as have a beat each of a line of this engine")?;
        check(self.latency >= 1, "stream_latency", self.latency as usize, "1 or more")?;
        let rate = self.beats >= 1 && self.beats <= self.per;
        check(rate, "stream_beats", self.beats as usize, "1 to the cycles that they take")
    }
}

/// Whether the decoder's next line is there, cycle by cycle from the segment's first busy one on.
pub(crate) trait Lines {
    fn there(&self) -> bool;
    /// The end of a cycle, in which the line may have been taken.
    fn step(&mut self, taken: bool);
}

/// Lines from block RAM.
pub(crate) struct OnChip;

impl Lines for OnChip {
    fn there(&self) -> bool {
        true
    }
    fn step(&mut self, _: bool) {}
}

/// One of several ports that are alike.
pub(crate) struct Port {
    memory: Streaming,
    /// Beats of a part, parts of a burst, parts that fit.
    beats: usize,
    parts: usize,
    rows: usize,
    cycle: u64,
    /// The next part that is asked for, and the parts still to ask for and to give.
    at: usize,
    left: usize,
    rest: usize,
    claimed: usize,
    /// When the first beat of each burst may come, and its beats.
    bursts: VecDeque<(u64, usize)>,
    tokens: u32,
    arrived: usize,
    written: usize,
    read: usize,
    there: bool,
}

impl Port {
    /// Of a segment with `lines` lines from `first` on, in its first busy cycle.
    pub fn new(memory: Streaming, format: &Format, first: usize, lines: usize) -> Self {
        let beats = format.fetch() / memory.ports / memory.beat_bits;
        Self {
            memory,
            beats,
            parts: engine_parameter("STREAM_BURST") as usize / beats,
            rows: engine_parameter("STREAM_ROWS") as usize,
            cycle: 0,
            at: first,
            left: 0,
            rest: lines,
            claimed: 0,
            bursts: VecDeque::new(),
            tokens: memory.per,
            arrived: 0,
            written: 0,
            read: 0,
            there: false,
        }
    }

    fn beat(&mut self) -> bool {
        let cycle = self.cycle;
        let Some((_, more)) = self.bursts.front_mut().filter(|(due, _)| *due <= cycle) else {
            self.tokens = self.memory.per; // it has had time
            return false;
        };
        if self.tokens < self.memory.per {
            self.tokens += self.memory.beats;
        }
        if self.tokens < self.memory.per {
            return false;
        }
        self.tokens -= self.memory.per;
        *more -= 1;
        if *more == 0 {
            self.bursts.pop_front();
        }
        true
    }
}

impl Lines for Port {
    fn there(&self) -> bool {
        self.there || self.rest == 0
    }

    fn step(&mut self, taken: bool) {
        let taken = taken && self.rest > 0;
        let moved = self.written != self.read && (!self.there || taken);
        // A burst as soon as there is room for the longest; its address is on the bus a cycle later.
        let asks = self.left > 0 && self.claimed <= self.rows - self.parts;
        let count = if asks { self.left.min(self.parts - self.at % self.parts) } else { 0 };
        let beat = self.beat();
        if asks {
            self.bursts.push_back((self.cycle + 1 + u64::from(self.memory.latency), count * self.beats));
        }
        self.arrived += usize::from(beat);
        self.written = self.arrived / self.beats;
        self.read += usize::from(moved);
        self.there = moved || (self.there && !taken);
        self.rest -= usize::from(taken);
        self.claimed = self.claimed + count - usize::from(moved);
        self.at += count;
        self.left = if self.cycle == 0 { self.rest } else { self.left - count };
        self.cycle += 1;
    }
}

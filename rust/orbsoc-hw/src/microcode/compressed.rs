//! Compressed microcode: delta-encoded words for a decoder in front of the issue register.
//! docs/pl-machine.md, "Compressed microcode".

use super::encoder::{chunks, encode, Index, Item, EMPTY, LAST, RUN_BITS, SAME, SAME_BITS};
use super::flat::Microcode;
use super::streamed::{Lines, OnChip, Port, Streaming};
use super::template::{choose, Candidates, Format, LaneState, Mode, Template};
use crate::error::Error;
use crate::machine::configuration::Configuration;
use crate::machine::operation::Code;
use crate::schedule::scheduler::{Issue, Schedule};
use std::collections::VecDeque;

/// The compressed microcode of several segments, with their common table of templates.
#[derive(Clone, Debug)]
pub struct Compressed {
    format: Format,
    table: Vec<Template>,
    /// Lines of all segments.
    pub lines: Microcode,
    /// Of each segment.
    pub segments: Vec<CompressedSegment>,
    /// Of each segment, the word that each cycle of a frozen datapath waits for, ascending.
    pub freezes: Vec<Vec<u32>>,
    items: Vec<Vec<Item>>,
}

/// Lines that the decoder holds.
const BUFFER_LINES: usize = 4;
/// Busy cycles before the first line may go there; and from then on until a header is complete, at least.
const LEAST_WAIT: usize = 2;

/// One segment's lines and cycles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub struct CompressedSegment {
    /// First line.
    pub start: usize,
    pub lines: usize,
    /// Bits in use.
    pub bits: usize,
    /// Cycles in which the datapath was frozen.
    pub frozen: u32,
    /// Cycles for which the engine is busy.
    pub cycles: u32,
}

/// A segment's items, by which its cycles follow for any memory.
#[derive(Clone, Debug)]
pub struct Demand {
    format: Format,
    segment: CompressedSegment,
    items: Vec<Item>,
}

impl Demand {
    /// Cycles for which the engine is busy with it when its lines come from memory.
    ///
    /// # Errors
    /// [`Error::Configuration`] for ports that the engine cannot have.
    pub fn cycles(&self, memory: Streaming) -> Result<u32, Error> {
        memory.validate(self.format.fetch())?;
        let port = Port::new(memory, &self.format, self.segment.start, self.segment.lines);
        let frozen = fetch_stalls(&self.items, &self.format, port).len() as u32;
        Ok(self.segment.cycles - self.segment.frozen + frozen)
    }
}

impl Compressed {
    /// Compress schedules of one engine.
    pub fn new(schedules: &[&Schedule], configuration: &Configuration) -> Self {
        let format = Format::new(configuration);
        let table = table(schedules, &format);
        let index = Index::new(&format, &table);
        let mut lines = Microcode::new(format.fetch(), 0);
        let (mut segments, mut freezes, mut kept) = (Vec::new(), Vec::new(), Vec::new());
        for schedule in schedules {
            let (stream, items) = encode(schedule, &index);
            let (start, count) = (lines.len(), stream.bits.div_ceil(format.fetch()));
            let stalls = fetch_stalls(&items, &format, OnChip);
            let frozen = stalls.len() as u32;
            let cycles = schedule.cycles + configuration.timing().decode + frozen;
            segments.push(CompressedSegment { start, lines: count, bits: stream.bits, frozen, cycles });
            freezes.push(stalls);
            kept.push(items);
            lines.append(&stream.lines(format.fetch()));
        }
        Self { format, table, lines, segments, freezes, items: kept }
    }

    /// What a segment asks of the memory that its lines come from.
    pub fn demand(&self, segment: usize) -> Demand {
        Demand { format: self.format, segment: self.segments[segment], items: self.items[segment].clone() }
    }

    /// Cycles for which the engine is busy with a schedule that is compressed alone.
    pub(crate) fn cycles(schedule: &Schedule, configuration: &Configuration) -> u32 {
        let format = Format::new(configuration);
        let table = table(&[schedule], &format);
        let (_, items) = encode(schedule, &Index::new(&format, &table));
        schedule.cycles + configuration.timing().decode + fetch_stalls(&items, &format, OnChip).len() as u32
    }

    /// Bits of microcode in use, without the table.
    pub fn bits(&self) -> usize {
        self.segments.iter().map(|segment| segment.bits).sum()
    }

    /// The table's entries in hexadecimal.
    pub fn templates(&self) -> impl Iterator<Item = String> + '_ {
        self.table.iter().map(|template| format!("{:03x}", template.bits()))
    }
}

/// The common table of templates of some schedules.
fn table(schedules: &[&Schedule], format: &Format) -> Vec<Template> {
    let mut candidates = Candidates::new();
    for schedule in schedules {
        let mut lanes = vec![LaneState::default(); format.lanes];
        for issue in schedule.issues.iter().filter(|issue| !issue.code.on_divider()) {
            let lane = &mut lanes[issue.unit as usize];
            let shortest = lane.modes(issue, format).shortest();
            lane.write(issue, shortest, format, |_, _| ());
            candidates.add(shortest);
        }
    }
    choose(&candidates, format)
}

/// For each cycle in which the next header and payload are not complete in the buffer: the word that waits.
fn fetch_stalls(items: &[Item], format: &Format, mut lines: impl Lines) -> Vec<u32> {
    let fetch = format.fetch();
    // Lines in the buffer, and those that were there a cycle ago, when the kind of the next header was read.
    let (mut fetched, mut seen) = (0, 0);
    let (mut at, mut rest, mut word, mut found) = (0, 0, 0, Vec::new());
    let mut chunks = chunks(items, format.headers_ahead).map(|(before, behind)| {
        let length = before.map_or(SAME_BITS, |item| item.header) + behind.map_or(0, |item| item.payload);
        (length, behind.map_or(0, |item| item.words))
    });
    let mut next = chunks.next();
    (0..LEAST_WAIT).for_each(|_| lines.step(false));
    while rest > 0 || next.is_some() {
        // A line goes where no bit is left that was not taken before this cycle. Behind the last come the next segment's.
        let room = fetched - at / fetch < BUFFER_LINES;
        let complete = |length| fetched * fetch >= at + length && seen * fetch >= at + format.opening();
        if rest > 0 {
            rest -= 1;
            word += 1;
        } else if let Some((length, words)) = next.filter(|(length, _)| complete(*length)) {
            at += length;
            word += words.min(1);
            rest = words.saturating_sub(1);
            next = chunks.next();
        } else {
            found.push(word);
        }
        seen = fetched;
        let taken = room && lines.there();
        fetched += usize::from(taken);
        lines.step(taken);
    }
    // The first lines go to the buffer in cycles that `DECODE_CYCLES` has already.
    found.split_off(LEAST_WAIT)
}

/// Decode a segment, as the RTL's decoder does.
///
/// # Errors
/// [`Error::Damaged`] where the stream ends within an item.
pub fn decompress(
    compressed: &Compressed,
    segment: usize,
    configuration: &Configuration,
) -> Result<Vec<Issue>, Error> {
    let CompressedSegment { start, lines, .. } = compressed.segments[segment];
    let mut reader = Reader {
        compressed,
        at: start * compressed.format.fetch(),
        end: (start + lines) * compressed.format.fetch(),
    };
    let format = &compressed.format;
    let (mut lanes, mut current) =
        (vec![LaneState::default(); format.lanes], vec![Template::NONE; format.lanes]);
    let (mut issues, mut cycle) = (Vec::new(), 0);
    let mut headers = VecDeque::new();
    for _ in 0..format.headers_ahead {
        headers.push_back(reader.header()?);
    }
    while let Some(header) = headers.pop_front() {
        headers.push_back(reader.header()?);
        if header.kind == EMPTY {
            cycle += header.run + 1;
            continue;
        }
        for (lane, template) in header.changes {
            current[lane] = template;
        }
        for (lane, template) in current.iter().enumerate() {
            let Some(code) = Code::of_field(u64::from(template.field), false) else { continue };
            issues.push(reader.lane(&mut lanes[lane], code, *template, (cycle, lane as u8))?);
        }
        for (unit, &op) in header.divider_ops.iter().enumerate() {
            let Some(code) = Code::of_field(op, true) else { continue };
            let a = reader.take(format.address_bits)? as u32;
            let b = if code == Code::Div { reader.take(format.address_bits)? as u32 } else { 0 };
            let destination = reader.take(format.address_bits)? as u32;
            issues.push(Issue { cycle, unit: unit as u8, code, operands: [a, b, 0], destination });
        }
        cycle += 1;
        if header.kind == LAST {
            debug_assert!(configuration.lanes == format.lanes);
            break;
        }
    }
    Ok(issues)
}

/// What an item is: its kind, the empty words after its first, the lanes that take a new template, what dividers do.
struct Header {
    kind: u64,
    run: u32,
    changes: Vec<(usize, Template)>,
    divider_ops: Vec<u64>,
}

struct Reader<'a> {
    compressed: &'a Compressed,
    at: usize,
    end: usize,
}

impl Reader<'_> {
    fn take(&mut self, bits: usize) -> Result<u64, Error> {
        if self.at + bits > self.end {
            return Err(Error::Damaged {
                word: self.at,
                detail: "the stream ends within an item".to_owned(),
            });
        }
        let fetch = self.compressed.format.fetch();
        let bit = |k: usize| self.compressed.lines.get(k / fetch, k % fetch, 1);
        let value = (0..bits).map(|k| bit(self.at + k) << k).sum();
        self.at += bits;
        Ok(value)
    }

    fn header(&mut self) -> Result<Header, Error> {
        let format = self.compressed.format;
        let kind = self.take(2)?;
        let mut header = Header { kind, run: 0, changes: Vec::new(), divider_ops: Vec::new() };
        if kind == EMPTY {
            header.run = self.take(RUN_BITS)? as u32;
        } else if kind != SAME {
            let mask = self.take(format.lanes)?;
            for lane in (0..format.lanes).filter(|lane| mask >> lane & 1 == 1) {
                let number = self.take(format.template_bits)?;
                header.changes.push((lane, self.compressed.table[number as usize]));
            }
            for _ in 0..format.dividers {
                header.divider_ops.push(self.take(2)?);
            }
        }
        Ok(header)
    }

    fn lane(
        &mut self,
        state: &mut LaneState,
        code: Code,
        template: Template,
        (cycle, unit): (u32, u8),
    ) -> Result<Issue, Error> {
        let format = self.compressed.format;
        let used = Template::full(code).modes;
        for k in (0..4).filter(|&k| used[k] == Mode::Full) {
            state.address[k] = match template.modes[k] {
                Mode::Kept if k == 3 => state.address[2],
                Mode::Kept => state.address[k],
                Mode::Step => format.sum(state.address[k], state.step[k]),
                Mode::Short => {
                    state.step[k] = format.sign_extend(self.take(format.short_bits)?);
                    format.sum(state.address[k], state.step[k])
                }
                Mode::Full => self.take(format.address_bits)? as u32,
            };
        }
        let mut operands = [0; 3];
        for (k, operand) in operands.iter_mut().enumerate() {
            *operand = if code.reads()[k] { state.address[k] } else { 0 };
        }
        Ok(Issue { cycle, unit, code, operands, destination: state.address[3] })
    }
}

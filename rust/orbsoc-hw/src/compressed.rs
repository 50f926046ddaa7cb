//! Compressed microcode: the same words in fewer bits, for a decoder in front of the issue register.
//! docs/pl-machine.md, "Compressed microcode".

use crate::code::Code;
use crate::configuration::Configuration;
use crate::error::Error;
use crate::microcode::Microcode;
use crate::schedule::{Issue, Schedule};
use crate::template::{choose, Format, Kept, Mode, Template};
use std::collections::HashMap;

/// The compressed microcode of several segments, with their common templates.
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
}

/// One segment's lines, and what they cost in time.
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

impl Compressed {
    /// Compress schedules of one engine.
    pub fn new(schedules: &[&Schedule], configuration: &Configuration) -> Self {
        let format = Format::new(configuration);
        let mut wishes = HashMap::new();
        for schedule in schedules {
            let mut lanes = vec![Kept::default(); format.lanes];
            for issue in schedule.issues.iter().filter(|issue| !issue.code.on_divider()) {
                let lane = &mut lanes[issue.unit as usize];
                let wish = lane.template(issue, &format);
                lane.write(issue, wish, &format);
                *wishes.entry(wish).or_default() += 1;
            }
        }
        let table = choose(&wishes, &format);
        let lines = Microcode::new(format.fetch(), 0);
        let mut this = Self { format, table, lines, segments: Vec::new(), freezes: Vec::new() };
        for schedule in schedules {
            this.append(schedule, configuration);
        }
        this
    }

    /// Bits of microcode in use, without the table.
    pub fn bits(&self) -> usize {
        self.segments.iter().map(|segment| segment.bits).sum()
    }

    /// The table's entries in hexadecimal.
    pub fn templates(&self) -> impl Iterator<Item = String> + '_ {
        self.table.iter().map(|template| format!("{:03x}", template.bits()))
    }

    fn append(&mut self, schedule: &Schedule, configuration: &Configuration) {
        let mut writer = Writer::new(&self.format, &self.table);
        let mut empty = 0;
        let mut next = schedule.issues.as_slice();
        for cycle in 0..schedule.words {
            let count = next.iter().take_while(|issue| issue.cycle == cycle).count();
            let (word, rest) = next.split_at(count);
            next = rest;
            let last = cycle + 1 == schedule.words;
            if word.is_empty() && !last {
                empty += 1;
                continue;
            }
            writer.empty_words(empty);
            empty = 0;
            writer.word(word, last);
        }
        let start = self.lines.len();
        let lines = writer.stream.lines(self.format.fetch());
        let freezes = freezes(&writer.items, lines.len(), self.format.fetch());
        let frozen = freezes.len() as u32;
        let timing = configuration.timing();
        let cycles = schedule.cycles + 1 + frozen;
        debug_assert!(cycles > timing.startup + timing.finish);
        self.segments.push(CompressedSegment {
            start,
            lines: lines.len(),
            bits: writer.stream.bits,
            frozen,
            cycles,
        });
        self.freezes.push(freezes);
        self.lines.append(&lines);
    }
}

/// An item: its length, and the words that it stands for.
type Item = (usize, u32);

/// The words that are waited for while the next item is not yet complete in the buffer, once a cycle.
fn freezes(items: &[Item], lines: usize, fetch: usize) -> Vec<u32> {
    let (mut fill, mut fetched, mut word, mut found) = (fetch, 1, 0, Vec::new());
    let mut items = items.iter().copied();
    let (mut rest, mut next) = (0, items.next());
    while rest > 0 || next.is_some() {
        let mut taken = 0;
        if rest > 0 {
            rest -= 1;
            word += 1;
        } else if let Some((length, words)) = next.filter(|(length, _)| fill >= *length) {
            (taken, rest) = (length, words - 1);
            word += 1;
            next = items.next();
        } else {
            found.push(word);
        }
        fill -= taken;
        if fetched < lines && fill <= 3 * fetch {
            fill += fetch;
            fetched += 1;
        }
    }
    found
}

/// Bits in their order.
#[derive(Default)]
struct Stream {
    limbs: Vec<u64>,
    bits: usize,
}

impl Stream {
    fn push(&mut self, value: u64, bits: usize) {
        debug_assert!(bits < 64 && value >> bits == 0, "{value} in {bits} bits");
        if bits == 0 {
            return;
        }
        let at = self.bits % 64;
        match self.limbs.last_mut() {
            Some(last) if at > 0 => {
                *last |= value << at;
                if at + bits > 64 {
                    self.limbs.push(value >> (64 - at));
                }
            }
            _ => self.limbs.push(value),
        }
        self.bits += bits;
    }

    fn lines(&self, fetch: usize) -> Microcode {
        let mut lines = Microcode::new(fetch, self.bits.div_ceil(fetch));
        // Lines are whole multiples of 32 bits.
        for from in (0..self.bits).step_by(32) {
            let half = self.limbs[from / 64] >> (from % 64) & u64::from(u32::MAX);
            lines.put(from / fetch, from % fetch, 32, half);
        }
        lines
    }
}

struct Writer<'a> {
    format: &'a Format,
    table: &'a [Template],
    number: HashMap<Template, usize>,
    lanes: Vec<Kept>,
    current: Vec<usize>,
    stream: Stream,
    items: Vec<Item>,
}

const SAME: u64 = 0;
const NEW: u64 = 1;
const EMPTY: u64 = 2;
const LAST: u64 = 3;
const RUN_BITS: usize = 8;

impl<'a> Writer<'a> {
    fn new(format: &'a Format, table: &'a [Template]) -> Self {
        let mut number = HashMap::new();
        for (k, template) in table.iter().enumerate() {
            number.entry(*template).or_insert(k);
        }
        Self {
            format,
            table,
            number,
            lanes: vec![Kept::default(); format.lanes],
            current: vec![0; format.lanes],
            stream: Stream::default(),
            items: Vec::new(),
        }
    }

    fn empty_words(&mut self, mut count: u32) {
        while count > 0 {
            let some = count.min(1 << RUN_BITS);
            self.stream.push(EMPTY, 2);
            self.stream.push(u64::from(some - 1), RUN_BITS);
            self.items.push((2 + RUN_BITS, some));
            count -= some;
        }
    }

    fn word(&mut self, word: &[Issue], last: bool) {
        let from = self.stream.bits;
        let mut templates = vec![0; self.format.lanes];
        let mut payload = Vec::new();
        let mut divider_ops = vec![0; self.format.dividers];
        for issue in word {
            if issue.code.on_divider() {
                divider_ops[issue.unit as usize] = u64::from(issue.code.field());
                let operands = if issue.code == Code::Div { 2 } else { 1 };
                let fields = issue.operands[..operands].iter().chain([&issue.destination]);
                payload.extend(fields.map(|&field| (u64::from(field), self.format.address_bits)));
            } else {
                let lane = issue.unit as usize;
                templates[lane] = self.template(issue);
                let template = self.table[templates[lane]];
                payload.extend(self.lanes[lane].write(issue, template, self.format));
            }
        }
        let changed: Vec<usize> =
            (0..self.format.lanes).filter(|&k| templates[k] != self.current[k]).collect();
        let divides = divider_ops.iter().any(|&op| op != 0);
        if changed.is_empty() && !divides && !last {
            self.stream.push(SAME, 2);
        } else {
            self.stream.push(if last { LAST } else { NEW }, 2);
            self.stream.push(changed.iter().map(|&lane| 1 << lane).sum(), self.format.lanes);
            for &lane in &changed {
                self.stream.push(templates[lane] as u64, self.format.template_bits);
            }
            for &op in &divider_ops {
                self.stream.push(op, 2);
            }
        }
        for (value, bits) in payload {
            self.stream.push(value, bits);
        }
        self.current = templates;
        self.items.push((self.stream.bits - from, 1));
    }

    /// The number of the cheapest template for an operation: the lane's last one, if it costs as little.
    fn template(&self, issue: &Issue) -> usize {
        let kept = &self.lanes[issue.unit as usize];
        let current = self.current[issue.unit as usize];
        let cost = |number: usize| {
            let payload = self.table[number].payload(self.format);
            // Of equal cost, the one that leaves the lane with a template that suits its run.
            (payload + if number == current { 0 } else { self.format.template_bits }, payload)
        };
        let wish = kept.template(issue, self.format);
        if let Some(&number) = self.number.get(&wish) {
            // Nothing else is shorter, and only staying costs less than a change.
            let stays =
                number == current || current != 0 && kept.allows(issue, self.table[current], self.format);
            return if stays && cost(current) <= cost(number) { current } else { number };
        }
        let possible = (1..self.table.len()).filter(|&k| kept.allows(issue, self.table[k], self.format));
        possible.min_by_key(|&k| cost(k)).unwrap_or(0)
    }
}

/// Flat words from compressed lines, as the decoder makes them.
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
    let (mut lanes, mut current) = (vec![Kept::default(); format.lanes], vec![Template::NONE; format.lanes]);
    let (mut issues, mut cycle) = (Vec::new(), 0);
    loop {
        let kind = reader.take(2)?;
        if kind == EMPTY {
            cycle += reader.take(RUN_BITS)? as u32 + 1;
            continue;
        }
        let mut divider_ops = vec![0; format.dividers];
        if kind != SAME {
            let mask = reader.take(format.lanes)?;
            for (lane, template) in current.iter_mut().enumerate() {
                if mask >> lane & 1 == 1 {
                    *template = compressed.table[reader.take(format.template_bits)? as usize];
                }
            }
            for op in &mut divider_ops {
                *op = reader.take(2)?;
            }
        }
        for (lane, template) in current.iter().enumerate() {
            let Some(code) = Code::of_field(u64::from(template.field), false) else { continue };
            issues.push(reader.lane(&mut lanes[lane], code, *template, (cycle, lane as u8))?);
        }
        for (unit, &op) in divider_ops.iter().enumerate() {
            let Some(code) = Code::of_field(op, true) else { continue };
            let a = reader.take(format.address_bits)? as u32;
            let b = if code == Code::Div { reader.take(format.address_bits)? as u32 } else { 0 };
            let destination = reader.take(format.address_bits)? as u32;
            issues.push(Issue { cycle, unit: unit as u8, code, operands: [a, b, 0], destination });
        }
        cycle += 1;
        if kind == LAST {
            debug_assert!(configuration.lanes == format.lanes);
            return Ok(issues);
        }
    }
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

    fn lane(
        &mut self,
        kept: &mut Kept,
        code: Code,
        template: Template,
        (cycle, unit): (u32, u8),
    ) -> Result<Issue, Error> {
        let format = self.compressed.format;
        let used = Template::full(code).modes;
        for k in (0..4).filter(|&k| used[k] == Mode::Full) {
            kept.address[k] = match template.modes[k] {
                Mode::Kept if k == 3 => kept.address[2],
                Mode::Kept => kept.address[k],
                Mode::Step => format.sum(kept.address[k], kept.step[k]),
                Mode::Short => {
                    kept.step[k] = format.long(self.take(format.short_bits)?);
                    format.sum(kept.address[k], kept.step[k])
                }
                Mode::Full => self.take(format.address_bits)? as u32,
            };
        }
        let mut operands = [0; 3];
        for (k, operand) in operands.iter_mut().enumerate() {
            *operand = if code.reads()[k] { kept.address[k] } else { 0 };
        }
        Ok(Issue { cycle, unit, code, operands, destination: kept.address[3] })
    }
}

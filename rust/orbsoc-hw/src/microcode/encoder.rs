//! Encoder of the compressed microcode. docs/pl-machine.md, "Compressed microcode".

use super::flat::Microcode;
use super::template::{FieldModes, Format, LaneState, Template, TEMPLATE_ENTRY};
use crate::machine::operation::Code;
use crate::schedule::scheduler::{Issue, Schedule};

/// Kinds of items.
pub(crate) const SAME: u64 = 0;
pub(crate) const NEW: u64 = 1;
pub(crate) const EMPTY: u64 = 2;
pub(crate) const LAST: u64 = 3;
/// Bits of a header that says no more than `SAME`.
pub(crate) const SAME_BITS: usize = 2;
/// Bits of a run of empty words.
pub(crate) const RUN_BITS: usize = 8;

/// An item: the bits of its header and of its payload, and the number of words that it encodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Item {
    pub header: usize,
    pub payload: usize,
    pub words: u32,
}

/// A bit stream.
#[derive(Default)]
pub(crate) struct Stream {
    limbs: Vec<u64>,
    pub bits: usize,
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

    /// Append bits of another stream.
    fn copy(&mut self, from: &Self, mut at: usize, bits: usize) {
        let end = at + bits;
        while at < end {
            let some = (64 - at % 64).min(end - at).min(32);
            self.push(from.limbs[at / 64] >> (at % 64) & ((1 << some) - 1), some);
            at += some;
        }
    }

    pub fn lines(&self, fetch: usize) -> Microcode {
        let mut lines = Microcode::new(fetch, self.bits.div_ceil(fetch));
        // Lines are whole multiples of 32 bits.
        for from in (0..self.bits).step_by(32) {
            let half = self.limbs[from / 64] >> (from % 64) & u64::from(u32::MAX);
            lines.put(from / fetch, from % fetch, 32, half);
        }
        lines
    }
}

/// A table of templates, indexed for the encoder.
pub(crate) struct Index<'a> {
    format: &'a Format,
    table: &'a [Template],
    /// For each template the modes that it needs, and the bits of its payload.
    needs: Vec<FieldModes>,
    payload: Vec<usize>,
    /// The number of a template by its bits; none: `table.len()`.
    number: Vec<u16>,
}

impl<'a> Index<'a> {
    pub fn new(format: &'a Format, table: &'a [Template]) -> Self {
        let mut number = vec![table.len() as u16; 1 << TEMPLATE_ENTRY];
        for (k, template) in table.iter().enumerate().rev() {
            number[template.bits()] = k as u16;
        }
        Self {
            format,
            table,
            needs: table.iter().map(|template| template.needs()).collect(),
            payload: table.iter().map(|template| template.payload(format)).collect(),
            number,
        }
    }

    /// The number of the cheapest template for an operation; of equally cheap ones the lane's current one.
    fn cheapest(&self, modes: FieldModes, current: usize) -> usize {
        let cost = |number: usize| {
            let payload = self.payload[number];
            // Of equal cost, the one with less payload: it is the better one for the rest of the chain.
            (payload + if number == current { 0 } else { self.format.template_bits }, payload)
        };
        let number = usize::from(self.number[modes.shortest().bits()]);
        if number < self.table.len() {
            // No other template is shorter; only keeping the current one may cost less than a change.
            let stays = number == current || current != 0 && modes.allow(self.needs[current]);
            return if stays && cost(current) <= cost(number) { current } else { number };
        }
        let possible = (1..self.table.len()).filter(|&k| modes.allow(self.needs[k]));
        possible.min_by_key(|&k| cost(k)).unwrap_or(0)
    }
}

/// Encode a schedule: its bits, and its items. Each header comes some payloads before its own; behind the last item's,
/// headers of `SAME` stand for those that are not there.
pub(crate) fn encode(schedule: &Schedule, index: &Index<'_>) -> (Stream, Vec<Item>) {
    let mut writer = Writer {
        index,
        lanes: vec![LaneState::default(); index.format.lanes],
        current: vec![0; index.format.lanes],
        templates: vec![0; index.format.lanes],
        headers: Stream::default(),
        payloads: Stream::default(),
        items: Vec::with_capacity(schedule.words as usize),
    };
    let (mut next, mut cycle) = (schedule.issues.as_slice(), 0);
    while cycle < schedule.words {
        // Empty words up to the next issue, or to the last word.
        let coming = next.first().map_or(schedule.words - 1, |issue| issue.cycle);
        writer.empty_words(coming - cycle);
        let (word, rest) = next.split_at(next.iter().take_while(|issue| issue.cycle == coming).count());
        writer.word(word, coming + 1 == schedule.words);
        (next, cycle) = (rest, coming + 1);
    }
    (writer.interleaved(), writer.items)
}

struct Writer<'a> {
    index: &'a Index<'a>,
    lanes: Vec<LaneState>,
    /// Template numbers of the lanes in the last word and in this one.
    current: Vec<usize>,
    templates: Vec<usize>,
    headers: Stream,
    payloads: Stream,
    items: Vec<Item>,
}

impl Writer<'_> {
    fn empty_words(&mut self, mut count: u32) {
        while count > 0 {
            let some = count.min(1 << RUN_BITS);
            self.headers.push(EMPTY, 2);
            self.headers.push(u64::from(some - 1), RUN_BITS);
            self.items.push(Item { header: 2 + RUN_BITS, payload: 0, words: some });
            count -= some;
        }
    }

    fn word(&mut self, word: &[Issue], last: bool) {
        let from = (self.headers.bits, self.payloads.bits);
        let format = self.index.format;
        self.templates.fill(0);
        let mut divider_ops = 0;
        for issue in word {
            let unit = issue.unit as usize;
            if issue.code.on_divider() {
                divider_ops |= u64::from(issue.code.field()) << (2 * unit);
            } else {
                let modes = self.lanes[unit].modes(issue, format);
                self.templates[unit] = self.index.cheapest(modes, self.current[unit]);
            }
        }
        self.header(divider_ops, last);
        let stream = &mut self.payloads;
        for issue in word {
            if issue.code.on_divider() {
                let operands = if issue.code == Code::Div { 2 } else { 1 };
                let fields = issue.operands[..operands].iter().chain([&issue.destination]);
                fields.for_each(|&field| stream.push(u64::from(field), format.address_bits));
            } else {
                let unit = issue.unit as usize;
                let template = self.index.table[self.templates[unit]];
                self.lanes[unit].write(issue, template, format, |value, bits| stream.push(value, bits));
            }
        }
        core::mem::swap(&mut self.current, &mut self.templates);
        let (header, payload) = (self.headers.bits - from.0, self.payloads.bits - from.1);
        self.items.push(Item { header, payload, words: 1 });
    }

    /// The kind of an item, and what changes from the last word to this one.
    fn header(&mut self, divider_ops: u64, last: bool) {
        let format = self.index.format;
        if self.templates == self.current && divider_ops == 0 && !last {
            self.headers.push(SAME, SAME_BITS);
            return;
        }
        self.headers.push(if last { LAST } else { NEW }, 2);
        let both = || self.templates.iter().zip(&self.current).enumerate();
        let changed = both().filter(|(_, (new, old))| new != old);
        self.headers.push(changed.clone().map(|(lane, _)| 1 << lane).sum(), format.lanes);
        for (_, (&new, _)) in changed {
            self.headers.push(new as u64, format.template_bits);
        }
        self.headers.push(divider_ops, 2 * format.dividers);
    }

    /// One stream of all headers and payloads.
    fn interleaved(&self) -> Stream {
        let (mut stream, mut header, mut payload) = (Stream::default(), 0, 0);
        for (before, behind) in chunks(&self.items, self.index.format.headers_ahead) {
            if let Some(item) = before {
                stream.copy(&self.headers, header, item.header);
                header += item.header;
            } else {
                stream.push(SAME, SAME_BITS);
            }
            if let Some(item) = behind {
                stream.copy(&self.payloads, payload, item.payload);
                payload += item.payload;
            }
        }
        stream
    }
}

/// Items in the order of the stream: whose header comes next, and whose payload comes after it.
pub(crate) fn chunks(
    items: &[Item],
    headers_ahead: usize,
) -> impl Iterator<Item = (Option<&Item>, Option<&Item>)> {
    (0..items.len() + headers_ahead)
        .map(move |k| (items.get(k), k.checked_sub(headers_ahead).map(|of| &items[of])))
}

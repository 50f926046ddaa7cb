//! Templates of the compressed microcode: an opcode and the encoding of each of its fields.

use crate::machine::configuration::Configuration;
use crate::machine::operation::Code;
use crate::schedule::scheduler::Issue;

/// How a field is encoded; docs/pl-machine.md, "Compressed microcode".
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Mode {
    Kept,
    Step,
    Short,
    Full,
}

/// An operation of a lane and the modes of a, b, c and dst.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Template {
    pub field: u8,
    pub modes: [Mode; 4],
}

impl Template {
    /// No operation.
    pub const NONE: Self = Self { field: 0, modes: [Mode::Kept; 4] };

    /// Escape: every field in full, for any operation of its code.
    pub fn full(code: Code) -> Self {
        let [a, b, c] = code.reads().map(|reads| if reads { Mode::Full } else { Mode::Kept });
        Self { field: code.field(), modes: [a, b, c, Mode::Full] }
    }

    /// As a table's entry.
    pub fn bits(self) -> usize {
        let modes = self.modes.iter().enumerate().map(|(k, &mode)| (mode as usize) << (4 + 2 * k));
        usize::from(self.field) | modes.sum::<usize>()
    }

    /// The modes that this template needs.
    pub fn needs(self) -> FieldModes {
        let modes = self.modes.iter().enumerate().map(|(k, &mode)| 1 << (4 * k + mode as usize));
        FieldModes { field: self.field, modes: modes.sum() }
    }

    /// Bits of the fields of one operation.
    pub fn payload(self, format: &Format) -> usize {
        let bits = |mode: &Mode| match mode {
            Mode::Kept | Mode::Step => 0,
            Mode::Short => format.short_bits,
            Mode::Full => format.address_bits,
        };
        self.modes.iter().map(bits).sum()
    }

    /// Whether it can encode all operations of another template. Steps fit short fields, since they came from them.
    fn covers(self, other: Self) -> bool {
        let covers = |(k, (mine, theirs)): (usize, (&Mode, &Mode))| {
            mine == theirs
                || *mine == Mode::Full
                || *mine == Mode::Short && *theirs != Mode::Full && (k < 3 || *theirs != Mode::Kept)
        };
        self.field == other.field && self.modes.iter().zip(&other.modes).enumerate().all(covers)
    }
}

/// The modes that can encode each field of an operation: four bits a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FieldModes {
    field: u8,
    modes: u16,
}

impl FieldModes {
    /// Whether all the modes of `needed` are among these.
    pub fn allow(self, needed: Self) -> bool {
        self.field == needed.field && needed.modes & !self.modes == 0
    }

    /// The template with the shortest mode of each field.
    pub fn shortest(self) -> Template {
        let mode = |k: usize| match (self.modes >> (4 * k) & 15).trailing_zeros() {
            0 => Mode::Kept,
            1 => Mode::Step,
            2 => Mode::Short,
            _ => Mode::Full,
        };
        Template { field: self.field, modes: [mode(0), mode(1), mode(2), mode(3)] }
    }
}

/// Decoder state of a lane: the last address and step of each field.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LaneState {
    pub address: [u32; 4],
    pub step: [u32; 4],
}

impl LaneState {
    /// The modes that can encode an operation in this state. An unused field is kept.
    pub fn modes(&self, issue: &Issue, format: &Format) -> FieldModes {
        let [a, b, c] = issue.code.reads();
        let mut modes = 0;
        for (k, used) in [a, b, c, true].into_iter().enumerate() {
            let wanted = field(issue, k);
            let kept = if k == 3 { c && issue.operands[2] == wanted } else { self.address[k] == wanted };
            let step = format.sum(self.address[k], self.step[k]) == wanted;
            let short = format.is_short(format.difference(wanted, self.address[k]));
            let field = u16::from(kept) | u16::from(step) << 1 | u16::from(short) << 2 | 1 << 3;
            modes |= if used { field } else { 1 } << (4 * k);
        }
        FieldModes { field: issue.code.field(), modes }
    }

    /// Encode an operation: `put` gets the value and the bits of each field of the payload.
    pub fn write(
        &mut self,
        issue: &Issue,
        template: Template,
        format: &Format,
        mut put: impl FnMut(u64, usize),
    ) {
        let [a, b, c] = issue.code.reads();
        for (k, _) in [a, b, c, true].into_iter().enumerate().filter(|(_, used)| *used) {
            let wanted = field(issue, k);
            match template.modes[k] {
                Mode::Kept | Mode::Step => {}
                Mode::Short => {
                    let step = format.difference(wanted, self.address[k]);
                    put(format.truncate(step), format.short_bits);
                    self.step[k] = step;
                }
                Mode::Full => put(u64::from(wanted), format.address_bits),
            }
            self.address[k] = wanted;
        }
    }
}

fn field(issue: &Issue, k: usize) -> u32 {
    if k == 3 {
        issue.destination
    } else {
        issue.operands[k]
    }
}

/// Bits of a template's number for which lines have room.
const MAX_TEMPLATE_BITS: usize = 7;

/// Widths of the stream's parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Format {
    pub lanes: usize,
    pub dividers: usize,
    pub address_bits: usize,
    pub short_bits: usize,
    pub template_bits: usize,
    pub headers_ahead: usize,
}

impl Format {
    /// That of an engine.
    pub fn new(configuration: &Configuration) -> Self {
        let timing = configuration.timing();
        Self {
            lanes: configuration.lanes,
            dividers: configuration.dividers,
            address_bits: configuration.address_bits as usize,
            short_bits: timing.short_bits as usize,
            template_bits: timing.template_bits as usize,
            headers_ahead: timing.headers_ahead as usize,
        }
    }

    /// Bits of a line, a power of two: 32 a lane, or more if the longest header and payload need it. They must fit three
    /// lines: with more in it, the decoder's buffer may take no further line.
    pub fn fetch(&self) -> usize {
        let item = |template_bits: usize| {
            let lane = 1 + template_bits + 4 * self.address_bits;
            2 + self.lanes * lane + self.dividers * (2 + 3 * self.address_bits)
        };
        debug_assert!(
            self.template_bits <= MAX_TEMPLATE_BITS,
            "lines have no room for these template numbers"
        );
        32 * self.lanes.max(item(MAX_TEMPLATE_BITS).div_ceil(96)).next_power_of_two()
    }

    /// Bits of a header's kind and mask.
    pub fn opening(&self) -> usize {
        2 + self.lanes
    }

    pub fn mask(&self) -> u32 {
        (1 << self.address_bits) - 1
    }

    pub fn sum(&self, address: u32, step: u32) -> u32 {
        address.wrapping_add(step) & self.mask()
    }

    fn difference(&self, to: u32, from: u32) -> u32 {
        to.wrapping_sub(from) & self.mask()
    }

    /// Whether a step fits into a short field.
    fn is_short(&self, step: u32) -> bool {
        let (half, whole) = (1u32 << (self.short_bits - 1), 1u32 << self.address_bits);
        step < half || step >= whole - half
    }

    /// A short step as a short field.
    fn truncate(&self, step: u32) -> u64 {
        debug_assert!(self.is_short(step), "{step} is no short step");
        u64::from(step) & ((1 << self.short_bits) - 1)
    }

    /// A short field as a step.
    pub fn sign_extend(&self, short: u64) -> u32 {
        let sign = 1u64 << (self.short_bits - 1);
        ((short ^ sign).wrapping_sub(sign) as u32) & self.mask()
    }
}

/// Candidate templates: for how many operations each is the shortest.
pub(crate) struct Candidates(Vec<(Template, u64)>);

impl Candidates {
    pub fn new() -> Self {
        Self(vec![(Template::NONE, 0); 1 << TEMPLATE_ENTRY])
    }

    /// Count one operation.
    pub fn add(&mut self, template: Template) {
        let (candidate, uses) = &mut self.0[template.bits()];
        (*candidate, *uses) = (template, *uses + 1);
    }

    /// Templates with their counts.
    fn all(&self) -> impl Iterator<Item = (Template, u64)> + '_ {
        self.0.iter().copied().filter(|(_, uses)| *uses > 0)
    }
}

/// Bits of a table's entry.
pub(crate) const TEMPLATE_ENTRY: usize = 12;

/// Greedy selection of the table: the escape of each code, then one by one the templates that save most bits.
pub(crate) fn choose(candidates: &Candidates, format: &Format) -> Vec<Template> {
    let mut table = vec![Template::NONE];
    for code in Code::ALL.into_iter().filter(|code| !code.on_divider()) {
        if candidates.all().any(|(candidate, _)| candidate.field == code.field()) {
            table.push(Template::full(code));
        }
    }
    let mut selection = Selection::new(candidates, &table, format);
    let size = 1 << format.template_bits;
    while table.len() < size {
        let Some(best) = selection.select() else { break };
        table.push(best);
    }
    table.resize(size, Template::NONE);
    table
}

/// Candidates that are not selected yet.
struct Selection(Vec<Candidate>);

struct Candidate {
    template: Template,
    bits: usize,
    uses: u64,
    /// Bits of one of its operations with the table so far.
    cost: usize,
    /// The candidates that it covers.
    covers: Vec<usize>,
}

impl Selection {
    fn new(candidates: &Candidates, table: &[Template], format: &Format) -> Self {
        let mut all: Vec<_> = candidates.all().collect();
        all.sort_unstable_by_key(|&(template, uses)| (core::cmp::Reverse(uses), template));
        all.truncate(MAX_CANDIDATES);
        let candidate = |&(template, uses): &(Template, u64)| {
            let full = table.iter().find(|full| full.field == template.field);
            let covered = all.iter().enumerate().filter(|(_, (other, _))| template.covers(*other));
            let covers = covered.map(|(k, _)| k).collect();
            let cost = full.map_or(0, |full| full.payload(format));
            Candidate { template, bits: template.payload(format), uses, cost, covers }
        };
        Self(all.iter().map(candidate).collect())
    }

    /// Bits that a candidate would save.
    fn saved(&self, candidate: &Candidate) -> u64 {
        let covered = candidate.covers.iter().map(|&k| &self.0[k]);
        covered.map(|other| other.uses * other.cost.saturating_sub(candidate.bits) as u64).sum()
    }

    /// Select the template that saves most bits, if one saves any.
    fn select(&mut self) -> Option<Template> {
        let saving = self.0.iter().map(|candidate| (self.saved(candidate), candidate.template)).enumerate();
        let (best, (saved, template)) = saving.max_by_key(|(_, saving)| *saving)?;
        let (bits, covers) = (self.0[best].bits, core::mem::take(&mut self.0[best].covers));
        for k in covers {
            self.0[k].cost = bits.min(self.0[k].cost);
        }
        (saved > 0).then_some(template)
    }
}

/// Only the most frequent candidates are considered: rarer ones save nothing.
const MAX_CANDIDATES: usize = 128;

#[cfg(test)]
mod tests {
    use super::*;

    fn sub_mul(modes: [Mode; 4]) -> Template {
        Template { field: Code::SubMul.field(), modes }
    }

    #[test]
    fn the_table_has_an_escape_and_then_what_saves_most_beside_it() {
        use Mode::{Full, Kept, Short, Step};
        let format = Format::new(&Configuration::default());
        let runs = sub_mul([Step, Kept, Step, Kept]);
        let gaps = sub_mul([Step, Kept, Short, Kept]);
        let rare = sub_mul([Short, Kept, Short, Kept]);
        let mut candidates = Candidates::new();
        for (template, uses) in [(runs, 100), (gaps, 30), (rare, 1)] {
            (0..uses).for_each(|_| candidates.add(template));
        }
        let table = choose(&candidates, &format);
        assert_eq!(table.len(), 1 << format.template_bits);
        assert_eq!(table[..2], [Template::NONE, Template::full(Code::SubMul)]);
        // 100 × 60 bits for runs alone, 130 × 54 for the one that covers gaps, too, 131 × 48 for the one that covers all.
        // Then 100 × 6 for runs, and 48 for the rare one.
        assert_eq!(table[2..5], [gaps, runs, rare]);
        assert!(table[5..].iter().all(|&template| template == Template::NONE));
        assert!(rare.covers(gaps) && gaps.covers(runs) && !runs.covers(gaps));
        assert!(!sub_mul([Short, Short, Short, Short]).covers(sub_mul([Full, Kept, Kept, Step])));
        assert!(!sub_mul([Short; 4]).covers(runs), "the word of c is not a step from the last destination");
    }
}

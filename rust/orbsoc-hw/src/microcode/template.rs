//! Templates of the compressed microcode: an opcode, and how each of its fields is written.

use crate::machine::configuration::Configuration;
use crate::machine::operation::Code;
use crate::schedule::scheduler::Issue;

/// How a field is written; docs/pl-machine.md, "Compressed microcode".
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

    /// Every field in full: fits any operation of its code.
    pub fn full(code: Code) -> Self {
        let [a, b, c] = code.reads().map(|reads| if reads { Mode::Full } else { Mode::Kept });
        Self { field: code.field(), modes: [a, b, c, Mode::Full] }
    }

    /// As a table's entry.
    pub fn bits(self) -> usize {
        let modes = self.modes.iter().enumerate().map(|(k, &mode)| (mode as usize) << (4 + 2 * k));
        usize::from(self.field) | modes.sum::<usize>()
    }

    /// What is written by this template fits these modes.
    pub fn needs(self) -> Fits {
        let modes = self.modes.iter().enumerate().map(|(k, &mode)| 1 << (4 * k + mode as usize));
        Fits { field: self.field, modes: modes.sum() }
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

    /// Whether it can write all that another one writes. Steps are short, for they came as short fields.
    fn serves(self, other: Self) -> bool {
        let serves = |(k, (mine, theirs)): (usize, (&Mode, &Mode))| {
            mine == theirs
                || *mine == Mode::Full
                || *mine == Mode::Short && *theirs != Mode::Full && (k < 3 || *theirs != Mode::Kept)
        };
        self.field == other.field && self.modes.iter().zip(&other.modes).enumerate().all(serves)
    }
}

/// For each field of an operation the modes in which it can be written: four bits a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Fits {
    field: u8,
    modes: u16,
}

impl Fits {
    /// Whether an operation that needs `needed` can be written where these modes fit.
    pub fn allow(self, needed: Self) -> bool {
        self.field == needed.field && needed.modes & !self.modes == 0
    }

    /// The shortest way to write each field.
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

/// Addresses and steps that a lane keeps.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Kept {
    pub address: [u32; 4],
    pub step: [u32; 4],
}

impl Kept {
    /// How an operation's fields can be written from here. A field that is not used is kept.
    pub fn fits(&self, issue: &Issue, format: &Format) -> Fits {
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
        Fits { field: issue.code.field(), modes }
    }

    /// Write an operation, field by field: each that adds to the payload goes to `put` as value and bits.
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
                    put(format.short(step), format.short_bits);
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
const LONGEST_NUMBER: usize = 7;

/// Widths of the stream's parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Format {
    pub lanes: usize,
    pub dividers: usize,
    pub address_bits: usize,
    pub short_bits: usize,
    pub template_bits: usize,
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
        }
    }

    /// Bits of a line: 32 for each lane, and as many as let the longest item fit into three lines, for the decoder's
    /// buffer takes no further line when it holds more than that.
    pub fn fetch(&self) -> usize {
        let item = |template_bits: usize| {
            let lane = 1 + template_bits + 4 * self.address_bits;
            2 + self.lanes * lane + self.dividers * (2 + 3 * self.address_bits)
        };
        debug_assert!(
            self.template_bits <= LONGEST_NUMBER,
            "lines are made for shorter numbers of templates"
        );
        32 * self.lanes.max(item(LONGEST_NUMBER).div_ceil(96))
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
    fn short(&self, step: u32) -> u64 {
        debug_assert!(self.is_short(step), "{step} is no short step");
        u64::from(step) & ((1 << self.short_bits) - 1)
    }

    /// A short field as a step.
    pub fn long(&self, short: u64) -> u32 {
        let sign = 1u64 << (self.short_bits - 1);
        ((short ^ sign).wrapping_sub(sign) as u32) & self.mask()
    }
}

/// How often each template was the shortest for an operation.
pub(crate) struct Wishes(Vec<(Template, u64)>);

impl Wishes {
    /// None yet.
    pub fn new() -> Self {
        Self(vec![(Template::NONE, 0); 1 << TEMPLATE_ENTRY])
    }

    /// Once more.
    pub fn add(&mut self, template: Template) {
        let (wish, times) = &mut self.0[template.bits()];
        (*wish, *times) = (template, *times + 1);
    }

    /// Those that there are, and how often.
    fn all(&self) -> impl Iterator<Item = (Template, u64)> + '_ {
        self.0.iter().copied().filter(|(_, times)| *times > 0)
    }
}

/// Bits of a table's entry.
pub(crate) const TEMPLATE_ENTRY: usize = 12;

/// The templates worth a place in the table: one for anything of each code, then, one by one, those that save most over
/// what is in it already.
pub(crate) fn choose(wishes: &Wishes, format: &Format) -> Vec<Template> {
    let mut table = vec![Template::NONE];
    for code in Code::ALL.into_iter().filter(|code| !code.on_divider()) {
        if wishes.all().any(|(wish, _)| wish.field == code.field()) {
            table.push(Template::full(code));
        }
    }
    let mut costly = Costly::new(wishes, &table, format);
    let size = 1 << format.template_bits;
    while table.len() < size {
        let Some(best) = costly.relieve() else { break };
        table.push(best);
    }
    table.resize(size, Template::NONE);
    table
}

/// What operations would be written by, and the bits that they cost with the table so far.
struct Costly(Vec<Wish>);

struct Wish {
    template: Template,
    bits: usize,
    times: u64,
    cost: usize,
    /// The wishes that it serves.
    serves: Vec<usize>,
}

impl Costly {
    fn new(wishes: &Wishes, table: &[Template], format: &Format) -> Self {
        let mut all: Vec<_> = wishes.all().collect();
        all.sort_unstable_by_key(|&(template, times)| (core::cmp::Reverse(times), template));
        all.truncate(WORTHWHILE);
        let wish = |&(template, times): &(Template, u64)| {
            let full = table.iter().find(|full| full.field == template.field);
            let served = all.iter().enumerate().filter(|(_, (other, _))| template.serves(*other));
            let serves = served.map(|(k, _)| k).collect();
            let cost = full.map_or(0, |full| full.payload(format));
            Wish { template, bits: template.payload(format), times, cost, serves }
        };
        Self(all.iter().map(wish).collect())
    }

    /// What a wish's template would save.
    fn saved(&self, wish: &Wish) -> u64 {
        let served = wish.serves.iter().map(|&k| &self.0[k]);
        served.map(|other| other.times * other.cost.saturating_sub(wish.bits) as u64).sum()
    }

    /// The template that saves most, if any saves; its savings are made.
    fn relieve(&mut self) -> Option<Template> {
        let saving = self.0.iter().map(|wish| (self.saved(wish), wish.template)).enumerate();
        let (best, (saved, template)) = saving.max_by_key(|(_, saving)| *saving)?;
        let (bits, serves) = (self.0[best].bits, core::mem::take(&mut self.0[best].serves));
        for k in serves {
            self.0[k].cost = bits.min(self.0[k].cost);
        }
        (saved > 0).then_some(template)
    }
}

/// Wishes that are looked at, the most frequent ones: rarer ones save nothing.
const WORTHWHILE: usize = 128;

#[cfg(test)]
mod tests {
    use super::*;

    fn sub_mul(modes: [Mode; 4]) -> Template {
        Template { field: Code::SubMul.field(), modes }
    }

    #[test]
    fn the_table_has_a_template_for_anything_and_then_what_saves_most_beside_it() {
        use Mode::{Full, Kept, Short, Step};
        let format = Format::new(&Configuration::default());
        let runs = sub_mul([Step, Kept, Step, Kept]);
        let gaps = sub_mul([Step, Kept, Short, Kept]);
        let rare = sub_mul([Short, Kept, Short, Kept]);
        let mut wishes = Wishes::new();
        for (template, times) in [(runs, 100), (gaps, 30), (rare, 1)] {
            (0..times).for_each(|_| wishes.add(template));
        }
        let table = choose(&wishes, &format);
        assert_eq!(table.len(), 1 << format.template_bits);
        assert_eq!(table[..2], [Template::NONE, Template::full(Code::SubMul)]);
        // 100 × 60 bits for runs alone, 130 × 54 for the one that serves gaps, too, 131 × 48 for the one that serves all.
        // Then 100 × 6 for runs, and 48 for the rare one.
        assert_eq!(table[2..5], [gaps, runs, rare]);
        assert!(table[5..].iter().all(|&template| template == Template::NONE));
        assert!(rare.serves(gaps) && gaps.serves(runs) && !runs.serves(gaps));
        assert!(!sub_mul([Short, Short, Short, Short]).serves(sub_mul([Full, Kept, Kept, Step])));
        assert!(!sub_mul([Short; 4]).serves(runs), "the word of c is not a step from the last destination");
    }
}

//! Flat microcode: one word a cycle, with fixed fields for every unit. docs/pl-machine.md, "Flat microcode".

use crate::error::Error;
use crate::machine::configuration::Configuration;
use crate::machine::operation::Code;
use crate::schedule::scheduler::{Issue, Schedule};

/// Words of equal width, packed from bit 0 of their first 64-bit limb on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Microcode {
    bits: usize,
    limbs: usize,
    data: Vec<u64>,
}

impl Microcode {
    /// `count` words of zeros.
    pub fn new(bits: usize, count: usize) -> Self {
        let limbs = bits.div_ceil(64);
        Self { bits, limbs, data: vec![0; limbs * count] }
    }

    /// Bits of a word.
    pub fn bits(&self) -> usize {
        self.bits
    }

    /// Number of words.
    pub fn len(&self) -> usize {
        self.data.len() / self.limbs
    }

    /// Whether there is no word.
    pub fn is_empty(&self) -> bool {
        self.data.is_empty()
    }

    /// A field of a word.
    pub fn get(&self, word: usize, from: usize, width: usize) -> u64 {
        let limbs = &self.data[word * self.limbs..(word + 1) * self.limbs];
        let (limb, shift) = (from / 64, from % 64);
        let low = limbs[limb] >> shift;
        let high = if shift + width > 64 { limbs[limb + 1] << (64 - shift) } else { 0 };
        (low | high) & (u64::MAX >> (64 - width))
    }

    /// Write a field that is still zero.
    pub fn put(&mut self, word: usize, from: usize, width: usize, value: u64) {
        let limbs = &mut self.data[word * self.limbs..(word + 1) * self.limbs];
        let (limb, shift) = (from / 64, from % 64);
        limbs[limb] |= value << shift;
        if shift + width > 64 {
            limbs[limb + 1] |= value >> (64 - shift);
        }
    }

    /// A word in hexadecimal, most significant digit first.
    pub fn hex(&self, word: usize) -> String {
        let digits = self.bits.div_ceil(4);
        let nibble = |k: usize| self.get(word, 4 * k, (self.bits - 4 * k).min(4));
        (0..digits).rev().map(|k| char::from_digit(nibble(k) as u32, 16).unwrap_or('?')).collect()
    }

    /// Some of the words, the last of them marked as the segment's last.
    pub fn select(&self, words: &[usize]) -> Self {
        let mut some = Self::new(self.bits, 0);
        for &word in words {
            some.data.extend_from_slice(&self.data[word * self.limbs..(word + 1) * self.limbs]);
        }
        if !words.is_empty() {
            some.put(words.len() - 1, 0, 1, 1);
        }
        some
    }

    /// `count` words from `first` on.
    pub fn range(&self, first: usize, count: usize) -> Self {
        let data = self.data[first * self.limbs..(first + count) * self.limbs].to_vec();
        Self { data, ..*self }
    }

    /// Append another segment's words.
    pub fn append(&mut self, other: &Self) {
        self.data.extend_from_slice(&other.data);
    }
}

/// Where the fields of a unit begin, and how wide the opcode is.
struct Fields {
    first: usize,
    address: usize,
    divider: bool,
}

impl Fields {
    fn of(configuration: &Configuration, divider: bool, unit: usize) -> Self {
        let address = configuration.address_bits as usize;
        let (lane, division) = (4 * address + 4, 3 * address + 2);
        let first = if divider { 1 + configuration.lanes * lane + unit * division } else { 1 + unit * lane };
        Self { first, address, divider }
    }

    /// Bits of operand a, b or c; a divider has no c.
    fn operand(&self, k: usize) -> usize {
        self.first + k * self.address
    }

    fn destination(&self) -> usize {
        self.first + if self.divider { 2 } else { 3 } * self.address
    }

    fn opcode(&self) -> (usize, usize) {
        (self.destination() + self.address, if self.divider { 2 } else { 4 })
    }
}

/// Write a schedule as flat microcode.
pub fn flat(schedule: &Schedule, configuration: &Configuration) -> Microcode {
    let mut microcode = Microcode::new(configuration.flat_bits(), schedule.words as usize);
    let address = configuration.address_bits as usize;
    for issue in &schedule.issues {
        let word = issue.cycle as usize;
        let fields = Fields::of(configuration, issue.code.on_divider(), issue.unit as usize);
        let reads = issue.code.reads();
        for (k, (&operand, reads)) in issue.operands.iter().zip(reads).enumerate() {
            if reads {
                microcode.put(word, fields.operand(k), address, u64::from(operand));
            }
        }
        microcode.put(word, fields.destination(), address, u64::from(issue.destination));
        let (from, width) = fields.opcode();
        microcode.put(word, from, width, u64::from(issue.code.field()));
    }
    microcode.put(schedule.words as usize - 1, 0, 1, 1);
    microcode
}

/// Decode a flat word: what it issues, and whether it is its segment's last.
///
/// # Errors
/// [`Error::Damaged`] when an opcode is invalid.
pub fn decode(
    microcode: &Microcode,
    word: usize,
    cycle: u32,
    configuration: &Configuration,
) -> Result<(Vec<Issue>, bool), Error> {
    let mut issues = Vec::new();
    let address = configuration.address_bits as usize;
    let lanes = (0..configuration.lanes).map(|unit| (false, unit));
    for (divider, unit) in lanes.chain((0..configuration.dividers).map(|unit| (true, unit))) {
        let fields = Fields::of(configuration, divider, unit);
        let (from, width) = fields.opcode();
        let field = microcode.get(word, from, width);
        if field == 0 {
            continue;
        }
        let code = Code::of_field(field, divider).ok_or_else(|| Error::Damaged {
            word,
            detail: format!("{field} is no operation of a {}", if divider { "divider" } else { "lane" }),
        })?;
        let mut operands = [0; 3];
        for (k, reads) in code.reads().into_iter().enumerate() {
            if reads {
                operands[k] = microcode.get(word, fields.operand(k), address) as u32;
            }
        }
        let destination = microcode.get(word, fields.destination(), address) as u32;
        issues.push(Issue { cycle, unit: unit as u8, code, operands, destination });
    }
    Ok((issues, microcode.get(word, 0, 1) == 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_cross_limbs_and_keep_to_themselves() {
        let mut microcode = Microcode::new(130, 2);
        microcode.put(1, 60, 14, 0x2abc);
        microcode.put(1, 126, 4, 0xd);
        assert_eq!((microcode.get(1, 60, 14), microcode.get(1, 126, 4)), (0x2abc, 0xd));
        assert_eq!((microcode.get(1, 59, 1), microcode.get(1, 74, 20), microcode.get(0, 60, 14)), (0, 0, 0));
        assert_eq!(microcode.hex(1).len(), 33);
        assert_eq!(microcode.hex(1)[..2], *"34");
    }
}

//! Memory image of a program: microcode of all segments, templates, literals.

use super::validation::{word_bits, Entry, Format, Sequence};
use crate::microcode::flat::{flat, Microcode};
use crate::program::Program;

/// What is loaded before the first segment runs; the layout has the addresses of the buffers' words.
#[derive(Clone, Debug)]
pub struct Image {
    /// Of compressed microcode, in the order of their numbers.
    pub templates: Vec<String>,
    /// Lines of all segments.
    pub microcode: Microcode,
    /// Position of each segment's lines, and its busy cycles.
    pub entries: Vec<(String, Entry)>,
    /// Address and bits of every literal.
    pub literals: Vec<(u32, u64)>,
}

impl Image {
    /// The program in one format of microcode.
    pub fn new(program: &Program, format: Format) -> Self {
        let mut sequence = Sequence::new(program, format);
        let mut entries = Vec::with_capacity(program.segments.len());
        for (number, segment) in program.segments.iter().enumerate() {
            let words = flat(&segment.schedule, &program.configuration);
            entries.push((segment.name(), sequence.append(number, segment, &words)));
        }
        let templates = sequence.compressed.as_ref().map(|c| c.templates().collect()).unwrap_or_default();
        let bits = |value| word_bits(program.configuration.precision, value);
        let literals = program.layout.constants().map(|(value, address)| (address, bits(value))).collect();
        Self { templates, microcode: sequence.microcode, entries, literals }
    }
}

//! Storage layout: the addresses of the buffers' words and of the constants, one map for all segments of a pattern.
//!
//! Every word that a segment reads or writes has an architectural location. Locations follow the order of the buffers:
//! neighbouring words lie in neighbouring banks, so the vector operations of the kernels meet no bank conflict.

use crate::error::Error;
use crate::machine::configuration::Configuration;
use orbsoc::real::Value;
use orbsoc::{word_of, Buffer, Recording, Tape};
use std::collections::HashMap;

/// Addresses of the literals that the scheduler needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Literals {
    pub one: u32,
    pub minus_zero: u32,
}

/// Addresses of every word that outlives a segment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    locations: Vec<Vec<Option<u32>>>,
    constants: HashMap<u64, u32>,
    words: u32,
}

impl Layout {
    /// The layout of a pattern.
    ///
    /// # Errors
    /// [`Error::Storage`] when it does not fit.
    pub fn new(recording: &Recording, configuration: &Configuration) -> Result<Self, Error> {
        let mut used: Vec<Vec<bool>> = recording.words.iter().map(|&words| vec![false; words]).collect();
        let mut constants: Vec<u64> = vec![1f64.to_bits(), (-0f64).to_bits()];
        for tape in &recording.tapes {
            mark(tape, &mut used, &mut constants);
        }
        let mut next = 0u32;
        let mut take = || {
            next += 1;
            next - 1
        };
        let locations =
            used.iter().map(|words| words.iter().map(|&used| used.then(&mut take)).collect()).collect();
        let constants = constants.into_iter().map(|bits| (bits, take())).collect();
        let layout = Self { locations, constants, words: next };
        if next as usize > configuration.words() {
            let (needed, available) = (next as usize, configuration.words());
            let key = configuration.storage_key();
            return Err(Error::Storage { key, needed_by: "buffers", needed, available });
        }
        Ok(layout)
    }

    /// Words in use; temporaries begin here.
    pub fn words(&self) -> u32 {
        self.words
    }

    /// Length of a buffer, unused words included.
    pub fn words_of(&self, buffer: Buffer) -> usize {
        self.locations[buffer as usize].len()
    }

    /// The address of a buffer's word; none if no segment reads or writes it.
    pub fn location(&self, buffer: Buffer, index: u32) -> Option<u32> {
        self.locations[buffer as usize].get(index as usize).copied().flatten()
    }

    /// The address of a literal.
    pub fn constant(&self, value: f64) -> Option<u32> {
        self.constants.get(&value.to_bits()).copied()
    }

    pub(crate) fn literals(&self) -> Literals {
        let of = |value: f64| self.constants[&value.to_bits()];
        Literals { one: of(1.0), minus_zero: of(-0.0) }
    }

    /// All locations: buffer, word, address.
    pub fn locations(&self) -> impl Iterator<Item = (Buffer, u32, u32)> + '_ {
        let words = |buffer: Buffer| self.locations[buffer as usize].iter().enumerate();
        let of = move |&buffer: &Buffer| {
            words(buffer).filter_map(move |(k, location)| location.map(|address| (buffer, k as u32, address)))
        };
        Buffer::ALL.iter().flat_map(of)
    }

    /// All literals and their addresses.
    pub fn constants(&self) -> impl Iterator<Item = (f64, u32)> + '_ {
        self.constants.iter().map(|(&bits, &address)| (f64::from_bits(bits), address))
    }
}

fn mark(tape: &Tape, used: &mut [Vec<bool>], constants: &mut Vec<u64>) {
    let mut seen = vec![false; tape.constants.len()];
    let mut see = |value: Value| match value {
        Value::Word { buffer, index } => used[usize::from(buffer)][index as usize] = true,
        Value::Constant(k) => {
            if core::mem::replace(&mut seen[k as usize], true) {
                return;
            }
            let bits = tape.constants[k as usize].to_bits();
            if !constants.contains(&bits) {
                constants.push(bits);
            }
        }
        Value::Result(_) => {}
    };
    for operation in &tape.operations {
        [Some(operation.a), operation.b, operation.c].into_iter().flatten().for_each(&mut see);
    }
    for store in &tape.stores {
        see(store.value);
        see(word_of(store.buffer, store.index));
    }
}

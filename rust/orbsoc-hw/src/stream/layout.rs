//! Where the buffers' words and the constants live: one map for all segments of a pattern.
//!
//! Every word that some segment reads, or leaves for somebody to read, has a home. Homes run in the
//! order of the buffers, so neighbours are in neighbouring banks and the vectors of the kernels meet no conflict.

use crate::error::Error;
use crate::machine::configuration::Configuration;
use orbsoc::real::Value;
use orbsoc::{word_of, Buffer, Recording, Tape};
use std::collections::HashMap;

/// Words that the scheduler itself asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Literals {
    pub one: u32,
    pub minus_zero: u32,
}

/// Addresses of everything that outlives a segment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    homes: Vec<Vec<Option<u32>>>,
    constants: HashMap<u64, u32>,
    words: u32,
}

impl Layout {
    /// The homes of a pattern.
    ///
    /// # Errors
    /// [`Error::Storage`] when they alone do not fit.
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
        let homes =
            used.iter().map(|words| words.iter().map(|&used| used.then(&mut take)).collect()).collect();
        let constants = constants.into_iter().map(|bits| (bits, take())).collect();
        let layout = Self { homes, constants, words: next };
        if next as usize > configuration.words() {
            let (needed, available) = (next as usize, configuration.words());
            return Err(Error::Storage { needed_by: "buffers", needed, available });
        }
        Ok(layout)
    }

    /// Words that are taken; temporaries begin here.
    pub fn words(&self) -> u32 {
        self.words
    }

    /// Words of a buffer, whether some segment touches them or not.
    pub fn words_of(&self, buffer: Buffer) -> usize {
        self.homes[buffer as usize].len()
    }

    /// The address of a buffer's word; none if no segment touches it.
    pub fn home(&self, buffer: Buffer, index: u32) -> Option<u32> {
        self.homes[buffer as usize].get(index as usize).copied().flatten()
    }

    /// The address of a literal.
    pub fn constant(&self, value: f64) -> Option<u32> {
        self.constants.get(&value.to_bits()).copied()
    }

    pub(crate) fn literals(&self) -> Literals {
        let of = |value: f64| self.constants[&value.to_bits()];
        Literals { one: of(1.0), minus_zero: of(-0.0) }
    }

    /// All homes: buffer, word, address.
    pub fn homes(&self) -> impl Iterator<Item = (Buffer, u32, u32)> + '_ {
        let words = |buffer: Buffer| self.homes[buffer as usize].iter().enumerate();
        let of = move |&buffer: &Buffer| {
            words(buffer).filter_map(move |(k, home)| home.map(|address| (buffer, k as u32, address)))
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

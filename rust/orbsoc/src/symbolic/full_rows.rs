//! A symmetric matrix by whole rows, of which the upper triangle's values are stored.

use crate::symbolic::indices::{begins, ordered};

#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Entry {
    /// Which of the values it is.
    pub value: u32,
    pub column: u32,
}

/// Of each row the diagonal, then what is left of it, then what is right.
#[derive(Clone, Debug)]
pub(crate) struct Rows {
    /// Where each row begins, and where all end.
    begins: Vec<u32>,
    entries: Vec<Entry>,
}

impl Rows {
    /// From an upper triangle's columns, each ascending with the diagonal last.
    pub fn new(colptr: &[u32], rowidx: &[u32]) -> Self {
        let columns = || (0..).zip(colptr.windows(2).map(|ends| ends[0]..ends[1] - 1));
        let entry = |value: u32, row: u32, column: u32| (row, Entry { value, column });
        let entries = || {
            let left = columns().flat_map(|(j, above)| {
                let at = move |k: u32| entry(k, j, rowidx[k as usize]);
                core::iter::once(at(above.end)).chain(above.map(at))
            });
            let right = columns().flat_map(|(j, above)| above.map(move |k| entry(k, rowidx[k as usize], j)));
            left.chain(right)
        };
        let begins = begins(colptr.len() - 1, entries().map(|(row, _)| row));
        let entries = ordered(&begins, entries());
        Self { begins, entries }
    }

    #[inline(always)]
    pub fn of(&self, row: usize) -> &[Entry] {
        &self.entries[self.begins[row] as usize..self.begins[row + 1] as usize]
    }
}

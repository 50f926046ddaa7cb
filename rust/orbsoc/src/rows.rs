//! A symmetric matrix by whole rows, of which the upper triangle's values are stored.

use crate::symbolic::index;

/// An entry of a row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    /// Which of the values it is.
    pub value: u32,
    pub column: u32,
}

/// Of each row the diagonal, then what is left of it, then what is right.
#[derive(Clone, Debug)]
pub(crate) struct Rows {
    begin: Vec<usize>,
    entries: Vec<Entry>,
}

impl Rows {
    /// From an upper triangle's columns, each ascending with the diagonal last.
    pub fn new(colptr: &[u32], rowidx: &[u32]) -> Self {
        let dim = colptr.len() - 1;
        let mut rows: Vec<Vec<Entry>> = vec![Vec::new(); dim];
        for j in 0..dim {
            let column = colptr[j] as usize..colptr[j + 1] as usize;
            for k in column.clone().rev().take(1).chain(column.start..column.end.max(1) - 1) {
                let (value, i) = (index(k), rowidx[k]);
                rows[j].push(Entry { value, column: i });
                if (i as usize) < j {
                    rows[i as usize].push(Entry { value, column: index(j) });
                }
            }
        }
        let ends = rows.iter().scan(0, |end, row| {
            *end += row.len();
            Some(*end)
        });
        Self { begin: core::iter::once(0).chain(ends).collect(), entries: rows.concat() }
    }

    #[inline(always)]
    pub fn of(&self, row: usize) -> &[Entry] {
        &self.entries[self.begin[row]..self.begin[row + 1]]
    }
}

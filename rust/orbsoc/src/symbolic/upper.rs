//! Patterns of symmetric matrices.

use crate::symbolic::indices::{begins, index, ordered};
use core::ops::Range;
use faer::sparse::SymbolicSparseColMatRef;

/// A square matrix's upper triangle, diagonal included, rows ascending in each column.
#[derive(Clone, Debug, Default)]
pub(crate) struct Upper {
    pub colptr: Vec<u32>,
    pub rowidx: Vec<u32>,
}

impl Upper {
    pub fn dim(&self) -> usize {
        self.colptr.len() - 1
    }

    pub fn nnz(&self) -> usize {
        self.rowidx.len()
    }

    /// Range of column `j`'s entries.
    pub fn range(&self, j: usize) -> Range<usize> {
        self.colptr[j] as usize..self.colptr[j + 1] as usize
    }

    /// Row indices of column `j`'s entries.
    pub fn column(&self, j: usize) -> &[u32] {
        &self.rowidx[self.range(j)]
    }

    pub fn faer(&self) -> SymbolicSparseColMatRef<'_, u32> {
        SymbolicSparseColMatRef::new_checked(self.dim(), self.dim(), &self.colptr, None, &self.rowidx)
    }

    /// From unordered (row, column); also returns where each of them went.
    pub fn from_positions(dim: usize, positions: &[(u32, u32)]) -> (Self, Vec<u32>) {
        let rows = begins(dim, positions.iter().map(|at| at.0));
        let by_row: Vec<u32> = ordered(&rows, positions.iter().zip(0..).map(|(at, k)| (at.0, k)));
        let colptr = begins(dim, positions.iter().map(|at| at.1));
        let mut next = colptr.clone();
        let (mut rowidx, mut place) = (vec![0; positions.len()], vec![0; positions.len()]);
        for k in by_row {
            let (row, column) = positions[k as usize];
            let at = &mut next[column as usize];
            (place[k as usize], rowidx[*at as usize]) = (*at, row);
            *at += 1;
        }
        (Self { colptr, rowidx }, place)
    }

    /// The upper triangle of `PKPᵀ`, and where each entry of K went.
    pub fn permuted(&self, order: &[u32]) -> (Self, Vec<u32>) {
        Self::from_positions(self.dim(), &self.positions_in(order))
    }

    /// The upper triangle of `PKPᵀ`.
    pub fn permuted_pattern(&self, order: &[u32]) -> Self {
        let (dim, positions) = (self.dim(), self.positions_in(order));
        let rows = begins(dim, positions.iter().map(|at| at.0));
        let by_row = ordered(&rows, positions.iter().copied());
        let colptr = begins(dim, positions.iter().map(|at| at.1));
        let columns = |row: usize| &by_row[rows[row] as usize..rows[row + 1] as usize];
        let entries = (0..dim).flat_map(|row| columns(row).iter().map(move |&column| (column, index(row))));
        let rowidx = ordered(&colptr, entries);
        Self { colptr, rowidx }
    }

    /// Row and column of each entry in `PKPᵀ`.
    fn positions_in(&self, order: &[u32]) -> Vec<(u32, u32)> {
        let mut inverse = vec![0; order.len()];
        for (&old, new) in order.iter().zip(0..) {
            inverse[old as usize] = new;
        }
        let mut positions = Vec::with_capacity(self.nnz());
        for j in 0..self.dim() {
            let b = inverse[j];
            positions.extend(self.column(j).iter().map(|&i| {
                let a = inverse[i as usize];
                (a.min(b), a.max(b))
            }));
        }
        positions
    }

    /// Below the diagonal, where each column's rows begin, and the rows, ascending.
    pub fn lower(&self) -> (Vec<u32>, Vec<u32>) {
        let entries = || {
            (0..self.dim()).flat_map(|j| {
                let above = self.column(j).iter().filter(move |&&i| (i as usize) < j);
                above.map(move |&i| (i, index(j)))
            })
        };
        let begins = begins(self.dim(), entries().map(|at| at.0));
        let rows = ordered(&begins, entries());
        (begins, rows)
    }
}

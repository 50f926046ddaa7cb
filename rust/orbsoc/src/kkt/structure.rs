//! Everything about a problem that its sparsity pattern decides: sizes, cones, KKT matrix, symbolic factorization.

use crate::error::Error;
use crate::kkt::assembly::{Kkt, SOC_DENSE_MAX};
use crate::problem::cones::{ConeLayout, Soc};
use crate::problem::problem::{Problem, Reduced};
use crate::problem::Csc;
use crate::symbolic::column_blocks::{column_blocks, ColumnBlock};
use crate::symbolic::{indices::index, ordering::Ordering, supernodes::Panels};

/// Positions of a sparse matrix's entries, column by column.
#[derive(Clone, Debug)]
pub(crate) struct Pattern {
    colptr: Vec<u32>,
    rowidx: Vec<u32>,
    column_blocks: Vec<ColumnBlock>,
}

impl Pattern {
    pub fn new(matrix: &Csc) -> Self {
        let colptr: Vec<u32> = matrix.colptr().iter().map(|&k| index(k)).collect();
        let rowidx: Vec<u32> = matrix.rowidx().iter().map(|&k| index(k)).collect();
        let rows = |j: usize| &rowidx[colptr[j] as usize..colptr[j + 1] as usize];
        let column_blocks = column_blocks(matrix.ncols(), rows);
        Self { colptr, rowidx, column_blocks }
    }

    /// Where each column begins, and the rows of all entries.
    pub fn lists(&self) -> (&[u32], &[u32]) {
        (&self.colptr, &self.rowidx)
    }

    pub fn nnz(&self) -> usize {
        self.rowidx.len()
    }

    /// All columns, by what they have in common.
    #[inline(always)]
    pub fn column_blocks(&self) -> &[ColumnBlock] {
        &self.column_blocks
    }

    /// Rows and entries of a block's entries.
    #[inline(always)]
    pub fn entries<'a, T>(&'a self, block: &ColumnBlock, values: &'a [T]) -> (&'a [u32], &'a [T]) {
        let entries = self.entries_of_block(block);
        (&self.rowidx[entries.clone()], &values[entries])
    }

    /// The same, to be changed.
    #[inline(always)]
    pub fn entries_mut<'a, T>(
        &'a self,
        block: &ColumnBlock,
        values: &'a mut [T],
    ) -> (&'a [u32], &'a mut [T]) {
        let entries = self.entries_of_block(block);
        (&self.rowidx[entries.clone()], &mut values[entries])
    }

    #[inline(always)]
    fn entries_of_block(&self, block: &ColumnBlock) -> core::ops::Range<usize> {
        self.colptr[block.columns.start] as usize..self.colptr[block.columns.end] as usize
    }

    /// Of each column of a dense block, whose entries are `values`: which it is, its first row, its entries.
    #[inline(always)]
    pub fn contiguous_columns<'a, T>(
        &'a self,
        block: &ColumnBlock,
        values: &'a [T],
    ) -> impl Iterator<Item = (usize, usize, &'a [T])> {
        let begin = self.colptr[block.columns.start] as usize;
        block.columns.clone().map(move |j| {
            let entries = self.column(j);
            (j, self.rowidx[entries.start] as usize, &values[entries.start - begin..entries.end - begin])
        })
    }

    /// Range of column `j`'s entries.
    #[inline(always)]
    pub fn column(&self, j: usize) -> core::ops::Range<usize> {
        self.colptr[j] as usize..self.colptr[j + 1] as usize
    }

    /// Row indices of the entries in `range`.
    #[inline(always)]
    pub fn rows(&self, range: core::ops::Range<usize>) -> &[u32] {
        &self.rowidx[range]
    }
}

/// The pattern's consequences, computed once.
#[derive(Clone, Debug)]
pub(crate) struct Structure {
    pub n: usize,
    /// Equality rows.
    pub p: usize,
    /// Cone rows, absent ones gone.
    pub m: usize,
    pub cones: ConeLayout,
    pub cost: Pattern,
    pub equality: Pattern,
    pub conic: Pattern,
    pub kkt: Kkt,
    pub reduced: Reduced,
}

impl Structure {
    pub fn new(problem: &Problem, ordering: Ordering, panels: Panels) -> Result<Self, Error> {
        let reduced = Reduced::new(problem);
        let m = reduced.row_origin.len();
        let mut cones = ConeLayout { l: reduced.l, soc: Vec::with_capacity(reduced.q.len()) };
        let (mut start, mut extra) = (reduced.l, m);
        for &dim in &reduced.q {
            let expansion = (dim > SOC_DENSE_MAX).then_some(extra);
            extra += if expansion.is_some() { 2 } else { 0 };
            cones.soc.push(Soc { start, dim, expansion });
            start += dim;
        }
        let kkt = Kkt::new(&problem.p, &problem.a, &reduced.g, &cones, ordering, panels)?;
        Ok(Self {
            n: problem.n(),
            p: problem.p(),
            m,
            cost: Pattern::new(&problem.p),
            equality: Pattern::new(&problem.a),
            conic: Pattern::new(&reduced.g),
            cones,
            kkt,
            reduced,
        })
    }

    /// As [`Structure::new`], for lanes.
    pub fn for_lanes(problem: &Problem, ordering: Ordering) -> Result<Self, Error> {
        let structure = Self::new(problem, ordering, Panels::Lanes)?;
        Ok(Self { kkt: structure.kkt.by_rows(), ..structure })
    }

    /// Length of (x, y, z).
    pub fn unknowns(&self) -> usize {
        self.n + self.p + self.m
    }
}

//! The KKT system's pattern, its permuted order, and where every block of it is written.
//!
//! ```text
//! ⎡ P   Aᵀ   Gᵀ       ⎤
//! ⎢ A                  ⎥      a cone of dimension > SOC_DENSE_MAX is written
//! ⎣ G       −W²  (v u) ⎦      −W² = −η²(D + uuᵀ − vvᵀ) with two more rows and columns
//! ```
//! Pivot signs: + for x and u-rows, − for everything else.

use crate::error::Error;
use crate::problem::cones::{ConeLayout, Soc};
use crate::problem::Csc;
use crate::symbolic::column_blocks::{column_blocks, ColumnBlock};
use crate::symbolic::ordering::{fill_reducing_order, FactorShape, Ordering};
use crate::symbolic::{factor_layout::Symbolic, full_rows::Rows, indices::index};
use crate::symbolic::{supernodes::Panels, upper::Upper};

/// More entries overflow the 32-bit sums of the fill-reducing order, which works in 2.4 times that number.
const MOST_ENTRIES: usize = 1 << 29;

/// Blocks of second-order cones up to this dimension are stored densely.
pub(crate) const SOC_DENSE_MAX: usize = 4;

/// Pattern of the permuted upper triangle and the maps into its values.
#[derive(Clone, Debug)]
pub(crate) struct Kkt {
    pub dim: usize,
    pub colptr: Vec<u32>,
    pub rowidx: Vec<u32>,
    /// Permuted position of each natural unknown: x, y, z, then expansion rows.
    pub position: Vec<u32>,
    /// True where the pivot is positive, in permuted order.
    pub positive: Vec<bool>,
    /// Where the entries of P, A and G are written.
    pub from_p: Vec<u32>,
    pub from_a: Vec<u32>,
    pub from_g: Vec<u32>,
    /// Where −W² of the nonnegative rows is written.
    pub orthant: Vec<u32>,
    /// Where each second-order block is written; see [`block_positions`].
    pub soc: Vec<Vec<u32>>,
    /// Its columns, the diagonal left out, by what they have in common.
    pub column_blocks: Vec<ColumnBlock>,
    pub symbolic: Symbolic,
    /// The matrix by rows, for entries so large that one is best written once: see [`Kkt::by_rows`].
    pub rows: Option<Rows>,
}

impl Kkt {
    pub fn new(
        p: &Csc,
        a: &Csc,
        g: &Csc,
        cones: &ConeLayout,
        ordering: Ordering,
        panels: Panels,
    ) -> Result<Self, Error> {
        let (n, me, m) = (p.ncols(), a.nrows(), g.nrows());
        let expanded = cones.soc.iter().filter(|c| c.expansion.is_some()).count();
        let dim = n + me + m + 2 * expanded;
        let row0 = n + me;
        let written = p.nnz() + a.nnz() + g.nnz() + cones.soc.iter().map(block_entries).sum::<usize>();
        let mut entries: Vec<(u32, u32)> = Vec::with_capacity(dim + written);
        entries.extend((0..index(dim)).map(|i| (i, i)));
        // Of P's, A's, G's and the cones' entries, one after the other.
        let mut places = Vec::with_capacity(written);
        let mut place = |row: usize, column: usize| {
            places.push(if row == column { row } else { entries.len() });
            if row != column {
                entries.push((index(row), index(column)));
            }
        };
        p.triplets().for_each(|(i, j, _)| place(i, j));
        a.triplets().for_each(|(i, j, _)| place(j, n + i));
        g.triplets().for_each(|(i, j, _)| place(j, row0 + i));
        cones.soc.iter().for_each(|cone| block_positions(cone, row0, &mut place));

        if entries.len() > MOST_ENTRIES {
            return Err(Error::TooLarge { what: "the KKT matrix", size: entries.len() });
        }
        let (natural, natural_place) = Upper::from_positions(dim, &entries);
        let order = fill_reducing_order(&natural, ordering)?;
        let (permuted, permuted_place) = natural.permuted(&order);
        let symbolic = Symbolic::new(&permuted, panels)?;

        let go = |k: usize| permuted_place[natural_place[k] as usize];
        let mut rest = &places[..];
        let mut take = |count: usize| -> Vec<u32> {
            let (these, after) = rest.split_at(count);
            rest = after;
            these.iter().map(|&k| go(k)).collect()
        };
        let mut position = vec![0; dim];
        let mut positive = vec![false; dim];
        for (new, &old) in order.iter().enumerate() {
            position[old as usize] = index(new);
            positive[new] = (old as usize) < n;
        }
        for cone in &cones.soc {
            if let Some(row) = cone.expansion {
                positive[position[row0 + row + 1] as usize] = true;
            }
        }
        let Upper { colptr, rowidx } = permuted;
        let above = |j: usize| &rowidx[colptr[j] as usize..colptr[j + 1] as usize - 1];
        Ok(Self {
            dim,
            column_blocks: column_blocks(dim, above),
            colptr,
            rowidx,
            position,
            positive,
            from_p: take(p.nnz()),
            from_a: take(a.nnz()),
            from_g: take(g.nnz()),
            orthant: (row0..row0 + cones.l).map(go).collect(),
            soc: cones.soc.iter().map(|cone| take(block_entries(cone))).collect(),
            symbolic,
            rows: None,
        })
    }

    /// For lanes: a vector of eight problems' entries does not fit the nearest cache, and an entry that is written
    /// there again and again costs three times what reading it does.
    pub fn by_rows(mut self) -> Self {
        self.rows = Some(Rows::new(&self.colptr, &self.rowidx));
        self
    }

    /// Range of column `j`'s entries.
    #[inline(always)]
    pub fn column(&self, j: usize) -> core::ops::Range<usize> {
        self.colptr[j] as usize..self.colptr[j + 1] as usize
    }

    /// How much there is to factor.
    pub fn factor_shape(&self) -> FactorShape {
        FactorShape::of(&Upper { colptr: self.colptr.clone(), rowidx: self.rowidx.clone() })
    }

    pub fn nnz(&self) -> usize {
        self.rowidx.len()
    }
}

/// Entries of one second-order block in the order in which the matrix update writes them.
/// Dense: the upper triangle, column by column. Expanded: the diagonal of D, then v without its
/// structurally zero head, v's pivot, u, u's pivot.
fn block_positions(cone: &Soc, row0: usize, place: &mut impl FnMut(usize, usize)) {
    let rows = row0 + cone.start..row0 + cone.start + cone.dim;
    match cone.expansion {
        None => rows.clone().for_each(|j| (rows.start..=j).for_each(|i| place(i, j))),
        Some(extra) => {
            let (v, u) = (row0 + extra, row0 + extra + 1);
            rows.clone().for_each(|i| place(i, i));
            rows.clone().skip(1).for_each(|i| place(i, v));
            place(v, v);
            rows.for_each(|i| place(i, u));
            place(u, u);
        }
    }
}

/// Their number.
fn block_entries(cone: &Soc) -> usize {
    match cone.expansion {
        None => cone.dim * (cone.dim + 1) / 2,
        Some(_) => 3 * cone.dim + 1,
    }
}

//! PL module *matrix factorization*: numeric LDLᵀ on the symbolic factorization of set-up.
//!
//! Right-looking over supernodes, in place. With y = L·D the column before its division, every entry receives
//! `l_ij ← k_ij − Σ_k l_ik·y_jk` in ascending k, whatever the supernodes are; then `d_j` is
//! regularised and the column divided by it.

#![allow(clippy::needless_range_loop)] // constant ranges over arrays unroll; iterators over them do not always

use super::supernodal::condensed::{self, Condensed};
use super::supernodal::pivots::{divide, regularized, Regularization};
use super::supernodal::simplicial::{self, Simplicial};
use super::supernodal::update::{
    subtract, subtract_leaves, subtract_scattered, Columns, SamePanel, ScatterTarget,
};
use super::supernodal::watch::{Watch, PIECE};
use crate::real::{outline, Real};
use crate::symbolic::factor_layout::{Supernode, Symbolic};
use crate::symbolic::supernodes::Kind;

/// Columns `l` as panels, reciprocal pivots; scratch holds one panel's unscaled columns.
pub struct Factor<'a, T> {
    pub l: &'a mut [T],
    pub pivot_inverse: &'a mut [T],
    pub scratch: &'a mut [T],
}

/// Factor `values` (permuted upper triangle). `positive` holds the pivots' signs. What `watch` has stopped is no factor.
#[inline(always)]
pub fn factorize<T: Real>(
    symbolic: &Symbolic,
    positive: &[bool],
    regularization: Regularization<T>,
    values: &[T],
    Factor { l, pivot_inverse, scratch }: Factor<T>,
    watch: &mut impl Watch,
) {
    l.fill(T::zero());
    for run in &symbolic.entry_runs {
        for (&to, &value) in symbolic.entry_targets[run.targets.clone()].iter().zip(&values[run.values..]) {
            l[to as usize] = value;
        }
    }
    for node in &symbolic.supernodes {
        if watch.stops(node.width * node.leading_dim) {
            return;
        }
        let own = node.first..node.first + node.width;
        let (positive, pivot_inverse) = (&positive[own.clone()], &mut pivot_inverse[own]);
        if node.kind == Kind::Condensed {
            let condensed = Condensed::of(symbolic, node, values);
            condensed::factor(condensed, positive, regularization, pivot_inverse);
            condensed::contribute(
                condensed,
                pivot_inverse,
                symbolic.scatter_indices(node),
                scratch,
                &mut l[node.panel..],
            );
            continue;
        }
        if node.kind == Kind::Simplicial {
            outline::<T>(simplicial::Factor {
                columns: Simplicial::of(symbolic, node),
                scatter: symbolic.scatter_indices(node),
                positive,
                regularization,
                l: &mut l[node.panel..],
                y: scratch,
                pivot_inverse,
            });
            continue;
        }
        let entries = node.width * node.leading_dim;
        let (panel, trailing) = l[node.panel..].split_at_mut(entries);
        let y = &mut scratch[..entries];
        if node.diagonal_size == 1 {
            factor_independent(node.leading_dim, positive, regularization, panel, y, pivot_inverse);
        } else {
            factor_supernodes(node, positive, regularization, (panel, y), pivot_inverse, watch);
        }
        if node.diagonal_size < node.leading_dim {
            contribute(
                symbolic,
                node,
                Columns { l: panel, y, leading_dim: node.leading_dim },
                trailing,
                watch,
            );
        }
    }
}

/// Independent columns.
#[inline(always)]
fn factor_independent<T: Real>(
    leading_dim: usize,
    positive: &[bool],
    regularization: Regularization<T>,
    panel: &mut [T],
    y: &mut [T],
    pivot_inverse: &mut [T],
) {
    let columns = panel.chunks_exact_mut(leading_dim).zip(y.chunks_exact_mut(leading_dim));
    for (((column, y), &positive), inverse) in columns.zip(positive).zip(pivot_inverse) {
        *inverse = T::one() / regularized(column[0], positive, regularization);
        divide(&mut column[1..], &mut y[1..], *inverse);
    }
}

/// One diagonal block after the other.
#[inline(always)]
fn factor_supernodes<T: Real>(
    node: &Supernode,
    positive: &[bool],
    by: Regularization<T>,
    (mut panel, mut y): (&mut [T], &mut [T]),
    mut pivot_inverse: &mut [T],
    watch: &mut impl Watch,
) {
    let leading_dim = node.leading_dim;
    for positive in positive.chunks(node.diagonal_size) {
        let (chain, chain_y, inverse);
        (chain, panel) = panel.split_at_mut(positive.len() * leading_dim);
        (chain_y, y) = y.split_at_mut(positive.len() * leading_dim);
        (inverse, pivot_inverse) = pivot_inverse.split_at_mut(positive.len());
        match positive.len() {
            2 => factor_block::<T, 2>(leading_dim, 0, positive, by, chain, chain_y, inverse),
            3 => factor_block::<T, 3>(leading_dim, 0, positive, by, chain, chain_y, inverse),
            4 => factor_block::<T, 4>(leading_dim, 0, positive, by, chain, chain_y, inverse),
            _ => factor_supernode(leading_dim, positive, by, (chain, chain_y), inverse, watch),
        }
    }
}

/// A dense supernode, left-looking in blocks of columns.
#[inline(always)]
fn factor_supernode<T: Real>(
    leading_dim: usize,
    positive: &[bool],
    regularization: Regularization<T>,
    (panel, y): (&mut [T], &mut [T]),
    pivot_inverse: &mut [T],
    watch: &mut impl Watch,
) {
    const BLOCK: usize = 4;
    let width = positive.len();
    for first in (0..width).step_by(BLOCK) {
        let end = (first + BLOCK).min(width);
        let (earlier, block) = panel.split_at_mut(first * leading_dim);
        if first > 0 {
            let columns = Columns { l: earlier, y: &y[..first * leading_dim], leading_dim };
            subtract(columns, (first, end), &SamePanel { leading_dim, first }, block);
            if watch.stops(first * (end - first) * (leading_dim - first)) {
                return;
            }
        }
        let y = &mut y[first * leading_dim..end * leading_dim];
        let block = &mut block[..(end - first) * leading_dim];
        let (positive, inverse) = (&positive[first..end], &mut pivot_inverse[first..end]);
        match end - first {
            1 => factor_block::<T, 1>(leading_dim, first, positive, regularization, block, y, inverse),
            2 => factor_block::<T, 2>(leading_dim, first, positive, regularization, block, y, inverse),
            3 => factor_block::<T, 3>(leading_dim, first, positive, regularization, block, y, inverse),
            _ => factor_block::<T, BLOCK>(leading_dim, first, positive, regularization, block, y, inverse),
        }
    }
}

/// `W` ≤ 4 columns of a supernode, from row `first` of the panel on.
#[inline(always)]
fn factor_block<T: Real, const W: usize>(
    leading_dim: usize,
    first: usize,
    positive: &[bool],
    regularization: Regularization<T>,
    panel: &mut [T],
    y: &mut [T],
    pivot_inverse: &mut [T],
) {
    let mut at = Block { leading_dim, first, positive, regularization, panel, y, pivot_inverse };
    at.factor_column::<0>();
    if W > 1 {
        at.factor_column::<1>();
    }
    if W > 2 {
        at.factor_column::<2>();
    }
    if W > 3 {
        at.factor_column::<3>();
    }
}

/// Adjacent columns of a supernode, from row `first` of the panel on.
struct Block<'a, T> {
    leading_dim: usize,
    first: usize,
    positive: &'a [bool],
    regularization: Regularization<T>,
    panel: &'a mut [T],
    y: &'a mut [T],
    pivot_inverse: &'a mut [T],
}

impl<T: Real> Block<'_, T> {
    /// The column that has `C` columns of the block before it.
    #[inline(always)]
    fn factor_column<const C: usize>(&mut self) {
        let (leading_dim, top) = (self.leading_dim, self.first + C);
        let (before, column) = self.panel.split_at_mut(C * leading_dim);
        let (y_before, y) = self.y.split_at_mut(C * leading_dim);
        let column = &mut column[top..leading_dim];
        let mut l: [&[T]; C] = [&[]; C];
        let mut factor = [T::zero(); C];
        for k in 0..C {
            l[k] = &before[k * leading_dim..][top..leading_dim];
            factor[k] = y_before[k * leading_dim + top];
        }
        let mut pivot = column[0];
        for k in 0..C {
            pivot = pivot.sub_mul(l[k][0], factor[k]);
            l[k] = &l[k][1..];
        }
        let inverse = T::one() / regularized(pivot, self.positive[C], self.regularization);
        self.pivot_inverse[C] = inverse;
        subtract_and_divide(&mut column[1..], &mut y[top + 1..leading_dim], l, factor, inverse);
    }
}

/// `y ← column − Σ_k l_k·factor_k`, the k in order, and `column ← y·inverse`.
#[inline(always)]
fn subtract_and_divide<T: Real, const C: usize>(
    column: &mut [T],
    y: &mut [T],
    mut l: [&[T]; C],
    factor: [T; C],
    inverse: T,
) {
    let y = &mut y[..column.len()];
    for k in 0..C {
        l[k] = &l[k][..column.len()];
    }
    for i in 0..column.len() {
        let mut entry = column[i];
        for k in 0..C {
            entry = entry.sub_mul(l[k][i], factor[k]);
        }
        y[i] = entry;
        column[i] = entry * inverse;
    }
}

/// Subtract a finished supernode's contribution from the trailing ones.
#[inline(always)]
fn contribute<T: Real, W: Watch>(
    symbolic: &Symbolic,
    node: &Supernode,
    columns: Columns<T>,
    trailing: &mut [T],
    watch: &mut W,
) {
    if node.scatter_range.is_some() {
        let scatter = symbolic.scatter_indices(node);
        if node.kind == Kind::Leaves {
            return subtract_leaves(columns, scatter, trailing);
        }
        return match node.width {
            1 => subtract_scattered::<T, 1>(columns, node.diagonal_size, scatter, trailing),
            2 => subtract_scattered::<T, 2>(columns, node.diagonal_size, scatter, trailing),
            3 => subtract_scattered::<T, 3>(columns, node.diagonal_size, scatter, trailing),
            _ => subtract_scattered::<T, 4>(columns, node.diagonal_size, scatter, trailing),
        };
    }
    let rows = symbolic.row_structure(node);
    let end = node.panel + node.width * node.leading_dim;
    for update in &symbolic.updates[node.updates.0..node.updates.1] {
        let target = &symbolic.supernodes[update.target];
        let first = rows[update.lo - node.diagonal_size] as usize;
        let scatter = RelativeIndices {
            columns: &rows[update.lo - node.diagonal_size..update.hi - node.diagonal_size],
            rows: &symbolic.relative[update.relative..][..node.leading_dim - update.lo],
            lo: update.lo,
            leading_dim: target.leading_dim,
            first,
        };
        let panel = &mut trailing[symbolic.column_begin(target, first) - end..];
        if !W::LOOKS {
            subtract(columns, (update.lo, update.hi), &scatter, panel);
            continue;
        }
        let work = node.width * (node.leading_dim - update.lo); // of a column
        let piece = PIECE.div_ceil(work).next_multiple_of(T::TILE_COLS);
        for lo in (update.lo..update.hi).step_by(piece) {
            let hi = update.hi.min(lo + piece);
            subtract(columns, (lo, hi), &scatter, panel);
            if watch.stops((hi - lo) * work) {
                return;
            }
        }
    }
}

/// In another supernode's panel.
struct RelativeIndices<'a> {
    /// Columns of the matrix that the source's rows `lo..hi` are.
    columns: &'a [u32],
    /// Rows of the target's panel that the source's rows `lo..` are.
    rows: &'a [u32],
    lo: usize,
    /// Of the target.
    leading_dim: usize,
    /// First column of the matrix among its targets.
    first: usize,
}

impl ScatterTarget for RelativeIndices<'_> {
    const DENSE: bool = false;

    #[inline(always)]
    fn row(&self, row: usize) -> usize {
        self.rows[row - self.lo] as usize
    }

    #[inline(always)]
    fn column(&self, column: usize) -> usize {
        (self.columns[column - self.lo] as usize - self.first) * self.leading_dim
    }
}

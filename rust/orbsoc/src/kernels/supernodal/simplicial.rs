//! Simplicial columns: one after the other, each with its own rows. Short columns cost less so than as supernodes.
//!
//! Each loop is outlined, so that those of other supernodes keep their registers.

use super::panel::subtract;
use super::pivots::{divide, regularized, Regularization};
use super::update::{subtract_scattered, Columns};
use crate::real::{Outlined, Real};
use crate::symbolic::factor_layout::{Supernode, Symbolic};

/// Where they begin, and their rows.
#[derive(Clone, Copy)]
pub struct Simplicial<'a> {
    /// Number of rows below the columns before each; then, below all of them.
    starts: &'a [u32],
    /// Rows of the matrix below each column, counted from the first column.
    below: &'a [u32],
}

impl<'a> Simplicial<'a> {
    /// The columns of a supernode of kind `Simplicial`.
    #[inline(always)]
    pub fn of(symbolic: &'a Symbolic, node: &Supernode) -> Self {
        Self { starts: symbolic.starts_of(node), below: symbolic.relative_rows(node) }
    }

    /// Number of rows of each column below its diagonal.
    #[inline(always)]
    fn lengths(self) -> impl Iterator<Item = usize> + 'a {
        self.starts.windows(2).map(
            #[inline(always)]
            |ends| (ends[1] - ends[0]) as usize,
        )
    }

    /// Each column's entries below its diagonal, of `l`, and their rows.
    #[inline(always)]
    fn columns<T>(
        self,
        l: &'a [T],
    ) -> impl DoubleEndedIterator<Item = (&'a [T], &'a [u32])> + ExactSizeIterator {
        let below = self.below;
        self.starts.windows(2).enumerate().map(
            #[inline(always)]
            move |(k, ends)| {
                let (begin, end) = (ends[0] as usize, ends[1] as usize);
                (&l[k + 1..][begin..end], &below[begin..end])
            },
        )
    }
}

/// Reciprocal pivots and columns; each column's update is subtracted at its scatter indices.
pub struct Factor<'a, T> {
    pub columns: Simplicial<'a>,
    pub scatter: &'a [u32],
    pub positive: &'a [bool],
    pub regularization: Regularization<T>,
    /// From the first of their entries on.
    pub l: &'a mut [T],
    pub y: &'a mut [T],
    pub pivot_inverse: &'a mut [T],
}

impl<T: Real> Outlined for Factor<'_, T> {
    #[inline(always)]
    fn run(self) {
        let Self { columns, mut scatter, positive, regularization, mut l, y, pivot_inverse } = self;
        for ((rows, &positive), inverse) in columns.lengths().zip(positive).zip(pivot_inverse) {
            let (column, trailing) = l.split_at_mut(1 + rows);
            let here;
            (here, scatter) = scatter.split_at(rows * (rows + 1) / 2);
            *inverse = T::one() / regularized(column[0], positive, regularization);
            let (column, y) = (&mut column[1..], &mut y[..rows]);
            divide(column, y, *inverse);
            subtract_scattered::<T, 1>(Columns { l: column, y, leading_dim: rows }, 0, here, trailing);
            l = trailing;
        }
    }
}

/// What the columns' unknowns contribute to the rows below each.
pub struct Forward<'a, T, const R: usize> {
    pub columns: Simplicial<'a>,
    pub l: &'a [T],
    /// From the first of their unknowns on.
    pub x: &'a mut [[T; R]],
}

impl<T: Real, const R: usize> Outlined for Forward<'_, T, R> {
    #[inline(always)]
    fn run(self) {
        let Self { columns, l, x } = self;
        for (k, (column, rows)) in columns.columns(l).enumerate() {
            let by = x[k];
            for (&l, &row) in column.iter().zip(rows) {
                subtract(&mut x[row as usize], l, by);
            }
        }
    }
}

/// What the rows below contribute to the columns' unknowns, from the last column up.
pub struct Backward<'a, T, const R: usize> {
    pub columns: Simplicial<'a>,
    /// Their entries, and no more.
    pub l: &'a [T],
    /// From the first of their unknowns on.
    pub x: &'a mut [[T; R]],
}

impl<T: Real, const R: usize> Outlined for Backward<'_, T, R> {
    #[inline(always)]
    fn run(self) {
        let Self { columns, l, x } = self;
        for (k, (column, rows)) in columns.columns(l).enumerate().rev() {
            let mut sum = x[k];
            for (&l, &row) in column.iter().zip(rows).rev() {
                subtract(&mut sum, l, x[row as usize]);
            }
            x[k] = sum;
        }
    }
}

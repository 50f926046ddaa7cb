//! Columns that do not depend on one another, one after the other, each with rows of its own, as many as it may be: where
//! a column has few rows, what a supernode costs by itself is more than its arithmetic.
//!
//! Each loop is a function of its own, so that those of other supernodes keep their registers.

use super::factorization::{divide, regularized, Regularization};
use super::outer::{subtract_listed, Columns};
use super::panel::subtract;
use crate::real::{Apart, Real};
use crate::symbolic::{Supernode, Symbolic};

/// Where they begin, and their rows.
#[derive(Clone, Copy)]
pub struct Ragged<'a> {
    /// How many rows below those before each column have; then, how many all of them have.
    starts: &'a [u32],
    /// Rows of the matrix below them, counted from the first of their successors.
    below: &'a [u32],
}

impl<'a> Ragged<'a> {
    /// Of a supernode of ragged columns.
    #[inline(always)]
    pub fn of(symbolic: &'a Symbolic, node: &Supernode) -> Self {
        Self { starts: symbolic.starts_of(node), below: symbolic.ahead(node) }
    }

    /// How many rows each column has below its diagonal.
    #[inline(always)]
    fn lengths(self) -> impl Iterator<Item = usize> + 'a {
        self.starts.windows(2).map(
            #[inline(always)]
            |ends| (ends[1] - ends[0]) as usize,
        )
    }

    /// Each column's words below its diagonal, of `l`, and their rows.
    #[inline(always)]
    fn columns<T>(self, mut l: &'a [T]) -> impl Iterator<Item = (&'a [T], &'a [u32])> {
        let mut below = self.below;
        self.lengths().map(
            #[inline(always)]
            move |rows| {
                let (column, here);
                (column, l) = l.split_at(1 + rows);
                (here, below) = below.split_at(rows);
                (&column[1..], here)
            },
        )
    }
}

/// Reciprocal pivots and columns; each column's contribution is subtracted from where it is listed among the later ones.
pub struct Factor<'a, T> {
    pub ragged: Ragged<'a>,
    pub positions: &'a [u32],
    pub positive: &'a [bool],
    pub regularization: Regularization<T>,
    pub panel: &'a mut [T],
    pub y: &'a mut [T],
    pub pivot_inverse: &'a mut [T],
    pub later: &'a mut [T],
}

impl<T: Real> Apart for Factor<'_, T> {
    #[inline(always)]
    fn run(self) {
        let Self { ragged, mut positions, positive, regularization, mut panel, y, pivot_inverse, later } =
            self;
        for ((rows, &positive), inverse) in ragged.lengths().zip(positive).zip(pivot_inverse) {
            let (column, here);
            (column, panel) = panel.split_at_mut(1 + rows);
            (here, positions) = positions.split_at(rows * (rows + 1) / 2);
            *inverse = T::one() / regularized(column[0], positive, regularization);
            let (l, y) = (&mut column[1..], &mut y[..rows]);
            divide(l, y, *inverse);
            subtract_listed::<T, 1>(Columns { l, y, height: rows }, 0, here, later);
        }
    }
}

/// What the columns' unknowns contribute to the later rows.
pub struct Forward<'a, T, const R: usize> {
    pub ragged: Ragged<'a>,
    pub l: &'a [T],
    pub known: &'a [[T; R]],
    pub later: &'a mut [[T; R]],
}

impl<T: Real, const R: usize> Apart for Forward<'_, T, R> {
    #[inline(always)]
    fn run(self) {
        let Self { ragged, l, known, later } = self;
        for ((column, rows), &by) in ragged.columns(l).zip(known) {
            for (&l, &row) in column.iter().zip(rows) {
                subtract(&mut later[row as usize], l, by);
            }
        }
    }
}

/// What the later rows contribute to the columns' unknowns.
pub struct Backward<'a, T, const R: usize> {
    pub ragged: Ragged<'a>,
    pub l: &'a [T],
    pub later: &'a [[T; R]],
    pub unknown: &'a mut [[T; R]],
}

impl<T: Real, const R: usize> Apart for Backward<'_, T, R> {
    #[inline(always)]
    fn run(self) {
        let Self { ragged, l, later, unknown } = self;
        for ((column, rows), word) in ragged.columns(l).zip(unknown) {
            let mut sum = *word;
            for (&l, &row) in column.iter().zip(rows).rev() {
                subtract(&mut sum, l, later[row as usize]);
            }
            *word = sum;
        }
    }
}

//! Condensed blocks: the Schur complement K₁D⁻¹K₁ᵀ of independent columns with a diagonal block and the same rows.
//! L·D is the matrix itself there, so no entry of L is stored, and every loop is over whole rows.

use super::pivots::{regularized, Regularization};
use crate::kernels::reduce::dot_of;
use crate::real::Real;
use crate::symbolic::factor_layout::{Supernode, Symbolic};
use core::ops::Range;

/// Where such columns are among the matrix's entries.
#[derive(Clone, Copy)]
pub struct Condensed<'a, T> {
    pub values: &'a [T],
    /// Where the diagonal begins, then each row below.
    pub gather: &'a [u32],
    pub width: usize,
}

impl<'a, T> Condensed<'a, T> {
    /// The entries of a supernode of kind `Condensed`.
    #[inline(always)]
    pub fn of(symbolic: &'a Symbolic, node: &Supernode, values: &'a [T]) -> Self {
        Condensed { values, gather: symbolic.gather_indices(node), width: node.width }
    }

    #[inline(always)]
    fn source(&self, k: usize) -> &'a [T] {
        &self.values[self.gather[k] as usize..][..self.width]
    }

    /// The entries of one of the rows below.
    #[inline(always)]
    pub fn row(&self, row: usize) -> &'a [T] {
        self.source(1 + row)
    }

    #[inline(always)]
    fn rows(&self) -> usize {
        self.gather.len() - 1
    }
}

/// Reciprocal pivots.
#[inline(always)]
pub fn factor<T: Real>(
    condensed: Condensed<T>,
    positive: &[bool],
    regularization: Regularization<T>,
    pivot_inverse: &mut [T],
) {
    for ((inverse, &pivot), &positive) in pivot_inverse.iter_mut().zip(condensed.source(0)).zip(positive) {
        *inverse = T::one() / regularized(pivot, positive, regularization);
    }
}

/// Subtract the Schur complement: each product of two rows, divided by the pivots, at its scatter index. Only the rows
/// that are multiplied at once are kept divided.
#[inline(always)]
pub fn contribute<T: Real>(
    condensed: Condensed<T>,
    pivot_inverse: &[T],
    scatter: &[u32],
    scratch: &mut [T],
    trailing: &mut [T],
) {
    let pairs = if T::RHS_BLOCK { condensed.rows() / 2 * 2 } else { 0 };
    let scatter = contribute_of::<T, 2>(condensed, 0..pairs, pivot_inverse, scatter, scratch, trailing);
    contribute_of::<T, 1>(condensed, pairs..condensed.rows(), pivot_inverse, scatter, scratch, trailing);
}

/// The same for some `columns`, `R` at once; returns the scatter indices of those after them.
#[inline(always)]
fn contribute_of<'p, T: Real, const R: usize>(
    condensed: Condensed<T>,
    columns: Range<usize>,
    pivot_inverse: &[T],
    mut scatter: &'p [u32],
    scratch: &mut [T],
    trailing: &mut [T],
) -> &'p [u32] {
    let scaled = &mut scratch.as_chunks_mut::<R>().0[..condensed.width];
    for first in columns.step_by(R) {
        let mut here: [&[u32]; R] = [&[]; R];
        for r in 0..R {
            for ((scaled, &entry), &inverse) in
                scaled.iter_mut().zip(condensed.row(first + r)).zip(pivot_inverse)
            {
                scaled[r] = entry * inverse;
            }
            (here[r], scatter) = scatter.split_at(condensed.rows() - first - r);
        }
        for row in first..condensed.rows() {
            let products = dot_of(condensed.row(row), scaled);
            // Above its own row a column has none.
            for r in 0..R.min(row - first + 1) {
                let entry = &mut trailing[here[r][row - first - r] as usize];
                *entry = *entry - products[r];
            }
        }
    }
    scatter
}

/// What the columns' unknowns contribute to the rows `below`, relative to the first `trailing` one.
#[inline(always)]
pub fn forward<T: Real, const R: usize>(
    condensed: Condensed<T>,
    pivot_inverse: &[T],
    known: &[[T; R]],
    below: &[u32],
    scratch: &mut [[T; R]],
    trailing: &mut [[T; R]],
) {
    let scaled = &mut scratch[..condensed.width];
    for ((scaled, known), &inverse) in scaled.iter_mut().zip(known).zip(pivot_inverse) {
        for r in 0..R {
            scaled[r] = known[r] * inverse;
        }
    }
    for (row, &at) in below.iter().enumerate() {
        let (entry, sum) = (&mut trailing[at as usize], dot_of(condensed.row(row), scaled));
        for r in 0..R {
            entry[r] = entry[r] - sum[r];
        }
    }
}

/// What the rows `below`, relative to the first `trailing` one, contribute to the columns' unknowns, which are divided
/// by their pivots already.
#[inline(always)]
pub fn backward<T: Real, const R: usize>(
    condensed: Condensed<T>,
    pivot_inverse: &[T],
    below: &[u32],
    trailing: &[[T; R]],
    scratch: &mut [[T; R]],
    unknown: &mut [[T; R]],
) {
    let sums = &mut scratch[..condensed.width];
    sums.fill([T::zero(); R]);
    for (row, &at) in below.iter().enumerate() {
        T::subtract_multiple(sums, condensed.row(row), trailing[at as usize]);
    }
    for ((entry, sum), &inverse) in unknown.iter_mut().zip(sums).zip(pivot_inverse) {
        for r in 0..R {
            entry[r] = entry[r].add_mul(inverse, sum[r]);
        }
    }
}

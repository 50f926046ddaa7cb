//! Columns that nothing is subtracted from and that share their rows: what L·D has below their diagonal is the
//! matrix itself, so no word of L is stored, and the rows' words are adjacent. Elimination of them is the sum
//! K₁D⁻¹K₁ᵀ of a condensed form, and every loop is over whole rows.

use super::factorization::{regularized, Regularization};
use super::reduce::{dot, dot_of, dots};
use crate::real::Real;
use crate::symbolic::{Supernode, Symbolic};

/// Where such columns are among the matrix's words.
#[derive(Clone, Copy)]
pub struct Given<'a, T> {
    pub values: &'a [T],
    /// Where the diagonal begins, then each row below.
    pub sources: &'a [u32],
    pub width: usize,
}

impl<'a, T> Given<'a, T> {
    /// The words of a supernode of given columns.
    #[inline(always)]
    pub fn of(symbolic: &'a Symbolic, node: &Supernode, values: &'a [T]) -> Self {
        Given { values, sources: symbolic.sources_of(node), width: node.width }
    }

    #[inline(always)]
    fn source(&self, k: usize) -> &'a [T] {
        &self.values[self.sources[k] as usize..][..self.width]
    }

    /// The words of one of the rows below.
    #[inline(always)]
    pub fn row(&self, row: usize) -> &'a [T] {
        self.source(1 + row)
    }

    #[inline(always)]
    fn rows(&self) -> usize {
        self.sources.len() - 1
    }
}

/// Reciprocal pivots.
#[inline(always)]
pub fn factor<T: Real>(
    given: Given<T>,
    positive: &[bool],
    regularization: Regularization<T>,
    pivot_inverse: &mut [T],
) {
    for ((inverse, &pivot), &positive) in pivot_inverse.iter_mut().zip(given.source(0)).zip(positive) {
        *inverse = T::one() / regularized(pivot, positive, regularization);
    }
}

/// Subtract each product of two rows, divided by the pivots, from where it is listed. Of the rows divided only as many
/// are kept as are multiplied at once.
#[inline(always)]
pub fn contribute<T: Real>(
    given: Given<T>,
    pivot_inverse: &[T],
    positions: &[u32],
    scratch: &mut [T],
    later: &mut [T],
) {
    let mut left = Products { given, pivot_inverse, positions, column: 0 };
    if T::ABREAST {
        left.contribute::<2>(scratch, later);
    }
    left.contribute::<1>(scratch, later);
}

/// Products that are left: of the rows from `column` on, where they are listed.
struct Products<'a, T> {
    given: Given<'a, T>,
    pivot_inverse: &'a [T],
    positions: &'a [u32],
    column: usize,
}

impl<T: Real> Products<'_, T> {
    /// `M` columns at once, as long as there are as many.
    #[inline(always)]
    fn contribute<const M: usize>(&mut self, scratch: &mut [T], later: &mut [T]) {
        let (given, rows) = (self.given, self.given.rows());
        while self.column + M <= rows {
            let (first, mut positions) = (self.column, [self.positions; M]);
            let mut scaled: [&[T]; M] = [&[]; M];
            for (m, row) in scratch.chunks_exact_mut(given.width).take(M).enumerate() {
                divide(given.row(first + m), self.pivot_inverse, row);
                scaled[m] = row;
                (positions[m], self.positions) = self.positions.split_at(rows - first - m);
            }
            // Rows that not all of these columns have, column by column.
            for m in 0..M {
                for row in m..M - 1 {
                    let product = dot(scaled[m], given.row(first + row));
                    subtract(&mut later[positions[m][row - m] as usize], product);
                }
            }
            for row in M - 1..rows - first {
                let products = dots(scaled, given.row(first + row));
                for m in 0..M {
                    subtract(&mut later[positions[m][row - m] as usize], products[m]);
                }
            }
            self.column += M;
        }
    }
}

#[inline(always)]
fn divide<T: Real>(words: &[T], pivot_inverse: &[T], out: &mut [T]) {
    for ((out, &word), &inverse) in out.iter_mut().zip(words).zip(pivot_inverse) {
        *out = word * inverse;
    }
}

#[inline(always)]
fn subtract<T: Real>(word: &mut T, product: T) {
    *word = *word - product;
}

/// What the columns' unknowns contribute to the rows `below`, counted from the first `later` one.
#[inline(always)]
pub fn forward<T: Real, const R: usize>(
    given: Given<T>,
    pivot_inverse: &[T],
    known: &[[T; R]],
    below: &[u32],
    scratch: &mut [[T; R]],
    later: &mut [[T; R]],
) {
    let scaled = &mut scratch[..given.width];
    for ((scaled, known), &inverse) in scaled.iter_mut().zip(known).zip(pivot_inverse) {
        for r in 0..R {
            scaled[r] = known[r] * inverse;
        }
    }
    for (row, &at) in below.iter().enumerate() {
        let (word, sum) = (&mut later[at as usize], dot_of(given.row(row), scaled));
        for r in 0..R {
            word[r] = word[r] - sum[r];
        }
    }
}

/// What the rows `below`, counted from the first `later` one, contribute to the columns' unknowns, which are divided
/// by their pivots already.
#[inline(always)]
pub fn backward<T: Real, const R: usize>(
    given: Given<T>,
    pivot_inverse: &[T],
    below: &[u32],
    later: &[[T; R]],
    scratch: &mut [[T; R]],
    unknown: &mut [[T; R]],
) {
    let sums = &mut scratch[..given.width];
    sums.fill([T::zero(); R]);
    for (row, &at) in below.iter().enumerate() {
        T::subtract_multiple(sums, given.row(row), later[at as usize]);
    }
    for ((word, sum), &inverse) in unknown.iter_mut().zip(sums).zip(pivot_inverse) {
        for r in 0..R {
            word[r] = word[r].add_mul(inverse, sum[r]);
        }
    }
}

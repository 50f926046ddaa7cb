//! The update of the trailing matrix by finished columns: register-tiled outer products. Subtractions into any one
//! entry keep their ascending order.

#![allow(clippy::needless_range_loop)] // constant ranges over arrays unroll; iterators over them do not always

use crate::real::{tiles::Factors, Real};

/// Finished columns as factorisation keeps them: `l`, and the same before the division by the pivot.
#[derive(Clone, Copy)]
pub struct Columns<'a, T> {
    pub l: &'a [T],
    pub y: &'a [T],
    /// Entries of a column.
    pub leading_dim: usize,
}

/// Scatter target of an update: the position of (row, column) is the sum of what either gives.
pub trait ScatterTarget {
    /// Entries of adjacent rows are adjacent.
    const DENSE: bool;
    fn row(&self, row: usize) -> usize;
    fn column(&self, column: usize) -> usize;
}

/// Within the panel itself: later columns of the same leading dimension.
pub struct SamePanel {
    pub leading_dim: usize,
    /// The first column among its targets.
    pub first: usize,
}

impl ScatterTarget for SamePanel {
    const DENSE: bool = true;

    #[inline(always)]
    fn row(&self, row: usize) -> usize {
        row
    }

    #[inline(always)]
    fn column(&self, column: usize) -> usize {
        (column - self.first) * self.leading_dim
    }
}

/// `target −= Σ_k l_k·y_kᵀ` on the columns `lo..hi` and the rows from each of them down.
#[inline(always)]
pub fn subtract<T: Real>(
    columns: Columns<T>,
    (lo, hi): (usize, usize),
    scatter: &impl ScatterTarget,
    target: &mut [T],
) {
    if T::TILE_COLS == 4 {
        subtract_tiled::<T, _, 4>(columns, (lo, hi), scatter, target);
    } else {
        subtract_tiled::<T, _, 2>(columns, (lo, hi), scatter, target);
    }
}

#[inline(always)]
fn subtract_tiled<T: Real, L: ScatterTarget, const N: usize>(
    columns: Columns<T>,
    (lo, hi): (usize, usize),
    scatter: &L,
    target: &mut [T],
) {
    let mut column = lo;
    while column + N <= hi {
        tile::<T, L, N, N, true>(columns, column, column, scatter, target);
        let mut row = column + N;
        while T::TILE_ROWS == 8 && row + 8 <= columns.leading_dim {
            tile::<T, L, 8, N, false>(columns, row, column, scatter, target);
            row += 8;
        }
        while row + N <= columns.leading_dim {
            tile::<T, L, N, N, false>(columns, row, column, scatter, target);
            row += N;
        }
        for row in row..columns.leading_dim {
            tile::<T, L, 1, N, false>(columns, row, column, scatter, target);
        }
        column += N;
    }
    for column in column..hi {
        let mut row = column;
        while row + N <= columns.leading_dim {
            tile::<T, L, N, 1, false>(columns, row, column, scatter, target);
            row += N;
        }
        for row in row..columns.leading_dim {
            tile::<T, L, 1, 1, false>(columns, row, column, scatter, target);
        }
    }
}

/// `M` rows by `N` columns; of the diagonal's tile the `LOWER` triangle.
#[inline(always)]
fn tile<T: Real, L: ScatterTarget, const M: usize, const N: usize, const LOWER: bool>(
    columns: Columns<T>,
    row: usize,
    column: usize,
    scatter: &L,
    target: &mut [T],
) {
    let (mut rows, mut bases) = ([0; M], [0; N]);
    for (m, at) in rows.iter_mut().enumerate() {
        *at = scatter.row(row + m);
    }
    for (n, at) in bases.iter_mut().enumerate() {
        *at = scatter.column(column + n);
    }
    let top = |n: usize| if LOWER { n } else { 0 };
    let mut entries = [[T::zero(); M]; N];
    for n in 0..N {
        if L::DENSE {
            entries[n][top(n)..].copy_from_slice(&target[bases[n] + rows[top(n)]..][..M - top(n)]);
        } else {
            entries[n] = gathered(&target[bases[n]..], rows, top(n));
        }
    }
    let Columns { l, y, leading_dim } = columns;
    T::subtract_products::<M, N, LOWER>(&mut entries, Factors { l, y, leading_dim, row, column });
    for n in 0..N {
        if L::DENSE {
            target[bases[n] + rows[top(n)]..][..M - top(n)].copy_from_slice(&entries[n][top(n)..]);
        } else {
            let target = &mut target[bases[n]..];
            for m in top(n)..M {
                target[rows[m]] = entries[n][m];
            }
        }
    }
}

/// Entries of up to four `rows`, or eight, from row `first` on. No loop: entries that pass through memory one by one are waited
/// for when they are read as a vector.
#[inline(always)]
fn gathered<T: Real, const M: usize>(entries: &[T], rows: [usize; M], first: usize) -> [T; M] {
    let mut out = [T::zero(); M];
    if M > 0 && first == 0 {
        out[0] = entries[rows[0]];
    }
    if M > 1 && first <= 1 {
        out[1] = entries[rows[1]];
    }
    if M > 2 && first <= 2 {
        out[2] = entries[rows[2]];
    }
    if M > 3 {
        out[3] = entries[rows[3]];
    }
    if M > 7 {
        out[4] = entries[rows[4]];
        out[5] = entries[rows[5]];
        out[6] = entries[rows[6]];
        out[7] = entries[rows[7]];
    }
    out
}

/// The same for `W` columns with scatter indices entry by entry. Few columns with few
/// rows cost less so than in tiles.
#[inline(always)]
pub fn subtract_scattered<T: Real, const W: usize>(
    columns: Columns<T>,
    first: usize,
    scatter: &[u32],
    target: &mut [T],
) {
    let leading_dim = columns.leading_dim;
    let mut l: [&[T]; W] = [&[]; W];
    let mut y: [&[T]; W] = [&[]; W];
    for k in 0..W {
        l[k] = &columns.l[k * leading_dim + first..(k + 1) * leading_dim];
        y[k] = &columns.y[k * leading_dim + first..(k + 1) * leading_dim];
    }
    let mut scatter = scatter;
    for j in 0..leading_dim - first {
        let mut factor = [T::zero(); W];
        for k in 0..W {
            factor[k] = y[k][j];
        }
        let here;
        (here, scatter) = scatter.split_at(leading_dim - first - j);
        for k in 0..W {
            l[k] = &l[k][..here.len()];
        }
        for i in 0..here.len() {
            let entry = &mut target[here[i] as usize];
            let mut sum = *entry;
            for k in 0..W {
                sum = sum.sub_mul(l[k][i], factor[k]);
            }
            *entry = sum;
        }
        for k in 0..W {
            l[k] = &l[k][1..];
        }
    }
}

/// The same for leaves: each column has scatter indices of its own.
#[inline(always)]
pub fn subtract_leaves<T: Real>(columns: Columns<T>, scatter: &[u32], target: &mut [T]) {
    match columns.leading_dim {
        2 => subtract_leaves_of::<T, 2, 1>(columns, scatter, target),
        3 => subtract_leaves_of::<T, 3, 3>(columns, scatter, target),
        4 => subtract_leaves_of::<T, 4, 6>(columns, scatter, target),
        _ => subtract_leaves_of::<T, 5, 10>(columns, scatter, target),
    }
}

/// `H` entries a column, the diagonal included; `P` products of the others.
#[inline(always)]
fn subtract_leaves_of<T: Real, const H: usize, const P: usize>(
    columns: Columns<T>,
    scatter: &[u32],
    target: &mut [T],
) {
    let leaves = columns.l.as_chunks::<H>().0.iter().zip(columns.y.as_chunks::<H>().0);
    for ((l, y), scatter) in leaves.zip(scatter.as_chunks::<P>().0) {
        let mut next = 0;
        for j in 1..H {
            for i in j..H {
                let entry = &mut target[scatter[next] as usize];
                *entry = entry.sub_mul(l[i], y[j]);
                next += 1;
            }
        }
    }
}

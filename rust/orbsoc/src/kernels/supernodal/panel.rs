//! Substitution through one panel of L, for `R` right-hand sides side by side. Each entry of L is read
//! once for all of them, and subtractions into any one accumulator keep the order of the plain loops.

#![allow(clippy::needless_range_loop)] // constant ranges over arrays unroll; iterators over them do not always

use crate::real::Real;

/// A supernode's columns.
#[derive(Clone, Copy)]
pub struct Panel<'a, T> {
    pub l: &'a [T],
    pub leading_dim: usize,
    /// Size of its diagonal blocks.
    pub diagonal_size: usize,
    /// Rows of the matrix below them, counted from the first of these columns' successors …
    pub rows: &'a [u32],
    /// … or below each of them in turn.
    pub leaves: bool,
}

impl<'a, T> Panel<'a, T> {
    /// From one of its columns on.
    #[inline(always)]
    fn starting_at(self, column: usize) -> Self {
        Self { l: &self.l[column * self.leading_dim..], ..self }
    }

    #[inline(always)]
    fn column(&self, k: usize) -> &'a [T] {
        &self.l[k * self.leading_dim..][..self.leading_dim]
    }
}

/// `a −= b·l`, for each right-hand side.
#[inline(always)]
pub(super) fn subtract<T: Real, const R: usize>(entry: &mut [T; R], l: T, by: [T; R]) {
    for r in 0..R {
        entry[r] = entry[r].sub_mul(l, by[r]);
    }
}

/// `x ← L⁻¹x` for this panel: its own unknowns, then what they contribute to the rows below.
#[inline(always)]
pub fn forward<T: Real, const R: usize>(panel: Panel<T>, known: &mut [[T; R]], trailing: &mut [[T; R]]) {
    if panel.leaves {
        return match panel.leading_dim {
            2 => forward_leaves::<T, R, 2, 1>(panel, known, trailing),
            3 => forward_leaves::<T, R, 3, 2>(panel, known, trailing),
            4 => forward_leaves::<T, R, 4, 3>(panel, known, trailing),
            _ => forward_leaves::<T, R, 5, 4>(panel, known, trailing),
        };
    }
    match (panel.diagonal_size, known.len()) {
        (_, 1) => forward_below::<T, R, 1>(panel, known, trailing),
        (2, 2) => forward_narrow::<T, R, 2>(panel, known, trailing),
        (3, 3) => forward_narrow::<T, R, 3>(panel, known, trailing),
        (4, 4) => forward_narrow::<T, R, 4>(panel, known, trailing),
        (diagonal_size, _) => {
            if diagonal_size > 1 {
                for (block, known) in known.chunks_mut(diagonal_size).enumerate() {
                    forward_own(panel.starting_at(block * diagonal_size), known);
                }
            }
            forward_tiles(panel, known, trailing);
        }
    }
}

/// The unknowns of a diagonal block.
#[inline(always)]
fn forward_own<T: Real, const R: usize>(panel: Panel<T>, known: &mut [[T; R]]) {
    for c in 1..known.len() {
        let (known, unknown) = known.split_at_mut(c);
        for (entry, &l) in unknown.iter_mut().zip(&panel.column(c - 1)[c..]) {
            subtract(entry, l, known[c - 1]);
        }
    }
}

/// A supernode of `W` columns.
#[inline(always)]
fn forward_narrow<T: Real, const R: usize, const W: usize>(
    panel: Panel<T>,
    known: &mut [[T; R]],
    trailing: &mut [[T; R]],
) {
    let known = &mut known[..W];
    for c in 1..W {
        for i in c..W {
            let by = known[c - 1];
            subtract(&mut known[i], panel.column(c - 1)[i], by);
        }
    }
    forward_below::<T, R, W>(panel, known, trailing);
}

/// Leaves of `B` rows each; `H` entries with the diagonal.
#[inline(always)]
fn forward_leaves<T: Real, const R: usize, const H: usize, const B: usize>(
    panel: Panel<T>,
    known: &[[T; R]],
    trailing: &mut [[T; R]],
) {
    let leaves = panel.l.as_chunks::<H>().0.iter().zip(panel.rows.as_chunks::<B>().0);
    for ((column, rows), &by) in leaves.zip(known) {
        for i in 0..B {
            subtract(&mut trailing[rows[i] as usize], column[i + 1], by);
        }
    }
}

#[inline(always)]
fn backward_leaves<T: Real, const R: usize, const H: usize, const B: usize>(
    panel: Panel<T>,
    trailing: &[[T; R]],
    unknown: &mut [[T; R]],
) {
    let leaves = panel.l.as_chunks::<H>().0.iter().zip(panel.rows.as_chunks::<B>().0);
    for ((column, rows), entry) in leaves.zip(unknown) {
        for i in (0..B).rev() {
            subtract(entry, column[i + 1], trailing[rows[i] as usize]);
        }
    }
}

#[inline(always)]
fn forward_below<T: Real, const R: usize, const W: usize>(
    panel: Panel<T>,
    known: &[[T; R]],
    trailing: &mut [[T; R]],
) {
    let mut columns: [&[T]; W] = [&[]; W];
    let mut by = [[T::zero(); R]; W];
    for k in 0..W {
        columns[k] = &panel.column(k)[panel.diagonal_size..][..panel.rows.len()];
        by[k] = known[k];
    }
    for i in 0..panel.rows.len() {
        let entry = &mut trailing[panel.rows[i] as usize];
        let mut sum = *entry;
        for k in 0..W {
            subtract(&mut sum, columns[k][i], by[k]);
        }
        *entry = sum;
    }
}

/// Many columns: a few rows stay in registers while the columns go by.
#[inline(always)]
fn forward_tiles<T: Real, const R: usize>(panel: Panel<T>, known: &[[T; R]], trailing: &mut [[T; R]]) {
    const M: usize = 4;
    let mut rows = panel.rows.chunks_exact(M);
    let mut at = panel.diagonal_size;
    for rows in &mut rows {
        forward_tile::<T, R, M>(panel, known, at, rows, trailing);
        at += M;
    }
    for row in rows.remainder().chunks(1) {
        forward_tile::<T, R, 1>(panel, known, at, row, trailing);
        at += 1;
    }
}

#[inline(always)]
fn forward_tile<T: Real, const R: usize, const M: usize>(
    panel: Panel<T>,
    known: &[[T; R]],
    at: usize,
    rows: &[u32],
    trailing: &mut [[T; R]],
) {
    let mut entries = [[T::zero(); R]; M];
    for (entry, &row) in entries.iter_mut().zip(rows) {
        *entry = trailing[row as usize];
    }
    for (column, &by) in panel.l.chunks_exact(panel.leading_dim).zip(known) {
        for (entry, &l) in entries.iter_mut().zip(&column[at..at + M]) {
            subtract(entry, l, by);
        }
    }
    for (entry, &row) in entries.into_iter().zip(rows) {
        trailing[row as usize] = entry;
    }
}

/// `x ← L⁻ᵀx` for this panel's unknowns: each subtracts the known ones from the last row up.
#[inline(always)]
pub fn backward<T: Real, const R: usize>(
    panel: Panel<T>,
    trailing: &[[T; R]],
    scratch: &mut [[T; R]],
    unknown: &mut [[T; R]],
) {
    if panel.leaves {
        return match panel.leading_dim {
            2 => backward_leaves::<T, R, 2, 1>(panel, trailing, unknown),
            3 => backward_leaves::<T, R, 3, 2>(panel, trailing, unknown),
            4 => backward_leaves::<T, R, 4, 3>(panel, trailing, unknown),
            _ => backward_leaves::<T, R, 5, 4>(panel, trailing, unknown),
        };
    }
    match (panel.diagonal_size, unknown.len()) {
        (_, 1) => return backward_narrow::<T, R, 1>(panel, trailing, unknown),
        (2, 2) => return backward_narrow::<T, R, 2>(panel, trailing, unknown),
        (3, 3) => return backward_narrow::<T, R, 3>(panel, trailing, unknown),
        (4, 4) => return backward_narrow::<T, R, 4>(panel, trailing, unknown),
        _ => {}
    }
    let below = &mut scratch[..panel.rows.len()];
    for (entry, &row) in below.iter_mut().zip(panel.rows) {
        *entry = trailing[row as usize];
    }
    let chain = if panel.diagonal_size == 1 { unknown.len() } else { panel.diagonal_size };
    let mut end = unknown.len();
    while end > 0 {
        backward_supernode(panel.starting_at(end - chain), below, &mut unknown[end - chain..end]);
        end -= chain;
    }
}

/// One supernode, or single twins, from the unknowns `below`.
#[inline(always)]
fn backward_supernode<T: Real, const R: usize>(panel: Panel<T>, below: &[[T; R]], unknown: &mut [[T; R]]) {
    let mut k = unknown.len();
    while k >= 4 {
        k -= 4;
        backward_group::<T, R, 4>(panel, k, below, unknown);
    }
    match k {
        1 => backward_group::<T, R, 1>(panel, 0, below, unknown),
        2 => backward_group::<T, R, 2>(panel, 0, below, unknown),
        3 => backward_group::<T, R, 3>(panel, 0, below, unknown),
        _ => {}
    }
}

/// `sums[i] −= columns[i][r]·entry(by[r])`, from the last r down. Zipped, as an index that counts down is checked.
#[inline(always)]
fn subtract_from_last<T: Real, B, const R: usize, const C: usize>(
    sums: &mut [[T; R]; C],
    columns: [&[T]; C],
    by: &[B],
    entry: impl Fn(&B) -> [T; R],
) {
    match (sums.as_mut_slice(), columns.as_slice()) {
        ([p], [a]) => {
            for (&a, by) in a.iter().zip(by).rev() {
                let by = entry(by);
                subtract(p, a, by);
            }
        }
        ([p, q], [a, b]) => {
            for ((&a, &b), by) in a.iter().zip(*b).zip(by).rev() {
                let by = entry(by);
                subtract(p, a, by);
                subtract(q, b, by);
            }
        }
        ([p, q, s], [a, b, c]) => {
            for (((&a, &b), &c), by) in a.iter().zip(*b).zip(*c).zip(by).rev() {
                let by = entry(by);
                subtract(p, a, by);
                subtract(q, b, by);
                subtract(s, c, by);
            }
        }
        ([p, q, s, t], [a, b, c, d]) => {
            for ((((&a, &b), &c), &d), by) in a.iter().zip(*b).zip(*c).zip(*d).zip(by).rev() {
                let by = entry(by);
                subtract(p, a, by);
                subtract(q, b, by);
                subtract(s, c, by);
                subtract(t, d, by);
            }
        }
        _ => {}
    }
}

/// A supernode of `W` columns, or one column.
#[inline(always)]
fn backward_narrow<T: Real, const R: usize, const W: usize>(
    panel: Panel<T>,
    trailing: &[[T; R]],
    unknown: &mut [[T; R]],
) {
    let unknown = &mut unknown[..W];
    let mut tails: [&[T]; W] = [&[]; W];
    let mut sums = [[T::zero(); R]; W];
    for i in 0..W {
        tails[i] = &panel.column(i)[panel.diagonal_size..][..panel.rows.len()];
        sums[i] = unknown[i];
    }
    subtract_from_last(
        &mut sums,
        tails,
        panel.rows,
        #[inline(always)]
        |&row| trailing[row as usize],
    );
    for solved in (1..W).rev() {
        let by = sums[solved];
        for i in 0..solved {
            subtract(&mut sums[i], panel.column(i)[solved], by);
        }
    }
    unknown.copy_from_slice(&sums);
}

#[inline(always)]
fn entry<T: Real, const R: usize>(x: &[T; R]) -> [T; R] {
    *x
}

/// Columns `first..first + C`, the ones after them being solved.
#[inline(always)]
fn backward_group<T: Real, const R: usize, const C: usize>(
    panel: Panel<T>,
    first: usize,
    below: &[[T; R]],
    x: &mut [[T; R]],
) {
    let mut columns: [&[T]; C] = [&[]; C];
    let mut tails: [&[T]; C] = [&[]; C];
    let mut sums = [[T::zero(); R]; C];
    for i in 0..C {
        columns[i] = panel.column(first + i);
        tails[i] = &columns[i][panel.diagonal_size..][..below.len()];
        sums[i] = x[first + i];
    }
    subtract_from_last(&mut sums, tails, below, entry);
    if panel.diagonal_size > 1 {
        let solved = first + C..x.len();
        subtract_from_last(
            &mut sums,
            columns.map(|column| &column[solved.clone()]),
            &x[solved.clone()],
            entry,
        );
        for solved in (1..C).rev() {
            let by = sums[solved];
            for i in 0..solved {
                subtract(&mut sums[i], columns[i][first + solved], by);
            }
        }
    }
    x[first..first + C].copy_from_slice(&sums);
}

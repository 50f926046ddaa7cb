//! The two loops over a panel of L that factorisation and substitution share. Columns go in blocks
//! of four so that each word of the vector is read once for four columns; the order of subtractions
//! into any one accumulator is that of the plain loops.

use crate::real::Real;

/// `out −= Σ_{k < columns} l[row.., k]·factor(k)`, ascending in k.
#[inline(always)]
pub fn subtract_columns<T: Real>(
    columns: usize,
    height: usize,
    row: usize,
    l: &[T],
    factor: impl Fn(usize) -> T,
    out: &mut [T],
) {
    let len = out.len();
    let column = |k: usize| &l[k * height + row..][..len];
    let mut k = 0;
    while k + 4 <= columns {
        let f: [T; 4] = [factor(k), factor(k + 1), factor(k + 2), factor(k + 3)];
        let (l0, l1, l2, l3) = (column(k), column(k + 1), column(k + 2), column(k + 3));
        for i in 0..len {
            let word = out[i].sub_mul(l0[i], f[0]).sub_mul(l1[i], f[1]);
            out[i] = word.sub_mul(l2[i], f[2]).sub_mul(l3[i], f[3]);
        }
        k += 4;
    }
    for k in k..columns {
        let f = factor(k);
        for (word, &l) in out.iter_mut().zip(column(k)) {
            *word = word.sub_mul(l, f);
        }
    }
}

/// As [`subtract_columns`] into the words of `target` at `landing`. Few columns go word by word; for
/// more, gathering the words into a vector pays.
#[inline(always)]
#[allow(clippy::too_many_arguments)] // a panel's five, the target, where, and scratch
pub fn subtract_scattered<T: Real>(
    columns: usize,
    height: usize,
    row: usize,
    l: &[T],
    factor: impl Fn(usize) -> T,
    landing: &[u32],
    scratch: &mut [T],
    target: &mut [T],
) {
    let len = landing.len();
    let column = |k: usize| &l[k * height + row..][..len];
    match columns {
        1 => {
            let (l0, f0) = (column(0), factor(0));
            for (&to, &l0) in landing.iter().zip(l0) {
                target[to as usize] = target[to as usize].sub_mul(l0, f0);
            }
        }
        2 => {
            let (l0, l1, f0, f1) = (column(0), column(1), factor(0), factor(1));
            for ((&to, &l0), &l1) in landing.iter().zip(l0).zip(l1) {
                target[to as usize] = target[to as usize].sub_mul(l0, f0).sub_mul(l1, f1);
            }
        }
        3 => {
            let (l0, l1, l2) = (column(0), column(1), column(2));
            let (f0, f1, f2) = (factor(0), factor(1), factor(2));
            for (((&to, &l0), &l1), &l2) in landing.iter().zip(l0).zip(l1).zip(l2) {
                let word = target[to as usize].sub_mul(l0, f0).sub_mul(l1, f1);
                target[to as usize] = word.sub_mul(l2, f2);
            }
        }
        _ => {
            let scratch = &mut scratch[..len];
            for (word, &from) in scratch.iter_mut().zip(landing) {
                *word = target[from as usize];
            }
            subtract_columns(columns, height, row, l, factor, scratch);
            for (&word, &to) in scratch.iter().zip(landing) {
                target[to as usize] = word;
            }
        }
    }
}

/// `top ← L_top⁻ᵀ (top − L_belowᵀ below)` for a panel of `top.len()` columns: each unknown subtracts
/// the known ones from the last row up.
#[inline(always)]
pub fn solve_transposed<T: Real>(height: usize, l: &[T], below: &[T], top: &mut [T]) {
    let mut k = top.len();
    while k >= 4 {
        k -= 4;
        solve_group::<T, 4>(height, k, l, below, top);
    }
    match k {
        1 => solve_group::<T, 1>(height, 0, l, below, top),
        2 => solve_group::<T, 2>(height, 0, l, below, top),
        3 => solve_group::<T, 3>(height, 0, l, below, top),
        _ => {}
    }
}

/// Columns `first..first + C`, whose later columns are solved.
#[inline(always)]
fn solve_group<T: Real, const C: usize>(height: usize, first: usize, l: &[T], below: &[T], top: &mut [T]) {
    let width = top.len();
    let column = |i: usize| &l[(first + i) * height..][..height];
    let columns: [&[T]; C] = core::array::from_fn(column);
    let mut sums = [T::zero(); C];
    sums.copy_from_slice(&top[first..first + C]);
    let tails: [&[T]; C] = core::array::from_fn(|i| &columns[i][width..][..below.len()]);
    for r in (0..below.len()).rev() {
        for i in 0..C {
            sums[i] = sums[i].sub_mul(tails[i][r], below[r]);
        }
    }
    for r in (first + C..width).rev() {
        for i in 0..C {
            sums[i] = sums[i].sub_mul(columns[i][r], top[r]);
        }
    }
    for solved in (1..C).rev() {
        for i in 0..solved {
            sums[i] = sums[i].sub_mul(columns[i][first + solved], sums[solved]);
        }
    }
    top[first..first + C].copy_from_slice(&sums);
}

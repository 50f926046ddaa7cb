//! PL module *linear solve*: permuted substitution through L, D, Lᵀ and the refinement residual.

use super::panel::{solve_transposed, subtract_columns};
use crate::kkt::Kkt;
use crate::real::Real;
use crate::symbolic::Symbolic;

/// `out = (LDLᵀ)⁻¹ rhs`, everything in permuted order.
#[inline(always)]
pub fn substitute<T: Real>(
    symbolic: &Symbolic,
    l: &[T],
    pivot_inverse: &[T],
    rhs: &[T],
    scratch: &mut [T],
    out: &mut [T],
) {
    out.copy_from_slice(rhs);
    substitute_in_place(symbolic, l, pivot_inverse, scratch, out);
}

/// `x ← (LDLᵀ)⁻¹ x`.
#[inline(always)]
pub fn substitute_in_place<T: Real>(
    symbolic: &Symbolic,
    l: &[T],
    pivot_inverse: &[T],
    scratch: &mut [T],
    x: &mut [T],
) {
    forward(symbolic, l, scratch, x);
    for (word, &inverse) in x.iter_mut().zip(pivot_inverse) {
        *word = *word * inverse;
    }
    backward(symbolic, l, scratch, x);
}

/// `x ← L⁻¹ x` in column form: each unknown, once known, is subtracted from all rows below it.
#[inline(always)]
fn forward<T: Real>(symbolic: &Symbolic, l: &[T], scratch: &mut [T], x: &mut [T]) {
    for node in &symbolic.supernodes {
        let (width, height) = (node.width, node.height);
        let l = &l[node.panel..node.panel + width * height];
        let below = &symbolic.rows_of(node)[width..];
        let top = &mut x[node.first..node.first + width];
        for c in 1..width {
            let (known, unknown) = top.split_at_mut(c);
            let column = &l[(c - 1) * height..c * height];
            for (word, &l) in unknown.iter_mut().zip(&column[c..width]) {
                *word = word.sub_mul(l, known[c - 1]);
            }
        }
        if width == 1 {
            let known = x[node.first];
            for (&i, &l) in below.iter().zip(&l[1..]) {
                x[i as usize] = x[i as usize].sub_mul(l, known);
            }
            continue;
        }
        let scratch = &mut scratch[..below.len()];
        for (word, &i) in scratch.iter_mut().zip(below) {
            *word = x[i as usize];
        }
        let known = &x[node.first..node.first + width];
        subtract_columns(width, height, width, l, |k| known[k], scratch);
        for (&word, &i) in scratch.iter().zip(below) {
            x[i as usize] = word;
        }
    }
}

/// `x ← L⁻ᵀ x`; each unknown subtracts the known ones in descending order.
#[inline(always)]
fn backward<T: Real>(symbolic: &Symbolic, l: &[T], scratch: &mut [T], x: &mut [T]) {
    for node in symbolic.supernodes.iter().rev() {
        let (width, height) = (node.width, node.height);
        let l = &l[node.panel..node.panel + width * height];
        let below = &symbolic.rows_of(node)[width..];
        let known = &mut scratch[..below.len()];
        for (word, &i) in known.iter_mut().zip(below) {
            *word = x[i as usize];
        }
        solve_transposed(height, l, known, &mut x[node.first..node.first + width]);
    }
}

/// `error = rhs − K·x` with the unregularised matrix, everything in permuted order.
#[inline(always)]
pub fn residual<T: Real>(kkt: &Kkt, values: &[T], rhs: &[T], x: &[T], error: &mut [T]) {
    error.copy_from_slice(rhs);
    for j in 0..kkt.dim {
        let entries = kkt.colptr[j] as usize..kkt.colptr[j + 1] as usize;
        let (rows, values) = (&kkt.rowidx[entries.clone()], &values[entries]);
        let diagonal = rows.len() - 1;
        let xj = x[j];
        let mut own = error[j].sub_mul(values[diagonal], xj);
        for (&i, &value) in rows[..diagonal].iter().zip(values) {
            let i = i as usize;
            own = own.sub_mul(value, x[i]);
            error[i] = error[i].sub_mul(value, xj);
        }
        error[j] = own;
    }
}

/// `x += correction`.
#[inline(always)]
pub fn accumulate<T: Real>(correction: &[T], x: &mut [T]) {
    for (x, &correction) in x.iter_mut().zip(correction) {
        *x = *x + correction;
    }
}

/// Unknowns in natural order from the permuted solution; expansion rows are left behind.
#[inline(always)]
pub fn unload<T: Real>(position: &[u32], permuted: &[T], natural: &mut [T]) {
    for (word, &from) in natural.iter_mut().zip(position) {
        *word = permuted[from as usize];
    }
}

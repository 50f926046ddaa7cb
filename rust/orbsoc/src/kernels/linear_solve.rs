//! PL module *linear solve*: permuted substitution through L, D, Lᵀ and the refinement residual.

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
        for c in 0..width {
            let known = x[node.first + c];
            for (word, &l) in scratch.iter_mut().zip(&l[c * height + width..]) {
                *word = word.sub_mul(l, known);
            }
        }
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
        let top = &mut x[node.first..node.first + width];
        let mut c = 0;
        while c + 4 <= width {
            let columns: [&[T]; 4] = core::array::from_fn(|i| &l[(c + i) * height + width..][..known.len()]);
            let mut sums: [T; 4] = core::array::from_fn(|i| top[c + i]);
            for k in (0..known.len()).rev() {
                for (sum, column) in sums.iter_mut().zip(&columns) {
                    *sum = sum.sub_mul(column[k], known[k]);
                }
            }
            top[c..c + 4].copy_from_slice(&sums);
            c += 4;
        }
        for c in c..width {
            let column = &l[c * height + width..][..known.len()];
            for (&l, &known) in column.iter().zip(known.iter()).rev() {
                top[c] = top[c].sub_mul(l, known);
            }
        }
        for c in (1..width).rev() {
            for k in 0..c {
                top[k] = top[k].sub_mul(l[k * height + c], top[c]);
            }
        }
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

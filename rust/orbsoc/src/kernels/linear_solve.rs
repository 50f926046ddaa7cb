//! PL module *linear solve*: permuted substitution through L, D, Lᵀ and the refinement residual.

use super::panel::{solve_transposed, subtract_scattered};
use super::reduce::{finite_witness, max_abs};
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
    forward(symbolic, l, scratch, out);
    for (word, &inverse) in out.iter_mut().zip(pivot_inverse) {
        *word = *word * inverse;
    }
    backward(symbolic, l, scratch, out);
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
        let (known, scratch) = scratch.split_at_mut(width);
        known.copy_from_slice(top);
        subtract_scattered(
            width,
            height,
            width,
            l,
            #[inline(always)]
            |k| known[k],
            below,
            scratch,
            x,
        );
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

/// Words of the refinement buffer.
pub mod refinement {
    /// ‖error‖∞; not finite when the error is not.
    pub const ERROR: usize = 0;
    /// An error this small is small enough.
    pub const ALLOWED: usize = 1;
    /// A step that leaves a larger error than this is the last.
    pub const WORTHWHILE: usize = 2;
    pub const WORDS: usize = 3;
}

/// Norm of the error after a solve, and what it may be: a share of the right-hand side, or `goal`.
#[inline(always)]
pub fn assess<T: Real>(error: &[T], rhs: &[T], relative: T, goal: T, out: &mut [T]) {
    out[refinement::ERROR] = error_norm(error);
    out[refinement::ALLOWED] = goal.max(relative * max_abs(rhs));
    out[refinement::WORTHWHILE] = out[refinement::ERROR];
}

#[inline(always)]
fn error_norm<T: Real>(error: &[T]) -> T {
    max_abs(error) + finite_witness(error)
}

/// One refinement step of a problem that is `active` (not zero). The new solution and error replace the
/// old where their norm is smaller, and not where it is not a number.
#[inline(always)]
#[allow(clippy::too_many_arguments)] // the system, its solution, its error, and their state
pub fn refine<T: Real>(
    kkt: &Kkt,
    (values, l, pivot_inverse): (&[T], &[T], &[T]),
    rhs: &[T],
    scratch: &mut [T],
    x: &mut [T],
    error: &mut [T],
    state: &mut [T],
    active: T,
) {
    let (candidate, rest) = scratch.split_at_mut(kkt.dim);
    let (new_error, scratch) = rest.split_at_mut(kkt.dim);
    substitute(&kkt.symbolic, l, pivot_inverse, error, scratch, candidate);
    for (word, &x) in candidate.iter_mut().zip(x.iter()) {
        *word = x + *word;
    }
    residual(kkt, values, rhs, candidate, new_error);
    let (old, new) = (state[refinement::ERROR], error_norm(new_error));
    let better = T::and(new.lt(old), T::zero().lt(active));
    for (kept, &new) in x.iter_mut().zip(candidate.iter()).chain(error.iter_mut().zip(new_error.iter())) {
        *kept = T::select(better, new, *kept);
    }
    state[refinement::ERROR] = T::select(better, new, old);
    state[refinement::WORTHWHILE] = T::constant(0.25) * old;
}

/// Unknowns in natural order from the permuted solution; expansion rows are left behind.
#[inline(always)]
pub fn unload<T: Real>(position: &[u32], permuted: &[T], natural: &mut [T]) {
    for (word, &from) in natural.iter_mut().zip(position) {
        *word = permuted[from as usize];
    }
}

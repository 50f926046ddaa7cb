//! PL module *linear solve*: permuted substitution through L, D, Lᵀ and the refinement residual, for `R`
//! right-hand sides side by side.

use super::panel::{self, Panel};
use super::reduce::{finite_witness_of, max_abs_of};
use crate::kkt::Kkt;
use crate::real::Real;
use crate::rows::Rows;
use crate::supernode::Kind;
use crate::symbolic::{Supernode, Symbolic};

/// `x ← (LDLᵀ)⁻¹ x`, everything in permuted order. Divided by D all at once, or late, each panel's words when
/// they are near anyway; it is the same division.
#[inline(always)]
pub fn substitute<T: Real, const R: usize>(
    symbolic: &Symbolic,
    l: &[T],
    pivot_inverse: &[T],
    divide_late: bool,
    scratch: &mut [[T; R]],
    x: &mut [[T; R]],
) {
    for node in &symbolic.supernodes {
        panel::forward(panel_of(symbolic, node, l), node.first, node.width, x);
    }
    if !divide_late {
        divide(x, pivot_inverse);
    }
    for node in symbolic.supernodes.iter().rev() {
        if divide_late {
            let own = node.first..node.first + node.width;
            divide(&mut x[own.clone()], &pivot_inverse[own]);
        }
        panel::backward(panel_of(symbolic, node, l), node.first, node.width, scratch, x);
    }
}

#[inline(always)]
fn divide<T: Real, const R: usize>(x: &mut [[T; R]], pivot_inverse: &[T]) {
    for (words, &inverse) in x.iter_mut().zip(pivot_inverse) {
        for word in words {
            *word = *word * inverse;
        }
    }
}

#[inline(always)]
fn panel_of<'a, T>(symbolic: &'a Symbolic, node: &Supernode, l: &'a [T]) -> Panel<'a, T> {
    Panel {
        l: &l[node.panel..][..node.width * node.height],
        height: node.height,
        top: node.top,
        below: symbolic.below(node),
        leaves: node.kind == Kind::Leaves,
    }
}

/// `error = rhs − K·x` with the unregularised matrix, everything in permuted order.
#[inline(always)]
pub fn residual<T: Real, const R: usize>(
    kkt: &Kkt,
    values: &[T],
    rhs: &[[T; R]],
    x: &[[T; R]],
    error: &mut [[T; R]],
) {
    if let Some(rows) = &kkt.rows {
        return residual_by_rows(rows, values, rhs, x, error);
    }
    error.copy_from_slice(rhs);
    let mut values = values;
    for j in 0..kkt.dim {
        let rows = &kkt.rowidx[kkt.colptr[j] as usize..kkt.colptr[j + 1] as usize];
        let column;
        (column, values) = values.split_at(rows.len());
        let (Some((_, rows)), Some((&diagonal, column))) = (rows.split_last(), column.split_last()) else {
            continue;
        };
        let (known, xj) = (&x[..j], x[j]);
        let (error, own) = error.split_at_mut(j);
        for r in 0..R {
            own[0][r] = own[0][r].sub_mul(diagonal, xj[r]);
        }
        let mut sum = own[0];
        for (&i, &value) in rows.iter().zip(column) {
            let (xi, error) = (&known[i as usize], &mut error[i as usize]);
            for r in 0..R {
                sum[r] = sum[r].sub_mul(value, xi[r]);
                error[r] = error[r].sub_mul(value, xj[r]);
            }
        }
        own[0] = sum;
    }
}

/// The same in the same order for each word of the error, of which each is written once.
#[inline(always)]
fn residual_by_rows<T: Real, const R: usize>(
    rows: &Rows,
    values: &[T],
    rhs: &[[T; R]],
    x: &[[T; R]],
    error: &mut [[T; R]],
) {
    for (j, (error, &rhs)) in error.iter_mut().zip(rhs).enumerate() {
        let mut sum = rhs;
        for entry in rows.of(j) {
            let (value, x) = (values[entry.value as usize], &x[entry.column as usize]);
            for r in 0..R {
                sum[r] = sum[r].sub_mul(value, x[r]);
            }
        }
        *error = sum;
    }
}

/// Words of the refinement buffer, for each right-hand side.
pub mod refinement {
    /// ‖error‖∞; not finite when the error is not.
    pub const ERROR: usize = 0;
    /// An error this small is small enough.
    pub const ALLOWED: usize = 1;
    /// A step that leaves a larger error than this is the last.
    pub const WORTHWHILE: usize = 2;
    pub const WORDS: usize = 3;
}

/// A factored system.
#[derive(Clone, Copy)]
pub struct System<'a, T> {
    pub kkt: &'a Kkt,
    /// The matrix, unregularised.
    pub values: &'a [T],
    pub l: &'a [T],
    pub pivot_inverse: &'a [T],
}

/// Solve, and say how large the error is and what it may be: a share of the right-hand side, or `goal`.
#[inline(always)]
pub fn solve<T: Real, const R: usize>(
    system: System<T>,
    rhs: &[[T; R]],
    (relative, goal): (T, T),
    scratch: &mut [[T; R]],
    x: &mut [[T; R]],
    error: &mut [[T; R]],
    state: &mut [T],
) {
    let System { kkt, values, l, pivot_inverse } = system;
    x.copy_from_slice(rhs);
    substitute(&kkt.symbolic, l, pivot_inverse, kkt.rows.is_some(), scratch, x);
    residual(kkt, values, rhs, x, error);
    let (sizes, errors) = (max_abs_of(rhs), error_norms(error));
    for (r, state) in state.chunks_exact_mut(refinement::WORDS).enumerate() {
        state[refinement::ERROR] = errors[r];
        state[refinement::ALLOWED] = goal.max(relative * sizes[r]);
        state[refinement::WORTHWHILE] = errors[r];
    }
}

#[inline(always)]
fn error_norms<T: Real, const R: usize>(error: &[[T; R]]) -> [T; R] {
    let (mut norms, witnesses) = (max_abs_of(error), finite_witness_of(error));
    for r in 0..R {
        norms[r] = norms[r] + witnesses[r];
    }
    norms
}

/// One refinement step of a problem that is `active` (not zero). Of each right-hand side, the new solution
/// and error replace the old where their norm is smaller, and not where it is not a number.
#[inline(always)]
pub fn refine<T: Real, const R: usize>(
    system: System<T>,
    rhs: &[[T; R]],
    scratch: &mut [[T; R]],
    x: &mut [[T; R]],
    error: &mut [[T; R]],
    state: &mut [T],
    active: T,
) {
    let System { kkt, values, l, pivot_inverse } = system;
    let (candidate, rest) = scratch.split_at_mut(kkt.dim);
    let (new_error, scratch) = rest.split_at_mut(kkt.dim);
    candidate.copy_from_slice(error);
    substitute(&kkt.symbolic, l, pivot_inverse, kkt.rows.is_some(), scratch, candidate);
    for (words, x) in candidate.iter_mut().zip(x.iter()) {
        for r in 0..R {
            words[r] = x[r] + words[r];
        }
    }
    residual(kkt, values, rhs, candidate, new_error);
    let norms = error_norms(new_error);
    for (r, state) in state.chunks_exact_mut(refinement::WORDS).enumerate() {
        let (old, new) = (state[refinement::ERROR], norms[r]);
        let better = T::and(new.lt(old), T::zero().lt(active));
        for (kept, new) in x.iter_mut().zip(candidate.iter()).chain(error.iter_mut().zip(new_error.iter())) {
            kept[r] = T::select(better, new[r], kept[r]);
        }
        state[refinement::ERROR] = T::select(better, new, old);
        state[refinement::WORTHWHILE] = T::constant(0.25) * old;
    }
}

/// Unknowns in natural order from column `r` of the permuted solutions; expansion rows are left behind.
#[inline(always)]
pub fn unload<T: Real, const R: usize>(position: &[u32], permuted: &[[T; R]], r: usize, natural: &mut [T]) {
    for (word, &from) in natural.iter_mut().zip(position) {
        *word = permuted[from as usize][r];
    }
}

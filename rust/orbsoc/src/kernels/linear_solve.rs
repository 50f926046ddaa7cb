//! PL module *linear solve*: permuted substitution through L, D, Lᵀ and the refinement residual, for `R`
//! right-hand sides side by side.

use super::layout::refinement;
use super::reduce::{dot_of, max_abs_of, non_finite_flags};
use super::supernodal::condensed::{self, Condensed};
use super::supernodal::panel::{self, Panel};
use super::supernodal::simplicial::{self, Simplicial};
use crate::kkt::assembly::Kkt;
use crate::real::{outline, Real};
use crate::symbolic::factor_layout::{Supernode, Symbolic};
use crate::symbolic::{column_blocks::Uniformity, full_rows::Rows, supernodes::Kind};

/// `x ← (LDLᵀ)⁻¹ x`, everything in permuted order; `values` are the matrix's. With `divide_late`, each
/// panel divides by D when its entries are in cache; it is the same division.
#[inline(always)]
pub fn substitute<T: Real, const R: usize>(
    symbolic: &Symbolic,
    values: &[T],
    l: &[T],
    pivot_inverse: &[T],
    divide_late: bool,
    scratch: &mut [[T; R]],
    x: &mut [[T; R]],
) {
    for node in &symbolic.supernodes {
        if node.kind == Kind::Simplicial {
            let (columns, l) = (Simplicial::of(symbolic, node), &l[node.panel..]);
            outline::<T>(simplicial::Forward { columns, l, x: &mut x[node.first..] });
            continue;
        }
        let (known, trailing) = x.split_at_mut(node.first + node.width);
        let known = &mut known[node.first..];
        if node.kind == Kind::Condensed {
            let (condensed, inverse) = (Condensed::of(symbolic, node, values), &pivot_inverse[node.first..]);
            condensed::forward(condensed, inverse, known, symbolic.relative_rows(node), scratch, trailing);
        } else {
            panel::forward(panel_of(symbolic, node, l), known, trailing);
        }
    }
    if !divide_late {
        divide(x, pivot_inverse);
    }
    for node in symbolic.supernodes.iter().rev() {
        let own = node.first..node.first + node.width;
        if divide_late {
            divide(&mut x[own.clone()], &pivot_inverse[own.clone()]);
        }
        if node.kind == Kind::Simplicial {
            let (columns, l) = (Simplicial::of(symbolic, node), &l[node.panel..][..node.stored_entries()]);
            outline::<T>(simplicial::Backward { columns, l, x: &mut x[node.first..] });
            continue;
        }
        let (unknown, trailing) = x.split_at_mut(own.end);
        let unknown = &mut unknown[own.start..];
        if node.kind == Kind::Condensed {
            let (condensed, inverse) = (Condensed::of(symbolic, node, values), &pivot_inverse[node.first..]);
            condensed::backward(condensed, inverse, symbolic.relative_rows(node), trailing, scratch, unknown);
        } else {
            panel::backward(panel_of(symbolic, node, l), trailing, scratch, unknown);
        }
    }
}

#[inline(always)]
fn divide<T: Real, const R: usize>(x: &mut [[T; R]], pivot_inverse: &[T]) {
    for (entries, &inverse) in x.iter_mut().zip(pivot_inverse) {
        for entry in entries {
            *entry = *entry * inverse;
        }
    }
}

#[inline(always)]
fn panel_of<'a, T>(symbolic: &'a Symbolic, node: &Supernode, l: &'a [T]) -> Panel<'a, T> {
    Panel {
        l: &l[node.panel..][..node.width * node.leading_dim],
        leading_dim: node.leading_dim,
        diagonal_size: node.diagonal_size,
        rows: symbolic.relative_rows(node),
        leaves: node.kind == Kind::Leaves,
    }
}

/// `error = rhs − K·x` with the unregularised matrix, everything in permuted order. An entry of the error takes
/// its row's products in the order of their columns, the diagonal first; those of a dense column are one sum.
#[inline(always)]
pub fn residual<T: Real, const R: usize>(
    kkt: &Kkt,
    values: &[T],
    rhs: &[[T; R]],
    x: &[[T; R]],
    error: &mut [[T; R]],
) {
    if let Some(rows) = &kkt.rows {
        return residual_by_rows(kkt, rows, values, rhs, x, error);
    }
    error.copy_from_slice(rhs);
    for block in &kkt.column_blocks {
        let columns = block.columns.clone();
        let entries = kkt.column(columns.start).start..kkt.column(columns.end - 1).end;
        let (rows, values) = (&kkt.rowidx[entries.clone()], &values[entries]);
        match block.uniformity {
            Uniformity::FixedLength(0) => subtract_fixed::<T, R, 0, 1>(columns.start, rows, values, x, error),
            Uniformity::FixedLength(1) => subtract_fixed::<T, R, 1, 2>(columns.start, rows, values, x, error),
            Uniformity::FixedLength(2) => subtract_fixed::<T, R, 2, 3>(columns.start, rows, values, x, error),
            Uniformity::FixedLength(3) => subtract_fixed::<T, R, 3, 4>(columns.start, rows, values, x, error),
            Uniformity::FixedLength(_) => subtract_fixed::<T, R, 4, 5>(columns.start, rows, values, x, error),
            Uniformity::Contiguous | Uniformity::General => {
                let (mut rows, mut values) = (rows, values);
                for j in columns {
                    let (here, column);
                    (here, rows) = rows.split_at(kkt.column(j).len());
                    (column, values) = values.split_at(here.len());
                    if block.uniformity == Uniformity::Contiguous {
                        subtract_contiguous(j, here[0] as usize, column, x, error);
                    } else {
                        subtract_column(j, here, column, x, error);
                    }
                }
            }
        }
    }
}

/// What column `j` of the upper triangle and its mirror image contribute.
#[inline(always)]
fn subtract_column<T: Real, const R: usize>(
    j: usize,
    rows: &[u32],
    column: &[T],
    x: &[[T; R]],
    error: &mut [[T; R]],
) {
    let (Some((_, rows)), Some((&diagonal, column))) = (rows.split_last(), column.split_last()) else {
        return;
    };
    let (known, xj) = (&x[..j], x[j]);
    let (error, own) = error.split_at_mut(j);
    let mut sum = subtract(own[0], diagonal, xj);
    for (&i, &value) in rows.iter().zip(column) {
        sum = subtract(sum, value, known[i as usize]);
        error[i as usize] = subtract(error[i as usize], value, xj);
    }
    own[0] = sum;
}

/// The same for columns of `L` entries above the diagonal's, `H` with it, from column `first` on.
#[inline(always)]
fn subtract_fixed<T: Real, const R: usize, const L: usize, const H: usize>(
    first: usize,
    rows: &[u32],
    values: &[T],
    x: &[[T; R]],
    error: &mut [[T; R]],
) {
    let columns = rows.as_chunks::<H>().0.iter().zip(values.as_chunks::<H>().0);
    for ((j, &xj), (rows, column)) in x.iter().enumerate().skip(first).zip(columns) {
        let mut sum = subtract(error[j], column[L], xj);
        for k in 0..L {
            let i = rows[k] as usize;
            sum = subtract(sum, column[k], x[i]);
            error[i] = subtract(error[i], column[k], xj);
        }
        error[j] = sum;
    }
}

/// The same for a column whose rows above the diagonal's are adjacent, from row `first` on.
#[inline(always)]
fn subtract_contiguous<T: Real, const R: usize>(
    j: usize,
    first: usize,
    column: &[T],
    x: &[[T; R]],
    error: &mut [[T; R]],
) {
    let Some((&diagonal, column)) = column.split_last() else { return };
    let (xj, rows) = (x[j], first..first + column.len());
    let (error, own) = error.split_at_mut(j);
    own[0] = subtract_sum(subtract(own[0], diagonal, xj), dot_of(column, &x[rows.clone()]));
    T::subtract_multiple(&mut error[rows], column, xj);
}

/// `entry − value·x`, for each right-hand side.
#[inline(always)]
fn subtract<T: Real, const R: usize>(mut entry: [T; R], value: T, x: [T; R]) -> [T; R] {
    for r in 0..R {
        entry[r] = entry[r].sub_mul(value, x[r]);
    }
    entry
}

#[inline(always)]
fn subtract_sum<T: Real, const R: usize>(mut entry: [T; R], sum: [T; R]) -> [T; R] {
    for r in 0..R {
        entry[r] = entry[r] - sum[r];
    }
    entry
}

/// The same in the same order for each entry of the error, of which each is written once.
#[inline(always)]
fn residual_by_rows<T: Real, const R: usize>(
    kkt: &Kkt,
    rows: &Rows,
    values: &[T],
    rhs: &[[T; R]],
    x: &[[T; R]],
    error: &mut [[T; R]],
) {
    for block in &kkt.column_blocks {
        for j in block.columns.clone() {
            let (entries, mut sum) = (rows.of(j), rhs[j]);
            let mut entries = entries.iter();
            if block.uniformity == Uniformity::Contiguous {
                let column = kkt.column(j);
                let (first, above) = (kkt.rowidx[column.start] as usize, column.len() - 1);
                sum = subtract(sum, values[column.end - 1], x[j]);
                sum = subtract_sum(sum, dot_of(&values[column.start..][..above], &x[first..first + above]));
                entries.nth(above);
            }
            for entry in entries {
                sum = subtract(sum, values[entry.value as usize], x[entry.column as usize]);
            }
            error[j] = sum;
        }
    }
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

/// Solve.
#[inline(always)]
pub fn solve<T: Real, const R: usize>(
    system: System<T>,
    rhs: &[[T; R]],
    scratch: &mut [[T; R]],
    x: &mut [[T; R]],
) {
    let System { kkt, values, l, pivot_inverse } = system;
    x.copy_from_slice(rhs);
    substitute(&kkt.symbolic, values, l, pivot_inverse, kkt.rows.is_some(), scratch, x);
}

/// The residual's norm, and what it may be: a fraction of the right-hand side, or `tolerance`.
#[inline(always)]
pub fn measure<T: Real, const R: usize>(
    system: System<T>,
    rhs: &[[T; R]],
    (relative, tolerance): (T, T),
    x: &[[T; R]],
    error: &mut [[T; R]],
    state: &mut [T],
) {
    residual(system.kkt, system.values, rhs, x, error);
    let (sizes, errors) = (max_abs_of(rhs), error_norms(error));
    for (r, state) in state.chunks_exact_mut(refinement::WORDS).enumerate() {
        state[refinement::ERROR] = errors[r];
        state[refinement::ALLOWED] = tolerance.max(relative * sizes[r]);
        state[refinement::WORTHWHILE] = errors[r];
    }
}

#[inline(always)]
fn error_norms<T: Real, const R: usize>(error: &[[T; R]]) -> [T; R] {
    let (mut norms, witnesses) = (max_abs_of(error), non_finite_flags(error));
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
    substitute(&kkt.symbolic, values, l, pivot_inverse, kkt.rows.is_some(), scratch, candidate);
    for (entries, x) in candidate.iter_mut().zip(x.iter()) {
        for r in 0..R {
            entries[r] = x[r] + entries[r];
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

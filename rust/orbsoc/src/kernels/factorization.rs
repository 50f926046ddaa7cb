//! PL module *matrix factorization*: numeric LDLᵀ on the elimination walk resolved at set-up.
//!
//! Left-looking over supernodes. With y the unscaled column (y = L·d), every entry receives
//! `l_ij ← k_ij − Σ_k l_ik·y_jk` in ascending k, whatever the supernodes are; then `d_j` is
//! regularised and the column divided by it.

use super::panel::{subtract_columns, subtract_scattered};
use crate::real::Real;
use crate::symbolic::{Supernode, Symbolic, Update};

/// Regularisation of the pivots, whose signs are known from the pattern.
#[derive(Clone, Copy)]
pub struct Regularization<T> {
    /// Added to every diagonal entry with its sign.
    pub shift: T,
    /// Pivots below this, in the direction of their sign, …
    pub floor: T,
    /// … become this.
    pub replacement: T,
}

/// Factor `values` (permuted upper triangle). `positive` holds the pivots' signs.
/// Outputs: unscaled columns `y` and scaled columns `l` as panels, reciprocal pivots, scratch.
#[inline(always)]
#[allow(clippy::too_many_arguments)] // three inputs, three outputs, pattern, scratch
pub fn factorize<T: Real>(
    symbolic: &Symbolic,
    positive: &[bool],
    regularization: Regularization<T>,
    values: &[T],
    scratch: &mut [T],
    y: &mut [T],
    l: &mut [T],
    pivot_inverse: &mut [T],
) {
    y.fill(T::zero());
    for (&to, &value) in symbolic.load.iter().zip(values) {
        y[to as usize] = value;
    }
    for node in &symbolic.supernodes {
        let (done, panel) = y.split_at_mut(node.panel);
        let panel = &mut panel[..node.width * node.height];
        for update in &symbolic.updates[node.updates.0..node.updates.1] {
            let source = &symbolic.supernodes[update.source];
            apply_update(symbolic, node, source, *update, done, l, scratch, panel);
        }
        let l = &mut l[node.panel..node.panel + node.width * node.height];
        factor_panel(node, positive, regularization, panel, l, pivot_inverse);
    }
}

/// Subtract a finished supernode's contribution from a later one.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn apply_update<T: Real>(
    symbolic: &Symbolic,
    node: &Supernode,
    source: &Supernode,
    update: Update,
    y: &[T],
    l: &[T],
    scratch: &mut [T],
    panel: &mut [T],
) {
    let rows = symbolic.rows_of(source);
    let (height, words) = (source.height, source.width * source.height);
    let (y, l) = (&y[source.panel..source.panel + words], &l[source.panel..source.panel + words]);
    for row in update.lo..update.hi {
        let column = rows[row] as usize - node.first;
        let target = &mut panel[column * node.height..(column + 1) * node.height];
        let landing = &symbolic.relative[update.relative + row - update.lo..][..height - row];
        subtract_scattered(
            source.width,
            height,
            row,
            l,
            #[inline(always)]
            |k| y[k * height + row],
            landing,
            scratch,
            target,
        );
    }
}

/// Factor a supernode whose contributions from earlier ones are in.
#[inline(always)]
fn factor_panel<T: Real>(
    node: &Supernode,
    positive: &[bool],
    regularization: Regularization<T>,
    panel: &mut [T],
    l: &mut [T],
    pivot_inverse: &mut [T],
) {
    for c in 0..node.width {
        let (earlier, current) = panel.split_at_mut(c * node.height);
        let current = &mut current[c..node.height];
        subtract_columns(
            c,
            node.height,
            c,
            l,
            #[inline(always)]
            |k| earlier[k * node.height + c],
            current,
        );
        let j = node.first + c;
        let pivot = regularized(current[0], positive[j], regularization);
        let inverse = T::one() / pivot;
        pivot_inverse[j] = inverse;
        for (l, &y) in l[c * node.height + c + 1..(c + 1) * node.height].iter_mut().zip(&current[1..]) {
            *l = y * inverse;
        }
    }
}

/// The pivot with static and dynamic regularisation, by its known sign.
#[inline(always)]
fn regularized<T: Real>(pivot: T, positive: bool, by: Regularization<T>) -> T {
    if positive {
        let pivot = pivot + by.shift;
        T::select(pivot.lt(by.floor), by.replacement, pivot)
    } else {
        let (pivot, ceiling) = (pivot - by.shift, -by.floor);
        T::select(ceiling.lt(pivot), -by.replacement, pivot)
    }
}

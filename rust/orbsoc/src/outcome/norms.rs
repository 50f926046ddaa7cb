//! Products, sums and norms of the verification, each one function for each instruction set. They run once in a solve, when
//! what a small problem waits for is their code, read from memory: a copy for every place that calls them took
//! a fifth of all the code that such a solve runs.

use crate::problem::Csc;
use nalgebra::{DVector, DVectorView};

/// The machine's instruction set.
#[derive(Clone, Copy)]
pub(crate) struct Sums(pulp::Arch);

impl Sums {
    pub fn new() -> Self {
        Self(pulp::Arch::new())
    }

    /// M x and Mᵀ y in one pass over M.
    #[inline(never)]
    pub fn products(self, matrix: &Csc, x: &DVector<f64>, y: &DVector<f64>) -> (DVector<f64>, DVector<f64>) {
        let (mut by_rows, mut by_columns) = (DVector::zeros(matrix.nrows()), DVector::zeros(matrix.ncols()));
        let (rows, columns) = (by_rows.as_mut_slice(), by_columns.as_mut_slice());
        self.0.dispatch(
            #[inline(always)]
            || multiply(matrix, x.as_slice(), y.as_slice(), rows, columns),
        );
        (by_rows, by_columns)
    }

    /// Add a multiple of one vector to another.
    #[inline(never)]
    pub fn add(self, to: &mut DVector<f64>, factor: f64, v: &[f64]) {
        let to = to.as_mut_slice();
        self.0.dispatch(
            #[inline(always)]
            || to.iter_mut().zip(v).for_each(|(to, v)| *to += factor * v),
        );
    }

    /// aᵀb.
    #[inline(never)]
    pub fn dot(self, a: &[f64], b: &[f64]) -> f64 {
        self.0.dispatch(
            #[inline(always)]
            || DVectorView::from(a).dot(&DVectorView::from(b)),
        )
    }

    /// ‖x‖∞; infinite when x is not finite, zero when it is empty.
    #[inline(never)]
    pub fn norm(self, x: &[f64]) -> f64 {
        self.0.dispatch(
            #[inline(always)]
            || norm(x),
        )
    }

    /// Σ |a_k|.
    #[inline(never)]
    pub fn size(self, a: &[f64]) -> f64 {
        self.0.dispatch(
            #[inline(always)]
            || side_by_side(a, a, |a, _| a.abs()),
        )
    }

    /// Σ |a_k·b_k|.
    #[inline(never)]
    pub fn magnitude(self, a: &[f64], b: &[f64]) -> f64 {
        self.0.dispatch(
            #[inline(always)]
            || side_by_side(a, b, |a, b| (a * b).abs()),
        )
    }
}

/// P x, from P's upper triangle.
#[inline(never)]
pub(crate) fn symmetric_product(upper: &Csc, x: &DVector<f64>) -> DVector<f64> {
    let mut out = DVector::zeros(upper.nrows());
    let (sums, x) = (out.as_mut_slice(), x.as_slice());
    for (j, (rows, values)) in upper.columns().enumerate() {
        for (&i, &value) in rows.iter().zip(values) {
            sums[i] += value * x[j];
            if i != j {
                sums[j] += value * x[i];
            }
        }
    }
    out
}

#[inline(always)]
fn multiply(matrix: &Csc, x: &[f64], y: &[f64], by_rows: &mut [f64], by_columns: &mut [f64]) {
    for (((rows, values), out), &x) in matrix.columns().zip(by_columns).zip(x) {
        // Adjacent rows, as all of a dense matrix, are read and written side by side: the same sums.
        if let [first, .., last] = *rows {
            if last - first + 1 == rows.len() {
                let (by_rows, y) = (&mut by_rows[first..=last], &y[first..=last]);
                by_rows.iter_mut().zip(values).for_each(|(sum, &value)| *sum += value * x);
                *out = four_sums(values, y, |&y| y);
                continue;
            }
        }
        for (&i, &value) in rows.iter().zip(values) {
            by_rows[i] += value * x;
        }
        *out = four_sums(values, rows, |&i| y[i]);
    }
}

/// Σ of value times factor, four sums side by side: one alone would wait for each addition.
#[inline(always)]
fn four_sums<B>(values: &[f64], factors: &[B], factor: impl Fn(&B) -> f64) -> f64 {
    let mut four = [0.0; 4];
    let (value_chunks, factor_chunks) = (values.as_chunks::<4>(), factors.as_chunks::<4>());
    for (values, factors) in value_chunks.0.iter().zip(factor_chunks.0) {
        for k in 0..4 {
            four[k] += values[k] * factor(&factors[k]);
        }
    }
    let rest: f64 = factor_chunks.1.iter().zip(value_chunks.1).map(|(f, v)| v * factor(f)).sum();
    rest + ((four[0] + four[2]) + (four[1] + four[3]))
}

#[inline(always)]
fn norm(x: &[f64]) -> f64 {
    // Several maxima side by side: one alone would wait for each comparison.
    let (mut top, mut zero) = ([0.0; 8], [0.0; 8]);
    let (chunks, rest) = x.as_chunks::<8>();
    for entries in chunks {
        for k in 0..8 {
            top[k] = larger(top[k], entries[k].abs());
            zero[k] += entries[k] * 0.0;
        }
    }
    for (k, entry) in rest.iter().enumerate() {
        top[k] = larger(top[k], entry.abs());
        zero[k] += entry * 0.0;
    }
    if zero == [0.0; 8] {
        top.into_iter().fold(0.0, larger)
    } else {
        f64::INFINITY
    }
}

/// The sum of the terms, eight sums side by side.
#[inline(always)]
fn side_by_side(a: &[f64], b: &[f64], term: impl Fn(f64, f64) -> f64) -> f64 {
    let mut sums = [0.0; 8];
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    for (a, b) in a.iter().zip(b) {
        for k in 0..8 {
            sums[k] += term(a[k], b[k]);
        }
    }
    sums.into_iter().sum::<f64>() + a_rest.iter().zip(b_rest).map(|(&a, &b)| term(a, b)).sum::<f64>()
}

/// The larger one; a NaN on the right is dropped.
#[inline(always)]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a < b {
        b
    } else {
        a
    }
}

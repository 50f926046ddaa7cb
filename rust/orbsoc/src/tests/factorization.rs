//! LDLᵀ and substitution against a textbook factorisation, faer's, and the definition, on random sparse
//! quasi-definite matrices of every size from 0 to 64.

use crate::kernels::factorization::{self as kernels, factorize};
use crate::kernels::linear_solve::substitute;
use crate::kernels::supernodal::condensed::Condensed;
use crate::kernels::supernodal::pivots::Regularization;
use crate::kernels::supernodal::watch::{Unwatched, Watch, Watched};
use crate::real::{count, Counted, Latency, OperationCounts};
use crate::symbolic::factor_layout::{Supernode, Symbolic};
use crate::symbolic::indices::index;
use crate::symbolic::ordering::{fill_reducing_order, Ordering};
use crate::symbolic::supernodes::{Kind, Panels};
use crate::symbolic::upper::Upper;
use crate::tests::reference::SplitMix64;
use crate::{Decide, Real};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::cholesky::simplicial;
use faer::sparse::SparseColMatRef;
use nalgebra::{DMatrix, DVector};

const REGULARIZATION: Regularization<f64> =
    Regularization { shift_up: 1e-9, shift_down: 1e-7, floor: 1e-13, replacement: 2e-7 };

/// A matrix in its final order.
struct Matrix {
    upper: Upper,
    values: Vec<f64>,
    positive: Vec<bool>,
}

impl Matrix {
    fn dim(&self) -> usize {
        self.positive.len()
    }

    fn dense(&self) -> DMatrix<f64> {
        let mut out = DMatrix::zeros(self.dim(), self.dim());
        for j in 0..self.dim() {
            for k in self.upper.range(j) {
                let i = self.upper.rowidx[k] as usize;
                out[(i, j)] = self.values[k];
                out[(j, i)] = self.values[k];
            }
        }
        out
    }

    fn sign(&self, j: usize) -> f64 {
        if self.positive[j] {
            1.0
        } else {
            -1.0
        }
    }

    /// What regularisation adds to diagonal entry `j`.
    fn shift(&self, j: usize) -> f64 {
        if self.sign(j) > 0.0 {
            REGULARIZATION.shift_up
        } else {
            -REGULARIZATION.shift_down
        }
    }

    /// With the static regularisation on the diagonal.
    fn regularized(&self) -> DMatrix<f64> {
        let mut out = self.dense();
        (0..self.dim()).for_each(|j| out[(j, j)] += self.shift(j));
        out
    }
}

/// [H, Bᵀ; B, −R] with diagonally dominant H and R, in a fill-reducing order. `exact` numbers are
/// small integers, so that zeros turn up within the pattern.
fn quasi_definite(dim: usize, density: f64, exact: bool, seed: u64) -> Matrix {
    let mut numbers = SplitMix64(seed);
    let positive: Vec<bool> = (0..dim).map(|_| numbers.unit() < 0.6).collect();
    let mut dominance = vec![0.1; dim];
    let (mut entries, mut values) = (Vec::new(), Vec::new());
    for j in 0..dim {
        for i in 0..j {
            if numbers.unit() < density {
                let value = if exact { (3.0 * numbers.signed()).round() } else { numbers.signed() };
                entries.push((i, j));
                values.push(value);
                if positive[i] == positive[j] {
                    dominance[i] += value.abs();
                    dominance[j] += value.abs();
                }
            }
        }
    }
    for j in 0..dim {
        entries.push((j, j));
        let size = if exact { dominance[j].ceil() } else { dominance[j] + numbers.unit() };
        values.push(if positive[j] { size } else { -size });
    }
    ordered(dim, &entries, &values, &positive)
}

fn ordered(dim: usize, entries: &[(usize, usize)], values: &[f64], positive: &[bool]) -> Matrix {
    let entries: Vec<(u32, u32)> = entries.iter().map(|&(i, j)| (index(i), index(j))).collect();
    let (natural, place) = Upper::from_positions(dim, &entries);
    let order = fill_reducing_order(&natural, Ordering::Amd).unwrap();
    let (upper, permuted_place) = natural.permuted(&order);
    let mut permuted = vec![0.0; values.len()];
    values
        .iter()
        .zip(&place)
        .for_each(|(&value, &to)| permuted[permuted_place[to as usize] as usize] = value);
    Matrix { upper, values: permuted, positive: order.iter().map(|&old| positive[old as usize]).collect() }
}

struct Factor<T> {
    symbolic: Symbolic,
    values: Vec<T>,
    l: Vec<T>,
    pivot_inverse: Vec<T>,
}

fn factor<T: Real>(matrix: &Matrix, by: Regularization<T>, panels: Panels) -> Factor<T> {
    factor_watched(matrix, by, panels, &mut Unwatched)
}

fn factor_watched<T: Real>(
    matrix: &Matrix,
    by: Regularization<T>,
    panels: Panels,
    watch: &mut impl Watch,
) -> Factor<T> {
    let symbolic = Symbolic::new(&matrix.upper, panels).unwrap();
    let entries = |len| vec![T::zero(); len];
    let values: Vec<T> = matrix.values.iter().map(|&v| T::constant(v)).collect();
    let (mut l, mut pivot_inverse) = (entries(symbolic.panel_entries), entries(matrix.dim()));
    let mut scratch = entries(symbolic.max_panel);
    let out = kernels::Factor { l: &mut l, pivot_inverse: &mut pivot_inverse, scratch: &mut scratch };
    factorize(&symbolic, &matrix.positive, by, &values, out, watch);
    Factor { symbolic, values, l, pivot_inverse }
}

impl<T: Decide> Factor<T> {
    fn l(&self) -> DMatrix<f64> {
        let dim = self.pivot_inverse.len();
        let mut out = DMatrix::identity(dim, dim);
        for node in &self.symbolic.supernodes {
            if node.kind == Kind::Condensed {
                let given = Condensed::of(&self.symbolic, node, &self.values);
                for (k, &row) in self.symbolic.row_structure(node).iter().enumerate() {
                    for (c, entry) in given.row(k).iter().enumerate() {
                        let at = node.first + c;
                        out[(row as usize, at)] = entry.value() * self.pivot_inverse[at].value();
                    }
                }
                continue;
            }
            for column in node.first..node.first + node.width {
                let begin = self.symbolic.column_begin(node, column);
                for (row, at) in self.symbolic.entries(node, column) {
                    out[(row, column)] = self.l[begin + at].value();
                }
            }
        }
        out
    }

    fn d(&self) -> DVector<f64> {
        DVector::from_iterator(self.pivot_inverse.len(), self.pivot_inverse.iter().map(|v| 1.0 / v.value()))
    }
}

impl<T: Real> Factor<T> {
    fn solve(&self, rhs: &[T]) -> Vec<T> {
        let mut out = rhs.to_vec();
        let mut scratch = vec![[T::zero()]; self.symbolic.substitution_scratch];
        let x = out.as_chunks_mut::<1>().0;
        substitute(&self.symbolic, &self.values, &self.l, &self.pivot_inverse, false, &mut scratch, x);
        out
    }
}

/// Dense LDLᵀ, column by column, as textbooks have it.
fn textbook(k: &DMatrix<f64>) -> (DMatrix<f64>, DVector<f64>) {
    let dim = k.nrows();
    let (mut l, mut d) = (DMatrix::identity(dim, dim), DVector::zeros(dim));
    for j in 0..dim {
        d[j] = k[(j, j)] - (0..j).map(|k| l[(j, k)] * l[(j, k)] * d[k]).sum::<f64>();
        for i in j + 1..dim {
            let sum: f64 = (0..j).map(|k| l[(i, k)] * l[(j, k)] * d[k]).sum();
            l[(i, j)] = (k[(i, j)] - sum) / d[j];
        }
    }
    (l, d)
}

fn faers(matrix: &Matrix) -> (DMatrix<f64>, DVector<f64>) {
    let dim = matrix.dim();
    let pattern = matrix.upper.faer();
    let (mut parent, mut counts) = (vec![0; dim], vec![0; dim]);
    let nnz = matrix.upper.nnz();
    let mut memory = MemBuffer::new(simplicial::prefactorize_symbolic_cholesky_scratch::<u32>(dim, nnz));
    let stack = MemStack::new(&mut memory);
    let tree = simplicial::prefactorize_symbolic_cholesky(&mut parent, &mut counts, pattern, stack);
    let mut memory = MemBuffer::new(simplicial::factorize_simplicial_symbolic_cholesky_scratch::<u32>(dim));
    let stack = MemStack::new(&mut memory);
    let symbolic = simplicial::factorize_simplicial_symbolic_cholesky(pattern, tree, &counts, stack).unwrap();
    let mut values = matrix.values.clone();
    for j in 0..dim {
        values[matrix.upper.range(j).end - 1] += matrix.shift(j);
    }
    let mut stored = vec![0.0; symbolic.len_val()];
    let scratch = simplicial::factorize_simplicial_numeric_ldlt_scratch::<u32, f64>(dim);
    let mut memory = MemBuffer::new(scratch);
    simplicial::factorize_simplicial_numeric_ldlt(
        &mut stored,
        SparseColMatRef::new(pattern, &values),
        faer::linalg::cholesky::ldlt::factor::LdltRegularization::default(),
        &symbolic,
        MemStack::new(&mut memory),
    )
    .unwrap();
    let (mut l, mut d) = (DMatrix::identity(dim, dim), DVector::zeros(dim));
    for j in 0..dim {
        let entries = symbolic.col_ptr()[j] as usize..symbolic.col_ptr()[j + 1] as usize;
        d[j] = stored[entries.start];
        for k in entries.skip(1) {
            l[(symbolic.row_idx()[k] as usize, j)] = stored[k];
        }
    }
    (l, d)
}

/// Rows of a dense inequality matrix, diagonal among themselves, above unknowns that they alone connect: columns
/// that share their rows, and a few that lack one of them.
fn inequalities(rows: usize, unknowns: usize, seed: u64) -> Matrix {
    let mut numbers = SplitMix64(seed);
    let dim = unknowns + rows;
    let positive: Vec<bool> = (0..dim).map(|i| i < unknowns).collect();
    let mut entries: Vec<(usize, usize)> = (0..dim).map(|i| (i, i)).collect();
    let mut values: Vec<f64> =
        positive.iter().map(|&up| if up { 0.5 } else { -1.0 } * (0.5 + numbers.unit())).collect();
    for (row, unknown) in (unknowns..dim).flat_map(|row| (0..unknowns).map(move |unknown| (row, unknown))) {
        if row % 11 != 3 || unknown != row % unknowns {
            entries.push((unknown, row));
            values.push(numbers.signed());
        }
    }
    ordered(dim, &entries, &values, &positive)
}

/// `count` blocks of `size` unknowns that only a dense border of `border` connects, each with a `share` of its rows.
fn arrow(count: usize, size: usize, border: usize, share: f64, seed: u64) -> Matrix {
    let mut numbers = SplitMix64(seed);
    let dim = count * size + border;
    let positive: Vec<bool> = (0..dim).map(|_| numbers.unit() < 0.6).collect();
    let mut entries: Vec<(usize, usize)> = (0..dim).map(|i| (i, i)).collect();
    let mut values: Vec<f64> = positive
        .iter()
        .map(|&up| if up { dim as f64 } else { -(dim as f64) } * (1.0 + numbers.unit()))
        .collect();
    let mut connect = |i: usize, j: usize, value: f64| {
        entries.push((i, j));
        values.push(value);
    };
    for first in (0..count).map(|block| block * size) {
        for row in (dim - border..dim).filter(|_| numbers.unit() < share).collect::<Vec<_>>() {
            (first..first + size).for_each(|i| connect(i, row, numbers.signed()));
        }
        for (i, j) in (first..first + size).flat_map(|j| (first..j).map(move |i| (i, j))) {
            connect(i, j, numbers.signed());
        }
    }
    for (i, j) in (dim - border..dim).flat_map(|j| (dim - border..j).map(move |i| (i, j))) {
        connect(i, j, numbers.signed());
    }
    ordered(dim, &entries, &values, &positive)
}

/// Unknowns of tasks, each connected to its task's and to all but the last or all but the first of the `shared` ones: not
/// every two rows that neighbours have between them are connected.
fn sensors(tasks: usize, each: usize, shared: usize, seed: u64) -> Matrix {
    let mut numbers = SplitMix64(seed);
    let columns = 2 * tasks * each;
    let dim = columns + tasks + shared;
    let positive: Vec<bool> = (0..dim).map(|i| i < columns).collect();
    let mut entries: Vec<(usize, usize)> = (0..dim).map(|i| (i, i)).collect();
    let mut values: Vec<f64> =
        positive.iter().map(|&up| if up { 1.0 } else { -1.0 } * (0.5 + numbers.unit())).collect();
    for i in 0..columns {
        let sensor = i / each % 2;
        let rows = (0..shared - 1).map(|row| columns + tasks + row + sensor);
        for row in rows.chain([columns + i / (2 * each)]) {
            entries.push((i, row));
            values.push(numbers.signed());
        }
    }
    ordered(dim, &entries, &values, &positive)
}

#[test]
fn columns_that_share_their_rows_and_depend_on_none_are_not_stored() {
    for (rows, unknowns) in [(60, 7), (90, 16)] {
        let matrix = inequalities(rows, unknowns, 3);
        for panels in [Panels::Exact, Panels::Relaxed] {
            let symbolic = Symbolic::new(&matrix.upper, panels).unwrap();
            let given = symbolic.supernodes.iter().filter(|node| node.kind == Kind::Condensed);
            let columns: usize = given.map(|node| node.width).sum();
            // Minimum degree takes the unknowns first once fewer rows than unknowns are left.
            let alike = (unknowns..unknowns + rows).filter(|row| row % 11 != 3).count();
            assert!((alike - unknowns..=alike).contains(&columns), "{columns} of {alike}");
            let left = unknowns + rows - columns;
            assert!(symbolic.panel_entries <= left * left, "{} words", symbolic.panel_entries);
        }
    }
}

fn matrices() -> impl Iterator<Item = Matrix> {
    let sizes = (0..=64).flat_map(|dim| [0.05, 0.2, 0.7].map(|density| (dim, density)));
    sizes
        .chain([(200, 0.01), (300, 0.02)])
        .enumerate()
        .map(|(seed, (dim, density))| quasi_definite(dim, density, false, seed as u64))
        .chain([(60, 7), (9, 5), (90, 16)].map(|(rows, unknowns)| inequalities(rows, unknowns, 5)))
        .chain((1..=5).map(|top| arrow(9, top, 14, 1.0, top as u64)))
        .chain((1..=3).map(|top| arrow(11, top, 14, 0.7, top as u64)))
        .chain((4..=6).map(|shared| sensors(4, shared, shared + 1, shared as u64)))
}

/// |LDLᵀ − K| ≤ γ |L||D||L|ᵀ entrywise, the bound that any order of the operations obeys.
fn assert_factors<T: Decide>(matrix: &Matrix, by: Regularization<T>) {
    let at = factor(matrix, by, Panels::Relaxed);
    let (l, d) = (at.l(), at.d());
    let error = &l * DMatrix::from_diagonal(&d) * l.transpose() - matrix.regularized();
    let size = l.abs() * DMatrix::from_diagonal(&d.abs()) * l.abs().transpose();
    let gamma = (matrix.dim() + 4) as f64 * T::epsilon();
    for (error, size) in error.iter().zip(size.iter()) {
        assert!(error.abs() <= gamma * size, "{error} in a matrix of size {}", matrix.dim());
    }
}

#[test]
fn factors_multiply_back_to_the_regularised_matrix_in_both_precisions() {
    let c = f32::constant;
    for matrix in matrices() {
        assert_factors::<f64>(&matrix, REGULARIZATION);
        let single =
            Regularization { shift_up: c(1e-9), shift_down: c(1e-7), floor: c(1e-13), replacement: c(2e-7) };
        assert_factors::<f32>(&matrix, single);
    }
}

#[test]
fn factors_are_the_textbooks_and_faers() {
    for matrix in matrices() {
        let at = factor(&matrix, REGULARIZATION, Panels::Relaxed);
        for (l, d) in [textbook(&matrix.regularized()), faers(&matrix)] {
            // Quasi-definite with dominance 0.1: entries of size up to 1e2, pivots at least 0.1.
            let scale = l.amax().max(1.0);
            assert!((at.l() - &l).amax() <= 1e-11 * scale, "L of size {}", matrix.dim());
            for (found, expected) in at.d().iter().zip(d.iter()) {
                assert!((found / expected - 1.0).abs() <= 1e-11, "pivot of size {}", matrix.dim());
            }
        }
    }
}

#[test]
fn substitution_solves_with_the_factors() {
    for matrix in matrices() {
        let at = factor(&matrix, REGULARIZATION, Panels::Relaxed);
        let rhs = SplitMix64(9).list(matrix.dim());
        let x = DVector::from_vec(at.solve(&rhs));
        let error = matrix.regularized() * &x - DVector::from_vec(rhs);
        // Backward stable up to the factors' growth: γ |L||D||L|ᵀ|x|.
        let l = at.l().abs();
        let bound = &l * DMatrix::from_diagonal(&at.d().abs()) * l.transpose() * x.abs();
        for (error, bound) in error.iter().zip(bound.iter()) {
            assert!(error.abs() <= 4.0 * (matrix.dim() + 1) as f64 * f64::EPSILON * bound);
        }
    }
}

/// Equal numbers are equal entries but for the sign of zero: −0 − (−0·y) is +0, so a stored zero can
/// turn a −0 that it meets. Small integers make zeros of both signs within the pattern.
#[test]
fn exact_and_relaxed_panels_give_the_same_words_but_for_the_sign_of_zero() {
    let mut found = [0; 4];
    for seed in 0..240 {
        let matrix = match seed % 8 {
            5 => sensors(3 + seed % 4, 3 + seed / 8 % 4, 5 + seed % 9, seed as u64),
            7 => inequalities(30 + seed % 50, 5 + seed % 9, seed as u64),
            6 => arrow(
                4 + seed % 11,
                1 + seed / 8 % 5,
                8 + seed % 17,
                1.0 - (seed % 3) as f64 / 8.0,
                seed as u64,
            ),
            _ => quasi_definite(1 + seed % 64, 0.1, seed % 2 == 0, seed as u64),
        };
        let exact = factor(&matrix, REGULARIZATION, Panels::Exact);
        let plain = |node: &Supernode| {
            node.kind != Kind::Simplicial && (node.diagonal_size == 1 || node.diagonal_size == node.width)
        };
        assert!(exact.symbolic.supernodes.iter().all(plain));
        for panels in [Panels::Relaxed, Panels::Lanes] {
            let relaxed = factor(&matrix, REGULARIZATION, panels);
            let nodes = &relaxed.symbolic.supernodes;
            let is = |node: &Supernode, which: fn(&Supernode) -> bool| {
                node.kind == Kind::IndependentTwins && which(node)
            };
            found[0] += usize::from(relaxed.symbolic.panel_entries != exact.symbolic.panel_entries);
            found[1] += nodes.iter().filter(|node| node.kind == Kind::Simplicial).count();
            found[2] += nodes.iter().filter(|node| is(node, |node| node.diagonal_size > 1)).count();
            found[3] += nodes
                .iter()
                .filter(|node| is(node, |node| node.diagonal_size == 1 && node.width > 3))
                .count();
            assert_eq!(exact.pivot_inverse, relaxed.pivot_inverse);
            assert_eq!(exact.l(), relaxed.l());
            let whole = |v: &f64| (2.0 * v).round();
            let rhs: Vec<f64> = SplitMix64(seed as u64).list(matrix.dim()).iter().map(whole).collect();
            assert_eq!(exact.solve(&rhs), relaxed.solve(&rhs));
        }
    }
    let what = ["changed panels", "simplicial columns", "merged supernodes", "merged columns"];
    assert!(found.iter().all(|&count| count > 20), "{what:?}: {found:?}");
}

/// Below the diagonal, by eliminating the pattern with no cleverness at all.
fn column_counts(upper: &Upper) -> Vec<usize> {
    let dim = upper.dim();
    let mut filled = vec![vec![false; dim]; dim];
    for (j, row) in filled.iter_mut().enumerate() {
        upper.column(j).iter().for_each(|&i| row[i as usize] = true);
    }
    for k in 0..dim {
        for i in k + 1..dim {
            for j in k + 1..i {
                filled[i][j] |= filled[i][k] && filled[j][k];
            }
        }
    }
    (0..dim).map(|k| (k + 1..dim).filter(|&i| filled[i][k]).count()).collect()
}

/// What a factorisation asks for, from the column counts c of L: Σc(c+1)/2 multiply–subtracts, Σc
/// products by the reciprocal pivot, one division and the regularisation for each pivot, a product and a bound among it.
#[test]
fn operations_are_the_closed_forms_of_the_column_counts() {
    for matrix in matrices().step_by(5) {
        let symbolic = Symbolic::new(&matrix.upper, Panels::Exact).unwrap();
        if symbolic.supernodes.iter().any(|node| node.kind == Kind::Condensed) {
            continue; // as many operations, but sums instead of subtractions
        }
        let below = column_counts(&matrix.upper);
        let (nnz, updates): (usize, usize) =
            below.iter().fold((0, 0), |(n, u), c| (n + c, u + c * (c + 1) / 2));
        let positive = matrix.positive.iter().filter(|p| **p).count() as u64;
        let dim = matrix.dim() as u64;
        let expected = OperationCounts {
            sub_mul: updates as u64,
            mul: nnz as u64 + dim,
            div: dim,
            add: positive,
            sub: dim - positive,
            // −floor and −replacement.
            neg: 2 * (dim - positive),
            min: dim - positive,
            max: positive,
            compare: dim,
            select: dim,
            ..OperationCounts::default()
        };
        let c = Counted::constant;
        let by = Regularization { shift_up: c(0.0), shift_down: c(0.0), floor: c(0.0), replacement: c(0.0) };
        assert_eq!((symbolic.nnz_l, symbolic.multiply_subtracts), (nnz, updates));
        let tally = count(Latency::UNIT, || {
            factor(&matrix, by, Panels::Exact);
        });
        assert_eq!(tally.operations, expected, "size {}", matrix.dim());

        let at = factor(&matrix, by, Panels::Exact);
        let rhs = vec![Counted::zero(); matrix.dim()];
        let tally = count(Latency::UNIT, || {
            at.solve(&rhs);
        });
        let expected = OperationCounts { sub_mul: 2 * nnz as u64, mul: dim, ..OperationCounts::default() };
        assert_eq!(tally.operations, expected, "size {}", matrix.dim());
    }
}

#[test]
fn the_order_is_a_permutation_that_puts_children_before_parents() {
    for matrix in matrices() {
        let order = fill_reducing_order(&matrix.upper, Ordering::Amd).unwrap();
        let mut sorted: Vec<usize> = order.iter().map(|&old| old as usize).collect();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..matrix.dim()).collect::<Vec<_>>());
        let symbolic = Symbolic::new(&matrix.upper, Panels::Relaxed).unwrap();
        let covered: Vec<usize> =
            symbolic.supernodes.iter().flat_map(|node| node.first..node.first + node.width).collect();
        assert_eq!(covered, sorted, "every column belongs to one supernode");
        for node in &symbolic.supernodes {
            for column in node.first..node.first + node.width {
                let rows: Vec<usize> = symbolic.entries(node, column).map(|(row, _)| row).collect();
                assert!(rows.first().is_none_or(|&row| row > column), "children before parents");
                assert!(rows.windows(2).all(|rows| rows[0] < rows[1]));
            }
        }
    }
}

#[test]
fn pivots_of_the_wrong_sign_or_too_small_become_the_replacement() {
    let entries: Vec<(usize, usize)> = (0..6).map(|j| (j, j)).collect();
    let values = [0.0, -1e-7, 1e-7, 0.0, 1.9e-7, -1e-7];
    let signs = [true, true, true, false, false, false];
    let by = Regularization { shift_up: 1e-8, shift_down: 3e-8, floor: 1e-6, replacement: 2e-5 };
    let matrix = ordered(6, &entries, &values, &signs);
    let mut found: Vec<f64> = factor(&matrix, by, Panels::Exact).d().iter().copied().collect();
    found.sort_by(f64::total_cmp);
    let expected = [-2e-5, -2e-5, -2e-5, 2e-5, 2e-5, 2e-5];
    assert!(found.iter().zip(expected).all(|(f, e)| (f / e - 1.0).abs() < 1e-15), "{found:?}");
    // One of the wrong sign that is larger than that becomes five times as large.
    let matrix = ordered(2, &entries[..2], &[-5e-3, 3e-2], &[true, false]);
    let mut d: Vec<f64> = factor(&matrix, by, Panels::Exact).d().iter().copied().collect();
    d.sort_by(f64::total_cmp);
    assert!(d.iter().zip([-0.15, 2.5e-2]).all(|(d, e)| (d / e - 1.0).abs() < 1e-14), "{d:?}");
    // Just above the floor, a pivot is only shifted.
    let matrix = ordered(2, &entries[..2], &[1.5e-6, -1.5e-6], &[true, false]);
    let mut d: Vec<f64> = factor(&matrix, by, Panels::Exact).d().iter().copied().collect();
    d.sort_by(f64::total_cmp);
    assert!(d.iter().zip([-1.53e-6, 1.51e-6]).all(|(d, e)| (d / e - 1.0).abs() < 1e-14), "{d:?}");
}

#[test]
fn a_watched_factorization_has_the_same_bits_and_ends_where_it_is_stopped() {
    for (dim, density) in [(64, 0.04), (64, 0.15), (150, 0.03), (60, 1.0)] {
        let matrix = quasi_definite(dim, density, false, 5);
        let plain = factor(&matrix, REGULARIZATION, Panels::Relaxed);
        let mut asked = 0;
        let mut never = || {
            asked += 1;
            false
        };
        let watched = factor_watched(&matrix, REGULARIZATION, Panels::Relaxed, &mut Watched::new(&mut never));
        assert_eq!((&watched.l, &watched.pivot_inverse), (&plain.l, &plain.pivot_inverse));
        assert!(asked >= 3, "{dim}, {density}: {asked}");
        for last in [1, asked / 2, asked] {
            let mut count = 0;
            let mut stop = || {
                count += 1;
                count == last
            };
            let mut watch = Watched::new(&mut stop);
            let cut = factor_watched(&matrix, REGULARIZATION, Panels::Relaxed, &mut watch);
            assert!(watch.stopped);
            assert_eq!(count, last, "asked again after its end");
            assert!(last > asked / 2 || cut.pivot_inverse != plain.pivot_inverse);
        }
    }
}

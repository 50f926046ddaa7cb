//! PL module *matrix scaling*: Ruiz equilibration of the problem data, and its undoing.
//!
//! P̂ = γDPD, Â = EAD, Ĝ = FGD, ĉ = γDc, b̂ = Eb, ĥ = Fh with diagonal D, E, F and one factor per
//! second-order cone, so that every row and column of the KKT matrix has maximum entry about one; of P and c, too,
//! unless small costs beside large ones would vanish.

use super::reduce::{max_abs, min_abs_above};
use crate::kkt::structure::{Pattern, Structure};
use crate::real::Real;
use crate::symbolic::column_blocks::Uniformity;
use core::ops::Range;

/// The user's data, or their scaled copy: P (upper), A, G as values; q = (c, b, h).
pub struct Data<'a, T> {
    pub p: &'a mut [T],
    pub a: &'a mut [T],
    pub g: &'a mut [T],
    pub q: &'a mut [T],
}

/// Regularisation hides what is much smaller than this beside one.
const LEAST_COST: f64 = 1e-3;
const NO_COST: f64 = 1e-12;

/// What [`equilibrate`] makes beside the scaled data.
pub struct Scales<'a, T> {
    /// (D, E, F) …
    pub scale: &'a mut [T],
    /// … and its reciprocals, over the unknowns.
    pub inverse: &'a mut [T],
    /// γ, 1/γ, and the largest entries of scaled (b, h) and c.
    pub cost: &'a mut [T],
    /// DPD.
    pub equilibrated_p: &'a mut [T],
}

/// Scale `data` in place.
#[inline(always)]
pub fn equilibrate<T: Real>(
    structure: &Structure,
    passes: u32,
    data: &mut Data<T>,
    norms: &mut [T],
    scales: Scales<T>,
) {
    let Scales { scale, inverse, cost, equilibrated_p } = scales;
    let (n, p) = (structure.n, structure.p);
    scale.fill(T::one());
    for _ in 0..passes {
        norms.fill(T::zero());
        largest(&structure.cost, data.p, 0, norms);
        largest(&structure.equality, data.a, n, norms);
        largest(&structure.conic, data.g, n + p, norms);
        for soc in &structure.cones.soc {
            let rows = &mut norms[n + p + soc.start..n + p + soc.start + soc.dim];
            let top = max_abs(rows);
            rows.fill(top);
        }
        for (norm, scale) in norms.iter_mut().zip(scale.iter_mut()) {
            *norm = T::one() / nonzero(*norm).sqrt();
            *scale = *scale * *norm;
        }
        multiply(&structure.cost, norms, 0, data.p);
        multiply(&structure.equality, norms, n, data.a);
        multiply(&structure.conic, norms, n + p, data.g);
    }
    equilibrated_p.copy_from_slice(data.p);
    rescale(n, scale, data.p, data.q, cost);
    for (inverse, &scale) in inverse.iter_mut().zip(scale.iter()) {
        *inverse = T::one() / scale;
    }
}

/// Other (c, b, h) beside the same matrices: what [`equilibrate`] makes of them and of P, from its scales and DPD.
#[inline(always)]
pub fn rescale<T: Real>(n: usize, scale: &[T], p: &mut [T], q: &mut [T], cost: &mut [T]) {
    let gamma = scale_vectors(n, scale, p, q);
    let (c, sides) = q.split_at(n);
    cost[0] = gamma;
    cost[1] = T::one() / gamma;
    cost[2] = nonzero(max_abs(sides));
    cost[3] = nonzero(max_abs(c));
}

/// Scale (c, b, h), and the cost by γ, which is the result.
#[inline(always)]
fn scale_vectors<T: Real>(n: usize, scale: &[T], p: &mut [T], q: &mut [T]) -> T {
    for (q, &scale) in q.iter_mut().zip(scale) {
        *q = *q * scale;
    }
    let gamma = cost_factor(&q[..n], p);
    for entry in p.iter_mut().chain(&mut q[..n]) {
        *entry = *entry * gamma;
    }
    gamma
}

/// γ, which makes the largest entry of the scaled P and c one; but where large costs stand beside small ones, no cost
/// becomes smaller than `LEAST_COST` that is not smaller already. One below `NO_COST` of the largest is rounding.
#[inline(always)]
fn cost_factor<T: Real>(c: &[T], p: &[T]) -> T {
    let most = nonzero(max_abs(c).max(max_abs(p)));
    let least = min_abs_above(c, T::constant(NO_COST) * most, most);
    (T::one() / most).max(T::constant(LEAST_COST) / least.max(T::one()))
}

/// One where a norm vanishes (nothing to scale), the norm elsewhere.
#[inline(always)]
fn nonzero<T: Real>(norm: T) -> T {
    T::select(T::zero().lt(norm), norm, T::one())
}

/// Raise each row's and column's norm to the entries of one matrix whose rows begin at `row0`.
#[inline(always)]
fn largest<T: Real>(pattern: &Pattern, values: &[T], row0: usize, norms: &mut [T]) {
    for block in pattern.column_blocks() {
        let columns = block.columns.clone();
        let (rows, values) = pattern.entries(block, values);
        match block.uniformity {
            Uniformity::FixedLength(0) => {}
            Uniformity::FixedLength(1) => largest_of_fixed::<T, 1>(columns, rows, values, row0, norms),
            Uniformity::FixedLength(2) => largest_of_fixed::<T, 2>(columns, rows, values, row0, norms),
            Uniformity::FixedLength(3) => largest_of_fixed::<T, 3>(columns, rows, values, row0, norms),
            Uniformity::FixedLength(_) => largest_of_fixed::<T, 4>(columns, rows, values, row0, norms),
            Uniformity::Contiguous => {
                for (j, first, column) in pattern.contiguous_columns(block, values) {
                    for (norm, value) in norms[row0 + first..].iter_mut().zip(column) {
                        *norm = norm.max(value.abs());
                    }
                    norms[j] = norms[j].max(max_abs(column));
                }
            }
            Uniformity::General => {
                let mut entries = rows.iter().zip(values);
                for j in columns {
                    let mut top = T::zero();
                    for (&i, value) in entries.by_ref().take(pattern.column(j).len()) {
                        top = top.max(raise(&mut norms[row0 + i as usize], *value));
                    }
                    norms[j] = norms[j].max(top);
                }
            }
        }
    }
}

/// The value's magnitude, to which its row's norm is raised.
#[inline(always)]
fn raise<T: Real>(norm: &mut T, value: T) -> T {
    let size = value.abs();
    *norm = norm.max(size);
    size
}

#[inline(always)]
fn largest_of_fixed<T: Real, const L: usize>(
    columns: Range<usize>,
    rows: &[u32],
    values: &[T],
    row0: usize,
    norms: &mut [T],
) {
    for ((j, rows), values) in columns.zip(rows.as_chunks::<L>().0).zip(values.as_chunks::<L>().0) {
        let mut top = T::zero();
        for k in 0..L {
            top = top.max(raise(&mut norms[row0 + rows[k] as usize], values[k]));
        }
        norms[j] = norms[j].max(top);
    }
}

/// Multiply each entry by its row's and column's factor.
#[inline(always)]
fn multiply<T: Real>(pattern: &Pattern, factors: &[T], row0: usize, values: &mut [T]) {
    for block in pattern.column_blocks() {
        let columns = block.columns.clone();
        let (rows, values) = pattern.entries_mut(block, values);
        match block.uniformity {
            Uniformity::FixedLength(0) => {}
            Uniformity::FixedLength(1) => multiply_fixed::<T, 1>(columns, rows, factors, row0, values),
            Uniformity::FixedLength(2) => multiply_fixed::<T, 2>(columns, rows, factors, row0, values),
            Uniformity::FixedLength(3) => multiply_fixed::<T, 3>(columns, rows, factors, row0, values),
            Uniformity::FixedLength(_) => multiply_fixed::<T, 4>(columns, rows, factors, row0, values),
            Uniformity::Contiguous | Uniformity::General => {
                let (mut rows, mut values) = (rows, values);
                for j in columns {
                    let (here, column);
                    (here, rows) = rows.split_at(pattern.column(j).len());
                    (column, values) = values.split_at_mut(here.len());
                    if block.uniformity == Uniformity::Contiguous {
                        for (value, &row) in column.iter_mut().zip(&factors[row0 + here[0] as usize..]) {
                            *value = *value * (row * factors[j]);
                        }
                    } else {
                        for (value, &i) in column.iter_mut().zip(here) {
                            *value = *value * (factors[row0 + i as usize] * factors[j]);
                        }
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn multiply_fixed<T: Real, const L: usize>(
    columns: Range<usize>,
    rows: &[u32],
    factors: &[T],
    row0: usize,
    values: &mut [T],
) {
    for ((j, rows), values) in columns.zip(rows.as_chunks::<L>().0).zip(values.as_chunks_mut::<L>().0) {
        for k in 0..L {
            values[k] = values[k] * (factors[row0 + rows[k] as usize] * factors[j]);
        }
    }
}

/// The user's (x, y, z) and s from a scaled point: x = Dx̂/τ, (y, z) = (E, F)ŷ/(γτ), s = F⁻¹ŝ/τ.
#[inline(always)]
pub fn undo<T: Real>(
    structure: &Structure,
    (scale, scale_inverse, cost_scale): (&[T], &[T], &[T]),
    (point, slack, tau): (&[T], &[T], T),
    (out_point, out_slack): (&mut [T], &mut [T]),
) {
    let primal = T::one() / tau;
    let dual = cost_scale[1] * primal;
    for (i, (out, &entry)) in out_point.iter_mut().zip(point).enumerate() {
        let factor = if i < structure.n { primal } else { dual };
        *out = (entry * scale[i]) * factor;
    }
    let inverse = &scale_inverse[structure.n + structure.p..];
    for ((out, &entry), &inverse) in out_slack.iter_mut().zip(slack).zip(inverse) {
        *out = (entry * inverse) * primal;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::symbolic::supernodes::Panels;
    use crate::tests::reference::{seeded, SplitMix64};
    use crate::{Cones, Csc, Problem};
    use proptest::prelude::*;

    /// Data over `decades` decades to either side of one, in every block.
    fn problem(seed: u64, decades: f64) -> Problem {
        let (n, p, cones) = (6, 3, Cones { l: 4, q: vec![2, 5] });
        let mut numbers = SplitMix64(seed);
        let mut wide = |rows, columns, square: bool| {
            let dense: Vec<Vec<f64>> = (0..rows)
                .map(|i| (0..columns).map(|j| entry(&mut numbers, decades, square && i == j)).collect())
                .collect();
            Csc::from_dense(&dense.iter().map(Vec::as_slice).collect::<Vec<_>>(), columns)
        };
        let (cost, a, g) = (wide(n, n, true), wide(p, n, false), wide(cones.dim(), n, false));
        let cost = cost.upper_triangle("P").unwrap();
        let (c, b, h) = (numbers.list(n), numbers.list(p), numbers.list(cones.dim()));
        Problem::trusted(Some(cost), c, Some(a), b, Some(g), h, cones).unwrap()
    }

    /// About half of the entries are stored; those that `must` be always are.
    fn entry(numbers: &mut SplitMix64, decades: f64, must: bool) -> f64 {
        let size = 10f64.powf(decades * numbers.signed());
        let sign = numbers.signed().signum();
        if must || numbers.unit() < 0.5 {
            sign * size
        } else {
            0.0
        }
    }

    struct Scaled {
        structure: Structure,
        p: Vec<f64>,
        a: Vec<f64>,
        g: Vec<f64>,
        q: Vec<f64>,
        scale: Vec<f64>,
        inverse: Vec<f64>,
        cost: [f64; 4],
    }

    fn scaled(problem: &Problem, passes: u32) -> Scaled {
        let structure = Structure::new(problem, crate::Ordering::Amd, Panels::Exact).unwrap();
        let unknowns = structure.unknowns();
        let g = structure.reduced.g.values().to_vec();
        let h = structure.reduced.row_origin.iter().map(|&i| problem.h[i]);
        let q: Vec<f64> = problem.c.iter().chain(&problem.b).copied().chain(h).collect();
        let (p, a) = (problem.p.values().to_vec(), problem.a.values().to_vec());
        let (scale, inverse, mut norms) = (vec![0.0; unknowns], vec![0.0; unknowns], vec![0.0; unknowns]);
        let equilibrated_p = &mut vec![0.0; p.len()];
        let mut out = Scaled { structure, p, a, g, q, scale, inverse, cost: [0.0; 4] };
        let Scaled { structure, p, a, g, q, scale, inverse, cost } = &mut out;
        let scales = Scales { scale, inverse, cost, equilibrated_p };
        equilibrate(structure, passes, &mut Data { p, a, g, q }, &mut norms, scales);
        out
    }

    impl Scaled {
        /// Largest entry of each row and column of the scaled matrix before the cost factor γ; cones
        /// count as one row.
        fn maxima(&self) -> Vec<f64> {
            let (n, s) = (self.structure.n, &self.structure);
            let mut out = vec![0.0; s.unknowns()];
            let cost: Vec<f64> = self.p.iter().map(|v| v * self.cost[1]).collect();
            largest(&s.cost, &cost, 0, &mut out);
            largest(&s.equality, &self.a, n, &mut out);
            largest(&s.conic, &self.g, n + s.p, &mut out);
            for soc in &s.cones.soc {
                let rows = n + s.p + soc.start..n + s.p + soc.start + soc.dim;
                let top = out[rows.clone()].iter().copied().fold(0.0, f64::max);
                out[rows].fill(top);
            }
            out
        }
    }

    proptest! {
        #![proptest_config(seeded(64))]

        #[test]
        fn passes_drive_every_row_and_column_maximum_to_one(seed in any::<u64>()) {
            let off = |passes: u32| {
                let maxima = scaled(&problem(seed, 2.0), passes).maxima();
                maxima.into_iter().filter(|v| *v > 0.0).map(|v: f64| v.log10().abs()).fold(0.0, f64::max)
            };
            prop_assert!(off(40) <= 1e-9, "{}", off(40));
            // Four passes leave less than an eighth of four decades.
            prop_assert!(off(4) <= 0.5, "{}", off(4));
        }

        #[test]
        fn scaled_data_are_the_products_that_the_header_states(seed in any::<u64>()) {
            let problem = problem(seed, 3.0);
            let at = scaled(&problem, 4);
            let (n, p) = (at.structure.n, at.structure.p);
            let close = |found: f64, expected: f64| (found - expected).abs() <= 1e-13 * expected.abs();
            let matrices = [
                (&problem.p, &at.p, 0, at.cost[0]),
                (&problem.a, &at.a, n, 1.0),
                (&at.structure.reduced.g, &at.g, n + p, 1.0),
            ];
            for (matrix, found, row0, gamma) in matrices {
                for ((i, j, value), &found) in matrix.triplets().zip(found) {
                    prop_assert!(close(found, value * at.scale[row0 + i] * at.scale[j] * gamma));
                }
            }
            let given: Vec<f64> = problem.c.iter().chain(&problem.b).chain(&problem.h).copied().collect();
            for (k, (&found, value)) in at.q.iter().zip(given).enumerate() {
                let gamma = if k < n { at.cost[0] } else { 1.0 };
                prop_assert!(close(found, value * at.scale[k] * gamma));
            }
            for (scale, inverse) in at.scale.iter().zip(&at.inverse) {
                prop_assert!(close(scale * inverse, 1.0));
            }
            for soc in &at.structure.cones.soc {
                let factors = &at.scale[n + p..][soc.rows()];
                prop_assert!(factors.iter().all(|f| f == &factors[0]), "a cone has one factor");
            }
            let top = max_abs(&at.q[..n]).max(max_abs(&at.p));
            prop_assert!(close(top, 1.0), "the cost's largest entry is one");
        }

        #[test]
        fn undoing_gives_back_the_point_that_was_scaled(seed in any::<u64>(), tau in 1e-3..1e3f64) {
            let at = scaled(&problem(seed, 3.0), 4);
            let (n, p, m) = (at.structure.n, at.structure.p, at.structure.m);
            let mut numbers = SplitMix64(seed);
            let (point, slack) = (numbers.list(n + p + m), numbers.list(m));
            // x̂ = τD⁻¹x, (ŷ, ẑ) = γτ(E, F)⁻¹(y, z), ŝ = τFs.
            let scaled_point: Vec<f64> = (0..n + p + m)
                .map(|k| point[k] / at.scale[k] * tau * if k < n { 1.0 } else { at.cost[0] })
                .collect();
            let scaled_slack: Vec<f64> = (0..m).map(|k| slack[k] * at.scale[n + p + k] * tau).collect();
            let (mut out, mut out_slack) = (vec![0.0; n + p + m], vec![0.0; m]);
            let from = (&scaled_point[..], &scaled_slack[..], tau);
            let scales = (&at.scale[..], &at.inverse[..], &at.cost[..]);
            undo(&at.structure, scales, from, (&mut out, &mut out_slack));
            for (found, expected) in out.iter().chain(&out_slack).zip(point.iter().chain(&slack)) {
                prop_assert!((found - expected).abs() <= 1e-14 * expected.abs());
            }
        }
    }

    #[test]
    fn rows_and_columns_of_zeros_are_left_alone() {
        // Column 1, equality row 1, nonnegative row 1 and the whole second cone are zero.
        let a = Csc::from_dense(&[&[100.0, 0.0, 0.0], &[0.0, 0.0, 0.0]], 3);
        let g = Csc::from_dense(
            &[&[0.0, 0.0, 4.0], &[0.0; 3], &[0.01, 0.0, 0.0], &[0.0; 3], &[0.0; 3], &[0.0; 3]],
            3,
        );
        let cones = Cones { l: 2, q: vec![2, 2] };
        let problem = Problem::new(None, vec![0.0; 3], Some(a), vec![1.0; 2], Some(g), vec![1.0; 6], cones);
        let at = scaled(&problem.unwrap(), 4);
        // Unknowns: x₀ x₁ x₂ | y₀ y₁ | z₀ … z₅.
        for k in [1, 4, 6, 9, 10] {
            assert_eq!((at.scale[k], at.inverse[k]), (1.0, 1.0), "unknown {k}");
        }
        for k in [0, 2, 3, 5, 7, 8] {
            assert_ne!(at.scale[k], 1.0, "unknown {k}");
        }
        assert_eq!(at.cost[..2], [1.0, 1.0], "a cost of zeros is left alone, too");
    }

    #[test]
    fn the_cost_factor_keeps_small_costs_in_sight_of_large_ones() {
        let close = |c: &[f64], p: &[f64], expected: f64| {
            let found = cost_factor(c, p);
            assert!(
                (found - expected).abs() <= 1e-15 * expected,
                "{c:?}, {p:?}: {found:e}, not {expected:e}"
            );
        };
        close(&[4.0, -0.5], &[2.0], 0.25); // the largest entry
        close(&[0.0, 0.0], &[2.0], 0.5);
        close(&[0.0], &[], 1.0); // nothing to scale
        close(&[-1e2, 1e-5], &[], 1e-2);
        close(&[1e8, 2.0], &[], 0.5e-3); // 2 becomes LEAST_COST
        close(&[1e8, 0.2], &[], 1e-3); // what is below one may become smaller than that
        close(&[1e8, 1e6], &[], 1e-8); // no small cost
        close(&[1e8, 1e-5], &[], 1e-8); // 1e-13 of the largest: rounding
    }
}

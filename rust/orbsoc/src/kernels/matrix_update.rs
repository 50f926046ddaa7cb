//! PL module *matrix update*: write problem data and scaling blocks into the KKT values.

use super::cone_ops::{ETA_SQ, SCALARS};
use super::reduce::dot;
use crate::kkt::assembly::Kkt;
use crate::problem::cones::ConeLayout;
use crate::real::Real;

/// Write P, A and G (scaled) into a zeroed KKT matrix.
#[inline(always)]
pub fn load_data<T: Real>(kkt: &Kkt, p: &[T], a: &[T], g: &[T], values: &mut [T]) {
    values.fill(T::zero());
    for (map, from) in [(&kkt.from_p, p), (&kkt.from_a, a), (&kkt.from_g, g)] {
        for (&to, &value) in map.iter().zip(from) {
            values[to as usize] = value;
        }
    }
}

/// Write −W² = −I, for the starting point.
#[inline(always)]
pub fn identity_blocks<T: Real>(kkt: &Kkt, cones: &ConeLayout, values: &mut [T]) {
    for &to in &kkt.orthant {
        values[to as usize] = -T::one();
    }
    for (cone, block) in cones.soc.iter().zip(&kkt.soc) {
        for &to in block {
            values[to as usize] = T::zero();
        }
        if cone.expansion.is_none() {
            for j in 0..cone.dim {
                values[block[(j + 1) * (j + 2) / 2 - 1] as usize] = -T::one();
            }
        } else {
            for &to in &block[..2 * cone.dim] {
                values[to as usize] = -T::one();
            }
            for &to in &block[cone.dim..2 * cone.dim - 1] {
                values[to as usize] = T::zero();
            }
            values[block[3 * cone.dim] as usize] = T::one();
        }
    }
}

/// Write −W²: w² of each nonnegative row, η²(2wwᵀ − J) of each second-order cone.
#[inline(always)]
pub fn scaling_blocks<T: Real>(kkt: &Kkt, cones: &ConeLayout, w: &[T], cone: &[T], values: &mut [T]) {
    for (&to, &w) in kkt.orthant.iter().zip(w) {
        values[to as usize] = -(w * w);
    }
    let scalars = cone.as_chunks::<SCALARS>().0;
    cones.each_soc(
        #[inline(always)]
        |rows, k| {
            let (w, block, eta_sq) = (&w[rows], &kkt.soc[k][..], scalars[k][ETA_SQ]);
            if cones.soc[k].expansion.is_none() {
                dense_block(eta_sq, w, block, values);
            } else {
                expanded_block(eta_sq, w, block, values);
            }
        },
    );
}

/// −η²(2wwᵀ − J), upper triangle column by column.
#[inline(always)]
fn dense_block<T: Real>(eta_sq: T, w: &[T], block: &[u32], values: &mut [T]) {
    let minus_two_eta_sq = -(eta_sq + eta_sq);
    let mut next = 0;
    for j in 0..w.len() {
        let column = minus_two_eta_sq * w[j];
        for &wi in &w[..j] {
            values[block[next] as usize] = column * wi;
            next += 1;
        }
        let square = column * w[j];
        values[block[next] as usize] = if j == 0 { square + eta_sq } else { square - eta_sq };
        next += 1;
    }
}

/// −η²(D + uuᵀ − vvᵀ) as a bordered block whose two extra unknowns are scaled by u₀:
/// −η²[D, u₀v, u₀u; u₀vᵀ, u₀², 0; u₀uᵀ, 0, −u₀²]. So scaled, an error in an extra row moves the
/// cone's rows by no more than its own size, and u₀² = ω − d, u₀u = (u₀², 2w₀w₁) and
/// u₀v = (0, √(2 + 1/ω)·w₁) take one division and one root.
#[inline(always)]
fn expanded_block<T: Real>(eta_sq: T, w: &[T], block: &[u32], values: &mut [T]) {
    let dim = w.len();
    let (head, tail) = (w[0], &w[1..]);
    let minus = -eta_sq;
    let omega = dot(tail, tail).add_mul(head, head);
    let inverse = T::one() / omega;
    let d = T::constant(0.5) * inverse;
    let pivot = eta_sq * (omega - d);
    let by_v = minus * (T::constant(2.0) + inverse).sqrt();
    let by_u = minus * (head + head);
    let (diagonal, rest) = block.split_at(dim);
    let (v, u) = rest.split_at(dim);
    values[diagonal[0] as usize] = minus * d;
    for &to in &diagonal[1..] {
        values[to as usize] = minus;
    }
    for (&to, &wi) in v.iter().zip(tail) {
        values[to as usize] = by_v * wi;
    }
    values[v[dim - 1] as usize] = -pivot;
    values[u[0] as usize] = -pivot;
    for (&to, &wi) in u[1..].iter().zip(tail) {
        values[to as usize] = by_u * wi;
    }
    values[u[dim] as usize] = pivot;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::cone_ops;
    use crate::kkt::structure::Structure;
    use crate::symbolic::supernodes::Panels;
    use crate::tests::reference::{dense, pairs, scaling, seeded, Pair, SplitMix64};
    use crate::{Cones, Csc, Problem};
    use nalgebra::DMatrix;
    use proptest::prelude::*;

    const N: usize = 3;
    const P: usize = 2;

    fn problem(l: usize, q: Vec<usize>) -> Problem {
        let mut numbers = SplitMix64(11);
        let cones = Cones { l, q };
        let cost = numbers.sparse(N, N, 0.8).upper_triangle("P").unwrap();
        let (a, g) = (numbers.sparse(P, N, 0.5), numbers.sparse(cones.dim(), N, 0.4));
        let h = numbers.list(cones.dim());
        Problem::trusted(Some(cost), vec![1.0; N], Some(a), vec![0.0; P], Some(g), h, cones).unwrap()
    }

    fn structure(problem: &Problem) -> Structure {
        Structure::new(problem, crate::Ordering::Amd, Panels::Exact).unwrap()
    }

    /// The rows and columns of (x, y, z), once the expansion rows are eliminated.
    fn condensed(structure: &Structure, values: &[f64]) -> DMatrix<f64> {
        let (whole, kept) = (dense(&structure.kkt, values), structure.unknowns());
        let extra = structure.kkt.dim - kept;
        let border = whole.view((0, kept), (kept, extra));
        let corner = whole.view((kept, kept), (extra, extra)).into_owned();
        let correction = corner.try_inverse().expect("pivots are not zero");
        whole.view((0, 0), (kept, kept)) - border * correction * border.transpose()
    }

    fn dense_data(matrix: &Csc) -> DMatrix<f64> {
        let mut out = DMatrix::zeros(matrix.nrows(), matrix.ncols());
        matrix.triplets().for_each(|(i, j, v)| out[(i, j)] = v);
        out
    }

    #[test]
    fn data_and_starting_blocks_make_the_starting_matrix() {
        let problem = problem(2, vec![2, 4, 5, 9]);
        let structure = structure(&problem);
        let mut values = vec![f64::NAN; structure.kkt.nnz()];
        load_data(
            &structure.kkt,
            problem.p.values(),
            problem.a.values(),
            structure.reduced.g.values(),
            &mut values,
        );
        identity_blocks(&structure.kkt, &structure.cones, &mut values);
        let found = condensed(&structure, &values);

        let mut expected = DMatrix::<f64>::zeros(structure.unknowns(), structure.unknowns());
        let upper = dense_data(&problem.p);
        let cost = &upper + upper.transpose() - DMatrix::from_diagonal(&upper.diagonal());
        let (a, g) = (dense_data(&problem.a), dense_data(&structure.reduced.g));
        expected.view_mut((0, 0), (N, N)).copy_from(&cost);
        expected.view_mut((N, 0), (P, N)).copy_from(&a);
        expected.view_mut((0, N), (N, P)).copy_from(&a.transpose());
        expected.view_mut((N + P, 0), (structure.m, N)).copy_from(&g);
        expected.view_mut((0, N + P), (N, structure.m)).copy_from(&g.transpose());
        expected.view_mut((N + P, N + P), (structure.m, structure.m)).fill_with_identity();
        expected.view_mut((N + P, N + P), (structure.m, structure.m)).neg_mut();
        assert!((found - expected).amax() < 1e-15);
    }

    /// The scaling blocks of a pair, with nothing else in the matrix.
    fn blocks(pair: &Pair) -> (Structure, Vec<f64>) {
        let structure = structure(&problem(pair.cones.l, pair.cones.soc.iter().map(|soc| soc.dim).collect()));
        let at = scaling(&pair.cones, &pair.s, &pair.z);
        let mut values = vec![0.0; structure.kkt.nnz()];
        scaling_blocks(&structure.kkt, &structure.cones, &at.w, &at.cone, &mut values);
        (structure, values)
    }

    /// Pairs without cones of dimension one, which are rows to the engine.
    fn engine_pairs(nearest: f64) -> impl Strategy<Value = Pair> {
        pairs(nearest).prop_filter("a row", |pair| pair.cones.soc.iter().all(|soc| soc.dim > 1))
    }

    proptest! {
        #![proptest_config(seeded(128))]

        #[test]
        fn condensed_blocks_are_minus_w_applied_twice(pair in engine_pairs(-6.0)) {
            let (structure, values) = blocks(&pair);
            let (m, kept) = (structure.m, N + P);
            let found = condensed(&structure, &values).view((kept, kept), (m, m)).into_owned();
            let at = scaling(&pair.cones, &pair.s, &pair.z);
            let apply = |x: &[f64]| {
                let mut out = vec![0.0; m];
                cone_ops::scale(&pair.cones, &at.w, &at.cone, x, &mut out);
                out
            };
            for j in 0..m {
                let unit: Vec<f64> = (0..m).map(|i| f64::from(u8::from(i == j))).collect();
                let column = apply(&apply(&unit));
                // Rounding is relative to the block's largest entry, η²(2w₀² − 1) = ‖column of the head‖∞.
                let own = pair.cones.soc.iter().position(|soc| soc.rows().contains(&j));
                let size = own.map_or(column[j], |k| {
                    let head = at.w[pair.cones.soc[k].start];
                    at.cone[k * SCALARS + ETA_SQ] * (2.0 * head * head)
                });
                for i in 0..m {
                    prop_assert!((found[(i, j)] + column[i]).abs() <= 32.0 * f64::EPSILON * size, "({i}, {j})");
                }
            }
        }

        /// What makes the whole matrix quasi-definite: pivot signs −, …, −, − and then +.
        #[test]
        fn expanded_blocks_have_the_declared_signs(pair in engine_pairs(-6.0)) {
            let (structure, values) = blocks(&pair);
            let whole = dense(&structure.kkt, &values);
            for soc in &structure.cones.soc {
                let Some(extra) = soc.expansion else { continue };
                let row0 = N + P;
                let rows: Vec<usize> = soc.rows().map(|i| row0 + i).chain([row0 + extra]).collect();
                let negative = -whole.select_rows(&rows).select_columns(&rows);
                prop_assert!(negative.cholesky().is_some(), "not negative definite");
                let last = row0 + extra + 1;
                prop_assert!(whole[(last, last)] > 0.0);
                prop_assert!(structure.kkt.positive[structure.kkt.position[last] as usize]);
                prop_assert!(!structure.kkt.positive[structure.kkt.position[last - 1] as usize]);
            }
        }
    }

    #[test]
    fn writing_blocks_leaves_the_data_alone_and_nothing_of_the_last_blocks() {
        let problem = problem(2, vec![3, 6]);
        let structure = structure(&problem);
        let with_heads = |head: f64, tail: f64| {
            let is_head = |i| matches!(i, 0 | 1 | 2 | 5);
            (0..structure.m).map(|i| if is_head(i) { head } else { tail }).collect::<Vec<f64>>()
        };
        let write = |identity: bool, heads: &[f64]| {
            let mut values = vec![0.0; structure.kkt.nnz()];
            let g = structure.reduced.g.values();
            load_data(&structure.kkt, problem.p.values(), problem.a.values(), g, &mut values);
            if identity {
                identity_blocks(&structure.kkt, &structure.cones, &mut values);
            }
            for &head in heads {
                let at = scaling(&structure.cones, &with_heads(head, 0.1), &with_heads(1.0, 0.0));
                scaling_blocks(&structure.kkt, &structure.cones, &at.w, &at.cone, &mut values);
            }
            values.into_iter().map(f64::to_bits).collect::<Vec<_>>()
        };
        assert_eq!(write(true, &[7.0, 3.0]), write(false, &[3.0]));
    }
}

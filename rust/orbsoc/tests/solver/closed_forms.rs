//! What a stage asks of the datapath, in closed forms of the sizes.

use crate::known::{generated, Data};
use crate::operation_counts::{check, plus, ZERO};
use orbsoc::real::OperationCounts;
use orbsoc::{Cones, Engine, Settings, Stage};

fn times(count: u64, of: OperationCounts) -> OperationCounts {
    (0..count).fold(ZERO, |sum, _| plus(sum, of))
}

/// A dot product: below eight terms a chain, else eight chains and seven joining sums.
fn dot(len: u64) -> OperationCounts {
    match len {
        0 => ZERO,
        1..8 => OperationCounts { mul: 1, add_mul: len - 1, ..ZERO },
        _ => OperationCounts { mul: 8, add_mul: len - 8, add: 7, ..ZERO },
    }
}

/// A cone's scaling by its tail's length t: three dots of tails for norms and cosine, one for w₀.
fn nt_scaling_soc(t: u64) -> OperationCounts {
    let fixed = OperationCounts { mul: 36, add: 13, sub: 2, sqrt: 10, div: 3, max: 2, ..ZERO };
    let entries = OperationCounts { mul: 2 * t, add_mul: t, sub_mul: t, ..ZERO };
    [times(4, dot(t)), entries].into_iter().fold(fixed, plus)
}

fn step_length_soc(t: u64) -> OperationCounts {
    let fixed = OperationCounts { mul: 5, sub: 2, add: 1, sqrt: 1, max: 1, sub_mul: t, ..ZERO };
    plus(fixed, times(2, dot(t)))
}

/// Dense up to dimension four, bordered from five on.
fn scaling_block(q: u64) -> OperationCounts {
    if q <= 4 {
        return OperationCounts { add: 2, neg: 1, mul: 2 * q + q * (q - 1) / 2, sub: q - 1, ..ZERO };
    }
    let fixed = OperationCounts { neg: 3, add_mul: 1, div: 1, mul: 5, sub: 1, add: 2, sqrt: 1, ..ZERO };
    [dot(q - 1), OperationCounts { mul: 2 * (q - 1), ..ZERO }].into_iter().fold(fixed, plus)
}

#[test]
fn cone_stages_follow_their_closed_forms_by_size() {
    for (seed, (l, q)) in
        [(6, vec![3, 2, 7]), (0, vec![2]), (1, vec![4, 5]), (9, vec![]), (3, vec![8, 9, 10, 40])]
            .into_iter()
            .enumerate()
    {
        let m = l + q.iter().sum::<usize>();
        let g = (0..m).map(|i| vec![1.0 + i as f64, seed as f64 - 1.5]).collect();
        let data =
            Data { c: vec![1.0; 2], g, h: vec![1.0; m], cones: Cones { l, q: q.clone() }, ..Data::default() };
        let l = l as u64;
        let over = |of: fn(u64) -> OperationCounts, less: u64| {
            q.iter().map(|&q| of(q as u64 - less)).fold(ZERO, plus)
        };
        let rows = OperationCounts { mul: 3, div: 1, sqrt: 1, ..ZERO };
        let nt_scaling = plus(times(l, rows), over(nt_scaling_soc, 1));
        let blocks = plus(OperationCounts { mul: l, neg: l, ..ZERO }, over(scaling_block, 0));
        // From eight rows on, eight accumulators of the maximum are joined by seven more.
        let joins = if l < 8 { 0 } else { 7 };
        let rows = OperationCounts { mul: l, neg: l, max: l + joins, ..ZERO };
        let direction = [rows, over(step_length_soc, 1), OperationCounts { max: 1, ..ZERO }];
        let fixed = OperationCounts { neg: 2, div: 3, max: 2, ..ZERO };
        let step_length = plus(fixed, times(2, direction.into_iter().fold(ZERO, plus)));
        check(
            &data,
            &[
                (Stage::NtScaling, nt_scaling),
                (Stage::ScalingBlocks, blocks),
                (Stage::StepLength, step_length),
            ],
        );
    }
}

#[test]
fn factorisation_and_solve_follow_the_column_counts_of_l() {
    for (seed, zeros) in (0..5).enumerate() {
        let mut data = generated(seed as u64).0;
        // Sparser each time, so that the patterns differ.
        for (k, word) in data.g.iter_mut().flatten().enumerate() {
            if (k * 7) % 5 < zeros {
                *word = 0.0;
            }
        }
        let engine = Engine::<f64>::new(&data.problem(), &Settings::default()).unwrap();
        let (nnz_kkt, nnz_l) = engine.kkt_sizes();
        let (nnz_kkt, nnz_l) = (nnz_kkt as u64, nnz_l as u64);
        let multiply_subtracts = engine.factorization_multiply_subtracts() as u64;
        // x: 9 positive pivots; y: 3, z: 18 negative ones; the cone of size 7 adds one of each sign.
        let (positive, negative) = (9 + 1, 3 + 18 + 1);
        let dim = positive + negative;
        let factorize = OperationCounts {
            sub_mul: multiply_subtracts,
            mul: nnz_l + dim,
            div: dim,
            add: positive,
            sub: negative,
            neg: 2 * negative,
            min: negative,
            max: positive,
            compare: dim,
            select: dim,
            ..ZERO
        };
        // Norms over `dim` ≥ 8 words: eight accumulators joined by seven operations.
        let solve = OperationCounts {
            sub_mul: 2 * nnz_l + dim + 2 * (nnz_kkt - dim),
            mul: dim + 8 + 1,
            add_mul: dim - 8,
            add: 7 + 1,
            abs: 2 * dim,
            max: 2 * (dim - 1) + 1,
            ..ZERO
        };
        check(&data, &[(Stage::Factorize, factorize), (Stage::SolveKkt, solve)]);
    }
}

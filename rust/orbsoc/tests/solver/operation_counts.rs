//! What a stage asks of the datapath, counted by hand on three tiny problems.

use crate::known::{generated, Data};
use orbsoc::real::{Latency, OperationCounts, Tally};
use orbsoc::{operation_counts, Cones, Settings, Stage};

pub const ZERO: OperationCounts = OperationCounts {
    neg: 0,
    abs: 0,
    mul: 0,
    add: 0,
    sub: 0,
    add_mul: 0,
    sub_mul: 0,
    div: 0,
    sqrt: 0,
    min: 0,
    max: 0,
    compare: 0,
    and: 0,
    select: 0,
};

pub fn tally(data: &Data, stage: Stage) -> Tally {
    let counted = operation_counts(&data.problem(), &Settings::default(), Latency::UNIT).unwrap();
    counted.into_iter().find(|(counted, _)| *counted == stage).unwrap().1
}

pub fn check(data: &Data, expected: &[(Stage, OperationCounts)]) {
    for (stage, expected) in expected {
        assert_eq!(tally(data, *stage).operations, *expected, "{}", stage.name());
    }
}

/// min x, 1 ≤ x ≤ 3. The KKT matrix of (x; z₀, z₁) has five entries:
///
/// ```text
/// [ 0  −1   1 ]      Eliminating z₀ and z₁ first (one neighbour each), L has one entry below the
/// [−1 −w₀²    ]      diagonal in either column and none in that of x: no fill.
/// [ 1     −w₁²]
/// ```
#[test]
fn a_linear_programme_of_one_variable_and_two_rows() {
    let data = Data {
        c: vec![1.0],
        g: vec![vec![-1.0], vec![1.0]],
        h: vec![-1.0, 3.0],
        cones: Cones { l: 2, q: vec![] },
        ..Data::default()
    };
    check(
        &data,
        &[
            // Columns with 1, 1, 0 entries below: l·y from x's diagonal twice, l = y/d twice, 1/d three
            // times. Each negative pivot (z₀, z₁): −shift, −floor, −replacement, compare, −5 times
            // the pivot, minimum, select; the positive one (x): +shift, compare, product, maximum, select.
            (
                Stage::Factorize,
                OperationCounts {
                    sub_mul: 2,
                    mul: 2 + 3,
                    div: 3,
                    add: 1,
                    sub: 2,
                    neg: 4,
                    min: 2,
                    max: 1,
                    compare: 3,
                    select: 3,
                    ..ZERO
                },
            ),
            // L⁻¹ 2, L⁻ᵀ 2, K·x with 3 diagonal entries and 2 · 2 others: 11 multiply–subtracts. Products
            // with 1/d 3. Error norm: 3 magnitudes, 2 maxima, witness 0·e₀ + 0·e₁ + 0·e₂, and their sum.
            // Allowed: 3 magnitudes and 2 maxima of the right-hand side, times its share, or the goal.
            (
                Stage::SolveKkt,
                OperationCounts { sub_mul: 11, mul: 3 + 1 + 1, abs: 6, max: 5, add_mul: 2, add: 1, ..ZERO },
            ),
            // Per row: s·z, its reciprocal's root r, and λ = (s·z)·r, w = s·r.
            (Stage::NtScaling, OperationCounts { mul: 6, div: 2, sqrt: 2, ..ZERO }),
            // −w² per row.
            (Stage::ScalingBlocks, OperationCounts { mul: 2, neg: 2, ..ZERO }),
            // −dτ/τ and −dκ/κ, and the larger. For each of ds, dz: −δ·λ⁻¹ against zero in two rows, two
            // maxima; joined, once more a maximum. Then a floor, and one division for both.
            (
                Stage::StepLength,
                OperationCounts { neg: 2 + 4, div: 3, mul: 4, max: 1 + 2 * (2 + 1) + 1, ..ZERO },
            ),
        ],
    );
    // z: −shift 1, compare 2, select 3, 1/d 4, l 5. x: two subtractions into one word 6, 7, +shift 8,
    // compare 9, select 10, 1/d 11.
    assert_eq!(tally(&data, Stage::Factorize).critical_path, 11);
    // s·z, 1/·, root, ·r.
    assert_eq!(tally(&data, Stage::NtScaling).critical_path, 4);
    // A row's product 1 and sign 2, maxima with zero 3 and with the other row 4; joined with that of τ
    // and κ 5 and that of the other direction 6, floor 7, division 8.
    assert_eq!(tally(&data, Stage::StepLength).critical_path, 8);
}

/// min ½(x₀² + x₁²), x₀ + x₁ = 1, x₀ ≥ 0. The graph of the KKT matrix is the path z – x₀ – y – x₁: a
/// tree, whose leaves go first, so L has the path's three entries, one in each column but the last.
#[test]
fn a_quadratic_programme_whose_matrix_is_a_path() {
    let data = Data {
        p: vec![vec![1.0, 0.0], vec![0.0, 1.0]],
        c: vec![0.0, 0.0],
        a: vec![vec![1.0, 1.0]],
        b: vec![1.0],
        g: vec![vec![-1.0, 0.0]],
        h: vec![0.0],
        cones: Cones { l: 1, q: vec![] },
    };
    check(
        &data,
        &[
            // Columns 1, 1, 1, 0; positive pivots x₀, x₁, negative ones y, z.
            (
                Stage::Factorize,
                OperationCounts {
                    sub_mul: 3,
                    mul: 3 + 4,
                    div: 4,
                    add: 2,
                    sub: 2,
                    neg: 4,
                    min: 2,
                    max: 2,
                    compare: 4,
                    select: 4,
                    ..ZERO
                },
            ),
            // 3 + 3 + (4 + 2 · 3) multiply–subtracts, 4 products with 1/d; norms over 4 words.
            (
                Stage::SolveKkt,
                OperationCounts {
                    sub_mul: 16,
                    mul: 4 + 1 + 1,
                    abs: 8,
                    max: 3 + 3 + 1,
                    add_mul: 3,
                    add: 1,
                    ..ZERO
                },
            ),
            (Stage::NtScaling, OperationCounts { mul: 3, div: 1, sqrt: 1, ..ZERO }),
            (Stage::ScalingBlocks, OperationCounts { mul: 1, neg: 1, ..ZERO }),
            (
                Stage::StepLength,
                OperationCounts { neg: 2 + 2, div: 3, mul: 2, max: 1 + 2 * (1 + 1) + 1, ..ZERO },
            ),
        ],
    );
}

/// min x₀ + x₁ over (h − Gx) ∈ Q³ with a full G. x₀ and x₁ have three neighbours, each z four, so x₀ and
/// x₁ go first and make no fill: columns of L with 3, 3, 2, 1, 0 entries.
#[test]
fn one_second_order_cone_of_dimension_three() {
    let data = Data {
        c: vec![1.0, 1.0],
        g: vec![vec![1.0, 2.0], vec![3.0, 4.0], vec![5.0, 7.0]],
        h: vec![9.0, 1.0, 1.0],
        cones: Cones { l: 0, q: vec![3] },
        ..Data::default()
    };
    check(
        &data,
        &[
            // Σ c(c+1)/2 = 6 + 6 + 3 + 1, Σ c = 9.
            (
                Stage::Factorize,
                OperationCounts {
                    sub_mul: 16,
                    mul: 9 + 5,
                    div: 5,
                    add: 2,
                    sub: 3,
                    neg: 6,
                    min: 3,
                    max: 2,
                    compare: 5,
                    select: 5,
                    ..ZERO
                },
            ),
            // 9 + 9 + (5 + 2 · 9), norms over 5 words.
            (
                Stage::SolveKkt,
                OperationCounts {
                    sub_mul: 41,
                    mul: 5 + 1 + 1,
                    abs: 10,
                    max: 4 + 4 + 1,
                    add_mul: 4,
                    add: 1,
                    ..ZERO
                },
            ),
            (Stage::NtScaling, nt_scaling_by_hand()),
            // 2η² (add) with its sign; per column j: its factor, j products, the square, ±η².
            (Stage::ScalingBlocks, OperationCounts { add: 1 + 1, neg: 1, mul: 3 + 3 + 3, sub: 2, ..ZERO }),
            // Per direction: λ̄ᵀJδ (γδ₀ 1, dot 1 + 1, scaled 1, subtracted 1), its sum with δ₀ times two
            // factors, two components of ρ, ‖ρ‖ (1 + 1 and a root), minus the product, scaled, two maxima.
            (
                Stage::StepLength,
                OperationCounts {
                    neg: 2,
                    div: 3,
                    mul: 2 * (1 + 1 + 1 + 2 + 1 + 1),
                    add_mul: 2 * (1 + 1),
                    sub: 2 * (1 + 1),
                    add: 2,
                    sub_mul: 2 * 2,
                    sqrt: 2,
                    max: 1 + 2 * (1 + 1) + 1,
                    ..ZERO
                },
            ),
        ],
    );
}

/// The scaling of one cone of dimension three, line by line of the kernel.
fn nt_scaling_by_hand() -> OperationCounts {
    let lines = [
        // √res(s), √res(z): each ‖v₁‖ (1 product, 1 sum, 1 root), v₀ − ‖v₁‖, its floor (1 product, 1
        // maximum) and root, v₀ + ‖v₁‖ and root, and the product of both.
        OperationCounts { mul: 6, add_mul: 2, sqrt: 6, sub: 2, max: 2, add: 2, ..ZERO },
        // 1/√(res(s)res(z)), and s's and z's factors with it; normalised heads.
        OperationCounts { mul: 1 + 2 + 2, div: 1, ..ZERO },
        // s̄₁ᵀz̄₁ (dot 1 + 1, two factors); γ = √(½(1 + s̄₀z̄₀ + s̄₁ᵀz̄₁)).
        OperationCounts { mul: 1 + 2 + 2, add_mul: 1, add: 2, sqrt: 1, ..ZERO },
        // 2γ, s̄₀ + z̄₀ + 2γ, and the reciprocals of both by one division.
        OperationCounts { add: 1 + 2, mul: 1 + 2, div: 1, ..ZERO },
        // √ of 1/√(res(s)res(z)), and its inverse by products.
        OperationCounts { sqrt: 1, mul: 2, ..ZERO },
        // Factors of λ₁ from s and z (one sum, three products each), λ₀, and factors of w₁.
        OperationCounts { add: 2, mul: 6 + 1 + 2, ..ZERO },
        // λ₁ and w₁, two components each.
        OperationCounts { mul: 4, add_mul: 2, sub_mul: 2, ..ZERO },
        // w₀ = √(1 + w₁ᵀw₁).
        OperationCounts { mul: 1, add_mul: 1, add: 1, sqrt: 1, ..ZERO },
        // 1/(1 + w₀) and 1/(1 + γ) by one division.
        OperationCounts { add: 2, mul: 1 + 2, div: 1, ..ZERO },
        // η² and η, 1/η; 1/λ₀.
        OperationCounts { mul: 2, sqrt: 1, ..ZERO },
        OperationCounts { mul: 3, ..ZERO },
        OperationCounts { add: 1, mul: 1, ..ZERO },
    ];
    lines.into_iter().fold(ZERO, plus)
}

pub fn plus(a: OperationCounts, b: OperationCounts) -> OperationCounts {
    OperationCounts {
        neg: a.neg + b.neg,
        abs: a.abs + b.abs,
        mul: a.mul + b.mul,
        add: a.add + b.add,
        sub: a.sub + b.sub,
        add_mul: a.add_mul + b.add_mul,
        sub_mul: a.sub_mul + b.sub_mul,
        div: a.div + b.div,
        sqrt: a.sqrt + b.sqrt,
        min: a.min + b.min,
        max: a.max + b.max,
        compare: a.compare + b.compare,
        and: a.and + b.and,
        select: a.select + b.select,
    }
}

#[test]
fn transfers_ask_for_nothing_but_signs() {
    let data = generated(0).0;
    for stage in [Stage::LoadKkt, Stage::StoreStep, Stage::StoreConstantAndPredictor] {
        assert_eq!(tally(&data, stage).operations, ZERO, "{}", stage.name());
    }
    // The signs of −c and of the residuals of x and y; s less the residual of z.
    let predictor = OperationCounts { neg: 9 + 9 + 3, sub: 18, ..ZERO };
    assert_eq!(tally(&data, Stage::PredictorRhs).operations, predictor);
}

/// Each right-hand side has its error's size, four comparisons with limits and what follows from them (four maxima and a
/// minimum); the counts of refinements, and whether the next solve needs its residual, are the same for any number of them.
#[test]
fn a_check_asks_for_comparisons_by_right_hand_side() {
    let data = generated(0).0;
    for (stage, sides) in [(Stage::CheckSolve, 1), (Stage::CheckConstantAndPredictor, 2)] {
        let expected = OperationCounts {
            abs: sides,
            mul: 1,
            add: 2,
            min: 7 + sides,
            max: 3 + 4 * sides,
            compare: 13 + 8 * sides,
            select: 13 + 8 * sides,
            ..ZERO
        };
        assert_eq!(tally(&data, stage).operations, expected, "{}", stage.name());
    }
}

#[test]
fn a_path_is_never_longer_than_its_operations_take_one_after_the_other() {
    let latency =
        Latency { mul: 4, add: 6, sub: 6, add_mul: 10, sub_mul: 10, div: 20, sqrt: 18, ..Latency::UNIT };
    let counted = operation_counts(&generated(0).0.problem(), &Settings::default(), latency).unwrap();
    assert_eq!(counted.len(), Stage::ALL.len());
    for (stage, Tally { operations: n, critical_path }) in counted {
        let slow = 4 * n.mul + 6 * (n.add + n.sub) + 10 * (n.add_mul + n.sub_mul) + 20 * n.div + 18 * n.sqrt;
        let quick = n.neg + n.abs + n.min + n.max + n.compare + n.and + n.select;
        assert!(critical_path <= slow + quick, "{}", stage.name());
    }
}

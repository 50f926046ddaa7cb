//! PL module *matrix update*: write problem data and scaling blocks into the KKT values.

use super::cone_ops::{ETA_SQ, SCALARS};
use super::reduce::dot;
use crate::cones::ConeLayout;
use crate::kkt::Kkt;
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
    for ((soc, block), scalars) in cones.soc.iter().zip(&kkt.soc).zip(cone.chunks_exact(SCALARS)) {
        let w = &w[soc.rows()];
        if soc.expansion.is_none() {
            dense_block(scalars[ETA_SQ], w, block, values);
        } else {
            expanded_block(scalars[ETA_SQ], w, block, values);
        }
    }
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

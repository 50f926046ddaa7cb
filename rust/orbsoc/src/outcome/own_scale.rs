//! A problem's own scale: how large its rows, in whatever units, let each unknown be.
//!
//! Curtis and Reid's scaling (1972) of Mx = h, h as a column of fixed factor: those d and e that minimise
//! Σ (ln |eᵢMᵢⱼdⱼ|)² + Σ (ln |eᵢhᵢ|)² over the entries that are not zero. Rows and columns in other units have the inverse factors.
//! Rows of a cone share one factor, and so do unknowns of a cone.

/// Iterations of conjugate gradients, and the largest error in a logarithm, at which they end.
const MOST_ITERATIONS: usize = 300;
const ENOUGH: f64 = 1e-4;

/// Rows M x ~ h in groups.
pub(crate) struct Rows {
    /// Of each row, and of each unknown, the group.
    pub row_groups: Vec<usize>,
    pub column_groups: Vec<usize>,
    /// Row, unknown, entry.
    pub entries: Vec<(usize, usize, f64)>,
    pub sides: Vec<f64>,
}

/// The size of each unknown, and the largest |eᵢhᵢ|; one where h is zero.
pub(crate) struct OwnScale {
    pub sizes: Vec<f64>,
    pub largest_side: f64,
}

impl OwnScale {
    pub fn of(rows: &Rows) -> Self {
        let groups = |of: &[usize]| of.iter().max().map_or(0, |last| last + 1);
        let (first, all) = (groups(&rows.row_groups), groups(&rows.row_groups) + groups(&rows.column_groups));
        let logarithm = |value: f64| value.is_normal().then(|| value.abs().ln());
        let (mut pairs, mut diagonal, mut right) = (Vec::new(), vec![0.0; all], vec![0.0; all]);
        for &(i, j, value) in &rows.entries {
            if let Some(value) = logarithm(value) {
                let (row, column) = (rows.row_groups[i], first + rows.column_groups[j]);
                pairs.push((row, column));
                for at in [row, column] {
                    diagonal[at] += 1.0;
                    right[at] -= value;
                }
            }
        }
        for (&row, &side) in rows.row_groups.iter().zip(&rows.sides) {
            if let Some(side) = logarithm(side) {
                diagonal[row] += 1.0;
                right[row] -= side;
            }
        }
        let logarithms = solved(&pairs, &diagonal, right);
        let sides = rows.row_groups.iter().zip(&rows.sides);
        let largest = sides.map(|(&row, side)| side.abs() * logarithms[row].exp()).fold(0.0, f64::max);
        Self {
            sizes: rows.column_groups.iter().map(|&column| logarithms[first + column].exp()).collect(),
            largest_side: if largest > 0.0 { largest } else { 1.0 },
        }
    }
}

/// The normal equations, diagonal and ones at `pairs`, by conjugate gradients with the diagonal as preconditioner.
fn solved(pairs: &[(usize, usize)], diagonal: &[f64], mut residual: Vec<f64>) -> Vec<f64> {
    let size = diagonal.len();
    let weight: Vec<f64> = diagonal.iter().map(|d| 1.0 / f64::max(*d, 1.0)).collect();
    let (mut out, mut direction, mut energy) = (vec![0.0; size], vec![0.0; size], f64::INFINITY);
    for _ in 0..MOST_ITERATIONS {
        let steps: Vec<f64> = residual.iter().zip(&weight).map(|(r, w)| r * w).collect();
        if steps.iter().all(|step| step.abs() <= ENOUGH) {
            break;
        }
        let now: f64 = residual.iter().zip(&steps).map(|(r, s)| r * s).sum();
        for (direction, step) in direction.iter_mut().zip(&steps) {
            *direction = step + now / energy * *direction;
        }
        energy = now;
        let mut product: Vec<f64> = diagonal.iter().zip(&direction).map(|(d, v)| d * v).collect();
        for &(row, column) in pairs {
            product[row] += direction[column];
            product[column] += direction[row];
        }
        let length = now / product.iter().zip(&direction).map(|(p, d)| p * d).sum::<f64>();
        if !length.is_finite() {
            break;
        }
        for k in 0..size {
            out[k] += length * direction[k];
            residual[k] -= length * product[k];
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::reference::SplitMix64;

    /// Two rows of a cone, three of none.
    fn rows(numbers: &mut SplitMix64) -> Rows {
        let entries: Vec<(usize, usize, f64)> =
            (0..5).flat_map(|i| (0..4).map(move |j| (i, j))).map(|(i, j)| (i, j, numbers.signed())).collect();
        let sides = numbers.list(5);
        Rows { row_groups: vec![0, 1, 2, 3, 3], column_groups: vec![0, 1, 2, 2], entries, sides }
    }

    #[test]
    fn other_units_of_rows_change_nothing_and_those_of_unknowns_their_sizes() {
        let mut numbers = SplitMix64(5);
        for _ in 0..20 {
            let first = rows(&mut numbers);
            let unit = |of: usize| 10f64.powi(of as i32 * 5 - 8);
            let entry = |&(i, j, value): &(usize, usize, f64)| {
                (i, j, value * unit(first.row_groups[i]) * unit(first.column_groups[j]))
            };
            let other = Rows {
                row_groups: first.row_groups.clone(),
                column_groups: first.column_groups.clone(),
                entries: first.entries.iter().map(entry).collect(),
                sides: first.sides.iter().zip(&first.row_groups).map(|(h, &i)| h * unit(i)).collect(),
            };
            let (one, two) = (OwnScale::of(&first), OwnScale::of(&other));
            assert!((one.largest_side / two.largest_side - 1.0).abs() < 1e-2);
            for (j, (one, two)) in one.sizes.iter().zip(&two.sizes).enumerate() {
                assert!((one / two / unit(first.column_groups[j]) - 1.0).abs() < 1e-2);
            }
        }
    }

    #[test]
    fn sizes_follow_rows_that_let_their_unknowns_grow() {
        // x₀ = 1, xₖ₊₁ = 10 xₖ.
        let growth = (1..6).flat_map(|k| [(k, k - 1, 10.0), (k, k, -1.0)]);
        let entries = core::iter::once((0, 0, 1.0)).chain(growth).collect();
        let sides = vec![1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let groups: Vec<usize> = (0..6).collect();
        let scale = OwnScale::of(&Rows { row_groups: groups.clone(), column_groups: groups, entries, sides });
        for (k, size) in scale.sizes.iter().enumerate() {
            assert!((size / 10f64.powi(k as i32) - 1.0).abs() < 1e-2, "{size}");
        }
    }
}

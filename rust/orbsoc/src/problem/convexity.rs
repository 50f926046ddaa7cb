//! Whether a cost is convex: is its matrix positive semidefinite? Answered with what shows that it is not.
//!
//! The coupled part is scaled to a unit diagonal, which keeps the signs of its eigenvalues, shifted by [`SHIFT`] and
//! factored; without a Cholesky factor it has negative curvature (Sylvester's law of inertia).

use crate::error::Error;
use crate::problem::csc::Csc;
use crate::symbolic::ordering::{fill_reducing_order, Ordering};
use crate::symbolic::upper::Upper;
use crate::symbolic::{etree::has_cholesky_factor, indices::index};
use nalgebra::{Cholesky, DMatrix};

/// Negative curvature below this fraction of the diagonal passes: rounding in P = MᵀM can produce it.
const SHIFT: f64 = 1e-8;
/// Up to this order a dense factor is quicker than the search for a sparse one.
const DENSE: usize = 200;
/// Up to this order the reason names the smallest eigenvalue.
const NAMED: usize = 500;

/// Check the matrix of a cost, whole or its upper triangle, as [`crate::Problem::new`] does. What lies below the
/// diagonal is ignored.
///
/// # Errors
/// [`Error::NotConvex`] if it is not positive semidefinite, [`Error::Dimension`] if it is not square.
pub fn check_convex(matrix: &Csc) -> Result<(), Error> {
    check_upper(&matrix.upper_triangle("P")?)
}

/// As [`check_convex`], of a square upper triangle.
pub(crate) fn check_upper(upper: &Csc) -> Result<(), Error> {
    match nonconvexity(upper)? {
        Some(detail) => Err(Error::NotConvex { detail }),
        None => Ok(()),
    }
}

/// What shows that the matrix is not positive semidefinite, if it is not.
fn nonconvexity(upper: &Csc) -> Result<Option<String>, Error> {
    let mut diagonal = vec![0.0; upper.ncols()];
    let mut coupled = false;
    for (i, j, value) in upper.triplets() {
        if i == j {
            diagonal[i] = value;
        } else {
            coupled |= value != 0.0;
        }
    }
    if let Some(k) = diagonal.iter().position(|&d| d < 0.0) {
        return Ok(Some(format!("P[{k}, {k}] is {:?}", diagonal[k])));
    }
    if !coupled {
        return Ok(None);
    }
    let roots: Vec<f64> = diagonal.iter().map(|d| d.sqrt()).collect();
    let mut place = vec![None; upper.ncols()];
    let mut order = 0;
    let mut correlations = Vec::with_capacity(upper.nnz());
    for (i, j, value) in upper.triplets().filter(|&(i, j, value)| i != j && value != 0.0) {
        // |P_ij| ≤ √(P_ii P_jj) in every semidefinite matrix; this also catches P_ii = 0 with P_ij ≠ 0.
        let bound = roots[i] * roots[j];
        if value.abs() > bound * (1.0 + SHIFT) {
            let (first, second) = (diagonal[i], diagonal[j]);
            return Ok(Some(format!(
                "P[{i}, {j}] is {value:?}, P[{i}, {i}] is {first:?} and P[{j}, {j}] is {second:?}"
            )));
        }
        let [i, j] = [i, j].map(|k| {
            *place[k].get_or_insert_with(|| {
                order += 1;
                order - 1
            })
        });
        correlations.push((i.min(j), i.max(j), value / bound));
    }
    if has_factor(order, &correlations)? {
        return Ok(None);
    }
    Ok(Some(if order > NAMED {
        "it has a direction of negative curvature".into()
    } else {
        let smallest = smallest_eigenvalue(order, &correlations);
        format!("scaled to a unit diagonal, its smallest eigenvalue is {smallest:.3e}")
    }))
}

/// Whether the matrix of unit diagonal with these entries above it, shifted, has a Cholesky factor.
fn has_factor(order: usize, correlations: &[(usize, usize, f64)]) -> Result<bool, Error> {
    if order <= DENSE {
        let mut matrix = DMatrix::from_diagonal_element(order, order, 1.0 + SHIFT);
        for &(i, j, value) in correlations {
            matrix[(j, i)] = value;
        }
        return Ok(Cholesky::new(matrix).is_some());
    }
    let diagonal = (0..order).map(|k| (k, k, 1.0 + SHIFT));
    let entries: Vec<_> = diagonal.chain(correlations.iter().copied()).collect();
    let positions: Vec<_> = entries.iter().map(|&(i, j, _)| (index(i), index(j))).collect();
    let (given, first) = Upper::from_positions(order, &positions);
    let (upper, second) = given.permuted(&fill_reducing_order(&given, Ordering::Amd)?);
    let mut values = vec![0.0; entries.len()];
    for (&at, (.., value)) in first.iter().zip(entries) {
        values[second[at as usize] as usize] = value;
    }
    has_cholesky_factor(&upper, &values)
}

/// Of the matrix of unit diagonal with these entries above it.
fn smallest_eigenvalue(order: usize, correlations: &[(usize, usize, f64)]) -> f64 {
    let mut matrix = DMatrix::identity(order, order);
    for &(i, j, value) in correlations {
        (matrix[(i, j)], matrix[(j, i)]) = (value, value);
    }
    matrix.symmetric_eigenvalues().min()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::reference::SplitMix64;

    fn told(rows: &[&[f64]]) -> Option<String> {
        nonconvexity(&Csc::from_dense(rows, rows.len()).upper_triangle("P").unwrap()).unwrap()
    }

    /// MᵀM with M of `rank` rows, each entry of M there with probability `density`, shifted by `shift` of its diagonal.
    fn gram(order: usize, rank: usize, density: f64, shift: f64, numbers: &mut SplitMix64) -> Csc {
        let mut m = DMatrix::zeros(rank, order);
        numbers.sparse(rank, order, density).triplets().for_each(|(i, j, value)| m[(i, j)] = value);
        let mut p = m.transpose() * &m;
        (0..order).for_each(|k| p[(k, k)] *= 1.0 + shift);
        let rows: Vec<Vec<f64>> = p.row_iter().map(|row| row.iter().copied().collect()).collect();
        let whole = Csc::from_dense(&rows.iter().map(Vec::as_slice).collect::<Vec<_>>(), order);
        whole.upper_triangle("P").unwrap()
    }

    #[test]
    fn what_shows_it_is_named() {
        let cases: [(&[&[f64]], &str); 5] = [
            (&[&[1.0, 0.0], &[0.0, -2.0]], "P[1, 1] is -2.0"),
            (&[&[1.0, 2.0], &[2.0, 1.0]], "P[0, 1] is 2.0, P[0, 0] is 1.0 and P[1, 1] is 1.0"),
            (&[&[1.0, 0.5], &[0.5, 0.0]], "P[0, 1] is 0.5, P[0, 0] is 1.0 and P[1, 1] is 0.0"),
            (&[&[1e-300, 0.0], &[0.0, -1e-300]], "P[1, 1] is -1e-300"),
            (
                &[&[4.0, -3.0, -3.0], &[-3.0, 4.0, -3.0], &[-3.0, -3.0, 4.0]],
                "scaled to a unit diagonal, its smallest eigenvalue is -5.000e-1",
            ),
        ];
        for (rows, expected) in cases {
            assert_eq!(told(rows).as_deref(), Some(expected));
        }
    }

    #[test]
    fn extreme_numbers_neither_overflow_nor_vanish() {
        assert_eq!(told(&[&[1e300, 1e300], &[1e300, 1e300]]), None);
        assert_eq!(told(&[&[1e-320, 1e-320], &[1e-320, 1e-320]]), None);
        assert_eq!(told(&[&[1e300, 1.0], &[1.0, 1e-300]]), None);
        assert!(told(&[&[1e300, 1.1], &[1.1, 1e-300]]).is_some());
    }

    #[test]
    fn gram_matrices_pass_and_lose_their_place_with_a_little_less_on_the_diagonal() {
        let mut numbers = SplitMix64(29);
        for (order, density) in [(2, 1.0), (20, 1.0), (20, 0.2), (DENSE + 50, 0.02), (NAMED + 50, 0.01)] {
            let (deficient, full) = (order / 2 + 1, order + order / 2);
            assert_eq!(nonconvexity(&gram(order, deficient, density, 0.0, &mut numbers)), Ok(None));
            assert_eq!(nonconvexity(&gram(order, full, density, 0.0, &mut numbers)), Ok(None));
            if deficient < order {
                let short = gram(order, deficient, density, -1e-6, &mut numbers);
                assert!(nonconvexity(&short).unwrap().is_some(), "a flat direction bends down now");
            }
        }
    }
}

//! How far the points lie that a certificate of infeasibility does not exclude, on the user's data.

use crate::outcome::norms::{symmetric_product, Sums};
use crate::outcome::point::{present, project, Point};
use crate::outcome::roundoff::{deterministic_bound, roundoff_in_product};
use crate::problem::{Csc, Problem};
use nalgebra::{DVector, DVectorView};

/// What a certificate proves: no point of the other side is smaller.
#[derive(Clone, Copy, Default)]
pub(super) struct Radius {
    /// In the user's units.
    pub plain: f64,
    /// The same over the data's scale.
    pub relative: f64,
    /// Over its own scale: an unknown is as large as makes its terms in the sum of all rows, by the certificate, those of
    /// the right-hand side. Other units of rows, unknowns and cost have no part in it.
    pub own: f64,
}

/// Certified radius of primal infeasibility: whatever the sums below may have lost in rounding counts against it. z is
/// projected onto K, and the certificate scaled to size one: its own size means nothing and may overflow.
pub(super) fn primal_radius(problem: &Problem, at: &mut Point) -> Radius {
    let sums = Sums::new();
    at.z = present(problem, at.z.clone());
    project(problem, &mut at.z);
    let size = sums.norm(at.y.as_slice()).max(sums.norm(at.z.as_slice()));
    at.y.unscale_mut(size);
    at.z.unscale_mut(size);
    let h = present(problem, DVector::from_column_slice(&problem.h));
    let support = DVectorView::from(&problem.b[..]).dot(&at.y) + h.dot(&at.z);
    let nowhere = DVector::zeros(problem.n());
    let (_, aty) = sums.products(&problem.a, &nowhere, &at.y);
    let (_, gtz) = sums.products(&problem.g, &nowhere, &at.z);
    let (y, z) = (at.y.as_slice(), at.z.as_slice());
    let terms = problem.b.iter().zip(&at.y).chain(h.iter().zip(&at.z)).map(|(b, y)| (b * y).abs());
    let terms: f64 = terms.sum();
    let roundoff = deterministic_bound(problem.p() + problem.m()) * terms;
    let scale = data_scale(problem, largest_side(problem));
    let residual = aty + gtz;
    let (mut share, mut lost) = (0.0, 0.0);
    for (j, (in_a, in_g)) in problem.a.columns().zip(problem.g.columns()).enumerate() {
        let [in_a, in_g] = [(in_a, y), (in_g, z)].map(|((rows, values), weights)| {
            rows.iter().zip(values).fold(0.0, |sum, (&i, value)| sum + (value * weights[i]).abs())
        });
        let rounding = deterministic_bound(problem.p()) * in_a + deterministic_bound(problem.m()) * in_g;
        share += share_of(residual[j].abs() + rounding, in_a + in_g);
        lost += rounding;
    }
    radius(support + roundoff, residual.lp_norm(1) + lost, scale, (terms, share))
}

/// How many times farther than where the largest entry makes its product the largest right-hand side an unknown may lie.
const SCALE_RANGE: f64 = 100.0;

/// The data's scale that a radius is compared with: at least 1, and no less than how near points can be where entries are small.
/// Entries that are no normal numbers count as zero, as in the iteration.
fn data_scale(problem: &Problem, side: f64) -> f64 {
    let entry = largest(problem.a.values().iter().chain(problem.g.values()));
    let nearest = if entry >= f64::MIN_POSITIVE { side / entry / SCALE_RANGE } else { 0.0 };
    side.max(1.0).max(nearest)
}

fn largest<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().fold(0.0, |top: f64, value| top.max(value.abs()))
}

/// The largest right-hand side of rows that constrain.
fn largest_side(problem: &Problem) -> f64 {
    largest(problem.b.iter().chain(problem.h.iter().filter(|side| side.is_finite())))
}

/// An error over the magnitude of the terms that it is left of; zero where there are none.
fn share_of(error: f64, terms: f64) -> f64 {
    if terms > 0.0 {
        error / terms
    } else {
        0.0
    }
}

/// Certified radius of dual infeasibility; x is scaled to size one.
pub(super) fn dual_radius(problem: &Problem, at: &mut Point) -> Radius {
    let sums = Sums::new();
    at.x.unscale_mut(sums.norm(at.x.as_slice()));
    let cost = DVectorView::from(&problem.c[..]).dot(&at.x);
    let (ax, _) = sums.products(&problem.a, &at.x, &DVector::zeros(problem.p()));
    let (gx, _) = sums.products(&problem.g, &at.x, &DVector::zeros(problem.m()));
    let recession = -present(problem, gx);
    let mut inside = recession.clone();
    project(problem, &mut inside);
    let (px, outside) = (symmetric_product(&problem.p, &at.x), recession - inside);
    let distance = px.lp_norm(1) + ax.lp_norm(1) + outside.lp_norm(1);
    let (n, x) = (problem.n(), at.x.as_slice());
    let by = |value: f64, _: usize, j: usize| (value * x[j]).abs();
    let either = |value: f64, i: usize, j: usize| 2.0 * by(value, 0, i).max(by(value, 0, j));
    let present =
        |value: f64, i: usize, j: usize| if problem.h[i].is_finite() { by(value, i, j) } else { 0.0 };
    let lost = roundoff_in_product(&problem.p, n, either)
        + roundoff_in_product(&problem.a, n, by)
        + roundoff_in_product(&problem.g, n, present);
    let terms = problem.c.iter().zip(x).map(|(c, x)| (c * x).abs()).sum::<f64>();
    let roundoff = deterministic_bound(n) * terms;
    // With a quadratic cost a dual point has an x in it.
    let of_x = if problem.p.values().is_empty() { 0.0 } else { largest_side(problem) };
    let scale = data_scale(problem, largest(&problem.c).max(of_x));
    let mut share = 0.0;
    for (errors, sizes, losses) in [
        (&px, row_sizes(&problem.p, x, true), 2.0),
        (&ax, row_sizes(&problem.a, x, false), 1.0),
        (&outside, by_cone(problem, row_sizes(&problem.g, x, false)), 1.0),
    ] {
        for (error, size) in errors.iter().zip(sizes) {
            share += share_of(error.abs() + losses * deterministic_bound(n) * size, size);
        }
    }
    radius(cost + roundoff, distance + lost, scale, (terms, share))
}

/// Σⱼ |Mᵢⱼxⱼ| of each row, of an upper triangle those of the whole matrix.
fn row_sizes(matrix: &Csc, x: &[f64], symmetric: bool) -> Vec<f64> {
    let mut sizes = vec![0.0; matrix.nrows()];
    for (i, j, value) in matrix.triplets() {
        sizes[i] += (value * x[j]).abs();
        if symmetric && i != j {
            sizes[j] += (value * x[i]).abs();
        }
    }
    sizes
}

/// Absent rows have no size, and rows of a cone that of all.
fn by_cone(problem: &Problem, sizes: Vec<f64>) -> Vec<f64> {
    let mut sizes = present(problem, DVector::from_vec(sizes)).as_slice().to_vec();
    let mut rest = &mut sizes[problem.cones.l..];
    for &dim in &problem.cones.q {
        let (cone, later) = rest.split_at_mut(dim);
        rest = later;
        let all = cone.iter().fold(0.0, |sum, size| sum + size);
        cone.fill(all);
    }
    sizes
}

/// Of a certificate of this value, of which the size of what it misses, the data's scale, the magnitude of the value's terms,
/// and the sum of all shares.
fn radius(value: f64, size: f64, scale: f64, (terms, share): (f64, f64)) -> Radius {
    if value < 0.0 && value.is_finite() && size.is_finite() {
        let over = |value: f64, size: f64| if size > 0.0 { value / size } else { f64::INFINITY };
        let plain = over(-value, size);
        Radius { plain, relative: plain / scale, own: over(-value / terms, share) }
    } else {
        Radius::default()
    }
}

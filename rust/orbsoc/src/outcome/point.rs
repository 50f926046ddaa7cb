//! A point on the user's data, and what its rows are in the cone.

use crate::outcome::norms::larger;
use crate::problem::Problem;
use nalgebra::DVector;

/// A point in the user's scaling and row order.
pub(super) struct Point {
    pub x: DVector<f64>,
    pub y: DVector<f64>,
    pub z: DVector<f64>,
    pub s: DVector<f64>,
}

/// What the projection of (head, tail) onto its cone makes of the head, and by what it multiplies the tail;
/// nothing where the point is inside.
fn onto_cone(head: f64, tail: &[f64]) -> Option<(f64, f64)> {
    let size = tail.iter().map(|v| v * v).sum::<f64>().sqrt();
    if size <= head {
        None
    } else if size <= -head {
        Some((0.0, 0.0))
    } else {
        let middle = f64::midpoint(head, size);
        Some((middle, middle / size))
    }
}

/// Exact projection of `v` onto K.
pub(super) fn project(problem: &Problem, v: &mut DVector<f64>) {
    let (orthant, mut rest) = v.as_mut_slice().split_at_mut(problem.cones.l);
    for v in orthant {
        *v = v.max(0.0);
    }
    for &dim in &problem.cones.q {
        let (cone, later) = rest.split_at_mut(dim);
        rest = later;
        if let Some((head, factor)) = onto_cone(cone[0], &cone[1..]) {
            cone[0] = head;
            for v in &mut cone[1..] {
                *v *= factor;
            }
        }
    }
}

/// The largest entry of what the projection of `v` onto K would move.
#[inline(never)]
pub(super) fn outside(problem: &Problem, v: &DVector<f64>) -> f64 {
    let (orthant, mut rest) = v.as_slice().split_at(problem.cones.l);
    let mut farthest = [0.0; 8];
    for chunk in orthant.chunks(8) {
        for (farthest, v) in farthest.iter_mut().zip(chunk) {
            *farthest = larger(*farthest, -v);
        }
    }
    let mut moved = farthest.into_iter().fold(0.0, larger);
    for &dim in &problem.cones.q {
        let (cone, later) = rest.split_at(dim);
        rest = later;
        if let Some((head, factor)) = onto_cone(cone[0], &cone[1..]) {
            let tail = cone[1..].iter().fold(0.0, |top, v| larger(top, v.abs()));
            moved = larger(larger(moved, (head - cone[0]).abs()), (1.0 - factor) * tail);
        }
    }
    moved
}

/// Absent rows take part in nothing: zero where h is +∞.
#[inline(never)]
pub(super) fn present(problem: &Problem, mut v: DVector<f64>) -> DVector<f64> {
    // A selection: a store on a condition would be made one by one.
    for (v, h) in v.as_mut_slice().iter_mut().zip(&problem.h) {
        *v = if h.is_finite() { *v } else { 0.0 };
    }
    v
}

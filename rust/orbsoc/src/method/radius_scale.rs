//! What a radius of infeasibility is compared with where the iteration stops.
//!
//! The data's scale is max(1, ‖b‖∞, ‖h‖∞), for dual infeasibility max(1, ‖c‖∞). In units far from one it says little: in rows
//! of 1e8 no radius is 1e8 times as large. It is therefore kept within `SCALE_RANGE` times of what a row's right-hand side leaves
//! an unknown, the largest side over the smallest and over the largest entry. Near one it stays as it is.

use crate::kernels::layout::norm;
use crate::problem::problem::Reduced;
use crate::problem::Problem;

/// How many times farther than a row lets an unknown be the data's scale may reach, or how many times less far.
const SCALE_RANGE: f64 = 100.0;
/// The smallest share of the data's scale that is left: a radius that ends an attempt is then large enough for a claim.
const SCALE_SHARE: f64 = 1e-4;

/// The smallest and the largest magnitude of a matrix' entries; those that are no normal number count as zero.
#[derive(Clone, Copy)]
struct Entries {
    least: f64,
    most: f64,
}

impl Entries {
    fn of<'a>(values: impl IntoIterator<Item = &'a f64>) -> Self {
        let none = Self { least: f64::INFINITY, most: 0.0 };
        let sizes = values.into_iter().map(|value| value.abs());
        sizes.filter(|&size| size >= f64::MIN_POSITIVE).fold(none, |range, size| Self {
            least: if size < range.least { size } else { range.least },
            most: if size > range.most { size } else { range.most },
        })
    }

    /// Of two matrices.
    fn and(self, other: Self) -> Self {
        Self { least: self.least.min(other.least), most: self.most.max(other.most) }
    }
}

/// The scale where `side` is the largest right-hand side beside these entries.
fn radius_scale(side: f64, entries: Entries) -> f64 {
    let scale = side.max(1.0);
    if side == 0.0 || entries.most == 0.0 {
        return scale;
    }
    let nearest = side / entries.most / SCALE_RANGE;
    let farthest = (side / entries.least * SCALE_RANGE).max(SCALE_SHARE * scale);
    scale.max(nearest).min(farthest)
}

/// The entries of the norms, of the rows that constrain.
pub(crate) fn norms(reduced: &Reduced, problem: &Problem) -> [f64; norm::WORDS] {
    let h = reduced.row_origin.iter().map(|&i| &problem.h[i]);
    let g = reduced.g_origin.iter().map(|&k| &problem.g.values()[k]);
    let (b, h, c) = (largest(&problem.b), largest(h), largest(&problem.c));
    let rows = Entries::of(problem.a.values().iter().chain(g));
    let columns = rows.and(Entries::of(problem.p.values()));
    let mut out = [0.0; norm::WORDS];
    (out[norm::B], out[norm::H], out[norm::C]) = (b, h, c);
    out[norm::PRIMAL_SCALE] = radius_scale(b.max(h), rows);
    out[norm::DUAL_SCALE] = radius_scale(c, columns);
    out
}

fn largest<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().fold(0.0, |top, value| value.abs().max(top))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_units_far_from_one_change_the_datas_scale() {
        let scale = |side: f64, entries: &[f64]| radius_scale(side, Entries::of(entries));
        assert_eq!(scale(0.5, &[-1.0, 0.0, 3.0]), 1.0);
        assert_eq!(scale(7.0, &[0.1, 100.0]), 7.0);
        assert_eq!(scale(0.0, &[1e8]), 1.0);
        assert_eq!(scale(2.0, &[0.0, 1e-310]), 2.0);
        assert_eq!(scale(1e8, &[1.0, 1e8]), 1e8); // rows of 1 beside rows of 1e8: as large as those of 1 let x be
        assert_eq!(scale(1e4, &[1e4, 2e4]), SCALE_RANGE); // rows of 1e4
        assert_eq!(scale(1e8, &[1e8, 1e8]), SCALE_SHARE * 1e8); // rows of 1e8
        assert_eq!(scale(1.0, &[1e8]), SCALE_SHARE); // columns of 1e8
        assert_eq!(scale(1.0, &[1e-8]), 1e8 / SCALE_RANGE); // columns of 1e-8
        assert_eq!(scale(1e-8, &[1e-8]), 1.0); // rows of 1e-8
    }
}

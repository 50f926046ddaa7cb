//! Analyses of the last patterns, for problems that come again with other numbers: a structure has no numbers in it that a
//! solve reads, so that a solve has the same bits with one that was kept.

use crate::error::Error;
use crate::kkt::structure::Structure;
use crate::problem::Problem;
use crate::symbolic::{ordering::Ordering, supernodes::Panels};
use std::sync::{Arc, Mutex};

/// Patterns that are kept, and the most entries of one. For larger ones the analysis is a small part of a solve.
const MOST_PATTERNS: usize = 16;
const MOST_ENTRIES: usize = 4096;

/// The latest is the last.
static KNOWN: Mutex<Vec<Known>> = Mutex::new(Vec::new());

struct Known {
    problem: Arc<Problem>,
    ordering: Ordering,
    structure: Arc<Structure>,
}

impl Known {
    fn fits(&self, problem: &Problem, ordering: Ordering) -> bool {
        self.ordering == ordering && self.problem.same_pattern(problem).is_ok()
    }
}

/// The analysis of a problem's pattern with relaxed panels: one that is kept, or a new one. Where another thread holds the
/// lock, a new one: none waits.
///
/// # Errors
/// A pattern too large.
pub(crate) fn structure_of(problem: &Arc<Problem>, ordering: Ordering) -> Result<Arc<Structure>, Error> {
    let small = problem.p.nnz() + problem.a.nnz() + problem.g.nnz() <= MOST_ENTRIES
        && problem.n() + problem.p() + problem.m() <= MOST_ENTRIES;
    if small {
        if let Ok(mut known) = KNOWN.try_lock() {
            if let Some(at) = known.iter().rposition(|known| known.fits(problem, ordering)) {
                known[at..].rotate_left(1);
                return Ok(Arc::clone(&known[known.len() - 1].structure));
            }
        }
    }
    let structure = Arc::new(Structure::new(problem, ordering, Panels::Relaxed)?);
    if small {
        if let Ok(mut known) = KNOWN.try_lock() {
            if known.len() == MOST_PATTERNS {
                known.remove(0);
            }
            known.push(Known { problem: Arc::clone(problem), ordering, structure: Arc::clone(&structure) });
        }
    }
    Ok(structure)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Cones, Csc, Engine, Settings};

    /// −xᵢ ≤ −hᵢ at a cost of one each.
    fn bounds(h: &[f64]) -> Problem {
        let rows: Vec<Vec<f64>> =
            (0..h.len()).map(|i| (0..h.len()).map(|j| if i == j { -1.0 } else { 0.0 }).collect()).collect();
        let g = Csc::from_dense(&rows.iter().map(Vec::as_slice).collect::<Vec<_>>(), h.len());
        let (c, cones) = (vec![1.0; h.len()], Cones { l: h.len(), q: vec![] });
        Problem::new(None, c, None, vec![], Some(g), h.to_vec(), cones).unwrap()
    }

    #[test]
    fn a_known_pattern_gives_the_bits_of_a_new_one_and_absent_rows_are_part_of_it() {
        let settings = Settings::default();
        let problems = [bounds(&[-1.0, -2.0, -3.0]), bounds(&[4.0, 5.0, -6.0])];
        for problem in problems.iter().chain(&problems) {
            let fresh = Engine::<f64>::with_panels(problem, &settings, Panels::Relaxed).unwrap().solve();
            let known = Engine::<f64>::new(problem, &settings).unwrap().solve();
            let bits = |v: &[f64]| v.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&fresh.x), bits(&known.x));
            assert_eq!(bits(&fresh.z), bits(&known.z));
        }
        let [absent, other] = [bounds(&[1.0, f64::INFINITY, 1.0]), bounds(&[0.0; 3])].map(Arc::new);
        assert_eq!(structure_of(&absent, Ordering::Amd).unwrap().m, 2);
        assert_eq!(structure_of(&other, Ordering::Amd).unwrap().m, 3);
    }

    #[test]
    fn as_many_patterns_are_kept_as_there_is_room_for() {
        for size in 1..2 * MOST_PATTERNS {
            structure_of(&Arc::new(bounds(&vec![1.0; size])), Ordering::Amd).unwrap();
        }
        if let Ok(known) = KNOWN.lock() {
            assert!(known.len() <= MOST_PATTERNS);
        }
    }
}

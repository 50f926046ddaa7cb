//! Nested dissection: an order whose elimination tree is shallow. A separator splits the graph of the matrix, both
//! halves are ordered alike, and the separator comes last (George, SIAM J. Numer. Anal. 10(2), 1973). The level sets of
//! a breadth-first search are slices in time of a trajectory's problem, so a separator is a least vertex cover between
//! two of them. Integers decide everything: the order depends on the pattern alone, on every machine.

use crate::error::Error;
use crate::symbolic::indices::{begins, index, ordered};
use crate::symbolic::minimum_degree::minimum_degree;
use crate::symbolic::upper::Upper;
use core::cmp::Reverse;

/// Cuts that are tried for each separator, the most promising first.
const CUTS: usize = 12;
/// Passes that look for a vertex far from all others.
const SWEEPS: usize = 3;

/// How a graph is dissected.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    /// Pieces of at most this many vertices are ordered by minimum degree.
    pub leaf: usize,
    /// Vertices of more than this many times the mean number of neighbours come last.
    pub dense: usize,
}

/// An order of the matrix: `order[new] = old`.
pub(crate) fn dissected(upper: &Upper, shape: Shape) -> Result<Vec<u32>, Error> {
    if shape.leaf >= upper.dim() {
        return minimum_degree(upper);
    }
    let graph = Graph::new(upper);
    let dim = graph.dim();
    let mean = graph.neighbours.len().div_ceil(dim.max(1));
    let limit = shape.dense.saturating_mul(mean.max(1));
    let many = |v: &u32| graph.of(*v).len() > limit;
    let rest: Vec<u32> = (0..index(dim)).filter(|v| !many(v)).collect();
    let mut dense: Vec<u32> = (0..index(dim)).filter(many).collect();
    dense.sort_by_key(|&v| graph.of(v).len());
    // From the back: the densest, then separators, then what they separate.
    let mut from_back: Vec<u32> = dense.into_iter().rev().collect();
    let mut part = vec![NONE; dim];
    let mut pieces = vec![rest];
    let mut marks = 0;
    while let Some(piece) = pieces.pop() {
        marks += 1;
        for &v in &piece {
            part[v as usize] = marks;
        }
        let mut search = Search { graph: &graph, part: &mut part, inside: marks };
        let connected = search.components(&piece);
        marks = search.inside;
        if connected.len() > 1 {
            pieces.extend(connected);
            continue;
        }
        let cut = if piece.len() > shape.leaf { search.separator(&piece) } else { None };
        marks = search.inside;
        if let Some([one, separator, other]) = cut {
            from_back.extend(separator.iter().rev());
            for v in separator {
                part[v as usize] = NONE;
            }
            pieces.extend([one, other]);
        } else {
            let order = graph.minimum_degree_within(&piece)?;
            from_back.extend(order.iter().rev());
            for v in piece {
                part[v as usize] = NONE;
            }
        }
    }
    from_back.reverse();
    Ok(from_back)
}

const NONE: u32 = 0;

/// The graph of a symmetric matrix: each vertex's neighbours, ascending.
struct Graph {
    begins: Vec<u32>,
    neighbours: Vec<u32>,
}

impl Graph {
    fn new(upper: &Upper) -> Self {
        let edges = || {
            (0..upper.dim()).flat_map(move |j| {
                let above = upper.column(j).iter().filter(move |&&i| i as usize != j);
                above.flat_map(move |&i| [(i, index(j)), (index(j), i)])
            })
        };
        let begins = begins(upper.dim(), edges().map(|edge| edge.0));
        let mut neighbours: Vec<u32> = ordered(&begins, edges());
        for range in begins.windows(2) {
            neighbours[range[0] as usize..range[1] as usize].sort_unstable();
        }
        Self { begins, neighbours }
    }

    fn dim(&self) -> usize {
        self.begins.len() - 1
    }

    fn of(&self, v: u32) -> &[u32] {
        &self.neighbours[self.begins[v as usize] as usize..self.begins[v as usize + 1] as usize]
    }

    /// Some vertices in minimum-degree order of the graph that is left when all others are gone.
    fn minimum_degree_within(&self, piece: &[u32]) -> Result<Vec<u32>, Error> {
        let mut sorted = piece.to_vec();
        sorted.sort_unstable();
        let mut entries: Vec<(u32, u32)> = (0..index(sorted.len())).map(|k| (k, k)).collect();
        for (&v, k) in sorted.iter().zip(0..) {
            let before = self.of(v).iter().filter_map(|u| sorted[..k as usize].binary_search(u).ok());
            entries.extend(before.map(|at| (index(at), k)));
        }
        let (upper, _) = Upper::from_positions(sorted.len(), &entries);
        Ok(minimum_degree(&upper)?.into_iter().map(|k| sorted[k as usize]).collect())
    }
}

/// Searches within the vertices whose `part` is `inside`.
struct Search<'a> {
    graph: &'a Graph,
    part: &'a mut [u32],
    inside: u32,
}

impl Search<'_> {
    /// Level sets from some vertex on; what they reach is the part `to` afterwards.
    fn levels(&mut self, from: u32, to: u32) -> Vec<Vec<u32>> {
        self.part[from as usize] = to;
        let mut levels = vec![vec![from]];
        loop {
            let mut next = Vec::new();
            for &v in &levels[levels.len() - 1] {
                for &u in self.graph.of(v) {
                    if self.part[u as usize] == self.inside {
                        self.part[u as usize] = to;
                        next.push(u);
                    }
                }
            }
            if next.is_empty() {
                self.inside = to;
                return levels;
            }
            levels.push(next);
        }
    }

    /// The connected components of the piece, in the order of their first vertices; `inside` is then a new number
    /// that all have.
    fn components(&mut self, piece: &[u32]) -> Vec<Vec<u32>> {
        let (inside, new) = (self.inside, self.inside + 1);
        let mut found = Vec::new();
        for &v in piece {
            if self.part[v as usize] == inside {
                self.inside = inside;
                found.push(self.levels(v, new).concat());
            }
        }
        self.inside = new;
        found
    }

    /// A connected piece as one side, separator and the other side; none where its level sets are too few.
    fn separator(&mut self, piece: &[u32]) -> Option<[Vec<u32>; 3]> {
        let mut from = piece.iter().copied().min_by_key(|&v| (self.graph.of(v).len(), v))?;
        let mut levels = self.levels(from, self.inside + 1);
        for _ in 0..SWEEPS {
            let far = levels[levels.len() - 1].iter().copied();
            from = far.min_by_key(|&v| (self.graph.of(v).len(), v))?;
            let again = self.levels(from, self.inside + 1);
            let deeper = again.len() > levels.len();
            levels = again;
            if !deeper {
                break;
            }
        }
        let below: Vec<usize> = levels
            .iter()
            .scan(0, |sum, level| {
                *sum += level.len();
                Some(*sum)
            })
            .collect();
        // Vertices of the cut for each one of the smaller side, as a fraction of 2³².
        let price = |cut: usize, k: usize| ((cut as u64) << 32) / below[k].min(piece.len() - below[k]) as u64;
        let mut cuts: Vec<usize> = (0..levels.len().saturating_sub(1)).collect();
        cuts.sort_by_key(|&k| (price(levels[k].len().min(levels[k + 1].len()), k), k));
        let covers = cuts.into_iter().take(CUTS).map(|k| (k, self.cover(&levels[k], &levels[k + 1])));
        let (k, separator) = covers.min_by_key(|(k, cover)| (price(cover.len(), *k), Reverse(*k)))?;
        let apart = |levels: &[Vec<u32>]| {
            let outside = levels.iter().flatten().filter(|v| !separator.contains(v));
            outside.copied().collect::<Vec<u32>>()
        };
        let (one, other) = (apart(&levels[..=k]), apart(&levels[k + 1..]));
        let useful = !one.is_empty() && !other.is_empty();
        useful.then_some([one, separator, other])
    }

    /// A least set of vertices that every edge between two level sets meets: Kőnig's theorem on a largest matching.
    fn cover(&self, left: &[u32], right: &[u32]) -> Vec<u32> {
        let mut place: Vec<(u32, usize)> = right.iter().copied().zip(0..).collect();
        place.sort_unstable();
        let at = |v: &u32| place.binary_search_by_key(v, |entry| entry.0).ok().map(|k| place[k].1);
        let edges: Vec<Vec<usize>> =
            left.iter().map(|&v| self.graph.of(v).iter().filter_map(at).collect()).collect();
        let mut mate_of_left = vec![None; left.len()];
        let mut mate_of_right = vec![None; right.len()];
        for start in 0..left.len() {
            let (reached, end) = alternating(&edges, &mate_of_right, [start]);
            let mut end = end;
            while let Some(r) = end {
                let l: usize = reached[r].unwrap_or(start);
                mate_of_right[r] = Some(l);
                end = mate_of_left[l].replace(r);
            }
        }
        let free = (0..left.len()).filter(|&l| mate_of_left[l].is_none());
        let (reached, _) = alternating(&edges, &mate_of_right, free);
        let mut met: Vec<bool> = mate_of_left.iter().map(Option::is_none).collect();
        for (r, from) in reached.iter().enumerate() {
            if let (Some(_), Some(l)) = (from, mate_of_right[r]) {
                met[l] = true;
            }
        }
        let of_left = left.iter().zip(&met).filter(|(_, &met)| !met).map(|(&v, _)| v);
        let of_right = right.iter().zip(&reached).filter(|(_, from)| from.is_some()).map(|(&v, _)| v);
        of_left.chain(of_right).collect()
    }
}

/// From where on the left each vertex of the right is reached by paths that alternate between free and matched edges,
/// and the first free one, where the search ends.
fn alternating(
    edges: &[Vec<usize>],
    mate_of_right: &[Option<usize>],
    from: impl IntoIterator<Item = usize>,
) -> (Vec<Option<usize>>, Option<usize>) {
    let mut reached = vec![None; mate_of_right.len()];
    let mut queue: Vec<usize> = from.into_iter().collect();
    let mut next = 0;
    while next < queue.len() {
        let l = queue[next];
        next += 1;
        for &r in &edges[l] {
            if reached[r].is_none() {
                reached[r] = Some(l);
                match mate_of_right[r] {
                    None => return (reached, Some(r)),
                    Some(mate) => queue.push(mate),
                }
            }
        }
    }
    (reached, None)
}

#[cfg(test)]
#[allow(clippy::cast_possible_truncation)] // small sizes
mod tests {
    use super::*;
    use crate::tests::reference::SplitMix64;

    /// Slices of `width` vertices, each joined with all of its own and of the next.
    fn chain(slices: u32, width: u32) -> Upper {
        let mut entries = Vec::new();
        for j in 0..slices * width {
            let first = (j / width).saturating_sub(1) * width;
            entries.extend((first..=j).map(|i| (i, j)));
        }
        Upper::from_positions((slices * width) as usize, &entries).0
    }

    #[test]
    fn the_order_is_a_permutation_of_any_graph() {
        let mut numbers = SplitMix64(11);
        for dim in 0..60u32 {
            let mut entries: Vec<(u32, u32)> = (0..dim).map(|j| (j, j)).collect();
            let density = numbers.unit().powi(3);
            for j in 0..dim {
                entries.extend((0..j).filter(|_| numbers.unit() < density).map(|i| (i, j)));
            }
            let (upper, _) = Upper::from_positions(dim as usize, &entries);
            for shape in [Shape { leaf: 1, dense: 2 }, Shape { leaf: 8, dense: usize::MAX }] {
                let mut order = dissected(&upper, shape).unwrap();
                order.sort_unstable();
                assert_eq!(order, (0..dim).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn the_separator_of_a_chain_is_one_slice_near_its_middle() {
        let (upper, slices, width) = (chain(31, 3), 31, 3);
        let order = dissected(&upper, Shape { leaf: 6, dense: usize::MAX }).unwrap();
        let last: Vec<u32> = order[order.len() - width..].iter().map(|v| v / 3).collect();
        assert!(last.iter().all(|&slice| slice == last[0]), "{last:?}");
        assert!((last[0].cast_signed() - slices / 2).abs() <= 2, "{last:?}");
    }

    #[test]
    fn no_edge_passes_a_cover_and_no_smaller_set_does_it() {
        let mut numbers = SplitMix64(3);
        for _ in 0..200 {
            let (l, r) = (1 + numbers.bits() % 5, 1 + numbers.bits() % 5);
            let dim = (l + r) as usize;
            let mut entries: Vec<(u32, u32)> = (0..index(dim)).map(|j| (j, j)).collect();
            for j in l..l + r {
                entries.extend((0..l).filter(|_| numbers.unit() < 0.4).map(|i| (i as u32, j as u32)));
            }
            let (upper, _) = Upper::from_positions(dim, &entries);
            let graph = Graph::new(&upper);
            let (left, right): (Vec<u32>, Vec<u32>) =
                ((0..l as u32).collect(), (l as u32..index(dim)).collect());
            let search = Search { graph: &graph, part: &mut [], inside: 0 };
            let cover = search.cover(&left, &right);
            let edges: Vec<_> = entries.iter().filter(|(i, j)| i != j).collect();
            let covers = |set: u32| edges.iter().all(|(i, j)| set >> i & 1 == 1 || set >> j & 1 == 1);
            assert!(covers(cover.iter().map(|v| 1 << v).sum()));
            let least = (0..1u32 << dim).filter(|&set| covers(set)).map(u32::count_ones).min();
            assert_eq!(least, Some(index(cover.len())));
        }
    }
}

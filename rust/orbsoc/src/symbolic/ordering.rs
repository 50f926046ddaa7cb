//! Fill-reducing ordering: AMD or nested dissection, then a leaf-first postorder of the elimination tree. It changes
//! neither fill nor operations, and brings columns of one kind side by side for the numeric kernels.

use crate::error::Error;
use crate::symbolic::dissection::{dissected, Shape};
use crate::symbolic::indices::{begins, index, ordered};
use crate::symbolic::minimum_degree::minimum_degree;
use crate::symbolic::{etree::elimination_tree, supernodes::MAX_LEAF_ROWS, upper::Upper};
use core::ops::Range;

/// Smaller groups stay in postorder.
const MIN_GROUP: usize = 4;
/// Rounds in which columns may follow their children to the front.
const ROUNDS: usize = 3;

/// How the KKT matrix is ordered. Each order has bits of its own, the same on every datapath.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ordering {
    /// Approximate minimum degree: the fewest operations.
    #[default]
    Amd,
    /// Nested dissection: a shallow elimination tree, for hardware whose lanes wait for a chain of pivots.
    NestedDissection,
    /// Whichever takes one core less time: the one with fewer multiply-adds.
    Automatic,
}

impl Ordering {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Amd, Self::NestedDissection, Self::Automatic];

    /// Its name in settings.
    pub fn name(self) -> &'static str {
        match self {
            Self::Amd => "amd",
            Self::NestedDissection => "nested_dissection",
            Self::Automatic => "automatic",
        }
    }

    /// The one of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|ordering| ordering.name() == name)
    }
}

/// How much there is to factor under an order, and how much of it must follow one another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FactorShape {
    /// Height of the elimination tree, in columns.
    pub height: u32,
    /// Entries of L, its diagonal included.
    pub entries: u64,
    /// Multiply-adds of LDLᵀ.
    pub multiply_adds: u64,
}

impl FactorShape {
    pub(crate) fn of(upper: &Upper) -> Self {
        let (parent, counts) = elimination_tree(upper);
        let mut heights = vec![1u32; parent.len()];
        for (j, &parent) in parent.iter().enumerate() {
            if let Ok(parent) = usize::try_from(parent) {
                heights[parent] = heights[parent].max(heights[j] + 1);
            }
        }
        let below = || counts.iter().map(|&count| u64::from(count) - 1);
        Self {
            height: heights.into_iter().max().unwrap_or(0),
            entries: counts.iter().map(|&count| u64::from(count)).sum(),
            multiply_adds: below().map(|rows| rows * (rows + 1) / 2).sum(),
        }
    }

    /// What a factorization costs where much is done at once: the chain of pivots, and the multiply-adds, in these.
    fn cost(self) -> u64 {
        u64::from(self.height) * PIVOT_WEIGHT + self.multiply_adds
    }
}

/// Multiply-adds in the time from one pivot of a chain to the next, a division, a product and a sum of 45 units: 8 a unit.
const PIVOT_WEIGHT: u64 = 360;

/// Dissections of which the cheapest is taken; the first has one piece, in minimum-degree order.
const SHAPES: [Shape; 5] = [
    Shape { leaf: usize::MAX, dense: usize::MAX },
    Shape { leaf: 12, dense: usize::MAX },
    Shape { leaf: 48, dense: usize::MAX },
    Shape { leaf: 24, dense: 4 },
    Shape { leaf: 48, dense: 4 },
];

/// Fill-reducing permutation: `order[new] = old`, children before parents. Groups of leaves with equally few rows, and
/// of columns with the same rows, come first; the others follow in postorder.
pub(crate) fn fill_reducing_order(upper: &Upper, ordering: Ordering) -> Result<Vec<u32>, Error> {
    let order = match ordering {
        Ordering::Amd => minimum_degree(upper)?,
        Ordering::NestedDissection => nested_dissection(upper)?,
        Ordering::Automatic => {
            let (one, other) = (minimum_degree(upper)?, nested_dissection(upper)?);
            if shape_of(upper, &one).multiply_adds <= shape_of(upper, &other).multiply_adds {
                one
            } else {
                other
            }
        }
    };
    Ok(leaves_first(upper, &order))
}

/// What there is to factor in that order.
fn shape_of(upper: &Upper, order: &[u32]) -> FactorShape {
    FactorShape::of(&upper.permuted_pattern(order))
}

/// The cheapest dissection; minimum degree where no separator shortens it.
fn nested_dissection(upper: &Upper) -> Result<Vec<u32>, Error> {
    let mut best: Option<(u64, Vec<u32>)> = None;
    for shape in SHAPES {
        let order = dissected(upper, shape)?;
        let cost = shape_of(upper, &order).cost();
        if best.as_ref().is_none_or(|(least, _)| cost < *least) {
            best = Some((cost, order));
        }
    }
    Ok(best.map_or_else(Vec::new, |(_, order)| order))
}

/// An equivalent order, with the same tree, that brings columns of one kind together.
fn leaves_first(upper: &Upper, order: &[u32]) -> Vec<u32> {
    let mut forest = EliminationForest::new(&upper.permuted_pattern(order));
    let front = forest.group_leaves();
    let rest = forest.postorder(&front);
    front.into_iter().chain(rest).map(|k| order[k as usize]).collect()
}

/// The elimination tree, and rows of L below the columns whose children went to the front.
struct EliminationForest {
    parent: Vec<Option<u32>>,
    /// Where each column's children begin in `children`; then, where all end.
    begins: Vec<u32>,
    children: Vec<u32>,
    /// Entries of each column of L.
    counts: Vec<u32>,
    /// Of each column, where its rows are in `rows`: the matrix's own, which are L's where it has no children;
    /// L's once [`EliminationForest::find`] has been there.
    below: Vec<Range<usize>>,
    rows: Vec<u32>,
}

impl EliminationForest {
    fn new(upper: &Upper) -> Self {
        let (parent, counts) = elimination_tree(upper);
        let parent: Vec<Option<u32>> = parent.iter().map(|&p| u32::try_from(p).ok()).collect();
        let edges = || parent.iter().zip(0..).filter_map(|(&parent, j)| Some((parent?, j)));
        let begins = begins(parent.len(), edges().map(|edge| edge.0));
        let children = ordered(&begins, edges());
        let (starts, rows) = upper.lower();
        let below = starts.windows(2).map(|ends| ends[0] as usize..ends[1] as usize).collect();
        Self { parent, begins, children, counts, below, rows }
    }

    fn children(&self, j: u32) -> &[u32] {
        &self.children[self.begins[j as usize] as usize..self.begins[j as usize + 1] as usize]
    }

    fn below(&self, j: u32) -> &[u32] {
        &self.rows[self.below[j as usize].clone()]
    }

    fn columns(&self) -> Range<u32> {
        0..index(self.parent.len())
    }

    /// Find the rows of a column of L: the matrix's own, and its children's.
    fn find(&mut self, j: u32) {
        let begin = self.rows.len();
        self.rows.extend_from_within(self.below[j as usize].clone());
        for child in self.begins[j as usize]..self.begins[j as usize + 1] {
            // Its first row is this column.
            let Range { start, end } = self.below[self.children[child as usize] as usize];
            self.rows.extend_from_within(start + 1..end);
        }
        self.rows[begin..].sort_unstable();
        let mut end = begin;
        for k in begin..self.rows.len() {
            if end == begin || self.rows[k] != self.rows[end - 1] {
                self.rows[end] = self.rows[k];
                end += 1;
            }
        }
        self.rows.truncate(end);
        self.below[j as usize] = begin..end;
    }

    /// Columns for the front, group after group.
    fn group_leaves(&mut self) -> Vec<u32> {
        let mut front = Vec::new();
        let mut taken = vec![false; self.parent.len()];
        let mut ready: Vec<u32> = self.columns().filter(|&j| self.children(j).is_empty()).collect();
        for _ in 0..ROUNDS {
            // A column that its parent merely continues stays with it, in one panel.
            let rows = |j: u32| self.counts[j as usize];
            ready.retain(|&j| self.parent[j as usize].is_none_or(|parent| rows(parent) + 1 != rows(j)));
            for &j in &ready {
                if !self.children(j).is_empty() {
                    self.find(j);
                }
            }
            // `None`, not an empty literal: comparing that takes 87 ns instead of 1 (decision 0009).
            let kind = |&j: &u32| {
                let rows = self.below(j);
                (rows.len(), (rows.len() > MAX_LEAF_ROWS).then_some(rows))
            };
            ready.sort_by_key(|&j| (self.below(j).len(), self.below(j)));
            let begin = front.len();
            for group in ready.chunk_by(|a, b| kind(a) == kind(b)).filter(|group| group.len() >= MIN_GROUP) {
                front.extend_from_slice(group);
            }
            front[begin..].iter().for_each(|&j| taken[j as usize] = true);
            let parents = front[begin..].iter().filter_map(|&j| self.parent[j as usize]);
            ready = parents.filter(|&p| self.children(p).iter().all(|&c| taken[c as usize])).collect();
            ready.sort_unstable();
            ready.dedup();
        }
        front
    }

    /// The other columns, children before parents, each subtree contiguous; among children, leaves come first,
    /// and those with the same rows side by side.
    fn postorder(&self, front: &[u32]) -> Vec<u32> {
        let mut taken = vec![false; self.parent.len()];
        for &j in front {
            taken[j as usize] = true;
        }
        let kind = |&j: &u32| {
            let leaf = self.children(j).is_empty();
            (!leaf, leaf.then(|| self.below(j)))
        };
        let roots = self.columns().filter(|&j| self.parent[j as usize].is_none() && !taken[j as usize]);
        // A column is met twice: its children go before it, then it follows them.
        let mut stack: Vec<(u32, bool)> = roots.rev().map(|j| (j, false)).collect();
        let mut order = Vec::with_capacity(self.parent.len() - front.len());
        let mut siblings = Vec::new();
        while let Some((j, met)) = stack.pop() {
            if met {
                order.push(j);
                continue;
            }
            stack.push((j, true));
            siblings.extend(self.children(j).iter().filter(|&&c| !taken[c as usize]));
            siblings.sort_by(|a, b| kind(a).cmp(&kind(b)));
            stack.extend(siblings.drain(..).rev().map(|c| (c, false)));
        }
        order
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::symbolic::etree::columns_of_l;
    use crate::tests::reference::SplitMix64;

    #[test]
    fn rows_found_from_the_children_are_those_of_l() {
        let mut numbers = SplitMix64(5);
        for dim in 0..40 {
            let mut positions: Vec<(u32, u32)> = (0..dim).map(|j| (j, j)).collect();
            let density = numbers.unit().powi(2);
            for j in 0..dim {
                positions.extend((0..j).filter(|_| numbers.unit() < density).map(|i| (i, j)));
            }
            let (upper, _) = Upper::from_positions(dim as usize, &positions);
            let l = columns_of_l(&upper).unwrap();
            let (colptr, rowidx) = (l.col_ptr(), l.row_idx());
            let mut forest = EliminationForest::new(&upper);
            for j in 0..dim {
                if !forest.children(j).is_empty() {
                    forest.find(j);
                }
                let column = colptr[j as usize] as usize..colptr[j as usize + 1] as usize;
                assert_eq!(forest.below(j), &rowidx[column][1..], "column {j} of {dim}");
            }
        }
    }
}

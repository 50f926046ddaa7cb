//! The fill-reducing order: AMD through faer, then rearranged along the elimination tree, which changes
//! neither fill nor operations, so that the numeric kernels find columns of a kind side by side.

use crate::error::Error;
use crate::supernode::LEAF_ROWS;
use crate::symbolic::{columns_of_l, elimination_tree};
use crate::upper::Upper;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::amd;
use std::collections::BTreeMap;

/// A group of fewer columns is not worth a place of its own.
const GROUP: usize = 4;
/// How often columns whose children all went to the front may follow them.
const ROUNDS: usize = 3;

/// Fill-reducing permutation: `order[new] = old`. Children come before parents. To the front go columns
/// that only depend on columns there, and of which there are many of a kind (leaves with equally few rows,
/// siblings with the same rows); the others follow in postorder.
pub(crate) fn fill_reducing_order(upper: &Upper) -> Result<Vec<usize>, Error> {
    let dim = upper.dim();
    let (mut order, mut inverse) = (vec![0usize; dim], vec![0usize; dim]);
    let mut memory = MemBuffer::new(amd::order_scratch::<usize>(dim, upper.nnz()));
    amd::order(&mut order, &mut inverse, upper.faer(), amd::Control::default(), MemStack::new(&mut memory))
        .map_err(|e| Error::Symbolic(format!("{e:?}")))?;
    let (permuted, _) = upper.permuted(&order);
    let (colptr, rowidx) = columns_of_l(&permuted)?;
    let forest = Forest::new(&elimination_tree(&permuted).0);
    let below = |j: usize| &rowidx[colptr[j] + 1..colptr[j + 1]];
    let front = forest.groups(below);
    let rest = forest.postorder(&front, below);
    Ok(front.into_iter().chain(rest).map(|k| order[k]).collect())
}

struct Forest {
    parent: Vec<Option<usize>>,
    children: Vec<Vec<usize>>,
}

impl Forest {
    fn new(parent: &[isize]) -> Self {
        let parent: Vec<Option<usize>> = parent.iter().map(|&p| usize::try_from(p).ok()).collect();
        let mut children = vec![Vec::new(); parent.len()];
        for (j, parent) in parent.iter().enumerate() {
            if let Some(parent) = *parent {
                children[parent].push(j);
            }
        }
        Self { parent, children }
    }

    /// Columns for the front, group after group.
    fn groups<'a>(&self, below: impl Fn(usize) -> &'a [usize]) -> Vec<usize> {
        let mut front = Vec::new();
        let mut taken = vec![false; self.parent.len()];
        let mut ready: Vec<usize> = (0..self.parent.len()).filter(|&j| self.children[j].is_empty()).collect();
        for _ in 0..ROUNDS {
            let mut groups: BTreeMap<(usize, &[usize]), Vec<usize>> = BTreeMap::new();
            for &j in &ready {
                let rows = below(j);
                // A column that its parent merely continues stays with it, in one panel.
                let continued = self.parent[j].is_some_and(|p| below(p).len() + 1 == rows.len());
                if !continued {
                    let few = rows.len() <= LEAF_ROWS;
                    groups.entry((rows.len(), if few { &[] } else { rows })).or_default().push(j);
                }
            }
            let begin = front.len();
            for mut group in groups.into_values().filter(|group| group.len() >= GROUP) {
                group.sort_by_key(|&j| below(j));
                front.extend(group);
            }
            front[begin..].iter().for_each(|&j| taken[j] = true);
            let parents = front[begin..].iter().filter_map(|&j| self.parent[j]);
            ready = parents.filter(|&p| self.children[p].iter().all(|&c| taken[c])).collect();
            ready.sort_unstable();
            ready.dedup();
        }
        front
    }

    /// The other columns, children before parents, each subtree contiguous; of siblings, leaves come first,
    /// and those with the same rows side by side.
    fn postorder<'a>(&self, front: &[usize], below: impl Fn(usize) -> &'a [usize]) -> Vec<usize> {
        let mut taken = vec![false; self.parent.len()];
        for &j in front {
            taken[j] = true;
        }
        let mut children = self.children.clone();
        for siblings in &mut children {
            siblings.retain(|&j| !taken[j]);
            siblings.sort_by_cached_key(|&j| {
                let leaf = self.children[j].is_empty();
                (!leaf, if leaf { below(j) } else { &[] })
            });
        }
        let roots = (0..self.parent.len()).filter(|&j| self.parent[j].is_none() && !taken[j]);
        let mut stack: Vec<usize> = roots.rev().collect();
        let mut order = Vec::with_capacity(self.parent.len() - front.len());
        while let Some(&j) = stack.last() {
            if children[j].is_empty() {
                order.push(j);
                stack.pop();
            } else {
                stack.extend(core::mem::take(&mut children[j]).into_iter().rev());
            }
        }
        order
    }
}

//! Who waits for whom, how long, and how long the way to the end is from everywhere.

use super::graph::Graph;
use crate::machine::configuration::Configuration;
use crate::machine::operation::Code;
use std::cell::OnceCell;

/// Whom a node waits for: until the result is in storage, or (`false`) only until the other one has begun.
pub(crate) type Wait = (u32, bool);

/// Predecessors of each node, and the longest way from its issue to the end.
pub(crate) struct Edges {
    first: Vec<u32>,
    from: Vec<Wait>,
    /// Cycles from a node's issue until the last result that depends on it is in storage.
    path: Vec<u32>,
    longest: u32,
    waiting: OnceCell<Waiting>,
}

/// Who waits for each node: the start of each node's list, and the lists; and for how many each node waits.
pub(crate) struct Waiting {
    pub first: Vec<u32>,
    pub list: Vec<u32>,
    pub count: Vec<u32>,
}

impl Edges {
    pub fn new(graph: &Graph, configuration: &Configuration) -> Self {
        let timing = configuration.timing();
        let distances = Code::ALL.map(|code| timing.distance(code));
        let nodes = &graph.nodes;
        let mut first = vec![0u32; nodes.len() + 1];
        for (k, node) in nodes.iter().enumerate() {
            first[k + 1] = node.sources().count() as u32;
        }
        for &(_, overwriter) in &graph.overwrites {
            first[overwriter as usize + 1] += 1;
        }
        for k in 0..nodes.len() {
            first[k + 1] += first[k];
        }
        let mut next = first.clone();
        let mut from = vec![(0, false); first[nodes.len()] as usize];
        let mut put = |to: usize, edge: Wait| {
            from[next[to] as usize] = edge;
            next[to] += 1;
        };
        for (k, node) in nodes.iter().enumerate() {
            for source in node.sources() {
                put(k, (source, true));
            }
        }
        for &(reader, overwriter) in &graph.overwrites {
            put(overwriter as usize, (reader, false));
        }
        let mut path: Vec<u32> = nodes.iter().map(|node| distances[node.code as usize] + 1).collect();
        for k in (0..nodes.len()).rev() {
            for &(source, result) in &from[first[k] as usize..first[k + 1] as usize] {
                let cycles = if result { distances[nodes[source as usize].code as usize] } else { 0 };
                let through = cycles + path[k];
                path[source as usize] = path[source as usize].max(through);
            }
        }
        let longest = path.iter().copied().max().unwrap_or(0);
        Self { first, from, path, longest, waiting: OnceCell::new() }
    }

    /// Whom a node waits for.
    pub fn into(&self, k: u32) -> &[Wait] {
        &self.from[self.first[k as usize] as usize..self.first[k as usize + 1] as usize]
    }

    /// Who waits for whom.
    pub fn waiting(&self) -> &Waiting {
        self.waiting.get_or_init(|| {
            let nodes = self.path.len();
            let mut first = vec![0u32; nodes + 1];
            self.from.iter().for_each(|&(source, _)| first[source as usize + 1] += 1);
            for k in 0..nodes {
                first[k + 1] += first[k];
            }
            let (mut next, mut list) = (first.clone(), vec![0; self.from.len()]);
            for k in 0..nodes as u32 {
                for &(source, _) in self.into(k) {
                    list[next[source as usize] as usize] = k;
                    next[source as usize] += 1;
                }
            }
            let count = self.first.windows(2).map(|pair| pair[1] - pair[0]).collect();
            Waiting { first, list, count }
        })
    }

    /// Cycles from each node's issue until the last result that depends on it is in storage.
    pub fn paths(&self) -> &[u32] {
        &self.path
    }

    /// The longest way of all.
    pub fn longest(&self) -> u32 {
        self.longest
    }
}

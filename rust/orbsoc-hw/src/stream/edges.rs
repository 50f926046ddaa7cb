//! Dependence edges of a graph, and each node's latency-weighted longest path to a sink.

use super::graph::Graph;
use crate::machine::configuration::Configuration;
use crate::machine::operation::Code;
use std::cell::OnceCell;

/// A predecessor, and whether its result is needed (true dependence) or only its reads (`false`, anti-dependence).
pub(crate) type Dependence = (u32, bool);

/// Predecessors of each node, and the longest path from its issue to the end.
pub(crate) struct Edges {
    first: Vec<u32>,
    predecessors: Vec<Dependence>,
    path: Vec<u32>,
    critical_path: u32,
    successors: OnceCell<Successors>,
}

/// Successors of each node, node `k`'s in `list[first[k]..first[k + 1]]`, and the number of predecessors of each.
pub(crate) struct Successors {
    pub first: Vec<u32>,
    pub list: Vec<u32>,
    pub predecessor_counts: Vec<u32>,
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
        for &(_, overwriter) in &graph.anti_dependences {
            first[overwriter as usize + 1] += 1;
        }
        for k in 0..nodes.len() {
            first[k + 1] += first[k];
        }
        let mut next = first.clone();
        let mut predecessors = vec![(0, false); first[nodes.len()] as usize];
        let mut put = |to: usize, edge: Dependence| {
            predecessors[next[to] as usize] = edge;
            next[to] += 1;
        };
        for (k, node) in nodes.iter().enumerate() {
            for source in node.sources() {
                put(k, (source, true));
            }
        }
        for &(reader, overwriter) in &graph.anti_dependences {
            put(overwriter as usize, (reader, false));
        }
        let mut path: Vec<u32> = nodes.iter().map(|node| distances[node.code as usize] + 1).collect();
        for k in (0..nodes.len()).rev() {
            for &(source, result) in &predecessors[first[k] as usize..first[k + 1] as usize] {
                let cycles = if result { distances[nodes[source as usize].code as usize] } else { 0 };
                let through = cycles + path[k];
                path[source as usize] = path[source as usize].max(through);
            }
        }
        let critical_path = path.iter().copied().max().unwrap_or(0);
        Self { first, predecessors, path, critical_path, successors: OnceCell::new() }
    }

    pub fn predecessors(&self, k: u32) -> &[Dependence] {
        &self.predecessors[self.first[k as usize] as usize..self.first[k as usize + 1] as usize]
    }

    pub fn successors(&self) -> &Successors {
        self.successors.get_or_init(|| {
            let nodes = self.path.len();
            let mut first = vec![0u32; nodes + 1];
            self.predecessors.iter().for_each(|&(source, _)| first[source as usize + 1] += 1);
            for k in 0..nodes {
                first[k + 1] += first[k];
            }
            let (mut next, mut list) = (first.clone(), vec![0; self.predecessors.len()]);
            for k in 0..nodes as u32 {
                for &(source, _) in self.predecessors(k) {
                    list[next[source as usize] as usize] = k;
                    next[source as usize] += 1;
                }
            }
            let predecessor_counts = self.first.windows(2).map(|pair| pair[1] - pair[0]).collect();
            Successors { first, list, predecessor_counts }
        })
    }

    /// Cycles from each node's issue until the last result that depends on it is in storage.
    pub fn paths_to_sink(&self) -> &[u32] {
        &self.path
    }

    /// Cycles of the longest path.
    pub fn critical_path(&self) -> u32 {
        self.critical_path
    }
}

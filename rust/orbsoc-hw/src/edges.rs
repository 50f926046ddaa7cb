//! Who waits for whom, how long, and how long the way to the end is from everywhere.

use crate::configuration::Configuration;
use crate::graph::Graph;

/// Whom a node waits for: until the result is in storage, or (`false`) only until the other one has begun.
pub(crate) type Wait = (u32, bool);

/// Predecessors of each node, and the longest way from its issue to the end.
pub(crate) struct Edges {
    first: Vec<u32>,
    from: Vec<Wait>,
    /// Cycles from a node's issue until the last result that depends on it is in storage.
    pub path: Vec<u32>,
    /// Nodes from the most urgent on, and the place of each among them: first who has the longest way to the end, and
    /// of equal ways the earlier one in the kernel; of ways about as long, too, where neighbours shall stay together.
    /// Urgency decreases along every edge, since ways get shorter (or, from a word's reader to its overwriter, at
    /// least not longer) and numbers higher.
    order: Vec<u32>,
    rank: Vec<u32>,
}

impl Edges {
    /// `nodes_per_cycle`: how many nodes earlier in the kernel weigh as much as a cycle more to the end; none: nothing
    /// does.
    pub fn new(graph: &Graph, configuration: &Configuration, nodes_per_cycle: Option<u32>) -> Self {
        let timing = configuration.timing();
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
        let mut path: Vec<u32> = nodes.iter().map(|node| timing.distance(node.code) + 1).collect();
        for k in (0..nodes.len()).rev() {
            for &(source, result) in &from[first[k] as usize..first[k + 1] as usize] {
                let cycles = if result { timing.distance(nodes[source as usize].code) } else { 0 };
                let through = cycles + path[k];
                path[source as usize] = path[source as usize].max(through);
            }
        }
        // Key and node in one number sort fastest.
        let count = nodes.len() as u32;
        let urgency = |k: u32| match nodes_per_cycle {
            None => path[k as usize],
            Some(nodes) => path[k as usize].saturating_mul(nodes).saturating_add(count - k),
        };
        let key = |k: u32| u64::from(u32::MAX - urgency(k)) << 32 | u64::from(k);
        let mut keys: Vec<u64> = (0..count).map(key).collect();
        keys.sort_unstable();
        let order: Vec<u32> = keys.into_iter().map(|key| key as u32).collect();
        let mut rank = vec![0; nodes.len()];
        order.iter().zip(0..).for_each(|(&k, place)| rank[k as usize] = place);
        Self { first, from, path, order, rank }
    }

    /// Whom a node waits for.
    pub fn into(&self, k: u32) -> &[Wait] {
        &self.from[self.first[k as usize] as usize..self.first[k as usize + 1] as usize]
    }

    /// Nodes from the most urgent on.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// A node's place in that order.
    pub fn rank(&self, k: u32) -> u32 {
        self.rank[k as usize]
    }

    /// The node in a place of that order.
    pub fn of_rank(&self, rank: u32) -> u32 {
        self.order[rank as usize]
    }

    /// Nodes that wait for each node, as the start of each node's list and the lists; and how many it waits for.
    pub fn waiting(&self) -> (Vec<u32>, Vec<u32>, Vec<u32>) {
        let nodes = self.path.len();
        let mut first = vec![0u32; nodes + 1];
        self.from.iter().for_each(|&(source, _)| first[source as usize + 1] += 1);
        for k in 0..nodes {
            first[k + 1] += first[k];
        }
        let (mut next, mut list) = (first.clone(), vec![0; self.from.len()]);
        let mut count = vec![0; nodes];
        for k in 0..nodes as u32 {
            for &(source, _) in self.into(k) {
                list[next[source as usize] as usize] = k;
                next[source as usize] += 1;
                count[k as usize] += 1;
            }
        }
        (first, list, count)
    }

    /// The longest way of all.
    pub fn longest(&self) -> u32 {
        self.path.iter().copied().max().unwrap_or(0)
    }
}

//! Runs of like operations: what a lane does one after the other costs a compressed microcode few bits.

use crate::code::Code;
use crate::graph::{Graph, Operand};
use std::collections::HashMap;

/// For each node the one that continues its run, and the number of its run.
pub(crate) struct Vectors {
    next: Vec<Option<u32>>,
    run: Vec<u32>,
    length: Vec<u32>,
}

/// Operations of a run at most.
const LONGEST: u32 = 64;

impl Vectors {
    /// Runs of a graph: operations of one code that share a factor, in the order of the kernel; and neighbours of one
    /// code that do not read each other.
    pub fn new(graph: &Graph) -> Self {
        let nodes = graph.nodes.len();
        let mut vectors = Self { next: vec![None; nodes], run: vec![0; nodes], length: Vec::new() };
        let mut open: HashMap<(Code, Operand), u32> = HashMap::new();
        let mut shared: HashMap<(Code, Operand), u32> = HashMap::new();
        let factor = |k: usize| {
            let node = &graph.nodes[k];
            node.operands[1].filter(|_| node.code.commutes()).map(|b| (node.code, b))
        };
        (0..nodes).filter_map(factor).for_each(|key| *shared.entry(key).or_default() += 1);
        for k in 0..nodes {
            let key = factor(k).filter(|key| shared[key] > 1);
            let before = match key {
                Some(key) => open.insert(key, k as u32),
                None => (k as u32).checked_sub(1).filter(|&p| {
                    let alone = factor(p as usize).is_none_or(|key| shared[&key] == 1);
                    alone && graph.nodes[p as usize].code == graph.nodes[k].code
                }),
            };
            let run = before.map(|p| vectors.run[p as usize]).filter(|&run| {
                let reads = |source: u32| vectors.run[source as usize] == run;
                vectors.length[run as usize] < LONGEST && !graph.nodes[k].sources().any(reads)
            });
            if let (Some(run), Some(p)) = (run, before) {
                vectors.next[p as usize] = Some(k as u32);
                vectors.run[k] = run;
                vectors.length[run as usize] += 1;
            } else {
                vectors.run[k] = vectors.length.len() as u32;
                vectors.length.push(1);
            }
        }
        vectors
    }

    /// A node's run.
    pub fn run(&self, k: u32) -> u32 {
        self.run[k as usize]
    }

    /// The first operation of every run.
    pub fn heads(&self) -> Vec<u32> {
        let mut heads = vec![0; self.length.len()];
        for (k, &run) in self.run.iter().enumerate().rev() {
            heads[run as usize] = k as u32;
        }
        heads
    }

    /// The operation that continues a node's run.
    pub fn next(&self, k: u32) -> Option<u32> {
        self.next[k as usize]
    }

    /// Whether a node's run is the node alone.
    pub fn is_alone(&self, k: u32) -> bool {
        self.length[self.run[k as usize] as usize] == 1
    }
}

//! Runs of like operations: what a lane does one after the other costs a compressed microcode few bits.

use super::graph::{Graph, Node, Operand};
use crate::machine::operation::Code;

/// For each node the one that continues its run, and the number of its run; for each run its first node and its length.
pub(crate) struct Vectors {
    next: Vec<Option<u32>>,
    run: Vec<u32>,
    heads: Vec<u32>,
    length: Vec<u32>,
}

/// Operations of a run at most.
const LONGEST: u32 = 64;

impl Vectors {
    /// Runs of a graph: operations of one code that share a factor, in the order of the kernel; and neighbours of one
    /// code that do not read each other.
    pub fn new(graph: &Graph) -> Self {
        let nodes = graph.nodes.len();
        let mut vectors =
            Self { next: vec![None; nodes], run: vec![0; nodes], heads: Vec::new(), length: Vec::new() };
        let factors = Factors::of(graph);
        // Of each factor, the last operation that has it so far, counted from one.
        let mut last = vec![0u32; factors.times.len()];
        for k in 0..nodes {
            let before = match factors.shared(k) {
                Some(key) => core::mem::replace(&mut last[key as usize], k as u32 + 1).checked_sub(1),
                None => (k as u32).checked_sub(1).filter(|&p| {
                    let alone = factors.shared(p as usize).is_none();
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
                vectors.heads.push(k as u32);
            }
        }
        vectors
    }

    /// A node's run.
    pub fn run(&self, k: u32) -> u32 {
        self.run[k as usize]
    }

    /// The first operation of every run.
    pub fn heads(&self) -> &[u32] {
        &self.heads
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

/// The factor b of every operation that may exchange it with a, together with the operation's code, as a number; and
/// how many operations have each.
struct Factors {
    keys: Vec<Option<u32>>,
    times: Vec<u32>,
}

impl Factors {
    fn of(graph: &Graph) -> Self {
        let mut codes = 0;
        let numbers = Code::ALL.map(|code| {
            codes += u32::from(code.commutes());
            code.commutes().then(|| codes - 1)
        });
        let words = graph.words() as u32;
        let key = |node: &Node| {
            let operand = match node.operands[1]? {
                Operand::Fixed(address) => address,
                Operand::Node(source) => words + source,
            };
            Some(operand * codes + numbers[node.code as usize]?)
        };
        let keys: Vec<Option<u32>> = graph.nodes.iter().map(key).collect();
        let mut times = vec![0; (words as usize + keys.len()) * codes as usize];
        keys.iter().flatten().for_each(|&key| times[key as usize] += 1);
        Self { keys, times }
    }

    /// The factor of an operation that is not the only one to have it.
    fn shared(&self, k: usize) -> Option<u32> {
        self.keys[k].filter(|&key| self.times[key as usize] > 1)
    }
}

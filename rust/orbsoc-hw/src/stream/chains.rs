//! Operation chains for one lane: like operations that, one after the other, take few bits of compressed microcode.

use super::graph::{Graph, Node, Operand};
use crate::machine::operation::Code;

/// For each node its successor in its chain and the chain's number; for each chain its first node and its length.
pub(crate) struct Chains {
    next: Vec<Option<u32>>,
    chain: Vec<u32>,
    heads: Vec<u32>,
    length: Vec<u32>,
}

const MAX_LENGTH: u32 = 64;

impl Chains {
    /// A chain has operations of one code that share a factor, in kernel order, or neighbours of one code. No operation
    /// of a chain reads another one's result.
    pub fn new(graph: &Graph) -> Self {
        let nodes = graph.nodes.len();
        let mut chains =
            Self { next: vec![None; nodes], chain: vec![0; nodes], heads: Vec::new(), length: Vec::new() };
        let factors = Factors::of(graph);
        // The last operation of each factor, counted from one.
        let mut last = vec![0u32; factors.uses.len()];
        for k in 0..nodes {
            let previous = match factors.shared(k) {
                Some(key) => core::mem::replace(&mut last[key as usize], k as u32 + 1).checked_sub(1),
                None => (k as u32).checked_sub(1).filter(|&p| {
                    let unshared = factors.shared(p as usize).is_none();
                    unshared && graph.nodes[p as usize].code == graph.nodes[k].code
                }),
            };
            let chain = previous.map(|p| chains.chain(p)).filter(|&chain| {
                let reads = |source: u32| chains.chain(source) == chain;
                chains.length[chain as usize] < MAX_LENGTH && !graph.nodes[k].sources().any(reads)
            });
            if let (Some(chain), Some(p)) = (chain, previous) {
                chains.next[p as usize] = Some(k as u32);
                chains.chain[k] = chain;
                chains.length[chain as usize] += 1;
            } else {
                chains.chain[k] = chains.length.len() as u32;
                chains.length.push(1);
                chains.heads.push(k as u32);
            }
        }
        chains
    }

    /// The number of a node's chain.
    pub fn chain(&self, k: u32) -> u32 {
        self.chain[k as usize]
    }

    /// The first operation of every chain.
    pub fn heads(&self) -> &[u32] {
        &self.heads
    }

    /// A node's successor in its chain.
    pub fn next(&self, k: u32) -> Option<u32> {
        self.next[k as usize]
    }

    /// Whether a node's chain has no other operation.
    pub fn is_single(&self, k: u32) -> bool {
        self.length[self.chain(k) as usize] == 1
    }
}

/// For every commutative operation its factor b and its code as one key; for each key the number of operations.
struct Factors {
    keys: Vec<Option<u32>>,
    uses: Vec<u32>,
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
        let mut uses = vec![0; (words as usize + keys.len()) * codes as usize];
        keys.iter().flatten().for_each(|&key| uses[key as usize] += 1);
        Self { keys, uses }
    }

    /// The key of an operation whose factor another operation has, too.
    fn shared(&self, k: usize) -> Option<u32> {
        self.keys[k].filter(|&key| self.uses[key as usize] > 1)
    }
}

//! Operations of the dataflow graph, and what they read.

use crate::machine::operation::Code;

/// An operand: a fixed word of storage, or the result of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Operand {
    /// The address of a buffer's word or of a literal.
    Fixed(u32),
    /// The node.
    Node(u32),
}

/// One operation of the engine.
#[derive(Clone, Copy, Debug)]
#[allow(missing_docs)]
pub struct Node {
    pub code: Code,
    /// a, b, c; absent where the operation does not read.
    pub operands: [Option<Operand>; 3],
    /// Architectural location of the result; none: a temporary.
    pub location: Option<u32>,
}

impl Node {
    /// The nodes whose results it reads, one for each operand.
    pub fn sources(&self) -> impl Iterator<Item = u32> + '_ {
        self.operands.iter().flatten().filter_map(|operand| match operand {
            Operand::Node(k) => Some(*k),
            Operand::Fixed(_) => None,
        })
    }
}

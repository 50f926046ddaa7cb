//! Lower bounds of the cycles of any schedule, and the resource that sets them.

use crate::machine::configuration::Configuration;
use crate::stream::edges::Edges;
use crate::stream::graph::{Graph, Operand};

/// Lower bounds of a segment's busy cycles, one for each resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// Every operation but divisions and roots occupies a lane for a cycle.
    pub issue: u32,
    /// The critical path.
    pub dependency: u32,
    /// Every division and root occupies a divider for its interval.
    pub divider: u32,
    /// Every result occupies a write port, every word that is read a read port, for a cycle.
    pub bank: u32,
}

impl Bounds {
    /// Bounds of a graph on an engine, start and end of a segment included.
    pub(crate) fn new(graph: &Graph, edges: &Edges, configuration: &Configuration) -> Self {
        let timing = configuration.timing();
        let around = timing.startup + timing.finish;
        let on_dividers = || graph.nodes.iter().filter(|node| node.code.on_divider());
        let busy: u32 = on_dividers().map(|node| timing.interval(node.code)).sum();
        let lanes = graph.nodes.len() as u32 - on_dividers().count() as u32;
        // From the last issue until its result is in storage.
        let after = |least: u32| if graph.nodes.is_empty() { 0 } else { least + timing.read + timing.write };
        let tail = |count: u32| if count == 0 { 0 } else { count + after(timing.simple) };
        Self {
            issue: around + tail(lanes.div_ceil(configuration.lanes as u32)),
            dependency: around + edges.critical_path(),
            divider: around
                + busy.div_ceil(configuration.dividers as u32)
                + if busy > 0 { after(1) } else { 0 },
            bank: around + tail(bank_cycles(graph, configuration)),
        }
    }

    /// The largest.
    pub fn cycles(&self) -> u32 {
        self.issue.max(self.dependency).max(self.divider).max(self.bank)
    }

    /// Its name.
    pub fn bottleneck(&self) -> &'static str {
        let named = [
            (self.issue, "issue"),
            (self.dependency, "dependency"),
            (self.divider, "divider"),
            (self.bank, "bank"),
        ];
        named.into_iter().rev().max_by_key(|(cycles, _)| *cycles).map_or("issue", |(_, name)| name)
    }
}

/// Cycles for which the busiest bank's port is occupied in any order.
fn bank_cycles(graph: &Graph, configuration: &Configuration) -> u32 {
    let mut written = vec![0u32; configuration.banks];
    let mut words = vec![[0u32; 3]; configuration.banks];
    let mut seen = vec![[false; 3]; graph.words()];
    for node in &graph.nodes {
        if let Some(location) = node.location {
            written[configuration.bank(location)] += 1;
        }
        for (replica, operand) in node.operands.iter().enumerate() {
            // Commutative operations may read a and b from either replica.
            if let (Some(Operand::Fixed(address)), false) = (operand, node.code.commutes() && replica < 2) {
                let known = core::mem::replace(&mut seen[*address as usize][replica], true);
                words[configuration.bank(*address)][replica] += u32::from(!known);
            }
        }
    }
    let evenly = (graph.nodes.len() as u32).div_ceil(configuration.banks as u32);
    let read = words.into_iter().flatten().max().unwrap_or(0);
    written.into_iter().max().unwrap_or(0).max(evenly).max(read)
}

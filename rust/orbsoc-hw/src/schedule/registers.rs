//! Words for results without a home: from their issue to their last reader's.

use super::placement::Place;
use crate::error::Error;
use crate::machine::configuration::Configuration;
use crate::stream::graph::{Graph, Operand};
use std::collections::{BinaryHeap, VecDeque};

/// The address of every result, and how many words of storage are in use. Banks are given, and `order` is that of issue.
///
/// # Errors
/// [`Error::Storage`] when a bank is full.
pub(crate) fn assign_rows(
    segment: &'static str,
    graph: &Graph,
    places: &[Place],
    order: &[u32],
    first: u32,
    configuration: &Configuration,
) -> Result<(Vec<u32>, u32), Error> {
    let mut last = vec![0u32; graph.nodes.len()];
    for (node, place) in graph.nodes.iter().zip(places) {
        for source in node.sources() {
            last[source as usize] = last[source as usize].max(place.cycle);
        }
    }
    let mut pool = Pool::new(configuration, first, graph.nodes.len());
    let mut address = vec![0; graph.nodes.len()];
    for &k in order {
        let (node, place) = (&graph.nodes[k as usize], places[k as usize]);
        let heir = match node.operands[2] {
            Some(Operand::Node(source)) if graph.nodes[source as usize].home.is_none() => {
                let source = source as usize;
                let free = last[source] == place.cycle && graph.uses[source] == 1;
                (free && places[source].bank == place.bank).then_some(source)
            }
            _ => None,
        };
        address[k as usize] = match (node.home, heir) {
            (Some(home), _) => home,
            (None, Some(source)) => {
                pool.taken_over[source] = true;
                address[source]
            }
            (None, None) => pool.take(place.bank, place.cycle).ok_or(Error::Storage {
                needed_by: segment,
                needed: configuration.words() + 1,
                available: configuration.words(),
            })?,
        };
        if node.home.is_none() {
            pool.held.push(core::cmp::Reverse((last[k as usize], k, address[k as usize])));
        }
    }
    Ok((address, pool.highest))
}

/// Free words, bank by bank: fresh ones in rising order, then those that were given back longest ago.
struct Pool {
    limit: u32,
    banks: u32,
    fresh: Vec<u32>,
    returned: Vec<VecDeque<u32>>,
    /// Words in use: the cycle of their last reader, the node that holds them. Those held since the heap was last
    /// looked at stand beside it: as long as there are fresh words, nobody looks.
    leaving: BinaryHeap<core::cmp::Reverse<(u32, u32, u32)>>,
    held: Vec<core::cmp::Reverse<(u32, u32, u32)>>,
    highest: u32,
    /// Nodes whose word went on to the next partial result.
    taken_over: Vec<bool>,
}

impl Pool {
    fn new(configuration: &Configuration, first: u32, nodes: usize) -> Self {
        let banks = configuration.banks as u32;
        Self {
            limit: configuration.words() as u32,
            banks,
            fresh: (0..banks).map(|bank| first + (bank + banks - first % banks) % banks).collect(),
            returned: vec![VecDeque::new(); banks as usize],
            leaving: BinaryHeap::new(),
            held: Vec::new(),
            highest: first,
            taken_over: vec![false; nodes],
        }
    }

    /// A word for a result that is issued in `cycle`.
    fn take(&mut self, bank: u8, cycle: u32) -> Option<u32> {
        let fresh = &mut self.fresh[usize::from(bank)];
        if *fresh < self.limit {
            *fresh += self.banks;
            self.highest = self.highest.max(*fresh - self.banks + 1);
            return Some(*fresh - self.banks);
        }
        self.leaving.extend(self.held.drain(..));
        while let Some(&core::cmp::Reverse((last, node, address))) = self.leaving.peek() {
            // A word that is read for the last time in this very cycle may be its own reader's.
            if last >= cycle {
                break;
            }
            self.leaving.pop();
            if !self.taken_over[node as usize] {
                self.returned[(address % self.banks) as usize].push_back(address);
            }
        }
        self.returned[usize::from(bank)].pop_front()
    }
}

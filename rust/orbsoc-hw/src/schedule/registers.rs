//! Register allocation: words for temporaries, from their issue to that of their last reader.

use super::placement::Place;
use crate::error::Error;
use crate::machine::configuration::Configuration;
use crate::stream::graph::{Graph, Operand};
use core::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

/// The address of every result, one past the highest address in use, and how many words would do, each used again as
/// soon as it is free. Banks are given; `order` is that of issue.
///
/// # Errors
/// [`Error::Storage`] when a bank is full.
pub(crate) fn allocate_registers(
    segment: &'static str,
    graph: &Graph,
    places: &[Place],
    order: &[u32],
    first: u32,
    configuration: &Configuration,
) -> Result<(Vec<u32>, u32, u32), Error> {
    let mut last_read = vec![0u32; graph.nodes.len()];
    for (node, place) in graph.nodes.iter().zip(places) {
        for source in node.sources() {
            last_read[source as usize] = last_read[source as usize].max(place.cycle);
        }
    }
    let mut pool = Pool::new(configuration, first, graph.nodes.len());
    let mut address = vec![0; graph.nodes.len()];
    for &k in order {
        let (node, place) = (&graph.nodes[k as usize], places[k as usize]);
        let reused = match node.operands[2] {
            Some(Operand::Node(source)) if graph.nodes[source as usize].location.is_none() => {
                let source = source as usize;
                let free = last_read[source] == place.cycle && graph.uses[source] == 1;
                (free && places[source].bank == place.bank).then_some(source)
            }
            _ => None,
        };
        address[k as usize] = match (node.location, reused) {
            (Some(location), _) => location,
            (None, Some(source)) => {
                pool.reused[source] = true;
                address[source]
            }
            (None, None) => pool.take(place.bank, place.cycle).ok_or(Error::Storage {
                key: configuration.storage_key(),
                needed_by: segment,
                needed: configuration.words() + 1,
                available: configuration.words(),
            })?,
        };
        if node.location.is_none() {
            pool.recent.push(Reverse((last_read[k as usize], k, address[k as usize])));
        }
    }
    let live =
        graph.nodes.iter().zip(0..).filter(|(node, _)| node.location.is_none()).map(|(_, k): (_, u32)| {
            // A partial sum takes over its predecessor's word in the cycle in which it reads it.
            let k = k as usize;
            (places[k].bank, places[k].cycle, last_read[k] + u32::from(!pool.reused[k]))
        });
    let least = least_words(live, first, configuration.banks as u32);
    Ok((address, pool.end, least))
}

/// Words that hold `first` fixed ones and the live ranges (bank, from, to), each bank with as many rows as the fullest.
fn least_words(live: impl Iterator<Item = (u8, u32, u32)>, first: u32, banks: u32) -> u32 {
    let mut changes: Vec<Vec<(u32, i32)>> = vec![Vec::new(); banks as usize];
    for (bank, from, to) in live {
        // At equal times what ends comes first: -1 sorts below 1.
        changes[usize::from(bank)].extend([(from, 1), (to.max(from + 1), -1)]);
    }
    let rows = changes.into_iter().zip(0..banks).map(|(mut changes, bank)| {
        changes.sort_unstable();
        let (mut count, mut most) = (0, 0);
        for (_, change) in changes {
            count += change;
            most = most.max(count);
        }
        (first + banks - 1 - bank) / banks + most.unsigned_abs()
    });
    banks * rows.max().unwrap_or(0)
}

/// Free words of each bank: unused ones in ascending order, then released ones, oldest first.
struct Pool {
    limit: u32,
    banks: u32,
    unused: Vec<u32>,
    released: Vec<VecDeque<u32>>,
    /// Live ranges by end: the cycle of the last reader, the node, its word.
    live: BinaryHeap<Reverse<(u32, u32, u32)>>,
    /// Live ranges that are not in the heap yet: as long as there are unused words, it is not needed.
    recent: Vec<Reverse<(u32, u32, u32)>>,
    end: u32,
    /// Nodes whose word the next partial sum reuses.
    reused: Vec<bool>,
}

impl Pool {
    fn new(configuration: &Configuration, first: u32, nodes: usize) -> Self {
        let banks = configuration.banks as u32;
        Self {
            limit: configuration.words() as u32,
            banks,
            unused: (0..banks).map(|bank| first + (bank + banks - first % banks) % banks).collect(),
            released: vec![VecDeque::new(); banks as usize],
            live: BinaryHeap::new(),
            recent: Vec::new(),
            end: first,
            reused: vec![false; nodes],
        }
    }

    /// A word for a result that is issued in `cycle`.
    fn take(&mut self, bank: u8, cycle: u32) -> Option<u32> {
        let unused = &mut self.unused[usize::from(bank)];
        if *unused < self.limit {
            *unused += self.banks;
            self.end = self.end.max(*unused - self.banks + 1);
            return Some(*unused - self.banks);
        }
        self.live.extend(self.recent.drain(..));
        while let Some(&Reverse((last_read, node, address))) = self.live.peek() {
            // The last reader itself may have reused the word in this cycle.
            if last_read >= cycle {
                break;
            }
            self.live.pop();
            if !self.reused[node as usize] {
                self.released[(address % self.banks) as usize].push_back(address);
            }
        }
        self.released[usize::from(bank)].pop_front()
    }
}

#[cfg(test)]
mod tests {
    use super::least_words;

    #[test]
    fn a_word_is_used_again_once_it_is_free() {
        // Two banks, three fixed words: two rows in bank 0, one in bank 1.
        assert_eq!(least_words([].into_iter(), 3, 2), 4);
        // One after the other in bank 1: one word more there.
        assert_eq!(least_words([(1, 0, 4), (1, 4, 6)].into_iter(), 3, 2), 4);
        // At the same time: two.
        assert_eq!(least_words([(1, 0, 5), (1, 4, 6)].into_iter(), 3, 2), 6);
        // A result without a reader takes a word in its own cycle.
        assert_eq!(least_words([(0, 7, 0), (0, 7, 0)].into_iter(), 0, 1), 2);
    }
}

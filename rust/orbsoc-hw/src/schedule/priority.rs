//! Priorities of the list schedulers: critical-path length.

use crate::stream::edges::Edges;

/// Nodes in order of priority, and each node's position in that order: longest path to a sink first, then kernel order.
///
/// Priority never increases along an edge: paths get shorter (along an anti-dependence, at least not longer) and node
/// numbers higher.
pub(crate) struct Priorities {
    order: Vec<u32>,
    position: Vec<u32>,
}

impl Priorities {
    /// `nodes_per_cycle`: how many nodes earlier in the kernel weigh as much as one cycle of path length; none: path
    /// length alone decides.
    pub fn new(edges: &Edges, nodes_per_cycle: Option<u32>) -> Self {
        let paths = edges.paths_to_sink();
        let keys: Vec<u32> = match nodes_per_cycle {
            None => paths.to_vec(),
            Some(nodes) => {
                let later = (1..=paths.len() as u32).rev();
                let both = paths.iter().zip(later);
                both.map(|(path, later)| path.saturating_mul(nodes).saturating_add(later)).collect()
            }
        };
        let order = sort_descending(&keys);
        let mut position = vec![0; order.len()];
        order.iter().zip(0..).for_each(|(&k, place)| position[k as usize] = place);
        Self { order, position }
    }

    /// Nodes, the highest priority first.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// A node's position in that order.
    pub fn position(&self, k: u32) -> u32 {
        self.position[k as usize]
    }

    /// The node at a position.
    pub fn node_at(&self, position: u32) -> u32 {
        self.order[position as usize]
    }
}

/// Stable radix sort: indices of the keys, the largest key first.
fn sort_descending(keys: &[u32]) -> Vec<u32> {
    const DIGIT: u32 = 11;
    let largest = keys.iter().copied().max().unwrap_or(0);
    let mut order: Vec<u32> = (0..keys.len() as u32).collect();
    let mut sorted = vec![0; keys.len()];
    let mut shift = 0;
    while shift < u32::BITS && largest >> shift > 0 {
        let digit = |k: u32| ((largest - keys[k as usize]) >> shift) as usize & ((1 << DIGIT) - 1);
        let mut next = [0u32; (1 << DIGIT) + 1];
        for &k in &order {
            next[digit(k) + 1] += 1;
        }
        for value in 0..1 << DIGIT {
            next[value + 1] += next[value];
        }
        for &k in &order {
            let place = &mut next[digit(k)];
            sorted[*place as usize] = k;
            *place += 1;
        }
        core::mem::swap(&mut order, &mut sorted);
        shift += DIGIT;
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_key_comes_first_and_of_equal_ones_the_first() {
        for (count, limit) in [(0, 1), (1, 1), (100, 1), (1000, 7), (5000, 1 << 22), (3000, u32::MAX)] {
            let mut number = 1u32;
            let mut draw = || {
                number = number.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (number ^ number >> 15) % limit
            };
            let keys: Vec<u32> = (0..count).map(|_| draw()).collect();
            let mut expected: Vec<u32> = (0..count).collect();
            expected.sort_by_key(|&k| core::cmp::Reverse(keys[k as usize]));
            assert_eq!(sort_descending(&keys), expected);
        }
    }
}

//! Who goes first.

use crate::stream::edges::Edges;

/// Nodes from the most urgent on, and the place of each among them: first who has the longest way to the end, and of
/// equal ways the earlier one in the kernel; of ways about as long, too, where neighbours shall stay together.
///
/// Urgency decreases along every edge, since ways get shorter (or, from a word's reader to its overwriter, at least
/// not longer) and numbers higher.
pub(crate) struct Urgency {
    order: Vec<u32>,
    rank: Vec<u32>,
}

impl Urgency {
    /// `nodes_per_cycle`: how many nodes earlier in the kernel weigh as much as a cycle more to the end; none: nothing
    /// does.
    pub fn new(edges: &Edges, nodes_per_cycle: Option<u32>) -> Self {
        let paths = edges.paths();
        let urgency: Vec<u32> = match nodes_per_cycle {
            None => paths.to_vec(),
            Some(nodes) => {
                let later = (1..=paths.len() as u32).rev();
                let both = paths.iter().zip(later);
                both.map(|(path, later)| path.saturating_mul(nodes).saturating_add(later)).collect()
            }
        };
        let order = falling(&urgency);
        let mut rank = vec![0; order.len()];
        order.iter().zip(0..).for_each(|(&k, place)| rank[k as usize] = place);
        Self { order, rank }
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
}

/// Positions of keys from the largest key on, of equal keys the first one first: digit by digit.
fn falling(keys: &[u32]) -> Vec<u32> {
    const DIGIT: u32 = 11;
    let most = keys.iter().copied().max().unwrap_or(0);
    let mut order: Vec<u32> = (0..keys.len() as u32).collect();
    let mut sorted = vec![0; keys.len()];
    let mut shift = 0;
    while shift < u32::BITS && most >> shift > 0 {
        let digit = |k: u32| ((most - keys[k as usize]) >> shift) as usize & ((1 << DIGIT) - 1);
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
            assert_eq!(falling(&keys), expected);
        }
    }
}

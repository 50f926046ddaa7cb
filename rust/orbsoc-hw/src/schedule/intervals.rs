//! Busy intervals of a unit that does not take an operation every cycle.

/// Disjoint intervals `[start, end)` in ascending order; adjacent ones are merged.
#[derive(Clone, Debug, Default)]
pub(crate) struct Intervals(Vec<(u32, u32)>);

impl Intervals {
    /// The first cycle from `from` on at which `length` free cycles begin.
    pub fn gap(&self, from: u32, length: u32) -> u32 {
        let mut start = from;
        let first = self.0.partition_point(|&(_, end)| end <= from);
        for &(busy, end) in &self.0[first..] {
            if start + length <= busy {
                break;
            }
            start = end;
        }
        start
    }

    /// Add `start..end`, which is free.
    pub fn take(&mut self, start: u32, end: u32) {
        let at = self.0.partition_point(|&(_, before)| before < start);
        let (mut start, mut end, mut joined) = (start, end, at);
        if self.0.get(joined).is_some_and(|&(_, before)| before == start) {
            start = self.0[joined].0;
            joined += 1;
        }
        if self.0.get(joined).is_some_and(|&(after, _)| after == end) {
            end = self.0[joined].1;
            joined += 1;
        }
        self.0.splice(at..joined, [(start, end)]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_where_nothing_was_taken() {
        let mut busy = Intervals::default();
        assert_eq!(busy.gap(7, 5), 7);
        busy.take(10, 15);
        busy.take(20, 25);
        assert_eq!([busy.gap(0, 10), busy.gap(1, 10), busy.gap(12, 5), busy.gap(12, 6)], [0, 25, 15, 25]);
        busy.take(15, 20);
        assert_eq!(busy.0, [(10, 25)]);
        busy.take(25, 26);
        busy.take(8, 10);
        busy.take(0, 2);
        assert_eq!(busy.0, [(0, 2), (8, 26)]);
        assert_eq!([busy.gap(0, 6), busy.gap(0, 7), busy.gap(26, 1)], [2, 26, 26]);
    }

    /// Against a table of cycles, for taken intervals of any kind.
    #[test]
    fn the_first_gap_is_the_one_that_a_table_shows() {
        for seed in 0..200u32 {
            let (mut busy, mut table) = (Intervals::default(), vec![false; 400]);
            let mut number = seed.wrapping_mul(2_654_435_769) | 1;
            for _ in 0..20 {
                number ^= number << 13;
                number ^= number >> 17;
                number ^= number << 5;
                let (from, length) = (number % 100, 1 + number / 128 % 9);
                let free = |start: u32| (start..start + length).all(|cycle| !table[cycle as usize]);
                let expected = (from..380).find(|&start| free(start)).expect("the table is long enough");
                assert_eq!(busy.gap(from, length), expected);
                busy.take(expected, expected + length);
                table[expected as usize..(expected + length) as usize].fill(true);
            }
        }
    }
}

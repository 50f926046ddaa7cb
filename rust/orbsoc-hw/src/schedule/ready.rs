//! Ready set of the cycle-driven scheduler, by priority.

/// A set of positions below a limit, as a hierarchical bitmap: a bit is set if its 64 bits in the level
/// below are not all zero.
#[derive(Clone, Debug)]
pub(crate) struct ReadySet {
    levels: Vec<Vec<u64>>,
}

impl ReadySet {
    /// An empty set.
    pub fn new(limit: usize) -> Self {
        let mut levels = vec![vec![0; limit.div_ceil(64).max(1)]];
        while levels[levels.len() - 1].len() > 1 {
            let words = levels[levels.len() - 1].len().div_ceil(64);
            levels.push(vec![0; words]);
        }
        Self { levels }
    }

    pub fn insert(&mut self, position: u32) {
        let mut at = position as usize;
        for level in &mut self.levels {
            level[at / 64] |= 1 << (at % 64);
            at /= 64;
        }
    }

    pub fn remove(&mut self, position: u32) {
        let mut at = position as usize;
        for level in &mut self.levels {
            level[at / 64] &= !(1 << (at % 64));
            if level[at / 64] != 0 {
                return;
            }
            at /= 64;
        }
    }

    /// The first position from `from` on.
    pub fn next(&self, from: u32) -> Option<u32> {
        let mut at = from as usize;
        for (depth, level) in self.levels.iter().enumerate() {
            let rest = level.get(at / 64)? & (u64::MAX << (at % 64));
            if rest != 0 {
                at = at / 64 * 64 + rest.trailing_zeros() as usize;
                for below in self.levels[..depth].iter().rev() {
                    at = at * 64 + below[at].trailing_zeros() as usize;
                }
                return Some(at as u32);
            }
            at = at / 64 + 1;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_put_in_comes_out_in_order() {
        for limit in [0, 1, 64, 65, 4096, 4097, 300_000] {
            let mut ready = ReadySet::new(limit);
            assert_eq!(ready.next(0), None);
            let mut positions: Vec<u32> =
                (0..500u64).map(|k| (k * k * 7919 % limit.max(1) as u64) as u32).collect();
            if limit == 0 {
                continue;
            }
            for &position in &positions {
                ready.insert(position);
            }
            positions.sort_unstable();
            positions.dedup();
            let all = core::iter::successors(ready.next(0), |&position| ready.next(position + 1));
            assert_eq!(all.collect::<Vec<_>>(), positions);
            for &position in &positions {
                ready.remove(position);
            }
            assert_eq!(ready.next(0), None);
        }
    }
}

//! The operations that are ready, most urgent first.

/// A set of ranks below a limit. Each level tells of 64 words of the one below whether they are empty.
#[derive(Clone, Debug)]
pub(crate) struct Ready {
    levels: Vec<Vec<u64>>,
}

impl Ready {
    /// An empty set.
    pub fn new(limit: usize) -> Self {
        let mut levels = vec![vec![0; limit.div_ceil(64).max(1)]];
        while levels[levels.len() - 1].len() > 1 {
            let words = levels[levels.len() - 1].len().div_ceil(64);
            levels.push(vec![0; words]);
        }
        Self { levels }
    }

    pub fn insert(&mut self, rank: u32) {
        let mut at = rank as usize;
        for level in &mut self.levels {
            level[at / 64] |= 1 << (at % 64);
            at /= 64;
        }
    }

    pub fn remove(&mut self, rank: u32) {
        let mut at = rank as usize;
        for level in &mut self.levels {
            level[at / 64] &= !(1 << (at % 64));
            if level[at / 64] != 0 {
                return;
            }
            at /= 64;
        }
    }

    /// The first rank from `from` on.
    pub fn next(&self, from: u32) -> Option<u32> {
        let mut at = from as usize;
        for (height, level) in self.levels.iter().enumerate() {
            let rest = level.get(at / 64)? & (u64::MAX << (at % 64));
            if rest != 0 {
                at = at / 64 * 64 + rest.trailing_zeros() as usize;
                for below in self.levels[..height].iter().rev() {
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
            let mut ready = Ready::new(limit);
            assert_eq!(ready.next(0), None);
            let mut ranks: Vec<u32> =
                (0..500u64).map(|k| (k * k * 7919 % limit.max(1) as u64) as u32).collect();
            if limit == 0 {
                continue;
            }
            for &rank in &ranks {
                ready.insert(rank);
            }
            ranks.sort_unstable();
            ranks.dedup();
            let all = core::iter::successors(ready.next(0), |&rank| ready.next(rank + 1));
            assert_eq!(all.collect::<Vec<_>>(), ranks);
            for &rank in &ranks {
                ready.remove(rank);
            }
            assert_eq!(ready.next(0), None);
        }
    }
}

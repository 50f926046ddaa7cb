//! A tile of sums of products, which factorisation spends most of its time on.

#![allow(clippy::needless_range_loop)] // constant ranges over arrays unroll; iterators over them do not always

/// Columns `l` and `y` of `leading_dim` entries, one after the other; a tile takes rows `row..` of `l` and `column..` of `y`.
#[derive(Clone, Copy)]
pub struct Factors<'a, T> {
    /// Columns divided by their pivots.
    pub l: &'a [T],
    /// The same before the division.
    pub y: &'a [T],
    /// Entries of a column.
    pub leading_dim: usize,
    /// Where the tile begins in a column of `l` …
    pub row: usize,
    /// … and of `y`.
    pub column: usize,
}

impl<'a, T: Copy> Factors<'a, T> {
    /// `M` entries of `l` and `N` of `y` to `each`, column by column. By hand: the library's iterators over two
    /// lists of chunks divide to count them, and become calls where the kernel around them is large. A tile that lies
    /// within its columns, and lists of one length, leave one comparison a column.
    #[inline(always)]
    pub fn pairs<const M: usize, const N: usize>(self, mut each: impl FnMut(&'a [T; M], &'a [T; N])) {
        let Self { l, y, leading_dim, row, column } = self;
        if row + M > leading_dim || column + N > leading_dim {
            return;
        }
        let (mut l, mut y) = (l, &y[..l.len()]);
        while let (Some((l_column, l_rest)), Some((y_column, y_rest))) =
            (l.split_at_checked(leading_dim), y.split_at_checked(leading_dim))
        {
            let (Some(entries), Some(factors)) =
                (l_column[row..].first_chunk(), y_column[column..].first_chunk())
            else {
                return;
            };
            each(entries, factors);
            (l, y) = (l_rest, y_rest);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::scalar::{accumulate, subtract, subtract_multiple, Real};
    use super::*;
    use crate::tests::reference::SplitMix64;

    /// What the datapath makes of a tile, and what the plain loops do: the bits of the entries asked for.
    fn both<const M: usize, const N: usize, const LOWER: bool>(seed: u64, columns: usize) -> [Vec<u64>; 2] {
        const HEIGHT: usize = 13;
        let mut numbers = SplitMix64(seed);
        let (l, y) = (numbers.list(columns * HEIGHT), numbers.list(columns * HEIGHT));
        let factors = Factors { l: &l, y: &y, leading_dim: HEIGHT, row: 5, column: 3 };
        let flat = numbers.list(M * N);
        let mut entries = [[0.0; M]; N];
        for n in 0..N {
            entries[n].copy_from_slice(&flat[n * M..][..M]);
        }
        let mut plain = entries;
        f64::subtract_products::<M, N, LOWER>(&mut entries, factors);
        subtract::<f64, M, N, LOWER>(&mut plain, factors);
        [entries, plain].map(|entries| {
            let asked = |n: usize| entries[n][if LOWER { n } else { 0 }..].iter();
            (0..N).flat_map(|n| asked(n).map(|w| w.to_bits()).collect::<Vec<_>>()).collect()
        })
    }

    #[test]
    fn a_quicker_way_changes_no_bit() {
        for columns in [0, 1, 2, 7, 40] {
            for seed in 0..20 {
                for [found, expected] in [
                    both::<4, 4, false>(seed, columns),
                    both::<4, 4, true>(seed, columns),
                    both::<8, 4, false>(seed, columns),
                    both::<4, 1, false>(seed, columns),
                    both::<1, 4, false>(seed, columns),
                    both::<1, 1, false>(seed, columns),
                    both::<2, 2, false>(seed, columns),
                ] {
                    assert_eq!(found, expected, "{columns} columns, seed {seed}");
                }
            }
        }
    }

    #[test]
    fn a_quicker_multiple_of_two_vectors_changes_no_bit() {
        let mut numbers = SplitMix64(23);
        for len in 0..40 {
            let (by, x) = (numbers.list(len), [numbers.signed(), numbers.signed()]);
            let entries: Vec<[f64; 2]> = (0..len).map(|_| [numbers.signed(), numbers.signed()]).collect();
            let (mut quick, mut plain) = (entries.clone(), entries);
            f64::subtract_multiple(&mut quick, &by, x);
            subtract_multiple(&mut plain, &by, x);
            let bits = |entries: &[[f64; 2]]| entries.iter().map(|w| w.map(f64::to_bits)).collect::<Vec<_>>();
            assert_eq!(bits(&quick), bits(&plain), "{len} words");
        }
    }

    #[test]
    fn quicker_sums_change_no_bit() {
        fn both<const R: usize>(numbers: &mut SplitMix64, len: usize) -> [Vec<u64>; 2] {
            let a: Vec<[f64; 8]> = (0..len).map(|_| [0.0; 8].map(|_: f64| numbers.signed())).collect();
            let x: Vec<[[f64; R]; 8]> =
                (0..len).map(|_| [[0.0; R]; 8].map(|x| x.map(|_: f64| numbers.signed()))).collect();
            let mut quick = [[0.0; R]; 8].map(|x| x.map(|_: f64| numbers.signed()));
            let mut plain = quick;
            f64::accumulate(&mut quick, &a, &x);
            accumulate(&mut plain, &a, &x);
            [quick, plain].map(|sums| sums.as_flattened().iter().map(|v| v.to_bits()).collect())
        }
        let mut numbers = SplitMix64(29);
        for len in 0..6 {
            for [quick, plain] in [both::<1>(&mut numbers, len), both::<2>(&mut numbers, len)] {
                assert_eq!(quick, plain, "{len} times eight");
            }
        }
    }

    /// One product of a lone column: no rounding of the product may be lost in a fused operation.
    #[test]
    fn products_are_rounded_before_they_are_subtracted() {
        let a = 1.0 + 2f64.powi(-30);
        let (l, y) = ([a; 4], [a; 4]);
        let mut entries = [[1.0 + 2f64.powi(-29); 4]; 4];
        f64::subtract_products::<4, 4, false>(
            &mut entries,
            Factors { l: &l, y: &y, leading_dim: 4, row: 0, column: 0 },
        );
        assert_eq!(entries, [[0.0; 4]; 4]);
    }
}

//! A tile of sums of products, which factorisation spends most of its time on.

#![allow(clippy::needless_range_loop)] // constant ranges over arrays unroll; iterators over them do not always

use super::Real;

/// Columns `l` and `y` of `height` words, one after the other; a tile takes rows `row..` of `l` and `column..` of `y`.
#[derive(Clone, Copy)]
pub struct Factors<'a, T> {
    /// Columns divided by their pivots.
    pub l: &'a [T],
    /// The same before the division.
    pub y: &'a [T],
    /// Words of a column.
    pub height: usize,
    /// Where the tile begins in a column of `l` …
    pub row: usize,
    /// … and of `y`.
    pub column: usize,
}

impl<'a, T: Copy> Factors<'a, T> {
    /// `M` words of `l` and `N` of `y`, column by column.
    #[inline(always)]
    pub fn pairs<const M: usize, const N: usize>(self) -> impl Iterator<Item = (&'a [T; M], &'a [T; N])> {
        let Self { l, y, height, row, column } = self;
        let columns = l.chunks_exact(height).zip(y.chunks_exact(height));
        columns.filter_map(move |(l, y)| l[row..].first_chunk().zip(y[column..].first_chunk()))
    }
}

/// `words[n][m] −= Σ_k l_k[m]·y_k[n]`, the k in order, each product rounded. With `LOWER`, only the words of
/// m ≥ n are asked for, and the others come out as anything.
#[inline(always)]
pub fn subtract<T: Real, const M: usize, const N: usize, const LOWER: bool>(
    words: &mut [[T; M]; N],
    factors: Factors<T>,
) {
    for (l, y) in factors.pairs::<M, N>() {
        for n in 0..N {
            let mut column = words[n];
            for m in if LOWER { n } else { 0 }..M {
                column[m] = column[m].sub_mul(l[m], y[n]);
            }
            words[n] = column;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::Numbers;

    /// What the datapath makes of a tile, and what the plain loops do: the bits of the words asked for.
    fn both<const M: usize, const N: usize, const LOWER: bool>(seed: u64, columns: usize) -> [Vec<u64>; 2] {
        const HEIGHT: usize = 9;
        let mut numbers = Numbers(seed);
        let (l, y) = (numbers.list(columns * HEIGHT), numbers.list(columns * HEIGHT));
        let factors = Factors { l: &l, y: &y, height: HEIGHT, row: 5, column: 3 };
        let flat = numbers.list(M * N);
        let mut words = [[0.0; M]; N];
        for n in 0..N {
            words[n].copy_from_slice(&flat[n * M..][..M]);
        }
        let mut plain = words;
        f64::subtract_products::<M, N, LOWER>(&mut words, factors);
        subtract::<f64, M, N, LOWER>(&mut plain, factors);
        [words, plain].map(|words| {
            let asked = |n: usize| words[n][if LOWER { n } else { 0 }..].iter();
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

    /// One product of a lone column: no rounding of the product may be lost in a fused operation.
    #[test]
    fn products_are_rounded_before_they_are_subtracted() {
        let a = 1.0 + 2f64.powi(-30);
        let (l, y) = ([a; 4], [a; 4]);
        let mut words = [[1.0 + 2f64.powi(-29); 4]; 4];
        f64::subtract_products::<4, 4, false>(
            &mut words,
            Factors { l: &l, y: &y, height: 4, row: 0, column: 0 },
        );
        assert_eq!(words, [[0.0; 4]; 4]);
    }
}

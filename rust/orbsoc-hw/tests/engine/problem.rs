//! Random problems with every kind of block, for the tests of this crate.

use orbsoc::{Cones, Csc, Problem};

struct SplitMix64(u64);

impl SplitMix64 {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    fn sparse(&mut self, rows: usize, columns: usize, density: f64) -> Csc {
        let entry = |this: &mut Self| if this.unit() < density { this.signed() } else { 0.0 };
        let dense: Vec<Vec<f64>> = (0..rows).map(|_| (0..columns).map(|_| entry(self)).collect()).collect();
        Csc::from_dense(&dense.iter().map(Vec::as_slice).collect::<Vec<_>>(), columns)
    }
}

fn times(matrix: &Csc, x: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; matrix.nrows()];
    matrix.triplets().for_each(|(i, j, value)| out[i] += value * x[j]);
    out
}

/// A strictly feasible, bounded problem: P, A, `l` rows, cones of dimensions `q`.
pub fn problem(seed: u64, n: usize, p: usize, l: usize, q: &[usize]) -> Problem {
    let cones = Cones { l, q: q.to_vec() };
    let mut numbers = SplitMix64(seed);
    let (a, g) = (numbers.sparse(p, n, 0.6), numbers.sparse(cones.dim(), n, 0.5));
    let diagonal: Vec<Vec<f64>> =
        (0..n).map(|i| (0..n).map(|j| if i == j { 0.5 } else { 0.0 }).collect()).collect();
    let cost = Csc::from_dense(&diagonal.iter().map(Vec::as_slice).collect::<Vec<_>>(), n);
    let x: Vec<f64> = (0..n).map(|_| numbers.signed()).collect();
    let mut h = times(&g, &x);
    let heads = (0..l).chain(q.iter().scan(l, |start, dim| {
        *start += dim;
        Some(*start - dim)
    }));
    heads.for_each(|i| h[i] += 1.0);
    let (b, c) = (times(&a, &x), (0..n).map(|_| numbers.signed()).collect());
    Problem::new(Some(cost), c, Some(a), b, Some(g), h, cones).expect("sizes fit")
}

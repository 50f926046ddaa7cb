//! What the tests of this crate compare with: points, products and matrices made the slow, plain way.

use crate::kernels::cone_ops;
use crate::kkt::assembly::{Kkt, SOC_DENSE_MAX};
use crate::method::stage::{ITERATION, STARTUP};
use crate::problem::cones::{ConeLayout, Soc};
use crate::problem::Csc;
use crate::{Compiled, Cones, Engine, Problem, Real};
use nalgebra::DMatrix;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// The same cases in every run; with `ORBSOC_FUZZ` = k in the environment, k times as many new ones: more in
/// `make fuzz`, and under valgrind (`make memcheck`), where each takes fifty times as long, a fraction.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a number of cases, and at least one
pub fn seeded(cases: u32) -> ProptestConfig {
    let times: Option<f64> = std::env::var("ORBSOC_FUZZ").ok().and_then(|k| k.parse().ok());
    let rng_seed = if times.is_some() { RngSeed::Random } else { RngSeed::Fixed(47) };
    let cases = (f64::from(cases) * times.unwrap_or(1.0)).ceil().max(1.0) as u32;
    ProptestConfig { cases, rng_seed, failure_persistence: None, ..Default::default() }
}

/// SplitMix64 for inputs that need no shrinking (SplitMix64).
pub struct SplitMix64(pub u64);

impl SplitMix64 {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in [−1, 1).
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    pub fn list(&mut self, len: usize) -> Vec<f64> {
        (0..len).map(|_| self.signed()).collect()
    }

    /// A dense matrix in which a fraction `density` of the entries is stored.
    pub fn sparse(&mut self, rows: usize, columns: usize, density: f64) -> Csc {
        let mut dense = vec![vec![0.0; columns]; rows];
        for entry in dense.iter_mut().flatten() {
            if self.unit() < density {
                *entry = self.signed();
            }
        }
        Csc::from_dense(&dense.iter().map(Vec::as_slice).collect::<Vec<_>>(), columns)
    }
}

/// Cones of `dims` behind `l` nonnegative rows, with expansion rows where the engine has them.
pub fn layout(l: usize, dims: &[usize]) -> ConeLayout {
    let m = l + dims.iter().sum::<usize>();
    let (mut start, mut extra, mut soc) = (l, m, Vec::new());
    for &dim in dims {
        let expansion = (dim > SOC_DENSE_MAX).then_some(extra);
        extra += 2 * usize::from(expansion.is_some());
        soc.push(Soc { start, dim, expansion });
        start += dim;
    }
    ConeLayout { l, soc }
}

pub fn norm(v: &[f64]) -> f64 {
    v.iter().map(|v| v * v).sum::<f64>().sqrt()
}

pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Least distance-like margin over all cones: the row itself, or v₀ − ‖v₁‖.
pub fn margin(cones: &ConeLayout, v: &[f64]) -> f64 {
    let orthant = v[..cones.l].iter().copied();
    let soc = cones.soc.iter().map(|soc| v[soc.start] - norm(&v[soc.rows()][1..]));
    orthant.chain(soc).fold(f64::INFINITY, f64::min)
}

/// a ∘ b.
pub fn jordan(cones: &ConeLayout, a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut out: Vec<f64> = a.iter().zip(b).map(|(a, b)| a * b).collect();
    for soc in &cones.soc {
        let (a, b) = (&a[soc.rows()], &b[soc.rows()]);
        out[soc.start] = dot(a, b);
        for i in 1..soc.dim {
            out[soc.start + i] = a[0] * b[i] + b[0] * a[i];
        }
    }
    out
}

/// A point inside a second-order cone: its relative margin is 10^`nearest` … 1, its size 1e±3.
pub fn inside(dim: usize, nearest: f64) -> impl Strategy<Value = Vec<f64>> {
    (vec(-1.0..1.0f64, dim - 1), nearest..0.0, -3.0..3.0).prop_map(|(tail, near, size)| {
        let size = 10f64.powf(size);
        let head = (norm(&tail) * (1.0 + 10f64.powf(near))).max(1e-3);
        core::iter::once(head).chain(tail).map(|v| size * v).collect()
    })
}

/// Points s and z inside one product of cones.
#[derive(Clone, Debug)]
pub struct Pair {
    pub cones: ConeLayout,
    pub s: Vec<f64>,
    pub z: Vec<f64>,
}

/// Up to four nonnegative rows and three second-order cones of sizes 1 to 16.
pub fn pairs(nearest: f64) -> impl Strategy<Value = Pair> {
    (0usize..=4, vec(1usize..=16, 0..=3)).prop_flat_map(move |(l, dims)| {
        let cones = layout(l, &dims);
        let point = || {
            let cones = dims.iter().map(|&dim| inside(dim, nearest)).collect::<Vec<_>>();
            (vec(-3.0..3.0f64, l), cones).prop_map(|(rows, cones)| {
                rows.into_iter()
                    .map(|e| 10f64.powf(e))
                    .chain(cones.into_iter().flatten())
                    .collect::<Vec<f64>>()
            })
        };
        (point(), point()).prop_map(move |(s, z)| Pair { cones: cones.clone(), s, z })
    })
}

/// Nesterov–Todd scaling at (s, z), as the kernel makes it.
pub struct Scaling<T> {
    pub w: Vec<T>,
    pub lambda: Vec<T>,
    pub lambda_inverse: Vec<T>,
    pub cone: Vec<T>,
}

pub fn scaling<T: Real>(cones: &ConeLayout, s: &[T], z: &[T]) -> Scaling<T> {
    let zeros = |len| vec![T::zero(); len];
    let (mut w, mut lambda, mut lambda_inverse) = (zeros(s.len()), zeros(s.len()), zeros(cones.l));
    let mut cone = zeros(cones.soc.len() * cone_ops::SCALARS);
    cone_ops::nt_scaling(cones, s, z, &mut w, &mut lambda, &mut lambda_inverse, &mut cone);
    Scaling { w, lambda, lambda_inverse, cone }
}

/// A KKT matrix's values, dense, in natural order (x, y, z, expansion rows).
pub fn dense(kkt: &Kkt, values: &[f64]) -> DMatrix<f64> {
    let mut natural = vec![0; kkt.dim];
    kkt.position.iter().enumerate().for_each(|(old, &new)| natural[new as usize] = old);
    let mut out = DMatrix::zeros(kkt.dim, kkt.dim);
    for j in 0..kkt.dim {
        for k in kkt.colptr[j] as usize..kkt.colptr[j + 1] as usize {
            let (i, j) = (natural[kkt.rowidx[k] as usize], natural[j]);
            out[(i, j)] = values[k];
            out[(j, i)] = values[k];
        }
    }
    out
}

/// A strictly feasible, bounded problem with every kind of block: P, A, rows, cones of sizes 3 and 6.
pub fn mixed_problem(seed: u64) -> Problem {
    let (n, p, cones) = (8, 2, Cones { l: 5, q: vec![3, 6] });
    let mut numbers = SplitMix64(seed);
    let (a, g) = (numbers.sparse(p, n, 0.7), numbers.sparse(cones.dim(), n, 0.6));
    let diagonal: Vec<Vec<f64>> =
        (0..n).map(|i| (0..n).map(|j| if i == j { 0.5 } else { 0.0 }).collect()).collect();
    let cost = Csc::from_dense(&diagonal.iter().map(Vec::as_slice).collect::<Vec<_>>(), n);
    let x = numbers.list(n);
    let times = |matrix: &Csc, x: &[f64]| {
        let mut out = vec![0.0; matrix.nrows()];
        matrix.triplets().for_each(|(i, j, v)| out[i] += v * x[j]);
        out
    };
    let mut h = times(&g, &x);
    let heads = [0, 1, 2, 3, 4, 5, 8];
    for i in heads {
        h[i] += 1.0;
    }
    let (b, c) = (times(&a, &x), numbers.list(n));
    Problem::new(Some(cost), c, Some(a), b, Some(g), h, cones).expect("sizes fit")
}

/// Run STARTUP and then `iterations` whole iterations.
pub fn iterate_from_startup<T: Compiled>(engine: &mut Engine<T>, iterations: usize) {
    let lists = core::iter::once(STARTUP).chain(core::iter::repeat_n(ITERATION, iterations));
    for step in lists.flatten() {
        step.perform(&mut |stage| engine.run(stage));
    }
}

//! Loops over tiles on NEON: the compiler finds vectors of two by itself only where the entries lie side by side.

use super::tiles::Factors;
use core::arch::aarch64::float64x2_t;
use pulp::{aarch64::Neon, cast};

/// A tile of rows as vectors of two. A macro, as a function of that many vectors keeps its sums in memory (decision 0010).
macro_rules! rows_in_vectors {
    ($name:ident, $rows:literal, [$($vector:literal),+]) => {
        #[inline(always)]
        pub fn $name<const M: usize, const N: usize>(
            simd: Neon,
            entries: &mut [[f64; M]; N],
            factors: Factors<f64>,
        ) {
            let two = |w: [f64; M], v: usize| -> float64x2_t { cast([w[2 * v], w[2 * v + 1]]) };
            let mut sums = entries.map(|w| [$(two(w, $vector)),+]);
            factors.pairs::<$rows, N>(
                #[inline(always)]
                |l, y| {
                    let l: [float64x2_t; $rows / 2] = cast(*l);
                    for n in 0..N {
                        $(sums[n][$vector] = minus(simd, sums[n][$vector], l[$vector], y[n]);)+
                    }
                },
            );
            for (entries, sum) in entries.iter_mut().zip(sums) {
                entries.copy_from_slice(&cast::<[float64x2_t; $rows / 2], [f64; $rows]>(sum));
            }
        }
    };
}
rows_in_vectors! { four_rows, 4, [0, 1] }
rows_in_vectors! { eight_rows, 8, [0, 1, 2, 3] }

/// `sum − l·y`, two roundings.
#[inline(always)]
fn minus(simd: Neon, sum: float64x2_t, l: float64x2_t, y: f64) -> float64x2_t {
    simd.neon.vsubq_f64(sum, simd.neon.vmulq_n_f64(l, y))
}

/// `sum + a·x`, two roundings.
#[inline(always)]
fn plus(simd: Neon, sum: float64x2_t, a: float64x2_t, x: float64x2_t) -> float64x2_t {
    simd.neon.vaddq_f64(sum, simd.neon.vmulq_f64(a, x))
}

/// Four columns of one row in two registers.
#[inline(always)]
pub fn four_columns<const M: usize, const N: usize>(
    simd: Neon,
    entries: &mut [[f64; M]; N],
    factors: Factors<f64>,
) {
    let mut low: float64x2_t = cast([entries[0][0], entries[1][0]]);
    let mut high: float64x2_t = cast([entries[2][0], entries[3][0]]);
    factors.pairs::<1, 4>(
        #[inline(always)]
        |&[l], &y| {
            let [y_low, y_high]: [float64x2_t; 2] = cast(y);
            low = minus(simd, low, y_low, l);
            high = minus(simd, high, y_high, l);
        },
    );
    for (entry, sum) in entries.iter_mut().zip(cast::<[float64x2_t; 2], [f64; 4]>([low, high])) {
        entry[0] = sum;
    }
}

/// Eight sums in four registers.
#[inline(always)]
pub fn accumulate_one(simd: Neon, sums: &mut [[f64; 8]], a: &[[f64; 8]], x: &[[f64; 8]]) {
    let Some(sums) = sums.first_mut() else { return };
    let [mut s0, mut s1, mut s2, mut s3]: [float64x2_t; 4] = cast(*sums);
    for (&a, &x) in a.iter().zip(x) {
        let (a, x): ([float64x2_t; 4], [float64x2_t; 4]) = (cast(a), cast(x));
        s0 = plus(simd, s0, a[0], x[0]);
        s1 = plus(simd, s1, a[1], x[1]);
        s2 = plus(simd, s2, a[2], x[2]);
        s3 = plus(simd, s3, a[3], x[3]);
    }
    *sums = cast([s0, s1, s2, s3]);
}

/// Eight sums of either of two vectors side by side, in eight registers.
#[inline(always)]
pub fn accumulate_two(simd: Neon, sums: &mut [[f64; 16]], a: &[[f64; 8]], x: &[[f64; 16]]) {
    let Some(sums) = sums.first_mut() else { return };
    let mut entries: [float64x2_t; 8] = cast(*sums);
    for (a, &x) in a.iter().zip(x) {
        let x: [float64x2_t; 8] = cast(x);
        for k in 0..8 {
            entries[k] = simd.neon.vaddq_f64(entries[k], simd.neon.vmulq_n_f64(x[k], a[k]));
        }
    }
    *sums = cast(entries);
}

/// Of two vectors side by side, an entry of either: a register.
#[inline(always)]
pub fn multiple_of_two(simd: Neon, entries: &mut [[f64; 2]], by: &[f64], x: [f64; 2]) {
    let x: float64x2_t = cast(x);
    for (entries, &by) in entries.iter_mut().zip(by) {
        *entries = cast(minus(simd, cast(*entries), x, by));
    }
}

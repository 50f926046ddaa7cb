//! Every dot product, norm and sum. The association is fixed here, once: below `WAYS` terms left to
//! right, from there on `WAYS` accumulators (term k goes to accumulator k mod `WAYS`) folded as a
//! balanced tree. The tree is what SIMD registers compute anyway, and it shortens the critical path.

#![allow(clippy::redundant_closure_for_method_calls)] // a function passed by name is called, not inlined

use crate::real::Real;

const WAYS: usize = 8;

/// Reduce `first(k)`, then `accumulate(sum, k)` over k < `len`, with `join` between accumulators; `empty`
/// when there are no terms.
#[inline(always)]
fn reduce<V: Copy>(
    len: usize,
    empty: V,
    first: impl Fn(usize) -> V,
    accumulate: impl Fn(V, usize) -> V,
    join: impl Fn(V, V) -> V,
) -> V {
    if len == 0 {
        return empty;
    }
    if len < WAYS {
        let mut sum = first(0);
        for k in 1..len {
            sum = accumulate(sum, k);
        }
        return sum;
    }
    let mut sums: [V; WAYS] =
        [first(0), first(1), first(2), first(3), first(4), first(5), first(6), first(7)];
    let whole = len - len % WAYS;
    for base in (WAYS..whole).step_by(WAYS) {
        for (way, sum) in sums.iter_mut().enumerate() {
            *sum = accumulate(*sum, base + way);
        }
    }
    for k in whole..len {
        sums[k - whole] = accumulate(sums[k - whole], k);
    }
    let [a, b, c, d, e, f, g, h] = sums;
    join(join(join(a, e), join(c, g)), join(join(b, f), join(d, h)))
}

/// aᵀb.
#[inline(always)]
pub fn dot<T: Real>(a: &[T], b: &[T]) -> T {
    let b = &b[..a.len()];
    reduce(
        a.len(),
        T::zero(),
        #[inline(always)]
        |k| a[k] * b[k],
        #[inline(always)]
        |sum, k| sum.add_mul(a[k], b[k]),
        #[inline(always)]
        |x, y| x + y,
    )
}

/// Σ values[k]·x[index[k]].
#[inline(always)]
pub fn dot_indexed<T: Real>(values: &[T], index: &[u32], x: &[T]) -> T {
    let index = &index[..values.len()];
    reduce(
        values.len(),
        T::zero(),
        #[inline(always)]
        |k| values[k] * x[index[k] as usize],
        #[inline(always)]
        |sum, k| sum.add_mul(values[k], x[index[k] as usize]),
        #[inline(always)]
        |x, y| x + y,
    )
}

/// ‖x‖₂.
#[inline(always)]
pub fn norm2<T: Real>(x: &[T]) -> T {
    dot(x, x).sqrt()
}

/// max |x_k|; zero for no terms.
#[inline(always)]
pub fn max_abs<T: Real>(x: &[T]) -> T {
    reduce(
        x.len(),
        T::zero(),
        #[inline(always)]
        |k| x[k].abs(),
        #[inline(always)]
        |top, k| top.max(x[k].abs()),
        #[inline(always)]
        |a, b| a.max(b),
    )
}

/// max |x_k| of each of `R` vectors side by side.
#[inline(always)]
pub fn max_abs_of<T: Real, const R: usize>(x: &[[T; R]]) -> [T; R] {
    if R == 1 {
        return [max_abs(x.as_flattened()); R];
    }
    reduce(
        x.len(),
        [T::zero(); R],
        #[inline(always)]
        |k| magnitudes(x[k]),
        #[inline(always)]
        |top, k| larger_of(top, magnitudes(x[k])),
        #[inline(always)]
        |a, b| larger_of(a, b),
    )
}

#[inline(always)]
fn magnitudes<T: Real, const R: usize>(mut words: [T; R]) -> [T; R] {
    for word in &mut words {
        *word = word.abs();
    }
    words
}

#[inline(always)]
fn larger_of<T: Real, const R: usize>(mut a: [T; R], b: [T; R]) -> [T; R] {
    for r in 0..R {
        a[r] = a[r].max(b[r]);
    }
    a
}

/// max |weight_k·x_k|.
#[inline(always)]
pub fn max_abs_weighted<T: Real>(weight: &[T], x: &[T]) -> T {
    let x = &x[..weight.len()];
    reduce(
        weight.len(),
        T::zero(),
        #[inline(always)]
        |k| (weight[k] * x[k]).abs(),
        #[inline(always)]
        |top, k| top.max((weight[k] * x[k]).abs()),
        #[inline(always)]
        |a, b| a.max(b),
    )
}

/// Σ |weight_k·x_k|.
#[inline(always)]
pub fn sum_abs_weighted<T: Real>(weight: &[T], x: &[T]) -> T {
    let x = &x[..weight.len()];
    reduce(
        weight.len(),
        T::zero(),
        #[inline(always)]
        |k| (weight[k] * x[k]).abs(),
        #[inline(always)]
        |sum, k| sum + (weight[k] * x[k]).abs(),
        #[inline(always)]
        |a, b| a + b,
    )
}

/// max −x_k·y_k over k, with zero among the candidates.
#[inline(always)]
pub fn max_negative_product<T: Real>(x: &[T], y: &[T]) -> T {
    let y = &y[..x.len()];
    reduce(
        x.len(),
        T::zero(),
        #[inline(always)]
        |k| T::zero().max(-(x[k] * y[k])),
        #[inline(always)]
        |top, k| top.max(-(x[k] * y[k])),
        #[inline(always)]
        |a, b| a.max(b),
    )
}

/// Σ 0·x_k: zero when every entry is finite, NaN otherwise.
#[inline(always)]
pub fn finite_witness<T: Real>(x: &[T]) -> T {
    reduce(
        x.len(),
        T::zero(),
        #[inline(always)]
        |k| x[k] * T::zero(),
        #[inline(always)]
        |sum, k| sum.add_mul(x[k], T::zero()),
        #[inline(always)]
        |a, b| a + b,
    )
}

/// [`finite_witness`] of each of `R` vectors side by side.
#[inline(always)]
pub fn finite_witness_of<T: Real, const R: usize>(x: &[[T; R]]) -> [T; R] {
    if R == 1 {
        return [finite_witness(x.as_flattened()); R];
    }
    reduce(
        x.len(),
        [T::zero(); R],
        #[inline(always)]
        |k| add_zeros([T::zero(); R], x[k]),
        #[inline(always)]
        |sum, k| add_zeros(sum, x[k]),
        #[inline(always)]
        |mut a, b| {
            for r in 0..R {
                a[r] = a[r] + b[r];
            }
            a
        },
    )
}

#[inline(always)]
fn add_zeros<T: Real, const R: usize>(mut sum: [T; R], words: [T; R]) -> [T; R] {
    for r in 0..R {
        sum[r] = sum[r].add_mul(words[r], T::zero());
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::Numbers;

    const SIZES: core::ops::RangeInclusive<usize> = 0..=64;

    /// The association of the file's first paragraph, written down a second time.
    fn tree(terms: &[f64]) -> f64 {
        match terms.len() {
            0 => 0.0,
            1..WAYS => terms.iter().copied().reduce(|a, b| a + b).unwrap(),
            _ => {
                let mut sums: Vec<f64> = (0..WAYS)
                    .map(|way| terms[way..].iter().step_by(WAYS).copied().reduce(|a, b| a + b).unwrap())
                    .collect();
                for half in [4, 2, 1] {
                    for k in 0..half {
                        sums[k] += sums[k + half];
                    }
                }
                sums[0]
            }
        }
    }

    /// Products of binary32 words are exact in binary64, and so is, to 2⁻²⁹ of the bound, their sum.
    #[test]
    #[allow(clippy::cast_possible_truncation)] // makes binary32 words
    fn dots_are_the_exact_sum_within_the_bound_of_their_longest_path() {
        let mut numbers = Numbers(3);
        for len in SIZES.chain([300, 1001]) {
            let mut list = || numbers.list(len).into_iter().map(|v| v as f32).collect::<Vec<_>>();
            let (a, b) = (list(), list());
            let exact: f64 = a.iter().zip(&b).map(|(&a, &b)| f64::from(a) * f64::from(b)).sum();
            let size: f64 = a.iter().zip(&b).map(|(&a, &b)| (f64::from(a) * f64::from(b)).abs()).sum();
            let path = if len < WAYS { len } else { len.div_ceil(WAYS) + 3 };
            let unit_roundoff = f64::from(f32::EPSILON) / 2.0;
            let bound = 1.01 * (path + 1) as f64 * unit_roundoff * size;
            assert!((f64::from(dot(&a, &b)) - exact).abs() <= bound, "{len} terms");
        }
    }

    #[test]
    fn sums_of_whole_numbers_are_exact() {
        for len in SIZES {
            let a: Vec<f64> = (0..len).map(|k| (k % 7) as f64 - 3.0).collect();
            let b: Vec<f64> = (0..len).map(|k| (k % 5) as f64 + 1.0).collect();
            let exact: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
            assert_eq!(dot(&a, &b), exact);
            let absolute: f64 = a.iter().zip(&b).map(|(a, b)| (a * b).abs()).sum();
            assert_eq!(sum_abs_weighted(&a, &b), absolute);
        }
    }

    #[test]
    fn the_order_of_summation_depends_on_the_length_alone() {
        let mut numbers = Numbers(5);
        for len in SIZES.chain([300]) {
            let (a, b) = (numbers.list(len), numbers.list(len));
            let terms: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a * b).collect();
            let expected = tree(&terms).to_bits();
            // Wherever the words lie in memory, gathered or not, on whatever instruction set.
            for offset in 0..4 {
                let pad = |v: &[f64]| [vec![9.0; offset], v.to_vec()].concat();
                let (a, b) = (pad(&a), pad(&b));
                assert_eq!(dot(&a[offset..], &b[offset..]).to_bits(), expected);
            }
            let reversed: Vec<f64> = b.iter().rev().copied().collect();
            let index: Vec<u32> = (0..len).rev().map(crate::symbolic::index).collect();
            assert_eq!(dot_indexed(&a, &index, &reversed).to_bits(), expected);
            assert_eq!(pulp::Arch::new().dispatch(|| dot(&a, &b)).to_bits(), expected);
            assert_eq!(norm2(&a).to_bits(), dot(&a, &a).sqrt().to_bits());
        }
    }

    #[test]
    fn maxima_are_the_largest_term_wherever_it_stands() {
        let mut numbers = Numbers(7);
        for len in SIZES.skip(1) {
            for at in 0..len {
                let mut a = numbers.list(len);
                a[at] = -2.0;
                assert_eq!(max_abs(&a), 2.0);
                assert_eq!(max_abs_weighted(&vec![-3.0; len], &a), 6.0);
                assert_eq!(max_negative_product(&a, &vec![4.0; len]), 8.0);
            }
            assert_eq!(max_negative_product(&vec![1.0; len], &vec![1.0; len]), 0.0);
        }
        assert_eq!((max_abs::<f64>(&[]), max_negative_product::<f64>(&[], &[])), (0.0, 0.0));
    }

    #[test]
    fn a_maximum_drops_nan_and_the_finite_witness_does_not() {
        for len in SIZES.skip(1) {
            for at in 0..len {
                let mut a = vec![1.0; len];
                a[at] = f64::NAN;
                // Dropped wherever it is not an accumulator's first term.
                let kept = at == 0 || (len >= WAYS && at < WAYS);
                if !kept {
                    assert_eq!(max_abs(&a), 1.0, "entry {at} of {len}");
                }
                assert!(finite_witness(&a).is_nan());
                a[at] = f64::NEG_INFINITY;
                assert!(finite_witness(&a).is_nan());
                a[at] = -1e300;
                assert_eq!(finite_witness(&a), 0.0);
            }
        }
    }
}

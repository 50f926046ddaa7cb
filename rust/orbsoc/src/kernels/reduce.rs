//! Every dot product, norm and sum. The association is fixed here, once: below `WAYS` terms left to
//! right, from there on `WAYS` accumulators (term k goes to accumulator k mod `WAYS`) folded as a
//! balanced tree. The tree is what SIMD registers compute anyway, and it shortens the critical path.

#![allow(clippy::redundant_closure_for_method_calls, clippy::redundant_closure)] // a function passed by name is called, not inlined
#![allow(clippy::needless_range_loop)] // constant ranges over arrays unroll; iterators over them do not always

use crate::real::Real;

const WAYS: usize = 8;

/// Reduce `first` of a pair of entries, then `accumulate(sum, pair)` over all pairs, with `join` between
/// accumulators; `empty` when there are none. Whole chunks, so that no index is checked and the accumulators
/// become registers.
#[inline(always)]
fn reduce<A: Copy, B: Copy, V: Copy>(
    a: &[A],
    b: &[B],
    empty: V,
    first: impl Fn(A, B) -> V,
    accumulate: impl Fn(V, A, B) -> V,
    join: impl Fn(V, V) -> V,
) -> V {
    let b = &b[..a.len()];
    let ((a_chunks, a_rest), (b_chunks, b_rest)) = (a.as_chunks::<WAYS>(), b.as_chunks::<WAYS>());
    let mut chunks = a_chunks.iter().zip(b_chunks);
    let Some((a, b)) = chunks.next() else {
        let mut pairs = a_rest.iter().zip(b_rest);
        let Some((&a, &b)) = pairs.next() else { return empty };
        let mut sum = first(a, b);
        for (&a, &b) in pairs {
            sum = accumulate(sum, a, b);
        }
        return sum;
    };
    let mut sums: [V; WAYS] = [
        first(a[0], b[0]),
        first(a[1], b[1]),
        first(a[2], b[2]),
        first(a[3], b[3]),
        first(a[4], b[4]),
        first(a[5], b[5]),
        first(a[6], b[6]),
        first(a[7], b[7]),
    ];
    for (a, b) in chunks {
        for way in 0..WAYS {
            sums[way] = accumulate(sums[way], a[way], b[way]);
        }
    }
    for way in 0..WAYS - 1 {
        let (Some(&a), Some(&b)) = (a_rest.get(way), b_rest.get(way)) else { break };
        sums[way] = accumulate(sums[way], a, b);
    }
    let [a, b, c, d, e, f, g, h] = sums;
    join(join(join(a, e), join(c, g)), join(join(b, f), join(d, h)))
}

/// aᵀb.
#[inline(always)]
pub fn dot<T: Real>(a: &[T], b: &[T]) -> T {
    dot_of(a, b.as_chunks::<1>().0)[0]
}

/// Σ a_k·x_k for each of `R` vectors side by side: as [`reduce`], on a loop of the datapath's own.
#[inline(always)]
pub fn dot_of<T: Real, const R: usize>(a: &[T], x: &[[T; R]]) -> [T; R] {
    let x = &x[..a.len()];
    let ((a_chunks, a_rest), (x_chunks, x_rest)) = (a.as_chunks::<WAYS>(), x.as_chunks::<WAYS>());
    let (Some((a, a_chunks)), Some((x, x_chunks))) = (a_chunks.split_first(), x_chunks.split_first()) else {
        let mut sum = [T::zero(); R];
        for (k, (&a, &x)) in a_rest.iter().zip(x_rest).enumerate() {
            sum = if k == 0 { product_of(a, x) } else { add_product_of(sum, a, x) };
        }
        return sum;
    };
    let mut sums = [[T::zero(); R]; WAYS];
    for way in 0..WAYS {
        sums[way] = product_of(a[way], x[way]);
    }
    T::accumulate(&mut sums, a_chunks, x_chunks);
    for way in 0..WAYS - 1 {
        let (Some(&a), Some(&x)) = (a_rest.get(way), x_rest.get(way)) else { break };
        sums[way] = add_product_of(sums[way], a, x);
    }
    let [a, b, c, d, e, f, g, h] = sums;
    let left = add_of(add_of(a, e), add_of(c, g));
    add_of(left, add_of(add_of(b, f), add_of(d, h)))
}

#[inline(always)]
fn product_of<T: Real, const R: usize>(a: T, mut x: [T; R]) -> [T; R] {
    for entry in &mut x {
        *entry = a * *entry;
    }
    x
}

#[inline(always)]
fn add_product_of<T: Real, const R: usize>(mut sum: [T; R], a: T, x: [T; R]) -> [T; R] {
    for r in 0..R {
        sum[r] = sum[r].add_mul(a, x[r]);
    }
    sum
}

#[inline(always)]
fn add_of<T: Real, const R: usize>(mut a: [T; R], b: [T; R]) -> [T; R] {
    for r in 0..R {
        a[r] = a[r] + b[r];
    }
    a
}

/// Σ values[k]·x[index[k]].
#[inline(always)]
pub fn dot_indexed<T: Real>(values: &[T], index: &[u32], x: &[T]) -> T {
    reduce(
        values,
        index,
        T::zero(),
        #[inline(always)]
        |value, at| value * x[at as usize],
        #[inline(always)]
        |sum, value, at| sum.add_mul(value, x[at as usize]),
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
        x,
        x,
        T::zero(),
        #[inline(always)]
        |x, _| x.abs(),
        #[inline(always)]
        |top, x, _| top.max(x.abs()),
        #[inline(always)]
        |a, b| a.max(b),
    )
}

/// min |x_k| of the terms beyond `floor`, and of `most`.
#[inline(always)]
pub fn min_abs_above<T: Real>(x: &[T], floor: T, most: T) -> T {
    reduce(
        x,
        x,
        most,
        #[inline(always)]
        |x, _| abs_above(x, floor, most),
        #[inline(always)]
        |least, x, _| least.min(abs_above(x, floor, most)),
        #[inline(always)]
        |a, b| a.min(b),
    )
}

#[inline(always)]
fn abs_above<T: Real>(x: T, floor: T, otherwise: T) -> T {
    T::select(floor.lt(x.abs()), x.abs(), otherwise)
}

/// max |x_k| of each of `R` vectors side by side.
#[inline(always)]
pub fn max_abs_of<T: Real, const R: usize>(x: &[[T; R]]) -> [T; R] {
    if R == 1 {
        return [max_abs(x.as_flattened()); R];
    }
    reduce(
        x,
        x,
        [T::zero(); R],
        #[inline(always)]
        |x, _| magnitudes(x),
        #[inline(always)]
        |top, x, _| larger_of(top, magnitudes(x)),
        #[inline(always)]
        |a, b| larger_of(a, b),
    )
}

#[inline(always)]
fn magnitudes<T: Real, const R: usize>(mut entries: [T; R]) -> [T; R] {
    for entry in &mut entries {
        *entry = entry.abs();
    }
    entries
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
    reduce(
        weight,
        x,
        T::zero(),
        #[inline(always)]
        |weight, x| (weight * x).abs(),
        #[inline(always)]
        |top, weight, x| top.max((weight * x).abs()),
        #[inline(always)]
        |a, b| a.max(b),
    )
}

/// Σ |x_k|.
#[inline(always)]
pub fn sum_abs<T: Real>(x: &[T]) -> T {
    reduce(
        x,
        x,
        T::zero(),
        #[inline(always)]
        |x, _| x.abs(),
        #[inline(always)]
        |sum, x, _| sum + x.abs(),
        #[inline(always)]
        |a, b| a + b,
    )
}

/// max −x_k·y_k over k, with zero among the candidates.
#[inline(always)]
pub fn max_negative_product<T: Real>(x: &[T], y: &[T]) -> T {
    reduce(
        x,
        y,
        T::zero(),
        #[inline(always)]
        |x, y| T::zero().max(-(x * y)),
        #[inline(always)]
        |top, x, y| top.max(-(x * y)),
        #[inline(always)]
        |a, b| a.max(b),
    )
}

/// Σ 0·x_k: zero when every entry is finite, NaN otherwise.
#[inline(always)]
pub fn non_finite_flag<T: Real>(x: &[T]) -> T {
    reduce(
        x,
        x,
        T::zero(),
        #[inline(always)]
        |x, _| x * T::zero(),
        #[inline(always)]
        |sum, x, _| sum.add_mul(x, T::zero()),
        #[inline(always)]
        |a, b| a + b,
    )
}

/// [`non_finite_flag`] of each of `R` vectors side by side.
#[inline(always)]
pub fn non_finite_flags<T: Real, const R: usize>(x: &[[T; R]]) -> [T; R] {
    if R == 1 {
        return [non_finite_flag(x.as_flattened()); R];
    }
    reduce(
        x,
        x,
        [T::zero(); R],
        #[inline(always)]
        |x, _| add_zeros([T::zero(); R], x),
        #[inline(always)]
        |sum, x, _| add_zeros(sum, x),
        #[inline(always)]
        |a, b| add_of(a, b),
    )
}

#[inline(always)]
fn add_zeros<T: Real, const R: usize>(mut sum: [T; R], entries: [T; R]) -> [T; R] {
    for r in 0..R {
        sum[r] = sum[r].add_mul(entries[r], T::zero());
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::reference::SplitMix64;

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

    /// Products of binary32 entries are exact in binary64, and so is, to 2⁻²⁹ of the bound, their sum.
    #[test]
    #[allow(clippy::cast_possible_truncation)] // makes binary32 entries
    fn dots_are_the_exact_sum_within_the_bound_of_their_longest_path() {
        let mut numbers = SplitMix64(3);
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
            assert_eq!(sum_abs(&a), a.iter().map(|a| a.abs()).sum::<f64>());
        }
    }

    #[test]
    fn the_order_of_summation_depends_on_the_length_alone() {
        let mut numbers = SplitMix64(5);
        for len in SIZES.chain([300]) {
            let (a, b) = (numbers.list(len), numbers.list(len));
            let terms: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a * b).collect();
            let expected = tree(&terms).to_bits();
            // Wherever the entries lie in memory, gathered or not, on whatever instruction set.
            for offset in 0..4 {
                let pad = |v: &[f64]| [vec![9.0; offset], v.to_vec()].concat();
                let (a, b) = (pad(&a), pad(&b));
                assert_eq!(dot(&a[offset..], &b[offset..]).to_bits(), expected);
            }
            let reversed: Vec<f64> = b.iter().rev().copied().collect();
            let index: Vec<u32> = (0..len).rev().map(crate::symbolic::indices::index).collect();
            assert_eq!(dot_indexed(&a, &index, &reversed).to_bits(), expected);
            assert_eq!(pulp::Arch::new().dispatch(|| dot(&a, &b)).to_bits(), expected);
            assert_eq!(norm2(&a).to_bits(), dot(&a, &a).sqrt().to_bits());
        }
    }

    #[test]
    fn maxima_are_the_largest_term_wherever_it_stands() {
        let mut numbers = SplitMix64(7);
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
    fn the_least_magnitude_is_that_of_the_terms_beyond_the_floor() {
        for len in SIZES.skip(1) {
            for at in 0..len {
                let mut a = vec![-3.0; len];
                a[at] = -0.5;
                assert_eq!(min_abs_above(&a, 0.25, 8.0), 0.5, "entry {at} of {len}");
                assert_eq!(min_abs_above(&a, 0.5, 8.0), if len == 1 { 8.0 } else { 3.0 });
            }
            assert_eq!(min_abs_above(&vec![0.0; len], 0.0, 8.0), 8.0, "zeros are not beyond zero");
        }
        assert_eq!(min_abs_above(&[], 0.0, 8.0), 8.0);
    }

    #[test]
    fn a_maximum_drops_nan_and_the_non_finite_flag_does_not() {
        for len in SIZES.skip(1) {
            for at in 0..len {
                let mut a = vec![1.0; len];
                a[at] = f64::NAN;
                // Dropped wherever it is not an accumulator's first term.
                let kept = at == 0 || (len >= WAYS && at < WAYS);
                if !kept {
                    assert_eq!(max_abs(&a), 1.0, "entry {at} of {len}");
                }
                assert!(non_finite_flag(&a).is_nan());
                a[at] = f64::NEG_INFINITY;
                assert!(non_finite_flag(&a).is_nan());
                a[at] = -1e300;
                assert_eq!(non_finite_flag(&a), 0.0);
            }
        }
    }
}

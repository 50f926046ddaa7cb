//! Every dot product, norm and sum. The association is fixed here, once: below `WAYS` terms left to
//! right, from there on `WAYS` accumulators (term k goes to accumulator k mod `WAYS`) folded as a
//! balanced tree. The tree is what SIMD registers compute anyway, and it shortens the critical path.

use crate::real::Real;

const WAYS: usize = 8;

/// Reduce `term(0) … term(len − 1)` with `combine(accumulator, k)`; an empty reduction is zero.
#[inline(always)]
fn reduce<T: Real>(
    len: usize,
    first: impl Fn(usize) -> T,
    accumulate: impl Fn(T, usize) -> T,
    join: impl Fn(T, T) -> T,
) -> T {
    if len == 0 {
        return T::zero();
    }
    if len < WAYS {
        let mut sum = first(0);
        for k in 1..len {
            sum = accumulate(sum, k);
        }
        return sum;
    }
    let mut sums: [T; WAYS] = core::array::from_fn(&first);
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
    reduce(a.len(), |k| a[k] * b[k], |sum, k| sum.add_mul(a[k], b[k]), |x, y| x + y)
}

/// Σ values[k]·x[index[k]].
#[inline(always)]
pub fn dot_indexed<T: Real>(values: &[T], index: &[u32], x: &[T]) -> T {
    let index = &index[..values.len()];
    reduce(
        values.len(),
        |k| values[k] * x[index[k] as usize],
        |sum, k| sum.add_mul(values[k], x[index[k] as usize]),
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
    reduce(x.len(), |k| x[k].abs(), |top, k| top.max(x[k].abs()), Real::max)
}

/// max |weight_k·x_k|.
#[inline(always)]
pub fn max_abs_weighted<T: Real>(weight: &[T], x: &[T]) -> T {
    let x = &x[..weight.len()];
    reduce(weight.len(), |k| (weight[k] * x[k]).abs(), |top, k| top.max((weight[k] * x[k]).abs()), Real::max)
}

/// Σ |weight_k·x_k|.
#[inline(always)]
pub fn sum_abs_weighted<T: Real>(weight: &[T], x: &[T]) -> T {
    let x = &x[..weight.len()];
    reduce(weight.len(), |k| (weight[k] * x[k]).abs(), |sum, k| sum + (weight[k] * x[k]).abs(), |a, b| a + b)
}

/// max −x_k·y_k over k, with zero among the candidates.
#[inline(always)]
pub fn max_negative_product<T: Real>(x: &[T], y: &[T]) -> T {
    let y = &y[..x.len()];
    reduce(x.len(), |k| T::zero().max(-(x[k] * y[k])), |top, k| top.max(-(x[k] * y[k])), Real::max)
}

/// Σ 0·x_k: zero when every entry is finite, NaN otherwise.
#[inline(always)]
pub fn finite_witness<T: Real>(x: &[T]) -> T {
    reduce(x.len(), |k| x[k] * T::zero(), |sum, k| sum.add_mul(x[k], T::zero()), |a, b| a + b)
}

//! IEEE binary64 and binary32 as datapaths.

#[cfg(target_arch = "aarch64")]
use super::neon;
use super::scalar::{self, Decide, Real};
use super::tiles::Factors;
#[cfg(target_arch = "x86_64")]
use pulp::{f64x4, Simd};

/// A comparison's outcome for one scalar; opaque outside this module.
#[derive(Clone, Copy)]
pub struct Bit(bool);

/// To AVX2 where there is it, on machines with AVX-512 too: a tile has four entries to the row. Elsewhere as a function
/// of its own, for the instructions that every machine of the target has.
#[inline(always)]
fn by_256_bits<W: pulp::WithSimd>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return pulp::Simd::vectorize(simd, work);
    }
    by_itself(work)
}

#[inline(never)]
fn by_itself<W: pulp::WithSimd>(work: W) -> W::Output {
    work.with_simd(pulp::Scalar)
}

macro_rules! ieee {
    ($t:ty, $($own:item)*) => {
        impl Real for $t {
            type Mask = Bit;
            // A vector of them counts as one.
            const TILE_COLS: usize = 4;

            #[inline(always)]
            fn vectorize<W: pulp::WithSimd>(work: W) -> W::Output {
                by_256_bits(work)
            }

            #[inline(always)]
            fn is_down(flag: Self) -> bool {
                flag == 0.0
            }

            $($own)*

            #[inline(always)]
            #[allow(clippy::cast_possible_truncation)] // binary32 input entries are rounded once, here
            fn constant(value: f64) -> Self {
                value as $t
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                <$t>::sqrt(self)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                <$t>::abs(self)
            }
            #[inline(always)]
            fn lt(self, other: Self) -> Bit {
                Bit(self < other)
            }
            #[inline(always)]
            fn and(a: Bit, b: Bit) -> Bit {
                Bit(a.0 & b.0)
            }
            #[inline(always)]
            fn select(mask: Bit, yes: Self, no: Self) -> Self {
                if mask.0 {
                    yes
                } else {
                    no
                }
            }
        }

        impl Decide for $t {
            const LANES: usize = 1;

            #[inline(always)]
            fn lane(&self, _: usize) -> f64 {
                f64::from(*self)
            }
            #[inline(always)]
            #[allow(clippy::cast_possible_truncation)] // what is set came from an entry of this type
            fn set_lane(&mut self, _: usize, value: f64) {
                *self = value as $t;
            }
            fn epsilon() -> f64 {
                f64::from(<$t>::EPSILON)
            }
        }
    };
}

ieee! { f64,
    const TILE_ROWS: usize = 8;

    #[inline(always)]
    fn subtract_products<const M: usize, const N: usize, const LOWER: bool>(
        entries: &mut [[Self; M]; N],
        factors: Factors<Self>,
    ) {
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            if M == 4 {
                return four_rows(simd, entries, factors);
            }
            if M == 8 {
                return eight_rows(simd, entries, factors);
            }
            if M == 1 && N == 4 {
                return four_columns(simd, entries, factors);
            }
        }
        #[cfg(target_arch = "aarch64")]
        if let Some(simd) = pulp::aarch64::Neon::try_new() {
            if M == 4 {
                return neon::four_rows(simd, entries, factors);
            }
            if M == 8 {
                return neon::eight_rows(simd, entries, factors);
            }
            if M == 1 && N == 4 {
                return neon::four_columns(simd, entries, factors);
            }
        }
        scalar::subtract::<Self, M, N, LOWER>(entries, factors);
    }

    #[inline(always)]
    fn accumulate<const R: usize>(sums: &mut [[Self; R]; 8], a: &[[Self; 8]], x: &[[[Self; R]; 8]]) {
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            let flat = x.as_flattened().as_flattened();
            match R {
                1 => {
                    let sums = sums.as_flattened_mut().as_chunks_mut().0;
                    return accumulate_one(simd, sums, a, flat.as_chunks().0);
                }
                2 => {
                    let sums = sums.as_flattened_mut().as_chunks_mut().0;
                    return accumulate_two(simd, sums, a, flat.as_chunks().0);
                }
                _ => {}
            }
        }
        #[cfg(target_arch = "aarch64")]
        if let Some(simd) = pulp::aarch64::Neon::try_new() {
            let flat = x.as_flattened().as_flattened();
            match R {
                1 => {
                    let sums = sums.as_flattened_mut().as_chunks_mut().0;
                    return neon::accumulate_one(simd, sums, a, flat.as_chunks().0);
                }
                2 => {
                    let sums = sums.as_flattened_mut().as_chunks_mut().0;
                    return neon::accumulate_two(simd, sums, a, flat.as_chunks().0);
                }
                _ => {}
            }
        }
        scalar::accumulate(sums, a, x);
    }

    #[inline(always)]
    fn subtract_multiple<const R: usize>(entries: &mut [[Self; R]], by: &[Self], x: [Self; R]) {
        #[cfg(target_arch = "x86_64")]
        if let (2, Some(simd)) = (R, pulp::x86::V3::try_new()) {
            let by = &by[..entries.len()];
            let (whole, rest) = entries.split_at_mut(entries.len() / 4 * 4);
            multiple_of_two(simd, whole.as_flattened_mut().as_chunks_mut().0, by.as_chunks().0, [x[0], x[1]]);
            return scalar::subtract_multiple(rest, &by[whole.len()..], x);
        }
        #[cfg(target_arch = "aarch64")]
        if let (2, Some(simd)) = (R, pulp::aarch64::Neon::try_new()) {
            return neon::multiple_of_two(simd, entries.as_flattened_mut().as_chunks_mut().0, by, [x[0], x[1]]);
        }
        scalar::subtract_multiple(entries, by, x);
    }
}
ieee! { f32, }

/// A tile of rows as vectors of four: the compiler does not find it by itself where the entries come from scattered
/// places. A macro, as a function of that many vectors keeps its sums in memory (decision 0010).
#[cfg(target_arch = "x86_64")]
macro_rules! rows_in_vectors {
    ($name:ident, $rows:literal, [$($vector:literal),+]) => {
        #[inline(always)]
        fn $name<const M: usize, const N: usize>(
            simd: pulp::x86::V3,
            entries: &mut [[f64; M]; N],
            factors: Factors<f64>,
        ) {
            let four = |w: [f64; M], v: usize| f64x4(w[4 * v], w[4 * v + 1], w[4 * v + 2], w[4 * v + 3]);
            let mut sums = entries.map(|w| [$(four(w, $vector)),+]);
            factors.pairs::<$rows, N>(
                #[inline(always)]
                |l, y| {
                    let l: [f64x4; $rows / 4] = pulp::cast(*l);
                    for n in 0..N {
                        let y = simd.splat_f64s(y[n]);
                        $(sums[n][$vector] = simd.sub_f64s(sums[n][$vector], simd.mul_f64s(l[$vector], y));)+
                    }
                },
            );
            for (entries, sum) in entries.iter_mut().zip(sums) {
                entries.copy_from_slice(&pulp::cast::<[f64x4; $rows / 4], [f64; $rows]>(sum));
            }
        }
    };
}
#[cfg(target_arch = "x86_64")]
rows_in_vectors! { four_rows, 4, [0] }
#[cfg(target_arch = "x86_64")]
rows_in_vectors! { eight_rows, 8, [0, 1] }

/// Four columns of one row in a register.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn four_columns<const M: usize, const N: usize>(
    simd: pulp::x86::V3,
    entries: &mut [[f64; M]; N],
    factors: Factors<f64>,
) {
    let mut sums = f64x4(entries[0][0], entries[1][0], entries[2][0], entries[3][0]);
    factors.pairs::<1, 4>(
        #[inline(always)]
        |&[l], &y| sums = simd.sub_f64s(sums, simd.mul_f64s(simd.splat_f64s(l), pulp::cast(y))),
    );
    for (entry, sum) in entries.iter_mut().zip(pulp::cast::<f64x4, [f64; 4]>(sums)) {
        entry[0] = sum;
    }
}

/// Eight sums in two registers.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn accumulate_one(simd: pulp::x86::V3, sums: &mut [[f64; 8]], a: &[[f64; 8]], x: &[[f64; 8]]) {
    let Some(sums) = sums.first_mut() else { return };
    let [mut low, mut high]: [f64x4; 2] = pulp::cast(*sums);
    for (&a, &x) in a.iter().zip(x) {
        let ([a_low, a_high], [x_low, x_high]): ([f64x4; 2], [f64x4; 2]) = (pulp::cast(a), pulp::cast(x));
        low = simd.add_f64s(low, simd.mul_f64s(a_low, x_low));
        high = simd.add_f64s(high, simd.mul_f64s(a_high, x_high));
    }
    *sums = pulp::cast([low, high]);
}

/// Eight sums of either of two vectors side by side, in four registers.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn accumulate_two(simd: pulp::x86::V3, sums: &mut [[f64; 16]], a: &[[f64; 8]], x: &[[f64; 16]]) {
    let Some(sums) = sums.first_mut() else { return };
    let mut entries: [f64x4; 4] = pulp::cast(*sums);
    for (&a, &x) in a.iter().zip(x) {
        let ([low, high], x): ([f64x4; 2], [f64x4; 4]) = (pulp::cast(a), pulp::cast(x));
        let (first, second) = twice_each(simd, low);
        let (third, fourth) = twice_each(simd, high);
        entries[0] = simd.add_f64s(entries[0], simd.mul_f64s(first, x[0]));
        entries[1] = simd.add_f64s(entries[1], simd.mul_f64s(second, x[1]));
        entries[2] = simd.add_f64s(entries[2], simd.mul_f64s(third, x[2]));
        entries[3] = simd.add_f64s(entries[3], simd.mul_f64s(fourth, x[3]));
    }
    *sums = pulp::cast(entries);
}

/// (a, a, b, b) and (c, c, d, d) of (a, b, c, d).
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn twice_each(simd: pulp::x86::V3, entries: f64x4) -> (f64x4, f64x4) {
    let entries = pulp::cast(entries);
    let low = pulp::cast(simd.avx2._mm256_permute4x64_pd::<0b01_01_00_00>(entries));
    let high = pulp::cast(simd.avx2._mm256_permute4x64_pd::<0b11_11_10_10>(entries));
    (low, high)
}

/// Of two vectors side by side, four entries of either: two registers.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn multiple_of_two(simd: pulp::x86::V3, entries: &mut [[f64; 8]], by: &[[f64; 4]], x: [f64; 2]) {
    let x = f64x4(x[0], x[1], x[0], x[1]);
    for (entries, &by) in entries.iter_mut().zip(by) {
        let [low, high]: [f64x4; 2] = pulp::cast(*entries);
        let (low_by, high_by) = twice_each(simd, pulp::cast(by));
        let low = simd.sub_f64s(low, simd.mul_f64s(low_by, x));
        let high = simd.sub_f64s(high, simd.mul_f64s(high_by, x));
        *entries = pulp::cast([low, high]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn contract<T: Decide>() {
        let c = T::constant;
        let value = |x: T| x.value();
        assert_eq!(value(c(2.0).max(c(3.0))), 3.0);
        assert_eq!(value(c(2.0).min(c(3.0))), 2.0);
        assert_eq!(value(T::select(c(1.0).lt(c(2.0)), c(5.0), c(6.0))), 5.0);
        assert_eq!(value(T::select(c(2.0).lt(c(2.0)), c(5.0), c(6.0))), 6.0);
        let (yes, no) = (c(0.0).lt(c(1.0)), c(1.0).lt(c(0.0)));
        let both = |a, b| value(T::select(T::and(a, b), T::one(), T::zero()));
        assert_eq!([both(yes, yes), both(yes, no), both(no, yes), both(no, no)], [1.0, 0.0, 0.0, 0.0]);
        // Sign operations act on the bit, zero's included.
        assert_eq!(value(c(-0.0).abs()).to_bits(), 0.0f64.to_bits());
        assert_eq!(value(-c(0.0)).to_bits(), (-0.0f64).to_bits());
    }

    #[test]
    fn both_precisions_keep_the_contract() {
        contract::<f64>();
        contract::<f32>();
        assert_eq!((f64::epsilon(), f32::epsilon()), (2f64.powi(-52), 2f64.powi(-23)));
    }

    #[test]
    fn max_and_min_drop_a_nan_on_the_right_and_keep_one_on_the_left() {
        let (nan, one) = (f64::NAN, 1.0);
        assert_eq!((Real::max(one, nan), Real::min(one, nan)), (1.0, 1.0));
        assert!(Real::max(nan, one).is_nan() && Real::min(nan, one).is_nan());
    }

    #[test]
    fn equal_operands_yield_the_left_one() {
        let (plus, minus) = (0.0f64, -0.0f64);
        assert_eq!(Real::max(plus, minus).to_bits(), plus.to_bits());
        assert_eq!(Real::max(minus, plus).to_bits(), minus.to_bits());
    }

    #[test]
    fn products_are_added_with_two_roundings() {
        // (1 + 2⁻³⁰)² = 1 + 2⁻²⁹ + 2⁻⁶⁰: the last term is lost before the addition, not after it.
        let a = 1.0 + 2f64.powi(-30);
        let square = 1.0 + 2f64.powi(-29);
        assert_eq!((-square).add_mul(a, a), 0.0);
        assert_eq!(square.sub_mul(a, a), 0.0);
        assert_eq!(a.mul_add(a, -square), 2f64.powi(-60));
    }

    #[test]
    fn single_precision_rounds_input_words_once() {
        assert_eq!(<f32 as Real>::constant(0.1), 0.1f32);
        assert_eq!(<f32 as Real>::constant(1e300), f32::INFINITY);
        assert_eq!(<f32 as Real>::constant(1e-30), 1e-30f32);
    }
}

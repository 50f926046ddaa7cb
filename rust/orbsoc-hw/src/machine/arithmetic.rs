//! Arithmetic of the units, bit-identical to the RTL.

use super::operation::Code;
use super::timing::Precision;
use core::ops::{Add, Div, Mul, Sub};

/// The canonical quiet NaN of the arithmetic units.
fn quiet(precision: Precision) -> u64 {
    match precision {
        Precision::F64 => 0x7ff8_0000_0000_0000,
        Precision::F32 => 0x7fc0_0000,
    }
}

/// The result of an operation; words that it does not read are arbitrary.
pub fn compute(precision: Precision, code: Code, [a, b, c]: [u64; 3]) -> u64 {
    let sign = 1u64 << (precision.bits() - 1);
    let ones = u64::MAX >> (64 - precision.bits());
    let less = |x: u64, y: u64| match precision {
        Precision::F64 => f64::from_bits(x) < f64::from_bits(y),
        Precision::F32 => single(x) < single(y),
    };
    match code {
        Code::Neg => a ^ sign,
        Code::Abs => a & !sign,
        Code::Min if less(b, a) => b,
        Code::Max if less(a, b) => b,
        Code::Move | Code::Min | Code::Max => a,
        Code::Compare if less(a, b) => ones,
        Code::Compare => 0,
        Code::And => a & b,
        Code::Select if c & 1 == 1 => a,
        Code::Select => b,
        _ => round(precision, code, [a, b, c]),
    }
}

/// A binary32 word is the low half.
fn single(word: u64) -> f32 {
    f32::from_bits(word as u32)
}

/// A rounded operation, with canonical NaNs.
fn round(precision: Precision, code: Code, words: [u64; 3]) -> u64 {
    let (bits, nan) = match precision {
        Precision::F64 => {
            let result = evaluate(code, words.map(f64::from_bits), f64::sqrt);
            (result.to_bits(), result.is_nan())
        }
        Precision::F32 => {
            let result = evaluate(code, words.map(single), f32::sqrt);
            (u64::from(result.to_bits()), result.is_nan())
        }
    };
    if nan {
        quiet(precision)
    } else {
        bits
    }
}

fn evaluate<T>(code: Code, [a, b, c]: [T; 3], sqrt: impl Fn(T) -> T) -> T
where
    T: Add<Output = T> + Sub<Output = T> + Mul<Output = T> + Div<Output = T>,
{
    match code {
        Code::Mul => a * b,
        Code::Add => c + a,
        Code::Sub => c - a,
        Code::AddMul => c + a * b,
        Code::SubMul => c - a * b,
        Code::Div => a / b,
        _ => sqrt(a),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nans_are_canonical_unless_only_their_sign_changes() {
        let odd = 0xfff0_0000_0000_0001;
        let of = |code| compute(Precision::F64, code, [odd, 0, 0]);
        assert_eq!([Code::Add, Code::Mul, Code::Sqrt].map(of), [quiet(Precision::F64); 3]);
        assert_eq!(of(Code::Neg), 0x7ff0_0000_0000_0001);
        assert_eq!((of(Code::Move), of(Code::Abs)), (odd, 0x7ff0_0000_0000_0001));
        assert_eq!(compute(Precision::F32, Code::Sqrt, [0xbf80_0000, 0, 0]), 0x7fc0_0000);
    }

    #[test]
    fn masks_are_words_of_ones_and_select_looks_at_the_lowest_bit() {
        let [one, two] = [1.0f64, 2.0].map(f64::to_bits);
        let yes = compute(Precision::F64, Code::Compare, [one, two, 0]);
        assert_eq!((yes, compute(Precision::F64, Code::Compare, [one, one, 0])), (u64::MAX, 0));
        assert_eq!(compute(Precision::F64, Code::Select, [one, two, yes]), one);
        assert_eq!(compute(Precision::F64, Code::Select, [one, two, 0]), two);
        assert_eq!(compute(Precision::F32, Code::Compare, [0, 0x3f80_0000, 0]), 0xffff_ffff);
    }

    #[test]
    fn the_multiply_add_computes_products_and_sums() {
        let values = [0.0, -0.0, 1.0, -3.5, f64::INFINITY, f64::NAN, 5e-324, -1e308].map(f64::to_bits);
        let (one, minus_zero) = (1.0f64.to_bits(), (-0.0f64).to_bits());
        for a in values {
            for b in values {
                let of = |code, words| compute(Precision::F64, code, words);
                assert_eq!(of(Code::Mul, [a, b, 0]), of(Code::AddMul, [a, b, minus_zero]));
                assert_eq!(of(Code::Add, [a, 0, b]), of(Code::AddMul, [a, one, b]));
                assert_eq!(of(Code::Sub, [a, 0, b]), of(Code::SubMul, [a, one, b]));
            }
        }
    }
}

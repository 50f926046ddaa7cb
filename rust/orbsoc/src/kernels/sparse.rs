//! Products of the data's sparse matrices with vectors. Loops follow the column blocks that set-up found: what
//! is added to any one entry, and in which order, is as column by column.

use super::reduce::{dot, dot_indexed};
use crate::kkt::structure::Pattern;
use crate::real::Real;
use crate::symbolic::column_blocks::Uniformity;

/// `out = P x`, P symmetric and given by its upper triangle.
#[inline(always)]
pub fn symmetric_product<T: Real>(pattern: &Pattern, values: &[T], x: &[T], out: &mut [T]) {
    out.fill(T::zero());
    for block in pattern.column_blocks() {
        if block.uniformity == Uniformity::FixedLength(0) {
            continue;
        }
        for j in block.columns.clone() {
            let entries = pattern.column(j);
            for (&i, &value) in pattern.rows(entries.clone()).iter().zip(&values[entries]) {
                let i = i as usize;
                out[i] = out[i].add_mul(value, x[j]);
                if i != j {
                    out[j] = out[j].add_mul(value, x[i]);
                }
            }
        }
    }
}

/// `by_rows = M x` and `by_columns = Mᵀ y` in one pass over M.
#[inline(always)]
pub fn products_of<T: Real>(
    pattern: &Pattern,
    values: &[T],
    x: &[T],
    y: &[T],
    by_rows: &mut [T],
    by_columns: &mut [T],
) {
    by_rows.fill(T::zero());
    for block in pattern.column_blocks() {
        let columns = block.columns.clone();
        let (rows, values) = pattern.entries(block, values);
        let (x, sums) = (&x[columns.clone()], &mut by_columns[columns.clone()]);
        match block.uniformity {
            Uniformity::FixedLength(0) => sums.fill(T::zero()),
            Uniformity::FixedLength(1) => products_of_fixed::<T, 1>(rows, values, x, y, by_rows, sums),
            Uniformity::FixedLength(2) => products_of_fixed::<T, 2>(rows, values, x, y, by_rows, sums),
            Uniformity::FixedLength(3) => products_of_fixed::<T, 3>(rows, values, x, y, by_rows, sums),
            Uniformity::FixedLength(_) => products_of_fixed::<T, 4>(rows, values, x, y, by_rows, sums),
            Uniformity::Contiguous => {
                for (((_, first, column), &x), sum) in
                    pattern.contiguous_columns(block, values).zip(x).zip(sums)
                {
                    *sum = dot(column, &y[first..][..column.len()]);
                    for (entry, &value) in by_rows[first..].iter_mut().zip(column) {
                        *entry = entry.add_mul(value, x);
                    }
                }
            }
            Uniformity::General => {
                let lengths = columns.map(|j| pattern.column(j).len());
                products_of_general(lengths, rows, values, x, y, by_rows, sums);
            }
        }
    }
}

/// Columns of `L` ≥ 1 entries.
#[inline(always)]
fn products_of_fixed<T: Real, const L: usize>(
    rows: &[u32],
    values: &[T],
    x: &[T],
    y: &[T],
    by_rows: &mut [T],
    sums: &mut [T],
) {
    let columns = rows.as_chunks::<L>().0.iter().zip(values.as_chunks::<L>().0);
    for (((rows, values), &x), out) in columns.zip(x).zip(sums) {
        let mut sum = values[0] * y[rows[0] as usize];
        for k in 1..L {
            sum = sum.add_mul(values[k], y[rows[k] as usize]);
        }
        *out = sum;
        for k in 0..L {
            let entry = &mut by_rows[rows[k] as usize];
            *entry = entry.add_mul(values[k], x);
        }
    }
}

#[inline(always)]
fn products_of_general<T: Real>(
    lengths: impl Iterator<Item = usize>,
    rows: &[u32],
    values: &[T],
    x: &[T],
    y: &[T],
    by_rows: &mut [T],
    sums: &mut [T],
) {
    let mut begin = 0;
    for ((length, &x), sum) in lengths.zip(x).zip(sums) {
        let (rows, values) = (&rows[begin..begin + length], &values[begin..begin + length]);
        *sum = dot_indexed(values, rows, y);
        for (&i, &value) in rows.iter().zip(values) {
            by_rows[i as usize] = by_rows[i as usize].add_mul(value, x);
        }
        begin += length;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::reference::SplitMix64;
    use crate::Csc;

    /// Columns of every shape, side by side.
    fn matrix(numbers: &mut SplitMix64) -> Csc {
        let lengths = [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4, 2, 7, 16, 16, 30, 17, 11];
        let dense: Vec<Vec<f64>> = (0..30)
            .map(|i| {
                let entry = |&length: &usize| if i < length { numbers.signed() } else { 0.0 };
                lengths.iter().map(entry).collect()
            })
            .collect();
        Csc::from_dense(&dense.iter().map(Vec::as_slice).collect::<Vec<_>>(), lengths.len())
    }

    #[test]
    fn products_add_column_by_column_whatever_the_shape() {
        let mut numbers = SplitMix64(19);
        let m = matrix(&mut numbers);
        let pattern = Pattern::new(&m);
        assert!(pattern.column_blocks().len() >= 7);
        let (x, y) = (numbers.list(m.ncols()), numbers.list(m.nrows()));
        let (mut by_rows, mut by_columns) = (vec![9.0; m.nrows()], vec![9.0; m.ncols()]);
        products_of(&pattern, m.values(), &x, &y, &mut by_rows, &mut by_columns);
        let mut plain = vec![0.0; m.nrows()];
        for (j, (rows, values)) in m.columns().enumerate() {
            let gathered: Vec<f64> = rows.iter().map(|&i| y[i]).collect();
            assert_eq!(by_columns[j].to_bits(), dot(values, &gathered).to_bits(), "column {j}");
            for (&i, &value) in rows.iter().zip(values) {
                plain[i] += value * x[j];
            }
        }
        let bits = |v: &[f64]| v.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&by_rows), bits(&plain));
    }
}

//! Column blocks: adjacent columns of a sparse matrix with uniform sparsity, so that one loop with a
//! fixed number of turns, or one over adjacent entries, serves them all. Found once, at set-up.

use core::ops::Range;

/// Columns with at most this number of entries have loops of their own.
pub(crate) const MAX_FIXED_LENGTH: usize = 4;
/// From this number of adjacent rows on, a column is worth a loop over slices.
const MIN_CONTIGUOUS: usize = 16;
/// A shorter block is not worth a loop of its own.
const MIN_COLUMNS: usize = 4;

/// What the columns of a block have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Uniformity {
    /// The same number of entries in each, at most [`MAX_FIXED_LENGTH`].
    FixedLength(usize),
    /// Each one's rows are adjacent, and many.
    Contiguous,
    /// No uniformity.
    General,
}

/// Adjacent columns.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ColumnBlock {
    pub columns: Range<usize>,
    pub uniformity: Uniformity,
}

/// All columns in their order, from the rows of each one's entries, ascending.
pub(crate) fn column_blocks<'a>(columns: usize, rows: impl Fn(usize) -> &'a [u32]) -> Vec<ColumnBlock> {
    let mut out: Vec<ColumnBlock> = Vec::new();
    for j in 0..columns {
        let uniformity = shape(rows(j));
        match out.last_mut() {
            Some(last) if last.uniformity == uniformity => last.columns.end = j + 1,
            _ => out.push(ColumnBlock { columns: j..j + 1, uniformity }),
        }
    }
    for block in out.iter_mut().filter(|block| block.columns.len() < MIN_COLUMNS) {
        block.uniformity = Uniformity::General;
    }
    out.dedup_by(|block, last| {
        let joins = last.uniformity == block.uniformity;
        if joins {
            last.columns.end = block.columns.end;
        }
        joins
    });
    out
}

fn shape(rows: &[u32]) -> Uniformity {
    match rows {
        _ if rows.len() <= MAX_FIXED_LENGTH => Uniformity::FixedLength(rows.len()),
        [first, .., last] if rows.len() >= MIN_CONTIGUOUS && (last - first) as usize + 1 == rows.len() => {
            Uniformity::Contiguous
        }
        _ => Uniformity::General,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(columns: &[Vec<u32>]) -> Vec<(Range<usize>, Uniformity)> {
        column_blocks(columns.len(), |j| &columns[j]).into_iter().map(|s| (s.columns, s.uniformity)).collect()
    }

    #[test]
    fn columns_alike_are_gathered_and_few_of_them_are_not() {
        let (pair, triple) = (vec![1, 5], vec![0, 2, 9]);
        let long: Vec<u32> = (3..3 + 16).collect();
        let gap: Vec<u32> = (0..16).chain([17]).collect();
        let columns = [
            vec![pair; 4],
            vec![triple; 3],
            vec![vec![7]; 2],
            vec![long.clone(); 2],
            vec![long.clone(), (0..20).collect()],
            vec![gap],
            vec![long; 3],
            vec![vec![]; 5],
        ];
        let expected = [
            (0..4, Uniformity::FixedLength(2)),
            (4..9, Uniformity::General),
            (9..13, Uniformity::Contiguous),
            (13..17, Uniformity::General),
            (17..22, Uniformity::FixedLength(0)),
        ];
        assert_eq!(found(&columns.concat()), expected);
        assert_eq!(found(&[]), []);
    }

    #[test]
    fn every_column_is_in_one_block_in_order() {
        let mut numbers = crate::tests::reference::SplitMix64(11);
        for columns in 0..40 {
            let all: Vec<Vec<u32>> =
                (0..columns).map(|_| (0..40).filter(|_| numbers.unit() < 0.05).collect()).collect();
            let ranges: Vec<usize> = found(&all).into_iter().flat_map(|(columns, _)| columns).collect();
            assert_eq!(ranges, (0..columns).collect::<Vec<_>>());
        }
    }
}

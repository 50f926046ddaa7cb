//! Stretches of adjacent columns of a sparse matrix that have a shape in common, so that one loop with a
//! fixed number of turns, or one over adjacent words, serves them all. Found once, at set-up.

use core::ops::Range;

/// Columns with at most so many entries have loops of their own.
pub(crate) const SHORT: usize = 4;
/// From so many adjacent rows on a column is worth a loop over slices.
const DENSE: usize = 16;
/// So few columns alike are not worth the change of loops.
const FEW: usize = 4;

/// What the columns of a stretch have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Alike {
    /// As many entries each, at most [`SHORT`].
    Short(usize),
    /// Each one's rows are adjacent, and many.
    Dense,
    /// Nothing.
    Nothing,
}

/// Adjacent columns.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Stretch {
    pub columns: Range<usize>,
    pub alike: Alike,
}

/// All columns in their order, from the rows of each one's entries, ascending.
pub(crate) fn stretches<'a>(columns: usize, rows: impl Fn(usize) -> &'a [u32]) -> Vec<Stretch> {
    let mut out: Vec<Stretch> = Vec::new();
    for j in 0..columns {
        let alike = shape(rows(j));
        match out.last_mut() {
            Some(last) if last.alike == alike => last.columns.end = j + 1,
            _ => out.push(Stretch { columns: j..j + 1, alike }),
        }
    }
    let mut joined: Vec<Stretch> = Vec::with_capacity(out.len());
    for mut stretch in out {
        if stretch.columns.len() < FEW {
            stretch.alike = Alike::Nothing;
        }
        match joined.last_mut() {
            Some(last) if last.alike == stretch.alike => last.columns.end = stretch.columns.end,
            _ => joined.push(stretch),
        }
    }
    joined
}

fn shape(rows: &[u32]) -> Alike {
    match rows {
        _ if rows.len() <= SHORT => Alike::Short(rows.len()),
        [first, .., last] if rows.len() >= DENSE && (last - first) as usize + 1 == rows.len() => Alike::Dense,
        _ => Alike::Nothing,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(columns: &[Vec<u32>]) -> Vec<(Range<usize>, Alike)> {
        stretches(columns.len(), |j| &columns[j]).into_iter().map(|s| (s.columns, s.alike)).collect()
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
            (0..4, Alike::Short(2)),
            (4..9, Alike::Nothing),
            (9..13, Alike::Dense),
            (13..17, Alike::Nothing),
            (17..22, Alike::Short(0)),
        ];
        assert_eq!(found(&columns.concat()), expected);
        assert_eq!(found(&[]), []);
    }

    #[test]
    fn every_column_is_in_one_stretch_in_order() {
        let mut numbers = crate::tests::reference::Numbers(11);
        for columns in 0..40 {
            let all: Vec<Vec<u32>> =
                (0..columns).map(|_| (0..40).filter(|_| numbers.unit() < 0.05).collect()).collect();
            let ranges: Vec<usize> = found(&all).into_iter().flat_map(|(columns, _)| columns).collect();
            assert_eq!(ranges, (0..columns).collect::<Vec<_>>());
        }
    }
}

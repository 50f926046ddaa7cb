//! Sparse matrices in compressed-column form, double precision: the user's data.

use crate::error::{fit, Error};

/// An `nrows × ncols` matrix; row indices ascend strictly within each column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Csc {
    nrows: usize,
    ncols: usize,
    colptr: Vec<usize>,
    rowidx: Vec<usize>,
    values: Vec<f64>,
}

impl Csc {
    /// Check and take the three arrays. `argument` names the matrix in errors.
    ///
    /// # Errors
    /// [`Error::Sparse`] when the arrays do not form a matrix with sorted, unique row indices,
    /// [`Error::Value`] when an entry is not finite.
    pub fn new(
        argument: &'static str,
        (nrows, ncols): (usize, usize),
        colptr: Vec<usize>,
        rowidx: Vec<usize>,
        values: Vec<f64>,
    ) -> Result<Self, Error> {
        let fail = |detail: String| Err(Error::Sparse { argument, detail });
        if colptr.len().checked_sub(1) != Some(ncols) {
            return fail(format!(
                "column pointer has {} entries, but {ncols} columns need one more",
                colptr.len()
            ));
        }
        if rowidx.len() != values.len() {
            return fail(format!("{} row indices, but {} values", rowidx.len(), values.len()));
        }
        if colptr[0] != 0 || colptr[ncols] != rowidx.len() || colptr.windows(2).any(|w| w[0] > w[1]) {
            return fail("column pointer must ascend from 0 to the number of entries".into());
        }
        for j in 0..ncols {
            let rows = &rowidx[colptr[j]..colptr[j + 1]];
            if rows.windows(2).any(|w| w[0] >= w[1]) {
                return fail(format!("row indices of column {j} are unsorted or repeated"));
            }
            if let Some(&i) = rows.last().filter(|&&i| i >= nrows) {
                return fail(format!("row index {i} in column {j}, but there are {nrows} rows"));
            }
        }
        if let Some((index, &value)) = values.iter().enumerate().find(|(_, v)| !v.is_finite()) {
            return Err(Error::Value { argument, index, value });
        }
        Ok(Self { nrows, ncols, colptr, rowidx, values })
    }

    /// The `nrows × ncols` zero matrix.
    pub fn zeros(nrows: usize, ncols: usize) -> Self {
        Self { nrows, ncols, colptr: vec![0; ncols + 1], rowidx: Vec::new(), values: Vec::new() }
    }

    /// From a dense row-major matrix; zeros are not stored.
    ///
    /// # Panics
    /// When the rows have different lengths.
    pub fn from_dense(rows: &[&[f64]], ncols: usize) -> Self {
        let mut out = Self::zeros(rows.len(), ncols);
        for j in 0..ncols {
            for (i, row) in rows.iter().enumerate() {
                assert_eq!(row.len(), ncols, "row {i} has {} entries, not {ncols}", row.len());
                if row[j] != 0.0 {
                    out.rowidx.push(i);
                    out.values.push(row[j]);
                }
            }
            out.colptr[j + 1] = out.rowidx.len();
        }
        out
    }

    /// Number of rows.
    pub fn nrows(&self) -> usize {
        self.nrows
    }

    /// Number of columns.
    pub fn ncols(&self) -> usize {
        self.ncols
    }

    /// Stored entries.
    pub fn nnz(&self) -> usize {
        self.values.len()
    }

    /// Column pointers, `ncols + 1`.
    pub fn colptr(&self) -> &[usize] {
        &self.colptr
    }

    /// Row indices, column by column.
    pub fn rowidx(&self) -> &[usize] {
        &self.rowidx
    }

    /// Take the values of a matrix of the same pattern.
    pub(crate) fn copy_values(&mut self, from: &Self) {
        self.values.copy_from_slice(&from.values);
    }

    /// Row indices and values, column by column.
    pub(crate) fn columns(&self) -> impl Iterator<Item = (&[usize], &[f64])> {
        self.colptr.windows(2).map(|ends| (&self.rowidx[ends[0]..ends[1]], &self.values[ends[0]..ends[1]]))
    }

    /// Values, column by column.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Replace the stored values.
    ///
    /// # Errors
    /// [`Error::Dimension`] for another number of them, [`Error::Value`] for one that is not finite.
    pub(crate) fn set_values(&mut self, argument: &'static str, values: &[f64]) -> Result<(), Error> {
        fit(argument, (values.len(), "values"), self.nnz(), "its pattern has")?;
        finite(argument, values)?;
        self.values.copy_from_slice(values);
        Ok(())
    }

    /// Same shape and same stored positions.
    pub fn same_pattern(&self, other: &Self) -> bool {
        // Comparing two empty lists takes 87 ns (decision 0009).
        let same = |a: &[usize], b: &[usize]| a.len() == b.len() && (a.is_empty() || a == b);
        self.nrows == other.nrows && same(&self.colptr, &other.colptr) && same(&self.rowidx, &other.rowidx)
    }

    /// Entries as `(row, column, value)`, column by column.
    pub fn triplets(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        (0..self.ncols).flat_map(move |j| {
            (self.colptr[j]..self.colptr[j + 1]).map(move |k| (self.rowidx[k], j, self.values[k]))
        })
    }

    /// The entries on and above the diagonal of a square matrix.
    ///
    /// # Errors
    /// [`Error::Dimension`] when it is not square.
    pub fn upper_triangle(&self, argument: &'static str) -> Result<Self, Error> {
        fit(argument, (self.nrows, "rows"), self.ncols, "its number of columns is")?;
        let mut out = Self::zeros(self.nrows, self.ncols);
        for j in 0..self.ncols {
            for k in self.colptr[j]..self.colptr[j + 1] {
                if self.rowidx[k] <= j {
                    out.rowidx.push(self.rowidx[k]);
                    out.values.push(self.values[k]);
                }
            }
            out.colptr[j + 1] = out.rowidx.len();
        }
        Ok(out)
    }

    /// Keep and renumber rows: row `i` becomes `new_row[i]`, or goes when that is `None`.
    /// Also returns, for each entry kept, its position among the old entries.
    pub(crate) fn map_rows(&self, nrows: usize, new_row: &[Option<usize>]) -> (Self, Vec<usize>) {
        let mut out = Self::zeros(nrows, self.ncols);
        out.rowidx.reserve(self.nnz());
        let mut origin = Vec::with_capacity(self.nnz());
        for j in 0..self.ncols {
            let begin = origin.len();
            let mapped = |k: usize| new_row[self.rowidx[k]];
            origin.extend((self.colptr[j]..self.colptr[j + 1]).filter(|&k| mapped(k).is_some()));
            origin[begin..].sort_by_key(|&k| mapped(k));
            out.rowidx.extend(origin[begin..].iter().filter_map(|&k| mapped(k)));
            out.colptr[j + 1] = origin.len();
        }
        out.values = origin.iter().map(|&k| self.values[k]).collect();
        (out, origin)
    }
}

/// Every number of an argument must be finite; the error names the first that is not.
pub(crate) fn finite(argument: &'static str, values: &[f64]) -> Result<(), Error> {
    match values.iter().enumerate().find(|(_, v)| !v.is_finite()) {
        Some((index, &value)) => Err(Error::Value { argument, index, value }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::reference::SplitMix64;

    fn dense(matrix: &Csc) -> Vec<Vec<f64>> {
        let mut out = vec![vec![0.0; matrix.ncols()]; matrix.nrows()];
        matrix.triplets().for_each(|(i, j, v)| out[i][j] = v);
        out
    }

    #[test]
    fn dense_rows_come_back_for_every_shape() {
        let mut numbers = SplitMix64(13);
        for (rows, columns) in (0..=8).flat_map(|rows| (0..=8).map(move |columns| (rows, columns))) {
            let matrix = numbers.sparse(rows, columns, 0.5);
            let rebuilt = dense(&matrix);
            let again = Csc::from_dense(&rebuilt.iter().map(Vec::as_slice).collect::<Vec<_>>(), columns);
            assert_eq!(again, matrix);
            // What `from_dense` makes passes the checks that given arrays must pass.
            let arrays = (matrix.colptr().to_vec(), matrix.rowidx().to_vec(), matrix.values().to_vec());
            assert_eq!(Csc::new("M", (rows, columns), arrays.0, arrays.1, arrays.2), Ok(matrix));
        }
    }

    #[test]
    fn the_upper_triangle_drops_what_lies_below_the_diagonal() {
        let matrix = SplitMix64(17).sparse(7, 7, 0.6);
        let (whole, upper) = (dense(&matrix), dense(&matrix.upper_triangle("P").unwrap()));
        for (i, j) in (0..7).flat_map(|i| (0..7).map(move |j| (i, j))) {
            assert_eq!(upper[i][j], if i <= j { whole[i][j] } else { 0.0 });
        }
    }

    #[test]
    fn mapped_rows_stay_sorted_and_know_where_they_came_from() {
        let matrix = SplitMix64(19).sparse(6, 5, 0.7);
        let new_row = [Some(3), None, Some(0), Some(2), None, Some(1)];
        let (mapped, origin) = matrix.map_rows(4, &new_row);
        let (old, new) = (dense(&matrix), dense(&mapped));
        for (i, to) in new_row.iter().enumerate() {
            if let Some(to) = to {
                assert_eq!(new[*to], old[i]);
            }
        }
        assert!((0..5).all(|j| {
            let rows = &mapped.rowidx()[mapped.colptr()[j]..mapped.colptr()[j + 1]];
            rows.windows(2).all(|pair| pair[0] < pair[1])
        }));
        let values: Vec<f64> = origin.iter().map(|&k| matrix.values()[k]).collect();
        assert_eq!(values, mapped.values());
    }

    #[test]
    fn patterns_differ_by_shape_and_by_position_not_by_value() {
        let with = |corner: f64, value: f64| Csc::from_dense(&[&[value, 0.0], &[corner, 1.0]], 2);
        assert!(with(2.0, 1.0).same_pattern(&with(3.0, 4.0)));
        assert!(!with(2.0, 1.0).same_pattern(&with(0.0, 1.0)));
        assert!(!Csc::zeros(2, 3).same_pattern(&Csc::zeros(3, 3)));
        assert!(!Csc::zeros(2, 3).same_pattern(&Csc::zeros(2, 2)));
    }
}

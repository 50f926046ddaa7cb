//! Sparse matrices in compressed-column form, double precision: the user's data.

use crate::error::Error;
use crate::problem::finite;

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
        if colptr.len() != ncols + 1 {
            return fail(format!(
                "column pointer has {} entries, but {ncols} columns need {}",
                colptr.len(),
                ncols + 1
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

    /// Values, column by column.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Replace the stored values.
    ///
    /// # Errors
    /// [`Error::Dimension`] for another number of them, [`Error::Value`] for one that is not finite.
    pub(crate) fn set_values(&mut self, argument: &'static str, values: &[f64]) -> Result<(), Error> {
        if values.len() != self.nnz() {
            let (found, expected) = (values.len(), self.nnz());
            return Err(Error::Dimension { argument, found, expected, reason: "its pattern has" });
        }
        finite(argument, values)?;
        self.values.copy_from_slice(values);
        Ok(())
    }

    /// Same shape and same stored positions.
    pub fn same_pattern(&self, other: &Self) -> bool {
        self.nrows == other.nrows && self.colptr == other.colptr && self.rowidx == other.rowidx
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
        if self.nrows != self.ncols {
            let (found, expected) = (self.nrows, self.ncols);
            return Err(Error::Dimension { argument, found, expected, reason: "its number of columns is" });
        }
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
        let mut origin = Vec::with_capacity(self.nnz());
        for j in 0..self.ncols {
            let mut column: Vec<(usize, usize)> = (self.colptr[j]..self.colptr[j + 1])
                .filter_map(|k| new_row[self.rowidx[k]].map(|i| (i, k)))
                .collect();
            column.sort_unstable();
            for (i, k) in column {
                out.rowidx.push(i);
                out.values.push(self.values[k]);
                origin.push(k);
            }
            out.colptr[j + 1] = out.rowidx.len();
        }
        (out, origin)
    }
}

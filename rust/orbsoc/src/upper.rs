//! Patterns of symmetric matrices.

use faer::sparse::SymbolicSparseColMatRef;

/// A square matrix's upper triangle, diagonal included, rows ascending in each column.
#[derive(Clone, Debug, Default)]
pub(crate) struct Upper {
    pub colptr: Vec<usize>,
    pub rowidx: Vec<usize>,
}

/// The items in the order of their keys, all below `dim`; equal ones stay in theirs.
fn ordered(dim: usize, items: Vec<usize>, key: impl Fn(usize) -> usize) -> Vec<usize> {
    let mut next = vec![0; dim + 1];
    for &item in &items {
        next[key(item) + 1] += 1;
    }
    for k in 0..dim {
        next[k + 1] += next[k];
    }
    let mut out = vec![0; items.len()];
    for item in items {
        let place = &mut next[key(item)];
        out[*place] = item;
        *place += 1;
    }
    out
}

impl Upper {
    pub fn dim(&self) -> usize {
        self.colptr.len() - 1
    }

    pub fn nnz(&self) -> usize {
        self.rowidx.len()
    }

    pub fn faer(&self) -> SymbolicSparseColMatRef<'_, usize> {
        SymbolicSparseColMatRef::new_checked(self.dim(), self.dim(), &self.colptr, None, &self.rowidx)
    }

    /// From unordered positions; also returns where each of them went.
    pub fn from_positions(dim: usize, positions: &[(usize, usize)]) -> (Self, Vec<usize>) {
        let by_row = ordered(dim, (0..positions.len()).collect(), |k| positions[k].0);
        let order = ordered(dim, by_row, |k| positions[k].1);
        let mut place = vec![0; positions.len()];
        let mut upper = Self { colptr: vec![0; dim + 1], rowidx: Vec::with_capacity(positions.len()) };
        for (new, &k) in order.iter().enumerate() {
            let (row, column) = positions[k];
            place[k] = new;
            upper.rowidx.push(row);
            upper.colptr[column + 1] += 1;
        }
        for j in 0..dim {
            upper.colptr[j + 1] += upper.colptr[j];
        }
        (upper, place)
    }

    /// The upper triangle of `PKPᵀ`, and where each entry of K went.
    pub fn permuted(&self, order: &[usize]) -> (Self, Vec<usize>) {
        let mut inverse = vec![0; order.len()];
        for (new, &old) in order.iter().enumerate() {
            inverse[old] = new;
        }
        let mut positions = Vec::with_capacity(self.nnz());
        for j in 0..self.dim() {
            for &i in &self.rowidx[self.colptr[j]..self.colptr[j + 1]] {
                let (a, b) = (inverse[i], inverse[j]);
                positions.push((a.min(b), a.max(b)));
            }
        }
        Self::from_positions(self.dim(), &positions)
    }
}

//! The elimination tree, the pattern of L, and whether there is a Cholesky factor. faer owns all of them; nothing of
//! it leaves this file.

use crate::error::Error;
use crate::symbolic::upper::Upper;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::cholesky::simplicial;
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};

/// Parents, those of roots negative, and entries of each column of L.
pub(crate) fn elimination_tree(upper: &Upper) -> (Vec<i32>, Vec<u32>) {
    let (mut parent, mut counts) = (vec![0; upper.dim()], vec![0; upper.dim()]);
    analyse(upper.faer(), &mut parent, &mut counts);
    (parent, counts)
}

fn analyse<'a>(
    upper: SymbolicSparseColMatRef<'_, u32>,
    parent: &'a mut [i32],
    counts: &mut [u32],
) -> simplicial::EliminationTreeRef<'a, u32> {
    let (dim, nnz) = (upper.ncols(), upper.compute_nnz());
    let mut memory = MemBuffer::new(simplicial::prefactorize_symbolic_cholesky_scratch::<u32>(dim, nnz));
    simplicial::prefactorize_symbolic_cholesky(parent, counts, upper, MemStack::new(&mut memory))
}

/// Where the columns of L begin, and their row indices, diagonal first, ascending.
pub(crate) fn columns_of_l(upper: &Upper) -> Result<simplicial::SymbolicSimplicialCholesky<u32>, Error> {
    let (dim, upper) = (upper.dim(), upper.faer());
    let (mut parent, mut counts) = (vec![0; dim], vec![0; dim]);
    let tree = analyse(upper, &mut parent, &mut counts);
    let entries: usize = counts.iter().map(|&count| count as usize).sum();
    if u32::try_from(entries).is_err() {
        return Err(Error::TooLarge { what: "the factor of the KKT matrix", size: entries });
    }
    let mut memory = MemBuffer::new(simplicial::factorize_simplicial_symbolic_cholesky_scratch::<u32>(dim));
    simplicial::factorize_simplicial_symbolic_cholesky(upper, tree, &counts, MemStack::new(&mut memory))
        .map_err(|e| Error::Symbolic(format!("{e:?}")))
}

/// Whether the matrix with these entries, one for each position, has a Cholesky factor.
pub(crate) fn has_cholesky_factor(upper: &Upper, entries: &[f64]) -> Result<bool, Error> {
    let l = columns_of_l(upper)?;
    let mut factor_values = vec![0.0; l.len_val()];
    let scratch = simplicial::factorize_simplicial_numeric_llt_scratch::<u32, f64>(upper.dim());
    let mut memory = MemBuffer::new(scratch);
    let factor = simplicial::factorize_simplicial_numeric_llt(
        &mut factor_values,
        SparseColMatRef::new(upper.faer(), entries),
        LltRegularization::default(),
        &l,
        MemStack::new(&mut memory),
    );
    Ok(factor.is_ok())
}

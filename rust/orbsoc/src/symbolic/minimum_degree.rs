//! Approximate minimum degree, by faer.

use crate::error::Error;
use crate::symbolic::upper::Upper;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::amd;

/// An order of the matrix with little fill: `order[new] = old`.
pub(crate) fn minimum_degree(upper: &Upper) -> Result<Vec<u32>, Error> {
    let dim = upper.dim();
    let (mut order, mut inverse) = (vec![0; dim], vec![0; dim]);
    let mut memory = MemBuffer::new(amd::order_scratch::<u32>(dim, upper.nnz()));
    amd::order(&mut order, &mut inverse, upper.faer(), amd::Control::default(), MemStack::new(&mut memory))
        .map_err(|e| Error::Symbolic(format!("{e:?}")))?;
    Ok(order)
}

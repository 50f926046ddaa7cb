//! What follows from a symmetric matrix's sparsity pattern alone: order, elimination tree, supernodes, index lists.

pub(crate) mod amalgamation;
pub(crate) mod column_blocks;
pub(crate) mod dissection;
pub(crate) mod etree;
pub(crate) mod factor_layout;
pub(crate) mod full_rows;
pub(crate) mod indices;
pub(crate) mod minimum_degree;
pub(crate) mod ordering;
pub(crate) mod supernodes;
pub(crate) mod upper;

//! The arithmetic, one file per PL module.
//!
//! **Contract.** A kernel is a function over plain slices, generic over [`crate::Real`]: sizes come
//! from lengths, outputs are last and alias no input, settings arrive as parameters, and the only
//! constants are literals. It branches on sizes and on the pattern, never on data; it does not
//! allocate, print, look at a clock or panic. `#[inline(always)]` is part of the contract: a kernel
//! must inline into the SIMD dispatch of [`crate::Engine::run`], or it runs on the baseline
//! instruction set.

pub(crate) mod central_pair;
pub(crate) mod cone_ops;
pub(crate) mod decisions;
pub(crate) mod factorization;
pub(crate) mod layout;
pub(crate) mod line_search;
pub(crate) mod linear_solve;
pub(crate) mod matrix_scaling;
pub(crate) mod matrix_update;
pub(crate) mod reduce;
pub(crate) mod right_hand_sides;
pub(crate) mod sparse;
pub(crate) mod statistics;
pub(crate) mod supernodal;

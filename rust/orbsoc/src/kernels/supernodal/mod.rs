//! Factorization and substitution by kinds of supernodes.

pub(crate) mod condensed;
pub(crate) mod panel;
pub(crate) mod pivots;
pub(crate) mod simplicial;
pub(crate) mod update;
pub(crate) mod watch;

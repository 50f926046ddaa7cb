//! The cone K = R₊ˡ × Q^{q₁} × … × Q^{q_k}.

/// Rows of `G`: first `l` nonnegative ones, then second-order cones of dimensions `q`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cones {
    /// Number of nonnegative rows.
    pub l: usize,
    /// Dimensions of the second-order cones `{(t, u): ‖u‖₂ ≤ t}`.
    pub q: Vec<usize>,
}

impl Cones {
    /// Rows in all; `usize::MAX` when there are more than that.
    pub fn dim(&self) -> usize {
        self.q.iter().fold(self.l, |rows, &q| rows.saturating_add(q))
    }
}

/// One second-order cone's place among the rows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Soc {
    /// First row.
    pub start: usize,
    /// Dimension, at least 2.
    pub dim: usize,
    /// Where its two expansion rows begin in the KKT system; `None`: its block is stored dense.
    pub expansion: Option<usize>,
}

impl Soc {
    pub fn rows(&self) -> core::ops::Range<usize> {
        self.start..self.start + self.dim
    }
}

/// Cones as the engine sees them: no cone of dimension 1, no absent row.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct ConeLayout {
    pub l: usize,
    pub soc: Vec<Soc>,
}

impl ConeLayout {
    /// Barrier degree: one per nonnegative row and one per second-order cone.
    pub fn degree(&self) -> usize {
        self.l + self.soc.len()
    }
}

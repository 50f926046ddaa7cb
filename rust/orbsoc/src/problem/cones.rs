//! The cone K = R₊ˡ × Q^{q₁} × … × Q^{q_k}.

use core::ops::Range;

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
    pub fn rows(&self) -> Range<usize> {
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
    /// `body` with the rows and the number of every second-order cone, in their order. The dimensions that guidance
    /// problems have most are constants to the compiler.
    #[inline(always)]
    pub fn each_soc(&self, mut body: impl FnMut(Range<usize>, usize)) {
        for (k, soc) in self.soc.iter().enumerate() {
            match soc.dim {
                3 => body(soc.start..soc.start + 3, k),
                4 => body(soc.start..soc.start + 4, k),
                _ => body(soc.rows(), k),
            }
        }
    }

    /// Barrier degree: one per nonnegative row and one per second-order cone.
    pub fn degree(&self) -> usize {
        self.l + self.soc.len()
    }
}

//! Which entry is which in the small buffers.

/// Entries of the parameter buffer.
pub(crate) mod parameter {
    pub const STATIC_REGULARIZATION: usize = 0;
    pub const PIVOT_FLOOR: usize = 1;
    pub const DYNAMIC_REGULARIZATION: usize = 2;
    pub const STEP_FRACTION: usize = 3;
    pub const REFINEMENT_TOL: usize = 4;
    pub const REFINEMENT_SHARE: usize = 5;
    pub const RESIDUAL_FLOOR: usize = 6;
    pub const START_FLOOR: usize = 7;
    pub const WORDS: usize = 8;
}

/// Entries of the statistics buffer.
pub(crate) mod stat {
    /// The status table's worst ratio, with §1's and the independent verification's denominators alike.
    pub const STRICT: usize = 0;
    pub const PRIMAL: usize = 1;
    pub const DUAL: usize = 2;
    pub const GAP: usize = 3;
    pub const OBJECTIVE: usize = 4;
    pub const DUAL_OBJECTIVE: usize = 5;
    pub const MU: usize = 6;
    /// Certified radii over their problem's scale.
    pub const PRIMAL_RADIUS: usize = 7;
    pub const DUAL_RADIUS: usize = 8;
    /// Zero when the iterate is finite.
    pub const NON_FINITE: usize = 9;
    pub const WORDS: usize = 10;
}

/// Entries of the embedding buffer.
pub(crate) mod embedding {
    /// κ + cᵀx + bᵀy + hᵀz + xᵀPx/τ.
    pub const RESIDUAL: usize = 0;
    pub const TAU_INV: usize = 1;
    /// xᵀPx/τ².
    pub const CURVATURE: usize = 2;
    /// The scalar equation's pivot.
    pub const PIVOT: usize = 3;
    pub const WORDS: usize = 4;
}

/// Entries of the centring buffer.
pub(crate) mod centering {
    /// 1 − σ.
    pub const DAMPING: usize = 0;
    /// σμ.
    pub const TARGET: usize = 1;
    /// Right-hand side of τ dκ + κ dτ = −(·).
    pub const COMPLEMENT: usize = 2;
    /// Weight of the second-order correction.
    pub const CORRECTION: usize = 3;
    pub const WORDS: usize = 4;
}

/// Entries of the regularisation buffer.
pub(crate) mod regularization {
    /// For positive pivots: x, and one unknown of every expanded cone.
    pub const UP: usize = 0;
    /// For negative pivots: y, z, and the other unknown.
    pub const DOWN: usize = 1;
    /// Pivots below this, in the direction of their sign, …
    pub const FLOOR: usize = 2;
    /// … become this.
    pub const REPLACEMENT: usize = 3;
    pub const WORDS: usize = 4;
}

/// Entries of the refinement buffer, for each right-hand side.
pub(crate) mod refinement {
    /// ‖error‖∞; not finite when the error is not.
    pub const ERROR: usize = 0;
    /// An error this small is small enough.
    pub const ALLOWED: usize = 1;
    /// A step that leaves a larger error than this is the last.
    pub const WORTHWHILE: usize = 2;
    pub const WORDS: usize = 3;
}

//! Which entry is which in the small buffers.

/// Entries of the norms.
pub(crate) mod norm {
    pub const B: usize = 0;
    pub const H: usize = 1;
    pub const C: usize = 2;
    /// What a radius of primal infeasibility is compared with …
    pub const PRIMAL_SCALE: usize = 3;
    /// … and one of dual infeasibility.
    pub const DUAL_SCALE: usize = 4;
    pub const WORDS: usize = 5;
}

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

/// Entries of the control buffer: what an attempt decides by, and what it has decided.
pub(crate) mod control {
    /// Why the attempt ends, one of [`super::stop`]; 0 while it goes on. It stays until the next attempt.
    pub const STOP: usize = 0;
    /// The next linear solve needs its residual.
    pub const NEEDS_RESIDUAL: usize = 1;
    /// Largest known error before any refinement; 0: none is known.
    pub const KNOWN_ERROR: usize = 2;
    /// The factors of the last residual check are still in use.
    pub const SAME_FACTORS: usize = 3;
    /// Refinement tolerance of this iteration.
    pub const TOLERANCE: usize = 4;
    /// It may tell that a residual needs no check.
    pub const TRUSTED: usize = 5;
    /// It is no smaller than that of the iteration before.
    pub const RISEN: usize = 6;
    /// Refinement steps of the linear solve under way …
    pub const REFINED: usize = 7;
    /// … and of the attempt.
    pub const REFINEMENTS: usize = 8;
    /// The smallest worst ratio so far.
    pub const BEST: usize = 9;
    /// It meets the tolerance.
    pub const MET: usize = 10;
    /// Iterations without progress.
    pub const STALLED_ITERATIONS: usize = 11;
    /// Short steps in a row.
    pub const SHORT_STEPS: usize = 12;
    /// Steps taken since the attempt began.
    pub const ITERATION: usize = 13;
    /// Length of the last.
    pub const STEP: usize = 14;
    /// The largest radii that counted.
    pub const PRIMAL_RADIUS: usize = 15;
    pub const DUAL_RADIUS: usize = 16;
    /// The attempt's limits: the worst ratio that ends it, …
    pub const TOLERANCE_AIM: usize = 17;
    /// … that which ends it after one iteration more, …
    pub const TOLERANCE_MET: usize = 18;
    /// … iterations, refinement steps of a linear solve, …
    pub const MAX_ITERATIONS: usize = 19;
    pub const MAX_REFINEMENTS: usize = 20;
    /// … whether it may skip residual checks, and whether it began from a given point.
    pub const TRUSTING: usize = 21;
    pub const WARM: usize = 22;
    /// The least primal, dual and gap ratio that was progress.
    pub const LEAST: usize = 23;
    pub const WORDS: usize = 26;
}

/// Why an attempt ends, as a word, in the order in which the reasons are tested.
pub(crate) mod stop {
    pub const NONE: f64 = 0.0;
    pub const NOT_FINITE: f64 = 1.0;
    pub const CONVERGED: f64 = 2.0;
    pub const PRIMAL_CERTIFICATE: f64 = 3.0;
    pub const DUAL_CERTIFICATE: f64 = 4.0;
    pub const WARM_START_REJECTED: f64 = 5.0;
    /// Asked for from outside; no stage computes it.
    pub const INTERRUPTED: f64 = 6.0;
    pub const MAX_ITERATIONS: f64 = 7.0;
    /// Nor this.
    pub const MAX_TIME: f64 = 8.0;
    pub const STALLED: f64 = 9.0;
}

//! Every buffer of a solve, allocated once. A buffer is the unit of dataflow: stages declare which
//! they read and write, and the emulated computer moves them whole.

use crate::kernels::cone_ops::SCALARS;
use crate::kernels::layout::{
    centering, control, embedding, norm, parameter, refinement, regularization, stat,
};
use crate::kkt::structure::Structure;

macro_rules! buffers {
    ($($(#[$doc:meta])* $name:ident $field:ident $label:literal = $entries:expr;)*) => {
        /// A named buffer.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Buffer { $($(#[$doc])* $name,)* }

        impl Buffer {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$name,)*];

            /// The name in traces.
            pub fn name(self) -> &'static str {
                match self { $(Self::$name => $label,)* }
            }
        }

        #[derive(Clone, Debug)]
        pub(crate) struct Workspace<T> {
            $(pub $field: Vec<T>,)*
            /// Kernel-local entries: never carry anything from one stage to the next.
            pub scratch: Vec<T>,
            /// P before its cost factor, for other vectors beside the same matrices: [`Datapath::execute_as_needed`].
            ///
            /// [`Datapath::execute_as_needed`]: crate::method::datapath::Datapath::execute_as_needed
            pub equilibrated_p: Vec<T>,
        }

        impl<T: Copy> Workspace<T> {
            pub fn new(structure: &Structure, zero: T) -> Self {
                let scratch = scratch_entries(structure);
                Self {
                    $($field: vec![zero; ($entries)(structure)],)*
                    scratch: vec![zero; scratch],
                    equilibrated_p: vec![zero; structure.cost.nnz()],
                }
            }

            pub fn get(&self, buffer: Buffer) -> &[T] {
                match buffer { $(Buffer::$name => &self.$field,)* }
            }

            pub fn get_mut(&mut self, buffer: Buffer) -> &mut [T] {
                match buffer { $(Buffer::$name => &mut self.$field,)* }
            }
        }
    };
}

pub(crate) fn scratch_entries(s: &Structure) -> usize {
    let products = 2 * s.n + s.p + s.m;
    let refinement = 2 * (2 * s.kkt.dim + s.kkt.symbolic.substitution_scratch);
    products.max(s.unknowns()).max(refinement).max(s.kkt.symbolic.max_panel)
}

buffers! {
    /// Entries of P's upper triangle, as given.
    RawP raw_p "raw_p" = |s: &Structure| s.cost.nnz();
    /// Entries of A, as given.
    RawA raw_a "raw_a" = |s: &Structure| s.equality.nnz();
    /// Entries of G, as given.
    RawG raw_g "raw_g" = |s: &Structure| s.conic.nnz();
    /// (c, b, h), as given.
    RawQ raw_q "raw_q" = Structure::unknowns;
    /// A point to start from, as given: (x, y, z), s.
    Start start "start" = |s: &Structure| s.unknowns() + s.m;
    /// ‖b‖∞, ‖h‖∞, ‖c‖∞ as given, and what radii of primal and dual infeasibility are compared with.
    Norms norms "norms" = |_: &Structure| norm::WORDS;
    /// Settings in the order of `parameter`.
    Parameters parameters "parameters" = |_: &Structure| parameter::WORDS;
    /// Scaled P.
    P p "p" = |s: &Structure| s.cost.nnz();
    /// Scaled A.
    A a "a" = |s: &Structure| s.equality.nnz();
    /// Scaled G.
    G g "g" = |s: &Structure| s.conic.nnz();
    /// Scaled (c, b, h).
    Q q "q" = Structure::unknowns;
    /// (D, E, F).
    Scale scale "scale" = Structure::unknowns;
    /// Reciprocals of (D, E, F).
    ScaleInverse scale_inverse "scale_inverse" = Structure::unknowns;
    /// γ, 1/γ.
    CostScale cost_scale "cost_scale" = |_: &Structure| 2;
    /// (x, y, z).
    Point point "point" = Structure::unknowns;
    /// s.
    Slack slack "slack" = |s: &Structure| s.m;
    /// τ, κ, and whether a step was taken.
    Homogenizer homogenizer "homogenizer" = |_: &Structure| 3;
    /// Residuals of (x, y, z) in the embedding.
    Residual residual "residual" = Structure::unknowns;
    /// Px.
    CostProduct cost_product "cost_product" = |s: &Structure| s.n;
    /// Scalars of the embedding's last equation.
    Embedding embedding "embedding" = |_: &Structure| embedding::WORDS;
    /// 1 − σ, σμ, τ's complementarity, weight of the correction.
    Centering centering "centering" = |_: &Structure| centering::WORDS;
    /// What termination compares.
    Statistics statistics "statistics" = |_: &Structure| stat::WORDS;
    /// Scaling point.
    W w "w" = |s: &Structure| s.m;
    /// λ = Wz.
    Lambda lambda "lambda" = |s: &Structure| s.m;
    /// 1/λ on nonnegative rows.
    LambdaInverse lambda_inverse "lambda_inverse" = |s: &Structure| s.cones.l;
    /// Scalars of each second-order cone's scaling.
    Cone cone "cone" = |s: &Structure| s.cones.soc.len() * SCALARS;
    /// Permuted upper triangle of the KKT matrix, unregularised.
    KktValues kkt_values "kkt_values" = |s: &Structure| s.kkt.nnz();
    /// What is added to the diagonal for positive pivots and subtracted for negative ones; the least pivot,
    /// and what replaces a smaller one.
    Regularization regularization "regularization" = |_: &Structure| regularization::WORDS;
    /// Columns of L.
    FactorL factor_l "factor_l" = |s: &Structure| s.kkt.symbolic.panel_entries;
    /// 1/D.
    PivotInverse pivot_inverse "pivot_inverse" = |s: &Structure| s.kkt.dim;
    /// Right-hand side in permuted order.
    KktRhs kkt_rhs "kkt_rhs" = |s: &Structure| s.kkt.dim;
    /// Solution in permuted order.
    KktSolution kkt_solution "kkt_solution" = |s: &Structure| s.kkt.dim;
    /// Right-hand side minus K times solution.
    KktError kkt_error "kkt_error" = |s: &Structure| s.kkt.dim;
    /// Two right-hand sides side by side, in permuted order.
    MultiRhs multi_rhs "pair_rhs" = |s: &Structure| 2 * s.kkt.dim;
    /// Their solutions.
    MultiSolution multi_solution "pair_solution" = |s: &Structure| 2 * s.kkt.dim;
    /// Their errors.
    MultiError multi_error "pair_error" = |s: &Structure| 2 * s.kkt.dim;
    /// Largest error of a linear solve that is small enough for this iteration.
    RefinementTolerance refinement_tolerance "refinement_goal" = |_: &Structure| 1;
    /// Norm of the error, what it may be and what it must fall below to go on refining.
    Refinement refinement "refinement" = |_: &Structure| refinement::WORDS;
    /// The same for each of a pair.
    MultiRefinement multi_refinement "pair_refinement" = |_: &Structure| 2 * refinement::WORDS;
    /// Zero once a problem's refinement has ended: other lanes' does not move it.
    RefinementActive refinement_active "refinement_active" = |_: &Structure| 1;
    /// Solution for (−c, b, h).
    ConstantSolution constant_solution "constant" = Structure::unknowns;
    /// Direction of (x, y, z).
    Step step "step" = Structure::unknowns;
    /// dτ, dκ.
    TauStep tau_step "tau_step" = |_: &Structure| 2;
    /// W dz.
    ScaledZ scaled_z "scaled_z" = |s: &Structure| s.m;
    /// W⁻¹ ds.
    ScaledS scaled_s "scaled_s" = |s: &Structure| s.m;
    /// ds.
    SlackStep slack_step "slack_step" = |s: &Structure| s.m;
    /// Right-hand side of the scaled complementarity.
    ComplementarityRhs complementarity_rhs "complement" = |s: &Structure| s.m;
    /// λ \ complement.
    ConeDivision cone_division "quotient" = |s: &Structure| s.m;
    /// Largest step to the boundary.
    StepLength step_length "step_length" = |_: &Structure| 1;
    /// Fraction to the boundary.
    BoundaryFraction boundary_fraction "boundary_share" = |_: &Structure| 1;
    /// The step that was taken.
    StepTaken step_taken "step_taken" = |_: &Structure| 1;
    /// What an attempt decides by, and what it has decided.
    Control control "control" = |_: &Structure| control::WORDS;
    /// Whether a warm start is rejected.
    Verdict verdict "verdict" = |_: &Structure| 1;
    /// Best iterate so far: point, slack, τ.
    Best best "best" = |s: &Structure| s.unknowns() + s.m + 1;
    /// Point with the largest radius of primal infeasibility.
    PrimalCertificate primal_certificate "farkas" = Structure::unknowns;
    /// Point and slack with the largest radius of dual infeasibility.
    DualCertificate dual_certificate "ray" = |s: &Structure| s.unknowns() + s.m;
    /// Best iterate in the user's scaling: point, slack.
    UnscaledIterate unscaled_iterate "answer" = |s: &Structure| s.unknowns() + s.m;
    /// Certificates in the user's scaling: primal infeasibility's point, dual infeasibility's point.
    UnscaledCertificates unscaled_certificates "witness" = |s: &Structure| 2 * s.unknowns();
}

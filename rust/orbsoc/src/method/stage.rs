//! The iteration as data. Two constant lists and a closing one are the method; any caller that runs them,
//! in Rust or on an emulated processing system, runs the same solve.

use crate::method::workspace::Buffer;
use crate::outcome::verification::Stop;

/// The module that a stage belongs to: what a partition places on programmable logic or on the processing system.
/// To the solver these are names; what they cost is someone else's business.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub enum Module {
    Statistics,
    MatrixUpdate,
    MatrixScaling,
    Factorization,
    LinearSolve,
    ConeOps,
    LineSearch,
}

impl Module {
    /// The name in traces and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Statistics => "statistics",
            Self::MatrixUpdate => "matrix_update",
            Self::MatrixScaling => "matrix_scaling",
            Self::Factorization => "factorization",
            Self::LinearSolve => "linear_solve",
            Self::ConeOps => "cone_ops",
            Self::LineSearch => "line_search",
        }
    }
}

/// One entry of a schedule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Run a stage once.
    Run(Stage),
    /// Run `until`; while it answers [`Outcome::Repeat`], run `stage` and ask again.
    Repeat {
        /// What is repeated.
        stage: Stage,
        /// What decides.
        until: Stage,
    },
}

impl Step {
    /// Run its stage, or both in turn for as long as `until` asks to repeat; the last outcome.
    pub fn perform(self, run: &mut impl FnMut(Stage) -> Outcome) -> Outcome {
        match self {
            Self::Run(stage) => run(stage),
            Self::Repeat { stage, until } => loop {
                match run(until) {
                    Outcome::Repeat => run(stage),
                    outcome => return outcome,
                };
            },
        }
    }
}

/// What running a stage asks of the loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Go on.
    Next,
    /// Run the repeated stage once more.
    Repeat,
    /// Leave the iteration.
    Done(Stop),
}

macro_rules! stages {
    ($($(#[$doc:meta])* $stage:ident $label:literal $module:ident
        reads [$($read:ident)*] writes [$($write:ident)*] stales [$($stale:ident)*];)*) => {
        /// A unit of work with declared inputs and outputs.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Stage { $($(#[$doc])* $stage,)* }

        impl Stage {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$stage,)*];

            /// The name in traces and schedules.
            pub fn name(self) -> &'static str {
                match self { $(Self::$stage => $label,)* }
            }

            /// Where it runs.
            pub fn module(self) -> Module {
                match self { $(Self::$stage => Module::$module,)* }
            }

            /// Buffers whose entries it uses.
            pub fn reads(self) -> &'static [Buffer] {
                match self { $(Self::$stage => &[$(Buffer::$read,)*],)* }
            }

            /// Buffers whose entries it makes; a buffer also listed under `reads` is updated.
            pub fn writes(self) -> &'static [Buffer] {
                match self { $(Self::$stage => &[$(Buffer::$write,)*],)* }
            }

            /// Buffers that no longer fit what it wrote, until they are written again. A buffer also
            /// listed under `writes` is left unfinished: only a stage that updates it may read it.
            pub fn stales(self) -> &'static [Buffer] {
                match self { $(Self::$stage => &[$(Buffer::$stale,)*],)* }
            }
        }
    };
}

stages! {
    /// Ruiz equilibration of the problem data.
    Equilibrate "equilibrate" MatrixScaling
        reads [RawP RawA RawG RawQ]
        writes [P A G Q Scale ScaleInverse CostScale]
        stales [KktValues FactorL PivotInverse];
    /// Problem data into the KKT matrix.
    LoadKkt "load_kkt" MatrixUpdate reads [P A G] writes [KktValues]
        stales [KktValues FactorL PivotInverse];
    /// −I as scaling blocks, for the starting point.
    IdentityBlocks "identity_blocks" MatrixUpdate
        reads [Parameters KktValues] writes [KktValues Regularization] stales [FactorL PivotInverse];
    /// −W² as scaling blocks.
    ScalingBlocks "scaling_blocks" MatrixUpdate
        reads [KktValues W Cone] writes [KktValues] stales [FactorL PivotInverse];
    /// K + regularisation = LDLᵀ.
    Factorize "factorize" Factorization
        reads [KktValues Regularization] writes [FactorL PivotInverse]
        stales [KktSolution KktError Refinement MultiSolution MultiError MultiRefinement ConstantSolution];
    /// (0 or −c, b, h) for the starting x and s, (−c, 0 or b, 0 or h) for y and z.
    StartRhs "start_rhs" LinearSolve reads [Q] writes [MultiRhs RefinementTolerance]
        stales [MultiSolution MultiError MultiRefinement];
    /// x, s = −z, and y, z of the starting solves; s with what StartRhs left out of h.
    StartPoint "start_point" LinearSolve reads [Q MultiSolution] writes [Point Slack]
        stales [MultiRhs Residual];
    /// Shift s and z into the cone; τ = κ = 1.
    StartShift "start_shift" ConeOps reads [Point Slack] writes [Point Slack Homogenizer] stales [Residual];
    /// A given point in the scaling of the data; τ = 1, κ = 0.
    LoadStart "load_start" MatrixScaling
        reads [Start Scale ScaleInverse CostScale] writes [Point Slack Homogenizer] stales [Residual];
    /// Onto the central path, where the residuals suggest.
    CenterStart "center_start" ConeOps
        reads [Parameters Residual Point Slack] writes [Point Slack Homogenizer Verdict]
        stales [Residual CostProduct Statistics];
    /// (−c, b, h − 2s): from a central pair to the equations of the data.
    NewtonStartRhs "newton_start_rhs" LinearSolve
        reads [Q Slack] writes [KktRhs] stales [KktSolution KktError Refinement];
    /// That step, and onto the central path again, where the distance there suggests.
    NewtonStart "newton_start" ConeOps
        reads [KktSolution W Cone Point Slack Homogenizer]
        writes [Point Slack Homogenizer Verdict] stales [KktRhs Residual W Lambda LambdaInverse Cone];
    /// Residuals, gap, μ; decides termination, and keeps the best iterate and certificates.
    Statistics "statistics" Statistics
        reads [Parameters P A G Q Norms ScaleInverse CostScale Point Slack Homogenizer Control Best PrimalCertificate DualCertificate]
        writes [Residual CostProduct Embedding Centering Statistics RefinementTolerance Regularization Control Best PrimalCertificate DualCertificate]
        stales [Embedding FactorL PivotInverse];
    /// Nesterov–Todd scaling at the iterate.
    NtScaling "nt_scaling" ConeOps
        reads [Point Slack] writes [W Lambda LambdaInverse Cone] stales [KktValues FactorL PivotInverse];
    /// Right-hand sides (−c, b, h) and the predictor's.
    PredictorRhs "predictor_rhs" ConeOps
        reads [Q Residual Slack Lambda] writes [MultiRhs ConeDivision]
        stales [MultiSolution MultiError MultiRefinement ConstantSolution Step];
    /// Substitute two right-hand sides through the factors; leave the refinement residuals and their norms.
    SolveConstantAndPredictor "solve_pair" LinearSolve
        reads [Parameters RefinementTolerance KktValues FactorL PivotInverse MultiRhs]
        writes [MultiSolution MultiError MultiRefinement RefinementActive] stales [];
    /// One refinement step of both, kept where it made the residual smaller.
    RefineConstantAndPredictor "refine_pair" LinearSolve
        reads [KktValues FactorL PivotInverse MultiRhs MultiSolution MultiError MultiRefinement RefinementActive]
        writes [MultiSolution MultiError MultiRefinement] stales [];
    /// Decides on one more refinement step of both.
    CheckConstantAndPredictor "check_pair" Statistics reads [MultiRefinement RefinementActive Control] writes [RefinementActive Control] stales [];
    /// The solution for (−c, b, h), and the predictor for dτ = 0.
    StoreConstantAndPredictor "store_pair" LinearSolve reads [MultiSolution] writes [ConstantSolution Step]
        stales [MultiRhs TauStep ScaledZ ScaledS];
    /// Substitute through the factors; leave the refinement residual and its norm.
    SolveKkt "solve_kkt" LinearSolve
        reads [Parameters RefinementTolerance KktValues FactorL PivotInverse KktRhs]
        writes [KktSolution KktError Refinement RefinementActive] stales [];
    /// One refinement step, kept where it made the residual smaller.
    RefineKkt "refine_kkt" LinearSolve
        reads [KktValues FactorL PivotInverse KktRhs KktSolution KktError Refinement RefinementActive]
        writes [KktSolution KktError Refinement] stales [];
    /// Decides on one more refinement step.
    CheckSolve "check_solve" Statistics reads [Refinement RefinementActive Control] writes [RefinementActive Control] stales [];
    /// Pivot of the embedding's scalar equation.
    EmbeddingPivot "embedding_pivot" Statistics
        reads [Q ConstantSolution CostProduct Homogenizer Embedding] writes [Embedding] stales [];
    /// The solution in natural order.
    StoreStep "store_step" LinearSolve reads [KktSolution] writes [Step]
        stales [KktRhs TauStep ScaledZ ScaledS];
    /// dτ and dκ.
    TauStep "tau_step" Statistics
        reads [Q Step CostProduct Homogenizer Embedding Centering] writes [TauStep] stales [];
    /// The direction with dτ, and W dz, W⁻¹ds.
    Direction "direction" ConeOps
        reads [Step ConstantSolution TauStep W Cone ConeDivision] writes [Step ScaledZ ScaledS] stales [StepLength SlackStep];
    /// The largest step that stays in the cone.
    StepLength "step_length" LineSearch
        reads [Homogenizer TauStep Lambda LambdaInverse Cone ScaledS ScaledZ] writes [StepLength] stales [Centering];
    /// σ = (1 − α)², and how near to the boundary the step may go.
    Centering "centering" Statistics
        reads [Parameters StepLength Statistics Homogenizer TauStep] writes [Centering BoundaryFraction] stales [];
    /// λ∘λ + (W⁻¹ds)∘(W dz) − σμe.
    ConeProduct "cone_product" Statistics
        reads [Lambda ScaledS ScaledZ Centering] writes [ComplementarityRhs] stales [];
    /// Right-hand side of the corrector.
    CorrectorRhs "corrector_rhs" ConeOps
        reads [Residual Centering Lambda LambdaInverse W Cone ComplementarityRhs]
        writes [KktRhs ConeDivision] stales [KktSolution KktError Refinement Step];
    /// ds = W(W⁻¹ds).
    SlackStep "slack_step" ConeOps reads [W Cone ScaledS] writes [SlackStep] stales [];
    /// Take the step.
    Advance "advance" Statistics
        reads [BoundaryFraction StepLength Step SlackStep TauStep Point Slack Homogenizer Control]
        writes [StepTaken Point Slack Homogenizer Control]
        stales [Residual CostProduct Statistics W Lambda LambdaInverse Cone];
    /// Iterate and certificates in the user's scaling.
    Unscale "unscale" MatrixScaling
        reads [Scale ScaleInverse CostScale Best PrimalCertificate DualCertificate] writes [UnscaledIterate UnscaledCertificates] stales [];
}

/// A word that a stage leaves for what runs the lists: the first of a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flag {
    /// Not zero: run the repeated stage once more.
    Repeat(Buffer),
    /// Not zero: leave the iteration; the word says why.
    Stop(Buffer),
}

impl Stage {
    /// The flag by which a stage decides, if it does.
    pub fn flag(self) -> Option<Flag> {
        match self {
            Self::Statistics => Some(Flag::Stop(Buffer::Control)),
            Self::CenterStart | Self::NewtonStart => Some(Flag::Stop(Buffer::Verdict)),
            Self::CheckSolve | Self::CheckConstantAndPredictor => {
                Some(Flag::Repeat(Buffer::RefinementActive))
            }
            _ => None,
        }
    }
}

use Stage::{
    Advance, CenterStart, Centering, CheckConstantAndPredictor, CheckSolve, ConeProduct, CorrectorRhs,
    Direction, EmbeddingPivot, Equilibrate, Factorize, IdentityBlocks, LoadKkt, LoadStart, NewtonStart,
    NewtonStartRhs, NtScaling, PredictorRhs, RefineConstantAndPredictor, RefineKkt, ScalingBlocks, SlackStep,
    SolveConstantAndPredictor, SolveKkt, StartPoint, StartRhs, StartShift, Statistics, StepLength,
    StoreConstantAndPredictor, StoreStep, TauStep, Unscale,
};
use Step::{Repeat, Run};

const REFINE: Step = Repeat { stage: RefineKkt, until: CheckSolve };
const REFINE_MULTI: Step = Repeat { stage: RefineConstantAndPredictor, until: CheckConstantAndPredictor };

/// From problem data to a point inside the cone. Run once.
pub const STARTUP: &[Step] = &[
    Run(Equilibrate),
    Run(LoadKkt),
    Run(IdentityBlocks),
    Run(Factorize),
    Run(StartRhs),
    Run(SolveConstantAndPredictor),
    REFINE_MULTI,
    Run(StartPoint),
    Run(StartShift),
];

/// From problem data and a point nearby to a point inside the cone. Run once, in place of [`STARTUP`];
/// it may answer [`Outcome::Done`].
pub const WARM_STARTUP: &[Step] = &[
    Run(Equilibrate),
    Run(LoadKkt),
    Run(LoadStart),
    Run(Statistics),
    Run(CenterStart),
    Run(NtScaling),
    Run(ScalingBlocks),
    Run(Factorize),
    Run(NewtonStartRhs),
    Run(SolveKkt),
    REFINE,
    Run(NewtonStart),
];

/// One predictor–corrector iteration. Run until a stage answers [`Outcome::Done`].
pub const ITERATION: &[Step] = &[
    Run(Statistics),
    Run(NtScaling),
    Run(ScalingBlocks),
    Run(Factorize),
    Run(PredictorRhs),
    Run(SolveConstantAndPredictor),
    REFINE_MULTI,
    Run(StoreConstantAndPredictor),
    Run(EmbeddingPivot),
    Run(TauStep),
    Run(Direction),
    Run(StepLength),
    Run(Centering),
    Run(ConeProduct),
    Run(CorrectorRhs),
    Run(SolveKkt),
    REFINE,
    Run(StoreStep),
    Run(TauStep),
    Run(Direction),
    Run(SlackStep),
    Run(StepLength),
    Run(Advance),
];

/// Back to the user's scaling. Run once, after the iteration.
pub const CLOSING: &[Step] = &[Run(Unscale)];

/// Buffers that hold inputs, or entries that a stage reads only after it wrote them itself.
const GIVEN: &[Buffer] = &[
    Buffer::RawP,
    Buffer::RawA,
    Buffer::RawG,
    Buffer::RawQ,
    Buffer::Start,
    Buffer::Norms,
    Buffer::Parameters,
    Buffer::Control,
    Buffer::Best,
    Buffer::PrimalCertificate,
    Buffer::DualCertificate,
];

/// A stage that would read entries that were never written, or written before something they depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScheduleError {
    /// The stage.
    pub stage: Stage,
    /// What it would read.
    pub buffer: Buffer,
    /// True: written once, but stale since; false: never written.
    pub stale: bool,
}

impl core::fmt::Display for ScheduleError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let why = if self.stale { "is stale there" } else { "was never written" };
        write!(f, "stage `{}` reads buffer `{}`, which {why}", self.stage.name(), self.buffer.name())
    }
}

impl std::error::Error for ScheduleError {}

/// Buffers of which other stages make only a part stale; an update in place makes them whole again.
const PARTLY_STALE: &[Buffer] = &[Buffer::KktValues];

/// What a schedule has made of a buffer so far.
#[derive(Clone, Copy, PartialEq, Eq)]
enum BufferState {
    Absent,
    Fresh,
    /// A stage that updates them may read them.
    Unfinished,
    Stale,
}

/// Check a schedule against the dataflow table: every entry read was written and is not stale. The
/// iteration is checked twice, so that what it leaves behind must suit its own beginning.
/// A stage may read an unfinished buffer that it also writes: it updates it in place.
///
/// # Errors
/// The first offending read.
pub fn check_schedule(startup: &[Step], iteration: &[Step], closing: &[Step]) -> Result<(), ScheduleError> {
    let given = |buffer| if GIVEN.contains(buffer) { BufferState::Fresh } else { BufferState::Absent };
    let mut states: Vec<BufferState> = Buffer::ALL.iter().map(given).collect();
    let order = [startup, iteration, iteration, closing].concat();
    let stages = order.into_iter().flat_map(|step| match step {
        Run(stage) => [Some(stage), None],
        Repeat { stage, until } => [Some(until), Some(stage)],
    });
    for stage in stages.flatten() {
        let writes = |buffer| stage.writes().contains(&buffer);
        for &buffer in stage.reads() {
            let state = states[buffer as usize];
            if state != BufferState::Fresh && !(state == BufferState::Unfinished && writes(buffer)) {
                return Err(ScheduleError { stage, buffer, stale: state != BufferState::Absent });
            }
        }
        for &buffer in stage.writes() {
            states[buffer as usize] = BufferState::Fresh;
        }
        for &buffer in stage.stales() {
            let unfinished = writes(buffer) || PARTLY_STALE.contains(&buffer);
            states[buffer as usize] = match states[buffer as usize] {
                BufferState::Absent => BufferState::Absent,
                _ if unfinished => BufferState::Unfinished,
                _ => BufferState::Stale,
            };
        }
    }
    Ok(())
}

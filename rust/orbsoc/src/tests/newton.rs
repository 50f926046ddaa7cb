//! The direction that a dozen stages make together, against the equations it is meant to solve
//! (docs/algorithm.md §1 and §4), written down densely on the scaled data.

use crate::kernels::cone_ops;
use crate::kernels::layout::{embedding, stat};
use crate::kkt::structure::Pattern;
use crate::tests::reference::{dot, iterate_from_startup, jordan, mixed_problem, norm};
use crate::{Buffer, Engine, Outcome, Settings, Stage, Step, ITERATION};

/// The scaled problem, and an iterate with a direction.
struct At {
    engine: Engine<f64>,
}

struct Split {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
}

impl At {
    fn entries(&self, buffer: Buffer) -> &[f64] {
        self.engine.buffer(buffer)
    }

    fn split(&self, buffer: Buffer) -> Split {
        let (s, entries) = (&self.engine.path.structure, self.entries(buffer));
        Split {
            x: entries[..s.n].to_vec(),
            y: entries[s.n..s.n + s.p].to_vec(),
            z: entries[s.n + s.p..].to_vec(),
        }
    }

    fn pattern_product(
        &self,
        pattern: &Pattern,
        values: &[f64],
        rows: usize,
        x: &[f64],
    ) -> (Vec<f64>, Vec<f64>) {
        let n = self.engine.path.structure.n;
        let (mut forward, mut transposed) = (vec![0.0; rows], vec![0.0; n]);
        for j in 0..n {
            for k in pattern.column(j) {
                let i = pattern.rows(k..k + 1)[0] as usize;
                if x.len() == n {
                    forward[i] += values[k] * x[j];
                }
                if x.len() == rows {
                    transposed[j] += values[k] * x[i];
                }
            }
        }
        (forward, transposed)
    }

    fn p(&self, x: &[f64]) -> Vec<f64> {
        let s = &self.engine.path.structure;
        let (upper, lower) = self.pattern_product(&s.cost, self.entries(Buffer::P), s.n, x);
        let mut diagonal = vec![0.0; s.n];
        for (j, entry) in diagonal.iter_mut().enumerate() {
            for k in s.cost.column(j) {
                if s.cost.rows(k..k + 1)[0] as usize == j {
                    *entry = self.entries(Buffer::P)[k] * x[j];
                }
            }
        }
        (0..s.n).map(|j| upper[j] + lower[j] - diagonal[j]).collect()
    }

    fn a(&self, x: &[f64]) -> Vec<f64> {
        let s = &self.engine.path.structure;
        self.pattern_product(&s.equality, self.entries(Buffer::A), s.p, x).0
    }

    fn g(&self, x: &[f64]) -> Vec<f64> {
        let s = &self.engine.path.structure;
        self.pattern_product(&s.conic, self.entries(Buffer::G), s.m, x).0
    }

    /// Aᵀy + Gᵀz.
    fn transposed(&self, at: &Split) -> Vec<f64> {
        let s = &self.engine.path.structure;
        let a = self.pattern_product(&s.equality, self.entries(Buffer::A), s.p, &at.y).1;
        let g = self.pattern_product(&s.conic, self.entries(Buffer::G), s.m, &at.z).1;
        a.iter().zip(&g).map(|(a, g)| a + g).collect()
    }

    fn scale(&self, x: &[f64]) -> Vec<f64> {
        let (cones, mut out) = (&self.engine.path.structure.cones, vec![0.0; x.len()]);
        cone_ops::scale(cones, self.entries(Buffer::W), self.entries(Buffer::Cone), x, &mut out);
        out
    }
}

/// Run `before` iterations, then the next one up to and with the `count`th run of `last`.
fn stop_after(seed: u64, before: usize, last: Stage, count: usize) -> At {
    // Refined to the last digit, or the equations hold to a fraction of the residual only.
    let settings = Settings { refinement_share: 1e-15, refinement_tol: 1e-15, ..Settings::default() };
    let mut engine = Engine::<f64>::new(&mixed_problem(seed), &settings).unwrap();
    iterate_from_startup(&mut engine, before);
    let mut seen = 0;
    for step in ITERATION {
        match *step {
            Step::Run(stage) => {
                engine.run(stage);
                seen += usize::from(stage == last);
            }
            Step::Repeat { stage, until } => {
                while engine.run(until) == Outcome::Repeat {
                    engine.run(stage);
                }
            }
        }
        if seen == count {
            break;
        }
    }
    At { engine }
}

/// combine(a, b) entry by entry.
fn each(a: &[f64], b: &[f64], combine: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| combine(*a, *b)).collect()
}

/// The sum is zero to 1e-9 of its largest term.
fn assert_cancels(terms: &[Vec<f64>], name: &str) {
    let size = terms.iter().map(|term| norm(term)).fold(1e-300, f64::max);
    for i in 0..terms[0].len() {
        let sum: f64 = terms.iter().map(|term| term[i]).sum();
        assert!(sum.abs() <= 1e-9 * size, "{name}, entry {i}: {sum:e} of {size:e}");
    }
}

fn times(factor: f64, v: &[f64]) -> Vec<f64> {
    v.iter().map(|v| factor * v).collect()
}

/// Newton's equations with residuals reduced by θ, and complementarity targets t and t_κ.
fn assert_direction(at: &At, theta: f64, target: &[f64], target_kappa: f64) {
    let (point, step, residual) =
        (at.split(Buffer::Point), at.split(Buffer::Step), at.split(Buffer::Residual));
    let (tau, kappa) = (at.entries(Buffer::Homogenizer)[0], at.entries(Buffer::Homogenizer)[1]);
    let (d_tau, d_kappa) = (at.entries(Buffer::TauStep)[0], at.entries(Buffer::TauStep)[1]);
    let q = at.split(Buffer::Q);
    let slack_step = at.scale(at.entries(Buffer::ScaledS));
    assert_cancels(
        &[at.p(&step.x), at.transposed(&step), times(d_tau, &q.x), times(theta, &residual.x)],
        "stationarity",
    );
    assert_cancels(&[at.a(&step.x), times(-d_tau, &q.y), times(theta, &residual.y)], "equality");
    assert_cancels(&[at.g(&step.x), slack_step, times(-d_tau, &q.z), times(theta, &residual.z)], "cone rows");
    // λ ∘ (W dz + W⁻¹ds) = −t.
    let scaled = each(at.entries(Buffer::ScaledZ), at.entries(Buffer::ScaledS), |z, s| z + s);
    let cones = &at.engine.path.structure.cones;
    assert_cancels(&[jordan(cones, at.entries(Buffer::Lambda), &scaled), target.to_vec()], "complementarity");
    assert_cancels(&[vec![tau * d_kappa], vec![kappa * d_tau], vec![target_kappa]], "τκ");
    let px = at.p(&point.x);
    let curvature = dot(&point.x, &px) / (tau * tau);
    let terms = [
        d_kappa,
        dot(&q.x, &step.x) + dot(&q.y, &step.y) + dot(&q.z, &step.z),
        2.0 / tau * dot(&px, &step.x),
        -curvature * d_tau,
        theta * at.entries(Buffer::Embedding)[embedding::RESIDUAL],
    ];
    assert_cancels(&terms.map(|term| vec![term]), "the last equation");
}

#[test]
fn residuals_are_those_of_the_embedding() {
    for before in [0, 1, 3] {
        let at = stop_after(8, before, Stage::Statistics, 1);
        let (point, residual, q) = (at.split(Buffer::Point), at.split(Buffer::Residual), at.split(Buffer::Q));
        let (tau, kappa) = (at.entries(Buffer::Homogenizer)[0], at.entries(Buffer::Homogenizer)[1]);
        let (px, slack) = (at.p(&point.x), at.entries(Buffer::Slack).to_vec());
        let minus = |v: &[f64]| times(-1.0, v);
        assert_cancels(&[px.clone(), at.transposed(&point), times(tau, &q.x), minus(&residual.x)], "r_x");
        assert_cancels(&[at.a(&point.x), times(-tau, &q.y), minus(&residual.y)], "r_y");
        assert_cancels(&[at.g(&point.x), slack.clone(), times(-tau, &q.z), minus(&residual.z)], "r_z");
        let linear = dot(&q.x, &point.x) + dot(&q.y, &point.y) + dot(&q.z, &point.z);
        let stated = at.entries(Buffer::Embedding)[embedding::RESIDUAL];
        assert_cancels(&[kappa, linear, dot(&point.x, &px) / tau, -stated].map(|v| vec![v]), "r_τ");
        let degree = at.engine.path.structure.cones.degree() as f64 + 1.0;
        let mu = (dot(&slack, &point.z) + tau * kappa) / degree;
        assert!((at.entries(Buffer::Statistics)[stat::MU] / mu - 1.0).abs() < 1e-12);
    }
}

#[test]
fn the_predictor_solves_newtons_equations_without_centring() {
    for before in [0, 1, 3] {
        let at = stop_after(8, before, Stage::Direction, 1);
        let lambda = at.entries(Buffer::Lambda);
        let target = jordan(&at.engine.path.structure.cones, lambda, lambda);
        let homogenizer = at.entries(Buffer::Homogenizer);
        assert_direction(&at, 1.0, &target, homogenizer[0] * homogenizer[1]);
    }
}

#[test]
fn the_corrector_aims_where_the_predictors_step_says() {
    for before in [0, 1, 3] {
        let predictor = stop_after(8, before, Stage::StepLength, 1);
        let affine = predictor.entries(Buffer::StepLength)[0].min(1.0);
        let sigma = (1.0 - affine).powi(2);
        // In the first iteration, the second-order term is damped by the affine step.
        let weight = if before == 0 { affine } else { 1.0 };
        let at = stop_after(8, before, Stage::Direction, 2);
        let cones = &at.engine.path.structure.cones;
        let mu = at.entries(Buffer::Statistics)[stat::MU];
        let lambda = at.entries(Buffer::Lambda);
        let second = jordan(cones, predictor.entries(Buffer::ScaledS), predictor.entries(Buffer::ScaledZ));
        let mut target = each(&jordan(cones, lambda, lambda), &second, |l, d| l + weight * d);
        let heads = (0..cones.l).chain(cones.soc.iter().map(|soc| soc.start));
        heads.for_each(|i| target[i] -= sigma * mu);
        let (homogenizer, affine_tau) = (at.entries(Buffer::Homogenizer), predictor.entries(Buffer::TauStep));
        let kappa = homogenizer[0] * homogenizer[1] + weight * affine_tau[0] * affine_tau[1] - sigma * mu;
        assert_direction(&at, 1.0 - sigma, &target, kappa);
        assert!(affine < 1.0 && sigma > 0.0, "a step that is cut short");
    }
}

#[test]
fn a_step_moves_every_entry_by_its_fraction_and_stays_inside() {
    for before in [0, 1, 3] {
        let (from, to) =
            (stop_after(8, before, Stage::StepLength, 2), stop_after(8, before, Stage::Advance, 1));
        let short = 1.0 - stop_after(8, before, Stage::StepLength, 1).entries(Buffer::StepLength)[0].min(1.0);
        let fraction = (0.99 - 0.05 * short).max(1.0 - (10.0 * short * short).max(1e-4));
        let alpha = (fraction * from.entries(Buffer::StepLength)[0]).min(1.0);
        let pairs = [
            (Buffer::Point, Buffer::Step),
            (Buffer::Slack, Buffer::SlackStep),
            (Buffer::Homogenizer, Buffer::TauStep),
        ];
        for (what, by) in pairs {
            for ((new, old), step) in to.entries(what).iter().zip(from.entries(what)).zip(from.entries(by)) {
                assert!((new - (old + alpha * step)).abs() <= 1e-15 * (old.abs() + step.abs()));
            }
        }
        let cones = &to.engine.path.structure.cones;
        assert!(crate::tests::reference::margin(cones, to.entries(Buffer::Slack)) > 0.0);
        assert!(crate::tests::reference::margin(cones, &to.split(Buffer::Point).z) > 0.0);
        assert!(to.entries(Buffer::Homogenizer)[..2].iter().all(|v| *v > 0.0));
    }
}

//! Small problems whose answers are known, and residuals by plain dense loops.

use orbsoc::{Cones, Csc, Problem, Solution};

pub type Rows = Vec<Vec<f64>>;

/// A problem in dense form; P is the whole symmetric matrix.
#[derive(Clone, Debug, Default)]
pub struct Data {
    pub p: Rows,
    pub c: Vec<f64>,
    pub a: Rows,
    pub b: Vec<f64>,
    pub g: Rows,
    pub h: Vec<f64>,
    pub cones: Cones,
}

fn sparse(rows: &Rows, columns: usize) -> Option<Csc> {
    let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
    (!rows.is_empty()).then(|| Csc::from_dense(&rows, columns))
}

impl Data {
    pub fn problem(&self) -> Problem {
        let n = self.c.len();
        let p = sparse(&self.p, n).map(|p| p.upper_triangle("P").unwrap());
        let (a, g) = (sparse(&self.a, n), sparse(&self.g, n));
        let (c, b, h) = (self.c.clone(), self.b.clone(), self.h.clone());
        Problem::new(p, c, a, b, g, h, self.cones.clone()).unwrap()
    }

    /// Px + c + Aᵀy + Gᵀz.
    fn gradient(&self, x: &[f64], y: &[f64], z: &[f64]) -> Vec<f64> {
        let mut out = self.c.clone();
        for (rows, factors) in [(&self.p, x), (&self.a, y), (&self.g, z)] {
            for (row, factor) in rows.iter().zip(factors) {
                out.iter_mut().zip(row).for_each(|(out, v)| *out += factor * v);
            }
        }
        out
    }

    /// The referee's (pres, dres, gap): s recomputed as h − Gx, rows with h = ∞ absent.
    pub fn residuals(&self, at: &Solution) -> (f64, f64, f64) {
        let ax = times(&self.a, &at.x);
        let equality = ax.iter().zip(&self.b).map(|(ax, b)| (ax - b).abs());
        let slack: Vec<f64> = times(&self.g, &at.x).iter().zip(&self.h).map(|(g, h)| h - g).collect();
        let h = self.h.iter().copied().filter(|h| h.is_finite());
        let sizes = |v: &mut dyn Iterator<Item = f64>| v.fold(0.0, |top: f64, v| top.max(v.abs()));
        let primal = equality.fold(outside(&self.cones, &slack), f64::max)
            / (1.0 + sizes(&mut self.b.iter().copied().chain(h)));
        let gradient = self.gradient(&at.x, &at.y, &at.z);
        let dual = sizes(&mut gradient.into_iter()).max(outside(&self.cones, &at.z))
            / (1.0 + sizes(&mut self.c.iter().copied()));
        let (objective, dual_objective) = self.objectives(at);
        let gap = (objective - dual_objective).abs();
        (primal, dual, gap / (1.0 + objective.abs().min(dual_objective.abs())))
    }

    pub fn objectives(&self, at: &Solution) -> (f64, f64) {
        let half = 0.5 * dot(&times(&self.p, &at.x), &at.x);
        let present = self.h.iter().zip(&at.z).filter(|(h, _)| h.is_finite());
        let support = dot(&self.b, &at.y) + present.map(|(h, z)| h * z).sum::<f64>();
        (half + dot(&self.c, &at.x), -half - support)
    }

    /// The largest ball around the origin without a feasible point, as (y, z ∈ K) certify it.
    pub fn primal_radius(&self, at: &Solution) -> f64 {
        let value = dot(&self.b, &at.y) + dot(&self.h, &at.z);
        let sum: Vec<f64> =
            self.gradient(&[], &at.y, &at.z).iter().zip(&self.c).map(|(g, c)| g - c).collect();
        assert!(outside(&self.cones, &at.z) <= 0.0, "z must lie in K exactly");
        -value / sum.iter().map(|v| v.abs()).sum::<f64>()
    }

    /// −cᵀx over the distance of (Px, Ax, −Gx) from (0, 0, K).
    pub fn dual_radius(&self, at: &Solution) -> f64 {
        let sum = |v: Vec<f64>| v.iter().map(|v| v.abs()).sum::<f64>();
        let ray: Vec<f64> = times(&self.g, &at.x).iter().map(|v| -v).collect();
        let distance = self.cones.dim() as f64 * outside(&self.cones, &ray);
        let size = sum(times(&self.p, &at.x)) + sum(times(&self.a, &at.x)) + distance;
        -dot(&self.c, &at.x) / size
    }
}

pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub fn times(rows: &Rows, x: &[f64]) -> Vec<f64> {
    rows.iter().map(|row| dot(row, x)).collect()
}

/// How far v is outside K, at least; zero or less inside.
pub fn outside(cones: &Cones, v: &[f64]) -> f64 {
    let mut worst = v[..cones.l].iter().fold(0.0, |worst: f64, v| worst.max(-v));
    let mut start = cones.l;
    for &q in &cones.q {
        let tail = dot(&v[start + 1..start + q], &v[start + 1..start + q]).sqrt();
        worst = worst.max((tail - v[start]) / 2f64.sqrt());
        start += q;
    }
    worst
}

fn orthant(l: usize) -> Cones {
    Cones { l, q: vec![] }
}

/// The negative identity: rows −x ≤ 0.
fn minus_identity(n: usize) -> Rows {
    (0..n).map(|i| (0..n).map(|j| if i == j { -1.0 } else { 0.0 }).collect()).collect()
}

/// Problems with a unique, known optimal value: (name, problem, value).
pub fn solvable() -> Vec<(&'static str, Data, f64)> {
    // Two products, two machines: the vertex (1, 3).
    let lp = Data {
        c: vec![-1.0, -2.0],
        g: [vec![vec![1.0, 1.0], vec![1.0, 0.0], vec![0.0, 1.0]], minus_identity(2)].concat(),
        h: vec![4.0, 2.0, 3.0, 0.0, 0.0],
        cones: orthant(5),
        ..Data::default()
    };
    // Hock & Schittkowski 35: (4/3, 7/9, 4/9).
    let qp = Data {
        p: vec![vec![4.0, 2.0, 2.0], vec![2.0, 4.0, 0.0], vec![2.0, 0.0, 2.0]],
        c: vec![-8.0, -6.0, -4.0],
        g: [vec![vec![1.0, 1.0, 2.0]], minus_identity(3)].concat(),
        h: vec![3.0, 0.0, 0.0, 0.0],
        cones: orthant(4),
        ..Data::default()
    };
    // The least norm on a plane: ½‖x‖² with x₀ + 2x₁ + 2x₂ = 9 is attained at (1, 2, 2).
    let least_norm = Data {
        p: minus_identity(3).iter().map(|row| row.iter().map(|v| -v).collect()).collect(),
        c: vec![0.0; 3],
        a: vec![vec![1.0, 2.0, 2.0]],
        b: vec![9.0],
        ..Data::default()
    };
    // The distance of (3, 4) from the unit disk: variables (t, x), cones (t, x − (3, 4)) and (1, x).
    let distance = Data {
        c: vec![1.0, 0.0, 0.0],
        g: [minus_identity(3), vec![vec![0.0; 3]], minus_identity(3)[1..].to_vec()].concat(),
        h: vec![0.0, -3.0, -4.0, 1.0, 0.0, 0.0],
        cones: Cones { l: 0, q: vec![3, 3] },
        ..Data::default()
    };
    // min −aᵀx on the unit ball of dimension 40: −‖a‖, one expanded cone.
    let a: Vec<f64> = (0..40).map(|k| f64::from(k % 7) - 3.0).collect();
    let ball = Data {
        c: a.iter().map(|v| -v).collect(),
        g: [vec![vec![0.0; 40]], minus_identity(40)].concat(),
        h: [vec![1.0], vec![0.0; 40]].concat(),
        cones: Cones { l: 0, q: vec![41] },
        ..Data::default()
    };
    // A cone of size one is a nonnegative row, and h = ∞ is no row: min x with x ≥ 2 and x ≤ ∞.
    let odd_rows = Data {
        c: vec![1.0],
        g: vec![vec![1.0], vec![-1.0]],
        h: vec![f64::INFINITY, -2.0],
        cones: Cones { l: 1, q: vec![1] },
        ..Data::default()
    };
    vec![
        ("lp", lp, -7.0),
        ("qp", qp, 1.0 / 9.0 - 9.0),
        ("least norm", least_norm, 4.5),
        ("distance", distance, 4.0),
        ("ball", ball, -dot(&a, &a).sqrt()),
        ("odd rows", odd_rows, 2.0),
    ]
}

/// Problems without a feasible point.
pub fn infeasible() -> Vec<(&'static str, Data)> {
    let interval = Data {
        c: vec![1.0],
        g: vec![vec![-1.0], vec![1.0]],
        h: vec![-1.0, 0.0],
        cones: orthant(2),
        ..Data::default()
    };
    // The unit disk and x₀ ≥ 2.
    let disk = Data {
        c: vec![0.0, 1.0],
        g: [vec![vec![-1.0, 0.0], vec![0.0, 0.0]], minus_identity(2)].concat(),
        h: vec![-2.0, 1.0, 0.0, 0.0],
        cones: Cones { l: 1, q: vec![3] },
        ..Data::default()
    };
    // The same equation with two right-hand sides, under a quadratic cost.
    let equations = Data {
        p: vec![vec![1.0, 0.0], vec![0.0, 1.0]],
        c: vec![0.0, 0.0],
        a: vec![vec![1.0, 1.0], vec![1.0, 1.0]],
        b: vec![1.0, 2.0],
        ..Data::default()
    };
    vec![("interval", interval), ("disk", disk), ("equations", equations)]
}

/// Problems that are feasible and unbounded.
pub fn unbounded() -> Vec<(&'static str, Data)> {
    let ray = Data { c: vec![-1.0], g: vec![vec![-1.0]], h: vec![0.0], cones: orthant(1), ..Data::default() };
    // min x₁ − 2t in the cone t ≥ ‖x‖.
    let cone = Data {
        c: vec![-2.0, 1.0, 0.0],
        g: minus_identity(3),
        h: vec![0.0; 3],
        cones: Cones { l: 0, q: vec![3] },
        ..Data::default()
    };
    // Curved in x₀ only, falling in x₁.
    let flat = Data {
        p: vec![vec![1.0, 0.0], vec![0.0, 0.0]],
        c: vec![0.0, -1.0],
        g: vec![vec![1.0, 0.0]],
        h: vec![5.0],
        cones: orthant(1),
        ..Data::default()
    };
    vec![("ray", ray), ("cone", cone), ("flat", flat)]
}

/// A problem made around a strictly complementary optimal point; returns its value.
pub fn generated(seed: u64) -> (Data, f64) {
    let (n, p, cones) = (9, 3, Cones { l: 6, q: vec![3, 2, 7] });
    let m = cones.dim();
    let mut state = seed;
    let mut number = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let mut list = |len: usize| (0..len).map(|_| number()).collect::<Vec<f64>>();
    let (root, a, g): (Rows, Rows, Rows) = (
        (0..4).map(|_| list(n)).collect(),
        (0..p).map(|_| list(n)).collect(),
        (0..m).map(|_| list(n)).collect(),
    );
    let (x, y) = (list(n), list(p));
    let (mut s, mut z) = (vec![0.0; m], vec![0.0; m]);
    for i in 0..cones.l {
        *if i % 2 == 0 { &mut s[i] } else { &mut z[i] } = 1.0 + i as f64 / 4.0;
    }
    // One cone inactive, one at its apex, one on its boundary: s = (t, tu), z ∝ (1, −u).
    (s[6], s[7], z[9]) = (2.0, 0.5, 1.5);
    let u = list(6);
    let length = dot(&u, &u).sqrt();
    (s[11], z[11]) = (length, 0.7 * length);
    for (k, u) in u.iter().enumerate() {
        (s[12 + k], z[12 + k]) = (*u, -0.7 * u);
    }
    let cost: Rows =
        (0..n).map(|i| (0..n).map(|j| root.iter().map(|r| r[i] * r[j]).sum()).collect()).collect();
    let mut data = Data { p: cost, c: vec![0.0; n], a, g, cones, ..Data::default() };
    data.c = data.gradient(&x, &y, &z).iter().map(|v| -v).collect();
    data.b = times(&data.a, &x);
    data.h = times(&data.g, &x).iter().zip(&s).map(|(g, s)| g + s).collect();
    let value = 0.5 * dot(&times(&data.p, &x), &x) + dot(&data.c, &x);
    (data, value)
}

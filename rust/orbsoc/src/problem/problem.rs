//! The problem in standard form, as the user states it.

use crate::error::{fit, Error};
use crate::problem::csc::{finite, Csc};
use crate::problem::{cones::Cones, convexity::check_upper};

/// From here on a bound of a nonnegative row is no bound.
const ABSENT_FROM: f64 = 1e20;

/// min ½xᵀPx + cᵀx  s.t.  Ax = b,  Gx + s = h,  s ∈ K.
///
/// ```
/// use orbsoc::{Cones, Csc, Problem, Settings, solve, Status};
/// // The smallest circle around the origin: min t with ‖(3, 4)‖ ≤ t.
/// let g = Csc::from_dense(&[&[-1.0], &[0.0], &[0.0]], 1);
/// let problem = Problem::new(
///     None, vec![1.0], None, vec![], Some(g), vec![0.0, 3.0, 4.0], Cones { l: 0, q: vec![3] },
/// )?;
/// let solution = solve(&problem, &Settings::default())?;
/// assert_eq!(solution.status, Status::Solved);
/// assert!((solution.x[0] - 5.0).abs() < 1e-7);
/// # Ok::<(), orbsoc::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// Upper triangle of the symmetric positive semidefinite n × n cost matrix.
    pub(crate) p: Csc,
    pub(crate) c: Vec<f64>,
    pub(crate) a: Csc,
    pub(crate) b: Vec<f64>,
    pub(crate) g: Csc,
    pub(crate) h: Vec<f64>,
    pub(crate) cones: Cones,
}

impl Problem {
    /// Check the data and take them. `p_upper` holds the upper triangle of P; absent matrices
    /// have no rows (P: is zero).
    ///
    /// # Errors
    /// Sizes that do not fit, NaN or infinity where none may stand (+∞ in `h` on a nonnegative
    /// row is allowed and means that the row is absent, as 1e20 and more do), cones of dimension 0, no variables, and
    /// [`Error::NotConvex`] for a P that is not positive semidefinite.
    pub fn new(
        p_upper: Option<Csc>,
        c: Vec<f64>,
        a: Option<Csc>,
        b: Vec<f64>,
        g: Option<Csc>,
        h: Vec<f64>,
        cones: Cones,
    ) -> Result<Self, Error> {
        let problem = Self::trusted(p_upper, c, a, b, g, h, cones)?;
        check_upper(&problem.p)?;
        Ok(problem)
    }

    /// As [`Problem::new`], with the caller's word that P is positive semidefinite: of a cost that is not convex, a
    /// point without slope may come back as solved.
    ///
    /// # Errors
    /// As [`Problem::new`], but [`Error::NotConvex`].
    pub fn trusted(
        p_upper: Option<Csc>,
        c: Vec<f64>,
        a: Option<Csc>,
        b: Vec<f64>,
        g: Option<Csc>,
        mut h: Vec<f64>,
        cones: Cones,
    ) -> Result<Self, Error> {
        let n = c.len();
        if n == 0 {
            return Err(Error::Empty);
        }
        let p = p_upper.unwrap_or_else(|| Csc::zeros(n, n));
        let a = a.unwrap_or_else(|| Csc::zeros(0, n));
        let g = g.unwrap_or_else(|| Csc::zeros(0, n));
        fit("P", (p.nrows(), "rows"), n, "`c` has")?;
        fit("P", (p.ncols(), "columns"), n, "`c` has")?;
        fit("A", (a.ncols(), "columns"), n, "`c` has")?;
        fit("G", (g.ncols(), "columns"), n, "`c` has")?;
        fit("b", (b.len(), "entries"), a.nrows(), "the number of rows of A is")?;
        fit("h", (h.len(), "entries"), g.nrows(), "the number of rows of G is")?;
        if let Some(index) = cones.q.iter().position(|&q| q == 0) {
            return Err(Error::EmptyCone { index });
        }
        fit("cones", (cones.dim(), "rows"), g.nrows(), "the number of rows of G is")?;
        if let Some((i, j, _)) = p.triplets().find(|&(i, j, _)| i > j) {
            return Err(Error::Sparse {
                argument: "P",
                detail: format!("entry ({i}, {j}) lies below the diagonal; give the upper triangle"),
            });
        }
        finite("c", &c)?;
        finite("b", &b)?;
        finite_or_absent(&h, cones.l)?;
        without_huge_bounds(&mut h[..cones.l]);
        for (what, size) in
            [("P", p.nnz()), ("A", a.nnz()), ("G", g.nnz()), ("x, y, z", n + b.len() + h.len())]
        {
            addressable(what, size)?;
        }
        Ok(Self { p, c, a, b, g, h, cones })
    }

    /// Upper triangle of the quadratic cost's matrix, n × n.
    pub fn cost(&self) -> &Csc {
        &self.p
    }

    /// Linear cost, length n.
    pub fn c(&self) -> &[f64] {
        &self.c
    }

    /// Matrix of the equality rows, p × n.
    pub fn a(&self) -> &Csc {
        &self.a
    }

    /// Matrix of the cone rows, m × n.
    pub fn g(&self) -> &Csc {
        &self.g
    }

    /// Right-hand side of the equality rows, length p.
    pub fn b(&self) -> &[f64] {
        &self.b
    }

    /// Right-hand side of the cone rows, length m.
    pub fn h(&self) -> &[f64] {
        &self.h
    }

    /// Replace c.
    ///
    /// # Errors
    /// Another length, or a number that is not finite.
    pub fn set_c(&mut self, c: &[f64]) -> Result<(), Error> {
        finite("c", c)?;
        replace("c", &mut self.c, c)
    }

    /// Replace b.
    ///
    /// # Errors
    /// Another length, or a number that is not finite.
    pub fn set_b(&mut self, b: &[f64]) -> Result<(), Error> {
        finite("b", b)?;
        replace("b", &mut self.b, b)
    }

    /// Replace h.
    ///
    /// # Errors
    /// Another length, NaN, −∞, or +∞ on a row of a second-order cone.
    pub fn set_h(&mut self, h: &[f64]) -> Result<(), Error> {
        finite_or_absent(h, self.cones.l)?;
        replace("h", &mut self.h, h)?;
        without_huge_bounds(&mut self.h[..self.cones.l]);
        Ok(())
    }

    /// Replace the entries of P's upper triangle, in the order of its columns.
    ///
    /// # Errors
    /// Another number of entries, one that is not finite, or [`Error::NotConvex`]; the old entries stay.
    pub fn set_p_values(&mut self, values: &[f64]) -> Result<(), Error> {
        let mut new = self.p.clone();
        new.set_values("P", values)?;
        check_upper(&new)?;
        self.p = new;
        Ok(())
    }

    /// As [`Problem::set_p_values`], with the caller's word that P is positive semidefinite.
    ///
    /// # Errors
    /// Another number of entries, or one that is not finite.
    pub fn trust_p_values(&mut self, values: &[f64]) -> Result<(), Error> {
        self.p.set_values("P", values)
    }

    /// Replace the entries of A, in the order of its columns.
    ///
    /// # Errors
    /// Another number of entries, or one that is not finite.
    pub fn set_a_values(&mut self, values: &[f64]) -> Result<(), Error> {
        self.a.set_values("A", values)
    }

    /// Replace the entries of G, in the order of its columns.
    ///
    /// # Errors
    /// Another number of entries, or one that is not finite.
    pub fn set_g_values(&mut self, values: &[f64]) -> Result<(), Error> {
        self.g.set_values("G", values)
    }

    /// Take the numbers of a problem of the same pattern.
    pub(crate) fn copy_numbers(&mut self, from: &Self) {
        self.p.copy_values(&from.p);
        self.a.copy_values(&from.a);
        self.g.copy_values(&from.g);
        self.c.copy_from_slice(&from.c);
        self.b.copy_from_slice(&from.b);
        self.h.copy_from_slice(&from.h);
    }

    /// Check that `other` differs in its numbers only.
    ///
    /// # Errors
    /// [`Error::PatternChanged`] naming the matrix, or cones or absent rows that differ.
    pub fn same_pattern(&self, other: &Self) -> Result<(), Error> {
        let absent =
            |p: &Self, q: &Self| p.h.iter().map(|h| h.is_finite()).eq(q.h.iter().map(|h| h.is_finite()));
        let argument = match () {
            () if !self.p.same_pattern(&other.p) => "P",
            () if !self.a.same_pattern(&other.a) => "A",
            () if !self.g.same_pattern(&other.g) => "G",
            () if self.cones != other.cones => "cones",
            () if !absent(self, other) => "h",
            () => return Ok(()),
        };
        Err(Error::PatternChanged { argument })
    }

    /// Number of variables.
    pub fn n(&self) -> usize {
        self.c.len()
    }

    /// Number of equality rows.
    pub fn p(&self) -> usize {
        self.b.len()
    }

    /// Number of cone rows.
    pub fn m(&self) -> usize {
        self.h.len()
    }

    /// The cones of the rows of G.
    pub fn cones(&self) -> &Cones {
        &self.cones
    }
}

/// Four arrays of this size must fit 32-bit indices together.
fn addressable(what: &'static str, size: usize) -> Result<(), Error> {
    if size > u32::MAX as usize / 4 {
        Err(Error::TooLarge { what, size })
    } else {
        Ok(())
    }
}

/// +∞ on a nonnegative row of h says that the row is absent.
fn finite_or_absent(h: &[f64], l: usize) -> Result<(), Error> {
    let absent = |i: usize, v: f64| i < l && v == f64::INFINITY;
    match h.iter().enumerate().find(|&(i, &v)| !v.is_finite() && !absent(i, v)) {
        Some((index, &value)) => Err(Error::Value { argument: "h", index, value }),
        None => Ok(()),
    }
}

/// A bound of [`ABSENT_FROM`] or more is none: as a number it would make every tolerance of the primal side worthless.
fn without_huge_bounds(h: &mut [f64]) {
    h.iter_mut().filter(|h| **h >= ABSENT_FROM).for_each(|h| *h = f64::INFINITY);
}

fn replace(argument: &'static str, old: &mut [f64], new: &[f64]) -> Result<(), Error> {
    fit(argument, (new.len(), "entries"), old.len(), "the problem needs")?;
    old.copy_from_slice(new);
    Ok(())
}

/// The problem without absent rows and with one-dimensional cones as nonnegative rows.
#[derive(Clone, Debug)]
pub(crate) struct Reduced {
    pub g: Csc,
    /// For each entry of the reduced G, its position among the entries of the user's G.
    pub g_origin: Vec<usize>,
    /// For each reduced row, the user's row.
    pub row_origin: Vec<usize>,
    pub l: usize,
    pub q: Vec<usize>,
}

impl Reduced {
    pub fn new(problem: &Problem) -> Self {
        let cones = &problem.cones;
        let mut row_origin: Vec<usize> = (0..cones.l).filter(|&i| problem.h[i] < f64::INFINITY).collect();
        let mut soc_rows = Vec::new();
        let mut q = Vec::new();
        let mut start = cones.l;
        for &dim in &cones.q {
            if dim == 1 {
                row_origin.push(start);
            } else {
                soc_rows.extend(start..start + dim);
                q.push(dim);
            }
            start += dim;
        }
        let l = row_origin.len();
        row_origin.extend(soc_rows);
        let mut new_row = vec![None; problem.m()];
        for (new, &old) in row_origin.iter().enumerate() {
            new_row[old] = Some(new);
        }
        let (g, g_origin) = problem.g.map_rows(row_origin.len(), &new_row);
        Self { g, g_origin, row_origin, l, q }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows 1 and 4 are absent, cones 0 and 2 have dimension one.
    fn reducible() -> Problem {
        let g: Vec<[f64; 2]> = (0..10).map(|i| [f64::from(i), if i % 2 == 0 { 0.0 } else { 1.0 }]).collect();
        let g = Csc::from_dense(&g.iter().map(|row| &row[..]).collect::<Vec<_>>(), 2);
        let mut h: Vec<f64> = (0..10).map(f64::from).collect();
        (h[1], h[4]) = (f64::INFINITY, f64::INFINITY);
        let cones = Cones { l: 5, q: vec![1, 3, 1] };
        Problem::new(None, vec![1.0, 1.0], None, vec![], Some(g), h, cones).unwrap()
    }

    #[test]
    fn absent_rows_go_and_cones_of_one_become_nonnegative_rows() {
        let reduced = Reduced::new(&reducible());
        assert_eq!((reduced.l, &reduced.q[..]), (5, &[3][..]));
        assert_eq!(reduced.row_origin, [0, 2, 3, 5, 9, 6, 7, 8]);
    }

    #[test]
    fn bounds_of_1e20_and_more_are_none() {
        let mut problem = reducible();
        let mut h = problem.h.clone();
        (h[0], h[1], h[4], h[5]) = (9.9e19, 1e20, f64::MAX, 1e20);
        assert_eq!(problem.set_h(&h), Ok(()));
        assert_eq!((problem.h[0], problem.h[5]), (9.9e19, 1e20), "a cone's row keeps its number");
        assert!(problem.same_pattern(&reducible()).is_ok());
        let Problem { p, c, a, b, g, cones, .. } = problem.clone();
        assert_eq!(Problem::new(Some(p), c, Some(a), b, Some(g), h, cones).unwrap(), problem);
    }

    #[test]
    fn reduced_entries_are_the_users_by_row_and_by_position() {
        let problem = reducible();
        let reduced = Reduced::new(&problem);
        let given: Vec<(usize, usize, f64)> = problem.g.triplets().collect();
        assert_eq!(reduced.g.nnz(), given.iter().filter(|(i, ..)| ![1, 4].contains(i)).count());
        for ((i, j, value), &origin) in reduced.g.triplets().zip(&reduced.g_origin) {
            assert_eq!((reduced.row_origin[i], j, value), given[origin]);
        }
    }

    #[test]
    fn sizes_beyond_32_bit_indices_are_refused() {
        let limit = u32::MAX as usize / 4;
        assert_eq!(addressable("A", limit), Ok(()));
        let error = addressable("A", limit + 1).unwrap_err();
        assert_eq!(error.to_string(), "A has 1073741824 entries, more than 32-bit indices can address");
    }

    #[test]
    fn replaced_numbers_are_checked_like_given_ones() {
        let mut problem = reducible();
        assert_eq!(problem.set_c(&[2.0, 3.0]), Ok(()));
        assert_eq!(problem.c, [2.0, 3.0]);
        let short = problem.set_c(&[2.0]).unwrap_err();
        assert_eq!(short.to_string(), "`c` has 1 entries, but the problem needs 2");
        assert!(matches!(problem.set_c(&[2.0, f64::NAN]), Err(Error::Value { argument: "c", index: 1, .. })));
        assert!(matches!(
            problem.set_h(&[f64::INFINITY; 10]),
            Err(Error::Value { argument: "h", index: 5, .. })
        ));
        assert!(problem.set_b(&[1.0]).is_err() && problem.set_b(&[]).is_ok());
        assert_eq!(problem.c, [2.0, 3.0], "refused numbers leave the old ones");
    }
}

//! Many problems of one sparsity pattern: eight at a time in SIMD lanes, on several threads.
//!
//! Lanes run the same stages in step. Eight problems begin together, so that they need the same refinements in the same
//! iteration. Once half of them have ended, the others move to a second set of lanes and the next eight begin; the second
//! set iterates when it is full, so one hard problem does not hold the others. Every problem's bits are those of its own
//! single solve, wherever it ran.

use crate::crew::{Crew, StartOf, Work};
use crate::error::Error;
use crate::problem::Problem;
use crate::real::Lanes;
use crate::settings::Settings;
use crate::solution::Solution;
use crate::structure::Structure;
use crate::warm_start::Start;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

/// A pattern made ready for batches, for one after another: each thread keeps the lanes that it has made when it first
/// had a problem to solve.
///
/// ```
/// use orbsoc::{BatchSolver, Cones, Csc, Problem, Settings};
/// let g = Csc::from_dense(&[&[-1.0]], 1);
/// let base = Problem::new(None, vec![1.0], None, vec![], Some(g), vec![0.0], Cones { l: 1, q: vec![] })?;
/// let mut solver = BatchSolver::new(&base, &Settings::default(), 1)?;
/// for shift in [0.0, 0.5] {
///     let solutions = solver.solve(20, |k, problem| problem.set_h(&[shift - (k as f64)]))?;
///     assert!(solutions.iter().enumerate().all(|(k, s)| (s.x[0] + shift - k as f64).abs() < 1e-7));
/// }
/// # Ok::<(), orbsoc::Error>(())
/// ```
pub struct BatchSolver {
    base: Problem,
    structure: Arc<Structure>,
    settings: Settings,
    /// One for each thread that has solved a problem.
    crews: Vec<Option<Box<dyn Work>>>,
    pool: Option<Pool>,
}

/// Threads, and the process that has them: a fork has none of its parent's.
struct Pool {
    threads: rayon::ThreadPool,
    process: u32,
}

impl Pool {
    fn new(count: usize) -> Result<Self, Error> {
        let threads = rayon::ThreadPoolBuilder::new().num_threads(count).build();
        let threads = threads.map_err(|e| Error::Threads { count, detail: e.to_string() })?;
        Ok(Self { threads, process: std::process::id() })
    }
}

impl BatchSolver {
    /// Analyse the pattern of `base`, and start `threads` threads if there are to be several.
    ///
    /// # Errors
    /// As [`crate::Engine::new`], and [`Error::Threads`] when the system has no threads to give.
    pub fn new(base: &Problem, settings: &Settings, threads: usize) -> Result<Self, Error> {
        settings.validate()?;
        let structure = Arc::new(Structure::for_lanes(base)?);
        let pool = if threads > 1 { Some(Pool::new(threads)?) } else { None };
        let crews = (0..threads.max(1)).map(|_| None).collect();
        Ok(Self { base: base.clone(), structure, settings: settings.clone(), crews, pool })
    }

    /// Solve `count` problems. `write(k, problem)` puts problem k's numbers into a copy of the base; it must leave
    /// the pattern alone.
    ///
    /// # Errors
    /// What `write` returns, and [`Error::PatternChanged`] when it changed more than numbers.
    pub fn solve(
        &mut self,
        count: usize,
        write: impl Fn(usize, &mut Problem) -> Result<(), Error> + Sync,
    ) -> Result<Vec<Solution>, Error> {
        self.run(count, write, None)
    }

    /// As [`BatchSolver::solve`], each problem from a point nearby; see [`crate::Engine::solve_from`].
    ///
    /// # Errors
    /// As [`BatchSolver::solve`], and [`Error::Dimension`] naming the part of a point whose length does not fit.
    pub fn solve_from<'a>(
        &mut self,
        count: usize,
        write: impl Fn(usize, &mut Problem) -> Result<(), Error> + Sync,
        start: impl Fn(usize) -> Start<'a> + Sync,
    ) -> Result<Vec<Solution>, Error> {
        self.run(count, write, Some(&start))
    }

    fn run(
        &mut self,
        count: usize,
        write: impl Fn(usize, &mut Problem) -> Result<(), Error> + Sync,
        start: Option<StartOf<'_, '_>>,
    ) -> Result<Vec<Solution>, Error> {
        let Self { base, structure, settings, crews, pool } = self;
        let (base, structure, settings) = (&*base, &*structure, &*settings);
        let next = AtomicUsize::new(0);
        let solved = Mutex::new(vec![None; count]);
        let work = |crew: &mut Option<Box<dyn Work>>| {
            if next.load(Ordering::Relaxed) >= count {
                return Ok(());
            }
            let crew = match crew {
                Some(crew) => crew,
                None => crew.insert(lanes(structure, settings)?),
            };
            let mut take = |problem: &mut Problem| {
                let k = next.fetch_add(1, Ordering::Relaxed);
                if k >= count {
                    return Ok(None);
                }
                problem.copy_numbers(base);
                write(k, problem)?;
                base.same_pattern(problem)?;
                Ok(Some(k))
            };
            let mut done = |k: usize, solution| {
                if let Ok(mut solved) = solved.lock() {
                    solved[k] = Some(solution);
                }
            };
            crew.work(base, &mut take, start, &mut done)
        };
        match pool {
            Some(pool) => {
                if pool.process != std::process::id() {
                    *pool = Pool::new(crews.len())?;
                }
                pool.threads.install(|| crews.par_iter_mut().with_max_len(1).try_for_each(work))?;
            }
            None => crews.iter_mut().try_for_each(work)?,
        }
        let solved = solved.into_inner().unwrap_or_default();
        Ok(solved.into_iter().flatten().collect())
    }
}

/// Of the machine's instruction set.
fn lanes(structure: &Arc<Structure>, settings: &Settings) -> Result<Box<dyn Work>, Error> {
    Ok(match pulp::Arch::new() {
        #[cfg(target_arch = "x86_64")]
        pulp::Arch::V4(_) => Box::new(Crew::<Lanes<pulp::x86::V4>>::new(structure, settings)?),
        #[cfg(target_arch = "x86_64")]
        pulp::Arch::V3(_) => Box::new(Crew::<Lanes<pulp::x86::V3_512b>>::new(structure, settings)?),
        _ => Box::new(Crew::<Lanes<pulp::Scalar512b>>::new(structure, settings)?),
    })
}

/// Solve one batch; see [`BatchSolver`], which solves one after another.
///
/// # Errors
/// As [`BatchSolver::new`] and [`BatchSolver::solve`].
pub fn solve_batch(
    base: &Problem,
    count: usize,
    write: impl Fn(usize, &mut Problem) -> Result<(), Error> + Sync,
    settings: &Settings,
    threads: usize,
) -> Result<Vec<Solution>, Error> {
    BatchSolver::new(base, settings, threads)?.solve(count, write)
}

/// As [`solve_batch`], each problem from a point nearby.
///
/// # Errors
/// As [`BatchSolver::new`] and [`BatchSolver::solve_from`].
pub fn solve_batch_from<'a>(
    base: &Problem,
    count: usize,
    write: impl Fn(usize, &mut Problem) -> Result<(), Error> + Sync,
    start: impl Fn(usize) -> Start<'a> + Sync,
    settings: &Settings,
    threads: usize,
) -> Result<Vec<Solution>, Error> {
    BatchSolver::new(base, settings, threads)?.solve_from(count, write, start)
}

#[cfg(test)]
#[path = "batch_tests.rs"]
mod tests;

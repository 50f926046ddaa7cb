//! Many problems of one sparsity pattern: eight at a time in SIMD lanes, on several threads.
//!
//! Lanes run the same stages in step. Eight problems begin together, so that they need the same refinements in the same
//! iteration. Once half of them have ended, the others move to a second set of lanes and the next eight begin; the second
//! set iterates when it is full, so one hard problem does not hold the others. Every problem's bits are those of its own
//! single solve, wherever it ran.

use crate::error::Error;
use crate::problem::Problem;
use crate::real::{Decide, Lanes};
use crate::seats::{Seat, Seats};
use crate::settings::Settings;
use crate::solution::{Solution, WarmStart};
use crate::stage::{STARTUP, WARM_STARTUP};
use crate::structure::Structure;
use crate::warm_start::Start;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

/// Solve `count` problems of the pattern of `base` on `threads` threads. `write(k, problem)` puts
/// problem k's numbers into a copy of `base`; it must leave the pattern alone.
///
/// ```
/// use orbsoc::{solve_batch, Cones, Csc, Problem, Settings};
/// let g = Csc::from_dense(&[&[-1.0]], 1);
/// let base = Problem::new(None, vec![1.0], None, vec![], Some(g), vec![0.0], Cones { l: 1, q: vec![] })?;
/// let at_least = |k: usize, problem: &mut Problem| problem.set_h(&[-(k as f64)]);
/// let solutions = solve_batch(&base, 20, at_least, &Settings::default(), 1)?;
/// assert!(solutions.iter().enumerate().all(|(k, s)| (s.x[0] - k as f64).abs() < 1e-7));
/// # Ok::<(), orbsoc::Error>(())
/// ```
///
/// # Errors
/// As [`crate::Engine::new`], and [`Error::PatternChanged`] when `write` changed more than numbers.
pub fn solve_batch(
    base: &Problem,
    count: usize,
    write: impl Fn(usize, &mut Problem) -> Result<(), Error> + Sync,
    settings: &Settings,
    threads: usize,
) -> Result<Vec<Solution>, Error> {
    solve(base, count, write, None, settings, threads)
}

/// As [`solve_batch`], each problem from a point nearby; see [`crate::Engine::solve_from`].
///
/// # Errors
/// As [`solve_batch`], and [`Error::Dimension`] naming the part of a point whose length does not fit.
pub fn solve_batch_from<'a>(
    base: &Problem,
    count: usize,
    write: impl Fn(usize, &mut Problem) -> Result<(), Error> + Sync,
    start: impl Fn(usize) -> Start<'a> + Sync,
    settings: &Settings,
    threads: usize,
) -> Result<Vec<Solution>, Error> {
    solve(base, count, write, Some(&start), settings, threads)
}

/// Each problem's point to start from.
type StartOf<'f, 'a> = &'f (dyn Fn(usize) -> Start<'a> + Sync);

fn solve(
    base: &Problem,
    count: usize,
    write: impl Fn(usize, &mut Problem) -> Result<(), Error> + Sync,
    start: Option<StartOf<'_, '_>>,
    settings: &Settings,
    threads: usize,
) -> Result<Vec<Solution>, Error> {
    let structure = Arc::new(Structure::for_lanes(base)?);
    let next = AtomicUsize::new(0);
    let solved = Mutex::new(vec![None; count]);
    let worker = || -> Result<(), Error> {
        let take = |problem: &mut Problem| {
            let k = next.fetch_add(1, Ordering::Relaxed);
            if k >= count {
                return Ok(None);
            }
            problem.copy_numbers(base);
            write(k, problem)?;
            base.same_pattern(problem)?;
            Ok(Some(k))
        };
        let done = |k: usize, solution| {
            if let Ok(mut solved) = solved.lock() {
                solved[k] = Some(solution);
            }
        };
        match pulp::Arch::new() {
            #[cfg(target_arch = "x86_64")]
            pulp::Arch::V4(_) => {
                Crew::<Lanes<pulp::x86::V4>>::new(&structure, settings)?.work(base, take, start, done)
            }
            #[cfg(target_arch = "x86_64")]
            pulp::Arch::V3(_) => {
                Crew::<Lanes<pulp::x86::V3_512b>>::new(&structure, settings)?.work(base, take, start, done)
            }
            _ => Crew::<Lanes<pulp::Scalar512b>>::new(&structure, settings)?.work(base, take, start, done),
        }
    };
    if threads <= 1 {
        worker()?;
    } else {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|e| Error::Symbolic(format!("no thread pool: {e}")))?;
        pool.broadcast(|_| worker()).into_iter().collect::<Result<(), Error>>()?;
    }
    let solved = solved.into_inner().unwrap_or_default();
    Ok(solved.into_iter().flatten().collect())
}

#[cfg(test)]
#[path = "batch_tests.rs"]
mod tests;

/// One thread's lanes: the problems that began together, and those left over by earlier cohorts.
struct Crew<T> {
    cohort: Seats<T>,
    /// Made when first needed: in many batches all problems of a cohort end with the same iteration.
    stragglers: Option<Seats<T>>,
    /// Problems whose warm start failed, for a cold one.
    again: Vec<Seat>,
    /// Problems whose memory the next ones take.
    spare: Vec<Problem>,
}

impl<T: Decide> Crew<T> {
    /// With this many problems left, a cohort makes room for the next.
    const FEW: usize = T::LANES / 2;

    fn new(structure: &Arc<Structure>, settings: &Settings) -> Result<Self, Error> {
        let cohort = Seats::new(structure, settings)?;
        Ok(Self { cohort, stragglers: None, again: Vec::new(), spare: Vec::new() })
    }

    /// Solve what `take` hands out, from the points of `start`, until it has no more; give each solution to `done`.
    fn work(
        &mut self,
        base: &Problem,
        mut take: impl FnMut(&mut Problem) -> Result<Option<usize>, Error>,
        start: Option<StartOf<'_, '_>>,
        mut done: impl FnMut(usize, Solution),
    ) -> Result<(), Error> {
        loop {
            let arriving = self.arriving(base, &mut take)?;
            if !arriving.is_empty() {
                self.make_room(&mut done)?;
                self.begin(arriving, start)?;
                self.cohort.iterate_until(Self::FEW);
                let ended = self.cohort.dismiss();
                self.hand_over(ended, &mut done);
            } else if self.stragglers.is_some() {
                self.make_room(&mut done)?;
                let Some(mut stragglers) = self.stragglers.take() else { continue };
                stragglers.iterate_until(0);
                self.hand_over(stragglers.dismiss(), &mut done);
            } else if self.cohort.busy() > 0 {
                self.cohort.iterate_until(0);
                let ended = self.cohort.dismiss();
                self.hand_over(ended, &mut done);
            } else {
                return Ok(());
            }
        }
    }

    /// The next problems, at most one for each lane. Those whose warm start failed come once they fill the lanes or
    /// nothing else is left.
    fn arriving(
        &mut self,
        base: &Problem,
        take: &mut impl FnMut(&mut Problem) -> Result<Option<usize>, Error>,
    ) -> Result<Vec<Seat>, Error> {
        let mut arriving = Vec::with_capacity(T::LANES);
        while self.again.len() < T::LANES && arriving.len() < T::LANES {
            let mut problem = self.spare.pop().unwrap_or_else(|| base.clone());
            let Some(index) = take(&mut problem)? else {
                self.spare.push(problem);
                break;
            };
            arriving.push(Seat::new(index, problem, self.cohort.settings()));
        }
        if arriving.is_empty() {
            arriving.extend(self.again.drain(..self.again.len().min(T::LANES)));
        }
        Ok(arriving)
    }

    /// Bring problems to their starting points: warm where there are such, but for those that have tried.
    fn begin(&mut self, arriving: Vec<Seat>, start: Option<StartOf<'_, '_>>) -> Result<(), Error> {
        let tried = arriving.iter().all(|seat| seat.control.warm_start == WarmStart::FellBack);
        self.cohort.seat(arriving);
        if let Some(start) = start.filter(|_| !tried) {
            self.again.extend(self.cohort.load_starts(start)?);
            self.cohort.begin(WARM_STARTUP);
        } else {
            self.cohort.begin(STARTUP);
        }
        Ok(())
    }

    /// Move what is left of the cohort to the stragglers; when those are full, they iterate until one has ended.
    fn make_room(&mut self, done: &mut impl FnMut(usize, Solution)) -> Result<(), Error> {
        while self.cohort.busy() > 0 {
            let mut stragglers = match self.stragglers.take() {
                Some(stragglers) => stragglers,
                None => self.cohort.another()?,
            };
            if stragglers.busy() == T::LANES {
                stragglers.iterate_until(T::LANES - 1);
                self.hand_over(stragglers.dismiss(), done);
            }
            self.cohort.move_into(&mut stragglers);
            self.stragglers = Some(stragglers);
        }
        Ok(())
    }

    /// Give the solutions of those that have ended to `done`; who fell back from a warm start comes again.
    fn hand_over(&mut self, ended: Vec<(Seat, Solution)>, done: &mut impl FnMut(usize, Solution)) {
        for (seat, solution) in ended {
            if let Some(control) = seat.control.fall_back(solution.status) {
                self.again.push(Seat { control, ..seat });
            } else {
                done(seat.index, solution);
                self.spare.push(seat.problem);
            }
        }
    }
}

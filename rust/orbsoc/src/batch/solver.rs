//! Many problems of one sparsity pattern: eight at a time in SIMD lanes, on several threads.
//!
//! Lanes run the same stages in step. Eight problems begin together, so that they need the same refinements in the same
//! iteration. Once half of them have ended, the others move to a second set of lanes and the next eight begin; the second
//! set iterates when it is full, so one hard problem does not hold the others. Every problem's bits are those of its own
//! single solve, wherever it ran.

use crate::batch::queue::{BatchProgress, BatchQueue};
use crate::batch::slots::Watch;
use crate::batch::worker::{LaneWorker, StartOf, Work};
use crate::error::Error;
use crate::kkt::structure::Structure;
use crate::method::warm_start::Start;
use crate::outcome::solution::Solution;
use crate::problem::{Problem, Settings};
use crate::real::Lanes;
use core::ops::ControlFlow;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::Arc;
use std::time::Duration;

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
    workers: Vec<Option<Box<dyn Work>>>,
    pool: Option<Pool>,
}

/// How often the observer of a batch on several threads is called.
const LOOK_INTERVAL: Duration = Duration::from_millis(1);

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

    /// Do `work` with each of the workers, one a thread; the calling thread calls `look` now and then.
    fn run<C: Send>(
        &self,
        workers: &mut [C],
        work: impl Fn(&mut C) -> Result<(), Error> + Sync,
        mut look: impl FnMut() -> ControlFlow<()>,
    ) -> Result<(), Error> {
        let (send, receive) = mpsc::channel();
        self.threads.in_place_scope(|scope| {
            for worker in workers {
                let (send, work) = (send.clone(), &work);
                scope.spawn(move |_| drop(send.send(work(worker))));
            }
            drop(send);
            let mut outcome = Ok(());
            loop {
                match receive.recv_timeout(LOOK_INTERVAL) {
                    Ok(ended) => outcome = outcome.and(ended),
                    Err(RecvTimeoutError::Timeout) => {
                        let _ = look();
                    }
                    Err(RecvTimeoutError::Disconnected) => return outcome,
                }
            }
        })
    }
}

impl BatchSolver {
    /// Analyse the pattern of `base`, and start `threads` threads if there are to be several.
    ///
    /// # Errors
    /// As [`crate::Engine::new`], and [`Error::Threads`] when the system has no threads to give.
    pub fn new(base: &Problem, settings: &Settings, threads: usize) -> Result<Self, Error> {
        settings.validate()?;
        let structure = Arc::new(Structure::for_lanes(base, settings.ordering)?);
        let pool = if threads > 1 { Some(Pool::new(threads)?) } else { None };
        let workers = (0..threads.max(1)).map(|_| None).collect();
        Ok(Self { base: base.clone(), structure, settings: settings.clone(), workers, pool })
    }

    /// Solve `count` problems. `write(k, problem)` puts problem k's numbers into a copy of the base; it must leave
    /// the pattern alone.
    ///
    /// # Errors
    /// [`Error::OfBatch`] with what `write` returns, or with [`Error::PatternChanged`] when it changed more than numbers.
    pub fn solve(
        &mut self,
        count: usize,
        write: impl Fn(usize, &mut Problem) -> Result<(), Error> + Sync,
    ) -> Result<Vec<Solution>, Error> {
        self.solve_observed(count, write, None, |_| ControlFlow::Continue(()))
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
        self.solve_observed(count, write, Some(&start), |_| ControlFlow::Continue(()))
    }

    /// As the others, showing to `observe`, on the calling thread, how far the batch is: at the beginning, after each
    /// iteration of the lanes and every few milliseconds of a long factorization, or every millisecond where other threads do the
    /// work, and at the end. `observe` may end
    /// the batch: problems under way then end with their best iterate, those that have not begun without one, as
    /// [`crate::Status::Interrupted`] where that iterate does not meet the tolerance already.
    ///
    /// # Errors
    /// As [`BatchSolver::solve_from`].
    pub fn solve_observed(
        &mut self,
        count: usize,
        write: impl Fn(usize, &mut Problem) -> Result<(), Error> + Sync,
        start: Option<StartOf<'_, '_>>,
        mut observe: impl FnMut(&BatchProgress) -> ControlFlow<()>,
    ) -> Result<Vec<Solution>, Error> {
        let Self { base, structure, settings, workers, pool } = self;
        let (base, structure, settings) = (&*base, &*structure, &*settings);
        let queue = BatchQueue::new(count);
        let _ = queue.show(&mut observe);
        let work = |worker: &mut Option<Box<dyn Work>>, watch: &mut Watch<'_>| {
            if queue.empty() {
                return Ok(());
            }
            let worker = match worker {
                Some(worker) => worker,
                None => worker.insert(lanes(structure, settings)?),
            };
            let mut take = |problem: &mut Problem| {
                let Some(k) = queue.next() else { return Ok(None) };
                problem.copy_numbers(base);
                write(k, problem)
                    .and_then(|()| base.same_pattern(problem))
                    .map_err(|error| Error::OfBatch { problem: k, error: Box::new(error) })?;
                Ok(Some(k))
            };
            let worked =
                worker.work(base, &mut take, start, &mut |k, solution| queue.submit(k, solution), watch);
            worked.inspect_err(|_| queue.close())
        };
        match pool {
            Some(pool) => {
                if pool.process != std::process::id() {
                    *pool = Pool::new(workers.len())?;
                }
                pool.run(workers, |worker| work(worker, &mut || queue.flow()), || queue.show(&mut observe))?;
            }
            None => {
                workers.iter_mut().try_for_each(|worker| work(worker, &mut || queue.show(&mut observe)))?;
            }
        }
        let _ = queue.show(&mut observe);
        Ok(queue.solutions(base))
    }
}

/// Of the machine's instruction set.
fn lanes(structure: &Arc<Structure>, settings: &Settings) -> Result<Box<dyn Work>, Error> {
    Ok(match pulp::Arch::new() {
        #[cfg(target_arch = "x86_64")]
        pulp::Arch::V4(_) => Box::new(LaneWorker::<Lanes<pulp::x86::V4>>::new(structure, settings)?),
        #[cfg(target_arch = "x86_64")]
        pulp::Arch::V3(_) => Box::new(LaneWorker::<Lanes<pulp::x86::V3_512b>>::new(structure, settings)?),
        _ => Box::new(LaneWorker::<Lanes<pulp::Scalar512b>>::new(structure, settings)?),
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

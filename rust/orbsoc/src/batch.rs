//! Many problems of one sparsity pattern: eight at a time in SIMD lanes, on several threads.
//!
//! Lanes run the same stages in step. A second set of lanes brings the next problems to their starting points, eight
//! at once; a lane whose problem has ended takes one of them there and then, so one hard problem does not hold the
//! others. Every problem's bits are those of its own single solve, wherever it ran.

use crate::certificate::Walked;
use crate::control::{keep_best, Control};
use crate::datapath::Datapath;
use crate::error::Error;
use crate::problem::Problem;
use crate::real::{Decide, Lanes};
use crate::settings::Settings;
use crate::solution::{Solution, WarmStart};
use crate::stage::{Outcome, Stage, Step, CLOSING, ITERATION, STARTUP, WARM_STARTUP};
use crate::structure::Structure;
use crate::warm_start::Start;
use crate::workspace::Buffer;
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

/// Where decisions keep certificates.
const CERTIFICATES: [Buffer; 2] = [Buffer::Farkas, Buffer::Ray];

/// A problem in a lane.
struct Seat {
    index: usize,
    problem: Problem,
    control: Control,
    /// The statistics of this iteration have been decided on.
    judged: bool,
}

/// One thread's lanes: a set that iterates, and a set in which the next problems are started.
struct Crew<T> {
    running: Datapath<T>,
    fresh: Datapath<T>,
    seats: Vec<Option<Seat>>,
    /// Problems at their starting points, in the lanes of `fresh`.
    ready: Vec<Option<Seat>>,
    /// Problems whose warm start failed, for a cold one.
    again: Vec<Seat>,
    /// Problems whose memory the next ones take.
    spare: Vec<Problem>,
    /// Buffers that a started problem brings into the iteration.
    carried: Vec<Buffer>,
}

/// As many empty seats as there are lanes.
fn empty<T: Decide>() -> Vec<Option<Seat>> {
    (0..T::LANES).map(|_| None).collect()
}

impl<T: Decide> Crew<T> {
    fn new(structure: &Arc<Structure>, settings: &Settings) -> Result<Self, Error> {
        Ok(Self {
            running: Datapath::new(structure.clone(), settings)?,
            fresh: Datapath::new(structure.clone(), settings)?,
            seats: empty::<T>(),
            ready: empty::<T>(),
            again: Vec::new(),
            spare: Vec::new(),
            carried: carried_into_iteration(),
        })
    }

    /// Solve what `take` hands out, from the points of `start`, until it has no more; give each solution to `done`.
    fn work(
        &mut self,
        base: &Problem,
        mut take: impl FnMut(&mut Problem) -> Result<Option<usize>, Error>,
        start: Option<StartOf<'_, '_>>,
        mut done: impl FnMut(usize, Solution),
    ) -> Result<(), Error> {
        let mut seat_next = |crew: &mut Self| crew.seat_next(base, &mut take, start);
        while seat_next(self)? {
            self.iterate(&mut seat_next, &mut done)?;
        }
        Ok(())
    }

    /// Seat problems at their starting points in the lanes that are free; false when no lane has a problem.
    fn seat_next(
        &mut self,
        base: &Problem,
        take: &mut impl FnMut(&mut Problem) -> Result<Option<usize>, Error>,
        start: Option<StartOf<'_, '_>>,
    ) -> Result<bool, Error> {
        while self.seats.iter().any(Option::is_none) {
            if self.ready.iter().all(Option::is_none) {
                self.prepare(base, take, start)?;
            }
            let free = self.seats.iter().enumerate().filter(|(_, seat)| seat.is_none());
            let ready = self.ready.iter().enumerate().filter(|(_, seat)| seat.is_some());
            let moves: Vec<(usize, usize)> = ready.zip(free).map(|((from, _), (to, _))| (from, to)).collect();
            if moves.is_empty() {
                break;
            }
            self.running.take_lanes(&moves, &mut self.fresh, &self.carried);
            for (from, to) in moves {
                self.seats[to] = self.ready[from].take().map(|seat| Seat { judged: false, ..seat });
            }
        }
        Ok(self.seats.iter().any(Option::is_some))
    }

    /// Bring the next problems to their starting points: those whose warm start failed once they are many or
    /// nothing else is left.
    fn prepare(
        &mut self,
        base: &Problem,
        take: &mut impl FnMut(&mut Problem) -> Result<Option<usize>, Error>,
        start: Option<StartOf<'_, '_>>,
    ) -> Result<(), Error> {
        if 2 * self.again.len() < T::LANES {
            let mut arriving = self.next_problems(base, take)?;
            self.load(&arriving);
            if let Some(start) = start {
                self.load_starts(&mut arriving, start)?;
                self.bring(arriving, WARM_STARTUP);
            } else {
                self.bring(arriving, STARTUP);
            }
        }
        if self.ready.iter().all(Option::is_none) {
            let mut arriving = empty::<T>();
            arriving.fill_with(|| self.again.pop());
            self.load(&arriving);
            self.bring(arriving, STARTUP);
        }
        Ok(())
    }

    /// The next problems, one for each lane.
    fn next_problems(
        &mut self,
        base: &Problem,
        take: &mut impl FnMut(&mut Problem) -> Result<Option<usize>, Error>,
    ) -> Result<Vec<Option<Seat>>, Error> {
        let mut arriving = empty::<T>();
        for seat in &mut arriving {
            let mut problem = self.spare.pop().unwrap_or_else(|| base.clone());
            let Some(index) = take(&mut problem)? else {
                self.spare.push(problem);
                break;
            };
            let control = Control::new(&self.fresh.settings);
            *seat = Some(Seat { index, problem, control, judged: false });
        }
        Ok(arriving)
    }

    fn load(&mut self, arriving: &[Option<Seat>]) {
        let problems: Vec<_> = arriving.iter().map(|seat| seat.as_ref().map(|seat| &seat.problem)).collect();
        self.fresh.load(&problems);
    }

    /// The points to start from, into their lanes; who has none that is finite waits for a cold start.
    fn load_starts(&mut self, arriving: &mut [Option<Seat>], start: StartOf<'_, '_>) -> Result<(), Error> {
        for (lane, seat) in arriving.iter_mut().enumerate() {
            let Some(Seat { index, problem, control, .. }) = seat else { continue };
            let start = start(*index);
            start.fit(problem)?;
            control.warm_start = WarmStart::Used;
            if !self.fresh.load_start(lane, &start) {
                *control = control.fallen_back();
                self.again.extend(seat.take());
            }
        }
        Ok(())
    }

    /// Walk a start-up list with the problems loaded; they are then ready.
    fn bring(&mut self, mut arriving: Vec<Option<Seat>>, startup: &[Step]) {
        if arriving.iter().all(Option::is_none) {
            return;
        }
        for step in startup {
            perform(&mut self.fresh, &mut arriving, *step);
        }
        self.ready = arriving;
    }

    /// One iteration of all lanes. A lane whose problem ended hands it over, and the next one joins the others
    /// in this very iteration.
    fn iterate(
        &mut self,
        seat_next: &mut impl FnMut(&mut Self) -> Result<bool, Error>,
        done: &mut impl FnMut(usize, Solution),
    ) -> Result<(), Error> {
        self.seats.iter_mut().flatten().for_each(|seat| seat.judged = false);
        let Some((statistics, rest)) = ITERATION.split_first() else { return Ok(()) };
        while self.seats.iter().flatten().any(|seat| !seat.judged) {
            perform(&mut self.running, &mut self.seats, *statistics);
            self.hand_over(done);
            if !seat_next(self)? {
                return Ok(());
            }
        }
        for step in rest {
            perform(&mut self.running, &mut self.seats, *step);
        }
        Ok(())
    }

    fn hand_over(&mut self, done: &mut impl FnMut(usize, Solution)) {
        let ended = |seat: &Option<Seat>| seat.as_ref().is_some_and(|s| s.control.stop.is_some());
        if !self.seats.iter().any(ended) {
            return;
        }
        for step in CLOSING {
            perform(&mut self.running, &mut self.seats, *step);
        }
        for (lane, seat) in self.seats.iter_mut().enumerate() {
            if let Some(seat) = seat.take_if(|s| s.control.stop.is_some()) {
                let solution = Walked::new(&self.running, lane, &seat.problem, &seat.control).conclude();
                if let Some(control) = seat.control.fall_back(solution.status) {
                    self.again.push(Seat { control, judged: false, ..seat });
                } else {
                    done(seat.index, solution);
                    self.spare.push(seat.problem);
                }
            }
        }
    }
}

/// Run one step for all lanes; a repeated stage runs as long as any lane asks for it.
fn perform<T: Decide>(path: &mut Datapath<T>, seats: &mut [Option<Seat>], step: Step) {
    let mut run = |stage: Stage| {
        path.execute(stage);
        let mut again = false;
        for (lane, seat) in seats.iter_mut().enumerate() {
            let Some(seat) = seat else { continue };
            if stage == Stage::Statistics && core::mem::replace(&mut seat.judged, true) {
                continue;
            }
            if seat.control.stop.is_some() {
                seat.control.rest();
            } else {
                let outcome = seat.control.decide(lane, stage, &path.settings, &mut path.work);
                again |= outcome == Outcome::Repeat;
            }
        }
        if stage == Stage::Statistics {
            keep_best(seats.iter().map(|seat| seat.as_ref().map(|seat| &seat.control)), &mut path.work);
        }
        again
    };
    match step {
        Step::Run(stage) => {
            run(stage);
        }
        Step::Repeat { stage, until } => {
            while run(until) {
                run(stage);
            }
        }
    }
}

/// Buffers that the iteration or the closing reads before it writes them, and the best iterate. Certificates
/// stay behind: nobody looks at one that no decision has kept in the same solve.
fn carried_into_iteration() -> Vec<Buffer> {
    let mut written: Vec<Buffer> = Vec::new();
    let mut carried = vec![Buffer::Best];
    let stages = ITERATION.iter().chain(CLOSING).flat_map(|step| match *step {
        Step::Run(stage) => [Some(stage), None],
        Step::Repeat { stage, until } => [Some(until), Some(stage)],
    });
    for stage in stages.flatten() {
        for &buffer in stage.reads() {
            if !written.contains(&buffer) && !carried.contains(&buffer) && !CERTIFICATES.contains(&buffer) {
                carried.push(buffer);
            }
        }
        written.extend(stage.writes());
    }
    carried
}

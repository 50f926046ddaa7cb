//! List scheduling cycle by cycle, lane by lane: a lane goes on with the run that it is in; a lane without one takes
//! the most urgent operation that is ready. Runs keep neighbours together: they meet fewer conflicts, and compress.

use super::event_queue::Calendar;
use super::placement::Placement;
use super::priority::Urgency;
use super::ready::Ready;
use crate::stream::chains::Vectors;

/// Operations that a lane without a run tries in a cycle.
const TRIES: usize = 12;

/// How lanes keep to their runs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Habit {
    /// How many nodes earlier in the kernel weigh as much as a cycle more to the end; none: nothing does.
    pub nodes_per_cycle: Option<u32>,
    /// Cycles that a lane waits for a port before it leaves its run.
    pub patience: u32,
    /// A lane takes from another one's run only when there is nothing else.
    pub apart: bool,
}

impl Habit {
    /// The most urgent first, whatever run it is in.
    pub const URGENT: Self = Self { nodes_per_cycle: None, patience: 0, apart: false };
}

/// From the fewest bits on, as a rule.
pub(crate) const HABITS: [Habit; 4] = [
    Habit { nodes_per_cycle: Some(2), patience: 0, apart: true },
    Habit { nodes_per_cycle: Some(8), patience: 1, apart: true },
    Habit { nodes_per_cycle: None, patience: 0, apart: true },
    Habit::URGENT,
];

/// A lane's run: its last operation, and for how long the next one has been refused.
#[derive(Clone, Copy, Default)]
struct Lane {
    last: Option<u32>,
    held: u32,
}

/// The way through the cycles of a segment, as far as it has come.
pub(crate) struct Walk<'a> {
    placement: Placement<'a>,
    urgency: &'a Urgency,
    vectors: &'a Vectors,
    habit: Habit,
    /// How many lanes are in each run, and how many of its operations wait for one.
    claims: Vec<u8>,
    waiting: Vec<u8>,
    /// For how many each node still waits.
    waits: Vec<u32>,
    /// Whether each node waits for nothing but a lane.
    is_ready: Vec<bool>,
    /// Ranks by urgency: of operations for lanes, of those in another lane's run if lanes keep apart, of those for
    /// dividers.
    ready: Ready,
    claimed: Ready,
    divisions: Ready,
    /// Nodes by the cycle in which they become ready.
    calendar: Calendar,
    lanes: Vec<Lane>,
    /// Placed, their readers not yet told.
    placed: Vec<u32>,
    /// Who was due last.
    due: Vec<u32>,
    now: u32,
    /// How many nodes are not placed, and how many of them are for lanes.
    left: usize,
    left_to_lanes: u32,
    /// What waits for the nodes that are placed is not in storage before.
    end: u32,
}

impl<'a> Walk<'a> {
    /// At the first cycle, with an urgency that weighs nodes as the habit does.
    pub fn new(placement: Placement<'a>, urgency: &'a Urgency, vectors: &'a Vectors, habit: Habit) -> Self {
        let waits = placement.edges.waiting().count.clone();
        let nodes = waits.len();
        let mut calendar = Calendar::new(nodes);
        (0..nodes as u32).filter(|&k| waits[k as usize] == 0).for_each(|k| calendar.add(0, k));
        let on_lanes = placement.graph.nodes.iter().filter(|node| !node.code.on_divider());
        Self {
            left_to_lanes: on_lanes.count() as u32,
            end: 0,
            urgency,
            vectors,
            habit,
            claims: vec![0; vectors.heads().len()],
            waiting: vec![0; vectors.heads().len()],
            waits,
            is_ready: vec![false; nodes],
            ready: Ready::new(nodes),
            claimed: Ready::new(nodes),
            divisions: Ready::new(nodes),
            calendar,
            lanes: vec![Lane::default(); placement.configuration.lanes],
            placed: Vec::new(),
            due: Vec::new(),
            now: 0,
            left: nodes,
            placement,
        }
    }

    /// Go on until all nodes are placed, or until the end is sure to come after a limit; whether all are placed.
    pub fn run(&mut self, limit: u32) -> bool {
        while self.left > 0 {
            let lanes = self.lanes.len() as u32;
            if self.end.max(self.now + self.left_to_lanes.div_ceil(lanes)) > limit {
                return false;
            }
            self.cycle();
        }
        self.placement.end() <= limit
    }

    /// Where the nodes are.
    pub fn placement(self) -> Placement<'a> {
        self.placement
    }

    /// Fill one cycle, or as much of it as can be before more becomes ready within it.
    fn cycle(&mut self) {
        while self.calendar.is_due(self.now) {
            let mut due = core::mem::take(&mut self.due);
            self.calendar.take(self.now, &mut due);
            for &k in &due {
                self.welcome(k);
            }
            self.due = due;
            self.tell();
        }
        self.divide();
        // What has something to do in this cycle is taken, goes on with its run, or waits for a port.
        let free = self.placement.free_lanes(self.now);
        let idle = lanes_of(free).filter(|&lane| !self.go_on(lane)).fold(0u32, |all, k| all | 1 << k);
        // What one lane was refused, the others do not try.
        let mut from = [0, 0];
        lanes_of(idle).for_each(|lane| self.begin(lane, &mut from));
        self.tell();
        if !self.calendar.is_due(self.now) {
            self.now += 1;
        }
    }

    /// A node is ready. One that is alone and short goes at once, into the first gap: a lane full of long
    /// operations has its result register taken in every cycle to come but the last few.
    fn welcome(&mut self, k: u32) {
        let code = self.placement.graph.nodes[k as usize].code;
        let timing = self.placement.configuration.timing();
        let rank = self.urgency.rank(k);
        if code.on_divider() {
            self.divisions.insert(rank);
        } else if timing.latency(code) == timing.simple && self.vectors.is_alone(k) {
            self.placement.place_from(k, self.now);
            self.left_to_lanes -= 1;
            self.placed.push(k);
        } else {
            self.is_ready[k as usize] = true;
            self.waiting[self.vectors.run(k) as usize] += 1;
            self.among(k).insert(rank);
        }
    }

    fn divide(&mut self) {
        while let Some(rank) = self.divisions.next(0) {
            let k = self.urgency.of_rank(rank);
            if !self.placement.divider_free(k, self.now) {
                self.placement.accounts.divider_wait(self.now, self.now + 1);
                return;
            }
            self.divisions.remove(rank);
            self.placement.place_from(k, self.now);
            self.placed.push(k);
        }
    }

    /// Whether a free lane goes on with its run, or waits for a port.
    fn go_on(&mut self, lane: usize) -> bool {
        let next = self.lanes[lane].last.and_then(|last| self.following(last));
        let Some(k) = next.filter(|&k| self.is_ready[k as usize]) else { return false };
        if self.placement.try_place(k, self.now, 1 << lane).is_ok() {
            self.take(lane, k);
            return true;
        }
        self.lanes[lane].held += 1;
        self.lanes[lane].held <= self.habit.patience
    }

    /// What follows a node in its run; lanes that keep apart go past what another one took.
    fn following(&self, k: u32) -> Option<u32> {
        let mut next = self.vectors.next(k);
        while let Some(k) = next.filter(|&k| self.habit.apart && self.placement.is_placed(k)) {
            next = self.vectors.next(k);
        }
        next
    }

    /// Give a lane the most urgent operation that it can take, of those from a rank on of the free runs and of the
    /// claimed ones; the ranks move on after those tried.
    fn begin(&mut self, lane: usize, from: &mut [u32; 2]) {
        self.lanes[lane].held = 0;
        let sets = if self.habit.apart { 2 } else { 1 };
        for (claimed, from) in [false, true].into_iter().zip(from).take(sets) {
            for _ in 0..TRIES {
                let ready = if claimed { &self.claimed } else { &self.ready };
                let Some(rank) = ready.next(*from) else { break };
                *from = rank + 1;
                let k = self.urgency.of_rank(rank);
                if self.placement.try_place(k, self.now, 1 << lane).is_ok() {
                    self.take(lane, k);
                    return;
                }
            }
        }
    }

    fn take(&mut self, lane: usize, k: u32) {
        let rank = self.urgency.rank(k);
        self.among(k).remove(rank);
        self.left_to_lanes -= 1;
        self.is_ready[k as usize] = false;
        self.waiting[self.vectors.run(k) as usize] -= 1;
        let before = core::mem::replace(&mut self.lanes[lane], Lane { last: Some(k), held: 0 }).last;
        self.placed.push(k);
        if self.habit.apart {
            self.change_runs(before.map(|last| self.vectors.run(last)), self.vectors.run(k));
        }
    }

    /// A lane leaves a run, if it was in one, for another, or goes on with it.
    fn change_runs(&mut self, from: Option<u32>, to: u32) {
        if from != Some(to) {
            self.claim(to);
            if let Some(run) = from {
                self.leave(run);
            }
        }
    }

    /// The ready operations among which a node is, or would be.
    fn among(&mut self, k: u32) -> &mut Ready {
        if self.habit.apart && self.claims[self.vectors.run(k) as usize] > 0 {
            &mut self.claimed
        } else {
            &mut self.ready
        }
    }

    fn claim(&mut self, run: u32) {
        self.claims[run as usize] += 1;
        if self.claims[run as usize] == 1 {
            self.for_ready_of(run, |this, rank| {
                this.ready.remove(rank);
                this.claimed.insert(rank);
            });
        }
    }

    fn leave(&mut self, run: u32) {
        self.claims[run as usize] -= 1;
        if self.claims[run as usize] == 0 {
            self.for_ready_of(run, |this, rank| {
                this.claimed.remove(rank);
                this.ready.insert(rank);
            });
        }
    }

    /// Do something with the ranks of a run's operations that wait for a lane.
    fn for_ready_of(&mut self, run: u32, act: impl Fn(&mut Self, u32)) {
        let mut left = self.waiting[run as usize];
        let mut next = Some(self.vectors.heads()[run as usize]);
        while let Some(k) = next.filter(|_| left > 0) {
            if self.is_ready[k as usize] {
                act(self, self.urgency.rank(k));
                left -= 1;
            }
            next = self.vectors.next(k);
        }
    }

    /// Tell the readers of what was placed; those who wait for nothing more enter the calendar.
    fn tell(&mut self) {
        let mut placed = core::mem::take(&mut self.placed);
        let (waiting, paths) = (self.placement.edges.waiting(), self.placement.edges.paths());
        self.left -= placed.len();
        for k in placed.drain(..) {
            self.end = self.end.max(self.placement.places[k as usize].cycle + paths[k as usize]);
            let readers = waiting.first[k as usize] as usize..waiting.first[k as usize + 1] as usize;
            for &reader in &waiting.list[readers] {
                self.waits[reader as usize] -= 1;
                if self.waits[reader as usize] == 0 {
                    let when = self.placement.ready(reader).max(self.now);
                    self.calendar.add(when, reader);
                }
            }
        }
        self.placed = placed;
    }
}

/// The lanes of a mask.
fn lanes_of(mask: u32) -> impl Iterator<Item = usize> {
    let rest = |mask: &u32| Some(mask & (mask - 1)).filter(|&rest| rest != 0);
    core::iter::successors(Some(mask).filter(|&mask| mask != 0), rest)
        .map(|mask| mask.trailing_zeros() as usize)
}

#[cfg(test)]
mod tests {
    use super::HABITS;
    use crate::machine::configuration::Configuration;
    use crate::schedule::scheduler::Scheduler;
    use crate::stream::graph::Graph;
    use crate::stream::layout::Layout;
    use orbsoc::{record_tapes, Cones, Csc, Problem, Settings};

    fn problem() -> Problem {
        let entry = |i: usize, j: usize| if (i * 5 + j * 3) % 4 < 2 { 1.0 + (i + j) as f64 } else { 0.0 };
        let rows: Vec<Vec<f64>> = (0..9).map(|i| (0..5).map(|j| entry(i, j)).collect()).collect();
        let g = Csc::from_dense(&rows.iter().map(Vec::as_slice).collect::<Vec<_>>(), 5);
        let cones = Cones { l: 4, q: vec![5] };
        Problem::new(None, vec![1.0; 5], None, vec![], Some(g), vec![1.0; 9], cones).expect("sizes fit")
    }

    /// Left before its end or not, a walk says whether it is longer than its limit, and goes on as if never left.
    #[test]
    fn a_walk_is_left_exactly_when_it_is_too_long() {
        let recording = record_tapes(&problem(), &Settings::default()).unwrap();
        for lanes in [1, 2, 8] {
            let configuration = Configuration { lanes, banks: 4, ..Configuration::default() };
            let layout = Layout::new(&recording, &configuration).unwrap();
            for tape in &recording.tapes {
                let graph = Graph::new(tape, &layout);
                let scheduler = Scheduler::new(tape.stage.name(), &graph, &layout, &configuration);
                for habit in HABITS {
                    let urgency = scheduler.urgency(habit);
                    let new = || scheduler.walk(&graph, &urgency, habit);
                    let mut whole = new();
                    assert!(whole.run(u32::MAX));
                    let places = whole.placement();
                    let end = places.end();
                    for limit in [0, end / 2, end.saturating_sub(1), end, end + 1] {
                        let mut walk = new();
                        assert_eq!(walk.run(limit), end <= limit, "{} {habit:?} {limit}", tape.stage.name());
                        assert!(walk.run(end));
                        let again = walk.placement();
                        let cycles = |of: &super::Placement<'_>| {
                            of.places.iter().map(|place| place.cycle).collect::<Vec<_>>()
                        };
                        assert_eq!(cycles(&again), cycles(&places));
                    }
                }
            }
        }
    }
}

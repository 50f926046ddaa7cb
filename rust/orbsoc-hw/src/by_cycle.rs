//! List scheduling cycle by cycle, lane by lane: a lane goes on with the run that it is in; a lane without one takes
//! the most urgent operation that is ready. Runs keep neighbours together: they meet fewer conflicts, and compress.

use crate::calendar::Calendar;
use crate::placement::Placement;
use crate::ready::Ready;
use crate::vectors::Vectors;

/// Operations that a lane without a run tries in a cycle.
const TRIES: usize = 12;

/// Place all nodes. `patience`: cycles that a lane waits for a port before it leaves its run.
pub(crate) fn place_by_cycle(placement: Placement<'_>, patience: u32) -> Placement<'_> {
    let mut walk = Walk::new(placement, patience);
    while walk.left > 0 {
        walk.cycle();
    }
    walk.placement
}

/// A lane's run: its last operation, and for how long the next one has been refused.
#[derive(Clone, Copy, Default)]
struct Lane {
    last: Option<u32>,
    held: u32,
}

struct Walk<'a> {
    placement: Placement<'a>,
    patience: u32,
    vectors: Vectors,
    /// Who waits for each node: starts of the lists, the lists; and for how many each node waits.
    first: Vec<u32>,
    waiting: Vec<u32>,
    waits: Vec<u32>,
    is_ready: Vec<bool>,
    /// Ranks by urgency: of operations for lanes, of those for dividers.
    ready: Ready,
    divisions: Ready,
    /// Nodes by the cycle in which they become ready.
    calendar: Calendar,
    lanes: Vec<Lane>,
    /// Placed, their readers not yet told.
    placed: Vec<u32>,
    now: u32,
    left: usize,
}

impl<'a> Walk<'a> {
    fn new(placement: Placement<'a>, patience: u32) -> Self {
        let (first, waiting, waits) = placement.edges.waiting();
        let nodes = waits.len();
        let mut calendar = Calendar::new(nodes);
        (0..nodes as u32).filter(|&k| waits[k as usize] == 0).for_each(|k| calendar.add(0, k));
        Self {
            vectors: Vectors::new(placement.graph),
            patience,
            first,
            waiting,
            waits,
            is_ready: vec![false; nodes],
            ready: Ready::new(nodes),
            divisions: Ready::new(nodes),
            calendar,
            lanes: vec![Lane::default(); placement.configuration.lanes],
            placed: Vec::new(),
            now: 0,
            left: nodes,
            placement,
        }
    }

    /// Fill one cycle, or as much of it as can be before more becomes ready within it.
    fn cycle(&mut self) {
        while self.calendar.is_due(self.now) {
            for k in self.calendar.take(self.now) {
                self.welcome(k);
            }
            self.tell();
        }
        self.divide();
        let idle = (0..self.lanes.len()).filter(|&lane| !self.go_on(lane)).fold(0u32, |all, k| all | 1 << k);
        // What one lane was refused, the others do not try.
        let mut from = 0;
        for lane in (0..self.lanes.len()).filter(|lane| idle >> lane & 1 == 1) {
            from = self.begin(lane, from);
        }
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
        let rank = self.placement.edges.rank(k);
        if code.on_divider() {
            self.divisions.insert(rank);
        } else if timing.latency(code) == timing.simple && self.vectors.is_alone(k) {
            self.placement.place_from(k, self.now);
            self.placed.push(k);
        } else {
            self.is_ready[k as usize] = true;
            self.ready.insert(rank);
        }
    }

    fn divide(&mut self) {
        while let Some(rank) = self.divisions.next(0) {
            let k = self.placement.edges.of_rank(rank);
            if !self.placement.divider_free(k, self.now) {
                self.placement.accounts.divider_wait(self.now, self.now + 1);
                return;
            }
            self.divisions.remove(rank);
            self.placement.place_from(k, self.now);
            self.placed.push(k);
        }
    }

    /// Whether a lane has something to do in this cycle: it is taken, goes on with its run, or waits for a port.
    fn go_on(&mut self, lane: usize) -> bool {
        if !self.placement.lane_free(self.now, lane) {
            return true;
        }
        let next = self.lanes[lane].last.and_then(|last| self.vectors.next(last));
        let next = next.filter(|&k| self.is_ready[k as usize] && !self.placement.is_placed(k));
        let Some(k) = next else { return false };
        if self.placement.try_place(k, self.now, 1 << lane).is_ok() {
            self.take(lane, k);
            return true;
        }
        self.lanes[lane].held += 1;
        self.lanes[lane].held <= self.patience
    }

    /// Give a lane the most urgent operation from a rank on that it can take; the rank after those tried.
    fn begin(&mut self, lane: usize, mut from: u32) -> u32 {
        self.lanes[lane].held = 0;
        for _ in 0..TRIES {
            let Some(rank) = self.ready.next(from) else { break };
            from = rank + 1;
            let k = self.placement.edges.of_rank(rank);
            if self.placement.try_place(k, self.now, 1 << lane).is_ok() {
                self.take(lane, k);
                break;
            }
        }
        from
    }

    fn take(&mut self, lane: usize, k: u32) {
        self.lanes[lane] = Lane { last: Some(k), held: 0 };
        self.ready.remove(self.placement.edges.rank(k));
        self.placed.push(k);
    }

    /// Tell the readers of what was placed; those who wait for nothing more enter the calendar.
    fn tell(&mut self) {
        for k in core::mem::take(&mut self.placed) {
            self.left -= 1;
            for at in self.first[k as usize]..self.first[k as usize + 1] {
                let reader = self.waiting[at as usize];
                self.waits[reader as usize] -= 1;
                if self.waits[reader as usize] == 0 {
                    let when = self.placement.ready(reader).max(self.now);
                    self.calendar.add(when, reader);
                }
            }
        }
    }
}

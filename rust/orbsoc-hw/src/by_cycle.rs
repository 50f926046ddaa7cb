//! List scheduling cycle by cycle, lane by lane: a lane goes on with the run that it is in; a lane without one takes
//! the most urgent operation that is ready. Runs keep neighbours together: they meet fewer conflicts, and compress.

use crate::placement::Placement;
use crate::vectors::Vectors;
use std::collections::{BTreeMap, BinaryHeap};

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
    ready: BinaryHeap<(i64, u32)>,
    divisions: BinaryHeap<(i64, u32)>,
    /// Nodes by the cycle in which they become ready.
    calendar: BTreeMap<u32, Vec<u32>>,
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
        let at_once = (0..nodes as u32).filter(|&k| waits[k as usize] == 0).collect();
        Self {
            vectors: Vectors::new(placement.graph),
            patience,
            first,
            waiting,
            waits,
            is_ready: vec![false; nodes],
            ready: BinaryHeap::new(),
            divisions: BinaryHeap::new(),
            calendar: BTreeMap::from([(0, at_once)]),
            lanes: vec![Lane::default(); placement.configuration.lanes],
            placed: Vec::new(),
            now: 0,
            left: nodes,
            placement,
        }
    }

    /// Fill one cycle, or as much of it as can be before more becomes ready within it.
    fn cycle(&mut self) {
        while let Some(due) = self.calendar.remove(&self.now) {
            for k in due {
                self.welcome(k);
            }
            self.tell();
        }
        self.divide();
        let idle: Vec<usize> = (0..self.lanes.len()).filter(|&lane| !self.go_on(lane)).collect();
        let mut aside = Vec::new();
        for lane in idle {
            self.begin(lane, &mut aside);
        }
        self.ready.extend(aside);
        self.tell();
        if !self.calendar.contains_key(&self.now) {
            self.now += 1;
        }
    }

    /// A node is ready. One that is alone and short goes at once, into the first gap: a lane full of long
    /// operations has its result register taken in every cycle to come but the last few.
    fn welcome(&mut self, k: u32) {
        let code = self.placement.graph.nodes[k as usize].code;
        let timing = self.placement.configuration.timing();
        let urgency = self.placement.edges.urgency(k);
        if code.on_divider() {
            self.divisions.push((urgency, k));
        } else if timing.latency(code) == timing.simple && self.vectors.is_alone(k) {
            self.placement.place_from(k, self.now);
            self.placed.push(k);
        } else {
            self.is_ready[k as usize] = true;
            self.ready.push((urgency, k));
        }
    }

    fn divide(&mut self) {
        while let Some(&(_, k)) = self.divisions.peek() {
            if !self.placement.divider_free(k, self.now) {
                self.placement.accounts.divider_wait(self.now, self.now + 1);
                return;
            }
            self.divisions.pop();
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

    /// Give a lane the most urgent operation that it can take.
    fn begin(&mut self, lane: usize, aside: &mut Vec<(i64, u32)>) {
        self.lanes[lane].held = 0;
        let mut tries = 0;
        while tries < TRIES {
            let Some((urgency, k)) = self.ready.pop() else { return };
            if self.placement.is_placed(k) {
                continue;
            }
            tries += 1;
            if self.placement.try_place(k, self.now, 1 << lane).is_ok() {
                self.take(lane, k);
                return;
            }
            aside.push((urgency, k));
        }
    }

    fn take(&mut self, lane: usize, k: u32) {
        self.lanes[lane] = Lane { last: Some(k), held: 0 };
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
                    self.calendar.entry(when).or_default().push(reader);
                }
            }
        }
    }
}

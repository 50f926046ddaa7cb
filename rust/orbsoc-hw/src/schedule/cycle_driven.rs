//! Cycle-driven list scheduling: in each cycle a free lane continues its operation chain; a lane without one starts the
//! ready operation of the highest priority. Neighbours of a chain meet fewer bank conflicts, and compress.

use super::event_queue::EventQueue;
use super::placement::Placement;
use super::priority::Priorities;
use super::ready::ReadySet;
use crate::stream::chains::Chains;

/// Operations that a lane without a chain tries in a cycle.
const MAX_TRIES: usize = 12;

/// How strictly lanes keep to their chains.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SchedulingPolicy {
    /// As in [`Priorities::new`].
    pub nodes_per_cycle: Option<u32>,
    /// Cycles that a lane waits for a port before it leaves its chain.
    pub max_stalls: u32,
    /// A lane takes from another lane's chain only if nothing else is ready.
    pub exclusive: bool,
}

impl SchedulingPolicy {
    /// Critical path first, in any chain.
    pub const CRITICAL_PATH: Self = Self { nodes_per_cycle: None, max_stalls: 0, exclusive: false };
    /// As a rule, the fewest bits of microcode first.
    pub const ALL: [Self; 4] = [
        Self { nodes_per_cycle: Some(2), max_stalls: 0, exclusive: true },
        Self { nodes_per_cycle: Some(8), max_stalls: 1, exclusive: true },
        Self { nodes_per_cycle: None, max_stalls: 0, exclusive: true },
        Self::CRITICAL_PATH,
    ];
}

/// The last operation of a lane's chain, and the cycles for which its successor has been refused.
#[derive(Clone, Copy, Default)]
struct Lane {
    last: Option<u32>,
    stalls: u32,
}

/// The schedule of a segment up to the current cycle.
pub(crate) struct CycleScheduler<'a> {
    placement: Placement<'a>,
    priorities: &'a Priorities,
    chains: &'a Chains,
    policy: SchedulingPolicy,
    /// For each chain the lanes that are in it, and its operations that are ready for a lane.
    owners: Vec<u8>,
    ready_of_chain: Vec<u8>,
    /// Predecessors of each node that are not placed.
    unplaced_predecessors: Vec<u32>,
    /// Whether each node is ready for a lane.
    is_ready: Vec<bool>,
    /// Ready operations of free chains, of owned chains if the policy is exclusive, and of dividers.
    ready: ReadySet,
    owned: ReadySet,
    divisions: ReadySet,
    /// Nodes by the cycle in which they become ready.
    queue: EventQueue,
    lanes: Vec<Lane>,
    /// Placed nodes whose successors are not notified yet.
    placed: Vec<u32>,
    /// Scratch: the events of one cycle.
    events: Vec<u32>,
    now: u32,
    unplaced: usize,
    unplaced_on_lanes: u32,
    /// Lower bound of the end: the longest path from a placed node.
    end_bound: u32,
}

impl<'a> CycleScheduler<'a> {
    /// Before the first cycle. The priorities must be those of the policy.
    pub fn new(
        placement: Placement<'a>,
        priorities: &'a Priorities,
        chains: &'a Chains,
        policy: SchedulingPolicy,
    ) -> Self {
        let unplaced_predecessors = placement.edges.successors().predecessor_counts.clone();
        let nodes = unplaced_predecessors.len();
        let mut queue = EventQueue::new(nodes);
        (0..nodes as u32).filter(|&k| unplaced_predecessors[k as usize] == 0).for_each(|k| queue.push(0, k));
        let on_lanes = placement.graph.nodes.iter().filter(|node| !node.code.on_divider());
        Self {
            unplaced_on_lanes: on_lanes.count() as u32,
            end_bound: 0,
            priorities,
            chains,
            policy,
            owners: vec![0; chains.heads().len()],
            ready_of_chain: vec![0; chains.heads().len()],
            unplaced_predecessors,
            is_ready: vec![false; nodes],
            ready: ReadySet::new(nodes),
            owned: ReadySet::new(nodes),
            divisions: ReadySet::new(nodes),
            queue,
            lanes: vec![Lane::default(); placement.configuration.lanes],
            placed: Vec::new(),
            events: Vec::new(),
            now: 0,
            unplaced: nodes,
            placement,
        }
    }

    /// Schedule until all nodes are placed, or until the end must exceed `limit`. Whether the schedule is complete and
    /// ends within it; an interrupted one may be run again.
    pub fn run(&mut self, limit: u32) -> bool {
        while self.unplaced > 0 {
            let lanes = self.lanes.len() as u32;
            if self.end_bound.max(self.now + self.unplaced_on_lanes.div_ceil(lanes)) > limit {
                return false;
            }
            self.schedule_cycle();
        }
        self.placement.end() <= limit
    }

    pub fn placement(self) -> Placement<'a> {
        self.placement
    }

    /// Fill the current cycle. If more becomes ready within it, it stays current.
    fn schedule_cycle(&mut self) {
        while self.queue.has_events(self.now) {
            let mut events = core::mem::take(&mut self.events);
            self.queue.pop(self.now, &mut events);
            for &k in &events {
                self.mark_ready(k);
            }
            self.events = events;
            self.notify_successors();
        }
        self.issue_divisions();
        let free = self.placement.free_lanes(self.now);
        let mut idle =
            lanes_of(free).filter(|&lane| !self.continue_chain(lane)).fold(0u32, |all, k| all | 1 << k);
        // What one lane was refused, the others do not try.
        let mut from = [0, 0];
        while idle != 0 {
            let lanes = self.first_of_clusters(idle);
            let lane = self.start_chain(lanes, &mut from).unwrap_or(lanes & lanes.wrapping_neg());
            idle &= !lane;
        }
        self.notify_successors();
        if !self.queue.has_events(self.now) {
            self.now += 1;
        }
    }

    /// A node becomes ready. A short operation that is a chain by itself is placed at once, in the first gap: in a lane
    /// full of long operations only the last few cycles have a free result register.
    fn mark_ready(&mut self, k: u32) {
        let code = self.placement.graph.nodes[k as usize].code;
        let timing = self.placement.configuration.timing();
        let position = self.priorities.position(k);
        if code.on_divider() {
            self.divisions.insert(position);
        } else if timing.latency(code) == timing.simple && self.chains.is_single(k) {
            self.placement.place_from(k, self.now);
            self.unplaced_on_lanes -= 1;
            self.placed.push(k);
        } else {
            self.is_ready[k as usize] = true;
            self.ready_of_chain[self.chains.chain(k) as usize] += 1;
            self.ready_set_of(k).insert(position);
        }
    }

    fn issue_divisions(&mut self) {
        while let Some(position) = self.divisions.next(0) {
            let k = self.priorities.node_at(position);
            if !self.placement.divider_free(k, self.now) {
                self.placement.stalls.wait_for_divider(self.now, self.now + 1);
                return;
            }
            self.divisions.remove(position);
            self.placement.place_from(k, self.now);
            self.placed.push(k);
        }
    }

    /// Whether a free lane continues its chain, or stalls in it.
    fn continue_chain(&mut self, lane: usize) -> bool {
        let next = self.lanes[lane].last.and_then(|last| self.next_in_chain(last));
        let Some(k) = next.filter(|&k| self.is_ready[k as usize]) else { return false };
        if self.placement.try_place(k, self.now, 1 << lane).is_ok() {
            self.assign(lane, k);
            return true;
        }
        self.lanes[lane].stalls += 1;
        self.lanes[lane].stalls <= self.policy.max_stalls
    }

    /// The successor of a node in its chain; if the policy is exclusive, the first that is not placed.
    fn next_in_chain(&self, k: u32) -> Option<u32> {
        let mut next = self.chains.next(k);
        while let Some(k) = next.filter(|&k| self.policy.exclusive && self.placement.is_placed(k)) {
            next = self.chains.next(k);
        }
        next
    }

    /// The first lane of each cluster, of the lanes of a mask.
    fn first_of_clusters(&self, mask: u32) -> u32 {
        let configuration = self.placement.configuration;
        let first = |cluster| {
            let lanes = mask & configuration.lanes_of_cluster(cluster);
            lanes & lanes.wrapping_neg()
        };
        (0..configuration.clusters).fold(0, |all, cluster| all | first(cluster))
    }

    /// Assign the first ready operation that one of these lanes can take; the lane, as a bit. The positions `from`, of
    /// free and of owned chains, advance past those tried.
    fn start_chain(&mut self, lanes: u32, from: &mut [u32; 2]) -> Option<u32> {
        lanes_of(lanes).for_each(|lane| self.lanes[lane].stalls = 0);
        let sets = if self.policy.exclusive { 2 } else { 1 };
        for (owned, from) in [false, true].into_iter().zip(from).take(sets) {
            for _ in 0..MAX_TRIES {
                let ready = if owned { &self.owned } else { &self.ready };
                let Some(position) = ready.next(*from) else { break };
                *from = position + 1;
                let k = self.priorities.node_at(position);
                if self.placement.try_place(k, self.now, lanes).is_ok() {
                    let lane = self.placement.places[k as usize].unit;
                    self.assign(usize::from(lane), k);
                    return Some(1 << lane);
                }
            }
        }
        None
    }

    /// Record that a lane issues a node, which is placed already.
    fn assign(&mut self, lane: usize, k: u32) {
        let position = self.priorities.position(k);
        let chain = self.chains.chain(k);
        self.ready_set_of(k).remove(position);
        self.unplaced_on_lanes -= 1;
        self.is_ready[k as usize] = false;
        self.ready_of_chain[chain as usize] -= 1;
        let previous = core::mem::replace(&mut self.lanes[lane], Lane { last: Some(k), stalls: 0 }).last;
        self.placed.push(k);
        let left = previous.map(|last| self.chains.chain(last));
        if self.policy.exclusive && left != Some(chain) {
            self.acquire(chain);
            if let Some(left) = left {
                self.release(left);
            }
        }
    }

    /// The set that holds a node while it is ready for a lane.
    fn ready_set_of(&mut self, k: u32) -> &mut ReadySet {
        if self.policy.exclusive && self.owners[self.chains.chain(k) as usize] > 0 {
            &mut self.owned
        } else {
            &mut self.ready
        }
    }

    fn acquire(&mut self, chain: u32) {
        self.owners[chain as usize] += 1;
        if self.owners[chain as usize] == 1 {
            self.for_each_ready(chain, |this, position| {
                this.ready.remove(position);
                this.owned.insert(position);
            });
        }
    }

    fn release(&mut self, chain: u32) {
        self.owners[chain as usize] -= 1;
        if self.owners[chain as usize] == 0 {
            self.for_each_ready(chain, |this, position| {
                this.owned.remove(position);
                this.ready.insert(position);
            });
        }
    }

    /// Call `act` with the position of every ready operation of a chain.
    fn for_each_ready(&mut self, chain: u32, act: impl Fn(&mut Self, u32)) {
        let mut left = self.ready_of_chain[chain as usize];
        let mut next = Some(self.chains.heads()[chain as usize]);
        while let Some(k) = next.filter(|_| left > 0) {
            if self.is_ready[k as usize] {
                act(self, self.priorities.position(k));
                left -= 1;
            }
            next = self.chains.next(k);
        }
    }

    /// Notify the successors of the nodes placed; those without unplaced predecessors enter the event queue.
    fn notify_successors(&mut self) {
        let mut placed = core::mem::take(&mut self.placed);
        let (successors, paths) = (self.placement.edges.successors(), self.placement.edges.paths_to_sink());
        self.unplaced -= placed.len();
        for k in placed.drain(..) {
            self.end_bound = self.end_bound.max(self.placement.places[k as usize].cycle + paths[k as usize]);
            let range = successors.first[k as usize] as usize..successors.first[k as usize + 1] as usize;
            for &successor in &successors.list[range] {
                self.unplaced_predecessors[successor as usize] -= 1;
                if self.unplaced_predecessors[successor as usize] == 0 {
                    let cycle = self.placement.ready_cycle(successor).max(self.now);
                    self.queue.push(cycle, successor);
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
    use super::SchedulingPolicy;
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

    /// Interrupted or not, a run says whether the schedule exceeds the limit, and resumes to the same schedule.
    #[test]
    fn a_run_is_interrupted_exactly_when_the_schedule_is_too_long() {
        let recording = record_tapes(&problem(), &Settings::default()).unwrap();
        for lanes in [1, 2, 8] {
            let configuration = Configuration { lanes, banks: 4, ..Configuration::default() };
            let layout = Layout::new(&recording, &configuration).unwrap();
            for tape in &recording.tapes {
                let graph = Graph::new(tape, &layout, &configuration);
                let scheduler = Scheduler::new(tape.stage.name(), &graph, &layout, &configuration);
                for policy in SchedulingPolicy::ALL {
                    let priorities = scheduler.priorities(policy);
                    let new = || scheduler.by_cycle(&graph, &priorities, policy);
                    let mut whole = new();
                    assert!(whole.run(u32::MAX));
                    let places = whole.placement();
                    let end = places.end();
                    for limit in [0, end / 2, end.saturating_sub(1), end, end + 1] {
                        let mut interrupted = new();
                        assert_eq!(
                            interrupted.run(limit),
                            end <= limit,
                            "{} {policy:?} {limit}",
                            tape.stage.name()
                        );
                        assert!(interrupted.run(end));
                        let again = interrupted.placement();
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

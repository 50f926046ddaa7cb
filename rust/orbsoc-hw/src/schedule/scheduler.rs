//! Static scheduling of a segment: of two list schedulers, the shorter schedule. The engine decides nothing at run time.

use super::bounds::Bounds;
use super::causes::Causes;
use super::cycle_driven::{CycleScheduler, SchedulingPolicy};
use super::placement::{in_order, Place, Placement};
use super::priority::Priorities;
use super::registers::allocate_registers;
use crate::error::Error;
use crate::machine::configuration::Configuration;
use crate::machine::operation::Code;
use crate::stream::chains::Chains;
use crate::stream::edges::Edges;
use crate::stream::graph::{Graph, Operand};
use crate::stream::layout::{Layout, Literals};
use std::cell::OnceCell;

/// One scheduled operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub struct Issue {
    /// Cycle after the first word's.
    pub cycle: u32,
    /// Lane, or divider, as `code` says.
    pub unit: u8,
    pub code: Code,
    /// a, b, c; 0 where the operation does not read.
    pub operands: [u32; 3],
    pub destination: u32,
}

/// A scheduled segment.
#[derive(Clone, Debug)]
pub struct Schedule {
    /// In order of cycles, then of units.
    pub issues: Vec<Issue>,
    /// Microcode words: cycles up to the last issue.
    pub words: u32,
    /// Cycles for which the engine is busy.
    pub cycles: u32,
    /// Operations on lanes.
    pub lane_operations: u32,
    /// Lower bounds of the cycles.
    pub bounds: Bounds,
    /// Cycles by cause.
    pub causes: Causes,
    /// Issue slots of the lanes by cause.
    pub slots: Causes,
    /// Words of storage in use, temporaries included.
    pub storage: u32,
    /// Words that would do, were each used again as soon as it is free.
    pub least_storage: u32,
}

impl Schedule {
    /// Fraction of the lanes' busy cycles in which an operation was issued.
    pub fn utilisation(&self, configuration: &Configuration) -> f64 {
        f64::from(self.lane_operations) / (f64::from(self.cycles) * configuration.lanes as f64)
    }
}

/// What a schedule minimises.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aim {
    /// Fewest cycles.
    Fast,
    /// Few bits of compressed microcode, for a few cycles more.
    Compact,
}

/// Schedule a graph for the fewest cycles; temporaries follow the words of the layout.
///
/// # Errors
/// [`Error::Storage`] when the temporaries do not fit.
pub fn schedule(
    segment: &'static str,
    graph: &Graph,
    layout: &Layout,
    configuration: &Configuration,
) -> Result<Schedule, Error> {
    Scheduler::new(segment, graph, layout, configuration).fast()
}

/// Schedules of one graph, with what they have in common.
pub(crate) struct Scheduler<'a> {
    segment: &'static str,
    pub graph: &'a Graph,
    pub layout: &'a Layout,
    pub configuration: &'a Configuration,
    edges: Edges,
    chains: OnceCell<Chains>,
    critical_path: OnceCell<Priorities>,
}

impl<'a> Scheduler<'a> {
    pub fn new(
        segment: &'static str,
        graph: &'a Graph,
        layout: &'a Layout,
        configuration: &'a Configuration,
    ) -> Self {
        let edges = Edges::new(graph, configuration);
        Self {
            segment,
            graph,
            layout,
            configuration,
            edges,
            chains: OnceCell::new(),
            critical_path: OnceCell::new(),
        }
    }

    /// The schedule of the fewest cycles.
    ///
    /// # Errors
    /// [`Error::Storage`] when the temporaries do not fit.
    pub fn fast(&self) -> Result<Schedule, Error> {
        let (graph, configuration) = (self.graph, self.configuration);
        let bounds = Bounds::new(graph, &self.edges, configuration);
        let by_operation = || place_by_priority(self.placement(graph), self.critical_path());
        let by_cycle = |limit| {
            let mut scheduler = self.by_cycle(graph, self.critical_path(), SchedulingPolicy::CRITICAL_PATH);
            scheduler.run(limit).then(|| scheduler.placement())
        };
        let large = graph.nodes.len() > LARGE;
        let by_cycle_only = large && bounds.issue > bounds.dependency;
        let placement = if let Some(placement) = by_cycle_only.then(|| by_cycle(u32::MAX)).flatten() {
            placement
        } else {
            let one = by_operation();
            let least = bounds.cycles() - configuration.timing().startup - configuration.timing().finish;
            if large || one.end() <= least + least / NEAR {
                one
            } else {
                // Neither scheduler is always the better one.
                by_cycle(one.end()).unwrap_or(one)
            }
        };
        self.finish(placement, bounds, self.layout.words())
    }

    /// Priorities by path length alone.
    pub fn critical_path(&self) -> &Priorities {
        self.critical_path.get_or_init(|| self.priorities(SchedulingPolicy::CRITICAL_PATH))
    }

    /// Priorities of a policy.
    pub fn priorities(&self, policy: SchedulingPolicy) -> Priorities {
        Priorities::new(&self.edges, policy.nodes_per_cycle)
    }

    /// A cycle-driven scheduler of the same graph, whose results may have other locations.
    pub fn by_cycle<'b>(
        &'b self,
        graph: &'b Graph,
        priorities: &'b Priorities,
        policy: SchedulingPolicy,
    ) -> CycleScheduler<'b> {
        let chains = self.chains.get_or_init(|| Chains::new(self.graph));
        CycleScheduler::new(self.placement(graph), priorities, chains, policy)
    }

    /// The schedule of a cycle-driven scheduler that has placed all nodes; temporaries begin at `first_free`.
    ///
    /// # Errors
    /// As [`Scheduler::fast`].
    pub fn completed(&self, scheduler: CycleScheduler<'_>, first_free: u32) -> Result<Schedule, Error> {
        let placement = scheduler.placement();
        let bounds = Bounds::new(placement.graph, &self.edges, self.configuration);
        self.finish(placement, bounds, first_free)
    }

    fn placement<'b>(&'b self, graph: &'b Graph) -> Placement<'b> {
        Placement::new(graph, self.layout, self.configuration, &self.edges)
    }

    fn finish(&self, placement: Placement<'_>, bounds: Bounds, first_free: u32) -> Result<Schedule, Error> {
        let configuration = self.configuration;
        let end = placement.end();
        let Placement { graph, places, stalls, .. } = placement;
        let words = places.iter().map(|place| place.cycle + 1).max().unwrap_or(1);
        let order = in_order(&places, configuration);
        let (addresses, storage, least_storage) =
            allocate_registers(self.segment, graph, &places, &order, first_free, configuration)?;
        let timing = configuration.timing();
        let end = end.max(words);
        let issued = places.iter().map(|place| (place.cycle, place.code.on_divider()));
        let (causes, slots) = stalls.causes(issued, words, end, configuration);
        let lane_operations = graph.nodes.iter().filter(|node| !node.code.on_divider()).count() as u32;
        Ok(Schedule {
            issues: issues(graph, self.layout.literals(), &places, &order, &addresses),
            words,
            cycles: timing.startup + end + timing.finish,
            lane_operations,
            bounds,
            causes,
            slots,
            storage,
            least_storage,
        })
    }
}

/// Segments with more nodes are scheduled once: cycle by cycle if the lanes bound them, else operation by operation.
const LARGE: usize = 1 << 15;
/// A schedule within 1/`NEAR` of its lower bound is not tried another way.
const NEAR: u32 = 200;

/// Operation-driven list scheduling: in order of priority, each node in its first possible cycle, gaps included.
fn place_by_priority<'a>(mut placement: Placement<'a>, priorities: &Priorities) -> Placement<'a> {
    priorities.order().iter().for_each(|&k| placement.place(k));
    placement
}

fn issues(
    graph: &Graph,
    literals: Literals,
    places: &[Place],
    order: &[u32],
    addresses: &[u32],
) -> Vec<Issue> {
    let address = |operand: Option<Operand>| match operand {
        Some(Operand::Fixed(address)) => address,
        Some(Operand::Node(source)) => addresses[source as usize],
        None => 0,
    };
    let issue = |&k: &u32| {
        let (node, place) = (&graph.nodes[k as usize], places[k as usize]);
        let mut operands = node.operands.map(address);
        if place.code != node.code {
            match node.code {
                Code::Mul => operands[2] = literals.minus_zero,
                _ => operands[1] = literals.one,
            }
        }
        if place.swapped {
            operands.swap(0, 1);
        }
        let Place { cycle, unit, code, .. } = place;
        Issue { cycle, unit, code, operands, destination: addresses[k as usize] }
    };
    order.iter().map(issue).collect()
}

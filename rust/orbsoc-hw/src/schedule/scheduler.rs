//! Scheduling: every operation gets its cycle, its unit and its addresses. Nothing is left for the engine to decide.

use super::bounds::Bounds;
use super::causes::Causes;
use super::cycle_driven::{Habit, Walk};
use super::placement::{in_order, Place, Placement};
use super::priority::Urgency;
use super::registers::assign_rows;
use crate::error::Error;
use crate::machine::configuration::Configuration;
use crate::machine::operation::Code;
use crate::stream::chains::Vectors;
use crate::stream::edges::Edges;
use crate::stream::graph::{Graph, Operand};
use crate::stream::layout::{Layout, Literals};
use std::cell::OnceCell;

/// One operation in its place.
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

/// A segment, ready to be written as microcode.
#[derive(Clone, Debug)]
pub struct Schedule {
    /// In the order of cycles, and of units within one.
    pub issues: Vec<Issue>,
    /// Microcode words: cycles up to the last issue.
    pub words: u32,
    /// Cycles for which the engine is busy.
    pub cycles: u32,
    /// Operations on lanes.
    pub lane_operations: u32,
    /// Lower bounds of the cycles.
    pub bounds: Bounds,
    /// What every cycle went to.
    pub causes: Causes,
    /// What every lane did in every cycle.
    pub slots: Causes,
    /// Words of storage that are used, temporaries included.
    pub storage: u32,
}

impl Schedule {
    /// Share of the lanes' busy cycles in which an operation began.
    pub fn utilisation(&self, configuration: &Configuration) -> f64 {
        f64::from(self.lane_operations) / (f64::from(self.cycles) * configuration.lanes as f64)
    }
}

/// What a schedule is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aim {
    /// Fewest cycles.
    Fast,
    /// Few bits of compressed microcode, for a few cycles more.
    Compact,
}

/// Schedule a graph of a layout for the fewest cycles; temporaries go behind its words.
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

/// What all schedules of a graph have in common.
pub(crate) struct Scheduler<'a> {
    segment: &'static str,
    pub graph: &'a Graph,
    pub layout: &'a Layout,
    pub configuration: &'a Configuration,
    edges: Edges,
    vectors: OnceCell<Vectors>,
    urgent: OnceCell<Urgency>,
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
            vectors: OnceCell::new(),
            urgent: OnceCell::new(),
        }
    }

    /// The schedule of the fewest cycles.
    ///
    /// # Errors
    /// [`Error::Storage`] when the temporaries do not fit.
    pub fn fast(&self) -> Result<Schedule, Error> {
        let (graph, configuration) = (self.graph, self.configuration);
        let bounds = Bounds::new(graph, &self.edges, configuration);
        let by_urgency = || place_by_urgency(self.placement(graph), self.urgent());
        let by_cycle = |limit| {
            let mut walk = self.walk(graph, self.urgent(), Habit::URGENT);
            walk.run(limit).then(|| walk.placement())
        };
        let by_cycle_only = graph.nodes.len() > ONE_WAY && bounds.issue > bounds.dependency;
        let placement = if let Some(placement) = by_cycle_only.then(|| by_cycle(u32::MAX)).flatten() {
            placement
        } else {
            let one = by_urgency();
            let most = bounds.cycles() - configuration.timing().startup - configuration.timing().finish;
            if graph.nodes.len() > ONE_WAY || one.end() <= most + most / NEAR {
                one
            } else {
                // Neither way is always the shorter one: the cycles decide.
                by_cycle(one.end()).unwrap_or(one)
            }
        };
        self.finished(placement, bounds, self.layout.words())
    }

    /// Nodes from the most urgent on.
    pub fn urgent(&self) -> &Urgency {
        self.urgent.get_or_init(|| self.urgency(Habit::URGENT))
    }

    /// Nodes from the most urgent on, as lanes of a habit weigh them.
    pub fn urgency(&self, habit: Habit) -> Urgency {
        Urgency::new(&self.edges, habit.nodes_per_cycle)
    }

    /// A schedule to be made lane by lane, with lanes of a habit, of the same graph but for the words of its results.
    pub fn walk<'b>(&'b self, graph: &'b Graph, urgency: &'b Urgency, habit: Habit) -> Walk<'b> {
        Walk::new(self.placement(graph), urgency, self.vectors(), habit)
    }

    /// The schedule of a walk at its end, where results have words below `settled`.
    ///
    /// # Errors
    /// As [`Scheduler::fast`].
    pub fn walked(&self, walk: Walk<'_>, settled: u32) -> Result<Schedule, Error> {
        let placement = walk.placement();
        let bounds = Bounds::new(placement.graph, &self.edges, self.configuration);
        self.finished(placement, bounds, settled)
    }

    fn placement<'b>(&'b self, graph: &'b Graph) -> Placement<'b> {
        Placement::new(graph, self.layout, self.configuration, &self.edges)
    }

    fn vectors(&self) -> &Vectors {
        self.vectors.get_or_init(|| Vectors::new(self.graph))
    }

    fn finished(&self, placement: Placement<'_>, bounds: Bounds, first_free: u32) -> Result<Schedule, Error> {
        let configuration = self.configuration;
        let end = placement.end();
        let Placement { graph, places, accounts, .. } = placement;
        let words = places.iter().map(|place| place.cycle + 1).max().unwrap_or(1);
        let order = in_order(&places, configuration);
        let (addresses, storage) =
            assign_rows(self.segment, graph, &places, &order, first_free, configuration)?;
        let timing = configuration.timing();
        let end = end.max(words);
        let issued = places.iter().map(|place| (place.cycle, place.code.on_divider()));
        let (causes, slots) = accounts.settle(issued, words, end, configuration);
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
        })
    }
}

/// Larger segments are scheduled one way only: lane by lane if the lanes bound them, else by urgency.
const ONE_WAY: usize = 1 << 15;
/// A schedule that is this share above its bound is not tried another way.
const NEAR: u32 = 200;

/// Place the most urgent first, each in the first cycle that takes it; a later one may fill a gap before an earlier one.
fn place_by_urgency<'a>(mut placement: Placement<'a>, urgency: &Urgency) -> Placement<'a> {
    urgency.order().iter().for_each(|&k| placement.place(k));
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

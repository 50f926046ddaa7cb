//! Scheduling: every operation gets its cycle, its unit and its addresses. Nothing is left for the engine to decide.

use crate::by_cycle::place_by_cycle;
use crate::causes::Causes;
use crate::code::Code;
use crate::configuration::Configuration;
use crate::edges::Edges;
use crate::error::Error;
use crate::graph::{Graph, Operand};
use crate::layout::{Layout, Literals};
use crate::placement::{Place, Placement};
use crate::rows::assign_rows;

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
    /// Few bits of compressed microcode: a lane rather waits than leaves its run.
    Compact,
}

impl Aim {
    /// Cycles that a lane waits for a port before it turns to another run.
    fn patience(self) -> u32 {
        match self {
            Self::Fast => 0,
            Self::Compact => 2,
        }
    }
}

/// Schedule a graph of a layout; temporaries go behind its words.
///
/// # Errors
/// [`Error::Storage`] when the temporaries do not fit.
pub fn schedule(
    segment: &'static str,
    graph: &Graph,
    layout: &Layout,
    configuration: &Configuration,
    aim: Aim,
) -> Result<Schedule, Error> {
    let edges = Edges::new(graph, configuration);
    let new = || Placement::new(graph, layout, configuration, &edges);
    let by_cycle = || place_by_cycle(new(), aim.patience());
    let by_urgency = || place_by_urgency(new());
    let placement = if aim == Aim::Compact {
        by_cycle()
    } else if graph.nodes.len() > ONE_WAY {
        let lanes = graph.nodes.iter().filter(|node| !node.code.on_divider()).count();
        let issue_bound = lanes / configuration.lanes > edges.longest() as usize;
        if issue_bound {
            by_cycle()
        } else {
            by_urgency()
        }
    } else {
        // Neither way is always the shorter one: the cycles decide.
        let (one, other) = (by_urgency(), by_cycle());
        if one.end() < other.end() {
            one
        } else {
            other
        }
    };
    finished(segment, graph, layout, configuration, placement)
}

/// Larger segments are scheduled one way only: lane by lane if the lanes bound them, else by urgency.
const ONE_WAY: usize = 1 << 15;

fn finished(
    segment: &'static str,
    graph: &Graph,
    layout: &Layout,
    configuration: &Configuration,
    placement: Placement<'_>,
) -> Result<Schedule, Error> {
    let end = placement.end();
    let Placement { places, accounts, .. } = placement;
    let words = places.iter().map(|place| place.cycle + 1).max().unwrap_or(1);
    let (addresses, storage) = assign_rows(segment, graph, &places, layout.words(), configuration)?;
    let timing = configuration.timing();
    let end = end.max(words);
    let (causes, slots) = accounts.settle(graph, &places, words, end, configuration);
    let lane_operations = graph.nodes.iter().filter(|node| !node.code.on_divider()).count() as u32;
    Ok(Schedule {
        issues: issues(graph, layout.literals(), &places, &addresses),
        words,
        cycles: timing.startup + end + timing.finish,
        lane_operations,
        causes,
        slots,
        storage,
    })
}

/// Place the most urgent first, each in the first cycle that takes it; a later one may fill a gap before an earlier one.
fn place_by_urgency(mut placement: Placement<'_>) -> Placement<'_> {
    let mut order: Vec<u32> = (0..placement.graph.nodes.len() as u32).collect();
    order.sort_unstable_by_key(|&k| core::cmp::Reverse(placement.edges.urgency(k)));
    for k in order {
        placement.place(k);
    }
    placement
}

fn issues(graph: &Graph, literals: Literals, places: &[Place], addresses: &[u32]) -> Vec<Issue> {
    let mut issues: Vec<Issue> = graph
        .nodes
        .iter()
        .zip(places)
        .enumerate()
        .map(|(k, (node, place))| {
            let address = |operand: Option<Operand>| match operand {
                Some(Operand::Fixed(address)) => address,
                Some(Operand::Node(source)) => addresses[source as usize],
                None => 0,
            };
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
            let Place { cycle, unit, code, .. } = *place;
            Issue { cycle, unit, code, operands, destination: addresses[k] }
        })
        .collect();
    issues.sort_unstable_by_key(|issue| (issue.cycle, issue.code.on_divider(), issue.unit));
    issues
}

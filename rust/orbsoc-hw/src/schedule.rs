//! List scheduling: every operation gets its cycle, its unit and its bank, and every port is reserved.
//!
//! Operations are placed one after the other, the one with the longest way to the end first, each in the first
//! cycle in which its operands are there and its lane or divider, read ports, result register and write port are free.
//! A later one may fill a gap before an earlier one. Nothing is left for the engine to decide.

use crate::causes::{Accounts, Causes};
use crate::code::Code;
use crate::configuration::Configuration;
use crate::edges::Edges;
use crate::error::Error;
use crate::graph::{Graph, Node, Operand};
use crate::layout::{Layout, Literals};
use crate::reservation::{Conflict, Read, Reservation};
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

/// A node's place. The operands are in the order in which they are read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// The node's, or the chain that does the same.
    pub code: Code,
    pub cycle: u32,
    pub unit: u8,
    pub bank: u8,
    pub swapped: bool,
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
) -> Result<Schedule, Error> {
    let edges = Edges::new(graph, configuration);
    let mut order: Vec<u32> = (0..graph.nodes.len() as u32).collect();
    order.sort_unstable_by_key(|&k| core::cmp::Reverse(urgency(k, &edges)));
    let mut placement = Placement::new(graph, layout, configuration, &edges);
    for &k in &order {
        placement.place(k);
    }
    let Placement { places, accounts, .. } = placement;
    let words = places.iter().map(|place| place.cycle + 1).max().unwrap_or(1);
    let (addresses, storage) = assign_rows(segment, graph, &places, layout.words(), configuration)?;
    let timing = configuration.timing();
    let ends = places.iter().map(|place| place.cycle + timing.distance(place.code) + 1);
    let end = ends.max().unwrap_or(0).max(words);
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

/// Who is placed first: the longest way to the end, but of two ways about as long the earlier one in the
/// kernel, which finishes what it began: that is the order in which pivots free most work. Decreases along every
/// edge, since ways get shorter and numbers higher.
fn urgency(k: u32, edges: &Edges) -> i64 {
    const NODES_PER_CYCLE: i64 = 32;
    NODES_PER_CYCLE * i64::from(edges.path[k as usize]) - i64::from(k)
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

struct Placement<'a> {
    graph: &'a Graph,
    configuration: &'a Configuration,
    edges: &'a Edges,
    literals: Literals,
    reservation: Reservation,
    places: Vec<Place>,
    accounts: Accounts,
    preferred_bank: u8,
}

const NOWHERE: Place = Place { code: Code::Move, cycle: u32::MAX, unit: 0, bank: 0, swapped: false };

impl<'a> Placement<'a> {
    fn new(graph: &'a Graph, layout: &Layout, configuration: &'a Configuration, edges: &'a Edges) -> Self {
        Self {
            graph,
            configuration,
            edges,
            literals: layout.literals(),
            reservation: Reservation::new(configuration),
            places: vec![NOWHERE; graph.nodes.len()],
            accounts: Accounts::default(),
            preferred_bank: 0,
        }
    }

    /// What an operand reads, named so that equal words have equal names.
    fn read(&self, operand: Operand) -> Read {
        match operand {
            Operand::Fixed(address) => Read { value: address, bank: self.configuration.bank(address) as u8 },
            Operand::Node(source) => {
                let fixed = self.configuration.words() as u32;
                Read { value: fixed + source, bank: self.places[source as usize].bank }
            }
        }
    }

    /// Place a node in the first cycle that takes it.
    fn place(&mut self, k: u32) {
        let node = self.graph.nodes[k as usize];
        let (mut ready, mut after_divider) = (0, false);
        for &(source, result) in self.edges.into(k) {
            let place = self.places[source as usize];
            let there =
                place.cycle + if result { self.configuration.timing().distance(place.code) } else { 0 };
            if there >= ready {
                ready = there;
                after_divider = self.graph.nodes[source as usize].code.on_divider();
            }
        }
        self.accounts.arrived(ready, after_divider);
        let operands = node.operands.map(|operand| operand.map(|o| self.read(o)));
        let mut cycle = ready;
        let divider = node.code.on_divider();
        loop {
            cycle = if divider {
                let (free, _) = self.reservation.divider_from(cycle, node.code);
                self.accounts.divider_wait(cycle, free);
                free
            } else {
                self.reservation.open_from(cycle)
            };
            match self.try_cycle(&node, cycle, operands) {
                Ok(place) => {
                    self.places[k as usize] = place;
                    return;
                }
                Err(conflict) => {
                    self.accounts.refused(cycle, conflict);
                    if !divider {
                        self.reservation.refuse(cycle);
                    }
                }
            }
            cycle += 1;
        }
    }

    /// Take this cycle, or say what is in the way.
    fn try_cycle(
        &mut self,
        node: &Node,
        cycle: u32,
        mut operands: [Option<Read>; 3],
    ) -> Result<Place, Conflict> {
        let mut code = node.code;
        let unit = if code.on_divider() {
            self.reservation.divider_from(cycle, code).1
        } else {
            let mut lanes = self.reservation.lanes_for(cycle, code);
            if lanes == 0 {
                // The result register is taken too soon: the whole chain takes longer and may find it free.
                code = code.by_chain().ok_or(Conflict::Result)?;
                lanes = self.reservation.lanes_for(cycle, code);
                self.fill(node.code, &mut operands);
            }
            if lanes == 0 {
                return Err(Conflict::Result);
            }
            lanes.trailing_zeros() as usize
        };
        let mut swapped = false;
        if !self.reservation.may_read(cycle, &operands) {
            operands.swap(0, 1);
            swapped = true;
            if !code.commutes() || !self.reservation.may_read(cycle, &operands) {
                return Err(Conflict::ReadPort);
            }
        }
        let banks = self.reservation.banks_for(cycle, code);
        let bank = self.bank(node, banks).ok_or(Conflict::WritePort)?;
        self.reservation.take(cycle, code, unit, &operands, bank);
        Ok(Place { code, cycle, unit: unit as u8, bank: bank as u8, swapped })
    }

    /// The literal that makes a chain of a product or a sum.
    fn fill(&self, code: Code, operands: &mut [Option<Read>; 3]) {
        let (missing, address) = match code {
            Code::Mul => (2, self.literals.minus_zero),
            _ => (1, self.literals.one),
        };
        operands[missing] = Some(self.read(Operand::Fixed(address)));
    }

    /// The bank of the home; or that of the accumulator, whose word it may take over; or the next one in turn.
    fn bank(&mut self, node: &Node, free: u64) -> Option<usize> {
        if let Some(home) = node.home {
            let bank = self.configuration.bank(home);
            return (free >> bank & 1 == 1).then_some(bank);
        }
        if let Some(Operand::Node(source)) = node.operands[2] {
            let bank = self.places[source as usize].bank;
            if self.graph.uses[source as usize] == 1 && free >> bank & 1 == 1 {
                return Some(bank as usize);
            }
        }
        let banks = self.configuration.banks as u32;
        let above = free & (u64::MAX << self.preferred_bank);
        let bank = if above != 0 { above } else { free }.trailing_zeros();
        self.preferred_bank = ((bank + 1) % banks) as u8;
        (bank < banks).then_some(bank as usize)
    }
}

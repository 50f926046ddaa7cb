//! Placement of one operation in one cycle: its lane or divider, its bank, and the ports that it reserves.

use super::causes::Stalls;
use super::reads::Reads;
use super::reservation::{Conflict, Reservation};
use crate::machine::configuration::Configuration;
use crate::machine::operation::Code;
use crate::stream::edges::Edges;
use crate::stream::graph::{Graph, Node, Operand};
use crate::stream::layout::{Layout, Literals};

/// A node's place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// The node's code, or the multiply-add that computes the same.
    pub code: Code,
    pub cycle: u32,
    pub unit: u8,
    pub bank: u8,
    /// Whether a and b are exchanged.
    pub swapped: bool,
}

/// Nodes in the order of cycles, and of lanes, then dividers, within one.
pub(crate) fn in_order(places: &[Place], configuration: &Configuration) -> Vec<u32> {
    const EMPTY: u32 = u32::MAX;
    let units = configuration.lanes + configuration.dividers;
    let words = places.iter().map(|place| place.cycle as usize + 1).max().unwrap_or(0);
    let mut slots = vec![EMPTY; words * units];
    for (place, k) in places.iter().zip(0..) {
        let first = if place.code.on_divider() { configuration.lanes } else { 0 };
        slots[place.cycle as usize * units + first + usize::from(place.unit)] = k;
    }
    slots.retain(|&k| k != EMPTY);
    slots
}

/// All lanes, for operations outside a lane's chain.
pub(crate) const ANY_LANE: u32 = u32::MAX;

/// Where a node may be placed: a divider, or lanes of a cluster.
struct Candidates {
    unit: Option<usize>,
    lanes: u32,
    cluster: usize,
}

const UNPLACED: Place = Place { code: Code::Move, cycle: u32::MAX, unit: 0, bank: 0, swapped: false };

/// A partial schedule. Predecessors must be placed before their successors.
pub(crate) struct Placement<'a> {
    pub graph: &'a Graph,
    pub configuration: &'a Configuration,
    pub edges: &'a Edges,
    pub places: Vec<Place>,
    pub stalls: Stalls,
    reservation: Reservation,
    literals: Literals,
    preferred_bank: u8,
    distances: [u32; Code::ALL.len()],
}

impl<'a> Placement<'a> {
    pub fn new(
        graph: &'a Graph,
        layout: &Layout,
        configuration: &'a Configuration,
        edges: &'a Edges,
    ) -> Self {
        let least = edges.critical_path().max(graph.nodes.len() as u32 / configuration.lanes as u32);
        Self {
            graph,
            configuration,
            edges,
            places: vec![UNPLACED; graph.nodes.len()],
            stalls: Stalls::default(),
            reservation: Reservation::new(configuration, least + least / 8),
            literals: layout.literals(),
            preferred_bank: 0,
            distances: Code::ALL.map(|code| configuration.timing().distance(code)),
        }
    }

    pub fn is_placed(&self, k: u32) -> bool {
        self.places[k as usize].cycle != UNPLACED.cycle
    }

    /// The first cycle in which everything is in storage.
    pub fn end(&self) -> u32 {
        let ends = self.places.iter().map(|place| place.cycle + self.distance(place.code) + 1);
        ends.max().unwrap_or(0)
    }

    fn distance(&self, code: Code) -> u32 {
        self.distances[code as usize]
    }

    /// The first cycle in which a node has its operands and its word may be overwritten.
    pub fn ready_cycle(&mut self, k: u32) -> u32 {
        let (mut ready, mut after_divider) = (0, false);
        for &(source, result) in self.edges.predecessors(k) {
            let place = self.places[source as usize];
            let wait = if result { self.distance(place.code) } else { 0 };
            if place.cycle + wait >= ready {
                (ready, after_divider) = (place.cycle + wait, place.code.on_divider());
            }
        }
        self.stalls.arrived(ready, after_divider);
        ready
    }

    /// Place a node in the first possible cycle.
    pub fn place(&mut self, k: u32) {
        let ready = self.ready_cycle(k);
        self.place_from(k, ready);
    }

    /// Place a node in the first possible cycle from `cycle` on.
    pub fn place_from(&mut self, k: u32, mut cycle: u32) {
        let code = self.graph.nodes[k as usize].code;
        loop {
            if code.on_divider() {
                let (free, _) = self.reservation.divider_from(cycle, code);
                self.stalls.wait_for_divider(cycle, free);
                cycle = free;
            } else {
                cycle = self.reservation.open_from(cycle);
            }
            match self.try_place(k, cycle, ANY_LANE) {
                Ok(()) => return,
                Err(_) if code.on_divider() => {}
                Err(_) => self.reservation.refuse(cycle),
            }
            cycle += 1;
        }
    }

    /// Lanes in which no operation begins, as bits.
    pub fn free_lanes(&mut self, cycle: u32) -> u32 {
        self.reservation.reach(cycle);
        self.reservation.free_lanes(cycle)
    }

    /// Whether a divider is free for a node in a cycle.
    pub fn divider_free(&mut self, k: u32, cycle: u32) -> bool {
        self.reservation.divider_from(cycle, self.graph.nodes[k as usize].code).0 == cycle
    }

    /// Place a node in a cycle, in one of the lanes of a mask, or return the conflict.
    pub fn try_place(&mut self, k: u32, cycle: u32, lanes: u32) -> Result<(), Conflict> {
        self.reservation.reach(cycle);
        let tried = self.find(&self.graph.nodes[k as usize], cycle, lanes);
        match tried {
            Ok(place) => self.places[k as usize] = place,
            Err(conflict) => self.stalls.conflict(cycle, conflict),
        }
        tried.map(|_| ())
    }

    /// A place in one of the lanes of a mask: in the cluster that most of the node's words belong to, if it can be.
    fn find(&mut self, node: &Node, cycle: u32, allowed: u32) -> Result<Place, Conflict> {
        let reads = self.reads(node);
        if node.code.on_divider() {
            let unit = self.reservation.divider_from(cycle, node.code).1;
            let cluster = self.configuration.cluster_of_unit(true, unit);
            return self.find_in(
                node,
                cycle,
                reads,
                Candidates { unit: Some(unit), lanes: allowed, cluster },
            );
        }
        let clusters = self.configuration.clusters;
        if clusters == 1 {
            return self.find_in(node, cycle, reads, Candidates { unit: None, lanes: allowed, cluster: 0 });
        }
        let mut conflict = Conflict::Result;
        for cluster in self.by_locality(node, &reads) {
            let lanes = allowed & self.configuration.lanes_of_cluster(cluster);
            match self.find_in(node, cycle, reads, Candidates { unit: None, lanes, cluster }) {
                Ok(place) => return Ok(place),
                // What waits for a port waits for more than a lane.
                Err(found) => conflict = if found == Conflict::Result { conflict } else { found },
            }
        }
        Err(conflict)
    }

    fn find_in(
        &mut self,
        node: &Node,
        cycle: u32,
        mut reads: Reads,
        Candidates { unit, lanes: allowed, cluster }: Candidates,
    ) -> Result<Place, Conflict> {
        let mut code = node.code;
        let unit = if let Some(unit) = unit {
            unit
        } else {
            let mut lanes = self.reservation.lanes_for(cycle, code) & allowed;
            if lanes == 0 {
                // The result register is taken in that cycle. As a multiply-add the operation takes longer.
                code = code.as_multiply_add().ok_or(Conflict::Result)?;
                lanes = self.reservation.lanes_for(cycle, code) & allowed;
                self.add_literal(node.code, &mut reads);
            }
            if lanes == 0 {
                return Err(Conflict::Result);
            }
            lanes.trailing_zeros() as usize
        };
        let mut swapped = false;
        if !self.reservation.may_read(cycle, &reads, cluster) {
            // Within a chain operands are not exchanged: their addresses would no longer compress.
            reads.swap();
            swapped = true;
            if allowed.is_power_of_two()
                || !code.commutes()
                || !self.reservation.may_read(cycle, &reads, cluster)
            {
                return Err(Conflict::ReadPort);
            }
        }
        let (local, free) = self.reservation.banks_for(cycle, code, cluster);
        let bank = self.bank(node, local, free).ok_or(Conflict::WritePort)?;
        self.reservation.take(cycle, code, unit, &reads, bank, cluster);
        Ok(Place { code, cycle, unit: unit as u8, bank: bank as u8, swapped })
    }

    /// Clusters, the one with most of a node's words first.
    fn by_locality(&self, node: &Node, reads: &Reads) -> Vec<usize> {
        let mut words = [0u32; 8];
        for (replica, &bank) in reads.banks.iter().enumerate() {
            if bank != 0 {
                let cluster = self.configuration.cluster_of_bank(bank.trailing_zeros() as usize);
                words[cluster] += if replica == 2 { 2 } else { 1 };
            }
        }
        if let Some(location) = node.location {
            words[self.configuration.cluster_of_bank(self.configuration.bank(location))] += 1;
        }
        let mut clusters: Vec<usize> = (0..self.configuration.clusters).collect();
        clusters.sort_by_key(|&cluster| core::cmp::Reverse(words[cluster]));
        clusters
    }

    /// What a node reads.
    fn reads(&self, node: &Node) -> Reads {
        let mut reads = Reads::default();
        for (replica, operand) in node.operands.iter().enumerate() {
            match operand {
                Some(Operand::Fixed(address)) => {
                    reads.set(replica, self.configuration.bank(*address) as u8, *address);
                }
                Some(Operand::Node(source)) => {
                    let fixed = self.configuration.words() as u32;
                    reads.set(replica, self.places[*source as usize].bank, fixed + source);
                }
                None => {}
            }
        }
        reads
    }

    /// Read the literal that makes a product or a sum a multiply-add.
    fn add_literal(&self, code: Code, reads: &mut Reads) {
        let (missing, address) = match code {
            Code::Mul => (2, self.literals.minus_zero),
            _ => (1, self.literals.one),
        };
        reads.set(missing, self.configuration.bank(address) as u8, address);
    }

    /// The bank of the location; or that of the accumulator, whose word may be reused; or the next one of the cluster,
    /// round robin.
    fn bank(&mut self, node: &Node, local: u64, free: u64) -> Option<usize> {
        if let Some(location) = node.location {
            let bank = self.configuration.bank(location);
            return (free >> bank & 1 == 1).then_some(bank);
        }
        if let Some(Operand::Node(source)) = node.operands[2] {
            let bank = self.places[source as usize].bank;
            if self.graph.uses[source as usize] == 1 && local >> bank & 1 == 1 {
                return Some(bank as usize);
            }
        }
        let banks = self.configuration.banks as u32;
        let free = if local != 0 { local } else { free };
        let above = free & (u64::MAX << self.preferred_bank);
        let bank = if above != 0 { above } else { free }.trailing_zeros();
        self.preferred_bank = ((bank + 1) % banks) as u8;
        (bank < banks).then_some(bank as usize)
    }
}

//! Dataflow graph of a tape: the engine's operations, their dependences and the locations of their results.
//!
//! Dead results are eliminated. Where a chain of sums would wait for products, they are taken apart. A stored result is computed into the word that stores it. A further copy of a result,
//! and a stored word or literal, costs a `move`. A word is overwritten only after its last reader: anti-dependences are
//! edges without latency.

use super::layout::Layout;
pub use super::node::{Node, Operand};
use super::products::take_apart;
use crate::machine::configuration::Configuration;
use crate::machine::operation::Code;
use orbsoc::real::Value;
use orbsoc::{Buffer, Tape};
use std::collections::HashMap;

/// The operations of a segment. Every edge goes from a lower node to a higher one.
#[derive(Clone, Debug)]
pub struct Graph {
    /// In topological order.
    pub nodes: Vec<Node>,
    /// Reader, then overwriter.
    pub anti_dependences: Vec<(u32, u32)>,
    /// Number of reads of each result.
    pub uses: Vec<u32>,
}

impl Graph {
    /// Lower a tape onto a layout of its pattern, for one engine.
    pub fn new(tape: &Tape, layout: &Layout, configuration: &Configuration) -> Self {
        let mut lowering = Lowering::new(tape, layout);
        lowering.operations();
        lowering.stores();
        let mut graph = Self::of(take_apart(lowering.nodes, configuration));
        graph.coalesce_accumulators(layout.words());
        graph.find_anti_dependences(layout.words());
        graph
    }

    /// Operations without dependences other than their operands.
    fn of(nodes: Vec<Node>) -> Self {
        let mut uses = vec![0; nodes.len()];
        for node in &nodes {
            node.sources().for_each(|k| uses[k as usize] += 1);
        }
        Self { nodes, anti_dependences: Vec::new(), uses }
    }

    /// One past the highest fixed address that the graph reads or writes.
    pub(crate) fn words(&self) -> usize {
        let fixed = |operand: &Option<Operand>| match operand {
            Some(Operand::Fixed(address)) => address + 1,
            _ => 0,
        };
        let of = |node: &Node| {
            let read = node.operands.iter().map(fixed).max().unwrap_or(0);
            read.max(node.location.map_or(0, |location| location + 1))
        };
        self.nodes.iter().map(of).max().unwrap_or(0) as usize
    }

    /// Readers of the words that `overwritten` names: word, reader; sorted.
    fn readers(&self, overwritten: &[Option<u32>]) -> Vec<(u32, u32)> {
        let mut readers = Vec::new();
        for (node, k) in self.nodes.iter().zip(0..) {
            for operand in node.operands.iter().flatten() {
                match operand {
                    Operand::Fixed(address) if overwritten[*address as usize].is_some() => {
                        readers.push((*address, k));
                    }
                    _ => {}
                }
            }
        }
        readers.sort_unstable();
        readers.dedup();
        readers
    }

    /// Give the partial sums of an accumulation the location of its result, if only the first operation of the
    /// accumulation reads the word's old content.
    fn coalesce_accumulators(&mut self, words: u32) {
        let mut writers = vec![None; words as usize];
        for (node, k) in self.nodes.iter().zip(0..) {
            if let Some(location) = node.location {
                writers[location as usize] = Some(k);
            }
        }
        let readers = self.readers(&writers);
        for (location, last) in writers.into_iter().enumerate().filter_map(|(w, k)| k.map(|k| (w as u32, k)))
        {
            let mut accumulation = vec![last];
            while let Some(previous) = self.sole_accumulator(accumulation[accumulation.len() - 1]) {
                accumulation.push(previous);
            }
            let head = accumulation[accumulation.len() - 1];
            let from = readers.partition_point(|&(word, _)| word < location);
            if readers[from..]
                .iter()
                .take_while(|(word, _)| *word == location)
                .all(|&(_, reader)| reader == head)
            {
                for k in accumulation {
                    self.nodes[k as usize].location = Some(location);
                }
            }
        }
    }

    /// The temporary that only `k` reads, as the accumulator of a sum.
    fn sole_accumulator(&self, k: u32) -> Option<u32> {
        let node = &self.nodes[k as usize];
        let accumulator = match node.operands[2] {
            Some(Operand::Node(previous)) if node.code != Code::Select => previous,
            _ => return None,
        };
        let previous = &self.nodes[accumulator as usize];
        (self.uses[accumulator as usize] == 1 && previous.location.is_none()).then_some(accumulator)
    }

    /// Assign locations to all temporaries, from `first` on in kernel order: neighbours there are neighbours in
    /// storage. The partial sums of an accumulation share one word. Nothing changes if the words do not fit below
    /// `limit`. Returns the first free word.
    pub fn assign_locations(&mut self, first: u32, limit: u32) -> u32 {
        let temporaries: Vec<u32> =
            (0..self.nodes.len() as u32).filter(|&k| self.location(k).is_none()).collect();
        let mut continued = vec![false; self.nodes.len()];
        for previous in temporaries.iter().filter_map(|&k| self.sole_accumulator(k)) {
            continued[previous as usize] = true;
        }
        let ends: Vec<u32> = temporaries.into_iter().filter(|&k| !continued[k as usize]).collect();
        if ends.len() > limit.saturating_sub(first) as usize {
            return first;
        }
        for (&end, location) in ends.iter().zip(first..) {
            let mut next = Some(end);
            while let Some(k) = next {
                next = self.sole_accumulator(k);
                self.nodes[k as usize].location = Some(location);
            }
        }
        first + ends.len() as u32
    }

    fn location(&self, k: u32) -> Option<u32> {
        self.nodes[k as usize].location
    }

    fn find_anti_dependences(&mut self, words: u32) {
        let mut first: Vec<Option<u32>> = vec![None; words as usize];
        for (node, k) in self.nodes.iter().zip(0..) {
            if let Some(location) = node.location {
                first[location as usize].get_or_insert(k);
            }
        }
        let pairs = self.readers(&first).into_iter().filter_map(|(word, reader)| {
            first[word as usize].filter(|&writer| writer != reader).map(|writer| (reader, writer))
        });
        self.anti_dependences = pairs.collect();
        self.anti_dependences.sort_unstable();
    }
}

/// The translation of one tape.
struct Lowering<'a> {
    tape: &'a Tape,
    layout: &'a Layout,
    nodes: Vec<Node>,
    /// Addresses of the tape's literals.
    constants: Vec<Option<u32>>,
    /// Node of each live result.
    node_of: Vec<Option<u32>>,
    /// For each word that is stored elsewhere although it is overwritten: the temporary that saves its old content.
    saved: HashMap<u32, u32>,
}

impl<'a> Lowering<'a> {
    fn new(tape: &'a Tape, layout: &'a Layout) -> Self {
        Self {
            tape,
            layout,
            nodes: Vec::new(),
            constants: tape.constants.iter().map(|&value| layout.constant(value)).collect(),
            node_of: vec![None; tape.operations.len()],
            saved: HashMap::new(),
        }
    }

    /// Results that a store needs, directly or not.
    fn live(&self) -> Vec<bool> {
        let mut live = vec![false; self.tape.operations.len()];
        let mark = |value: Value, live: &mut Vec<bool>| {
            if let Value::Result(k) = value {
                live[k as usize] = true;
            }
        };
        for store in &self.tape.stores {
            mark(store.value, &mut live);
        }
        for k in (0..live.len()).rev() {
            if live[k] {
                let operation = &self.tape.operations[k];
                for value in [Some(operation.a), operation.b, operation.c].into_iter().flatten() {
                    mark(value, &mut live);
                }
            }
        }
        live
    }

    fn address(&self, value: Value) -> Option<u32> {
        match value {
            Value::Word { buffer, index } => self.layout.location(Buffer::ALL[usize::from(buffer)], index),
            Value::Constant(k) => self.constants[k as usize],
            Value::Result(_) => None,
        }
    }

    fn operand(&self, value: Value) -> Operand {
        match value {
            Value::Result(k) => Operand::Node(self.node_of[k as usize].expect("operands come first")),
            fixed => {
                let address = self.address(fixed).expect("the layout has every word of its recording");
                self.saved.get(&address).map_or(Operand::Fixed(address), |&k| Operand::Node(k))
            }
        }
    }

    fn push(&mut self, code: Code, operands: [Option<Operand>; 3], location: Option<u32>) -> u32 {
        self.nodes.push(Node { code, operands, location });
        self.nodes.len() as u32 - 1
    }

    /// Save every word that is stored elsewhere although the segment overwrites it.
    fn save_overwritten_words(&mut self) {
        let stores = || self.tape.stores.iter();
        let overwritten: std::collections::HashSet<u32> =
            stores().filter_map(|store| self.layout.location(store.buffer, store.index)).collect();
        let moved: Vec<u32> = stores()
            .filter(|store| matches!(store.value, Value::Word { .. }))
            .filter_map(|store| self.address(store.value))
            .filter(|address| overwritten.contains(address))
            .collect();
        for address in moved {
            if !self.saved.contains_key(&address) {
                let k = self.push(Code::Move, [Some(Operand::Fixed(address)), None, None], None);
                self.saved.insert(address, k);
            }
        }
    }

    fn operations(&mut self) {
        self.save_overwritten_words();
        let live = self.live();
        for (k, operation) in self.tape.operations.iter().enumerate() {
            if live[k] {
                let operands =
                    [Some(operation.a), operation.b, operation.c].map(|value| value.map(|v| self.operand(v)));
                self.node_of[k] = Some(self.push(operation.opcode.into(), operands, None));
            }
        }
    }

    /// A stored result gets the store's location if that is free; every other store is a `move`.
    fn stores(&mut self) {
        let mut last_reader: Vec<Option<u32>> = vec![None; self.layout.words() as usize];
        for (k, node) in self.nodes.iter().enumerate() {
            for operand in node.operands.iter().flatten() {
                if let Operand::Fixed(address) = operand {
                    last_reader[*address as usize] = Some(k as u32);
                }
            }
        }
        for store in &self.tape.stores {
            let Some(location) = self.layout.location(store.buffer, store.index) else { continue };
            let node = if let Value::Result(k) = store.value { self.node_of[k as usize] } else { None };
            if let Some(k) = node {
                let free = last_reader[location as usize].is_none_or(|reader| reader <= k);
                if free && self.nodes[k as usize].location.is_none() {
                    self.nodes[k as usize].location = Some(location);
                    continue;
                }
            }
            let source = self.operand(store.value);
            self.push(Code::Move, [Some(source), None, None], Some(location));
        }
    }
}

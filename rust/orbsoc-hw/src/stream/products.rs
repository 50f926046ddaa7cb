//! A product off the chain of its sum: c ± a·b as a product and a sum, where the sum waits for c.
//!
//! The operation reads a, b and c in one cycle, so that a sum of products takes a product's time a term, too. Apart, the
//! product is done when c comes, and a term takes a sum's time. Both round twice: the bits are the same. It costs an
//! operation, so only those are taken apart without which the segment would take longer than its lanes need anyway.

use super::node::{Node, Operand};
use crate::machine::configuration::Configuration;
use crate::machine::operation::Code;
use crate::machine::timing::Timing;

/// Operations in topological order, with products taken apart; the numbers of nodes in operands follow.
pub(super) fn take_apart(nodes: Vec<Node>, configuration: &Configuration) -> Vec<Node> {
    let timing = configuration.timing();
    let (useful, shortest) = all_useful(&nodes, timing);
    let lanes = configuration.lanes as u32;
    let allowed = shortest.max((nodes.len() as u32).div_ceil(lanes));
    let apart = needed(&nodes, &tails(&nodes, &useful, timing), allowed, timing);
    if apart.contains(&true) {
        rebuilt(&nodes, &apart)
    } else {
        nodes
    }
}

/// The sum that follows the product.
fn sum_of(code: Code) -> Option<Code> {
    match code {
        Code::AddMul => Some(Code::Add),
        Code::SubMul => Some(Code::Sub),
        _ => None,
    }
}

/// When the factors, or all operands of an operation without a sum, are there, and when c is.
fn arrivals(node: &Node, done: &[u32]) -> (u32, u32) {
    let at = |operand: Option<Operand>| match operand {
        Some(Operand::Node(source)) => done[source as usize],
        _ => 0,
    };
    let [a, b, c] = node.operands;
    (at(a).max(at(b)), at(c))
}

/// When a result can be read: as one operation, and taken apart.
fn finish(node: &Node, done: &[u32], timing: &Timing) -> (u32, Option<u32>) {
    let (factors, c) = arrivals(node, done);
    let together = factors.max(c) + timing.distance(node.code);
    let apart =
        sum_of(node.code).map(|sum| c.max(factors + timing.distance(Code::Mul)) + timing.distance(sum));
    (together, apart.filter(|&apart| apart < together))
}

/// Where it makes a result earlier, and the longest chain then.
fn all_useful(nodes: &[Node], timing: &Timing) -> (Vec<bool>, u32) {
    let (mut done, mut useful) = (vec![0; nodes.len()], vec![false; nodes.len()]);
    for (k, node) in nodes.iter().enumerate() {
        let (together, apart) = finish(node, &done, timing);
        (done[k], useful[k]) = (apart.unwrap_or(together), apart.is_some());
    }
    (useful, done.into_iter().max().unwrap_or(0))
}

/// From each result to the end.
fn tails(nodes: &[Node], apart: &[bool], timing: &Timing) -> Vec<u32> {
    let mut tails = vec![0; nodes.len()];
    for (k, node) in nodes.iter().enumerate().rev() {
        let (from_factors, from_c) = match sum_of(node.code).filter(|_| apart[k]) {
            Some(sum) => (timing.distance(Code::Mul) + timing.distance(sum), timing.distance(sum)),
            None => (timing.distance(node.code), timing.distance(node.code)),
        };
        let after = tails[k];
        for (operand, through) in node.operands.iter().zip([from_factors, from_factors, from_c]) {
            if let Some(Operand::Node(source)) = operand {
                let tail = &mut tails[*source as usize];
                *tail = (*tail).max(through + after);
            }
        }
    }
    tails
}

/// Where no chain may become longer than `allowed`: of those before each node it is known which are taken apart, and of
/// those behind it that they may be.
fn needed(nodes: &[Node], tails: &[u32], allowed: u32, timing: &Timing) -> Vec<bool> {
    let (mut done, mut apart) = (vec![0; nodes.len()], vec![false; nodes.len()]);
    for (k, node) in nodes.iter().enumerate() {
        let (together, earlier) = finish(node, &done, timing);
        let chosen = earlier.filter(|_| together + tails[k] > allowed);
        (done[k], apart[k]) = (chosen.unwrap_or(together), chosen.is_some());
    }
    apart
}

fn rebuilt(whole: &[Node], apart: &[bool]) -> Vec<Node> {
    let mut nodes: Vec<Node> = Vec::with_capacity(whole.len() + apart.iter().filter(|&&apart| apart).count());
    let mut number = vec![0; whole.len()];
    for (k, node) in whole.iter().enumerate() {
        let operands = node.operands.map(|operand| match operand {
            Some(Operand::Node(source)) => Some(Operand::Node(number[source as usize])),
            other => other,
        });
        if let Some(sum) = sum_of(node.code).filter(|_| apart[k]) {
            let [a, b, c] = operands;
            nodes.push(Node { code: Code::Mul, operands: [a, b, None], location: None });
            let product = Some(Operand::Node(nodes.len() as u32 - 1));
            nodes.push(Node { code: sum, operands: [product, None, c], location: node.location });
        } else {
            nodes.push(Node { operands, ..*node });
        }
        number[k] = nodes.len() as u32 - 1;
    }
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;

    const TERMS: u32 = 10;

    fn product(c: Operand) -> Node {
        let operands = [Some(Operand::Fixed(1)), Some(Operand::Fixed(2)), Some(c)];
        Node { code: Code::SubMul, operands, location: None }
    }

    /// A sum of products, and products alone.
    fn sum_and_products(alone: u32) -> Vec<Node> {
        let terms =
            (0..TERMS).map(|k| product(if k == 0 { Operand::Fixed(0) } else { Operand::Node(k - 1) }));
        terms.chain((0..alone).map(|_| product(Operand::Fixed(0)))).collect()
    }

    fn codes(nodes: &[Node]) -> Vec<Code> {
        nodes.iter().map(|node| node.code).collect()
    }

    #[test]
    fn a_term_of_a_chain_takes_the_time_of_a_sum() {
        let configuration = Configuration::default();
        let nodes = take_apart(sum_and_products(0), &configuration);
        // The first term has nothing to wait for.
        let later = [Code::Mul, Code::Sub].repeat(TERMS as usize - 1);
        assert_eq!(codes(&nodes), [vec![Code::SubMul], later].concat());
        let operand = |node| Some(Operand::Node(node));
        for term in 1..TERMS {
            let sum = &nodes[2 * term as usize];
            assert_eq!(sum.operands, [operand(2 * term - 1), None, operand(2 * term - 2)]);
        }
        let timing = configuration.timing();
        let (_, chain) = all_useful(&nodes, timing);
        assert_eq!(chain, timing.distance(Code::SubMul) + (TERMS - 1) * timing.distance(Code::Sub));
    }

    #[test]
    fn lanes_that_are_busy_longer_keep_products_and_sums_together() {
        let whole = sum_and_products(1000);
        let one_lane = Configuration { lanes: 1, ..Configuration::default() };
        assert_eq!(codes(&take_apart(whole.clone(), &one_lane)), codes(&whole));
    }
}

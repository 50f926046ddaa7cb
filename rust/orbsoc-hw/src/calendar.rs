//! Who is due in which cycle.

const NOBODY: u32 = u32::MAX;

/// Nodes by cycle: a list for each cycle, threaded through the nodes, the last one added first.
#[derive(Clone, Debug)]
pub(crate) struct Calendar {
    last: Vec<u32>,
    before: Vec<u32>,
}

impl Calendar {
    pub fn new(nodes: usize) -> Self {
        Self { last: Vec::new(), before: vec![NOBODY; nodes] }
    }

    pub fn add(&mut self, cycle: u32, node: u32) {
        let cycle = cycle as usize;
        if cycle >= self.last.len() {
            self.last.resize(2 * cycle + 64, NOBODY);
        }
        self.before[node as usize] = core::mem::replace(&mut self.last[cycle], node);
    }

    pub fn is_due(&self, cycle: u32) -> bool {
        self.last.get(cycle as usize).is_some_and(|&node| node != NOBODY)
    }

    /// Those of a cycle in the order in which they were added; they leave the calendar.
    pub fn take(&mut self, cycle: u32) -> Vec<u32> {
        let last = self.last.get_mut(cycle as usize).map_or(NOBODY, |last| core::mem::replace(last, NOBODY));
        let some = |node: u32| (node != NOBODY).then_some(node);
        let mut due: Vec<u32> =
            core::iter::successors(some(last), |&node| some(self.before[node as usize])).collect();
        due.reverse();
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_is_due_once_in_the_order_of_adding() {
        let mut calendar = Calendar::new(4);
        for (cycle, node) in [(5, 2), (0, 1), (5, 0), (5, 3)] {
            calendar.add(cycle, node);
        }
        assert!(calendar.is_due(5) && !calendar.is_due(4) && !calendar.is_due(1000));
        assert_eq!(calendar.take(5), [2, 0, 3]);
        assert_eq!(calendar.take(5), []);
        assert_eq!(calendar.take(0), [1]);
    }
}

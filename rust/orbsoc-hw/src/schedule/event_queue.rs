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

    /// Put those of a cycle, in the order in which they were added, into a list; they leave the calendar.
    pub fn take(&mut self, cycle: u32, due: &mut Vec<u32>) {
        due.clear();
        let Some(last) = self.last.get_mut(cycle as usize) else { return };
        let mut node = core::mem::replace(last, NOBODY);
        while node != NOBODY {
            due.push(node);
            node = self.before[node as usize];
        }
        due.reverse();
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
        let mut due = vec![7];
        for (cycle, expected) in [(5, vec![2, 0, 3]), (5, vec![]), (0, vec![1]), (1000, vec![])] {
            calendar.take(cycle, &mut due);
            assert_eq!(due, expected);
        }
    }
}

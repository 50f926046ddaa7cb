//! Event queue of the cycle-driven scheduler.

const NONE: u32 = u32::MAX;

/// Nodes by cycle: one linked list a cycle, threaded through the nodes, newest first.
#[derive(Clone, Debug)]
pub(crate) struct EventQueue {
    newest: Vec<u32>,
    previous: Vec<u32>,
}

impl EventQueue {
    pub fn new(nodes: usize) -> Self {
        Self { newest: Vec::new(), previous: vec![NONE; nodes] }
    }

    pub fn push(&mut self, cycle: u32, node: u32) {
        let cycle = cycle as usize;
        if cycle >= self.newest.len() {
            self.newest.resize(2 * cycle + 64, NONE);
        }
        self.previous[node as usize] = core::mem::replace(&mut self.newest[cycle], node);
    }

    pub fn has_events(&self, cycle: u32) -> bool {
        self.newest.get(cycle as usize).is_some_and(|&node| node != NONE)
    }

    /// Move the nodes of a cycle, oldest first, from the queue into `events`.
    pub fn pop(&mut self, cycle: u32, events: &mut Vec<u32>) {
        events.clear();
        let Some(newest) = self.newest.get_mut(cycle as usize) else { return };
        let mut node = core::mem::replace(newest, NONE);
        while node != NONE {
            events.push(node);
            node = self.previous[node as usize];
        }
        events.reverse();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_event_occurs_once_in_the_order_of_pushing() {
        let mut queue = EventQueue::new(4);
        for (cycle, node) in [(5, 2), (0, 1), (5, 0), (5, 3)] {
            queue.push(cycle, node);
        }
        assert!(queue.has_events(5) && !queue.has_events(4) && !queue.has_events(1000));
        let mut events = vec![7];
        for (cycle, expected) in [(5, vec![2, 0, 3]), (5, vec![]), (0, vec![1]), (1000, vec![])] {
            queue.pop(cycle, &mut events);
            assert_eq!(events, expected);
        }
    }
}

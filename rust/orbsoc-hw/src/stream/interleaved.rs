//! Independent problems of one pattern in one stream: the operations of one fill the waits of the others.
//!
//! Entry i of copy c lies at i·copies + c of its buffer, so that with as many clusters as copies each has one of its own. An
//! attempt of all runs until the last has ended: what a copy has left of its outcome is kept from then on. The operation
//! control reads one flag for all, in the entry after the last of a flag's buffer: stop when all do, repeat when one does.

use orbsoc::real::{Opcode, Operation, Value};
use orbsoc::{word_of, Buffer, Flag, Recording, Store, Tape};

/// What the end of a solve reads, and later stages of an attempt would overwrite.
pub(crate) const OUTCOME: [Buffer; 4] =
    [Buffer::Control, Buffer::Best, Buffer::PrimalCertificate, Buffer::DualCertificate];

/// Buffers that begin with a flag; the flag of all copies follows the words of the last.
const FLAGS: [Buffer; 3] = [Buffer::Control, Buffer::Verdict, Buffer::RefinementActive];

/// The tapes of some problems of one pattern as one recording, whose buffers hold all of them.
#[must_use]
pub fn interleaved(recording: &Recording, copies: u32) -> Recording {
    if copies == 1 {
        return recording.clone();
    }
    let of_all = |(&buffer, &words): (&Buffer, &usize)| length(buffer, words, copies as usize);
    let words = Buffer::ALL.iter().zip(&recording.words).map(of_all);
    let tape = |tape: &Tape| Interleaving::new(tape, copies).tape(recording);
    Recording {
        problem: recording.problem.clone(),
        words: words.collect(),
        tapes: recording.tapes.iter().map(tape).collect(),
    }
}

/// Words of a buffer of all copies, each with `words` of them.
pub(crate) fn length(buffer: Buffer, words: usize, copies: usize) -> usize {
    words * copies + usize::from(copies > 1 && FLAGS.contains(&buffer))
}

/// The words of a buffer of all copies, equally many of each, as such a recording holds them.
pub(crate) fn gathered<T: Copy>(buffer: Buffer, copies: &[&[T]], flag_of_all: T) -> Vec<T> {
    let entries = copies.first().map_or(0, |words| words.len());
    let mut all: Vec<T> =
        (0..entries).flat_map(|entry| copies.iter().map(move |words| words[entry])).collect();
    all.resize(length(buffer, entries, copies.len()), flag_of_all);
    all
}

/// The tape of all copies in the making.
struct Interleaving<'a> {
    tape: &'a Tape,
    copies: u32,
    all: Tape,
}

impl<'a> Interleaving<'a> {
    fn new(tape: &'a Tape, copies: u32) -> Self {
        let all = Tape { operations: Vec::new(), stores: Vec::new(), ..tape.clone() };
        Self { tape, copies, all }
    }

    fn tape(mut self, recording: &Recording) -> Tape {
        for operation in &self.tape.operations {
            for copy in 0..self.copies {
                let of = |value| self.of(value, copy);
                let Operation { opcode, a, b, c } = *operation;
                let copied = Operation { opcode, a: of(a), b: b.map(of), c: c.map(of) };
                self.all.operations.push(copied);
            }
        }
        for store in &self.tape.stores {
            for copy in 0..self.copies {
                let Store { buffer, index, value } = *store;
                let index = index * self.copies + copy;
                let value = self.of(value, copy);
                self.all.stores.push(Store { buffer, index, value });
            }
        }
        self.keep_outcomes();
        self.join_flags(recording);
        self.all.stores.sort_unstable_by_key(|store| (store.buffer as usize, store.index));
        self.all
    }

    fn of(&self, value: Value, copy: u32) -> Value {
        match value {
            Value::Word { buffer, index } => Value::Word { buffer, index: index * self.copies + copy },
            Value::Result(k) => Value::Result(k * self.copies + copy),
            constant @ Value::Constant(_) => constant,
        }
    }

    fn push(&mut self, opcode: Opcode, a: Value, b: Value, c: Option<Value>) -> Value {
        self.all.operations.push(Operation { opcode, a, b: Some(b), c });
        Value::Result(self.all.operations.len() as u32 - 1)
    }

    fn zero(&mut self) -> Value {
        self.all.constants.push(0.0);
        Value::Constant(self.all.constants.len() as u32 - 1)
    }

    /// A mask: whether the copy had ended before the stage.
    fn ended(&mut self, copy: u32) -> Value {
        let zero = self.zero();
        self.push(Opcode::Compare, zero, word_of(Buffer::Control, copy), None)
    }

    /// A copy that has ended keeps its outcome.
    fn keep_outcomes(&mut self) {
        if !self.all.stores.iter().any(|store| OUTCOME.contains(&store.buffer)) {
            return;
        }
        let ended: Vec<Value> = (0..self.copies).map(|copy| self.ended(copy)).collect();
        for k in 0..self.all.stores.len() {
            let Store { buffer, index, value } = self.all.stores[k];
            if OUTCOME.contains(&buffer) {
                let mask = ended[(index % self.copies) as usize];
                self.all.stores[k].value =
                    self.push(Opcode::Select, word_of(buffer, index), value, Some(mask));
            }
        }
    }

    /// One flag for all copies, where the stage decides.
    fn join_flags(&mut self, recording: &Recording) {
        let (buffer, opcode) = match self.tape.stage.flag() {
            None => return,
            Some(Flag::Stop(buffer)) => (buffer, Opcode::Min),
            Some(Flag::Repeat(buffer)) => (buffer, Opcode::Max),
        };
        let mut joined = None;
        for copy in 0..self.copies {
            let stored = self.all.stores.iter().find(|store| store.buffer == buffer && store.index == copy);
            let mut flag = stored.map_or(word_of(buffer, copy), |store| store.value);
            if opcode == Opcode::Max {
                let (ended, zero) = (self.ended(copy), self.zero());
                flag = self.push(Opcode::Select, zero, flag, Some(ended));
            }
            joined = Some(joined.map_or(flag, |others| self.push(opcode, flag, others, None)));
        }
        let index = recording.words_of(buffer) as u32 * self.copies;
        self.all.stores.extend(joined.map(|value| Store { buffer, index, value }));
    }
}

//! The operation stream of a stage, recorded once per sparsity pattern, and its data map.
//!
//! A tape says the same for every value of the data. Executed on any scalar it makes that scalar's kernel
//! over again, bit for bit: what is scheduled onto hardware is the method itself.

use crate::error::Error;
use crate::kkt::structure::Structure;
use crate::method::stage::Stage;
use crate::method::{datapath::Datapath, workspace::Buffer};
use crate::problem::{Problem, Settings};
use crate::real::{record, Opcode, Operation, Real, Taped, Value};
use crate::symbolic::{indices::index, supernodes::Panels};
use std::collections::HashMap;
use std::sync::Arc;

/// A buffer's word and the value that a stage leaves there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub struct Store {
    pub buffer: Buffer,
    pub index: u32,
    pub value: Value,
}

/// One stage's operations.
#[derive(Clone, Debug)]
pub struct Tape {
    /// The stage.
    pub stage: Stage,
    /// Literals, as double-precision numbers.
    pub constants: Vec<f64>,
    /// In the order of the kernel; an operand is a word, a constant or an earlier result.
    pub operations: Vec<Operation>,
    /// Words that hold another value after the stage than before it.
    pub stores: Vec<Store>,
}

/// The tapes of a pattern.
#[derive(Clone, Debug)]
pub struct Recording {
    /// The problem whose pattern it is.
    pub problem: Problem,
    /// One for each stage, in the order of [`Stage::ALL`].
    pub tapes: Vec<Tape>,
    /// Words of each buffer, in the order of [`Buffer::ALL`].
    pub words: Vec<usize>,
}

impl Recording {
    /// The tape of a stage.
    pub fn tape(&self, stage: Stage) -> Option<&Tape> {
        self.tapes.iter().find(|tape| tape.stage == stage)
    }

    /// The tapes of some stages only.
    #[must_use]
    pub fn only(mut self, wanted: impl Fn(Stage) -> bool) -> Self {
        self.tapes.retain(|tape| wanted(tape.stage));
        self
    }

    /// Words of a buffer.
    pub fn words_of(&self, buffer: Buffer) -> usize {
        self.words[buffer as usize]
    }
}

/// Record every stage on a problem's pattern, with the exact factor layout, that is,
/// without a single operation on a stored zero; [`crate::Engine::exact`] has the same layout.
///
/// # Errors
/// As [`crate::Engine::new`].
///
/// ```
/// # use orbsoc::*;
/// # let problem = Problem::new(None, vec![1.0], None, vec![], Some(Csc::from_dense(&[&[-1.0]], 1)),
/// #     vec![-2.0], Cones { l: 1, q: vec![] })?;
/// let recording = record_tapes(&problem, &Settings::default())?;
/// let tape = recording.tape(Stage::ScalingBlocks).expect("a stage of a PL module");
/// let left = tape.execute(|buffer, _| if buffer == Buffer::W { 3.0 } else { 0.0 });
/// assert_eq!(left, [-9.0]); // −w² of the one row
/// # Ok::<(), Error>(())
/// ```
pub fn record_tapes(problem: &Problem, settings: &Settings) -> Result<Recording, Error> {
    let structure = Arc::new(Structure::new(problem, settings.ordering, Panels::Exact)?);
    let mut path = Datapath::<Taped>::new(structure, settings)?;
    Ok(Recording {
        problem: problem.clone(),
        tapes: Stage::ALL.iter().map(|&stage| record_stage(&mut path, stage)).collect(),
        words: Buffer::ALL.iter().map(|&buffer| path.work.get(buffer).len()).collect(),
    })
}

/// What a buffer's word holds before a stage, as a value.
pub fn word_of(buffer: Buffer, index: u32) -> Value {
    Value::Word { buffer: buffer as u16, index }
}

fn record_stage(path: &mut Datapath<Taped>, stage: Stage) -> Tape {
    for &buffer in Buffer::ALL {
        for (k, word) in path.work.get_mut(buffer).iter_mut().enumerate() {
            *word = Taped(word_of(buffer, index(k)));
        }
    }
    let recorded = record(|| {
        // A kernel that read scratch entries before writing them would find this.
        path.work.scratch.fill(Taped::constant(f64::NAN));
        path.execute(stage);
    });
    let mut stores = Vec::new();
    for &buffer in Buffer::ALL {
        for (k, word) in path.work.get(buffer).iter().enumerate() {
            let index = index(k);
            if word.0 != word_of(buffer, index) {
                stores.push(Store { buffer, index, value: word.0 });
            }
        }
    }
    Tape { stage, constants: recorded.constants, operations: recorded.operations, stores }
}

/// A word of the execution: a number, or a mask.
#[derive(Clone, Copy)]
enum Word<T: Real> {
    Number(T),
    Mask(T::Mask),
}

impl<T: Real> Word<T> {
    fn number(self) -> T {
        match self {
            Self::Number(value) => value,
            Self::Mask(_) => unreachable!("`Real` keeps masks out of arithmetic"),
        }
    }

    fn mask(self) -> T::Mask {
        match self {
            Self::Mask(mask) => mask,
            Self::Number(_) => unreachable!("`Real` keeps numbers out of masks"),
        }
    }
}

impl Tape {
    /// This stage and then another as one stream: what the first leaves in a word, the second reads as a result, so
    /// that a schedule may begin the second while the first still runs. It keeps the first one's name.
    pub fn then(&self, next: &Self) -> Self {
        let left: HashMap<(Buffer, u32), Value> =
            self.stores.iter().map(|store| ((store.buffer, store.index), store.value)).collect();
        let (constants, results) = (index(self.constants.len()), index(self.operations.len()));
        let moved = |value: Value| match value {
            Value::Word { buffer, index } => {
                *left.get(&(Buffer::ALL[usize::from(buffer)], index)).unwrap_or(&value)
            }
            Value::Constant(k) => Value::Constant(k + constants),
            Value::Result(k) => Value::Result(k + results),
        };
        let operations = next.operations.iter().map(|o| Operation {
            opcode: o.opcode,
            a: moved(o.a),
            b: o.b.map(moved),
            c: o.c.map(moved),
        });
        let mut both = left.clone();
        both.extend(next.stores.iter().map(|store| ((store.buffer, store.index), moved(store.value))));
        let mut stores: Vec<Store> =
            both.into_iter().map(|((buffer, index), value)| Store { buffer, index, value }).collect();
        stores.sort_unstable_by_key(|store| (store.buffer as usize, store.index));
        Self {
            stage: self.stage,
            constants: self.constants.iter().chain(&next.constants).copied().collect(),
            operations: self.operations.iter().copied().chain(operations).collect(),
            stores,
        }
    }

    /// As much of this stage as stores entries of some buffers.
    pub fn leaving(mut self, buffers: &[Buffer]) -> Self {
        self.stores.retain(|store| buffers.contains(&store.buffer));
        self
    }

    /// Run the operations on words from `read`; returns the values of [`Tape::stores`].
    pub fn execute<T: Real>(&self, read: impl Fn(Buffer, usize) -> T) -> Vec<T> {
        let constants: Vec<T> = self.constants.iter().map(|&value| T::constant(value)).collect();
        let mut results: Vec<Word<T>> = Vec::with_capacity(self.operations.len());
        let get = |results: &[Word<T>], value: Value| match value {
            Value::Word { buffer, index } => {
                Word::Number(read(Buffer::ALL[usize::from(buffer)], index as usize))
            }
            Value::Constant(k) => Word::Number(constants[k as usize]),
            Value::Result(k) => results[k as usize],
        };
        for operation in &self.operations {
            let a = get(&results, operation.a);
            let b = operation.b.map_or(a, |b| get(&results, b));
            let c = operation.c.map_or(a, |c| get(&results, c));
            results.push(operate(operation.opcode, a, b, c));
        }
        self.stores.iter().map(|store| get(&results, store.value).number()).collect()
    }
}

fn operate<T: Real>(opcode: Opcode, a: Word<T>, b: Word<T>, c: Word<T>) -> Word<T> {
    Word::Number(match opcode {
        Opcode::Neg => -a.number(),
        Opcode::Abs => a.number().abs(),
        Opcode::Mul => a.number() * b.number(),
        Opcode::Add => c.number() + a.number(),
        Opcode::Sub => c.number() - a.number(),
        Opcode::AddMul => c.number().add_mul(a.number(), b.number()),
        Opcode::SubMul => c.number().sub_mul(a.number(), b.number()),
        Opcode::Div => a.number() / b.number(),
        Opcode::Sqrt => a.number().sqrt(),
        Opcode::Min => a.number().min(b.number()),
        Opcode::Max => a.number().max(b.number()),
        Opcode::Select => T::select(c.mask(), a.number(), b.number()),
        Opcode::Compare => return Word::Mask(a.number().lt(b.number())),
        Opcode::And => return Word::Mask(T::and(a.mask(), b.mask())),
    })
}

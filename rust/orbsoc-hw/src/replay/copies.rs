//! What the stages of a segment do to the buffers of all problems in its stream: the reference is an engine for each.

use crate::stream::interleaved::{gathered, OUTCOME};
use orbsoc::{Buffer, Compiled, Decide, Engine, Flag, Stage};

/// Of the flags of all problems before a segment: a value that no stage leaves, so that a flag not written differs.
const UNWRITTEN: f64 = 0.5;

/// An engine for each problem of a stream, and the flags of all.
pub(crate) struct Copies<T> {
    engines: Vec<Engine<T>>,
    flags: Vec<f64>,
}

impl<T: Compiled> Copies<T> {
    pub fn new(engines: &[&Engine<T>]) -> Self {
        let engines = engines.iter().map(|&engine| engine.clone()).collect();
        Self { engines, flags: vec![UNWRITTEN; Buffer::ALL.len()] }
    }

    /// The words of every buffer, as a program's storage holds them.
    pub fn words(&self) -> Vec<Vec<f64>> {
        let of_all = |&buffer: &Buffer| {
            let words = |engine: &Engine<T>| engine.buffer(buffer).iter().map(Decide::value).collect();
            let copies: Vec<Vec<f64>> = self.engines.iter().map(words).collect();
            let copies: Vec<&[f64]> = copies.iter().map(Vec::as_slice).collect();
            gathered(buffer, &copies, self.flags[buffer as usize])
        };
        Buffer::ALL.iter().map(of_all).collect()
    }

    /// Run a stage of each. Beside others, one that has ended keeps its outcome, and asks for no repetition.
    pub fn run(&mut self, stage: Stage) {
        let others = self.engines.len() > 1;
        let mut flags = Vec::new();
        for engine in &mut self.engines {
            let ended = others && engine.buffer(Buffer::Control)[0].value() > 0.0;
            let kept = OUTCOME.map(|buffer| engine.buffer(buffer).to_vec());
            engine.run(stage);
            if ended {
                for (buffer, words) in OUTCOME.into_iter().zip(&kept) {
                    engine.buffer_mut(buffer).copy_from_slice(words);
                }
            }
            flags.push(match stage.flag() {
                Some(Flag::Repeat(buffer)) if !ended => engine.buffer(buffer)[0].value(),
                Some(Flag::Stop(buffer)) => engine.buffer(buffer)[0].value(),
                _ => 0.0,
            });
        }
        match stage.flag() {
            None => (),
            Some(Flag::Stop(buffer)) => {
                self.flags[buffer as usize] = flags.into_iter().fold(f64::INFINITY, f64::min);
            }
            Some(Flag::Repeat(buffer)) => {
                self.flags[buffer as usize] = flags.into_iter().fold(0.0, f64::max);
            }
        }
    }
}

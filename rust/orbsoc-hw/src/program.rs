//! Every segment of a pattern on one engine.

use crate::bounds::Bounds;
use crate::compressed::Compressed;
use crate::configuration::Configuration;
use crate::error::Error;
use crate::graph::Graph;
use crate::layout::Layout;
use crate::microcode::{flat, Microcode};
use crate::schedule::{schedule, Aim, Schedule};
use orbsoc::{Recording, Stage};

/// A stage of a PL module, scheduled.
#[derive(Clone, Debug)]
pub struct Segment {
    /// The stage.
    pub stage: Stage,
    /// Its first word of microcode.
    pub start: usize,
    /// Lower bounds of its cycles.
    pub bounds: Bounds,
    /// Its cycles.
    pub schedule: Schedule,
}

/// A pattern's segments, one after the other in microcode memory, on one layout of the storage.
#[derive(Clone, Debug)]
pub struct Program {
    /// The engine.
    pub configuration: Configuration,
    /// Where everything lives.
    pub layout: Layout,
    /// In the order of the dataflow table.
    pub segments: Vec<Segment>,
}

impl Program {
    /// Schedule all tapes of a recording for the fewest cycles.
    ///
    /// # Errors
    /// A configuration that cannot exist, storage or microcode memory that is too small.
    pub fn new(recording: &Recording, configuration: &Configuration) -> Result<Self, Error> {
        Self::with_aim(recording, configuration, Aim::Fast)
    }

    /// Schedule all tapes of a recording.
    ///
    /// # Errors
    /// As [`Program::new`].
    pub fn with_aim(recording: &Recording, configuration: &Configuration, aim: Aim) -> Result<Self, Error> {
        configuration.validate()?;
        let layout = Layout::new(recording, configuration)?;
        let mut start = 0;
        let mut segments = Vec::with_capacity(recording.tapes.len());
        for tape in &recording.tapes {
            let graph = Graph::new(tape, &layout);
            let schedule = schedule(tape.stage.name(), &graph, &layout, configuration, aim)?;
            let bounds = Bounds::new(&graph, configuration);
            let words = schedule.words as usize;
            segments.push(Segment { stage: tape.stage, start, bounds, schedule });
            start += words;
        }
        if start > configuration.microcode_words {
            return Err(Error::Microcode { needed: start, available: configuration.microcode_words });
        }
        Ok(Self { configuration: *configuration, layout, segments })
    }

    /// The segment of a stage.
    ///
    /// # Errors
    /// [`Error::NoSegment`] for a stage of the processing system.
    pub fn segment(&self, stage: Stage) -> Result<&Segment, Error> {
        let found = self.segments.iter().find(|segment| segment.stage == stage);
        found.ok_or_else(|| Error::NoSegment { stage: stage.name().to_owned() })
    }

    /// Compressed microcode of all segments, in their order.
    ///
    /// # Errors
    /// As [`Compressed::new`].
    pub fn compressed(&self) -> Result<Compressed, Error> {
        let schedules: Vec<&Schedule> = self.segments.iter().map(|segment| &segment.schedule).collect();
        Compressed::new(&schedules, &self.configuration)
    }

    /// Flat microcode of all segments.
    pub fn flat(&self) -> Microcode {
        let mut all = Microcode::new(self.configuration.flat_bits(), 0);
        self.segments.iter().for_each(|segment| all.append(&flat(&segment.schedule, &self.configuration)));
        all
    }
}

//! Program: all segments of a pattern, scheduled for one engine.

use crate::error::Error;
use crate::machine::configuration::Configuration;
use crate::microcode::compact::compact;
use crate::microcode::compressed::Compressed;
use crate::microcode::flat::{flat, Microcode};
use crate::schedule::scheduler::{Aim, Schedule, Scheduler};
use crate::stream::graph::Graph;
use crate::stream::layout::Layout;
use orbsoc::{Buffer, Problem, Recording, Stage, Tape};

/// A scheduled stage of a PL module, or several as one stream.
#[derive(Clone, Debug)]
pub struct Segment {
    /// The stage, or the first of them.
    pub stage: Stage,
    /// The stages that follow it in the stream.
    pub then: Vec<Stage>,
    /// The buffers that it writes as its stages do; none: all of them.
    pub leaves: Option<Vec<Buffer>>,
    /// Its first word of microcode.
    pub start: usize,
    /// Its cycles.
    pub schedule: Schedule,
}

impl Segment {
    /// Its stages, in order.
    pub fn stages(&self) -> Vec<Stage> {
        core::iter::once(self.stage).chain(self.then.iter().copied()).collect()
    }

    /// Names of its stages.
    pub fn name(&self) -> String {
        let names: Vec<&str> = self.stages().into_iter().map(Stage::name).collect();
        names.join("_")
    }
}

/// A pattern's segments, one after the other in microcode memory, on one layout of the storage.
#[derive(Clone, Debug)]
pub struct Program {
    /// The engine.
    pub configuration: Configuration,
    /// The problem whose pattern was recorded.
    pub problem: Problem,
    /// Addresses of buffers and literals.
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
        let mut program = Self::empty(recording, configuration)?;
        for tape in &recording.tapes {
            program.append(tape, aim)?;
        }
        Ok(program)
    }

    /// Schedule all tapes of a recording for the fewest cycles, and for few bits: [`Program::with_aim`] twice, for less
    /// work.
    ///
    /// # Errors
    /// As [`Program::new`].
    pub fn both(recording: &Recording, configuration: &Configuration) -> Result<(Self, Self), Error> {
        let mut fast = Self::empty(recording, configuration)?;
        let mut compact = fast.clone();
        for tape in &recording.tapes {
            fast.append_both(&mut compact, tape)?;
        }
        Ok((fast, compact))
    }

    /// Schedule some stages as one stream, so that each may begin while those before it still run: a program of one
    /// segment, on the layout of all. With `leaves`, operations that these buffers do not need are eliminated.
    ///
    /// # Errors
    /// As [`Program::new`]; [`Error::NoSegment`] for a stage without a tape, or for no stage.
    pub fn joined(
        recording: &Recording,
        configuration: &Configuration,
        aim: Aim,
        stages: &[Stage],
        leaves: Option<&[Buffer]>,
    ) -> Result<Self, Error> {
        let mut program = Self::empty(recording, configuration)?;
        program.append(&joined(recording, stages, leaves)?, aim)?;
        program.name(stages, leaves);
        Ok(program)
    }

    /// Some streams of stages, for the fewest cycles and for few bits: [`Program::joined`] twice for each, for less work. With
    /// `leaves`, each leaves these buffers only.
    ///
    /// # Errors
    /// As [`Program::joined`].
    pub fn streams(
        recording: &Recording,
        configuration: &Configuration,
        streams: &[Vec<Stage>],
        leaves: Option<&[Buffer]>,
    ) -> Result<(Self, Self), Error> {
        let mut fast = Self::empty(recording, configuration)?;
        let mut compact = fast.clone();
        for stages in streams {
            fast.append_both(&mut compact, &joined(recording, stages, leaves)?)?;
            fast.name(stages, leaves);
            compact.name(stages, leaves);
        }
        Ok((fast, compact))
    }

    fn empty(recording: &Recording, configuration: &Configuration) -> Result<Self, Error> {
        configuration.validate()?;
        Ok(Self {
            configuration: *configuration,
            problem: recording.problem.clone(),
            layout: Layout::new(recording, configuration)?,
            segments: Vec::new(),
        })
    }

    fn append(&mut self, tape: &Tape, aim: Aim) -> Result<(), Error> {
        let graph = Graph::new(tape, &self.layout, &self.configuration);
        let scheduler = Scheduler::new(tape.stage.name(), &graph, &self.layout, &self.configuration);
        let fast = scheduler.fast()?;
        let schedule = match aim {
            Aim::Fast => fast,
            Aim::Compact => compact(&scheduler, &fast)?,
        };
        self.push(tape.stage, schedule)
    }

    fn append_both(&mut self, few_bits: &mut Self, tape: &Tape) -> Result<(), Error> {
        let graph = Graph::new(tape, &self.layout, &self.configuration);
        let scheduler = Scheduler::new(tape.stage.name(), &graph, &self.layout, &self.configuration);
        let fast = scheduler.fast()?;
        let compact = compact(&scheduler, &fast)?;
        self.push(tape.stage, fast)?;
        few_bits.push(tape.stage, compact)
    }

    fn push(&mut self, stage: Stage, schedule: Schedule) -> Result<(), Error> {
        let start = self.segments.last().map_or(0, |last| last.start + last.schedule.words as usize);
        let (needed, available) = (start + schedule.words as usize, self.configuration.microcode_words);
        if needed > available {
            return Err(Error::Microcode { needed, available });
        }
        self.segments.push(Segment { stage, then: Vec::new(), leaves: None, start, schedule });
        Ok(())
    }

    /// Name the stages of the last segment.
    fn name(&mut self, stages: &[Stage], leaves: Option<&[Buffer]>) {
        if let Some(segment) = self.segments.last_mut() {
            segment.then = stages[1..].to_vec();
            segment.leaves = leaves.map(<[Buffer]>::to_vec);
        }
    }

    /// The segment of a stage, or of the stream that begins with it.
    ///
    /// # Errors
    /// [`Error::NoSegment`] for a stage that has none.
    pub fn segment(&self, stage: Stage) -> Result<&Segment, Error> {
        let found = self.segments.iter().find(|segment| segment.stage == stage);
        found.ok_or_else(|| Error::NoSegment { stage: stage.name().to_owned() })
    }

    /// Compressed microcode of all segments, in their order.
    pub fn compressed(&self) -> Compressed {
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

/// Some stages as one tape, which writes some buffers as they do, or all.
fn joined(recording: &Recording, stages: &[Stage], leaves: Option<&[Buffer]>) -> Result<Tape, Error> {
    let none = |stage: &str| Error::NoSegment { stage: stage.to_owned() };
    let tape = |stage: Stage| recording.tape(stage).ok_or_else(|| none(stage.name()));
    let (&first, then) = stages.split_first().ok_or_else(|| none(""))?;
    let mut joined = tape(first)?.clone();
    for &stage in then {
        joined = joined.then(tape(stage)?);
    }
    Ok(match leaves {
        Some(buffers) => joined.leaving(buffers),
        None => joined,
    })
}

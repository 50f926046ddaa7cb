//! Errors of a configuration, or of a stream for it.

use core::fmt;

/// Misuse, or an engine too small; names the field and what is allowed.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[allow(missing_docs)] // the messages say what the fields are
pub enum Error {
    /// A field of the configuration that no engine can have.
    Configuration { field: &'static str, value: u64, allowed: &'static str },
    /// The storage has fewer words than the buffers, constants and temporaries need; `needed` is a lower bound, `key` the field that
    /// limits them.
    Storage { key: &'static str, needed_by: &'static str, needed: usize, available: usize },
    /// More microcode words than the memory holds.
    Microcode { needed: usize, available: usize },
    /// A stage that has no segment: it belongs to the processing system.
    NoSegment { stage: String },
    /// A buffer of another length than the recorded one.
    Pattern { buffer: &'static str, found: usize, expected: usize },
    /// A problem that differs from the recorded one in more than its numbers: in a matrix, the cones or the absent rows.
    OtherPattern { part: &'static str },
    /// A program on an engine that it was not made for.
    OtherEngine { engine: String, expected: u32, found: u32 },
    /// A microcode word that no encoder writes.
    Damaged { word: usize, detail: String },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Configuration { field, value, allowed } => {
                write!(f, "configuration `{field}` = {value}: allowed is {allowed}")
            }
            Self::Storage { key, needed_by, needed, available } => write!(
                f,
                "`{key}`: {needed_by} needs {needed} words of storage or more, the engine has {available}"
            ),
            Self::Microcode { needed, available } => write!(
                f,
                "`microcode_words`: {needed} words are needed, the engine's memory holds {available}"
            ),
            Self::NoSegment { stage } => {
                write!(f, "stage `{stage}` has no tape here: it has no segment")
            }
            Self::Pattern { buffer, found, expected } => write!(
                f,
                "buffer `{buffer}` has {found} words, but the recorded pattern has {expected}"
            ),
            Self::OtherPattern { part } => {
                write!(f, "the words are those of a problem whose `{part}` has another pattern than the recorded one")
            }
            Self::OtherEngine { engine, expected, found } => write!(
                f,
                "the program is of an engine of {engine} (identity {expected:08x}); this one has the identity {found:08x}"
            ),
            Self::Damaged { word, detail } => write!(f, "microcode word {word}: {detail}"),
        }
    }
}

impl std::error::Error for Error {}

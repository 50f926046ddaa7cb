//! What can be wrong with a problem or with settings. Non-convergence is a status, never an error.

use core::fmt;

/// Misuse: names the argument, and both sizes or the offending value.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// The problem has no variables.
    Empty,
    /// An argument's length or shape does not fit another's.
    Dimension {
        /// The argument that does not fit.
        argument: &'static str,
        /// What it has.
        found: usize,
        /// … of these: entries, rows, columns.
        unit: &'static str,
        /// What it must have.
        expected: usize,
        /// Where the expectation comes from.
        reason: &'static str,
    },
    /// A compressed-column array is malformed.
    Sparse {
        /// The matrix.
        argument: &'static str,
        /// What is wrong, where.
        detail: String,
    },
    /// A number that is not allowed where it stands.
    Value {
        /// The argument.
        argument: &'static str,
        /// Position among the argument's numbers.
        index: usize,
        /// The number.
        value: f64,
    },
    /// P is not positive semidefinite.
    NotConvex {
        /// What shows it.
        detail: String,
    },
    /// A second-order cone of dimension zero.
    EmptyCone {
        /// Which cone.
        index: usize,
    },
    /// A setting outside its range.
    Setting {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// The problem is too large for 32-bit indices.
    TooLarge {
        /// What has too many entries.
        what: &'static str,
        /// How many.
        size: usize,
    },
    /// Updated data do not have the sparsity pattern the engine was set up for.
    PatternChanged {
        /// The matrix.
        argument: &'static str,
    },
    /// The system has no threads to give.
    Threads {
        /// How many were asked for.
        count: usize,
        /// What it says.
        detail: String,
    },
    /// The sparse library refused the pattern.
    Symbolic(String),
    /// One problem of a batch is no problem.
    OfBatch {
        /// Which one.
        problem: usize,
        /// What is wrong with it.
        error: Box<Self>,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "the problem has no variables: `c` is empty"),
            Self::Dimension { argument, found, unit, expected, reason } => {
                write!(f, "`{argument}` has {found} {unit}, but {reason} {expected}")
            }
            Self::Sparse { argument, detail } => write!(f, "`{argument}`: {detail}"),
            Self::Value { argument, index, value } => {
                write!(f, "`{argument}` has {value} at entry {index}: only finite numbers are allowed there")
            }
            Self::NotConvex { detail } => write!(f, "`P` is not positive semidefinite: {detail}"),
            Self::EmptyCone { index } => {
                write!(f, "second-order cone {index} has dimension 0; the smallest has 1")
            }
            Self::Setting { name, value, allowed } => {
                write!(f, "setting `{name}` = {value}: allowed is {allowed}")
            }
            Self::TooLarge { what, size } => {
                write!(f, "{what} has {size} entries, more than 32-bit indices can address")
            }
            Self::PatternChanged { argument: "h" } => {
                write!(f, "`h` is +∞ in other rows than the problem this engine was set up for; absent rows stay so")
            }
            Self::PatternChanged { argument } => write!(
                f,
                "`{argument}` does not have the sparsity pattern of the problem this engine was set up for"
            ),
            Self::Threads { count, detail } => {
                write!(f, "`threads` = {count}: the system has none: {detail}")
            }
            Self::Symbolic(detail) => write!(f, "symbolic analysis failed: {detail}"),
            Self::OfBatch { problem, error } => write!(f, "problem {problem} of the batch: {error}"),
        }
    }
}

impl std::error::Error for Error {}

/// [`Error::Dimension`] unless an argument has what it must have.
pub(crate) fn fit(
    argument: &'static str,
    (found, unit): (usize, &'static str),
    expected: usize,
    reason: &'static str,
) -> Result<(), Error> {
    if found == expected {
        Ok(())
    } else {
        Err(Error::Dimension { argument, found, unit, expected, reason })
    }
}

//! An error message for the terminal.

pub type Failure = String;

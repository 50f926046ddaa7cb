//! Problem files, schema `orbsoc.problem/1`, as Python's `Problem.save` writes them.

use crate::failure::Failure;
use orbsoc::{Cones, Csc, Problem};
use serde::Deserialize;
use std::path::Path;

const SCHEMA: &str = "orbsoc.problem/1";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    schema: String,
    n: usize,
    p: usize,
    m: usize,
    #[serde(rename = "P", default)]
    quadratic: Option<Matrix>,
    #[serde(default)]
    c: Vec<f64>,
    #[serde(rename = "A", default)]
    equalities: Option<Matrix>,
    #[serde(default)]
    b: Vec<f64>,
    #[serde(rename = "G", default)]
    inequalities: Option<Matrix>,
    #[serde(default)]
    h: Vec<Number>,
    #[serde(default)]
    cones: Sizes,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Matrix {
    indptr: Vec<usize>,
    indices: Vec<usize>,
    data: Vec<f64>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct Sizes {
    l: usize,
    q: Vec<usize>,
}

/// A number, or the string "inf" for a row that does not constrain.
#[derive(Deserialize)]
#[serde(untagged)]
enum Number {
    Finite(f64),
    Text(Infinity),
}

#[derive(Deserialize)]
enum Infinity {
    #[serde(rename = "inf")]
    Inf,
}

/// Read one file.
pub fn read(path: &Path) -> Result<Problem, Failure> {
    let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    parse(&text).map_err(|reason| format!("{}: {reason}", path.display()))
}

fn parse(text: &str) -> Result<Problem, Failure> {
    let document: Document = serde_json::from_str(text).map_err(|e| e.to_string())?;
    if document.schema != SCHEMA {
        return Err(format!("schema is {:?}; this reader knows {SCHEMA:?}", document.schema));
    }
    let (n, p, m) = (document.n, document.p, document.m);
    if document.c.len() != n {
        return Err(format!("`c` has {} entries, but n is {n}", document.c.len()));
    }
    let refuse = |e: orbsoc::Error| e.to_string();
    let matrix = |name, matrix: Option<Matrix>, rows| match matrix {
        Some(Matrix { indptr, indices, data }) => Csc::new(name, (rows, n), indptr, indices, data).map(Some),
        None => Ok(None),
    };
    let full = matrix("P", document.quadratic, n).map_err(refuse)?;
    Problem::new(
        full.map(|full| full.upper_triangle("P")).transpose().map_err(refuse)?,
        document.c,
        matrix("A", document.equalities, p).map_err(refuse)?,
        document.b,
        matrix("G", document.inequalities, m).map_err(refuse)?,
        document.h.iter().map(Number::value).collect(),
        Cones { l: document.cones.l, q: document.cones.q },
    )
    .map_err(refuse)
}

impl Number {
    fn value(&self) -> f64 {
        match self {
            Self::Finite(value) => *value,
            Self::Text(Infinity::Inf) => f64::INFINITY,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::parse;

    const TEXT: &str = r#"{"schema": "orbsoc.problem/1", "n": 2, "p": 0, "m": 3,
        "P": {"indptr": [0, 2, 4], "indices": [0, 1, 0, 1], "data": [2.0, 1.0, 1.0, 2.0]}, "c": [1.0, 0.1],
        "G": {"indptr": [0, 1, 2], "indices": [0, 1], "data": [-1.0, -1.0]}, "h": [0.5, 0.0, "inf"],
        "cones": {"l": 3, "q": []}}"#;

    #[test]
    fn a_file_becomes_the_problem_it_states() {
        let problem = parse(TEXT).unwrap();
        assert_eq!((problem.n(), problem.p(), problem.m()), (2, 0, 3));
        let solution = orbsoc::solve(&problem, &orbsoc::Settings::default()).unwrap();
        // x1 >= -0.5 binds; then d/dx2 = x1 + 2 x2 + 0.1 vanishes at x2 = 0.2, inside x2 >= 0.
        assert!((solution.x[0] + 0.5).abs() < 1e-6 && (solution.x[1] - 0.2).abs() < 1e-6, "{:?}", solution.x);
        assert!(solution.s[2].is_infinite());
    }

    #[test]
    fn what_is_wrong_with_a_file_is_named() {
        for (from, to, named) in [
            ("problem/1", "problem/2", "schema"),
            ("\"c\": [1.0, 0.1]", "\"c\": [1.0]", "`c` has 1 entries"),
            ("\"inf\"", "\"nan\"", "untagged"),
            ("\"cones\"", "\"cone\"", "unknown field `cone`"),
            ("[0, 1, 2]", "[0, 1, 3]", "`G`"),
            ("\"l\": 3", "\"l\": 2", "cones"),
        ] {
            let reason = parse(&TEXT.replacen(from, to, 1)).unwrap_err();
            assert!(reason.contains(named), "{to}: {reason}");
        }
    }
}

//! docs/algorithm.md states what the code has: the dataflow table and the restarts, row by row, and the rules' numbers.

use orbsoc::{Attempt, Buffer, Restart, Stage, Status, RESTARTS};

const ALGORITHM: &str = include_str!("../../../docs/algorithm.md");
const CONTROL: &str = concat!(
    include_str!("../src/method/control.rs"),
    include_str!("../src/kernels/decisions.rs"),
    include_str!("../src/method/radius_scale.rs"),
    include_str!("../src/method/restart.rs"),
    include_str!("../src/outcome/verification.rs")
);

/// A stage's row: what it reads, updates, writes, and makes stale or leaves (unfinished).
fn row(stage: Stage) -> String {
    let (reads, writes, stales) = (stage.reads(), stage.writes(), stage.stales());
    let names = |buffers: &[Buffer], keep: &dyn Fn(&Buffer) -> bool| {
        buffers.iter().filter(|b| keep(b)).map(|b| b.name().to_owned()).collect::<Vec<_>>()
    };
    let cell = |names: Vec<String>| if names.is_empty() { "–".into() } else { names.join(" ") };
    let unfinished = names(stales, &|b| writes.contains(b)).into_iter().map(|name| format!("({name})"));
    let stale = names(stales, &|b| !writes.contains(b)).into_iter().chain(unfinished).collect();
    format!(
        "| `{}` {} | {} | {} | {} | {} |",
        stage.name(),
        stage.module().name(),
        cell(names(reads, &|b| !writes.contains(b))),
        cell(names(reads, &|b| writes.contains(b))),
        cell(names(writes, &|b| !reads.contains(b))),
        cell(stale),
    )
}

#[test]
fn the_dataflow_table_is_the_codes() {
    let missing: Vec<String> =
        Stage::ALL.iter().map(|&stage| row(stage)).filter(|row| !ALGORITHM.contains(row.as_str())).collect();
    assert!(missing.is_empty(), "rows to write into docs/algorithm.md:\n{}", missing.join("\n"));
    let rows = ALGORITHM
        .lines()
        .filter(|line| Stage::ALL.iter().any(|s| line.starts_with(&format!("| `{}` ", s.name()))));
    assert_eq!(rows.count(), Stage::ALL.len(), "a row that no stage has");
}

/// A restart's row: after which attempts and statuses, which one follows, and what it multiplies.
fn restart_row(restart: &Restart) -> String {
    let attempts: Vec<&str> = restart.after.iter().map(|&attempt| Attempt::name(attempt)).collect();
    let statuses: Vec<String> = restart.statuses.iter().map(|s| format!("`{}`", Status::name(*s))).collect();
    format!(
        "| {}{} | {} | {} | {} | {} |",
        attempts.join(", "),
        if restart.stalled { ", stalled" } else { "" },
        statuses.join(" "),
        restart.attempt.name(),
        restart.refinement_factor,
        restart.regularization_factor,
    )
}

#[test]
fn the_restart_table_is_the_codes() {
    let rows = RESTARTS.iter().map(restart_row).collect::<Vec<_>>().join("\n");
    assert!(ALGORITHM.contains(&rows), "rows to write into docs/algorithm.md:\n{rows}");
}

#[test]
fn the_rules_numbers_are_the_codes() {
    let constants = CONTROL.lines().filter_map(|line| {
        let (name, rest) = line.split_once("const ")?.1.split_once(": ")?;
        Some((name, rest.split_once(" = ")?.1.trim_end_matches(';')))
    });
    let constants = constants.filter(|(_, value)| !value.starts_with('&')); // the restarts have a table of their own
    let rows: Vec<String> = constants.map(|(name, value)| format!("| `{name}` | {value} |")).collect();
    assert!(rows.len() >= 14, "{rows:?}");
    for row in rows {
        assert!(ALGORITHM.contains(&row), "docs/algorithm.md lacks the row {row}");
    }
}

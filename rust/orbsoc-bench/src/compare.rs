//! Comparison of two results: the ratio after/before, below 1 where the later one is faster.

use crate::failure::Failure;
use crate::results::{Line, Lines, SETUP, SOLVE};
use std::collections::BTreeMap;
use std::fmt::Write;

/// A table by problem, and geometric means by part.
pub fn report(before: &Lines, after: &Lines) -> Result<String, Failure> {
    let pairs: Vec<_> = before
        .iter()
        .filter_map(|(key, old)| after.get(key).map(|new| (key, old, new)))
        .filter(|(_, old, new)| old.median_us > 0.0 && new.median_us > 0.0)
        .collect();
    if pairs.is_empty() {
        return Err("the two files have no problem in common".into());
    }
    let mut out = format!(
        "{:<44} {:>12} {:>12} {:>7}  iterations\n",
        "problem, solve", "before us", "after us", "ratio"
    );
    for ((problem, part), old, new) in &pairs {
        if part == SOLVE {
            let ratio = new.median_us / old.median_us;
            let note = changes(old, new);
            let _ = writeln!(
                out,
                "{problem:<44} {:>12.1} {:>12.1} {ratio:>7.3}  {note}",
                old.median_us, new.median_us
            );
        }
    }
    let mut parts: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for ((_, part), old, new) in &pairs {
        parts.entry(part).or_default().push((new.median_us / old.median_us).ln());
    }
    let _ = writeln!(
        out,
        "\n{:<44} {:>12} {:>12} {:>7}",
        "part, geometric mean of ratios", "", "problems", "ratio"
    );
    let stages = parts.keys().copied().filter(|part| ![SETUP, SOLVE].contains(part));
    for part in [SOLVE, SETUP].into_iter().chain(stages) {
        if let Some(logarithms) = parts.get(part) {
            let mean = (logarithms.iter().sum::<f64>() / logarithms.len() as f64).exp();
            let _ = writeln!(out, "{part:<44} {:>12} {:>12} {mean:>7.3}", "", logarithms.len());
        }
    }
    let only = before.keys().filter(|key| !after.contains_key(key)).count()
        + after.keys().filter(|key| !before.contains_key(key)).count();
    if only > 0 {
        let _ = writeln!(out, "{only} lines are in one file only");
    }
    Ok(out)
}

/// Iterations, and the status if it changed.
fn changes(old: &Line, new: &Line) -> String {
    let iterations = if old.iterations == new.iterations {
        old.iterations.to_string()
    } else {
        format!("{} -> {}", old.iterations, new.iterations)
    };
    if old.status == new.status {
        iterations
    } else {
        format!("{iterations}, {} -> {}", old.status, new.status)
    }
}

#[cfg(test)]
mod tests {
    use super::report;
    use crate::results::{Line, Lines};

    fn lines(rows: &[(&str, &str, f64, u32)]) -> Lines {
        let line = |median_us, iterations| Line { median_us, iterations, status: "SOLVED".into() };
        rows.iter().map(|&(p, part, us, it)| ((p.into(), part.into()), line(us, it))).collect()
    }

    #[test]
    fn ratios_are_of_the_problems_in_both_files() {
        let before = lines(&[("a", "solve", 8.0, 9), ("b", "solve", 2.0, 5), ("c", "solve", 1.0, 3)]);
        let after = lines(&[("a", "solve", 4.0, 9), ("b", "solve", 4.0, 6)]);
        let text = report(&before, &after).unwrap();
        assert!(text.contains("0.500  9\n") && text.contains("2.000  5 -> 6\n"), "{text}");
        let mean = text.lines().find(|line| line.starts_with("solve ")).unwrap();
        assert!(mean.ends_with("2   1.000"), "{mean}");
        assert!(text.ends_with("1 lines are in one file only\n"));
    }

    #[test]
    fn files_of_other_problems_cannot_be_compared() {
        assert!(report(&lines(&[("a", "solve", 1.0, 1)]), &lines(&[("b", "solve", 1.0, 1)])).is_err());
    }
}

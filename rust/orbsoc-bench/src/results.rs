//! Results as tables and as CSV: one line for each problem and part (set-up, solve, batch, stages).

use crate::arguments::Plan;
use crate::failure::Failure;
use crate::measure::Measured;
use crate::spread::Spread;
use crate::stages::StageTimes;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

pub const SETUP: &str = "setup";
pub const SOLVE: &str = "solve";
const COLUMNS: &str = "problem,part,calls,median_us,q1_us,q3_us,iterations,refinements,status,residual";

/// The fields of a line that comparisons need.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    pub median_us: f64,
    pub iterations: u32,
    pub status: String,
}

/// Lines by problem and part.
pub type Lines = BTreeMap<(String, String), Line>;

pub fn table(measured: &[Measured]) -> String {
    let mut out = format!(
        "{:<44} {:<18} {:>5} {:>6} {:>10} {:>9} {:>19} {:>9} {:>9}\n",
        "problem", "status", "iter", "refine", "setup us", "solve us", "(quartiles)", "batch us", "residual"
    );
    for m in measured {
        let s = &m.solution;
        let quartiles = format!("({:.1}-{:.1})", m.solve.q1, m.solve.q3);
        let _ = writeln!(
            out,
            "{:<44} {:<18} {:>5} {:>6} {:>10.1} {:>9.1} {:>19} {:>9} {:>9.1e}",
            m.problem,
            s.status.name(),
            s.iterations,
            s.refinements,
            m.setup.median,
            m.solve.median,
            quartiles,
            m.batch.map_or(String::new(), |batch| format!("{:.1}", batch.median)),
            s.certificate.worst()
        );
    }
    out
}

/// Stages, the most expensive first: means over the problems of their medians.
pub fn stage_table<'a>(stages: impl ExactSizeIterator<Item = &'a Vec<StageTimes>>) -> String {
    let mut rows: Vec<(&str, &str, f64, f64)> = Vec::new();
    let problems = stages.len() as f64;
    for times in stages.flatten() {
        let (calls, time) = (times.calls as f64 / problems, times.time.median / problems);
        match rows.iter_mut().find(|row| row.0 == times.stage) {
            Some(row) => {
                row.2 += calls;
                row.3 += time;
            }
            None => rows.push((times.stage, times.module, calls, time)),
        }
    }
    rows.sort_by(|a, b| b.3.total_cmp(&a.3));
    let total: f64 = rows.iter().map(|row| row.3).sum();
    let mut out = format!(
        "{:<18} {:<14} {:>10} {:>12} {:>10} {:>7}\n",
        "stage", "module", "runs/solve", "us/solve", "us/run", "share"
    );
    for (stage, module, calls, time) in rows {
        let percent = 100.0 * time / total;
        let _ = writeln!(
            out,
            "{stage:<18} {module:<14} {calls:>10.1} {time:>12.2} {:>10.3} {percent:>6.1}%",
            time / calls
        );
    }
    let _ = writeln!(out, "{:<18} {:<14} {:>10} {total:>12.2}", "sum", "", "");
    out
}

pub fn write(path: &Path, measured: &[Measured], plan: &Plan) -> Result<(), Failure> {
    let mut out = String::new();
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    for (key, value) in [
        ("orbsoc-bench", env!("CARGO_PKG_VERSION").to_string()),
        ("label", plan.label.clone()),
        ("date", today()),
        ("machine", format!("{cores} {} cores", std::env::consts::ARCH)),
        ("repeats", plan.repeats.to_string()),
        ("tolerance", format!("{:e}", plan.tol)),
    ] {
        let _ = writeln!(out, "# {key}: {value}");
    }
    let _ = writeln!(out, "{COLUMNS}");
    for m in measured {
        let s = &m.solution;
        let mut line = |part: &str, calls: usize, time: Spread| {
            let _ = writeln!(
                out,
                "{},{part},{calls},{:.3},{:.3},{:.3},{},{},{},{:.3e}",
                m.problem,
                time.median,
                time.q1,
                time.q3,
                s.iterations,
                s.refinements,
                s.status.name(),
                s.certificate.worst()
            );
        };
        line(SETUP, 1, m.setup);
        line(SOLVE, 1, m.solve);
        if let Some(batch) = m.batch {
            line("batch", 1, batch);
        }
        for stage in &m.stages {
            line(stage.stage, stage.calls, stage.time);
        }
    }
    std::fs::write(path, out).map_err(|e| format!("{}: {e}", path.display()))
}

pub fn read(path: &Path) -> Result<Lines, Failure> {
    let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    parse(&text).map_err(|reason| format!("{}: {reason}", path.display()))
}

fn parse(text: &str) -> Result<Lines, Failure> {
    let mut rows = text.lines().enumerate().filter(|(_, line)| !line.starts_with('#'));
    if rows.next().map(|(_, line)| line) != Some(COLUMNS) {
        return Err(format!("is no result of this program: its columns must be {COLUMNS}"));
    }
    let mut lines = Lines::new();
    for (k, row) in rows {
        let fields: Vec<&str> = row.split(',').collect();
        let parsed = match fields[..] {
            [problem, part, _, median, _, _, iterations, _, status, _] => {
                median.parse().ok().zip(iterations.parse().ok()).map(|(median_us, iterations)| {
                    let key = (problem.to_string(), part.to_string());
                    (key, Line { median_us, iterations, status: status.to_string() })
                })
            }
            _ => None,
        };
        let (key, line) = parsed.ok_or(format!("line {} is damaged: {row:?}", k + 1))?;
        lines.insert(key, line);
    }
    Ok(lines)
}

/// The date in UTC, year-month-day.
fn today() -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |t| t.as_secs());
    civil_date(seconds / 86_400)
}

/// Days since 1970-01-01 in the Gregorian calendar, counted in eras of 400 years that begin in March.
fn civil_date(days: u64) -> String {
    let day = days + 719_468;
    let (era, of_era) = (day / 146_097, day % 146_097);
    let year = (of_era - of_era / 1_460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year + year / 4 - year / 100);
    let from_march = (5 * of_year + 2) / 153;
    let month = if from_march < 10 { from_march + 3 } else { from_march - 9 };
    let in_month = of_year - (153 * from_march + 2) / 5 + 1;
    format!("{:04}-{month:02}-{in_month:02}", 400 * era + year + u64::from(month <= 2))
}

#[cfg(test)]
mod tests {
    use super::{civil_date, parse, COLUMNS};

    #[test]
    fn days_become_dates() {
        for (days, date) in
            [(0, "1970-01-01"), (59, "1970-03-01"), (11_016, "2000-02-29"), (20_778, "2026-11-21")]
        {
            assert_eq!(civil_date(days), date);
        }
    }

    #[test]
    fn a_damaged_line_is_named() {
        let text = format!("# label: x\n{COLUMNS}\na,solve,1,2.5,2,3,7,1,SOLVED,1e-9\nb,solve,1\n");
        assert!(parse(&text).unwrap_err().starts_with("line 4 is damaged"));
        let lines = parse(text.rsplit_once("b,").unwrap().0).unwrap();
        assert_eq!(lines[&("a".into(), "solve".into())].iterations, 7);
        assert!(parse("x,y\n").unwrap_err().contains("columns"));
    }
}

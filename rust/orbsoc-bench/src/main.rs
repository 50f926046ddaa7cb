//! `orbsoc-bench`: native times of set-up, solve and every stage, on folders of `orbsoc.problem/1` files.
//!
//! ```text
//! python -m benchmarks.families --out out/problems mission004
//! orbsoc-bench out/problems/mission004 --stages --out before.csv
//! orbsoc-bench out/problems/mission004 --stages --out after.csv      # at another commit
//! orbsoc-bench --compare before.csv after.csv
//! orbsoc-bench --warm out/problems/portfolio --stages
//! orbsoc-bench --schedule out/problems/mission004 --repeats 5
//! ```

mod arguments;
mod compare;
mod failure;
mod marks;
mod measure;
mod problem_file;
mod results;
mod schedules;
mod spread;
mod stages;
mod variants;
mod warm;

use arguments::{Command, HELP};
use failure::Failure;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("orbsoc-bench: {failure}");
            ExitCode::from(2)
        }
    }
}

fn run() -> Result<(), Failure> {
    match Command::parse(std::env::args().skip(1))? {
        Command::Help => print!("{HELP}"),
        Command::Compare { before, after } => {
            print!("{}", compare::report(&results::read(&before)?, &results::read(&after)?)?);
        }
        Command::Schedule(plan) => {
            print!("{}", schedules::table(&schedules::measure(&load(&plan.paths)?, &plan)?));
        }
        Command::Warm(plan) => {
            let measured = warm::measure(&load(&plan.paths)?, &plan)?;
            print!("{}", warm::table(&measured));
            if plan.stages {
                print!("\nfrom cold\n{}", results::stage_table(measured.iter().map(|m| &m.cold.stages)));
                print!("\nwarm\n{}", results::stage_table(measured.iter().map(|m| &m.warm.stages)));
            }
        }
        Command::Marks(plan) => {
            let settings = orbsoc::Settings { tol: plan.tol, ..orbsoc::Settings::default() };
            print!("{}", marks::solve(&load(&plan.paths)?, &settings, &plan)?);
        }
        Command::Measure(plan) => {
            let problems = load(&plan.paths)?;
            let measured = measure::measure(&problems, &plan)?;
            print!("{}", results::table(&measured));
            if plan.stages {
                print!("\n{}", results::stage_table(measured.iter().map(|m| &m.stages)));
            }
            if let Some(path) = &plan.out {
                results::write(path, &measured, &plan)?;
            }
        }
    }
    Ok(())
}

/// The problems of all files and folders given, by name in alphabetical order.
fn load(paths: &[PathBuf]) -> Result<Vec<(String, orbsoc::Problem)>, Failure> {
    let mut files = Vec::new();
    for path in paths {
        if path.is_dir() {
            let entries = path.read_dir().map_err(|e| format!("{}: {e}", path.display()))?;
            let mut found: Vec<_> = entries
                .filter_map(|entry| entry.ok().map(|e| e.path()))
                .filter(|file| file.extension().is_some_and(|end| end == "json"))
                .collect();
            if found.is_empty() {
                return Err(format!("{}: no .json files in this folder", path.display()));
            }
            found.sort();
            files.append(&mut found);
        } else {
            files.push(path.clone());
        }
    }
    files.iter().map(|file| Ok((name(file), problem_file::read(file)?))).collect()
}

/// Folder and file stem: the same file name may occur in several folders.
fn name(file: &Path) -> String {
    let stem = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    match file.parent().filter(|folder| folder.file_name().is_some()) {
        Some(folder) => format!("{}/{}", stem(folder), stem(file)),
        None => stem(file),
    }
}

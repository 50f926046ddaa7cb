//! Runs of columns that lie side by side and are worked on together, though none is the parent of the one before it.

use crate::supernode::{Kind, Panels, Run, LEAF_ROWS, MOST_LISTED};

/// Single siblings with the same rows, at most: recorded streams and schedules' tables follow from it.
const MOST_SIBLINGS: usize = 16;

/// So many siblings are no leaves.
const NO_LEAVES: usize = 8;

/// Fewer chains abreast are not worth the zeros.
const FEWEST_ABREAST: usize = 4;
/// Columns of each of them, at most, …
const WIDEST_ABREAST: usize = 4;
/// … of all together, …
const MOST_ABREAST: usize = 32;
/// … and rows of each, at least: others make leaves, or ragged columns.
const ROWS_ABREAST: usize = 5;

/// Gather what lies side by side; `below` are a column's rows.
pub(crate) fn gathered<'a>(runs: Vec<Run>, panels: Panels, below: impl Fn(usize) -> &'a [usize]) -> Vec<Run> {
    let runs = match panels {
        Panels::Exact => runs,
        Panels::Relaxed => abreast(runs, 2, &below),
        Panels::Lanes => abreast(runs, 1, &below),
    };
    let runs = join(join(runs, siblings), leaves);
    match panels {
        Panels::Exact => runs,
        Panels::Relaxed | Panels::Lanes => ragged(runs, below),
    }
}

/// Chains of equal width that do not contain one another, and the rows that any of them has.
struct Abreast {
    chains: Vec<Run>,
    rows: Vec<usize>,
}

impl Abreast {
    fn of(run: Run) -> Self {
        Self { rows: run.below.clone(), chains: vec![run] }
    }

    /// Whether a run may be one of several.
    fn suits(run: &Run) -> bool {
        run.kind == Kind::Chain && run.width <= WIDEST_ABREAST && run.below.len() >= ROWS_ABREAST
    }

    /// Take `next` in where it suits these: all rows are then at most `times` as many as each has in the mean.
    fn admit(&mut self, next: Run, times: usize) -> Result<(), Run> {
        let width = self.chains[0].width;
        let contained = || self.rows.iter().any(|row| (next.first..next.end()).contains(row));
        if next.width != width || self.width() + width > MOST_ABREAST || contained() {
            return Err(next);
        }
        if self.rows != next.below {
            let rows = union(&self.rows, &next.below);
            let entries = self.rows_of_each() + next.below.len();
            if rows.len() * (self.chains.len() + 1) > times * entries {
                return Err(next);
            }
            self.rows = rows;
        }
        self.chains.push(next);
        Ok(())
    }

    fn width(&self) -> usize {
        self.chains.len() * self.chains[0].width
    }

    /// Rows of one chain and the other, all told.
    fn rows_of_each(&self) -> usize {
        self.chains.iter().map(|chain| chain.below.len()).sum()
    }

    /// One run, where that is worth while and each product of two rows has a word of its own to be subtracted from,
    /// though it be zero.
    fn close<'a>(self, below: impl Fn(usize) -> &'a [usize]) -> Vec<Run> {
        let lands = |(at, &row): (usize, &usize)| {
            let mut there = below(row).iter();
            self.rows[at + 1..].iter().all(|row| there.any(|word| word == row))
        };
        if self.chains.len() < FEWEST_ABREAST || !self.rows.iter().enumerate().all(lands) {
            return self.chains;
        }
        let first = &self.chains[0];
        vec![Run {
            kind: Kind::Siblings,
            first: first.first,
            width: self.width(),
            top: first.width,
            nearest: self.rows[0],
            entries: self.chains.iter().map(|chain| chain.entries).sum(),
            below: self.rows,
            lengths: Vec::new(),
        }]
    }
}

/// Both lists, ascending.
fn union(a: &[usize], b: &[usize]) -> Vec<usize> {
    let mut all = [a, b].concat();
    all.sort_unstable();
    all.dedup();
    all
}

/// Chains whose rows are much the same share a panel: each word where they contribute is then met for once.
fn abreast<'a>(runs: Vec<Run>, times: usize, below: impl Fn(usize) -> &'a [usize]) -> Vec<Run> {
    let mut gathered = Vec::with_capacity(runs.len());
    let mut open: Option<Abreast> = None;
    for run in runs {
        let suits = Abreast::suits(&run);
        let rest = match &mut open {
            Some(open) if suits => open.admit(run, times),
            _ => Err(run),
        };
        if let Err(run) = rest {
            gathered.extend(open.take().into_iter().flat_map(|open| open.close(&below)));
            if suits {
                open = Some(Abreast::of(run));
            } else {
                gathered.push(run);
            }
        }
    }
    gathered.extend(open.into_iter().flat_map(|open| open.close(&below)));
    gathered
}

/// Take each run into the one before it where `suits` says as what.
fn join(runs: Vec<Run>, suits: impl Fn(&Run, &Run) -> Option<Kind>) -> Vec<Run> {
    let mut joined: Vec<Run> = Vec::with_capacity(runs.len());
    for run in runs {
        let kind = joined.last().and_then(|last| suits(last, &run));
        match (joined.last_mut(), kind) {
            (Some(last), Some(kind)) => take_beside(last, run, kind),
            _ => joined.push(run),
        }
    }
    joined
}

/// Whether the single column `next` has the rows of those `before` it.
fn siblings(before: &Run, next: &Run) -> Option<Kind> {
    let single = before.kind == Kind::Siblings && before.top == 1 && before.width < MOST_SIBLINGS;
    let single = (single || before.width == 1) && next.width == 1;
    (single && before.below == next.below).then_some(Kind::Siblings)
}

/// Whether the columns of `next` have as few rows as those `before` them, and do not depend on them.
fn leaves(before: &Run, next: &Run) -> Option<Kind> {
    let rows = rows_of_each_leaf(next)?;
    let independent = before.nearest >= next.end();
    (rows_of_each_leaf(before) == Some(rows) && independent).then_some(Kind::Leaves)
}

/// Rows below each column, where they may be leaves: few, and not better kept as siblings.
fn rows_of_each_leaf(run: &Run) -> Option<usize> {
    let rows = match run.kind {
        Kind::Leaves => run.below.len() / run.width,
        _ => run.below.len(),
    };
    let single = match run.kind {
        Kind::Chain => run.width == 1,
        Kind::Siblings => run.top == 1 && run.width < NO_LEAVES,
        Kind::Leaves => true,
        Kind::Given | Kind::Ragged => false,
    };
    (single && (1..=LEAF_ROWS).contains(&rows)).then_some(rows)
}

/// Take in columns that depend on none of these.
fn take_beside(run: &mut Run, mut next: Run, kind: Kind) {
    if kind == Kind::Leaves {
        make_leaves(run);
        make_leaves(&mut next);
        run.below.append(&mut next.below);
    }
    run.width += next.width;
    run.nearest = run.nearest.min(next.nearest);
    run.entries += next.entries;
    run.kind = kind;
}

/// Repeat the rows for each column.
fn make_leaves(run: &mut Run) {
    if run.kind != Kind::Leaves {
        run.below = run.below.repeat(run.width);
        run.kind = Kind::Leaves;
    }
}

/// Neighbours of few words each become ragged columns, whether one depends on another or not.
fn ragged<'a>(runs: Vec<Run>, below: impl Fn(usize) -> &'a [usize]) -> Vec<Run> {
    let kind = |run: &Run| matches!(run.kind, Kind::Chain | Kind::Siblings);
    let slight = |run: &Run| kind(run) && run.words() <= 1 + MOST_LISTED;
    let mut gathered: Vec<Run> = Vec::with_capacity(runs.len());
    for mut run in runs {
        match gathered.last_mut() {
            Some(last) if slight(&run) && (last.kind == Kind::Ragged || slight(last)) => {
                make_ragged(last, &below);
                make_ragged(&mut run, &below);
                last.width += run.width;
                last.below.append(&mut run.below);
                last.lengths.append(&mut run.lengths);
            }
            _ => gathered.push(run),
        }
    }
    gathered
}

/// Each column's own rows, instead of those that its panel has.
fn make_ragged<'a>(run: &mut Run, below: impl Fn(usize) -> &'a [usize]) {
    if run.kind != Kind::Ragged {
        let columns = run.first..run.end();
        run.lengths = columns.clone().map(|j| below(j).len()).collect();
        run.below = columns.flat_map(|j| below(j).iter().copied()).collect();
        (run.kind, run.top) = (Kind::Ragged, 1);
    }
}

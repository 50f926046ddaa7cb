//! Node amalgamation: adjacent runs of columns share a panel, though none is the parent of the one before it.

use crate::symbolic::supernodes::{Kind, Panels, Run, MAX_LEAF_ROWS, MAX_SCATTERED_ROWS};
use core::ops::Range;
use std::borrow::Cow;

/// Most single twins in a panel: recorded streams and schedules' tables follow from it.
const MAX_TWINS: usize = 16;

/// From this number on, twins stay together and are no leaves.
const MIN_TWINS_KEPT: usize = 8;

/// Fewer merged supernodes are not worth the stored zeros.
const MIN_MERGED: usize = 4;
/// Columns of each of them, at most, …
const MAX_MERGED_WIDTH: usize = 4;
/// … of all together, …
const MAX_MERGED_COLUMNS: usize = 32;
/// … and rows of each, at least: others make leaves, or simplicial columns.
const MIN_MERGED_ROWS: usize = 5;

/// Merge adjacent runs; `rows_of` are a column's rows.
pub(crate) fn amalgamated<'a>(
    mut runs: Vec<Run<'a>>,
    panels: Panels,
    rows_of: impl Fn(usize) -> &'a [u32],
) -> Vec<Run<'a>> {
    match panels {
        Panels::Exact => {}
        Panels::Relaxed => amalgamate(&mut runs, 2, &rows_of),
        Panels::Lanes => amalgamate(&mut runs, 1, &rows_of),
    }
    join(&mut runs, twins);
    join(&mut runs, leaves);
    match panels {
        Panels::Exact => {}
        Panels::Relaxed | Panels::Lanes => simplicial(&mut runs),
    }
    runs
}

/// Independent supernodes of equal width, and the union of their rows.
struct MergedSupernode<'a> {
    /// The runs that they are.
    runs: Range<usize>,
    /// Columns of each.
    diagonal_size: usize,
    rows: Cow<'a, [u32]>,
    /// Rows of one and the other, added up.
    rows_added: usize,
}

impl<'a> MergedSupernode<'a> {
    fn of(at: usize, run: &Run<'a>) -> Self {
        let rows_added = run.rows.len();
        Self { runs: at..at + 1, diagonal_size: run.width, rows: run.rows.clone(), rows_added }
    }

    /// Whether a run may be one of several.
    fn suits(run: &Run) -> bool {
        run.kind == Kind::Supernode && run.width <= MAX_MERGED_WIDTH && run.rows.len() >= MIN_MERGED_ROWS
    }

    fn width(&self) -> usize {
        self.runs.len() * self.diagonal_size
    }

    /// Merge the `next` run, and say so, where it suits: the union of rows is at most `times` their mean number.
    fn try_merge(&mut self, next: &Run, times: usize) -> bool {
        let contained = || self.rows.iter().any(|&row| (next.first..next.end()).contains(&(row as usize)));
        if next.width != self.diagonal_size
            || self.width() + self.diagonal_size > MAX_MERGED_COLUMNS
            || contained()
        {
            return false;
        }
        let rows_added = self.rows_added + next.rows.len();
        if self.rows != next.rows {
            let rows = union(&self.rows, &next.rows);
            if rows.len() * (self.runs.len() + 1) > times * rows_added {
                return false;
            }
            self.rows = Cow::Owned(rows);
        }
        self.runs.end += 1;
        self.rows_added = rows_added;
        true
    }

    /// Whether there are enough of them, and each product of two rows has a stored target, which may be zero.
    fn is_worthwhile(&self, rows_of: impl Fn(usize) -> &'a [u32]) -> bool {
        let lands = |(at, &row): (usize, &u32)| {
            let mut there = rows_of(row as usize).iter();
            self.rows[at + 1..].iter().all(|row| there.any(|entry| entry == row))
        };
        self.runs.len() >= MIN_MERGED && self.rows.iter().enumerate().all(lands)
    }

    /// The first of their runs takes the others in, which are left with no column.
    fn gather(self, runs: &mut [Run<'a>]) {
        let width = self.width();
        let entries = runs[self.runs.clone()].iter().map(|run| run.entries).sum();
        runs[self.runs.clone()].iter_mut().for_each(|run| run.width = 0);
        let first = &mut runs[self.runs.start];
        (first.kind, first.width, first.entries) = (Kind::IndependentTwins, width, entries);
        first.nearest = self.rows[0] as usize;
        first.rows = self.rows;
    }
}

/// Both lists, ascending.
fn union(a: &[u32], b: &[u32]) -> Vec<u32> {
    let mut all = [a, b].concat();
    all.sort_unstable();
    all.dedup();
    all
}

/// Sibling merge: supernodes of similar structure share a panel, so that each target entry is updated once.
fn amalgamate<'a>(runs: &mut Vec<Run<'a>>, times: usize, rows_of: impl Fn(usize) -> &'a [u32]) {
    let mut found: Vec<MergedSupernode> = Vec::new();
    let mut open: Option<MergedSupernode> = None;
    for (at, run) in runs.iter().enumerate() {
        let suits = MergedSupernode::suits(run);
        if suits && open.as_mut().is_some_and(|open| open.try_merge(run, times)) {
            continue;
        }
        found.extend(open.take().filter(|open| open.is_worthwhile(&rows_of)));
        open = suits.then(|| MergedSupernode::of(at, run));
    }
    found.extend(open.filter(|open| open.is_worthwhile(&rows_of)));
    for merged in found {
        merged.gather(runs);
    }
    runs.retain(|run| run.width > 0);
}

/// Take each run into the one before it where `suits` says as what.
fn join(runs: &mut Vec<Run<'_>>, suits: impl Fn(&Run, &Run) -> Option<Kind>) {
    runs.dedup_by(|next, last| {
        let kind = suits(last, next);
        if let Some(kind) = kind {
            merge(last, next, kind);
        }
        kind.is_some()
    });
}

/// Whether the single column `next` has the rows of those `before` it.
fn twins(before: &Run, next: &Run) -> Option<Kind> {
    let single =
        before.kind == Kind::IndependentTwins && before.diagonal_size == 1 && before.width < MAX_TWINS;
    let single = (single || before.width == 1) && next.width == 1;
    (single && before.rows == next.rows).then_some(Kind::IndependentTwins)
}

/// Whether the columns of `next` have as few rows as those `before` them, and do not depend on them.
fn leaves(before: &Run, next: &Run) -> Option<Kind> {
    let rows = rows_of_each_leaf(next)?;
    let independent = before.nearest >= next.end();
    (rows_of_each_leaf(before) == Some(rows) && independent).then_some(Kind::Leaves)
}

/// Rows below each column, where they may be leaves: few, and not better kept as twins.
fn rows_of_each_leaf(run: &Run) -> Option<usize> {
    let rows = run.rows.len();
    let single = match run.kind {
        Kind::Supernode => run.width == 1,
        Kind::IndependentTwins => run.diagonal_size == 1 && run.width < MIN_TWINS_KEPT,
        Kind::Leaves => true,
        Kind::Condensed | Kind::Simplicial => false,
    };
    (single && (1..=MAX_LEAF_ROWS).contains(&rows)).then_some(rows)
}

/// Take in columns that depend on none of these.
fn merge(run: &mut Run, next: &Run, kind: Kind) {
    run.width += next.width;
    run.nearest = run.nearest.min(next.nearest);
    run.entries += next.entries;
    run.kind = kind;
}

/// Neighbours of few entries each become simplicial columns, whether one depends on another or not.
fn simplicial(runs: &mut Vec<Run<'_>>) {
    let kind = |run: &Run| matches!(run.kind, Kind::Supernode | Kind::IndependentTwins);
    let slight = |run: &Run| kind(run) && run.stored_entries() <= 1 + MAX_SCATTERED_ROWS;
    runs.dedup_by(|next, last| {
        let joins = slight(next) && (last.kind == Kind::Simplicial || slight(last));
        if joins {
            (last.kind, last.diagonal_size) = (Kind::Simplicial, 1);
            last.width += next.width;
        }
        joins
    });
}

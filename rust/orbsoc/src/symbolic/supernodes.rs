//! Supernodes: runs of columns of L that share a panel.

use std::borrow::Cow;

/// Leaves with more rows than this are not batched.
pub(crate) const MAX_LEAF_ROWS: usize = 4;

/// Columns with more rows than this are not simplicial, and have no scatter indices entry by entry.
pub(crate) const MAX_SCATTERED_ROWS: usize = 24;

/// Fewer columns than this are twins, not condensed: sums over them would be short.
const MIN_CONDENSED: usize = 32;

/// What the columns of a supernode are to one another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A fundamental or relaxed supernode: each column's structure contains the next one's.
    Supernode,
    /// Independent columns, or supernodes of equal width, with identical structure below.
    IndependentTwins,
    /// Twins that depend on no column either, eliminated as a Schur complement: L·D has the matrix's own entries there.
    Condensed,
    /// Leaves of the elimination tree, batched: independent columns of equally few rows.
    Leaves,
    /// Simplicial: column by column, each with its own structure, perhaps depending on the ones before.
    Simplicial,
}

/// How columns of L are gathered into panels. The bits are the same: subtracting 0·y changes nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Panels {
    /// Only columns of equal structure: not one operation on a stored zero.
    Exact,
    /// Relaxed panels: also columns of similar structure, with stored zeros; and simplicial columns.
    Relaxed,
    /// The same with fewer zeros: an entry of eight problems is a vector already.
    Lanes,
}

/// Adjacent columns that share a panel.
pub(crate) struct Run<'a> {
    pub kind: Kind,
    pub first: usize,
    pub width: usize,
    /// Size of its diagonal blocks: the width of a supernode, one of single columns.
    pub diagonal_size: usize,
    /// Row structure below its own columns; of leaves and simplicial columns, the first one's: each has its own.
    pub rows: Cow<'a, [u32]>,
    /// The first of them; past all rows where there is none.
    pub nearest: usize,
    /// Entries of L among its columns.
    pub entries: usize,
}

impl<'a> Run<'a> {
    /// One column.
    fn of(first: usize, rows: &'a [u32]) -> Self {
        let nearest = rows.first().map_or(usize::MAX, |&row| row as usize);
        let (rows, entries) = (Cow::Borrowed(rows), 1 + rows.len());
        Self { kind: Kind::Supernode, first, width: 1, diagonal_size: 1, rows, nearest, entries }
    }

    /// The first column that is not its own.
    pub fn end(&self) -> usize {
        self.first + self.width
    }

    /// Entries that its panel stores.
    pub fn stored_entries(&self) -> usize {
        self.width * (self.diagonal_size + self.rows.len())
    }

    /// Take `next` in: it follows directly, and its rows contain all of this run's below it.
    fn absorb(&mut self, next: Self) {
        self.width += next.width;
        self.diagonal_size = self.width;
        self.entries += next.entries;
        self.nearest = next.nearest;
        self.rows = next.rows;
    }

    /// Whether `next` is the parent of this run's last column, and joining is cheap enough.
    fn suits(&self, next: &Self, panels: Panels) -> bool {
        let parent =
            self.end() == next.first && self.rows.first().is_some_and(|&row| row as usize == next.first);
        if !parent || self.kind == Kind::Condensed {
            return false;
        }
        let width = self.width + next.width;
        let stored = width * (width + 1) / 2 + width * next.rows.len();
        let zeros = stored - self.entries - next.entries;
        match panels {
            Panels::Exact => zeros == 0,
            Panels::Relaxed | Panels::Lanes => {
                let allowed = match width {
                    0..=4 => 0.3,
                    5..=16 => 0.2,
                    17..=48 => 0.1,
                    _ => 0.05,
                };
                zeros as f64 <= allowed * stored as f64
            }
        }
    }
}

/// Supernodes and condensed columns, from left to right: a column may absorb the runs before it whose parent it is.
/// `rows_of` are a column's rows.
pub(crate) fn supernodes<'a>(
    columns: usize,
    panels: Panels,
    rows_of: impl Fn(usize) -> &'a [u32],
) -> Vec<Run<'a>> {
    let condensed = condensed_columns(columns, &rows_of);
    let mut runs: Vec<Run> = Vec::with_capacity(columns);
    for (j, &condensed) in condensed.iter().enumerate() {
        let mut run = Run::of(j, rows_of(j));
        if condensed {
            run.kind = Kind::Condensed;
            match runs.last_mut() {
                Some(last) if last.kind == Kind::Condensed && last.rows == run.rows => last.width += 1,
                _ => runs.push(run),
            }
            continue;
        }
        while let Some(mut before) = runs.pop_if(|before| before.suits(&run, panels)) {
            before.absorb(run);
            run = before;
        }
        runs.push(run);
    }
    runs
}

/// Columns that depend on no other, with the same rows as those beside them: many of them, and too many rows
/// for leaves. Whatever the panels are, as sums over them have another order than those over twins.
fn condensed_columns<'a>(columns: usize, rows_of: impl Fn(usize) -> &'a [u32]) -> Vec<bool> {
    let (mut depends, mut condensed) = (vec![false; columns], vec![false; columns]);
    for j in 0..columns {
        for &row in rows_of(j) {
            depends[row as usize] = true;
        }
    }
    let mut first = 0;
    while first < columns {
        let same = |&j: &usize| !depends[j] && rows_of(j) == rows_of(first);
        let count = (first..columns).take_while(same).count();
        if count >= MIN_CONDENSED && rows_of(first).len() > MAX_LEAF_ROWS {
            condensed[first..first + count].fill(true);
        }
        first += count.max(1);
    }
    condensed
}

//! Runs of columns of L that are worked on together.

/// Leaves with more rows than this keep to themselves.
pub(crate) const LEAF_ROWS: usize = 4;

/// Fewer columns than this are siblings, even if they are given: sums over them would be short.
const FEWEST_GIVEN: usize = 32;

/// More siblings than this, with their rows, leave the nearest cache before they are used.
const MOST_SIBLINGS: usize = 16;

/// Columns with more rows than this are no part of a ragged run, and their contributions are not listed word by word.
pub(crate) const MOST_LISTED: usize = 24;

/// What the columns of a supernode are to one another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Each contains the next, and they share the rows below.
    Chain,
    /// They do not contain one another, and share the rows below.
    Siblings,
    /// Siblings that depend on no column either: what L·D has of them is the matrix's own.
    Given,
    /// They do not contain one another, and each has rows of its own, few and equally many.
    Leaves,
    /// The same, of as many rows as it may be.
    Ragged,
}

/// How columns of L are gathered into panels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Panels {
    /// Only columns of equal structure: not one operation on a stored zero.
    Exact,
    /// Also columns of similar structure, with stored zeros: more operations, on longer vectors; and ragged ones.
    /// The bits are the same: subtracting 0·y changes nothing.
    Relaxed,
}

/// Adjacent columns that share a panel.
pub(crate) struct Run {
    pub first: usize,
    pub width: usize,
    /// Rows below its own columns; of leaves and ragged ones, those of one after the other.
    pub below: Vec<usize>,
    /// How many of them are each ragged column's.
    pub lengths: Vec<usize>,
    /// The first of them; past all rows where there is none.
    nearest: usize,
    /// Entries of L among them.
    entries: usize,
    pub kind: Kind,
}

impl Run {
    /// Take `next` in: it follows directly, and its rows contain all of this run's below it.
    fn absorb(&mut self, next: Self) {
        self.width += next.width;
        self.entries += next.entries;
        self.nearest = next.nearest;
        self.below = next.below;
    }

    /// Whether this single column has the rows of those `before` it.
    fn is_sibling_of(&self, before: &Self) -> Option<Kind> {
        let single = before.kind == Kind::Siblings && before.width < MOST_SIBLINGS || before.width == 1;
        (single && self.width == 1 && before.below == self.below).then_some(Kind::Siblings)
    }

    /// Whether these columns have as few rows as those `before` them, and do not depend on them.
    fn is_leaf_beside(&self, before: &Self) -> Option<Kind> {
        let rows = self.rows_of_each()?;
        let independent = before.nearest >= self.first + self.width;
        (before.rows_of_each() == Some(rows) && independent).then_some(Kind::Leaves)
    }

    /// Rows below each column, where they may be leaves: few, and not better kept as siblings.
    fn rows_of_each(&self) -> Option<usize> {
        let rows = match self.kind {
            Kind::Leaves => self.below.len() / self.width,
            _ => self.below.len(),
        };
        let single = match self.kind {
            Kind::Chain => self.width == 1,
            Kind::Siblings => self.width < 8,
            Kind::Leaves => true,
            Kind::Given | Kind::Ragged => false,
        };
        (single && (1..=LEAF_ROWS).contains(&rows)).then_some(rows)
    }

    /// Whether this single column does not depend on the single ones `before` it.
    fn is_ragged_beside(&self, before: &Self) -> Option<Kind> {
        let single = |run: &Self| run.kind == Kind::Chain && run.width == 1;
        let few = (1..=MOST_LISTED).contains(&self.below.len());
        let first = single(before) && (1..=MOST_LISTED).contains(&before.below.len());
        let independent = before.nearest >= self.first + self.width;
        (single(self) && few && (first || before.kind == Kind::Ragged) && independent).then_some(Kind::Ragged)
    }

    /// Take in columns that depend on none of these.
    fn take_beside(&mut self, mut next: Self, kind: Kind) {
        if kind == Kind::Leaves {
            self.make_leaves();
            next.make_leaves();
        }
        if kind == Kind::Ragged {
            if self.lengths.is_empty() {
                self.lengths.push(self.below.len());
            }
            self.lengths.push(next.below.len());
        }
        if matches!(kind, Kind::Leaves | Kind::Ragged) {
            self.below.append(&mut next.below);
        }
        self.width += next.width;
        self.nearest = self.nearest.min(next.nearest);
        self.entries += next.entries;
        self.kind = kind;
    }

    /// Repeat the rows for each column.
    fn make_leaves(&mut self) {
        if self.kind != Kind::Leaves {
            self.below = self.below.repeat(self.width);
            self.kind = Kind::Leaves;
        }
    }

    /// Whether `next` is the parent of this run's last column, and joining is cheap enough.
    fn suits(&self, next: &Self, panels: Panels) -> bool {
        let follows = self.first + self.width == next.first;
        let parent = self.below.first() == Some(&next.first);
        if !follows || !parent || self.kind == Kind::Given {
            return false;
        }
        let width = self.width + next.width;
        let words = width * (width + 1) / 2 + width * next.below.len();
        let zeros = words - self.entries - next.entries;
        match panels {
            Panels::Exact => zeros == 0,
            Panels::Relaxed => {
                let allowed = match width {
                    0..=4 => 0.3,
                    5..=16 => 0.2,
                    17..=48 => 0.1,
                    _ => 0.05,
                };
                zeros as f64 <= allowed * words as f64
            }
        }
    }
}

/// Columns gathered from left to right; a new one may take in the runs before it that it ends.
pub(crate) fn runs_of_columns(colptr: &[usize], rowidx: &[usize], panels: Panels) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    let given = given_columns(colptr, rowidx);
    for j in 0..colptr.len() - 1 {
        let below = rowidx[colptr[j] + 1..colptr[j + 1]].to_vec();
        let nearest = below.first().copied().unwrap_or(usize::MAX);
        let entries = below.len() + 1;
        let kind = if given[j] { Kind::Given } else { Kind::Chain };
        let mut run = Run { first: j, width: 1, below, lengths: Vec::new(), nearest, entries, kind };
        let beside = |before: &&mut Run| before.kind == Kind::Given && before.below == run.below;
        if let Some(before) = runs.last_mut().filter(|before| given[j] && beside(before)) {
            before.take_beside(run, Kind::Given);
            continue;
        }
        while let Some(mut before) = runs.pop() {
            if !before.suits(&run, panels) {
                runs.push(before);
                break;
            }
            before.absorb(run);
            run = before;
        }
        runs.push(run);
    }
    let runs = join(join(runs, Run::is_sibling_of), Run::is_leaf_beside);
    match panels {
        Panels::Exact => runs,
        Panels::Relaxed => join(runs, Run::is_ragged_beside),
    }
}

/// Columns that depend on no other, with the same rows as those beside them: many of them, and too many rows
/// for leaves. Whatever the panels are, as sums over them have another order than those over siblings.
fn given_columns(colptr: &[usize], rowidx: &[usize]) -> Vec<bool> {
    let columns = colptr.len() - 1;
    let below = |j: usize| &rowidx[colptr[j] + 1..colptr[j + 1]];
    let (mut depends, mut given) = (vec![false; columns], vec![false; columns]);
    for j in 0..columns {
        for &row in below(j) {
            depends[row] = true;
        }
    }
    let mut first = 0;
    while first < columns {
        let alike = |&j: &usize| !depends[j] && below(j) == below(first);
        let count = (first..columns).take_while(alike).count();
        if count >= FEWEST_GIVEN && below(first).len() > LEAF_ROWS {
            given[first..first + count].fill(true);
        }
        first += count.max(1);
    }
    given
}

/// Take each run into the one before it where `suits` says so.
fn join(runs: Vec<Run>, suits: impl Fn(&Run, &Run) -> Option<Kind>) -> Vec<Run> {
    let mut joined: Vec<Run> = Vec::with_capacity(runs.len());
    for run in runs {
        let kind = joined.last().and_then(|last| suits(&run, last));
        match (joined.last_mut(), kind) {
            (Some(last), Some(kind)) => last.take_beside(run, kind),
            _ => joined.push(run),
        }
    }
    joined
}

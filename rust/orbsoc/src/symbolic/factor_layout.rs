//! Symbolic factorization of the KKT matrix: supernodes, and the elimination resolved once into scatter indices, so
//! that the numeric kernels only follow them.

use crate::error::Error;
use crate::symbolic::amalgamation::amalgamated;
use crate::symbolic::etree::columns_of_l;
use crate::symbolic::indices::index;
use crate::symbolic::supernodes::{chains, Kind, Panels, MAX_SCATTERED_ROWS};
use crate::symbolic::upper::Upper;
use core::ops::Range;

/// A run of columns of L, stored as a dense `height × width` panel, column-major. Each column begins with the rows of its
/// own chain, those above the diagonal unused; in siblings of one column each, and leaves, that is the diagonal alone.
/// Simplicial columns follow one another, each as long as it is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Supernode {
    pub kind: Kind,
    /// First column.
    pub first: usize,
    pub width: usize,
    /// Columns of each of its chains, and rows of the panel that are theirs.
    pub top: usize,
    /// Leading dimension: rows of the panel; of simplicial columns, of the longest.
    pub height: usize,
    /// Rows of the matrix below, in [`Symbolic::below`].
    pub below: (usize, usize),
    /// Where the panel begins among the factor's words.
    pub panel: usize,
    /// Where it contributes to, in [`Symbolic::updates`] …
    pub updates: (usize, usize),
    /// … or, when it is small, word by word in [`Symbolic::positions`].
    pub listed: Option<(usize, usize)>,
    /// Of simplicial columns, where theirs begin in [`Symbolic::starts`].
    starts: usize,
    /// Of given columns, where their words are in [`Symbolic::sources`].
    sources: usize,
}

impl Supernode {
    /// Words of the factor that its panel takes.
    pub fn words(&self) -> usize {
        match self.kind {
            Kind::Condensed => 0,
            Kind::Simplicial => self.width + self.below.1 - self.below.0,
            _ => self.width * self.height,
        }
    }

    /// Whether its contributions are listed word by word: few columns, and few enough words.
    fn small(&self) -> bool {
        matches!(self.kind, Kind::Leaves | Kind::Condensed | Kind::Simplicial)
            || (self.width <= 4 && self.height - self.top <= MAX_SCATTERED_ROWS)
    }

    /// The chain that a column is in.
    fn diagonal_block_of(&self, column: usize) -> Range<usize> {
        let first = match self.top {
            1 => column,
            top if top == self.width => self.first,
            top => column - (column - self.first) % top,
        };
        first..first + self.top
    }

    /// Columns whose contributions are listed apart.
    fn lists(&self) -> Range<usize> {
        let apart = matches!(self.kind, Kind::Leaves | Kind::Simplicial);
        self.first..self.first + if apart { self.width } else { 1 }
    }
}

/// Where the rows of one column of L are, asked for in ascending order.
struct Places<'a> {
    own: Range<usize>,
    below: &'a [u32],
    /// How many of the rows below have been passed.
    at: usize,
}

impl Places<'_> {
    /// Where in its column of the panel a row is.
    fn of(&mut self, row: u32) -> usize {
        if self.own.contains(&(row as usize)) {
            return row as usize - self.own.start;
        }
        if self.below[self.at..].first() != Some(&row) {
            self.at += self.below[self.at..].partition_point(|&r| r < row);
        }
        debug_assert_eq!(self.below.get(self.at), Some(&row), "no such row");
        self.at += 1;
        self.own.len() + self.at - 1
    }
}

/// "Subtract this from `target`": rows `lo..hi` of the source are columns of the target; rows `lo..`
/// land on the target's rows [`Symbolic::relative`]`[relative..]`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Update {
    pub target: usize,
    pub lo: usize,
    pub hi: usize,
    pub relative: usize,
}

/// Adjacent words of the permuted upper triangle, and where they are wanted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Load {
    /// The first of them.
    pub values: usize,
    /// Their places, in [`Symbolic::places`].
    pub places: Range<usize>,
}

/// The symbolic factorization.
#[derive(Clone, Debug, Default)]
pub(crate) struct Symbolic {
    pub supernodes: Vec<Supernode>,
    /// Rows below the columns of all supernodes …
    below: Vec<u32>,
    /// … and the same relative to the first row after each one's own columns, of simplicial columns to their first.
    ahead: Vec<u32>,
    /// Updates by all supernodes, targets ascending within each.
    pub updates: Vec<Update>,
    pub relative: Vec<u32>,
    /// Where each product of a small supernode's rows lands, column by column, counted from the end of
    /// its own panel; of simplicial columns, from the end of the column.
    pub positions: Vec<u32>,
    /// Runs of the matrix's entries that the factor begins with: all but those of condensed columns.
    pub loads: Vec<Load>,
    /// Where they go.
    pub places: Vec<u32>,
    /// Of given columns, where the diagonal begins among the matrix's words, then each row below.
    sources: Vec<u32>,
    /// Of simplicial columns, the number of rows below the columns before each; then, below all of them.
    starts: Vec<u32>,
    /// Words of all panels.
    pub panel_words: usize,
    /// Entries of the largest panel, of simplicial columns of the longest column: scratch of the factorisation.
    pub max_panel: usize,
    /// Unknowns that the substitution through any one panel keeps beside.
    pub substitution_scratch: usize,
    /// Entries of L below the diagonal.
    pub nnz_l: usize,
    /// Multiply–subtracts of the factorisation, from the column counts of L.
    pub multiply_subtracts: usize,
}

impl Symbolic {
    /// Analyse a matrix that is already in its final order.
    pub fn new(upper: &Upper, panels: Panels) -> Result<Self, Error> {
        let (colptr, rowidx) = columns_of_l(upper)?;
        let mut out = Self::default();
        let owner = out.find_supernodes(&colptr, &rowidx, panels);
        out.resolve_updates(&owner);
        out.locate_entries(upper, &owner);
        out.locate_condensed(upper);
        Ok(out)
    }

    /// Lay out the panels of the supernodes; returns the supernode that owns each column.
    fn find_supernodes(&mut self, colptr: &[u32], rowidx: &[u32], panels: Panels) -> Vec<u32> {
        let dim = colptr.len() - 1;
        for j in 0..dim {
            let below = (colptr[j + 1] - colptr[j] - 1) as usize;
            self.nnz_l += below;
            self.multiply_subtracts += below * (below + 1) / 2;
        }
        let mut owner = vec![0; dim];
        let below = |j: usize| &rowidx[colptr[j] as usize + 1..colptr[j + 1] as usize];
        for run in amalgamated(chains(dim, panels, below), panels, below) {
            let rows = match run.kind {
                Kind::Supernode | Kind::IndependentTwins | Kind::Condensed => run.below.len(),
                Kind::Leaves => run.below.len() / run.width,
                Kind::Simplicial => run.lengths.iter().copied().max().unwrap_or(0) as usize,
            };
            let height = run.top + rows;
            owner[run.first..run.first + run.width].fill(index(self.supernodes.len()));
            let node = Supernode {
                kind: run.kind,
                first: run.first,
                width: run.width,
                top: run.top,
                below: (self.below.len(), self.below.len() + run.below.len()),
                height,
                panel: self.panel_words,
                updates: (0, 0),
                listed: None,
                starts: self.starts.len(),
                sources: 0,
            };
            if node.kind == Kind::Simplicial {
                let ends = run.lengths.iter().scan(0, |end, length| {
                    *end += length;
                    Some(*end)
                });
                self.starts.push(0);
                self.starts.extend(ends);
            }
            self.supernodes.push(node);
            let condensed = run.kind == Kind::Condensed;
            self.substitution_scratch =
                self.substitution_scratch.max(if condensed { run.width } else { rows });
            let next = if node.kind == Kind::Simplicial { run.first } else { run.first + run.width };
            let next = index(next);
            self.ahead.extend(run.below.iter().map(|&row| row - next));
            self.below.extend_from_slice(&run.below);
            self.panel_words += node.words();
            let beside = if node.kind == Kind::Simplicial { height } else { run.width * height };
            self.max_panel = self.max_panel.max(beside);
        }
        owner
    }

    /// Row structure below a supernode; of leaves and simplicial columns, one column's after the other's.
    #[inline(always)]
    pub fn below(&self, node: &Supernode) -> &[u32] {
        &self.below[node.below.0..node.below.1]
    }

    /// The same, relative to the first row after its own columns, of simplicial columns to their first.
    #[inline(always)]
    pub fn ahead(&self, node: &Supernode) -> &[u32] {
        &self.ahead[node.below.0..node.below.1]
    }

    /// Where the products of a small supernode's rows land.
    #[inline(always)]
    pub fn positions_of(&self, node: &Supernode) -> &[u32] {
        let (begin, end) = node.listed.unwrap_or_default();
        &self.positions[begin..end]
    }

    /// Of simplicial columns, the number of rows below the columns before each; then, below all of them.
    #[inline(always)]
    pub fn starts_of(&self, node: &Supernode) -> &[u32] {
        &self.starts[node.starts..][..=node.width]
    }

    /// Where a column begins among the factor's words.
    #[inline(always)]
    pub fn column_begin(&self, node: &Supernode, column: usize) -> usize {
        let before = column - node.first;
        let words = match node.kind {
            Kind::Simplicial => before + self.starts_of(node)[before] as usize,
            _ => before * node.height,
        };
        node.panel + words
    }

    /// Of given columns, where the diagonal begins among the matrix's words, then each row below.
    #[inline(always)]
    pub fn sources_of(&self, node: &Supernode) -> &[u32] {
        &self.sources[node.sources..][..1 + node.height - node.top]
    }

    /// Rows below one column, the rows of its own panel left out.
    fn below_column(&self, node: &Supernode, column: usize) -> &[u32] {
        match node.kind {
            Kind::Leaves => {
                let rows = node.height - node.top;
                &self.below(node)[(column - node.first) * rows..][..rows]
            }
            Kind::Simplicial => {
                let starts = &self.starts_of(node)[column - node.first..];
                &self.below(node)[starts[0] as usize..starts[1] as usize]
            }
            _ => self.below(node),
        }
    }

    /// Rows of one column's entries below the diagonal, and where in its column of the panel they are.
    #[cfg(test)]
    pub fn entries<'a>(
        &'a self,
        node: &'a Supernode,
        column: usize,
    ) -> impl Iterator<Item = (usize, usize)> + 'a {
        let own = column + 1..node.diagonal_block_of(column).end;
        let below = self.below_column(node, column).iter().map(|&row| row as usize);
        let mut places = self.places_in(node, column);
        own.chain(below).map(move |row| (row, places.of(index(row))))
    }

    /// Where the entries of one column of L are.
    fn places_in(&self, node: &Supernode, column: usize) -> Places<'_> {
        Places { own: node.diagonal_block_of(column), below: self.below_column(node, column), at: 0 }
    }

    fn resolve_updates(&mut self, owner: &[u32]) {
        let (mut updates, mut relative, mut positions) = (Vec::new(), Vec::new(), Vec::new());
        for source in 0..self.supernodes.len() {
            let node = self.supernodes[source];
            if node.small() {
                let begin = positions.len();
                for column in node.lists() {
                    self.list_positions(&node, column, owner, &mut positions);
                }
                self.supernodes[source].listed = Some((begin, positions.len()));
            } else {
                let begin = updates.len();
                self.find_updates(&node, owner, &mut updates, &mut relative);
                self.supernodes[source].updates = (begin, updates.len());
            }
        }
        (self.updates, self.relative, self.positions) = (updates, relative, positions);
    }

    fn find_updates(
        &self,
        node: &Supernode,
        owner: &[u32],
        updates: &mut Vec<Update>,
        relative: &mut Vec<u32>,
    ) {
        let rows = self.below(node);
        let mut lo = 0;
        while lo < rows.len() {
            let column = rows[lo] as usize;
            let target = owner[column] as usize;
            let onto = &self.supernodes[target];
            let end = onto.diagonal_block_of(column).end;
            let hi = lo + rows[lo..].partition_point(|&r| (r as usize) < end);
            let begin = relative.len();
            let mut places = self.places_in(onto, column);
            relative.extend(rows[lo..].iter().map(|&row| index(places.of(row))));
            updates.push(Update { target, lo: node.top + lo, hi: node.top + hi, relative: begin });
            lo = hi;
        }
    }

    fn list_positions(&self, node: &Supernode, column: usize, owner: &[u32], positions: &mut Vec<u32>) {
        let rows = self.below_column(node, column);
        let end = match node.kind {
            Kind::Simplicial => self.column_begin(node, column) + 1 + rows.len(),
            _ => node.panel + node.words(),
        };
        for (j, &column) in rows.iter().enumerate() {
            let column = column as usize;
            let onto = &self.supernodes[owner[column] as usize];
            let begin = self.column_begin(onto, column) - end;
            let mut places = self.places_in(onto, column);
            positions.extend(rows[j..].iter().map(|&row| index(begin + places.of(row))));
        }
    }

    fn locate_entries(&mut self, upper: &Upper, owner: &[u32]) {
        for j in 0..upper.dim() {
            for k in upper.range(j) {
                let i = upper.rowidx[k] as usize;
                // Entry (i, j), i ≤ j, of the upper triangle is entry (j, i) of L's pattern.
                let node = self.supernodes[owner[i] as usize];
                if node.kind == Kind::Condensed {
                    continue;
                }
                let place = self.places_in(&node, i).of(index(j));
                match self.loads.last_mut() {
                    Some(last) if last.values + last.places.len() == k => last.places.end += 1,
                    _ => {
                        let begin = self.places.len();
                        self.loads.push(Load { values: k, places: begin..begin + 1 });
                    }
                }
                self.places.push(index(self.column_begin(&node, i) + place));
            }
        }
    }

    /// Where the matrix has the words of given columns: those of a row are adjacent, in that row's column of
    /// the upper triangle, and so are the diagonal's, which are their columns' only ones.
    fn locate_condensed(&mut self, upper: &Upper) {
        for at in 0..self.supernodes.len() {
            let node = self.supernodes[at];
            if node.kind != Kind::Condensed {
                continue;
            }
            self.supernodes[at].sources = self.sources.len();
            self.sources.push(upper.colptr[node.first]);
            for k in node.below.0..node.below.1 {
                let row = self.below[k] as usize;
                let before = upper.column(row).partition_point(|&row| (row as usize) < node.first);
                self.sources.push(upper.colptr[row] + index(before));
            }
        }
    }
}

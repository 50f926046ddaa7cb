//! Symbolic factorization of the KKT matrix: supernodes, and the elimination resolved once into scatter indices, so
//! that the numeric kernels only follow them.

use crate::error::Error;
use crate::symbolic::supernodes::{supernodes, Kind, Panels, MAX_SCATTERED_ROWS};
use crate::symbolic::{amalgamation::amalgamated, etree::columns_of_l, indices::index, upper::Upper};
use core::ops::Range;

/// A run of columns of L, stored as a dense `leading_dim × width` panel, column-major. Each column begins with the rows of its
/// diagonal block, the entries above the diagonal unused; of single columns that is the diagonal alone.
/// Simplicial columns follow one another, each as long as it is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Supernode {
    pub kind: Kind,
    pub first: usize,
    pub width: usize,
    /// Size of its diagonal blocks.
    pub diagonal_size: usize,
    /// Leading dimension: rows of the panel; of simplicial columns, of the longest.
    pub leading_dim: usize,
    /// Rows of the matrix below, in [`Symbolic::row_structure`].
    pub row_range: (usize, usize),
    /// Where the panel begins among the factor's entries.
    pub panel: usize,
    /// Where it contributes to, in [`Symbolic::updates`] …
    pub updates: (usize, usize),
    /// … or, when it is small, entry by entry in [`Symbolic::scatter`].
    pub scatter_range: Option<(usize, usize)>,
    /// Of simplicial columns, where theirs begin in [`Symbolic::starts`].
    starts: usize,
    /// Of condensed columns, where their entries are in [`Symbolic::gather`].
    gather: usize,
}

impl Supernode {
    /// Entries of the factor that its panel stores.
    pub fn stored_entries(&self) -> usize {
        match self.kind {
            Kind::Condensed => 0,
            Kind::Simplicial => self.width + self.row_range.1 - self.row_range.0,
            _ => self.width * self.leading_dim,
        }
    }

    /// Whether its update has scatter indices entry by entry: few columns and entries.
    fn small(&self) -> bool {
        matches!(self.kind, Kind::Leaves | Kind::Condensed | Kind::Simplicial)
            || (self.width <= 4 && self.leading_dim - self.diagonal_size <= MAX_SCATTERED_ROWS)
    }

    /// Columns of the diagonal block that a column is in.
    fn diagonal_block_of(&self, column: usize) -> Range<usize> {
        let first = match self.diagonal_size {
            1 => column,
            size if size == self.width => self.first,
            size => column - (column - self.first) % size,
        };
        first..first + self.diagonal_size
    }

    /// Columns with scatter indices of their own.
    fn lists(&self) -> Range<usize> {
        let apart = matches!(self.kind, Kind::Leaves | Kind::Simplicial);
        self.first..self.first + if apart { self.width } else { 1 }
    }
}

/// Positions of rows in one column of L, asked for in ascending order.
struct RowPositions<'a> {
    own: Range<usize>,
    below: &'a [u32],
    /// Number of rows below that have been passed.
    at: usize,
}

impl RowPositions<'_> {
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
/// scatter to the target's rows [`Symbolic::relative`]`[relative..]`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Update {
    pub target: usize,
    pub lo: usize,
    pub hi: usize,
    pub relative: usize,
}

/// Adjacent entries of the permuted upper triangle, and their targets in the factor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct EntryRun {
    /// The first of them.
    pub values: usize,
    /// Their targets, in [`Symbolic::entry_targets`].
    pub targets: Range<usize>,
}

/// The symbolic factorization.
#[derive(Clone, Debug, Default)]
pub(crate) struct Symbolic {
    pub supernodes: Vec<Supernode>,
    /// Rows below the columns of all supernodes …
    row_structure: Vec<u32>,
    /// … and the same relative to the first row after each one's own columns, of simplicial columns to their first.
    relative_rows: Vec<u32>,
    /// Updates by all supernodes, targets ascending within each.
    pub updates: Vec<Update>,
    pub relative: Vec<u32>,
    /// Scatter index of each product of a small supernode's rows, column by column, counted from the end of
    /// its own panel; of simplicial columns, from the end of the column.
    pub scatter: Vec<u32>,
    /// Runs of the matrix's entries that the factor begins with: all but those of condensed columns.
    pub entry_runs: Vec<EntryRun>,
    /// Where they go.
    pub entry_targets: Vec<u32>,
    /// Of condensed columns, where the diagonal begins among the matrix's entries, then each row below.
    gather: Vec<u32>,
    /// Of simplicial columns, the number of rows below the columns before each; then, below all of them.
    starts: Vec<u32>,
    /// Entries of all panels.
    pub panel_entries: usize,
    /// Entries of the largest panel, of simplicial columns of the longest column: scratch of the factorisation.
    pub max_panel: usize,
    /// Scratch of the substitution: most unknowns of any one panel.
    pub substitution_scratch: usize,
    /// Entries of L below the diagonal.
    pub nnz_l: usize,
    /// Multiply–subtracts of the factorisation, from the column counts of L.
    pub multiply_subtracts: usize,
}

impl Symbolic {
    /// Analyse a matrix that is already in its final order.
    pub fn new(upper: &Upper, panels: Panels) -> Result<Self, Error> {
        let l = columns_of_l(upper)?;
        let (colptr, rowidx) = (l.col_ptr(), l.row_idx());
        let mut out = Self::default();
        out.row_structure.reserve(rowidx.len() - upper.dim());
        out.relative_rows.reserve(rowidx.len() - upper.dim());
        out.entry_targets.reserve(upper.nnz());
        let owner = out.find_supernodes(colptr, rowidx, panels);
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
        let rows_of = |j: usize| &rowidx[colptr[j] as usize + 1..colptr[j + 1] as usize];
        for run in amalgamated(supernodes(dim, panels, rows_of), panels, rows_of) {
            let columns = run.first..run.end();
            let row_begin = self.row_structure.len();
            let mut rows = run.rows.len();
            let starts = self.starts.len();
            if run.kind == Kind::Simplicial {
                rows = columns.clone().map(|j| rows_of(j).len()).max().unwrap_or(0);
                self.starts.push(0);
            }
            if matches!(run.kind, Kind::Leaves | Kind::Simplicial) {
                for j in columns.clone() {
                    self.row_structure.extend_from_slice(rows_of(j));
                    if run.kind == Kind::Simplicial {
                        self.starts.push(index(self.row_structure.len() - row_begin));
                    }
                }
            } else {
                self.row_structure.extend_from_slice(&run.rows);
            }
            let leading_dim = run.diagonal_size + rows;
            owner[columns].fill(index(self.supernodes.len()));
            let node = Supernode {
                kind: run.kind,
                first: run.first,
                width: run.width,
                diagonal_size: run.diagonal_size,
                row_range: (row_begin, self.row_structure.len()),
                leading_dim,
                panel: self.panel_entries,
                updates: (0, 0),
                scatter_range: None,
                starts,
                gather: 0,
            };
            self.supernodes.push(node);
            let condensed = run.kind == Kind::Condensed;
            self.substitution_scratch =
                self.substitution_scratch.max(if condensed { run.width } else { rows });
            let next = index(if node.kind == Kind::Simplicial { run.first } else { run.end() });
            self.relative_rows.extend(self.row_structure[row_begin..].iter().map(|&row| row - next));
            self.panel_entries += node.stored_entries();
            let beside = if node.kind == Kind::Simplicial { leading_dim } else { run.width * leading_dim };
            self.max_panel = self.max_panel.max(beside);
        }
        owner
    }

    /// Row structure below a supernode; of leaves and simplicial columns, one column's after the other's.
    #[inline(always)]
    pub fn row_structure(&self, node: &Supernode) -> &[u32] {
        &self.row_structure[node.row_range.0..node.row_range.1]
    }

    /// The same, relative to the first row after its own columns, of simplicial columns to their first.
    #[inline(always)]
    pub fn relative_rows(&self, node: &Supernode) -> &[u32] {
        &self.relative_rows[node.row_range.0..node.row_range.1]
    }

    /// Scatter indices of a small supernode's update.
    #[inline(always)]
    pub fn scatter_indices(&self, node: &Supernode) -> &[u32] {
        let (begin, end) = node.scatter_range.unwrap_or_default();
        &self.scatter[begin..end]
    }

    /// Of simplicial columns, the number of rows below the columns before each; then, below all of them.
    #[inline(always)]
    pub fn starts_of(&self, node: &Supernode) -> &[u32] {
        &self.starts[node.starts..][..=node.width]
    }

    /// Where a column begins among the factor's entries.
    #[inline(always)]
    pub fn column_begin(&self, node: &Supernode, column: usize) -> usize {
        let before = column - node.first;
        let stored = match node.kind {
            Kind::Simplicial => before + self.starts_of(node)[before] as usize,
            _ => before * node.leading_dim,
        };
        node.panel + stored
    }

    /// Of condensed columns, where the diagonal begins among the matrix's entries, then each row below.
    #[inline(always)]
    pub fn gather_indices(&self, node: &Supernode) -> &[u32] {
        &self.gather[node.gather..][..1 + node.leading_dim - node.diagonal_size]
    }

    /// Rows below one column, the rows of its own panel left out.
    fn below_column(&self, node: &Supernode, column: usize) -> &[u32] {
        match node.kind {
            Kind::Leaves => {
                let rows = node.leading_dim - node.diagonal_size;
                &self.row_structure(node)[(column - node.first) * rows..][..rows]
            }
            Kind::Simplicial => {
                let starts = &self.starts_of(node)[column - node.first..];
                &self.row_structure(node)[starts[0] as usize..starts[1] as usize]
            }
            _ => self.row_structure(node),
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
        let mut found = self.positions_in(node, column);
        own.chain(below).map(move |row| (row, found.of(index(row))))
    }

    /// Where the entries of one column of L are.
    fn positions_in(&self, node: &Supernode, column: usize) -> RowPositions<'_> {
        RowPositions { own: node.diagonal_block_of(column), below: self.below_column(node, column), at: 0 }
    }

    fn resolve_updates(&mut self, owner: &[u32]) {
        let (mut updates, mut relative, mut scatter) = (Vec::new(), Vec::new(), Vec::new());
        for source in 0..self.supernodes.len() {
            let node = self.supernodes[source];
            if node.small() {
                let begin = scatter.len();
                for column in node.lists() {
                    self.list_scatter_indices(&node, column, owner, &mut scatter);
                }
                self.supernodes[source].scatter_range = Some((begin, scatter.len()));
            } else {
                let begin = updates.len();
                self.find_updates(&node, owner, &mut updates, &mut relative);
                self.supernodes[source].updates = (begin, updates.len());
            }
        }
        (self.updates, self.relative, self.scatter) = (updates, relative, scatter);
    }

    fn find_updates(
        &self,
        node: &Supernode,
        owner: &[u32],
        updates: &mut Vec<Update>,
        relative: &mut Vec<u32>,
    ) {
        let rows = self.row_structure(node);
        let mut lo = 0;
        while lo < rows.len() {
            let column = rows[lo] as usize;
            let target = owner[column] as usize;
            let onto = &self.supernodes[target];
            let end = onto.diagonal_block_of(column).end;
            let hi = lo + rows[lo..].partition_point(|&r| (r as usize) < end);
            let begin = relative.len();
            let mut found = self.positions_in(onto, column);
            relative.extend(rows[lo..].iter().map(|&row| index(found.of(row))));
            updates.push(Update {
                target,
                lo: node.diagonal_size + lo,
                hi: node.diagonal_size + hi,
                relative: begin,
            });
            lo = hi;
        }
    }

    fn list_scatter_indices(&self, node: &Supernode, column: usize, owner: &[u32], scatter: &mut Vec<u32>) {
        let rows = self.below_column(node, column);
        let end = match node.kind {
            Kind::Simplicial => self.column_begin(node, column) + 1 + rows.len(),
            _ => node.panel + node.stored_entries(),
        };
        for (j, &column) in rows.iter().enumerate() {
            let column = column as usize;
            let onto = &self.supernodes[owner[column] as usize];
            let begin = self.column_begin(onto, column) - end;
            let mut found = self.positions_in(onto, column);
            scatter.extend(rows[j..].iter().map(|&row| index(begin + found.of(row))));
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
                let place = self.positions_in(&node, i).of(index(j));
                match self.entry_runs.last_mut() {
                    Some(last) if last.values + last.targets.len() == k => last.targets.end += 1,
                    _ => {
                        let begin = self.entry_targets.len();
                        self.entry_runs.push(EntryRun { values: k, targets: begin..begin + 1 });
                    }
                }
                self.entry_targets.push(index(self.column_begin(&node, i) + place));
            }
        }
    }

    /// Where the matrix has the entries of condensed columns: those of a row are adjacent, in that row's column of
    /// the upper triangle, and so are the diagonal's, which are their columns' only ones.
    fn locate_condensed(&mut self, upper: &Upper) {
        for at in 0..self.supernodes.len() {
            let node = self.supernodes[at];
            if node.kind != Kind::Condensed {
                continue;
            }
            self.supernodes[at].gather = self.gather.len();
            self.gather.push(upper.colptr[node.first]);
            for k in node.row_range.0..node.row_range.1 {
                let row = self.row_structure[k] as usize;
                let before = upper.column(row).partition_point(|&row| (row as usize) < node.first);
                self.gather.push(upper.colptr[row] + index(before));
            }
        }
    }
}

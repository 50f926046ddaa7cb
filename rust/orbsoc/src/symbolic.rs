//! Symbolic analysis of the KKT matrix: fill-reducing order, elimination tree, supernodes, and the
//! elimination walk resolved once into index lists, so that the numeric kernel only follows them.
//!
//! faer owns the ordering (AMD) and the elimination tree; nothing of it leaves this file.

use crate::error::Error;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::{amd, cholesky::simplicial};
use faer::sparse::SymbolicSparseColMatRef;

/// A square matrix's upper triangle, diagonal included, rows ascending in each column.
#[derive(Clone, Debug, Default)]
pub(crate) struct Upper {
    pub colptr: Vec<usize>,
    pub rowidx: Vec<usize>,
}

impl Upper {
    pub fn dim(&self) -> usize {
        self.colptr.len() - 1
    }

    pub fn nnz(&self) -> usize {
        self.rowidx.len()
    }

    fn faer(&self) -> SymbolicSparseColMatRef<'_, usize> {
        SymbolicSparseColMatRef::new_checked(self.dim(), self.dim(), &self.colptr, None, &self.rowidx)
    }

    /// From unordered positions; also returns where each of them went.
    pub fn from_positions(dim: usize, positions: &[(usize, usize)]) -> (Self, Vec<usize>) {
        let mut order: Vec<usize> = (0..positions.len()).collect();
        order.sort_unstable_by_key(|&k| (positions[k].1, positions[k].0));
        let mut place = vec![0; positions.len()];
        let mut upper = Self { colptr: vec![0; dim + 1], rowidx: Vec::with_capacity(positions.len()) };
        for (new, &k) in order.iter().enumerate() {
            let (row, column) = positions[k];
            place[k] = new;
            upper.rowidx.push(row);
            upper.colptr[column + 1] += 1;
        }
        for j in 0..dim {
            upper.colptr[j + 1] += upper.colptr[j];
        }
        (upper, place)
    }
}

/// A run of columns of L with one structure, stored as a dense `height × width` panel,
/// column-major; rows above the diagonal of its top square are unused.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Supernode {
    /// First column.
    pub first: usize,
    pub width: usize,
    /// Its rows, top square included, in [`Symbolic::rows`].
    pub rows: usize,
    pub height: usize,
    /// Where the panel begins among the factor's words.
    pub panel: usize,
    /// Its updates, in [`Symbolic::updates`].
    pub updates: (usize, usize),
}

/// "Subtract from this supernode what `source` contributes": rows `lo..hi` of the source are
/// columns of the target; rows `lo..` land on the target's rows [`Symbolic::relative`]`[relative..]`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Update {
    pub source: usize,
    pub lo: usize,
    pub hi: usize,
    pub relative: usize,
}

/// The elimination walk, resolved.
#[derive(Clone, Debug, Default)]
pub(crate) struct Symbolic {
    pub supernodes: Vec<Supernode>,
    /// Row indices of all supernodes.
    pub rows: Vec<u32>,
    /// Updates of all supernodes, sources ascending within each.
    pub updates: Vec<Update>,
    pub relative: Vec<u32>,
    /// Panel position of each entry of the permuted upper triangle.
    pub load: Vec<u32>,
    /// Words of all panels.
    pub panel_words: usize,
    /// Tallest panel.
    pub max_height: usize,
    /// Entries of L below the diagonal.
    pub nnz_l: usize,
    /// Multiply–subtracts of the factorisation, from the column counts of L.
    pub multiply_subtracts: usize,
}

/// Fill-reducing permutation, postordered along the elimination tree: `order[new] = old`.
pub(crate) fn fill_reducing_order(upper: &Upper) -> Result<Vec<usize>, Error> {
    let dim = upper.dim();
    let (mut order, mut inverse) = (vec![0usize; dim], vec![0usize; dim]);
    let mut memory = MemBuffer::new(amd::order_scratch::<usize>(dim, upper.nnz()));
    amd::order(&mut order, &mut inverse, upper.faer(), amd::Control::default(), MemStack::new(&mut memory))
        .map_err(|e| Error::Symbolic(format!("{e:?}")))?;
    let (permuted, _) = permute(upper, &order);
    let (parent, _) = elimination_tree(&permuted);
    Ok(postorder(&parent).into_iter().map(|k| order[k]).collect())
}

/// The upper triangle of `PKPᵀ`, and where each entry of K went.
pub(crate) fn permute(upper: &Upper, order: &[usize]) -> (Upper, Vec<usize>) {
    let mut inverse = vec![0; order.len()];
    for (new, &old) in order.iter().enumerate() {
        inverse[old] = new;
    }
    let mut positions = Vec::with_capacity(upper.nnz());
    for j in 0..upper.dim() {
        for &i in &upper.rowidx[upper.colptr[j]..upper.colptr[j + 1]] {
            let (a, b) = (inverse[i], inverse[j]);
            positions.push((a.min(b), a.max(b)));
        }
    }
    Upper::from_positions(upper.dim(), &positions)
}

fn elimination_tree(upper: &Upper) -> (Vec<isize>, Vec<usize>) {
    let dim = upper.dim();
    let (mut parent, mut counts) = (vec![0isize; dim], vec![0usize; dim]);
    let mut memory =
        MemBuffer::new(simplicial::prefactorize_symbolic_cholesky_scratch::<usize>(dim, upper.nnz()));
    simplicial::prefactorize_symbolic_cholesky(
        &mut parent,
        &mut counts,
        upper.faer(),
        MemStack::new(&mut memory),
    );
    (parent, counts)
}

/// Children before parents, each subtree contiguous.
fn postorder(parent: &[isize]) -> Vec<usize> {
    let dim = parent.len();
    let (mut first_child, mut next_sibling) = (vec![usize::MAX; dim], vec![usize::MAX; dim]);
    let mut roots = Vec::new();
    for j in (0..dim).rev() {
        match usize::try_from(parent[j]) {
            Ok(p) => {
                next_sibling[j] = first_child[p];
                first_child[p] = j;
            }
            Err(_) => roots.push(j),
        }
    }
    let mut order = Vec::with_capacity(dim);
    let mut stack = roots;
    while let Some(&j) = stack.last() {
        let child = first_child[j];
        if child == usize::MAX {
            order.push(j);
            stack.pop();
        } else {
            first_child[j] = next_sibling[child];
            stack.push(child);
        }
    }
    order
}

impl Symbolic {
    /// Analyse a matrix that is already in its final order.
    pub fn new(upper: &Upper, panels: Panels) -> Result<Self, Error> {
        let (colptr, rowidx) = columns_of_l(upper)?;
        let mut out = Self::default();
        let owner = out.find_supernodes(&colptr, &rowidx, panels);
        out.resolve_updates(&owner);
        out.locate_entries(upper, &owner);
        Ok(out)
    }

    /// Lay out the panels of the supernodes; returns the supernode that owns each column.
    fn find_supernodes(&mut self, colptr: &[usize], rowidx: &[usize], panels: Panels) -> Vec<usize> {
        let dim = colptr.len() - 1;
        for j in 0..dim {
            let below = colptr[j + 1] - colptr[j] - 1;
            self.nnz_l += below;
            self.multiply_subtracts += below * (below + 1) / 2;
        }
        let mut owner = vec![0; dim];
        for run in runs_of_columns(colptr, rowidx, panels) {
            let height = run.width + run.below.len();
            owner[run.first..run.first + run.width].fill(self.supernodes.len());
            self.supernodes.push(Supernode {
                first: run.first,
                width: run.width,
                rows: self.rows.len(),
                height,
                panel: self.panel_words,
                updates: (0, 0),
            });
            self.rows.extend((run.first..run.first + run.width).chain(run.below).map(index));
            self.panel_words += run.width * height;
            self.max_height = self.max_height.max(height);
        }
        owner
    }

    pub fn rows_of(&self, node: &Supernode) -> &[u32] {
        &self.rows[node.rows..node.rows + node.height]
    }

    fn resolve_updates(&mut self, owner: &[usize]) {
        let mut incoming: Vec<Vec<(usize, usize, usize)>> = vec![Vec::new(); self.supernodes.len()];
        for (source, node) in self.supernodes.iter().enumerate() {
            let rows = self.rows_of(node);
            let mut lo = node.width;
            while lo < rows.len() {
                let target = owner[rows[lo] as usize];
                let end = self.supernodes[target].first + self.supernodes[target].width;
                let hi = lo + rows[lo..].partition_point(|&r| (r as usize) < end);
                incoming[target].push((source, lo, hi));
                lo = hi;
            }
        }
        for (target, sources) in incoming.into_iter().enumerate() {
            let begin = self.updates.len();
            for (source, lo, hi) in sources {
                let relative = self.relative.len();
                let here = self.rows_of(&self.supernodes[target]);
                let mut k = 0;
                let landing: Vec<u32> = self.rows_of(&self.supernodes[source])[lo..]
                    .iter()
                    .map(|r| {
                        while here[k] != *r {
                            k += 1;
                        }
                        index(k)
                    })
                    .collect();
                self.relative.extend(landing);
                self.updates.push(Update { source, lo, hi, relative });
            }
            self.supernodes[target].updates = (begin, self.updates.len());
        }
    }

    fn locate_entries(&mut self, upper: &Upper, owner: &[usize]) {
        for j in 0..upper.dim() {
            for &i in &upper.rowidx[upper.colptr[j]..upper.colptr[j + 1]] {
                // Entry (i, j), i ≤ j, of the upper triangle is entry (j, i) of L's pattern.
                let node = &self.supernodes[owner[i]];
                let row = self.rows_of(node).partition_point(|&r| (r as usize) < j);
                self.load.push(index(node.panel + (i - node.first) * node.height + row));
            }
        }
    }
}

/// How columns of L are gathered into panels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Panels {
    /// Only columns of equal structure: not one operation on a stored zero.
    Exact,
    /// Also columns of similar structure, with stored zeros: more operations, on longer vectors.
    /// The bits are the same: subtracting 0·y changes nothing.
    Relaxed,
}

/// Adjacent columns that share a panel.
struct Run {
    first: usize,
    width: usize,
    /// Rows below its own columns.
    below: Vec<usize>,
    /// Entries of L among them.
    entries: usize,
}

impl Run {
    /// Take `next` in: it follows directly, and its rows contain all of this run's below it.
    fn join(&mut self, next: Self) {
        self.width += next.width;
        self.entries += next.entries;
        self.below = next.below;
    }

    /// Whether `next` is the parent of this run's last column, and joining is cheap enough.
    fn suits(&self, next: &Self, panels: Panels) -> bool {
        let follows = self.first + self.width == next.first;
        let parent = self.below.first() == Some(&next.first);
        if !follows || !parent {
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
fn runs_of_columns(colptr: &[usize], rowidx: &[usize], panels: Panels) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for j in 0..colptr.len() - 1 {
        let below = rowidx[colptr[j] + 1..colptr[j + 1]].to_vec();
        let mut run = Run { first: j, width: 1, entries: below.len() + 1, below };
        while let Some(mut before) = runs.pop() {
            if !before.suits(&run, panels) {
                runs.push(before);
                break;
            }
            before.join(run);
            run = before;
        }
        runs.push(run);
    }
    runs
}

/// Row indices of each column of L, diagonal first, ascending.
fn columns_of_l(upper: &Upper) -> Result<(Vec<usize>, Vec<usize>), Error> {
    let dim = upper.dim();
    let (mut parent, mut counts) = (vec![0isize; dim], vec![0usize; dim]);
    let mut memory =
        MemBuffer::new(simplicial::prefactorize_symbolic_cholesky_scratch::<usize>(dim, upper.nnz()));
    let tree = simplicial::prefactorize_symbolic_cholesky(
        &mut parent,
        &mut counts,
        upper.faer(),
        MemStack::new(&mut memory),
    );
    let mut memory = MemBuffer::new(simplicial::factorize_simplicial_symbolic_cholesky_scratch::<usize>(dim));
    let l = simplicial::factorize_simplicial_symbolic_cholesky(
        upper.faer(),
        tree,
        &counts,
        MemStack::new(&mut memory),
    )
    .map_err(|e| Error::Symbolic(format!("{e:?}")))?;
    Ok((l.col_ptr().to_vec(), l.row_idx().to_vec()))
}

/// Indices are stored in 32 bits; sizes were checked when the problem was made, fill here.
pub(crate) fn index(value: usize) -> u32 {
    u32::try_from(value).unwrap_or_else(|_| panic!("index {value} does not fit 32 bits"))
}

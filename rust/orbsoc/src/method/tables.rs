//! A pattern's tables as plain lists of numbers, for a program elsewhere that runs the same solve.

use crate::error::Error;
use crate::kkt::structure::{Pattern, Structure};
use crate::method::workspace::{scratch_entries, Buffer, Workspace};
use crate::problem::{Problem, Settings};
use crate::symbolic::column_blocks::Uniformity;
use crate::symbolic::factor_layout::{Supernode, Symbolic};
use crate::symbolic::indices::index;
use crate::symbolic::supernodes::{Kind, Panels};

/// The kinds of supernodes in tables, by number.
pub const SUPERNODE_KINDS: &[&str] = &["supernode", "twins", "condensed", "leaves"];

/// Everything that a solve on the exact factor layout reads of a pattern, each list with its name.
#[derive(Clone, Debug)]
pub struct PatternTables {
    /// Sizes by name.
    pub sizes: Vec<(&'static str, usize)>,
    /// Lists by name.
    pub lists: Vec<(&'static str, Vec<u32>)>,
    /// Words of each buffer, in the order of [`Buffer::ALL`].
    pub words: Vec<(&'static str, usize)>,
}

/// The tables of a problem's pattern, with the layout of [`crate::Engine::exact`].
///
/// # Errors
/// As [`crate::Engine::new`].
pub fn pattern_tables(problem: &Problem, settings: &Settings) -> Result<PatternTables, Error> {
    settings.validate()?;
    let structure = Structure::new(problem, settings.ordering, Panels::Exact)?;
    let work = Workspace::new(&structure, 0u8);
    Ok(PatternTables {
        sizes: sizes(problem, &structure),
        lists: lists(problem, &structure),
        words: Buffer::ALL.iter().map(|&buffer| (buffer.name(), work.get(buffer).len())).collect(),
    })
}

fn sizes(problem: &Problem, structure: &Structure) -> Vec<(&'static str, usize)> {
    let (kkt, symbolic) = (&structure.kkt, &structure.kkt.symbolic);
    vec![
        ("n", structure.n),
        ("p", structure.p),
        ("m", structure.m),
        ("l", structure.cones.l),
        ("given_m", problem.m()),
        ("given_l", problem.cones().l),
        ("dim", kkt.dim),
        ("nnz_kkt", kkt.nnz()),
        ("nnz_l", symbolic.nnz_l),
        ("panel_entries", symbolic.panel_entries),
        ("substitution_scratch", symbolic.substitution_scratch),
        ("scratch", scratch_entries(structure)),
        ("multiply_subtracts", symbolic.multiply_subtracts),
    ]
}

fn lists(problem: &Problem, structure: &Structure) -> Vec<(&'static str, Vec<u32>)> {
    let kkt = &structure.kkt;
    let mut lists = vec![
        ("cone_dims", structure.cones.soc.iter().map(|cone| index(cone.dim)).collect()),
        ("given_cone_dims", problem.cones().q.iter().map(|&dim| index(dim)).collect()),
        ("row_origin", structure.reduced.row_origin.iter().map(|&row| index(row)).collect()),
        ("g_origin", structure.reduced.g_origin.iter().map(|&entry| index(entry)).collect()),
        ("kkt_colptr", kkt.colptr.clone()),
        ("kkt_rowidx", kkt.rowidx.clone()),
        ("kkt_contiguous", contiguous(structure)),
        ("position", kkt.position.clone()),
        ("positive", kkt.positive.iter().map(|&positive| u32::from(positive)).collect()),
        ("from_p", kkt.from_p.clone()),
        ("from_a", kkt.from_a.clone()),
        ("from_g", kkt.from_g.clone()),
        ("orthant", kkt.orthant.clone()),
        ("soc", kkt.soc.concat()),
    ];
    for (names, pattern) in [
        (["p_colptr", "p_rowidx"], &structure.cost),
        (["a_colptr", "a_rowidx"], &structure.equality),
        (["g_colptr", "g_rowidx"], &structure.conic),
        (["given_g_colptr", "given_g_rowidx"], &Pattern::new(problem.g())),
    ] {
        let (colptr, rowidx) = pattern.lists();
        lists.push((names[0], colptr.to_vec()));
        lists.push((names[1], rowidx.to_vec()));
    }
    factor_lists(&kkt.symbolic, &mut lists);
    lists
}

/// First column and end of each block of columns whose products are summed as one.
fn contiguous(structure: &Structure) -> Vec<u32> {
    let blocks = structure.kkt.column_blocks.iter();
    let dense = blocks.filter(|block| block.uniformity == Uniformity::Contiguous);
    dense.flat_map(|block| [index(block.columns.start), index(block.columns.end)]).collect()
}

fn factor_lists(symbolic: &Symbolic, lists: &mut Vec<(&'static str, Vec<u32>)>) {
    let each =
        |of: &dyn Fn(&Supernode) -> usize| symbolic.supernodes.iter().map(|node| index(of(node))).collect();
    lists.push(("node_kind", each(&|node| kind_number(node.kind))));
    lists.push(("node_width", each(&|node| node.width)));
    lists.push(("node_diagonal", each(&|node| node.diagonal_size)));
    lists.push(("node_leading", each(&|node| node.leading_dim)));
    lists.push(("node_updates", each(&|node| node.updates.1 - node.updates.0)));
    lists.push(("node_scattered", each(&|node| usize::from(node.scatter_range.is_some()))));
    let concat = |of: &dyn Fn(&Supernode) -> Vec<u32>| symbolic.supernodes.iter().flat_map(of).collect();
    lists.push(("rows", concat(&|node| symbolic.relative_rows(node).to_vec())));
    lists.push(("scatter", concat(&|node| symbolic.scatter_indices(node).to_vec())));
    let condensed = |node: &Supernode| node.kind == Kind::Condensed;
    lists.push((
        "gather",
        concat(&|node| if condensed(node) { symbolic.gather_indices(node).to_vec() } else { Vec::new() }),
    ));
    let updates = || symbolic.updates.iter();
    lists.push(("update_target", updates().map(|update| index(update.target)).collect()));
    lists.push(("update_lo", updates().map(|update| index(update.lo)).collect()));
    lists.push(("update_hi", updates().map(|update| index(update.hi)).collect()));
    lists.push(("relative", symbolic.relative.clone()));
    let runs = || symbolic.entry_runs.iter();
    lists.push(("run_value", runs().map(|run| index(run.values)).collect()));
    lists.push(("run_length", runs().map(|run| index(run.targets.len())).collect()));
    lists.push(("entry_targets", symbolic.entry_targets.clone()));
}

fn kind_number(kind: Kind) -> usize {
    match kind {
        Kind::Supernode => 0,
        Kind::IndependentTwins => 1,
        Kind::Condensed => 2,
        // Exact panels have no simplicial columns.
        Kind::Leaves | Kind::Simplicial => 3,
    }
}

//! Every error, produced by the misuse that it names (where a test can afford it), and its words.

use orbsoc::{check_convex, BatchSolver, Cones, Csc, Engine, Error, Problem, Settings};

fn orthant(l: usize) -> Cones {
    Cones { l, q: vec![] }
}

fn says<T: core::fmt::Debug>(result: Result<T, Error>, message: &str) {
    assert_eq!(result.unwrap_err().to_string(), message);
}

/// min c₀x₀ + c₁x₁ with x ≥ 0, which is right, for others to spoil.
fn build(c: &[f64], g: Csc, h: &[f64], cones: Cones) -> Result<Problem, Error> {
    Problem::new(None, c.to_vec(), None, vec![], Some(g), h.to_vec(), cones)
}

fn identity() -> Csc {
    Csc::from_dense(&[&[-1.0, 0.0], &[0.0, -1.0]], 2)
}

#[test]
fn empty() {
    says(
        Problem::new(None, vec![], None, vec![], None, vec![], Cones::default()),
        "the problem has no variables: `c` is empty",
    );
}

#[test]
fn dimension_names_the_argument_and_both_sizes() {
    let c = vec![1.0, 1.0];
    says(build(&c, identity(), &[0.0; 3], orthant(2)), "`h` has 3 entries, but the number of rows of G is 2");
    says(
        build(&c, identity(), &[0.0; 2], Cones { l: 1, q: vec![3] }),
        "`cones` has 4 rows, but the number of rows of G is 2",
    );
    says(build(&[1.0; 3], identity(), &[0.0; 2], orthant(2)), "`G` has 2 columns, but `c` has 3");
    let problem = |p, a, b| Problem::new(p, vec![1.0, 1.0], a, b, None, vec![], Cones::default());
    says(problem(None, Some(identity()), vec![1.0]), "`b` has 1 entries, but the number of rows of A is 2");
    says(problem(None, Some(Csc::zeros(1, 3)), vec![1.0]), "`A` has 3 columns, but `c` has 2");
    says(problem(Some(Csc::zeros(3, 2)), None, vec![]), "`P` has 3 rows, but `c` has 2");
    says(Csc::zeros(3, 2).upper_triangle("P"), "`P` has 3 rows, but its number of columns is 2");
}

#[test]
fn sparse_names_the_matrix_and_the_place() {
    let new = |colptr: &[usize], rowidx: &[usize], values: usize| {
        Csc::new("A", (2, 2), colptr.to_vec(), rowidx.to_vec(), vec![1.0; values])
    };
    says(new(&[0, 1], &[0], 1), "`A`: column pointer has 2 entries, but 2 columns need one more");
    says(new(&[0, 1, 2], &[0, 1], 1), "`A`: 2 row indices, but 1 values");
    let ascending = "`A`: column pointer must ascend from 0 to the number of entries";
    says(new(&[1, 1, 2], &[0, 1], 2), ascending);
    says(new(&[0, 1, 1], &[0, 1], 2), ascending);
    says(new(&[0, 2, 1], &[0], 1), ascending);
    says(new(&[0, 0, 2], &[1, 0], 2), "`A`: row indices of column 1 are unsorted or repeated");
    says(new(&[0, 2, 2], &[1, 1], 2), "`A`: row indices of column 0 are unsorted or repeated");
    says(new(&[0, 0, 1], &[2], 1), "`A`: row index 2 in column 1, but there are 2 rows");
    let lower = Csc::from_dense(&[&[1.0, 0.0], &[1.0, 1.0]], 2);
    says(
        Problem::new(Some(lower), vec![1.0, 1.0], None, vec![], None, vec![], Cones::default()),
        "`P`: entry (1, 0) lies below the diagonal; give the upper triangle",
    );
}

#[test]
fn value_names_the_entry_and_the_number() {
    let c = [1.0, 1.0];
    let only = "only finite numbers are allowed there";
    says(
        build(&[1.0, f64::NAN], identity(), &[0.0; 2], orthant(2)),
        &format!("`c` has NaN at entry 1: {only}"),
    );
    says(
        build(&c, identity(), &[0.0, f64::NEG_INFINITY], orthant(2)),
        &format!("`h` has -inf at entry 1: {only}"),
    );
    // +∞ in h means "no row", which a cone cannot do without.
    assert!(build(&c, identity(), &[f64::INFINITY, 0.0], orthant(2)).is_ok());
    says(
        build(&c, identity(), &[f64::INFINITY, 0.0], Cones { l: 0, q: vec![2] }),
        &format!("`h` has inf at entry 0: {only}"),
    );
    let equality = |b| Problem::new(None, vec![1.0; 2], Some(identity()), b, None, vec![], Cones::default());
    says(equality(vec![0.0, f64::INFINITY]), &format!("`b` has inf at entry 1: {only}"));
    let entry = Csc::new("G", (1, 1), vec![0, 1], vec![0], vec![f64::NAN]);
    says(entry, &format!("`G` has NaN at entry 0: {only}"));
}

#[test]
fn a_batch_names_the_problem() {
    let base = build(&[1.0; 2], identity(), &[0.0; 2], orthant(2)).unwrap();
    let mut solver = BatchSolver::new(&base, &Settings::default(), 1).unwrap();
    let numbers = |k: usize| [1.0, if k == 20 { f64::NAN } else { 1.0 }];
    says(
        solver.solve(37, |k, problem| problem.set_c(&numbers(k))),
        "problem 20 of the batch: `c` has NaN at entry 1: only finite numbers are allowed there",
    );
    assert!(solver.solve(7, |k, problem| problem.set_c(&numbers(k))).is_ok());
}

#[test]
fn empty_cone_names_the_cone() {
    says(
        build(&[1.0; 2], identity(), &[0.0; 2], Cones { l: 0, q: vec![2, 0] }),
        "second-order cone 1 has dimension 0; the smallest has 1",
    );
}

#[test]
fn setting_names_the_setting_its_value_and_what_is_allowed() {
    let problem = build(&[1.0; 2], identity(), &[0.0; 2], orthant(2)).unwrap();
    let refused = |change: fn(&mut Settings), message: &str| {
        let mut settings = Settings::default();
        change(&mut settings);
        says(Engine::<f64>::new(&problem, &settings), message);
    };
    let positive = "allowed is a positive, finite number";
    refused(|s| s.tol = 0.0, &format!("setting `tol` = 0: {positive}"));
    refused(|s| s.tol = f64::NAN, &format!("setting `tol` = NaN: {positive}"));
    refused(|s| s.tol = f64::INFINITY, &format!("setting `tol` = inf: {positive}"));
    refused(|s| s.tol_inaccurate = -1.0, &format!("setting `tol_inaccurate` = -1: {positive}"));
    refused(|s| s.max_time_s = 0.0, "setting `max_time_s` = 0: allowed is a positive number");
    refused(|s| s.max_time_s = f64::NAN, "setting `max_time_s` = NaN: allowed is a positive number");
    refused(|s| s.max_iterations = 0, "setting `max_iterations` = 0: allowed is 1 to 100000");
    refused(|s| s.ruiz_passes = 101, "setting `ruiz_passes` = 101: allowed is 0 to 100");
    refused(|s| s.max_restarts = 101, "setting `max_restarts` = 101: allowed is 0 to 100");
    refused(|s| s.static_regularization = 0.0, &format!("setting `static_regularization` = 0: {positive}"));
    refused(|s| s.pivot_floor = -1.0, &format!("setting `pivot_floor` = -1: {positive}"));
    refused(|s| s.dynamic_regularization = 0.0, &format!("setting `dynamic_regularization` = 0: {positive}"));
    refused(|s| s.refinement_tol = 0.0, &format!("setting `refinement_tol` = 0: {positive}"));
    refused(|s| s.refinement_share = 0.0, &format!("setting `refinement_share` = 0: {positive}"));
    let open = "allowed is between 0 and 1, both excluded";
    refused(|s| s.step_fraction = 1.0, &format!("setting `step_fraction` = 1: {open}"));
    refused(|s| s.step_fraction = f64::NAN, &format!("setting `step_fraction` = NaN: {open}"));
}

#[test]
fn pattern_changed_names_the_matrix() {
    let data = |corner: f64, cone: bool, bound: f64| {
        let square = |v: f64| Csc::from_dense(&[&[1.0, 0.0], &[0.0, v]], 2);
        let cones = if cone { Cones { l: 0, q: vec![2] } } else { orthant(2) };
        (square(corner), cones, vec![bound, 1.0])
    };
    let problem = |p: Csc, a: Csc, (g, cones, h): (Csc, Cones, Vec<f64>)| {
        Problem::new(Some(p), vec![1.0; 2], Some(a), vec![1.0; 2], Some(g), h, cones).unwrap()
    };
    let (full, half) = (|| data(1.0, false, 1.0).0, || data(0.0, false, 1.0).0);
    let given = problem(full(), full(), data(1.0, false, 1.0));
    let mut engine = Engine::<f64>::new(&given, &Settings::default()).unwrap();
    let others = [
        ("P", problem(half(), full(), data(1.0, false, 1.0))),
        ("A", problem(full(), half(), data(1.0, false, 1.0))),
        ("G", problem(full(), full(), data(0.0, false, 1.0))),
        ("cones", problem(full(), full(), data(1.0, true, 1.0))),
    ];
    for (argument, other) in others {
        let expected = format!(
            "`{argument}` does not have the sparsity pattern of the problem this engine was set up for"
        );
        says(engine.update(&other), &expected);
    }
    let absent = problem(full(), full(), data(1.0, false, f64::INFINITY));
    let expected = "`h` is +∞ in other rows than the problem this engine was set up for; absent rows stay so";
    says(engine.update(&absent), expected);
    assert_eq!(engine.update(&given), Ok(()));
}

/// Neither can be produced here: one needs a billion entries, the other an exhausted memory.
#[test]
fn sizes_and_patterns_out_of_reach_are_named() {
    says::<()>(
        Err(Error::TooLarge { what: "P", size: 5_000_000_000 }),
        "P has 5000000000 entries, more than 32-bit indices can address",
    );
    says::<()>(Err(Error::Symbolic("OutOfMemory".into())), "symbolic analysis failed: OutOfMemory");
}

#[test]
fn sizes_that_would_overflow_are_refused_not_wrapped() {
    // Wraps to 2, the number of rows, in unchecked arithmetic.
    let cones = Cones { l: 0, q: vec![usize::MAX, 1, 2] };
    says(
        build(&[1.0; 2], identity(), &[0.0; 2], cones),
        "`cones` has 18446744073709551615 rows, but the number of rows of G is 2",
    );
    says(
        Csc::new("A", (1, usize::MAX), vec![], vec![], vec![]),
        "`A`: column pointer has 0 entries, but 18446744073709551615 columns need one more",
    );
    // The events of a solve are allocated in advance.
    let problem = build(&[1.0; 2], identity(), &[0.0; 2], orthant(2)).unwrap();
    let refused = |settings: Settings, message| says(Engine::<f64>::new(&problem, &settings), message);
    refused(
        Settings { max_iterations: u32::MAX, ..Settings::default() },
        "setting `max_iterations` = 4294967295: allowed is 1 to 100000",
    );
    refused(
        Settings { refinement_max: u32::MAX, ..Settings::default() },
        "setting `refinement_max` = 4294967295: allowed is 0 to 100",
    );
}

#[test]
fn a_cost_matrix_must_be_square() {
    for (rows, columns, named) in
        [(2, 1, "1 columns"), (1, 2, "1 rows"), (2, 3, "3 columns"), (0, 0, "0 rows")]
    {
        let cost = Csc::zeros(rows, columns);
        let result = Problem::new(Some(cost), vec![1.0; 2], None, vec![], None, vec![], Cones::default());
        says(result, &format!("`P` has {named}, but `c` has 2"));
    }
}

#[test]
fn not_convex() {
    let cost = |off: f64| Csc::from_dense(&[&[1.0, off], &[0.0, 1.0]], 2);
    let make = |off| {
        Problem::new(Some(cost(off)), vec![1.0; 2], None, vec![], Some(identity()), vec![0.0; 2], orthant(2))
    };
    let message = "`P` is not positive semidefinite: P[0, 1] is -2.0, P[0, 0] is 1.0 and P[1, 1] is 1.0";
    says(make(-2.0), message);
    let mut problem = make(-1.0).unwrap();
    let before = problem.clone();
    says(problem.set_p_values(&[1.0, -2.0, 1.0]), message);
    assert_eq!(problem, before, "refused entries leave the old ones");
    assert_eq!(problem.trust_p_values(&[1.0, -2.0, 1.0]), Ok(()), "the caller's word");
    assert_eq!(problem.set_p_values(&[1.0, 0.5, 1.0]), Ok(()));

    let whole = Csc::from_dense(&[&[1.0, -2.0], &[-2.0, 1.0]], 2);
    says(check_convex(&whole), message);
    assert_eq!(check_convex(&cost(-1.0)), Ok(()));
    says(
        check_convex(&Csc::from_dense(&[&[1.0], &[2.0]], 1)),
        "`P` has 2 rows, but its number of columns is 1",
    );

    let write = |k: usize, problem: &mut Problem| problem.set_p_values(&[1.0, -0.9 * k as f64, 1.0]);
    says(
        BatchSolver::new(&before, &Settings::default(), 1).unwrap().solve(3, write),
        "problem 2 of the batch: `P` is not positive semidefinite: \
         P[0, 1] is -1.8, P[0, 0] is 1.0 and P[1, 1] is 1.0",
    );
}

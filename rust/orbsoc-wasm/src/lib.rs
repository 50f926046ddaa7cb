//! The solver for a page: the host writes one problem into two arrays, calls [`solve`], and reads one array of numbers.
//!
//! | array | in its order |
//! |---|---|
//! | integers | n, p, m, l, number of cones k, entries of P, A, G; q (k); then column pointers (n + 1) and row indices of P, A, G |
//! | numbers | entries of P, c, entries of A, b, entries of G, h |
//! | answer | x (n), y (p), z (m), s (m), objective, iterations, worst residual |
//!
//! P is whole, as in problem files (schema `orbsoc.problem/1`). Settings are the defaults.

use orbsoc::{Cones, Csc, Error, Problem, Settings};
use std::sync::{Mutex, MutexGuard, PoisonError};

#[derive(Default)]
struct Exchange {
    integers: Vec<u32>,
    numbers: Vec<f64>,
    answer: Vec<f64>,
    text: String,
}

static EXCHANGE: Mutex<Exchange> = Mutex::new(Exchange {
    integers: Vec::new(),
    numbers: Vec::new(),
    answer: Vec::new(),
    text: String::new(),
});

fn exchange() -> MutexGuard<'static, Exchange> {
    EXCHANGE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Room for `len` integers, to be written before [`solve`].
#[no_mangle]
pub extern "C" fn integers(len: usize) -> *mut u32 {
    let mut exchange = exchange();
    exchange.integers = vec![0; len];
    exchange.integers.as_mut_ptr()
}

/// Room for `len` numbers, to be written before [`solve`].
#[no_mangle]
pub extern "C" fn numbers(len: usize) -> *mut f64 {
    let mut exchange = exchange();
    exchange.numbers = vec![0.0; len];
    exchange.numbers.as_mut_ptr()
}

/// Solve what was written: the length of the answer, or 0 where [`text`] says what is wrong with the problem.
#[no_mangle]
pub extern "C" fn solve() -> usize {
    let mut exchange = exchange();
    let solved = read(&exchange.integers, &exchange.numbers)
        .and_then(|problem| orbsoc::solve(&problem, &Settings::default()).map_err(|e: Error| e.to_string()));
    (exchange.answer, exchange.text) = match solved {
        Ok(solution) => {
            let ends = [solution.objective, f64::from(solution.iterations), solution.certificate.worst()];
            let answer = [&solution.x[..], &solution.y, &solution.z, &solution.s, &ends].concat();
            (answer, solution.status.name().to_owned())
        }
        Err(reason) => (Vec::new(), reason),
    };
    exchange.answer.len()
}

/// The answer of the last [`solve`].
#[no_mangle]
pub extern "C" fn answer() -> *const f64 {
    exchange().answer.as_ptr()
}

/// UTF-8 text of the last [`solve`]: the name of the status, or what is wrong.
#[no_mangle]
pub extern "C" fn text() -> *const u8 {
    exchange().text.as_ptr()
}

/// Bytes of [`text`].
#[no_mangle]
pub extern "C" fn text_length() -> usize {
    exchange().text.len()
}

fn read(integers: &[u32], numbers: &[f64]) -> Result<Problem, String> {
    let integers: Vec<usize> = integers.iter().map(|&value| value as usize).collect();
    let (mut integers, mut numbers) = (&integers[..], numbers);
    let &[n, p, m, l, k, ref entries @ ..] = take(&mut integers, 8)? else {
        unreachable!("eight were taken")
    };
    let q = take(&mut integers, k)?.to_vec();
    let mut matrix = |name, rows, entries| -> Result<(Csc, Vec<f64>), String> {
        let columns = take(&mut integers, n + 1)?.to_vec();
        let indices = take(&mut integers, entries)?.to_vec();
        let values = take(&mut numbers, entries)?.to_vec();
        let vector = take(&mut numbers, rows)?.to_vec();
        Ok((Csc::new(name, (rows, n), columns, indices, values).map_err(|e| e.to_string())?, vector))
    };
    let (full, c) = matrix("P", n, entries[0])?;
    let (a, b) = matrix("A", p, entries[1])?;
    let (g, h) = matrix("G", m, entries[2])?;
    let upper = full.upper_triangle("P").map_err(|e| e.to_string())?;
    Problem::new(Some(upper), c, Some(a), b, Some(g), h, Cones { l, q }).map_err(|e| e.to_string())
}

/// The next `count` entries of `rest`.
fn take<'a, T>(rest: &mut &'a [T], count: usize) -> Result<&'a [T], String> {
    let (taken, left) = rest.split_at_checked(count).ok_or("the arrays are shorter than their sizes say")?;
    *rest = left;
    Ok(taken)
}

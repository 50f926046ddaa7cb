//! One step of the explicit midpoint rule, extrapolated to step size 0. Source: Hairer, Nørsett & Wanner, Solving
//! Ordinary Differential Equations I, 2nd ed., section II.9.

/// Numbers of substeps that are extrapolated are 2, 4, …, 2 × this; the error of a step falls with its power 2 × this + 1.
pub(crate) const COLUMNS: usize = 6;

/// `y` after a step of `h` from time `t`, and the error of the next to best extrapolation, (N,), of which the step's is less.
pub(crate) fn extrapolate<const N: usize>(
    rate: impl Fn(f64, &[f64; N]) -> [f64; N],
    t: f64,
    y: &[f64; N],
    h: f64,
) -> ([f64; N], [f64; N]) {
    let first = rate(t, y);
    let mut row = [[0.0; N]; COLUMNS];
    let mut error = [0.0; N];
    for j in 0..COLUMNS {
        let mut best = midpoint(&rate, &first, t, y, h, 2 * (j + 1));
        for (k, before) in row.iter_mut().enumerate().take(j) {
            // `before` is the extrapolation of one column less, of the row before
            let ratio = (j + 1) as f64 / (j - k) as f64;
            let weight = 1.0 / (ratio * ratio - 1.0);
            for i in 0..N {
                let step = (best[i] - before[i]) * weight;
                before[i] = best[i];
                best[i] += step;
                error[i] = step;
            }
        }
        row[j] = best;
    }
    (row[COLUMNS - 1], error)
}

/// The midpoint rule in `n` substeps, n even.
fn midpoint<const N: usize>(
    rate: &impl Fn(f64, &[f64; N]) -> [f64; N],
    first: &[f64; N],
    t: f64,
    y: &[f64; N],
    h: f64,
    n: usize,
) -> [f64; N] {
    let substep = h / n as f64;
    let mut before = *y;
    let mut now = *y;
    for i in 0..N {
        now[i] += substep * first[i];
    }
    for k in 1..n {
        let slope = rate(t + k as f64 * substep, &now);
        for i in 0..N {
            let next = before[i] + 2.0 * substep * slope[i];
            before[i] = now[i];
            now[i] = next;
        }
    }
    now
}

#[cfg(test)]
mod tests {
    use super::{extrapolate, COLUMNS};

    fn circle(_: f64, y: &[f64; 2]) -> [f64; 2] {
        [-y[1], y[0]]
    }

    #[test]
    fn a_step_is_exact_to_round_off_where_it_is_short() {
        let (found, error) = extrapolate(circle, 0.0, &[1.0, 0.0], 0.3);
        assert!((found[0] - 0.3_f64.cos()).abs() < 3e-15 && (found[1] - 0.3_f64.sin()).abs() < 3e-15);
        assert!(error.iter().all(|each| each.abs() < 1e-12));
    }

    #[test]
    fn the_error_falls_with_the_power_that_is_stated() {
        let power = i32::try_from(2 * COLUMNS + 1).unwrap();
        let off = |h: f64| {
            let (found, _) = extrapolate(circle, 0.0, &[1.0, 0.0], h);
            (found[0] - h.cos()).hypot(found[1] - h.sin())
        };
        let fall = off(3.0) / off(1.5);
        assert!((0.3..3.0).contains(&(fall / 2.0_f64.powi(power))), "{fall}");
    }

    #[test]
    fn time_is_that_of_the_substeps() {
        let (found, _) = extrapolate(|t, _: &[f64; 1]| [t * t], 2.0, &[0.0], 1.0);
        assert!((found[0] - 19.0 / 3.0).abs() < 3e-14);
    }
}

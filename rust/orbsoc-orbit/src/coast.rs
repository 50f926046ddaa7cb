//! Steps through given times. The air's density has a corner where layers meet: a step keeps to one layer, and where it
//! ends in another or passes through one, the border is located and the step ends there.

use crate::extrapolation::{extrapolate, COLUMNS};
use crate::field::{Field, Layer, Motion, Thrust};
use core::fmt;

/// What a layer's border is located to, m; at 10 m/s of climb that is 0.1 ms.
const BORDER_M: f64 = 1e-3;
/// What a turn of the height is located to, m/s.
const TURNING_M_S: f64 = 1e-3;
const TRIALS: usize = 60;
/// In air a step is short enough that the height turns once at most, s.
const LONGEST_IN_AIR_S: f64 = 400.0;
/// Of the first step, s.
const FIRST_STEP_S: f64 = 100.0;
/// Shorter steps than this end the integration, s.
const LEAST_STEP_S: f64 = 1e-6;

/// The integration ended: the motion is no orbit any more, or the numbers are none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Error {
    /// How far it came, in the caller's times.
    pub reached_s: f64,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "propagation stopped after t = {:.6} s: the step became too small", self.reached_s)
    }
}

impl std::error::Error for Error {}

/// States at the times, and the transition matrices by rows from the first time to each.
#[derive(Clone, Debug, Default)]
pub struct Coast {
    /// A state a time.
    pub states: Vec<[f64; 6]>,
    /// A matrix a time; empty where none were asked for.
    pub transitions: Vec<[f64; 36]>,
}

/// A coast through increasing times from a state at the first; `kicks`, empty or one a time, change the velocity after
/// the state of their time is told. `tolerance` is each step's error relative to distance and speed.
///
/// # Errors
/// Where no step is short enough.
pub fn coast(
    field: &Field,
    ballistic_m2_kg: f64,
    start: &[f64; 6],
    times_s: &[f64],
    kicks: &[[f64; 3]],
    tolerance: f64,
    transitions: bool,
) -> Result<Coast, Error> {
    let motion = Motion { field, ballistic_m2_kg, thrust: None };
    let mut found = Coast::default();
    if transitions {
        let mut y = [0.0; 42];
        y[..6].copy_from_slice(start);
        for k in 0..6 {
            y[6 + 7 * k] = 1.0;
        }
        through(&motion, y, times_s, kicks, tolerance, |y| {
            found.states.push(core::array::from_fn(|k| y[k]));
            found.transitions.push(core::array::from_fn(|k| y[6 + k]));
        })?;
    } else {
        through(&motion, *start, times_s, kicks, tolerance, |y| found.states.push(*y))?;
    }
    Ok(found)
}

/// The state at the end of a burn.
///
/// # Errors
/// Where no step is short enough.
pub fn burn(
    field: &Field,
    ballistic_m2_kg: f64,
    start: &[f64; 6],
    thrust: &Thrust,
    tolerance: f64,
) -> Result<[f64; 6], Error> {
    let motion = Motion { field, ballistic_m2_kg, thrust: Some(thrust) };
    let mut runner = Runner::new(&motion, start, tolerance);
    runner.advance(start, 0.0, thrust.duration_s).map_err(|reached_s| Error { reached_s })
}

fn through<const N: usize>(
    motion: &Motion<'_>,
    mut y: [f64; N],
    times_s: &[f64],
    kicks: &[[f64; 3]],
    tolerance: f64,
    mut tell: impl FnMut(&[f64; N]),
) -> Result<(), Error> {
    let mut runner = Runner::new(motion, &y, tolerance);
    for (k, &time) in times_s.iter().enumerate() {
        if k > 0 {
            let from = times_s[k - 1];
            y = runner
                .advance(&y, 0.0, time - from)
                .map_err(|reached| Error { reached_s: from + reached })?;
        }
        tell(&y);
        if let Some(kick) = kicks.get(k) {
            for i in 0..3 {
                y[3 + i] += kick[i];
            }
        }
    }
    Ok(())
}

struct Runner<'a> {
    motion: &'a Motion<'a>,
    tolerance: f64,
    step_s: f64,
    layer: usize,
}

impl<'a> Runner<'a> {
    fn new(motion: &'a Motion<'a>, y: &[f64], tolerance: f64) -> Self {
        Self { motion, tolerance, step_s: FIRST_STEP_S, layer: motion.layer(y) }
    }

    /// From one time to a later one; the error is the time reached.
    fn advance<const N: usize>(&mut self, start: &[f64; N], from: f64, to: f64) -> Result<[f64; N], f64> {
        let (mut t, mut y) = (from, *start);
        let mut switched = false;
        while t < to {
            let last = self.step_s >= to - t;
            let mut h = if last { to - t } else { self.step_s };
            let (mut end, error) = extrapolate(|s, y| self.motion.rate(s, y, self.layer), t, &y, h);
            let ratio = (size(&error[..3]) / size(&end[..3])).max(size(&error[3..6]) / size(&end[3..6]))
                / self.tolerance;
            let good = ratio <= 1.0 && end.iter().all(|value| value.is_finite());
            let power = -1.0 / (2 * COLUMNS - 1) as f64;
            let factor = if ratio.is_finite() { (0.9 * ratio.powf(power)).clamp(0.2, 4.0) } else { 0.2 };
            if !good {
                self.step_s = h * factor.min(0.5);
                if self.step_s < LEAST_STEP_S {
                    return Err(t);
                }
                continue;
            }
            let mut whole = true;
            if self.motion.drags() && !switched {
                if let Some(cut) = self.turning(t, &y, h, &end) {
                    (h, whole) = (cut, false);
                    end = extrapolate(|s, y| self.motion.rate(s, y, self.layer), t, &y, h).0;
                }
                if let Some((border, next)) = self.crossing(&end) {
                    let above = |state: &[f64; 6]| self.motion.height(state) - border;
                    let cut = self.locate(t, &y, h, &end, BORDER_M, above).unwrap_or(0.0);
                    if cut > 0.0 {
                        y = extrapolate(|s, y| self.motion.rate(s, y, self.layer), t, &y, cut).0;
                        t += cut;
                    }
                    self.layer = next;
                    switched = cut <= 0.0; // then the whole step lies in the next layer
                    continue;
                }
            }
            switched = false;
            t = if last && whole { to } else { t + h };
            y = end;
            if whole {
                self.step_s = if last { self.step_s.max(h * factor) } else { h * factor };
                if self.motion.drags() {
                    self.step_s = self.step_s.min(LONGEST_IN_AIR_S);
                }
            }
        }
        Ok(y)
    }

    /// After how much of a step the height turns, where it may come to another layer meanwhile.
    fn turning<const N: usize>(&self, t: f64, y: &[f64; N], h: f64, end: &[f64; N]) -> Option<f64> {
        let (start, finish) = (self.motion.climb(y), self.motion.climb(end));
        let reach = start.abs().max(finish.abs()) * h;
        let height = self.motion.height(y);
        let near = |layer: &Layer| (layer.base_m - height).abs() <= reach;
        if start * finish >= 0.0 || !self.motion.field.layers.iter().any(near) {
            return None;
        }
        self.locate(t, y, h, end, TURNING_M_S, |state| self.motion.climb(state))
    }

    /// The border that a step's end lies beyond, m, and the layer there.
    fn crossing(&self, end: &[f64]) -> Option<(f64, usize)> {
        let (layers, height) = (&self.motion.field.layers, self.motion.height(end));
        if self.layer > 0 && height < layers[self.layer].base_m {
            return Some((layers[self.layer].base_m, self.layer - 1));
        }
        let above = layers.get(self.layer + 1)?;
        (height >= above.base_m).then_some((above.base_m, self.layer + 1))
    }

    /// After how much of a step `value` is 0 to within `enough`, by the Illinois rule; nothing where it is so at the start
    /// or has one sign.
    fn locate<const N: usize>(
        &self,
        t: f64,
        y: &[f64; N],
        h: f64,
        end: &[f64; N],
        enough: f64,
        value: impl Fn(&[f64; 6]) -> f64,
    ) -> Option<f64> {
        let first = |y: &[f64; N]| -> [f64; 6] { core::array::from_fn(|k| y[k]) };
        let start = first(y);
        let (mut low, mut high) = (0.0, h);
        let (mut at_low, mut at_high) = (value(&start), value(&first(end)));
        if at_low * at_high >= 0.0 || at_low.abs() <= enough {
            return None;
        }
        let mut side = 0;
        for _ in 0..TRIALS {
            let cut = (low * at_high - high * at_low) / (at_high - at_low);
            let (there, _) = extrapolate(|s, y| self.motion.rate(s, y, self.layer), t, &start, cut);
            let found = value(&there);
            if found.abs() <= enough {
                return Some(cut);
            }
            if (found > 0.0) == (at_high > 0.0) {
                (high, at_high) = (cut, found);
                at_low *= if side == 1 { 0.5 } else { 1.0 };
                side = 1;
            } else {
                (low, at_low) = (cut, found);
                at_high *= if side == -1 { 0.5 } else { 1.0 };
                side = -1;
            }
        }
        Some(high)
    }
}

fn size(vector: &[f64]) -> f64 {
    vector.iter().map(|value| value * value).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::{burn, coast};
    use crate::field::{Field, Layer, Thrust};

    const MU: f64 = 3.986e14;

    fn field(j2: f64, air: bool) -> Field {
        let low = Layer { base_m: 0.0, density_kg_m3: 1e-9, scale_m: 60e3 };
        let high = Layer { base_m: 300e3, density_kg_m3: 1e-9 * (-5.0_f64).exp(), scale_m: 50e3 };
        Field {
            mu_m3_s2: MU,
            radius_m: 6.378e6,
            j2,
            rotation_rad_s: 7.292e-5,
            flattening: 1.0 / 298.0,
            layers: if air { vec![low, high] } else { Vec::new() },
        }
    }

    /// Perigee at 250 km and apogee at 400 km, inclined.
    fn start() -> [f64; 6] {
        let (perigee, apogee) = (6.628e6, 6.778e6);
        let speed = (2.0 * MU * apogee / (perigee * (perigee + apogee))).sqrt();
        [perigee, 0.0, 0.0, 0.0, 0.8 * speed, 0.6 * speed]
    }

    #[test]
    fn an_ellipse_closes() {
        let period = core::f64::consts::TAU * (6.703e6_f64.powi(3) / MU).sqrt();
        let found =
            coast(&field(0.0, false), 0.0, &start(), &[0.0, 10.0 * period], &[], 1e-13, false).unwrap();
        for k in 0..3 {
            assert!((found.states[1][k] - start()[k]).abs() < 1e-4, "{:?}", found.states[1]);
        }
    }

    #[test]
    fn transitions_are_the_derivatives_and_do_not_change_the_states() {
        let (field, times) = (field(1.08e-3, true), [0.0, 900.0, 6000.0]);
        let with = coast(&field, 0.02, &start(), &times, &[], 1e-12, true).unwrap();
        let without = coast(&field, 0.02, &start(), &times, &[], 1e-12, false).unwrap();
        assert_eq!(with.states, without.states);
        for j in 0..6 {
            let step = if j < 3 { 10.0 } else { 0.01 };
            let ends = [1.0, -1.0].map(|side| {
                let mut moved = start();
                moved[j] += side * step;
                coast(&field, 0.02, &moved, &times, &[], 1e-13, false).unwrap().states[2]
            });
            let numeric: Vec<f64> = (0..6).map(|i| (ends[0][i] - ends[1][i]) / (2.0 * step)).collect();
            let scale = |rows: core::ops::Range<usize>| rows.map(|i| numeric[i].abs()).fold(0.0, f64::max);
            for (i, value) in numeric.iter().enumerate() {
                let size = if i < 3 { scale(0..3) } else { scale(3..6) };
                assert!((value - with.transitions[2][6 * i + j]).abs() < 3e-5 * size, "{i} {j}");
            }
        }
    }

    #[test]
    fn a_time_between_changes_little_and_a_kick_acts_after_its_time() {
        let field = field(1.08e-3, true);
        let straight = coast(&field, 0.02, &start(), &[0.0, 5000.0], &[], 1e-12, false).unwrap();
        let halved = coast(&field, 0.02, &start(), &[0.0, 2345.6, 5000.0], &[], 1e-12, false).unwrap();
        assert!((0..3).all(|k| (straight.states[1][k] - halved.states[2][k]).abs() < 1e-3));
        let kicks = [[0.0; 3], [0.0, 0.0, 2.0], [0.0; 3]];
        let kicked = coast(&field, 0.02, &start(), &[0.0, 2345.6, 5000.0], &kicks, 1e-12, false).unwrap();
        assert_eq!(kicked.states[1], halved.states[1]);
        assert!((kicked.states[2][2] - halved.states[2][2]).abs() > 100.0);
    }

    #[test]
    fn drag_takes_energy_and_a_fall_ends_with_an_error() {
        let energy = |y: &[f64; 6]| {
            let speed: f64 = y[3..].iter().map(|v| v * v).sum();
            0.5 * speed - MU / y[..3].iter().map(|r| r * r).sum::<f64>().sqrt()
        };
        let found = coast(&field(0.0, true), 0.02, &start(), &[0.0, 20000.0], &[], 1e-12, false).unwrap();
        assert!(energy(&found.states[1]) < energy(&found.states[0]) - 1.0);
        let mut down = start();
        down[4] = 0.0;
        down[5] = 0.0;
        down[3] = -100.0;
        let error = coast(&field(0.0, false), 0.0, &down, &[50.0, 20000.0], &[], 1e-12, false).unwrap_err();
        assert!(error.reached_s > 50.0 && error.reached_s < 20000.0, "{error}");
    }

    #[test]
    fn a_short_burn_gives_its_velocity_change() {
        let thrust = Thrust {
            acceleration_m_s2: 100.0,
            exhaust_m_s: 3000.0,
            pitch_rad: 0.0,
            pitch_rate_rad_s: 0.0,
            yaw_rad: core::f64::consts::FRAC_PI_2,
            duration_s: 0.1,
        };
        let found = burn(&field(0.0, false), 0.0, &start(), &thrust, 1e-12).unwrap();
        let expected = -3000.0 * (1.0 - 100.0 * 0.1 / 3000.0_f64).ln();
        let normal = -0.6 * found[4] + 0.8 * found[5];
        assert!((normal - expected).abs() < 1e-5, "{normal} {expected}");
    }
}

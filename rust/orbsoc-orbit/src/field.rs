//! Accelerations of gravity, oblateness, drag and thrust, and the Jacobian of those that a coast has.

/// Air from a height up to the next layer's: density falls by e in a scale height.
#[derive(Clone, Copy, Debug)]
pub struct Layer {
    /// Its lower border, m.
    pub base_m: f64,
    /// There, kg/m³.
    pub density_kg_m3: f64,
    /// Of its exponential, m.
    pub scale_m: f64,
}

/// The Earth and its air. Without layers there is none.
#[derive(Clone, Debug)]
pub struct Field {
    /// Gravitational parameter, m³/s².
    pub mu_m3_s2: f64,
    /// Equatorial radius, m.
    pub radius_m: f64,
    /// Second zonal harmonic, unnormalised; 0 for a sphere.
    pub j2: f64,
    /// Of the Earth and its air, rad/s.
    pub rotation_rad_s: f64,
    /// Of the ellipsoid that heights of the air count from.
    pub flattening: f64,
    /// By rising base.
    pub layers: Vec<Layer>,
}

/// Constant thrust and mass flow, steered in the vehicle's own frame (R outward, T along the motion, N).
#[derive(Clone, Copy, Debug)]
pub struct Thrust {
    /// At ignition, m/s².
    pub acceleration_m_s2: f64,
    /// Speed of the exhaust, m/s.
    pub exhaust_m_s: f64,
    /// Half-way, from T towards R, rad.
    pub pitch_rad: f64,
    /// Its rate, rad/s.
    pub pitch_rate_rad_s: f64,
    /// Towards N, rad.
    pub yaw_rad: f64,
    /// How long it burns, s.
    pub duration_s: f64,
}

/// One body in a field.
pub(crate) struct Motion<'a> {
    pub field: &'a Field,
    /// C_D A/m, m²/kg.
    pub ballistic_m2_kg: f64,
    pub thrust: Option<&'a Thrust>,
}

type Vector = [f64; 3];
type Matrix = [[f64; 3]; 3];

impl Motion<'_> {
    /// Whether it feels air.
    pub fn drags(&self) -> bool {
        self.ballistic_m2_kg > 0.0 && !self.field.layers.is_empty()
    }

    /// Of a position above the ellipsoid, m: r − R(1 − f sin²φ).
    pub fn height(&self, r: &[f64]) -> f64 {
        let square = r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
        square.sqrt() - self.field.radius_m * (1.0 - self.field.flattening * r[2] * r[2] / square)
    }

    /// Rate of the height, m/s.
    pub fn climb(&self, y: &[f64]) -> f64 {
        let radius = size(&[y[0], y[1], y[2]]);
        let outward = (y[0] * y[3] + y[1] * y[4] + y[2] * y[5]) / radius;
        let sine = y[2] / radius;
        outward + 2.0 * self.field.radius_m * self.field.flattening * sine * (y[5] - sine * outward) / radius
    }

    /// The layer that a position is in; the lowest also below its base.
    pub fn layer(&self, r: &[f64]) -> usize {
        let height = self.height(r);
        self.field.layers.iter().rposition(|layer| layer.base_m <= height).unwrap_or(0)
    }

    /// Rate of [r, v] or, with 42 entries, of [r, v, transition by rows], in the air of one layer, `s` after ignition.
    pub fn rate<const N: usize>(&self, s: f64, y: &[f64; N], layer: usize) -> [f64; N] {
        let mut found = [0.0; N];
        let mut acceleration = [0.0; 3];
        let mut by_position = [[0.0; 3]; 3];
        let mut by_velocity = [[0.0; 3]; 3];
        self.gravity(y, &mut acceleration, (N > 6).then_some(&mut by_position));
        if self.drags() {
            let jacobian = (N > 6).then_some((&mut by_position, &mut by_velocity));
            self.drag(y, &self.field.layers[layer], &mut acceleration, jacobian);
        }
        if let Some(thrust) = self.thrust {
            thrust.add(s, y, &mut acceleration);
        }
        found[..3].copy_from_slice(&y[3..6]);
        found[3..6].copy_from_slice(&acceleration);
        if N > 6 {
            let (top, bottom) = y[6..].split_at(18);
            found[6..24].copy_from_slice(bottom);
            for i in 0..3 {
                for j in 0..6 {
                    let mut sum = 0.0;
                    for k in 0..3 {
                        sum += by_position[i][k] * top[6 * k + j] + by_velocity[i][k] * bottom[6 * k + j];
                    }
                    found[24 + 6 * i + j] = sum;
                }
            }
        }
        found
    }

    /// Point mass and J₂. With ρ = z²/r² and k = (3/2) μ J₂ R²/r⁵, J₂ gives k [(5ρ − 1) r − 2 z ẑ]. Source: Vallado, 4th
    /// ed., section 8.6.
    fn gravity(&self, y: &[f64], acceleration: &mut Vector, jacobian: Option<&mut Matrix>) {
        let r = [y[0], y[1], y[2]];
        let square = dot(&r, &r);
        let pull = self.field.mu_m3_s2 / (square * square.sqrt());
        let k = 1.5 * pull * self.field.j2 * self.field.radius_m.powi(2) / square;
        let ratio = r[2] * r[2] / square;
        let pole = [0.0, 0.0, r[2]];
        for i in 0..3 {
            acceleration[i] += -pull * r[i] + k * ((5.0 * ratio - 1.0) * r[i] - 2.0 * pole[i]);
        }
        let Some(jacobian) = jacobian else { return };
        // ∇k = −5 k r/r² and ∇ρ = 2 (z ẑ − ρ r)/r²
        for i in 0..3 {
            let shape = (5.0 * ratio - 1.0) * r[i] - 2.0 * pole[i];
            for j in 0..3 {
                let unit = f64::from(u8::from(i == j));
                let up = f64::from(u8::from(i == 2 && j == 2));
                let slope = 10.0 * r[i] * (pole[j] - ratio * r[j]) / square;
                jacobian[i][j] += pull * (3.0 * r[i] * r[j] / square - unit)
                    + k * (slope + (5.0 * ratio - 1.0) * unit - 2.0 * up - 5.0 * shape * r[j] / square);
            }
        }
    }

    /// −½ ρ B |u| u with u = v − ω × r; Jacobians by position and velocity.
    fn drag(
        &self,
        y: &[f64],
        layer: &Layer,
        acceleration: &mut Vector,
        jacobian: Option<(&mut Matrix, &mut Matrix)>,
    ) {
        let (field, r) = (self.field, [y[0], y[1], y[2]]);
        let turn = field.rotation_rad_s;
        let wind = [y[3] + turn * r[1], y[4] - turn * r[0], y[5]];
        let speed = size(&wind);
        let density = layer.density_kg_m3 * ((layer.base_m - self.height(&r)) / layer.scale_m).exp();
        let half = 0.5 * self.ballistic_m2_kg * density;
        for i in 0..3 {
            acceleration[i] -= half * speed * wind[i];
        }
        let Some((by_position, by_velocity)) = jacobian else { return };
        let radius = size(&r);
        let sine = r[2] / radius;
        let lift = 2.0 * field.radius_m * field.flattening * sine / radius;
        for i in 0..3 {
            let mut row = [0.0; 3];
            for j in 0..3 {
                let unit = f64::from(u8::from(i == j));
                row[j] = -half * (speed * unit + wind[i] * wind[j] / speed.max(f64::MIN_POSITIVE));
                by_velocity[i][j] += row[j];
                // ∇height = r̂ + 2 R f sinφ (ẑ − sinφ r̂)/r; ∂density/∂height = −density/scale
                let along = r[j] / radius;
                let up = f64::from(u8::from(j == 2)) - sine * along;
                by_position[i][j] += half / layer.scale_m * speed * wind[i] * (along + lift * up);
            }
            by_position[i][0] -= row[1] * turn; // ∂u/∂r = −[ω ×]
            by_position[i][1] += row[0] * turn;
        }
    }
}

impl Thrust {
    /// Adds F/m(s) in the direction commanded `s` after ignition.
    fn add(&self, s: f64, y: &[f64], acceleration: &mut Vector) {
        let (r, v) = ([y[0], y[1], y[2]], [y[3], y[4], y[5]]);
        let normal = unit(&cross(&r, &v));
        let outward = unit(&r);
        let along = cross(&normal, &outward);
        let size = self.acceleration_m_s2 / (1.0 - self.acceleration_m_s2 * s / self.exhaust_m_s);
        let pitch = self.pitch_rad + self.pitch_rate_rad_s * (s - 0.5 * self.duration_s);
        let (sine, cosine) = self.yaw_rad.sin_cos();
        for i in 0..3 {
            let plane = pitch.cos() * along[i] + pitch.sin() * outward[i];
            acceleration[i] += size * (cosine * plane + sine * normal[i]);
        }
    }
}

fn dot(a: &Vector, b: &Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn size(a: &Vector) -> f64 {
    dot(a, a).sqrt()
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: &Vector) -> Vector {
    let length = size(a);
    a.map(|value| value / length)
}

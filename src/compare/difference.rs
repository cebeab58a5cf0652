//! What is compared, and how far apart it is.

use super::error::CompareError;
use super::file::SignalFile;
use struna_kernel::RAD_PER_DEG;

const ATTITUDE: [&str; 4] = ["q_wb_w", "q_wb_x", "q_wb_y", "q_wb_z"];

/// Unit suffixes of column names, each before those that it ends with.
const UNITS: [(&str, &str); 8] = [
    ("_rad_s", "rad/s"),
    ("_rad", "rad"),
    ("_n_m", "N m"),
    ("_m_s", "m/s"),
    ("_m", "m"),
    ("_n", "N"),
    ("_j", "J"),
    ("_s", "s"),
];

/// How far one quantity of two files is apart over their common instants.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// Name of the column, or `attitude`.
    pub name: String,
    /// Unit, from the name's suffix; empty for flags and counts.
    pub unit: &'static str,
    /// Largest magnitude. Infinite where one file knows a value and the other does not; nothing
    /// where neither knows any.
    pub largest: Option<f64>,
    /// The first instant at which it occurs, s.
    pub at_s: f64,
    /// Root mean square.
    pub rms: f64,
}

impl Difference {
    /// Name of the unit in degrees, and how many radians it has, for angles and rates.
    #[must_use]
    pub fn in_degrees(&self) -> Option<(&'static str, f64)> {
        match self.unit {
            "rad" => Some(("deg", RAD_PER_DEG)),
            "rad/s" => Some(("deg/s", RAD_PER_DEG)),
            _ => None,
        }
    }
}

/// The angle of the rotation from one attitude to another, rad, in 0 to π.
///
/// Quaternions are (w, x, y, z); q and −q are the same attitude, and the length does not matter.
/// From the arc tangent, because the arc cosine of the scalar part loses half the digits near
/// zero, and the arc sine of the vector part loses them near π.
#[must_use]
pub fn attitude_angle_rad(a: [f64; 4], b: [f64; 4]) -> f64 {
    let ([aw, ax, ay, az], [bw, bx, by, bz]) = (a, b);
    // conjugate(a)·b
    let w = aw * bw + ax * bx + ay * by + az * bz;
    let x = aw * bx - ax * bw - ay * bz + az * by;
    let y = aw * by - ay * bw - az * bx + ax * bz;
    let z = aw * bz - az * bw - ax * by + ay * bx;
    2.0 * (x * x + y * y + z * z).sqrt().atan2(w.abs())
}

/// Where a quantity stands in each of the two files.
#[derive(Debug, Clone, Copy)]
enum Places {
    Column([usize; 2]),
    Attitude([[usize; 4]; 2]),
}

/// Gathers one [`Difference`].
#[derive(Debug, Clone)]
pub(super) struct Tally {
    places: Places,
    difference: Difference,
    squares: f64,
    count: u64,
}

impl Tally {
    fn new(name: &str, unit: &'static str, places: Places) -> Self {
        let difference =
            Difference { name: name.to_owned(), unit, largest: None, at_s: 0.0, rms: 0.0 };
        Self { places, difference, squares: 0.0, count: 0 }
    }

    /// One for each quantity that both files have, in the order of `a`.
    pub(super) fn of_common(a: &SignalFile, b: &SignalFile) -> Vec<Self> {
        let attitude = attitude_places(a).zip(attitude_places(b));
        let tally = |(at, name): (usize, &String)| match attitude {
            Some((in_a, in_b)) if in_a.contains(&at) => (name == ATTITUDE[0])
                .then(|| Self::new("attitude", "rad", Places::Attitude([in_a, in_b]))),
            _ => Some(Self::new(name, unit(name), Places::Column([at, b.find(name)?]))),
        };
        a.names().iter().enumerate().skip(1).filter_map(tally).collect()
    }

    /// Takes the current rows in.
    pub(super) fn add(&mut self, a: &SignalFile, b: &SignalFile) -> Result<(), CompareError> {
        let apart = match self.places {
            Places::Column([at_a, at_b]) => {
                let known = |value: f64| (!value.is_nan()).then_some(value);
                apart(known(a.value(at_a)), known(b.value(at_b)), |a, b| (a - b).abs())
            }
            Places::Attitude([at_a, at_b]) => {
                apart(a.attitude(at_a)?, b.attitude(at_b)?, attitude_angle_rad)
            }
        };
        let Some(apart) = apart else { return Ok(()) };
        self.count += 1;
        self.squares += apart * apart;
        if self.difference.largest.is_none_or(|largest| apart > largest) {
            (self.difference.largest, self.difference.at_s) = (Some(apart), a.time_s());
        }
        Ok(())
    }

    pub(super) fn finish(mut self) -> Difference {
        self.difference.rms = (self.squares / self.count.max(1) as f64).sqrt();
        self.difference
    }
}

/// How far two values are apart; nothing when both are unknown.
fn apart<T>(a: Option<T>, b: Option<T>, distance: impl Fn(T, T) -> f64) -> Option<f64> {
    match (a, b) {
        (Some(a), Some(b)) => Some(distance(a, b)),
        (None, None) => None,
        _ => Some(f64::INFINITY),
    }
}

fn attitude_places(file: &SignalFile) -> Option<[usize; 4]> {
    let [w, x, y, z] = ATTITUDE.map(|name| file.find(name));
    Some([w?, x?, y?, z?])
}

fn unit(name: &str) -> &'static str {
    UNITS.iter().find(|(suffix, _)| name.ends_with(suffix)).map_or("", |(_, unit)| unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A turn by `angle_rad` about a slanted axis.
    fn turn(angle_rad: f64) -> [f64; 4] {
        let (sin, cos) = (0.5 * angle_rad).sin_cos();
        [cos, sin * 2.0 / 7.0, sin * 3.0 / 7.0, sin * 6.0 / 7.0]
    }

    #[test]
    fn the_angle_between_attitudes_keeps_its_digits_at_both_ends() {
        for angle_rad in [1e-12, 1e-3, 1.0, 3.0, std::f64::consts::PI - 1e-6] {
            let (a, b) = (turn(0.4), turn(0.4 + angle_rad));
            for b in [b, b.map(|c| -c), b.map(|c| 3.0 * c)] {
                let off = attitude_angle_rad(a, b) - angle_rad;
                // Components of order one carry 1e-16 each; an arc cosine would be off by 1e-8.
                assert!(off.abs() < 1e-15, "{angle_rad}: off by {off:e}");
            }
        }
    }

    /// Hamilton's product.
    fn product([aw, a @ ..]: [f64; 4], [bw, b @ ..]: [f64; 4]) -> [f64; 4] {
        let [i, j, k] = [(0, 1, 2), (1, 2, 0), (2, 0, 1)]
            .map(|(i, j, k)| aw * b[i] + bw * a[i] + a[j] * b[k] - a[k] * b[j]);
        [aw * bw - a[0] * b[0] - a[1] * b[1] - a[2] * b[2], i, j, k]
    }

    #[test]
    fn the_angle_is_that_of_the_turn_which_carries_one_attitude_to_the_other() {
        let a = product([0.8, 0.6, 0.0, 0.0], product([0.28, 0.0, 0.96, 0.0], turn(2.0)));
        for angle_rad in [1e-9, 0.3, 2.5] {
            for b in [product(a, turn(angle_rad)), product(turn(angle_rad), a)] {
                let off = attitude_angle_rad(a, b) - angle_rad;
                // Three products of numbers up to one.
                assert!(off.abs() < 4e-15, "{angle_rad}: off by {off:e}");
            }
        }
    }

    #[test]
    fn the_unit_is_what_the_name_ends_with() {
        for (name, expected) in [
            ("truth.body_rate_rad_s", "rad/s"),
            ("twist_rad", "rad"),
            ("torsion.angle_sigma_rad", "rad"),
            ("torque_n_m", "N m"),
            ("speed_m_s", "m/s"),
            ("tension_n", "N"),
            ("delay_s", "s"),
            ("over_range", ""),
        ] {
            assert_eq!(unit(name), expected, "{name}");
        }
    }
}

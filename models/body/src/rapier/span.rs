//! What lies between two grid points.

use super::{BodyRates, Node, swing_twist};
use nalgebra::{UnitQuaternion, Vector3};
use struna_kernel::{BodyMotion, SimTime};

/// The motion over one step, from the motions at both ends and the rate half-way.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span<'a> {
    pub step_s: f64,
    pub from: &'a Node,
    pub to: &'a Node,
    /// Rates at the start, half-way and at the end, in world components.
    pub omega_w_rad_s: [Vector3<f64>; 3],
}

impl Span<'_> {
    /// The motion after the fraction `x` of the step, at `time`.
    ///
    /// Attitude and spin are cubics that meet values and slopes at both ends, the rate is the
    /// parabola through its three values: the errors, of third order and above, stay below that
    /// of the grid. The twist is that of the attitude, so the two never part.
    pub(super) fn motion_at(&self, time: SimTime, x: f64) -> BodyMotion {
        let q_wb = UnitQuaternion::from_scaled_axis(self.rotation_w(x)) * self.from.state.q_wb;
        let [start, half, end] = self.omega_w_rad_s;
        let rates = BodyRates::new(
            &q_wb,
            &(start * ((1.0 - x) * (1.0 - 2.0 * x))
                + half * (4.0 * x * (1.0 - x))
                + end * (x * (2.0 * x - 1.0))),
        );
        BodyMotion {
            time,
            q_wb,
            omega_wb_b_rad_s: rates.omega_wb_b_rad_s,
            twist_rad: swing_twist::twist_near(&q_wb, self.from.twist_rad),
            twist_rate_rad_s: rates.twist_rate_rad_s,
            spin_rad: self.spin_rad(x),
        }
    }

    /// Rotation since the start of the step, as a rotation vector in world components.
    fn rotation_w(&self, x: f64) -> Vector3<f64> {
        let whole = (self.to.state.q_wb * self.from.state.q_wb.inverse()).scaled_axis();
        let [start, _, end] = self.omega_w_rad_s.map(|omega| omega * self.step_s);
        // The rate of a rotation vector is not the angular rate: to the fourth order in its angle,
        // φ′ = ω − φ×ω/2 + φ×(φ×ω)/12.
        let turned = whole.cross(&end);
        let end = end - turned * 0.5 + whole.cross(&turned) / 12.0;
        let hermite = Hermite::at(x);
        start * hermite.start_slope + whole * hermite.end + end * hermite.end_slope
    }

    fn spin_rad(&self, x: f64) -> f64 {
        let [start, _, end] = self.omega_w_rad_s;
        let slope = |node: &Node, omega: &Vector3<f64>| {
            node.state.q_wb.inverse_transform_vector(omega).z * self.step_s
        };
        let hermite = Hermite::at(x);
        self.from.spin_rad
            + hermite.start_slope * slope(self.from, &start)
            + hermite.end * (self.to.spin_rad - self.from.spin_rad)
            + hermite.end_slope * slope(self.to, &end)
    }
}

/// Weights of the cubic that starts at zero: of the slope there, of the value and slope at one.
struct Hermite {
    start_slope: f64,
    end: f64,
    end_slope: f64,
}

impl Hermite {
    fn at(x: f64) -> Self {
        let rest = 1.0 - x;
        Self {
            start_slope: x * rest * rest,
            end: x * x * (3.0 - 2.0 * x),
            end_slope: -x * x * rest,
        }
    }
}

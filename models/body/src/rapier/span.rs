//! What lies between two grid points.

use super::{BodyRates, Node, Velocities, swing_twist};
use nalgebra::{UnitQuaternion, Vector3};
use struna_kernel::{BodyMotion, SimTime};

/// The motion over one step, from the motions at both ends and the velocities half-way.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span<'a> {
    pub step_s: f64,
    pub com_b_m: Vector3<f64>,
    pub earth_rate_w_rad_s: Vector3<f64>,
    /// Spin at the start of the run.
    pub start_twist_rad: f64,
    pub from: &'a Node,
    pub to: &'a Node,
    /// At the start, half-way and at the end.
    pub velocities: [Velocities; 3],
    /// Change of the velocities over a step, centred on its start and on its end, kicks left out.
    pub changes: [Velocities; 2],
}

impl Span<'_> {
    /// The motion at the start of the step, at `time`.
    pub(super) fn start(&self, time: SimTime) -> BodyMotion {
        let (node, changes) = (self.from, &self.changes[0]);
        let turned = (node.turned_b_rad, node.earth_b_rad);
        let place = (node.state.q_wb, node.state.suspension_w_m, node.twist_rad);
        self.motion(time, place, turned, (&self.velocities[0], changes))
    }

    /// The motion after the fraction `x` of the step, at `time`.
    ///
    /// Attitude and integrals are cubics that meet values and slopes at both ends, velocities are
    /// the parabola through their three values: the errors, of third order and above, stay below
    /// that of the grid. The twist is that of the attitude, so the two never part.
    pub(super) fn motion_at(&self, time: SimTime, x: f64) -> BodyMotion {
        let q_wb = UnitQuaternion::from_scaled_axis(self.rotation_w(x)) * self.from.state.q_wb;
        let [start, half, end] = &self.velocities;
        let velocities = start.mixed((1.0 - x) * (1.0 - 2.0 * x), half, 4.0 * x * (1.0 - x)).mixed(
            1.0,
            end,
            x * (2.0 * x - 1.0),
        );
        let changes = self.changes[0].mixed(1.0 - x, &self.changes[1], x);
        let (a, b) = (&self.from.state.suspension_w_m, &self.to.state.suspension_w_m);
        let twist_rad = swing_twist::twist_near(&q_wb, self.from.twist_rad);
        let earth_b_rad = self.from.earth_b_rad.lerp(&self.to.earth_b_rad, x);
        let turned = (self.turned_b_rad(x), earth_b_rad);
        self.motion(time, (q_wb, a.lerp(b, x), twist_rad), turned, (&velocities, &changes))
    }

    fn motion(
        &self,
        time: SimTime,
        (q_wb, suspension_w_m, twist_rad): (UnitQuaternion<f64>, Vector3<f64>, f64),
        (turned_b_rad, earth_b_rad): (Vector3<f64>, Vector3<f64>),
        (velocities, changes): (&Velocities, &Velocities),
    ) -> BodyMotion {
        let rates = BodyRates::new(&q_wb, &velocities.omega_w_rad_s);
        let earth_b_rad_s = q_wb.inverse_transform_vector(&self.earth_rate_w_rad_s);
        let acceleration_w = changes.omega_w_rad_s / self.step_s;
        BodyMotion {
            time,
            q_wb,
            omega_wb_b_rad_s: rates.omega_wb_b_rad_s,
            twist_rad,
            twist_rate_rad_s: rates.twist_rate_rad_s,
            spin_rad: self.start_twist_rad + turned_b_rad.z,
            omega_ib_b_rad_s: rates.omega_wb_b_rad_s + earth_b_rad_s,
            inertial_angle_b_rad: turned_b_rad + earth_b_rad,
            // Of the components as of the vector, for a vector does not turn about itself.
            angular_acceleration_b_rad_s2: q_wb.inverse_transform_vector(&acceleration_w),
            com_position_w_m: suspension_w_m + q_wb * self.com_b_m,
            com_velocity_w_m_s: velocities.com_w_m_s,
            com_acceleration_w_m_s2: changes.com_w_m_s / self.step_s,
        }
    }

    /// Rotation since the start of the step, as a rotation vector in world components.
    fn rotation_w(&self, x: f64) -> Vector3<f64> {
        let whole = (self.to.state.q_wb * self.from.state.q_wb.inverse()).scaled_axis();
        let [start, _, end] = self.velocities.map(|v| v.omega_w_rad_s * self.step_s);
        // The rate of a rotation vector is not the angular rate: to the fourth order in its angle,
        // φ′ = ω − φ×ω/2 + φ×(φ×ω)/12.
        let turned = whole.cross(&end);
        let end = end - turned * 0.5 + whole.cross(&turned) / 12.0;
        let hermite = Hermite::at(x);
        start * hermite.start_slope + whole * hermite.end + end * hermite.end_slope
    }

    fn turned_b_rad(&self, x: f64) -> Vector3<f64> {
        let [start, _, end] = &self.velocities;
        let slope = |node: &Node, velocities: &Velocities| {
            node.state.q_wb.inverse_transform_vector(&velocities.omega_w_rad_s) * self.step_s
        };
        let hermite = Hermite::at(x);
        self.from.turned_b_rad
            + slope(self.from, start) * hermite.start_slope
            + (self.to.turned_b_rad - self.from.turned_b_rad) * hermite.end
            + slope(self.to, end) * hermite.end_slope
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

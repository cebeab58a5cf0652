//! The leap-frog walk along the step grid.

use super::engine::{Applied, Engine, EngineState};
use super::mechanics::{Response, acceleration, gyroscopic_torque, kick};
use super::span::Span;
use super::swing_twist::{is_upright, twist_near, twist_rate_rad_s, upright_min};
use super::{BodyRates, Load, Loads, Momentum, Node, RigidBody, Synchronous, Velocities};
use crate::error::{Posture, Stop, StopReason};
use crate::ode::STEPS_MAX;
use crate::{BodyError, StartState};
use nalgebra::{Vector2, Vector3};
use std::fmt;
use struna_kernel::{BodyMotion, Bound, SimTime};

/// Steps that make sense: below, single steps drown in rounding; above, none resolves a swing.
const STEP_RANGE_S: (f64, f64) = (1e-6, 0.1);
/// The rounding of the clock: instants nearer than this to the grid are on it.
const CLOCK_ROUNDING_S: f64 = 0.5e-9;

/// All that a walk remembers; the engine holds nothing that is not in the newest node.
#[derive(Debug, Clone)]
struct Memory<L> {
    /// Steps taken; time is `index * step_s`, never a running sum.
    index: u64,
    /// The last three grid points passed, the newest last.
    nodes: [Node; 3],
    /// A step before the velocities of the newest node, as if a kick since had come before. At the
    /// start equal to them, for both are those of the start.
    previous: Velocities,
    loads: L,
}

impl<L> Memory<L> {
    fn new(start: &StartState, rigid: &RigidBody, step_s: f64, loads: L) -> Self {
        let q_wb = start.attitude();
        let omega_b = Vector3::from(start.omega_wb_b_rad_s);
        let vertical_b = q_wb.inverse_transform_vector(&Vector3::z());
        let from_com_b_m = -rigid.com_b_m;
        let turning_b = omega_b.cross(&from_com_b_m);
        // Where the joint holds A during motion: rapier corrects its height to first order in the
        // rotation, and over a step the second order lifts it by this much. A start at zero would
        // open with a jerk that takes the first two steps' rates away from the motion.
        let lift_m = 0.5 * step_s * step_s * vertical_b.dot(&omega_b.cross(&turning_b));
        let state = EngineState {
            q_wb,
            suspension_w_m: Vector2::from(start.suspension_w_m).push(lift_m),
            // A keeps its height.
            com_velocity_w_m_s: Vector2::from(start.com_velocity_w_m_s)
                .push(-vertical_b.dot(&turning_b)),
            omega_w_rad_s: q_wb * omega_b,
        };
        let node = Node {
            state,
            twist_rad: start.twist_rad,
            turned_b_rad: Vector3::zeros(),
            earth_b_rad: Vector3::zeros(),
            kick: Response::default(),
        };
        Self { index: 0, nodes: [node; 3], previous: Velocities::of(&state), loads }
    }

    /// The newest grid point, with velocities extrapolated from the last two.
    fn synchronous(&self, step_s: f64) -> Synchronous {
        let [.., node] = &self.nodes;
        let ahead = |now: &Vector3<f64>, before: &Vector3<f64>| now * 1.5 - before * 0.5;
        let omega_w = ahead(&node.state.omega_w_rad_s, &self.previous.omega_w_rad_s);
        let rates = BodyRates::new(&node.state.q_wb, &omega_w);
        Synchronous {
            time_s: self.index as f64 * step_s,
            q_wb: node.state.q_wb,
            omega_wb_b_rad_s: rates.omega_wb_b_rad_s,
            com_velocity_w_m_s: ahead(&node.state.com_velocity_w_m_s, &self.previous.com_w_m_s),
            twist_rad: node.twist_rad,
            twist_rate_rad_s: rates.twist_rate_rad_s,
        }
    }

    /// Takes in the state after a step, and what a kick changed in it.
    fn remember(
        &mut self,
        state: EngineState,
        kicked: Option<Response>,
        rigid: &RigidBody,
        h: f64,
    ) {
        let [_, middle, mut newest] = self.nodes;
        self.previous = Velocities::of(&newest.state);
        if let Some(change) = kicked {
            // An extrapolation across a kick would go on with it.
            self.previous = self.previous.after(1.0, &change);
            newest.kick = change;
        }
        let (before, after) = (&newest.state.q_wb, &state.q_wb);
        // A step turns the body about its rate, which keeps its body components meanwhile.
        let omega_b = before.inverse_transform_vector(&state.omega_w_rad_s);
        let earth = [before, after].map(|q| q.inverse_transform_vector(&rigid.earth_rate_w_rad_s));
        let node = Node {
            twist_rad: twist_near(after, newest.twist_rad),
            turned_b_rad: newest.turned_b_rad + omega_b * h,
            earth_b_rad: newest.earth_b_rad + (earth[0] + earth[1]) * (0.5 * h),
            kick: Response::default(),
            state,
        };
        self.nodes = [middle, newest, node];
        self.index += 1;
    }
}

impl Synchronous {
    fn posture(&self) -> Posture {
        let (q, w) = (self.q_wb, self.omega_wb_b_rad_s);
        let (q_wb, omega_wb_b_rad_s) = ([q.w, q.i, q.j, q.k], [w.x, w.y, w.z]);
        Posture { q_wb, omega_wb_b_rad_s, twist_rad: self.twist_rad }
    }

    /// The motion stops here.
    fn stop(&self, reason: StopReason) -> Stop {
        Stop { reason, time_s: self.time_s, posture: self.posture() }
    }

    /// After a part of a kick.
    fn kicked(&self, part: f64, change: &Response) -> Self {
        let change_b_rad_s = self.q_wb.inverse_transform_vector(&change.omega_w);
        let omega_wb_b_rad_s = self.omega_wb_b_rad_s + change_b_rad_s * part;
        Self {
            omega_wb_b_rad_s,
            com_velocity_w_m_s: self.com_velocity_w_m_s + change.com_w * part,
            twist_rate_rad_s: twist_rate_rad_s(&self.q_wb, &omega_wb_b_rad_s),
            ..*self
        }
    }
}

/// A body that rapier walks along the grid `k*step_s`, under any loads.
pub(crate) struct Walk<L> {
    rigid: RigidBody,
    step_s: f64,
    start_twist_rad: f64,
    upright_min: f64,
    engine: Engine,
    memory: Memory<L>,
}

impl<L: Loads> Walk<L> {
    /// # Errors
    /// [`BodyError::Parameter`] for an impossible tensor of inertia and for a step outside 1 µs to
    /// 0.1 s.
    pub(crate) fn new(
        rigid: RigidBody,
        start: &StartState,
        step_s: f64,
        loads: L,
    ) -> Result<Self, BodyError> {
        let (min_s, max_s) = STEP_RANGE_S;
        let usable = "single steps drown in rounding below, and none resolves a swing above";
        Bound::AtLeast(min_s).check("step_s", step_s, usable)?;
        Bound::AtMost(max_s).check("step_s", step_s, usable)?;
        let memory = Memory::new(start, &rigid, step_s, loads);
        let engine = Engine::new(&rigid, step_s, &memory.nodes[2].state)?;
        let start_twist_rad = start.twist_rad;
        Ok(Self { rigid, step_s, start_twist_rad, upright_min: upright_min(), engine, memory })
    }

    pub(crate) fn loads_mut(&mut self) -> &mut L {
        &mut self.memory.loads
    }

    /// rapier's own state: pose at the last grid point computed, velocities half a step before.
    pub(super) fn newest(&self) -> &EngineState {
        &self.memory.nodes[2].state
    }

    /// The motion at `time`, which must not lie before the instant asked for last.
    ///
    /// # Errors
    /// [`BodyError::Stopped`]. The walk then stays where the call found it.
    pub(crate) fn motion_at(&mut self, time: SimTime) -> Result<BodyMotion, BodyError> {
        let (grid, rest_s) = self.grid_before(time)?;
        let on_grid = rest_s <= CLOCK_ROUNDING_S;
        // Rates at a grid point need the velocity after it, an interpolation the next as well.
        self.walk_to(grid + if on_grid { 1 } else { 2 })?;
        let span = self.span_from(grid, on_grid);
        Ok(if on_grid { span.start(time) } else { span.motion_at(time, rest_s / self.step_s) })
    }

    /// The last grid point at or before `time`, to the rounding of the clock, and what is left.
    fn grid_before(&self, time: SimTime) -> Result<(u64, f64), BodyError> {
        let time_s = time.as_s();
        let grid = ((time_s + CLOCK_ROUNDING_S) / self.step_s).floor().max(0.0);
        if grid - self.memory.index as f64 > STEPS_MAX as f64 {
            let now = self.memory.synchronous(self.step_s);
            return Err(now.stop(StopReason::TooManySteps).into());
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "at least zero, and at most STEPS_MAX above the index already reached"
        )]
        let index = grid as u64;
        Ok((index, time_s - grid * self.step_s))
    }

    /// Takes steps until `index`, all of them or none.
    fn walk_to(&mut self, index: u64) -> Result<(), BodyError> {
        if index <= self.memory.index {
            return Ok(());
        }
        let before = self.memory.clone();
        while self.memory.index < index {
            if let Err(error) = self.step() {
                self.engine = Engine::new(&self.rigid, self.step_s, &before.nodes[2].state)?;
                self.memory = before;
                return Err(error.into());
            }
        }
        Ok(())
    }

    /// The step that begins at `grid`; for a point on the grid its end may be missing.
    fn span_from(&self, grid: u64, on_grid: bool) -> Span<'_> {
        let [oldest, middle, newest] = &self.memory.nodes;
        let of = |node: &Node| Velocities::of(&node.state);
        // On the grid the newest node is at most two ahead, elsewhere exactly two.
        let (from, to) = if on_grid && self.memory.index == grid + 1 {
            (middle, newest)
        } else {
            (oldest, middle)
        };
        // The mean of before and after a kick; a step begins after it, and ends before the next.
        let start = of(from).mixed(0.5, &of(to), 0.5).after(0.5, &from.kick);
        let end = of(middle).mixed(0.5, &of(newest), 0.5).after(-0.5, &to.kick);
        Span {
            step_s: self.step_s,
            com_b_m: self.rigid.com_b_m,
            earth_rate_w_rad_s: self.rigid.earth_rate_w_rad_s,
            start_twist_rad: self.start_twist_rad,
            from,
            to,
            velocities: [start, of(to), end],
            changes: [
                of(to).mixed(1.0, &of(from), -1.0).after(-1.0, &from.kick),
                of(newest).mixed(1.0, &of(middle), -1.0).after(-1.0, &middle.kick),
            ],
        }
    }

    /// Takes a step under its load and the impulses that fall into it.
    fn step(&mut self) -> Result<(), Stop> {
        let (h, now) = (self.step_s, self.memory.synchronous(self.step_s));
        let from_s = (now.time_s - 0.5 * h).max(0.0);
        let impulse = self.memory.loads.impulse(from_s, now.time_s + 0.5 * h);
        let kicked = impulse.map(|impulse| (impulse, kick(&self.rigid, &now.q_wb, &impulse)));
        // The load of a kicked step is half of before the kick and half of after.
        let load = match &kicked {
            None => self.memory.loads.load(&now, h),
            Some((_, change)) => self.memory.loads.load(&now.kicked(0.5, change), h),
        };
        if self.memory.index == 0 {
            self.half_kick(&now, &load);
        }
        let applied = self.applied(&now, &load, kicked.as_ref());
        let Some(state) = self.engine.step(&applied) else {
            return Err(now.stop(StopReason::Diverged));
        };
        let pull_n = self.pull_n(&state, &applied);
        self.memory.remember(state, kicked.map(|(_, change)| change), &self.rigid, h);
        // A kick is no pull: the string is taken to be stiff enough to bear it either way.
        if kicked.is_none() && pull_n < 0.0 {
            return Err(now.stop(StopReason::Slack));
        }
        self.judge(&now)
    }

    /// At the start: sets the velocities back to half a step before it.
    fn half_kick(&mut self, now: &Synchronous, load: &Load) {
        let rate = acceleration(&self.rigid, now, load);
        let half = self.memory.previous.after(-0.5 * self.step_s, &rate);
        let state = &mut self.memory.nodes[2].state;
        (state.omega_w_rad_s, state.com_velocity_w_m_s) = (half.omega_w_rad_s, half.com_w_m_s);
        self.engine.set_velocities(state);
    }

    /// What rapier is told to hold over the step.
    fn applied(
        &self,
        now: &Synchronous,
        load: &Load,
        kicked: Option<&(Momentum, Response)>,
    ) -> Applied {
        let mut torque_b_n_m =
            load.torque_b_n_m - gyroscopic_torque(&self.rigid, &now.omega_wb_b_rad_s);
        let mut force_w_n = load.force_w_n;
        if let Some((impulse, change)) = kicked {
            // The gyroscopic torque is no line between before and after, so take both.
            let [before, after] = [0.0, 1.0]
                .map(|part| now.kicked(part, change).omega_wb_b_rad_s)
                .map(|omega| gyroscopic_torque(&self.rigid, &omega));
            torque_b_n_m += (before - after) * 0.5 + impulse.angular_b_n_m_s / self.step_s;
            force_w_n += impulse.linear_w_n_s / self.step_s;
        }
        let torque_w_n_m = now.q_wb * torque_b_n_m;
        Applied { torque_w_n_m, force_w_n, gravity_m_s2: load.gravity_m_s2 }
    }

    /// Mean pull of the string over the step that leads to `state`, N.
    fn pull_n(&self, state: &EngineState, applied: &Applied) -> f64 {
        let rise = state.com_velocity_w_m_s.z - self.newest().com_velocity_w_m_s.z;
        self.rigid.mass_kg * (rise / self.step_s + applied.gravity_m_s2) - applied.force_w_n.z
    }

    /// Judges the newest node, which the step from `before` produced.
    fn judge(&self, before: &Synchronous) -> Result<(), Stop> {
        let now = self.memory.synchronous(self.step_s);
        let Posture { q_wb, omega_wb_b_rad_s, twist_rad } = now.posture();
        let finite = q_wb.iter().chain(&omega_wb_b_rad_s).all(|value| value.is_finite());
        if !(finite
            && twist_rad.is_finite()
            && now.com_velocity_w_m_s.iter().all(|v| v.is_finite()))
        {
            return Err(before.stop(StopReason::Diverged));
        }
        if !is_upright(&now.q_wb, self.upright_min) {
            return Err(now.stop(StopReason::Overturned));
        }
        Ok(())
    }
}

impl<L: Clone> Clone for Walk<L> {
    fn clone(&self) -> Self {
        let engine = Engine::new(&self.rigid, self.step_s, &self.memory.nodes[2].state)
            .expect("the same body made an engine before");
        let memory = self.memory.clone();
        Self {
            rigid: self.rigid,
            step_s: self.step_s,
            start_twist_rad: self.start_twist_rad,
            upright_min: self.upright_min,
            engine,
            memory,
        }
    }
}

impl<L: fmt::Debug> fmt::Debug for Walk<L> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The engine is left out: pages of empty sets, and nothing that the memory does not say.
        f.debug_struct("Walk")
            .field("rigid", &self.rigid)
            .field("step_s", &self.step_s)
            .field("memory", &self.memory)
            .finish_non_exhaustive()
    }
}

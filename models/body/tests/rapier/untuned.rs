//! rapier driven as its manual suggests, a switch at a time: what the checks must catch.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rapier3d_f64::prelude::{
    BroadPhaseBvh, CCDSolver, ColliderSet, GenericJointBuilder, ImpulseJointSet,
    IntegrationParameters, IslandManager, JointAxesMask, MassProperties, MultibodyJointSet,
    NarrowPhase, PhysicsPipeline, Pose, RigidBodyBuilder, RigidBodyHandle, RigidBodySet, Rotation,
    SoftBodySet, Vector,
};
use std::f64::consts::TAU;
use struna_body::ode::Rhs;
use struna_body::{Body, BodyEquations, StartState, reference};

/// Who adds the torque −ω×Jω.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Gyroscopic {
    Extrapolated,
    Rapiers,
    Nobodys,
}

/// What keeps the suspension point at its height.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Joint {
    Impulse,
    Multibody,
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Drive {
    pub(crate) substeps: usize,
    pub(crate) relaxations: usize,
    pub(crate) half_kick: bool,
    pub(crate) gyroscopic: Gyroscopic,
    pub(crate) joint: Joint,
}

impl Drive {
    /// How the library drives it: passes every check.
    pub(crate) const TUNED: Self = Self {
        substeps: 1,
        relaxations: 0,
        half_kick: true,
        gyroscopic: Gyroscopic::Extrapolated,
        joint: Joint::Impulse,
    };
    /// rapier's defaults.
    pub(crate) const DEFAULT: Self = Self {
        substeps: 4,
        relaxations: 1,
        half_kick: false,
        gyroscopic: Gyroscopic::Rapiers,
        joint: Joint::Impulse,
    };
}

/// The reference body in rapier's hands.
pub(crate) struct Untuned {
    drive: Drive,
    parameters: IntegrationParameters,
    pipeline: PhysicsPipeline,
    islands: IslandManager,
    broad_phase: BroadPhaseBvh,
    narrow_phase: NarrowPhase,
    bodies: RigidBodySet,
    colliders: ColliderSet,
    impulse_joints: ImpulseJointSet,
    multibody_joints: MultibodyJointSet,
    soft_bodies: SoftBodySet,
    ccd_solver: CCDSolver,
    body: RigidBodyHandle,
    stiffness_n_m_rad: f64,
    twist_rad: f64,
    /// World rate a step ago.
    previous_rad_s: Vector,
}

const INERTIA: Vector = Vector::new(0.0100, 0.0110, 0.0120);

impl Untuned {
    pub(crate) fn new(start: &StartState, step_s: f64, drive: Drive) -> Self {
        let body = Body::new(&reference::PARAMS).expect("the reference body is sound");
        let (half, before) = if drive.half_kick { (0.5, 1.5) } else { (0.0, 0.0) };
        let (linvel, angvel) = velocities(&body, start, -half * step_s);
        let mut bodies = RigidBodySet::new();
        let ground = bodies.insert(RigidBodyBuilder::fixed());
        let com = Vector::new(0.0, 0.0, -reference::PARAMS.com_depth_m);
        let q = start.attitude();
        let handle = bodies.insert(
            RigidBodyBuilder::dynamic()
                .pose(Pose::from_parts(Vector::ZERO, Rotation::from_xyzw(q.i, q.j, q.k, q.w)))
                .linvel(linvel)
                .angvel(angvel)
                .additional_mass_properties(MassProperties::new(com, 1.0, INERTIA))
                .can_sleep(false)
                .gyroscopic_forces_enabled(drive.gyroscopic == Gyroscopic::Rapiers),
        );
        let height = GenericJointBuilder::new(JointAxesMask::LIN_Z);
        let (mut impulse_joints, mut multibody_joints) =
            (ImpulseJointSet::new(), MultibodyJointSet::new());
        match drive.joint {
            Joint::Impulse => drop(impulse_joints.insert(ground, handle, height, true)),
            Joint::Multibody => drop(multibody_joints.insert(ground, handle, height, true)),
        }
        Self {
            drive,
            parameters: IntegrationParameters {
                dt: step_s,
                num_solver_iterations: drive.substeps,
                num_internal_stabilization_iterations: drive.relaxations,
                ..IntegrationParameters::default()
            },
            pipeline: PhysicsPipeline::new(),
            islands: IslandManager::new(),
            broad_phase: BroadPhaseBvh::new(),
            narrow_phase: NarrowPhase::new(),
            bodies,
            colliders: ColliderSet::new(),
            impulse_joints,
            multibody_joints,
            soft_bodies: SoftBodySet::new(),
            ccd_solver: CCDSolver::new(),
            body: handle,
            stiffness_n_m_rad: body.stiffness_n_m_rad(),
            twist_rad: start.twist_rad,
            previous_rad_s: velocities(&body, start, -before * step_s).1,
        }
    }

    pub(crate) fn step(&mut self) {
        let torque = self.torque_w_n_m();
        let body = self.bodies.get_mut(self.body).expect("the body stays");
        self.previous_rad_s = body.angvel();
        body.reset_torques(true);
        body.add_torque(torque, true);
        self.pipeline.step(
            Vector::new(0.0, 0.0, -reference::PARAMS.gravity_m_s2),
            &self.parameters,
            &mut self.islands,
            &mut self.broad_phase,
            &mut self.narrow_phase,
            &mut self.bodies,
            &mut self.colliders,
            &mut self.impulse_joints,
            &mut self.multibody_joints,
            &mut self.soft_bodies,
            &mut self.ccd_solver,
            &(),
            &(),
        );
        let q = self.attitude();
        let twist_rad = 2.0 * q.k.atan2(q.w);
        self.twist_rad = twist_rad + TAU * ((self.twist_rad - twist_rad) / TAU).round();
    }

    pub(crate) fn attitude(&self) -> UnitQuaternion<f64> {
        let q = self.bodies[self.body].rotation();
        UnitQuaternion::from_quaternion(Quaternion::new(q.w, q.x, q.y, q.z))
    }

    /// The rate that rapier holds, in body components.
    pub(crate) fn raw_rate_b_rad_s(&self) -> Vector3<f64> {
        let w = self.bodies[self.body].angvel();
        self.attitude().inverse_transform_vector(&Vector3::new(w.x, w.y, w.z))
    }

    fn torque_w_n_m(&self) -> Vector {
        let body = &self.bodies[self.body];
        let rotation = *body.rotation();
        let axis = rotation * Vector::Z;
        let string =
            (axis + Vector::Z) * (-self.stiffness_n_m_rad * self.twist_rad / (1.0 + axis.z));
        if self.drive.gyroscopic != Gyroscopic::Extrapolated {
            return string;
        }
        let w = rotation.inverse() * (body.angvel() * 1.5 - self.previous_rad_s * 0.5);
        string - rotation * w.cross(INERTIA * w)
    }
}

/// Velocity of the centre of mass and world rate at `time_s` near the start, to first order.
fn velocities(body: &Body, start: &StartState, time_s: f64) -> (Vector, Vector) {
    let states = BodyEquations::states(start);
    let rate = BodyEquations::new(body, start, Vector3::zeros()).derivative(0.0, &states);
    let q = start.attitude();
    let omega = Vector3::from_column_slice(&states[3..6]);
    let slope = Vector3::from_column_slice(&rate[3..6]);
    let w = q * (omega + slope * time_s);
    let fall = |omega: &Vector3<f64>, q: &UnitQuaternion<f64>| {
        let vertical_b = q.inverse_transform_vector(&Vector3::z());
        let depth_m = reference::PARAMS.com_depth_m;
        -depth_m * (vertical_b.x * omega.y - vertical_b.y * omega.x)
    };
    let turned = UnitQuaternion::from_scaled_axis(w * time_s) * q;
    let fall_m_s = fall(&(omega + slope * time_s), &turned);
    (Vector::new(0.0, 0.0, fall_m_s), Vector::new(w.x, w.y, w.z))
}

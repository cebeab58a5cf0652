//! The border to rapier: its world of one jointed body, and its types.
//!
//! Nothing outside this file names a type of rapier or of the algebra that it is built on.

use nalgebra::{Matrix3, Quaternion, SymmetricEigen, UnitQuaternion, Vector3};
use rapier3d_f64::prelude::{
    BroadPhaseBvh, CCDSolver, ColliderSet, GenericJointBuilder, ImpulseJointSet,
    IntegrationParameters, IslandManager, JointAxesMask, MassProperties, MultibodyJointSet,
    NarrowPhase, PhysicsPipeline, Pose, RigidBodyBuilder, RigidBodyHandle, RigidBodySet, Rotation,
    SoftBodySet, Vector,
};
use struna_kernel::{Bound, ParameterError};

/// Rounds of the eigenvalue iteration on a 3×3 tensor; it takes about five.
const EIGEN_ROUNDS_MAX: usize = 200;

/// A rigid body as the mechanics sees it, hung by the origin of its axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RigidBody {
    pub mass_kg: f64,
    /// From the suspension point A to the centre of mass C, in body components.
    pub com_b_m: Vector3<f64>,
    /// About C, in body axes.
    pub inertia_b_kg_m2: Matrix3<f64>,
    /// Rate of the world, in world components: for what a gyro integrates, not for the motion.
    pub earth_rate_w_rad_s: Vector3<f64>,
}

impl RigidBody {
    /// rapier's form of the mass: moments along principal axes.
    fn mass_properties(&self) -> Result<MassProperties, ParameterError> {
        let (moments, axes) = principal(&self.inertia_b_kg_m2)?;
        let (com, moments) = (to_vector(&self.com_b_m), to_vector(&moments));
        let frame = to_rotation(&axes);
        Ok(MassProperties::with_principal_inertia_frame(com, self.mass_kg, moments, frame))
    }
}

/// Principal moments of a tensor, and the rotation from its principal axes to body axes.
///
/// Not rapier's own decomposition: it gives up on tensors below some 1e-5 kg·m² and takes any
/// axes, because it compares a fourth power of the moments with a fixed 1e-20.
pub(super) fn principal(
    inertia: &Matrix3<f64>,
) -> Result<(Vector3<f64>, UnitQuaternion<f64>), ParameterError> {
    let extent = "a body of finite size has a positive tensor of inertia";
    for entry in inertia {
        Bound::Finite.check("inertia_b_kg_m2", *entry, extent)?;
    }
    let (moments, axes) = if off_diagonal(inertia) {
        let eigen = SymmetricEigen::try_new(*inertia, f64::EPSILON, EIGEN_ROUNDS_MAX);
        let eigen = eigen.ok_or_else(|| {
            let (name, value, bound) = ("inertia_b_kg_m2", f64::NAN, Bound::Finite);
            ParameterError { name, value, bound, reason: "its principal axes cannot be found" }
        })?;
        (eigen.eigenvalues, right_handed(eigen.eigenvectors))
    } else {
        (inertia.diagonal(), UnitQuaternion::identity())
    };
    for moment in &moments {
        Bound::Above(0.0).check("inertia_b_kg_m2", *moment, extent)?;
    }
    Ok((moments, axes))
}

fn off_diagonal(m: &Matrix3<f64>) -> bool {
    [m.m12, m.m13, m.m21, m.m23, m.m31, m.m32].iter().any(|entry| *entry != 0.0)
}

/// The rotation of three orthogonal axes, one of which is turned round if they are left-handed.
fn right_handed(mut axes: Matrix3<f64>) -> UnitQuaternion<f64> {
    if axes.determinant() < 0.0 {
        axes.column_mut(2).neg_mut();
    }
    UnitQuaternion::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(axes))
}

/// What rapier integrates. Attitude and position belong to a grid point, the velocities to half a
/// step before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EngineState {
    pub q_wb: UnitQuaternion<f64>,
    /// Of the suspension point A.
    pub suspension_w_m: Vector3<f64>,
    /// Of the centre of mass C.
    pub com_velocity_w_m_s: Vector3<f64>,
    pub omega_w_rad_s: Vector3<f64>,
}

/// What is held over one step, in world components, the force at C.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Applied {
    pub torque_w_n_m: Vector3<f64>,
    pub force_w_n: Vector3<f64>,
    pub gravity_m_s2: f64,
}

/// rapier's world: a body, the ground, and the joint that keeps A at its height.
///
/// No colliders, so the collision stages find nothing to do. Everything that a step reads is in
/// [`EngineState`], for the joint keeps no impulse from one step to the next.
pub(super) struct Engine {
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
}

impl Engine {
    pub(super) fn new(
        rigid: &RigidBody,
        step_s: f64,
        state: &EngineState,
    ) -> Result<Self, ParameterError> {
        let mut bodies = RigidBodySet::new();
        // The axes of the joint are those of its first body, so the ground comes first.
        let ground = bodies.insert(RigidBodyBuilder::fixed());
        let body = bodies.insert(
            RigidBodyBuilder::dynamic()
                .pose(Pose::from_parts(to_vector(&state.suspension_w_m), to_rotation(&state.q_wb)))
                .linvel(to_vector(&state.com_velocity_w_m_s))
                .angvel(to_vector(&state.omega_w_rad_s))
                .additional_mass_properties(rigid.mass_properties()?)
                .can_sleep(false)
                .allow_fast_rotation(true)
                // Explicit and of first order; the walk adds its own, of second.
                .gyroscopic_forces_enabled(false),
        );
        let mut impulse_joints = ImpulseJointSet::new();
        let height = GenericJointBuilder::new(JointAxesMask::LIN_Z);
        impulse_joints.insert(ground, body, height, true);
        Ok(Self {
            parameters: parameters(step_s),
            pipeline: PhysicsPipeline::new(),
            islands: IslandManager::new(),
            broad_phase: BroadPhaseBvh::new(),
            narrow_phase: NarrowPhase::new(),
            bodies,
            colliders: ColliderSet::new(),
            impulse_joints,
            multibody_joints: MultibodyJointSet::new(),
            soft_bodies: SoftBodySet::new(),
            ccd_solver: CCDSolver::new(),
            body,
        })
    }

    pub(super) fn set_velocities(&mut self, state: &EngineState) {
        if let Some(body) = self.bodies.get_mut(self.body) {
            body.set_linvel(to_vector(&state.com_velocity_w_m_s), false);
            body.set_angvel(to_vector(&state.omega_w_rad_s), false);
        }
    }

    /// One step; gives the state after it, or `None` when rapier found it not finite.
    pub(super) fn step(&mut self, applied: &Applied) -> Option<EngineState> {
        let body = self.bodies.get_mut(self.body)?;
        body.reset_torques(false);
        body.reset_forces(false);
        body.add_torque(to_vector(&applied.torque_w_n_m), false);
        body.add_force(to_vector(&applied.force_w_n), false);
        self.pipeline.step(
            Vector::new(0.0, 0.0, -applied.gravity_m_s2),
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
        // rapier mends a state that is not finite, and would go on with another motion.
        self.pipeline.quarantine().is_empty().then(|| self.state()).flatten()
    }

    fn state(&self) -> Option<EngineState> {
        let body = self.bodies.get(self.body)?;
        let q = body.rotation();
        Some(EngineState {
            // rapier leaves it at unit length.
            q_wb: UnitQuaternion::new_unchecked(Quaternion::new(q.w, q.x, q.y, q.z)),
            suspension_w_m: from_vector(body.translation()),
            com_velocity_w_m_s: from_vector(body.linvel()),
            omega_w_rad_s: from_vector(body.angvel()),
        })
    }
}

/// One velocity update and one pose update a step, which is the leap-frog scheme.
fn parameters(step_s: f64) -> IntegrationParameters {
    IntegrationParameters {
        dt: step_s,
        // rapier's word for substeps: a torque held over four of them is no nearer to the truth.
        num_solver_iterations: 1,
        num_internal_pgs_iterations: 1,
        // A further pass would change the velocities after the pose has used them.
        num_internal_stabilization_iterations: 0,
        max_ccd_substeps: 0,
        warmstart_joints: false,
        normalized_max_linear_velocity: f64::MAX,
        ..IntegrationParameters::default()
    }
}

fn to_vector(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

fn from_vector(v: Vector) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

fn to_rotation(q: &UnitQuaternion<f64>) -> Rotation {
    Rotation::from_xyzw(q.i, q.j, q.k, q.w)
}

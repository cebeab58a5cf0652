//! Parameters of the body and its string, and the one place that judges them.

use crate::BodyError;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;
use struna_kernel::{Bound, ParameterError};

/// How stiff the string is in torsion.
///
/// Both forms are in use: a period can be timed, a constant follows from the wire's dimensions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TorsionStiffness {
    /// Period T of free undamped torsion of the hanging body, s; k = C·(2π/T)².
    PeriodS(f64),
    /// Constant k, N·m/rad. Zero is a string that does not resist twist.
    ConstantNMRad(f64),
}

/// How the twist is damped, by a torque −c·τ′.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TorsionDamping {
    /// Damping ratio ζ; c = 2·ζ·C·Ω with Ω = √(k/C). Needs a stiffness when above zero.
    Ratio(f64),
    /// Coefficient c, N·m·s/rad.
    CoefficientNMSRad(f64),
}

/// The string's torsion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Torsion {
    /// Restoring torque.
    pub stiffness: TorsionStiffness,
    /// Dissipation.
    pub damping: TorsionDamping,
}

/// The body on its string, SI units. Anything may be written here; [`Body::new`] judges it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyParams {
    /// Mass M, kg.
    pub mass_kg: f64,
    /// Depth d of the centre of mass below the suspension point, along the body's z axis, m.
    pub com_depth_m: f64,
    /// Where the centre of mass lies off the body's z axis, x and y, m.
    pub com_offset_m: [f64; 2],
    /// Central moments of inertia A, B, C about the body's x, y, z axes, kg·m².
    pub inertia_kg_m2: [f64; 3],
    /// Off-diagonal entries J_xy, J_xz, J_yz of the central inertia tensor, kg·m²; the products of
    /// mass and coordinates with a minus sign. Zero when the body axes are the principal axes.
    pub products_kg_m2: [f64; 3],
    /// Acceleration of gravity, m/s².
    pub gravity_m_s2: f64,
    /// Torsion of the string.
    pub torsion: Torsion,
}

/// A body whose parameters have been judged: every value finite, every moment possible.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    params: BodyParams,
    stiffness_n_m_rad: f64,
    damping_n_m_s_rad: f64,
    /// Smallest principal moment, kg·m².
    inertia_min_kg_m2: f64,
}

impl Body {
    /// Judges `params`.
    ///
    /// # Errors
    /// [`BodyError::Parameter`] with name, value, bound and reason for the first value that is
    /// NaN or infinite; for a mass, length, moment of inertia, gravity or period that is not
    /// positive; for moments, those about the principal axes included, that break the triangle
    /// inequality; for negative stiffness or damping.
    pub fn new(params: &BodyParams) -> Result<Self, BodyError> {
        let positive = Bound::Above(0.0);
        positive.check(
            "mass_kg",
            params.mass_kg,
            "a weightless body does not tension its string",
        )?;
        let depth = "the body hangs below its suspension point";
        positive.check("com_depth_m", params.com_depth_m, depth)?;
        for offset in params.com_offset_m {
            Bound::Finite.check("com_offset_m", offset, "the body has a centre")?;
        }
        let inertia_min_kg_m2 = check_inertia(params)?;
        positive.check("gravity_m_s2", params.gravity_m_s2, "nothing else tensions the string")?;
        let axial_kg_m2 = params.inertia_kg_m2[2];
        let stiffness_n_m_rad = stiffness(params.torsion.stiffness, axial_kg_m2)?;
        let damping_n_m_s_rad = damping(params.torsion.damping, axial_kg_m2, stiffness_n_m_rad)?;
        Ok(Self { params: *params, stiffness_n_m_rad, damping_n_m_s_rad, inertia_min_kg_m2 })
    }

    /// The parameters as given.
    #[must_use]
    pub fn params(&self) -> &BodyParams {
        &self.params
    }

    /// Torsion constant k of the string, N·m/rad.
    #[must_use]
    pub fn stiffness_n_m_rad(&self) -> f64 {
        self.stiffness_n_m_rad
    }

    /// Torsion damping coefficient c, N·m·s/rad.
    #[must_use]
    pub fn damping_n_m_s_rad(&self) -> f64 {
        self.damping_n_m_s_rad
    }

    /// Angular frequency Ω = √(k/C) of undamped torsion, rad/s.
    #[must_use]
    pub fn torsion_frequency_rad_s(&self) -> f64 {
        (self.stiffness_n_m_rad / self.params.inertia_kg_m2[2]).sqrt()
    }

    /// Central inertia tensor in body components, kg·m².
    #[must_use]
    pub fn inertia_b_kg_m2(&self) -> Matrix3<f64> {
        let [a, b, c] = self.params.inertia_kg_m2;
        let [xy, xz, yz] = self.params.products_kg_m2;
        Matrix3::new(a, xy, xz, xy, b, yz, xz, yz, c)
    }

    /// Smallest principal moment of inertia, kg·m².
    pub(crate) fn inertia_min_kg_m2(&self) -> f64 {
        self.inertia_min_kg_m2
    }

    /// The suspension point A as seen from the centre of mass C, body components, m.
    #[must_use]
    pub fn suspension_b_m(&self) -> Vector3<f64> {
        let [x, y] = self.params.com_offset_m;
        Vector3::new(-x, -y, self.params.com_depth_m)
    }

    /// Whether the centre of mass lies on the body's z axis and the body axes are principal.
    pub(crate) fn is_aligned(&self) -> bool {
        let off = self.params.com_offset_m.iter().chain(&self.params.products_kg_m2);
        off.copied().all(|value| value == 0.0)
    }

    /// M·g·d, N·m: the swing's restoring torque per unit sin θ.
    pub(crate) fn pendulum_torque_n_m(&self) -> f64 {
        self.params.mass_kg * self.params.gravity_m_s2 * self.params.com_depth_m
    }
}

const INERTIA_NAMES: [&str; 3] = ["inertia_a_kg_m2", "inertia_b_kg_m2", "inertia_c_kg_m2"];

/// Judges the moments about the body axes, then those about the principal axes; gives the
/// smallest of the latter.
fn check_inertia(params: &BodyParams) -> Result<f64, ParameterError> {
    let moments = params.inertia_kg_m2;
    let extent = "a body of finite size has positive moments";
    for (name, moment) in INERTIA_NAMES.iter().zip(moments) {
        Bound::Above(0.0).check(name, moment, extent)?;
    }
    check_triangle(&INERTIA_NAMES, moments)?;
    for product in params.products_kg_m2 {
        Bound::Finite.check("products_kg_m2", product, "a body of finite size has finite ones")?;
    }
    let smallest = moments.iter().fold(f64::INFINITY, |a, b| a.min(*b));
    if params.products_kg_m2.iter().all(|product| *product == 0.0) {
        return Ok(smallest);
    }
    let [a, b, c] = moments;
    let [xy, xz, yz] = params.products_kg_m2;
    let tensor = Matrix3::new(a, xy, xz, xy, b, yz, xz, yz, c);
    let principal = tensor.symmetric_eigenvalues();
    for moment in &principal {
        let reason = "with these products of inertia a principal moment is not positive";
        Bound::Above(0.0).check("principal_inertia_kg_m2", *moment, reason)?;
    }
    check_triangle(&["principal_inertia_kg_m2"; 3], principal.into())?;
    Ok(principal.min())
}

fn check_triangle(names: &[&'static str; 3], moments: [f64; 3]) -> Result<(), ParameterError> {
    let total = moments.iter().sum::<f64>();
    for (name, moment) in names.iter().zip(moments) {
        // A flat plate reaches equality, so leave room for the rounding of decimal input and of
        // the principal axes.
        let limit = (total - moment) * (1.0 + 16.0 * f64::EPSILON);
        let triangle = "no moment of a real body exceeds the sum of the other two";
        Bound::AtMost(limit).check(name, moment, triangle)?;
    }
    Ok(())
}

fn stiffness(stiffness: TorsionStiffness, axial_kg_m2: f64) -> Result<f64, ParameterError> {
    match stiffness {
        TorsionStiffness::ConstantNMRad(k) => {
            let reason = "a string never drives its twist away from equilibrium";
            Bound::AtLeast(0.0).check("stiffness_n_m_rad", k, reason)
        }
        TorsionStiffness::PeriodS(period_s) => {
            Bound::Above(0.0).check("period_s", period_s, "an oscillation takes time")?;
            let k = axial_kg_m2 * (TAU / period_s).powi(2);
            Bound::Finite.check("stiffness_n_m_rad", k, "the period asks for an infinite stiffness")
        }
    }
}

fn damping(
    damping: TorsionDamping,
    axial_kg_m2: f64,
    stiffness_n_m_rad: f64,
) -> Result<f64, ParameterError> {
    let passive = "damping takes energy away, it never adds any";
    match damping {
        TorsionDamping::CoefficientNMSRad(c) => {
            Bound::AtLeast(0.0).check("damping_n_m_s_rad", c, passive)
        }
        TorsionDamping::Ratio(ratio) => {
            Bound::AtLeast(0.0).check("damping_ratio", ratio, passive)?;
            if stiffness_n_m_rad == 0.0 {
                let reason =
                    "a string without stiffness has no critical damping to take a share of";
                Bound::AtMost(0.0).check("damping_ratio", ratio, reason)?;
            }
            let c = 2.0 * ratio * (stiffness_n_m_rad * axial_kg_m2).sqrt();
            Bound::Finite.check("damping_n_m_s_rad", c, "the ratio asks for an infinite damping")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::PARAMS;

    fn refusal(params: BodyParams) -> (&'static str, Bound) {
        match Body::new(&params) {
            Err(BodyError::Parameter(ParameterError { name, bound, reason, .. })) => {
                assert!(!reason.is_empty());
                (name, bound)
            }
            other => panic!("accepted or refused otherwise: {other:?}"),
        }
    }

    fn with_torsion(stiffness: TorsionStiffness, damping: TorsionDamping) -> BodyParams {
        BodyParams { torsion: Torsion { stiffness, damping }, ..PARAMS }
    }

    #[test]
    fn values_that_no_body_can_have_are_refused_by_name() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(refusal(BodyParams { mass_kg: bad, ..PARAMS }).0, "mass_kg");
            assert_eq!(refusal(BodyParams { com_depth_m: bad, ..PARAMS }).0, "com_depth_m");
            assert_eq!(refusal(BodyParams { gravity_m_s2: bad, ..PARAMS }).0, "gravity_m_s2");
            for (axis, name) in INERTIA_NAMES.into_iter().enumerate() {
                let mut params = PARAMS;
                params.inertia_kg_m2[axis] = bad;
                assert_eq!(refusal(params).0, name, "{bad}");
            }
            let free = TorsionDamping::CoefficientNMSRad(0.0);
            let period = with_torsion(TorsionStiffness::PeriodS(bad), free);
            assert_eq!(refusal(period).0, "period_s");
        }
    }

    #[test]
    fn a_string_that_feeds_the_twist_is_refused() {
        let k = TorsionStiffness::ConstantNMRad(2e-6);
        for bad in [-1e-9, f64::NAN, f64::INFINITY] {
            let stiffness =
                with_torsion(TorsionStiffness::ConstantNMRad(bad), TorsionDamping::Ratio(0.0));
            assert_eq!(refusal(stiffness).0, "stiffness_n_m_rad");
            let ratio = with_torsion(k, TorsionDamping::Ratio(bad));
            assert_eq!(refusal(ratio).0, "damping_ratio");
            let coefficient = with_torsion(k, TorsionDamping::CoefficientNMSRad(bad));
            assert_eq!(refusal(coefficient).0, "damping_n_m_s_rad");
        }
    }

    #[test]
    fn extreme_but_positive_torsion_is_refused_when_it_overflows() {
        let free = TorsionDamping::Ratio(0.0);
        let fast = with_torsion(TorsionStiffness::PeriodS(1e-200), free);
        assert_eq!(refusal(fast), ("stiffness_n_m_rad", Bound::Finite));
        let thick =
            with_torsion(TorsionStiffness::ConstantNMRad(1e300), TorsionDamping::Ratio(1e200));
        assert_eq!(refusal(thick), ("damping_n_m_s_rad", Bound::Finite));
        let nothing_to_share =
            with_torsion(TorsionStiffness::ConstantNMRad(0.0), TorsionDamping::Ratio(0.1));
        assert_eq!(refusal(nothing_to_share), ("damping_ratio", Bound::AtMost(0.0)));
    }

    #[test]
    fn a_moment_above_the_sum_of_the_others_is_refused_and_a_plate_is_not() {
        for axis in 0..3 {
            let mut inertia_kg_m2 = [0.01, 0.01, 0.01];
            inertia_kg_m2[axis] = 0.021;
            let (name, bound) = refusal(BodyParams { inertia_kg_m2, ..PARAMS });
            assert_eq!(name, INERTIA_NAMES[axis]);
            assert!(matches!(bound, Bound::AtMost(limit) if (limit - 0.02).abs() < 1e-12));
        }
        // In binary 0.001 + 0.009 misses 0.010 by one bit: a plate typed in decimals must pass.
        for inertia_kg_m2 in [[0.001, 0.009, 0.010], [0.010, 0.001, 0.009], [0.1, 0.2, 0.3]] {
            assert!(Body::new(&BodyParams { inertia_kg_m2, ..PARAMS }).is_ok());
        }
    }

    #[test]
    fn period_and_constant_describe_the_same_string() {
        let timed = Body::new(&PARAMS).unwrap();
        // C (2π/480)² for C = 0.012 kg m², to the digits that the test set quotes.
        assert!((timed.stiffness_n_m_rad() - 2.056e-6).abs() < 5e-10);
        let by_constant = with_torsion(
            TorsionStiffness::ConstantNMRad(timed.stiffness_n_m_rad()),
            TorsionDamping::Ratio(0.1),
        );
        let damped = Body::new(&by_constant).unwrap();
        let period_s = TAU / damped.torsion_frequency_rad_s();
        // A square root and a division away: three roundings.
        assert!((period_s / 480.0 - 1.0).abs() < 4.0 * f64::EPSILON);
        let expected = 2.0 * 0.1 * 0.012 * damped.torsion_frequency_rad_s();
        assert!((damped.damping_n_m_s_rad() / expected - 1.0).abs() < 4.0 * f64::EPSILON);
    }

    #[test]
    fn a_refusal_names_value_bound_and_reason() {
        let error = Body::new(&BodyParams { mass_kg: -1.0, ..PARAMS }).unwrap_err();
        assert_eq!(
            error.to_string(),
            "mass_kg = -1 is refused: it must be finite and above 0, because a weightless body \
             does not tension its string"
        );
    }
}

//! Units of variables.

/// A unit in the words of a model description: a name, the quantity it measures, and the SI base
/// units that make it up.
///
/// Only coherent SI units exist here, so no factor or offset: degrees are for reports.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unit {
    name: &'static str,
    quantity: &'static str,
    base: &'static [(&'static str, i8)],
}

impl Unit {
    /// No dimension.
    pub const ONE: Self = Self { name: "1", quantity: "Ratio", base: &[] };
    /// Second.
    pub const S: Self = Self { name: "s", quantity: "Time", base: &[("s", 1)] };
    /// Radian.
    pub const RAD: Self = Self { name: "rad", quantity: "Angle", base: &[("rad", 1)] };
    /// Radian per second.
    pub const RAD_S: Self =
        Self { name: "rad/s", quantity: "AngularRate", base: &[("s", -1), ("rad", 1)] };
    /// Radian squared: variance of an angle.
    pub const RAD2: Self = Self { name: "rad2", quantity: "AngleVariance", base: &[("rad", 2)] };
    /// Radian squared per second squared: variance of an angular rate.
    pub const RAD2_S2: Self =
        Self { name: "rad2/s2", quantity: "AngularRateVariance", base: &[("s", -2), ("rad", 2)] };
    /// Radian squared per second cubed: density of white angular acceleration.
    pub const RAD2_S3: Self = Self {
        name: "rad2/s3",
        quantity: "AngularAccelerationNoiseDensity",
        base: &[("s", -3), ("rad", 2)],
    };
    /// Kilogram.
    pub const KG: Self = Self { name: "kg", quantity: "Mass", base: &[("kg", 1)] };
    /// Metre.
    pub const M: Self = Self { name: "m", quantity: "Length", base: &[("m", 1)] };
    /// Kilogram times square metre: moment of inertia.
    pub const KG_M2: Self =
        Self { name: "kg.m2", quantity: "MomentOfInertia", base: &[("kg", 1), ("m", 2)] };
    /// Metre per second squared.
    pub const M_S2: Self =
        Self { name: "m/s2", quantity: "Acceleration", base: &[("m", 1), ("s", -2)] };
    /// One per second: a decay.
    pub const PER_S: Self = Self { name: "1/s", quantity: "DecayRate", base: &[("s", -1)] };

    /// The name in model descriptions, such as `rad/s`.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.name
    }

    /// The quantity measured; FMI 3.0 names the declared type after it.
    #[must_use]
    pub const fn quantity(&self) -> &'static str {
        self.quantity
    }

    /// Exponents of the SI base units that take part, in the order of the FMI schema.
    #[must_use]
    pub const fn base(&self) -> &'static [(&'static str, i8)] {
        self.base
    }

    /// The ending of a variable's name that carries this unit, such as `_rad_s`; empty for
    /// dimensionless ones.
    #[must_use]
    pub fn name_suffix(&self) -> String {
        if *self == Self::ONE {
            return String::new();
        }
        format!("_{}", self.name.replace(['/', '.'], "_"))
    }
}

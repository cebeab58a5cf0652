//! Every model that Struna exports as an FMU, in one shared library.
//!
//! A model is one file with one variable table; adding one means adding its file and its line in
//! [`MODELS`]. The library built from here serves FMI 2.0 and 3.0 alike; packaging wraps it once
//! per model and version.
//!
//! **Architecture Invariant:** nothing is computed here. The estimators know nothing of FMI, the C
//! layer knows nothing of estimators, and this crate only names the one to the other.

mod augmented_torsion;
mod exported;
mod filter;
mod hysteresis_bank;
mod learning;
mod live_estimator;
mod permanent_rotation;
mod torsional_oscillation;

use struna_estimator::{PermanentRotation, TorsionalOscillation};
use struna_fmi_export::{ModelType, export_fmi};

/// The exported models. Each stands in a constant of its own: the compiler calculates their tokens,
/// and wonders when one constant takes it long.
pub static MODELS: [ModelType; 5] = [
    const { ModelType::of::<filter::FilterModel<PermanentRotation>>() },
    const { ModelType::of::<filter::FilterModel<TorsionalOscillation>>() },
    const { ModelType::of::<exported::EstimatorModel<augmented_torsion::AugmentedTorsion>>() },
    const { ModelType::of::<exported::EstimatorModel<hysteresis_bank::Bank>>() },
    const { ModelType::of::<exported::EstimatorModel<live_estimator::Live>>() },
];

/// Finds an exported model by its name.
#[must_use]
pub fn model(name: &str) -> Option<&'static ModelType> {
    MODELS.iter().find(|model| model.description().name() == name)
}

export_fmi!(crate::MODELS);

#[cfg(test)]
mod tests {
    use super::*;
    use struna_fmi_export::{Role, Unit};

    const UNITS: [Unit; 12] = [
        Unit::ONE,
        Unit::S,
        Unit::RAD,
        Unit::RAD_S,
        Unit::RAD2,
        Unit::RAD2_S2,
        Unit::RAD2_S3,
        Unit::KG,
        Unit::M,
        Unit::KG_M2,
        Unit::M_S2,
        Unit::PER_S,
    ];

    #[test]
    fn every_variables_name_ends_in_its_unit() {
        for variable in MODELS.iter().flat_map(|model| model.description().variables()) {
            if variable.role() == Role::Independent {
                continue; // called "time" by the standard
            }
            // The longest ending that fits: "rate_rad_s" also ends in "_s".
            let fitting = UNITS.iter().filter(|u| variable.name().ends_with(&u.name_suffix()));
            let named = fitting.max_by_key(|unit| unit.name_suffix().len());
            assert_eq!(named, Some(&variable.unit()), "{}", variable.name());
        }
    }

    #[test]
    fn models_are_found_by_name_and_have_tokens_of_their_own() {
        for (k, one) in MODELS.iter().enumerate() {
            let found = model(one.description().name()).map(ModelType::instantiation_token);
            assert_eq!(found, Some(one.instantiation_token()));
            for other in &MODELS[..k] {
                assert_ne!(one.instantiation_token(), other.instantiation_token());
            }
        }
        assert!(model("Pendulum").is_none());
    }
}

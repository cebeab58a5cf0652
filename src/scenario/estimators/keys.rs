//! Which keys of `[[estimator]]` each kind of estimator reads.

use struna_settings::{Result, Table};

/// The kinds, by the words that scenarios have for them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum KindWord {
    Integration,
    Rotation,
    Torsion,
    Augmented,
    Tested,
    Bank,
    Live,
    ThreeAxis,
}

use KindWord::{Augmented, Bank, Integration, Live, Rotation, Tested, ThreeAxis, Torsion};

pub(super) const WORDS: [(&str, KindWord); 8] = [
    ("plain-integration", Integration),
    ("permanent-rotation", Rotation),
    ("torsional-oscillation", Torsion),
    ("augmented-torsion", Augmented),
    ("tested-torsion", Tested),
    ("hysteresis-bank", Bank),
    ("live", Live),
    ("three-axis-swing", ThreeAxis),
];

const OF_2008: &[KindWord] = &[Integration, Rotation, Torsion];
const OSCILLATING: &[KindWord] = &[Torsion, Augmented, Tested, Bank, Live, ThreeAxis];
const LEARNING: &[KindWord] = &[Augmented, Tested, Bank, Live, ThreeAxis];
/// Those that ask whether the gyro may have clipped without a word, and how coarsely it counts.
const CLIPPING: &[KindWord] = &[Augmented, Tested, Bank, Live];
const TESTING: &[KindWord] = &[Tested, Live];
const SWITCHING: &[KindWord] = &[Live];
/// Those that are told of the body.
const SWINGING: &[KindWord] = &[Live, ThreeAxis];
const THREE_AXES: &[KindWord] = &[ThreeAxis];
const EVERY: &[KindWord] =
    &[Integration, Rotation, Torsion, Augmented, Tested, Bank, Live, ThreeAxis];

const KEYS: [(&str, &[KindWord]); 39] = [
    ("name", EVERY),
    ("kind", EVERY),
    ("run_as", EVERY),
    ("fmu_file", EVERY),
    ("angle_start_deg", EVERY),
    ("rate_start_deg_s", EVERY),
    ("angle_sigma_start_deg", EVERY),
    ("rate_sigma_start_deg_s", EVERY),
    ("measurement_sigma_deg_s", EVERY),
    ("process_noise_deg2_s3", EVERY),
    ("refinement_samples", OF_2008),
    ("refinement_reading", OF_2008),
    ("torsion_period_s", OSCILLATING),
    ("torsion_period_sigma_s", LEARNING),
    ("damping_ratio", LEARNING),
    ("damping_ratio_sigma", LEARNING),
    ("bias_deg_h", LEARNING),
    ("bias_sigma_deg_h", LEARNING),
    ("bias_walk_deg2_s3", LEARNING),
    ("scale_factor_sigma_percent", LEARNING),
    ("gyro_range_deg_s", CLIPPING),
    ("gyro_range_margin_deg_s", CLIPPING),
    ("test_false_alarms", TESTING),
    ("test_horizon_samples", TESTING),
    ("test_kick_floor_deg_s", TESTING),
    ("gyro_count_deg_s", CLIPPING),
    ("gyro_raw_sigma_deg_s", CLIPPING),
    ("swing_max_deg", SWITCHING),
    ("fit_work_per_sample", SWITCHING),
    ("body_mass_kg", SWINGING),
    ("body_com_depth_m", SWINGING),
    ("body_inertia_kg_m2", SWINGING),
    ("body_inertia_sigma_percent", SWINGING),
    ("body_swing_damping_1_s", SWINGING),
    ("body_swing_damping_sigma_percent", SWINGING),
    ("gravity_m_s2", SWINGING),
    ("input_axis_deg", SWINGING),
    ("input_axis_sigma_deg", SWITCHING),
    ("swing_sigma_start_deg", THREE_AXES),
];

/// Refuses what is no key at all.
pub(super) fn refuse_unknown(table: &Table<'_>) -> Result<()> {
    table.only(&KEYS.map(|(key, _)| key))
}

/// Refuses keys that an estimator of `kind` would not look at.
pub(super) fn refuse_unread(table: &Table<'_>, kind: KindWord) -> Result<()> {
    for (key, readers) in KEYS {
        if let (false, Some(value)) = (readers.contains(&kind), table.optional(key)) {
            let quoted = |(word, _): &(&str, _)| format!("\"{word}\"");
            let reads = |(_, kind): &&(&str, KindWord)| readers.contains(kind);
            let readers: Vec<_> = WORDS.iter().filter(reads).map(quoted).collect();
            let readers = readers.join(", ");
            return Err(value.because(format!(
                "this kind of estimator does not read it, but {readers}; remove it or change `kind`"
            )));
        }
    }
    Ok(())
}

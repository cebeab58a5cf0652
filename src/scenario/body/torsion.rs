//! `[body.torsion]`: how the thread resists twist, with `hysteresis` and `creep` below it.

use super::super::numbers::section;
use struna_body::{
    Creep, Hysteresis, Torsion, TorsionDamping, TorsionStiffness, YIELD_ELEMENTS_MAX, YieldElement,
    YieldLaw,
};
use struna_kernel::RAD_PER_DEG;
use struna_settings::{Result, Table, Value};

/// What `[body.torsion]` describes.
pub(super) struct Thread {
    pub(super) torsion: Torsion,
    pub(super) hysteresis: Option<Hysteresis>,
    pub(super) creep: Option<Creep>,
}

pub(super) fn thread(torsion: &Table<'_>) -> Result<Thread> {
    torsion.only(&[
        "period_s",
        "stiffness_n_m_rad",
        "damping_ratio",
        "damping_n_m_s_rad",
        "hysteresis",
        "creep",
    ])?;
    Ok(Thread {
        torsion: Torsion { stiffness: stiffness(torsion)?, damping: damping(torsion)? },
        hysteresis: section(torsion, "hysteresis", hysteresis)?,
        creep: section(torsion, "creep", creep)?,
    })
}

fn stiffness(torsion: &Table<'_>) -> Result<TorsionStiffness> {
    match (torsion.optional("period_s"), torsion.optional("stiffness_n_m_rad")) {
        (Some(period), None) => Ok(TorsionStiffness::PeriodS(period.positive()?)),
        (None, Some(k)) => Ok(TorsionStiffness::ConstantNMRad(k.not_negative()?)),
        (None, None) => Err(torsion.because("give either `period_s` or `stiffness_n_m_rad`")),
        (Some(_), Some(k)) => Err(k.because("contradicts `period_s`; remove one of them")),
    }
}

fn damping(torsion: &Table<'_>) -> Result<TorsionDamping> {
    match (torsion.optional("damping_ratio"), torsion.optional("damping_n_m_s_rad")) {
        (None, None) => Ok(TorsionDamping::Ratio(0.0)),
        (Some(ratio), None) => Ok(TorsionDamping::Ratio(ratio.not_negative()?)),
        (None, Some(c)) => Ok(TorsionDamping::CoefficientNMSRad(c.not_negative()?)),
        (Some(_), Some(c)) => Err(c.because("contradicts `damping_ratio`; remove one of them")),
    }
}

fn hysteresis(hysteresis: &Table<'_>) -> Result<Hysteresis> {
    hysteresis.only(&["law", "stiffness_n_m_rad", "yield_deg"])?;
    let law =
        hysteresis.required("law")?.word(&[("slip", YieldLaw::Slip), ("dahl", YieldLaw::Dahl)])?;
    let stiffness = elements(&hysteresis.required("stiffness_n_m_rad")?)?;
    let strain = hysteresis.required("yield_deg")?;
    let strain_deg = elements(&strain)?;
    if strain_deg.len() != stiffness.len() {
        let wanted = format!("{} numbers, one for each stiffness", stiffness.len());
        return Err(strain.out_of_range(wanted));
    }
    let element = |(stiffness_n_m_rad, yield_deg): (f64, f64)| YieldElement {
        stiffness_n_m_rad,
        yield_rad: yield_deg * RAD_PER_DEG,
    };
    Ok(Hysteresis { law, elements: stiffness.into_iter().zip(strain_deg).map(element).collect() })
}

/// One positive number for each yield element.
fn elements(value: &Value<'_>) -> Result<Vec<f64>> {
    let items = value.array()?;
    if !(1..=YIELD_ELEMENTS_MAX).contains(&items.len()) {
        return Err(value.out_of_range(format!("an array of 1 to {YIELD_ELEMENTS_MAX} numbers")));
    }
    items.iter().map(Value::positive).collect()
}

fn creep(creep: &Table<'_>) -> Result<Creep> {
    creep.only(&["time_s", "share"])?;
    Ok(Creep {
        time_s: creep.required("time_s")?.positive()?,
        share: creep.required("share")?.number_in(0.0..=1.0)?,
    })
}

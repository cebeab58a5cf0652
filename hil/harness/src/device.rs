//! What the bench tests.

use struna_fmi_import::ImportError;
use struna_kernel::{AngleEstimate, RateSample};

/// An estimator as the bench sees it: rates in, estimates out.
pub trait DeviceUnderTest {
    /// Its name in records and scores.
    fn name(&self) -> &str;

    /// Takes one rate sample; the estimate is for the sample's time.
    ///
    /// When the sample's span starts later than the previous sample ended, the device must treat
    /// the time between as a gap without measurement.
    ///
    /// # Errors
    /// [`DeviceError`] when the device refuses the sample or has failed.
    fn step(&mut self, sample: &RateSample) -> Result<AngleEstimate, DeviceError>;
}

/// Why a device gave no estimate.
#[derive(Debug, thiserror::Error)]
#[error("estimator '{device}' failed at {time_s} s: {cause}")]
pub struct DeviceError {
    /// Name of the device.
    pub device: String,
    /// Time of the sample, s.
    pub time_s: f64,
    /// What it said.
    pub cause: Box<DeviceFault>,
}

/// What went wrong inside a device.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DeviceFault {
    /// The FMU or its importer.
    #[error(transparent)]
    Fmu(#[from] ImportError),
    /// An estimator in process.
    #[error("{0}")]
    InProcess(Box<dyn std::error::Error + Send + Sync>),
}

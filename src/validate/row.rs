//! One run of one estimator, as a row of the table that everything else reads.

use struna_estimator::Status;

/// Instants at which error and claim are kept, at equal intervals up to the end.
pub const EPOCHS: usize = 10;

/// Declares the numbers of a row once: variant, name of the column, meaning.
macro_rules! columns {
    ($($variant:ident $name:literal $meaning:literal;)+) => {
        /// A number of a row. A name carries its unit.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Column {
            $(#[doc = $meaning] $variant,)+
        }

        impl Column {
            /// All of them, in the order of the files.
            pub const ALL: &[Self] = &[$(Self::$variant,)+];

            /// Name in files.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)+ }
            }

            /// What it is.
            #[must_use]
            pub const fn meaning(self) -> &'static str {
                match self { $(Self::$variant => $meaning,)+ }
            }
        }
    };
}

columns! {
    DurationS "duration_s" "Length of the run.";
    PeriodS "period_s" "True period of undamped torsion.";
    DampingRatio "damping_ratio" "True damping ratio of the torsion.";
    StartAngleDeg "start_angle_deg" "True angle at the start.";
    StartErrorDeg "start_error_deg" "Believed less true angle at the start.";
    StartRateDegS "start_rate_deg_s" "True rate at the start, believed to be zero.";
    BiasDegS "bias_deg_s" "True bias of the gyro at the start.";
    ScaleError "scale_error" "True scale factor of the gyro less one.";
    NoiseDegS "noise_deg_s" "Standard deviation of the white noise of one measured rate.";
    LsbDegS "lsb_deg_s" "One count of the gyro.";
    AveragedSamples "averaged_samples" "Gyro samples in one measured rate.";
    BiasWalkDegSSqrtS "bias_walk_deg_s_sqrt_s" "Random walk of the bias.";
    RangeDegS "range_deg_s" "Rate at which the gyro clips.";
    TorqueDensityDeg2S3 "torque_density_deg2_s3" "Density of white angular acceleration.";
    OutlierShare "outlier_share" "Share of samples with an error of 20 sigma.";
    Kicks "kicks" "Kicks and ramps of the rate in the run.";
    KickDegS "kick_deg_s" "Size of the first of them.";
    KickOverS "kick_over_s" "Time over which it is spread.";
    KickAtS "kick_at_s" "When it begins.";
    SwingDeg "swing_deg" "Amplitude of the swing at the start.";
    SwingRatio "swing_ratio" "Short axis of the swing's ellipse over its long one, with a sign.";
    MisalignmentDeg "misalignment_deg" "Angle between the gyro's input axis and the body's axis.";
    InertiaRatio "inertia_ratio" "Second transverse moment of inertia over the first.";
    YieldDeg "yield_deg" "Twist over which the thread yields.";
    LineEvents "line_events" "Faults injected into the line.";
    LostSamples "lost_samples" "Gyro samples that never arrived.";
    BelievedNoiseDegS "believed_noise_deg_s" "Square root of the estimator's R.";
    RefinementSamples "refinement_samples" "N of the covariance refinement.";
    AngleRmsDeg "angle_rms_deg" "RMS error of the angle over the run.";
    AngleHalf2Deg "angle_half2_deg" "RMS error of the angle over the second half.";
    AngleEndDeg "angle_end_deg" "Error of the angle at the end.";
    AngleEndSigmaDeg "angle_end_sigma_deg" "Claimed standard deviation of the angle at the end.";
    EndSigmas "end_sigmas" "Size of the error at the end in claimed standard deviations.";
    WorstSigmas "worst_sigmas" "The same at its largest, after the first quarter.";
    RateRmsDegS "rate_rms_deg_s" "RMS error of the rate over the run.";
    RateHalf2DegS "rate_half2_deg_s" "RMS error of the rate over the second half.";
    NisMean "nis_mean" "Mean normalised innovation squared.";
    NeesStates "nees_states" "States in the normalised estimation error squared.";
    BoundAngleDeg "bound_angle_deg" "Least RMS of the angle over the second half.";
    BoundRateDegS "bound_rate_deg_s" "Least RMS of the rate over the second half.";
    BoundEndDeg "bound_end_deg" "Least error of the angle at the end.";
    Alarms "alarms" "Alarms of the estimator.";
    DelayS "delay_s" "From the beginning of the first kick to the next alarm.";
    YieldFoundDeg "yield_found_deg" "Twist over which the thread yields, as the estimator finds.";
}

/// Error and claim at one instant. Not a number where there is none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Epoch {
    /// Error of the angle, deg.
    pub error_deg: f64,
    /// Claimed standard deviation of the angle, deg.
    pub sigma_deg: f64,
    /// Normalised estimation error squared over all states.
    pub nees: f64,
}

impl Epoch {
    /// Nothing known.
    pub const NONE: Self = Self { error_deg: f64::NAN, sigma_deg: f64::NAN, nees: f64::NAN };
}

/// How a run ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    /// It went to its end.
    Complete,
    /// It did not, and why.
    Stopped(String),
}

/// One run of one estimator.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Suite.
    pub suite: &'static str,
    /// Case: what was done to body, gyro or line.
    pub case: String,
    /// Estimator.
    pub estimator: String,
    /// Number of the run; equal numbers have equal draws in all cases of a suite.
    pub run: u32,
    /// Seed of the campaign.
    pub seed: u64,
    /// How it ended.
    pub outcome: Outcome,
    /// What the estimator said of itself at the end.
    pub status: &'static str,
    /// Error and claim along the run.
    pub epochs: [Epoch; EPOCHS],
    numbers: Vec<f64>,
}

impl Row {
    /// A row without numbers yet.
    #[must_use]
    pub fn new(suite: &'static str, case: &str, estimator: &str, (seed, run): (u64, u32)) -> Self {
        Self {
            suite,
            case: case.to_owned(),
            estimator: estimator.to_owned(),
            run,
            seed,
            outcome: Outcome::Complete,
            status: "",
            epochs: [Epoch::NONE; EPOCHS],
            numbers: vec![f64::NAN; Column::ALL.len()],
        }
    }

    /// Sets a number.
    pub fn set(&mut self, column: Column, value: f64) {
        self.numbers[column as usize] = value;
    }

    /// A number; none where it does not apply.
    #[must_use]
    pub fn get(&self, column: Column) -> Option<f64> {
        Some(self.numbers[column as usize]).filter(|value| !value.is_nan())
    }

    /// Whether the run went to its end.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.outcome == Outcome::Complete
    }
}

/// One word for a status.
#[must_use]
pub fn word(status: Status) -> &'static str {
    match status {
        Status::Nominal => "nominal",
        Status::Swinging { .. } => "swinging",
        Status::Fitting { .. } => "fitting",
        Status::Disturbed { .. } => "disturbed",
        Status::ModelDoubtful => "model doubtful",
        Status::ThreadYields { .. } => "thread yields",
        Status::NotObservable => "not observable",
        _ => "other",
    }
}

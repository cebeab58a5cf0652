//! What a motion was made by, said in one way wherever results name it.

use crate::scenario::Source;
use struna_body::Integrator;

/// What the motion of `source` comes from, for people and for the heads of files; one line.
///
/// A truth is only as good as what made it, so every result says what that was.
#[must_use]
pub fn sentence(source: &Source) -> String {
    match source {
        Source::Model(model) => format!("lagrange, {}", integrator(model.integrator)),
        Source::Recording(recording) => {
            // Without its folder: a result does not depend on where its input lay.
            let name = recording.file.file_name().unwrap_or_default().to_string_lossy();
            format!("recording {}", name.escape_debug())
        }
    }
}

fn integrator(integrator: Integrator) -> String {
    match integrator {
        Integrator::Rk4 { step_s } => format!("rk4, step {step_s} s"),
        Integrator::Dop853 { rtol, atol } => {
            format!("dop853, relative tolerance {rtol:e}, absolute tolerance {atol:e}")
        }
        // The enum may grow; its own words will do until this function has some.
        other => format!("{other:?}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::RecordingSource;

    #[test]
    fn an_integrator_is_named_with_what_decides_its_error() {
        assert_eq!(integrator(Integrator::Rk4 { step_s: 1e-3 }), "rk4, step 0.001 s");
        let record = Integrator::Dop853 { rtol: 1e-12, atol: 1e-11 };
        let expected = "dop853, relative tolerance 1e-12, absolute tolerance 1e-11";
        assert_eq!(integrator(record), expected);
    }

    #[test]
    fn a_recording_is_named_by_its_file_on_one_line() {
        let recording = |file: &str| {
            let (time_column, rate_column) = ("t".to_owned(), "r".to_owned());
            let file = file.into();
            let rad_s_per_unit = 1.0;
            Source::Recording(RecordingSource { file, time_column, rate_column, rad_s_per_unit })
        };
        assert_eq!(sentence(&recording("a/b.csv")), "recording b.csv");
        assert_eq!(sentence(&recording("a/b\n# seed: 7")), "recording b\\n# seed: 7");
    }
}

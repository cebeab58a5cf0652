//! What a motion was made by, said in one way wherever results name it.

use crate::scenario::Source;

/// What the motion of `source` comes from, for people and for the heads of files; one line.
///
/// A truth is only as good as what made it, so every result says what that was.
#[must_use]
pub fn sentence(source: &Source) -> String {
    match source {
        Source::Model(model) => model.backend.to_string(),
        Source::Recording(recording) => {
            // Without its folder: a result does not depend on where its input lay.
            let name = recording.file.file_name().unwrap_or_default().to_string_lossy();
            format!("recording {}", name.escape_debug())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::RecordingSource;

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

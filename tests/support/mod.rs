//! What several tests of the whole chain need.

use struna::scenario::Scenario;
use struna::session::{self, Drive, Session};
use struna_harness::Pacing;
use struna_line::StopFlag;

/// Runs a scenario to its end, as fast as possible.
pub(crate) fn run(scenario: &Scenario) -> Session {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let drive = Drive {
        fmu_folder: folder.path(),
        pacing: Pacing::AsFastAsPossible,
        stop: &StopFlag::new(),
        progress: &mut |_| {},
    };
    session::run(scenario, drive).expect("the run succeeds")
}

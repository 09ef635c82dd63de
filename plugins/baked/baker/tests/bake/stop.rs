//! Stopping at the beginning of each stage.

use std::path::Path;

use farlight_baked_format::Manifest;
use farlight_baker::{Bake, BakeError, Outcome, Stage};

use crate::{Ear, SCENE, contents, quick, run};

#[test]
fn stopped_at_any_stage_it_goes_on_as_if_it_had_not_been() {
    let folder = tempfile::tempdir().unwrap();
    let fresh = folder.path().join("fresh");
    let mut ear = Ear::default();
    let report = run(quick(Path::new(SCENE), &fresh), &mut ear).unwrap();
    assert_eq!(report.outcome, Outcome::Complete);
    assert_eq!(ear.warnings, [""; 0]);
    assert_eq!(report.manifest.scenarios[0].samples, 64);
    // Every stage is told, in its order. (Second UV sets may need a second try at another density.)
    let mut stages: Vec<Stage> = Vec::new();
    for stage in ear.stages {
        if !stages.contains(&stage) {
            stages.push(stage);
        }
    }
    stages.sort_by_key(|stage| *stage == Stage::Probes);
    let mut all = Stage::ALL.to_vec();
    all.sort_by_key(|stage| *stage == Stage::Probes);
    assert_eq!(stages, all);

    for stage in Stage::ALL {
        let out = folder.path().join(format!("{stage:?}"));
        let bake = Bake::new(quick(Path::new(SCENE), &out));
        let mut ear = Ear { stop: Some((stage, bake.stop_flag())), ..Ear::default() };
        let manifest = out.join("TwoRooms.baked.ron");
        match bake.run(&mut ear) {
            Err(BakeError::Stopped) => {
                assert!(stage <= Stage::Probes, "{stage}");
                assert!(!manifest.exists(), "{stage}");
            }
            Err(error) => panic!("{stage}: {error}"),
            Ok(report) => {
                let read = std::fs::read_to_string(&manifest).unwrap();
                let read = Manifest::parse(&read).unwrap();
                assert_eq!(read, report.manifest);
                // All rays were there: only the rest of the work went on.
                let done = read.scenarios[0].samples == 64;
                assert_eq!(report.outcome == Outcome::Complete, done, "{stage}");
            }
        }
        let report = run(quick(Path::new(SCENE), &out), &mut Ear::default()).unwrap();
        assert!(matches!(report.outcome, Outcome::Complete | Outcome::Unchanged));
        assert!(contents(&out) == contents(&fresh), "{stage}");
    }
}

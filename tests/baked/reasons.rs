//! Damaged and wrong folders: a reason, and whatever can be lit is.

use bevy::prelude::*;
use farlight::{baked::format::Manifest, prelude::*};

use crate::{
    folder::{Folder, glb, manifest, receiver},
    stage::Stage,
};

/// The reason that a changed folder gives for its only square.
fn reason(test: &str, change: impl FnOnce(&Folder, &mut Manifest)) -> String {
    let (folder, mut manifest) = Folder::square(test, &[("noon", Vec3::splat(0.4))]);
    change(&folder, &mut manifest);
    folder.manifest(&manifest);
    let mut stage = Stage::new(&folder);
    let root = stage.lit();
    let status = stage.status(root);
    assert_eq!((status.receivers, status.left_out.len()), (0, 1), "{status:?}");
    stage.picture();
    status.left_out[0].reason.to_string()
}

#[test]
fn another_second_uv_set_is_left_out() {
    let reason = reason("other_uv", |folder, _| {
        let uv = [[0.0, 0.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]];
        folder.write("room.glb", glb(&[Vec3::ZERO], &[], uv));
    });
    assert!(reason.contains("second UV set is another one"), "{reason}");
}

#[test]
fn a_missing_page_is_named() {
    let reason = reason("missing_page", |folder, _| {
        std::fs::remove_file(folder.0.join("noon.0.ktx2")).unwrap();
    });
    assert!(reason.contains("noon.0.ktx2"), "{reason}");
}

#[test]
fn a_page_of_another_size_is_named() {
    let reason = reason("page_size", |_, manifest| manifest.page_size = 64);
    assert!(reason.contains("noon.0.ktx2 has") && reason.contains("64"), "{reason}");
}

#[test]
fn a_damaged_page_is_named() {
    let reason = reason("damaged_page", |folder, _| folder.write("noon.0.ktx2", [7; 100]));
    assert!(reason.contains("noon.0.ktx2"), "{reason}");
}

#[test]
fn a_node_that_is_not_in_the_scene_is_named_and_the_others_are_lit() {
    let (folder, _) = Folder::square("no_node", &[("noon", Vec3::splat(0.4))]);
    folder.manifest(&manifest(&[receiver(0), receiver(7)], &["noon"]));
    let mut stage = Stage::new(&folder);
    let root = stage.lit();
    let status = stage.status(root);
    assert_eq!((status.receivers, status.left_out.len()), (1, 1));
    assert!(status.left_out[0].reason.contains("node 7"), "{:?}", status.left_out);
    let picture = stage.picture();
    stage.assert_all(&picture, Vec3::splat(0.2));
}

/// The .glb that was read and not the one that was written.
#[test]
fn a_scene_without_marks_is_refused() {
    let (folder, _) = Folder::square("no_marks", &[("noon", Vec3::splat(0.4))]);
    let file = folder.0.join("room.glb");
    let mut bytes = std::fs::read(&file).unwrap();
    let mark = b"farlight_node";
    let at = bytes.windows(mark.len()).position(|window| window == mark).unwrap();
    bytes[at..at + 3].copy_from_slice(b"FAR");
    std::fs::write(file, bytes).unwrap();
    let mut stage = Stage::new(&folder);
    let root = stage.spawn();
    let why = stage.failed(root);
    assert!(why.contains("farlight_node") && why.contains("room.glb"), "{why}");
}

#[test]
fn manifests_that_cannot_be_read_say_where() {
    for (test, text, expected) in [
        ("missing_manifest", None, "room.baked.ron"),
        ("no_manifest", Some("a picture".to_owned()), "room.baked.ron"),
        ("empty_manifest", Some("(version: 1)".to_owned()), "scene"),
        (
            "old_manifest",
            Some(manifest(&[], &["noon"]).to_text().replace("version: 1", "version: 0")),
            "version",
        ),
        ("outside", Some(manifest(&[], &["../noon"]).to_text()), "../noon"),
    ] {
        let folder = Folder::new(test);
        if let Some(text) = text {
            folder.write("room.baked.ron", text);
        }
        let mut stage = Stage::new(&folder);
        let root = stage.spawn();
        let why = stage.failed(root);
        assert!(why.contains(expected), "{test}: {why}");
        stage.picture();
    }
}

#[test]
fn a_damaged_volume_leaves_lightmaps_lit() {
    let (folder, mut manifest) = Folder::square("bad_volume", &[("noon", Vec3::splat(0.4))]);
    folder.volume("noon.volume0.ktx2", [Vec3::ONE; 6]);
    let mut volume = crate::folder::volume(Vec3::ZERO, 8.0);
    volume.resolution = [2, 3, 4];
    manifest.volumes = vec![volume];
    manifest.scenarios[0].volumes = vec!["noon.volume0.ktx2".into()];
    folder.manifest(&manifest);
    let mut stage = Stage::new(&folder);
    let root = stage.lit();
    let status = stage.status(root);
    assert_eq!((status.receivers, status.volumes), (1, 0));
    assert!(status.left_out[0].reason.contains("noon.volume0.ktx2"), "{:?}", status.left_out);
    assert!(!stage.world().resource::<BakedStatus>().roots.is_empty());
}

#[test]
fn a_scene_that_cannot_be_read_is_a_reason() {
    for (test, bytes) in [("damaged_scene", Some([7; 100])), ("missing_scene", None)] {
        let (folder, _) = Folder::square(test, &[("noon", Vec3::splat(0.4))]);
        match bytes {
            Some(bytes) => folder.write("room.glb", bytes),
            None => std::fs::remove_file(folder.0.join("room.glb")).unwrap(),
        }
        let mut stage = Stage::new(&folder);
        let root = stage.spawn();
        let why = stage.failed(root);
        assert!(why.contains("room.glb"), "{why}");
    }
}

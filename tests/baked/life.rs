//! Scenes and manifests that come, go and change.

use bevy::{pbr::Lightmap, prelude::*, world_serialization::WorldAssetRoot};
use farlight::prelude::*;

use crate::{
    folder::{Folder, manifest, receiver},
    stage::Stage,
};

const GREY: Vec3 = Vec3::splat(0.4);

#[test]
fn lighting_may_come_long_after_the_scene() {
    let (folder, _) = Folder::square("late", &[("noon", GREY)]);
    let mut stage = Stage::new(&folder);
    let server = stage.world().resource::<AssetServer>().clone();
    let scene = server.load(GltfAssetLabel::Scene(0).from_asset("room.glb"));
    let root = stage.world().spawn(WorldAssetRoot(scene)).id();
    stage.until("the scene", |world| world.query::<&Mesh3d>().iter(world).count() == 1);
    let picture = stage.picture();
    stage.assert_all(&picture, Vec3::ZERO);
    let lighting = BakedLighting::new(server.load("room.baked.ron"));
    stage.world().entity_mut(root).insert(lighting);
    stage.until_lit(root);
    let picture = stage.picture();
    stage.assert_all(&picture, GREY / 2.0);

    // Without it, the scene is as it was.
    stage.world().entity_mut(root).remove::<BakedLighting>();
    let picture = stage.picture();
    stage.assert_all(&picture, Vec3::ZERO);
    assert!(stage.lightmapped().is_empty());
    assert!(stage.world().resource::<BakedStatus>().roots.is_empty());
}

#[test]
fn a_scene_is_lit_again_when_it_is_spawned_again() {
    let (folder, mut manifest) = Folder::square("again", &[("noon", GREY)]);
    folder.volume("noon.volume0.ktx2", [Vec3::ONE; 6]);
    manifest.volumes = vec![crate::folder::volume(Vec3::ZERO, 8.0)];
    manifest.scenarios[0].volumes = vec!["noon.volume0.ktx2".into()];
    folder.manifest(&manifest);
    let mut stage = Stage::new(&folder);
    let root = stage.lit();
    // What was spawned goes, by itself.
    let old = stage.lightmapped();
    for entity in &old {
        let parent = stage.world().get::<ChildOf>(*entity).unwrap().parent();
        stage.world().entity_mut(parent).despawn();
    }
    stage.update();
    stage.update();
    assert_eq!(stage.status(root).receivers, 0);
    let scene = stage.world().get::<WorldAssetRoot>(root).unwrap().clone();
    stage.world().entity_mut(root).insert(scene);
    stage.until("the scene again", |world| world.query::<&Lightmap>().iter(world).count() == 1);
    let new = stage.lightmapped();
    assert_ne!(old, new);
    let picture = stage.picture();
    stage.assert_all(&picture, GREY / 2.0);
    // The whole root goes, and everything with it.
    stage.world().entity_mut(root).despawn();
    stage.update();
    stage.update();
    assert!(stage.lightmapped().is_empty());
    assert!(stage.world().resource::<BakedStatus>().roots.is_empty());
    let world = stage.world();
    assert_eq!(world.query::<&LightProbe>().iter(world).count(), 0);
}

#[test]
fn several_roots_share_a_manifest_and_move() {
    let scenarios = [("noon", GREY), ("night", Vec3::ZERO)];
    let (folder, _) = Folder::square("several", &scenarios);
    let mut stage = Stage::new(&folder);
    let near = stage.lit();
    let far = stage.lit();
    assert_eq!(stage.lightmapped().len(), 2);
    assert_eq!(stage.world().resource::<BakedStatus>().receivers(), 2);
    stage.lighting(far).scenarios.show("night");
    // One moves aside in front of the other: each has its own scenario.
    *stage.world().get_mut::<Transform>(far).unwrap() = Transform::from_xyz(1.0, 0.0, 0.1);
    let picture = stage.picture();
    stage.assert_pixel(&picture, 8, 32, GREY / 2.0);
    stage.assert_pixel(&picture, 56, 32, Vec3::ZERO);
    stage.world().entity_mut(far).despawn();
    let picture = stage.picture();
    stage.assert_all(&picture, GREY / 2.0);
    stage.until_lit(near);
}

/// A bake that ran again: other texels at another place in files of other names.
#[test]
fn a_manifest_that_changes_on_disk_is_shown() {
    let (folder, _) = Folder::square("reload", &[("noon", GREY)]);
    let mut stage = Stage::new(&folder);
    let root = stage.lit();
    folder.page("later.0.ktx2", |x, y| {
        if x >= 16 && y >= 16 { Vec3::splat(0.8) } else { Vec3::new(1.0, 0.0, 0.0) }
    });
    let mut moved = receiver(0);
    moved.rect = [16, 16, 16, 16];
    let mut changed = manifest(&[moved], &["noon"]);
    changed.scenarios[0].pages[0].ktx2 = "later.0.ktx2".into();
    folder.manifest(&changed);
    stage.world().resource::<AssetServer>().reload("room.baked.ron");
    stage.until("the new page", |world| {
        let server = world.resource::<AssetServer>().clone();
        world.query::<&Lightmap>().iter(world).any(|lightmap| {
            server.get_path(&lightmap.image).is_some_and(|p| p.to_string() == "later.0.ktx2")
        })
    });
    stage.until_lit(root);
    let picture = stage.picture();
    stage.assert_all(&picture, GREY);
    // A manifest that got damaged leaves what is shown.
    folder.write("room.baked.ron", "(");
    stage.world().resource::<AssetServer>().reload("room.baked.ron");
    for _ in 0..20 {
        stage.update();
    }
    let picture = stage.picture();
    stage.assert_all(&picture, GREY);
}

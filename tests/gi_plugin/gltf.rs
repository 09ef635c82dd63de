//! A glTF file that is tagged once, before it is loaded.

use std::time::Duration;

use bevy::{prelude::*, world_serialization::WorldAssetRoot};
use farlight::{
    gi::{ExtractedScene, GiStatic},
    prelude::*,
};

use crate::pictures::Stage;

#[test]
fn a_file_tagged_before_it_loads_takes_part_completely() {
    let mut stage = Stage::new();
    let scene = stage
        .world()
        .resource::<AssetServer>()
        .load(GltfAssetLabel::Scene(0).from_asset("scenes/doorway.glb"));
    stage.world().spawn((GiScene, WorldAssetRoot(scene)));
    let loaded = stage.headless.update_until("the file", Duration::from_secs(60), |world| {
        let tagged = world.query_filtered::<(), With<GiStatic>>().iter(world).count();
        let status = world.resource::<GiStatus>();
        tagged > 0 && status.converting == 0 && status.receivers > 0
    });
    loaded.unwrap_or_else(|problem| panic!("{problem}"));
    stage.settle();
    let meshes = {
        let world = stage.world();
        world.query_filtered::<(), With<Mesh3d>>().iter(world).count()
    };
    let lights = {
        let world = stage.world();
        world.query::<&PointLight>().iter(world).count()
    };
    let status = stage.world().resource::<GiStatus>();
    assert!(status.left_out.is_empty(), "{:?}", status.left_out);
    let extracted = stage.world().resource::<ExtractedScene>();
    assert_eq!(extracted.scene.instances.len(), meshes);
    assert_eq!(extracted.receivers.len(), meshes);
    assert_eq!(extracted.scene.lights.len(), lights);
    let triangles: usize = extracted
        .scene
        .instances
        .values()
        .map(|instance| extracted.scene.meshes[&instance.mesh].triangles.len())
        .sum();
    assert!(triangles > 100, "{triangles} triangles");
    for mesh in extracted.scene.meshes.values() {
        assert_eq!(mesh.uv1.len(), mesh.positions.len());
    }
}

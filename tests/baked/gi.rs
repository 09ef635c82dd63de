//! Baked meshes below a tag of the live solver.

use bevy::prelude::*;
use farlight::{
    core::BakedSurface,
    gi::{ExtractedScene, GiStatic},
    prelude::*,
};

use crate::{folder::Folder, stage::Stage};

/// Whichever comes first, the tag or the baked light: the mesh keeps its baked lightmap, and the solver
/// knows it as a surface only.
#[test]
fn baked_meshes_are_not_solved_again() {
    for baked_first in [true, false] {
        let (folder, _) = Folder::square("gi", &[("noon", Vec3::splat(0.4))]);
        let mut stage = Stage::new(&folder);
        let root = if baked_first {
            let root = stage.lit();
            stage.world().entity_mut(root).insert(GiScene);
            root
        } else {
            use bevy::world_serialization::WorldAssetRoot;
            let server = stage.world().resource::<AssetServer>().clone();
            let scene = server.load(GltfAssetLabel::Scene(0).from_asset("room.glb"));
            let root = stage.world().spawn((GiScene, WorldAssetRoot(scene))).id();
            stage.until("a solved lightmap", |world| {
                let lightmaps = world.resource::<GiLightmaps>();
                lightmaps.placements().count() == 1
            });
            let lighting = BakedLighting::new(server.load("room.baked.ron"));
            stage.world().entity_mut(root).insert(lighting);
            root
        };
        stage.until_lit(root);
        stage.until("the solver", |world| {
            let status = world.resource::<GiStatus>();
            world.resource::<ExtractedScene>().scene.instances.len() == 1
                && status.receivers == 0
                && status.converting == 0
        });
        let lit = stage.lightmapped();
        assert_eq!(lit.len(), 1);
        assert!(stage.world().get::<BakedSurface>(lit[0]).is_some());
        assert!(stage.world().get::<GiStatic>(lit[0]).is_some());
        assert!(stage.world().resource::<GiStatus>().left_out.is_empty());
        assert_eq!(stage.world().resource::<GiLightmaps>().placements().count(), 0);
        let picture = stage.picture();
        stage.assert_all(&picture, Vec3::splat(0.2));

        // Without the baked light, the solver takes over.
        stage.world().entity_mut(root).remove::<BakedLighting>();
        stage.until("a solved lightmap", |world| {
            world.resource::<GiLightmaps>().placements().count() == 1
        });
        assert!(stage.world().get::<BakedSurface>(lit[0]).is_none());
    }
}

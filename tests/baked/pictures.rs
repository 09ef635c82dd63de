//! Brightness and orientation.

use bevy::prelude::*;

use crate::{
    folder::{Folder, PAGE, RECT, manifest, receiver, volume},
    stage::{SIZE, Stage},
};

/// E / π of a texel times the base colour of one half.
#[test]
fn a_wall_shows_its_texels_at_their_place() {
    let folder = Folder::new("wall");
    folder.scene(&[Vec3::ZERO], &[]);
    let at = [8, 12, 16, 16];
    let quarter = move |x: u32, y: u32| match (x < at[0] + 8, y < at[1] + 8) {
        (true, true) => Vec3::new(0.8, 0.0, 0.0),
        (false, true) => Vec3::new(0.0, 0.8, 0.0),
        (true, false) => Vec3::new(0.0, 0.0, 0.8),
        (false, false) => Vec3::splat(0.4),
    };
    folder.page("noon.0.ktx2", quarter);
    let mut receiver = receiver(0);
    receiver.rect = at;
    folder.manifest(&manifest(&[receiver], &["noon"]));
    let mut stage = Stage::new(&folder);
    let root = stage.lit();
    let picture = stage.picture();
    let (low, high) = (SIZE / 4, SIZE * 3 / 4);
    stage.assert_pixel(&picture, low, low, Vec3::new(0.4, 0.0, 0.0));
    stage.assert_pixel(&picture, high, low, Vec3::new(0.0, 0.4, 0.0));
    stage.assert_pixel(&picture, low, high, Vec3::new(0.0, 0.0, 0.4));
    stage.assert_pixel(&picture, high, high, Vec3::splat(0.2));

    let status = stage.status(root);
    assert_eq!((status.receivers, status.left_out.len()), (1, 0));
    assert_eq!(status.texture_bytes, u64::from(PAGE * PAGE * 4), "no copy of a single scenario");
    assert_eq!(status.scenarios, [("noon".to_owned(), 1.0)]);
    let world = stage.world();
    assert_eq!(world.resource::<farlight::prelude::BakedStatus>().blends, 0);
}

/// Six colours, and a square without a lightmap that faces each way in turn.
#[test]
fn each_face_of_a_volume_lights_what_faces_it() {
    let faces = [
        Vec3::new(0.8, 0.0, 0.0),
        Vec3::new(0.0, 0.8, 0.8),
        Vec3::new(0.0, 0.8, 0.0),
        Vec3::new(0.8, 0.0, 0.8),
        Vec3::new(0.0, 0.0, 0.8),
        Vec3::new(0.8, 0.8, 0.0),
    ];
    let (folder, mut manifest) = Folder::square("faces", &[("noon", Vec3::ZERO)]);
    folder.volume("noon.volume0.ktx2", faces);
    manifest.volumes = vec![volume(Vec3::new(100.0, 0.0, 0.0), 8.0)];
    manifest.scenarios[0].volumes = vec!["noon.volume0.ktx2".into()];
    folder.manifest(&manifest);
    let mut stage = Stage::new(&folder);
    let root = stage.lit();
    assert_eq!(stage.status(root).volumes, 1);
    // The root moves the volume back to the camera, and its square away.
    stage.world().get_mut::<Transform>(root).unwrap().translation.x = -100.0;
    let mesh = stage.world().resource_mut::<Assets<Mesh>>().add(Rectangle::new(2.0, 2.0));
    let material = stage.world().resource_mut::<Assets<StandardMaterial>>().add(StandardMaterial {
        base_color: Color::linear_rgb(0.5, 0.5, 0.5),
        perceptual_roughness: 1.0,
        reflectance: 0.0,
        ..default()
    });
    let square =
        stage.world().spawn((Mesh3d(mesh), MeshMaterial3d(material), Transform::default())).id();
    let camera = {
        let world = stage.world();
        world.query_filtered::<Entity, With<Camera3d>>().single(world).unwrap()
    };
    let directions = [Dir3::X, Dir3::NEG_X, Dir3::Y, Dir3::NEG_Y, Dir3::Z, Dir3::NEG_Z];
    for (direction, colour) in directions.into_iter().zip(faces) {
        let up = direction.any_orthonormal_vector();
        // A square faces +z, a camera looks along -z.
        let turned = Transform::IDENTITY.looking_to(-*direction, up);
        *stage.world().get_mut::<Transform>(square).unwrap() = turned;
        let before = Transform::from_translation(*direction * 2.0).looking_at(Vec3::ZERO, up);
        *stage.world().get_mut::<Transform>(camera).unwrap() = before;
        let picture = stage.picture();
        stage.assert_pixel(&picture, SIZE / 2, SIZE / 2, colour / 2.0);
    }
}

/// A lightmapped mesh has its light already: a volume around it adds nothing.
#[test]
fn a_volume_leaves_lightmaps_alone() {
    let (folder, mut manifest) = Folder::square("volume_and_map", &[("noon", Vec3::splat(0.4))]);
    folder.volume("noon.volume0.ktx2", [Vec3::ONE; 6]);
    manifest.volumes = vec![volume(Vec3::ZERO, 8.0)];
    manifest.scenarios[0].volumes = vec!["noon.volume0.ktx2".into()];
    folder.manifest(&manifest);
    let mut stage = Stage::new(&folder);
    stage.lit();
    assert_eq!(RECT[2], PAGE / 2);
    let picture = stage.picture();
    stage.assert_all(&picture, Vec3::splat(0.2));
}

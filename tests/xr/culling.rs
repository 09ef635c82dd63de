//! Each eye has its own frustum, and lamps light as far as they do without a headset.

use bevy::{camera::visibility::VisibleEntities, prelude::*};

use crate::stage::Stage;

fn bright(picture: &[Vec3]) -> usize {
    picture.iter().filter(|pixel| pixel.max_element() > 1e-3).count()
}

#[test]
fn what_one_eye_sees_the_other_need_not() {
    let mut stage = Stage::new();
    stage.sun();
    let mesh = stage.mesh(Cuboid::from_length(0.4));
    let material = stage.material(StandardMaterial::default());
    // 46 degrees to the left: the left eye sees 51 degrees to its left, the right one only 40.
    let angle = -0.8_f32;
    let place = Vec3::new(angle.sin(), 0.0, -angle.cos()) * 6.0;
    let outside = stage.spawn((mesh.clone(), material.clone(), Transform::from_translation(place)));
    let middle = stage.spawn((mesh, material, Transform::from_xyz(0.0, 0.0, -2000.0)));
    (0..4).for_each(|_| stage.update());
    let culled = stage.eyes.map(|eye| {
        let visible = stage.world().get::<VisibleEntities>(eye).unwrap();
        let all: Vec<Entity> = visible.entities.values().flatten().copied().collect();
        (all.contains(&outside), all.contains(&middle))
    });
    // What is far away is never culled for that.
    assert_eq!(culled, [(true, true), (false, true)]);
    let pictures = stage.read();
    assert!(bright(&pictures[0]) > 10, "the left eye sees it");
    assert_eq!(bright(&pictures[1]), 0, "the right one doesn't");
}

#[test]
fn lamps_shine_at_any_distance() {
    let mut stage = Stage::new();
    let mesh = stage.mesh(Sphere::new(1.0));
    let material = stage.material(StandardMaterial::default());
    stage.spawn((mesh, material, Transform::from_xyz(0.0, 0.0, -12.0)));
    let lamp = PointLight { intensity: 5000.0, range: 4.0, ..default() };
    stage.spawn((lamp, Transform::from_xyz(0.0, 1.0, -10.0)));
    (0..4).for_each(|_| stage.update());
    for picture in stage.read() {
        assert!(bright(&picture) > 20, "{}", bright(&picture));
    }
}

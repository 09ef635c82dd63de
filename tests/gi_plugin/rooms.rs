//! Rooms lit by the real solver in its thread.

use std::{f32::consts::PI, time::Duration};

use bevy::prelude::*;
use farlight::prelude::*;

use crate::{
    lightmapped_quad,
    pictures::{SIZE, Stage},
};

/// Albedo of the walls.
const ALBEDO: f32 = 0.5;

/// The inside of a cube with an edge of two metres: six walls with lightmaps, tagged.
fn room(stage: &mut Stage) -> [Entity; 6] {
    let mesh = stage.world().resource_mut::<Assets<Mesh>>().add(lightmapped_quad(2.0));
    let material = stage.matte();
    let root = stage.world().spawn((GiScene, Transform::default(), Visibility::default())).id();
    [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z].map(|outward| {
        let place = Transform::from_translation(outward)
            .with_rotation(Quat::from_rotation_arc(Vec3::Z, -outward));
        stage
            .world()
            .spawn((Mesh3d(mesh.clone()), MeshMaterial3d(material.clone()), place, ChildOf(root)))
            .id()
    })
}

fn lamp(stage: &mut Stage, lumens: f32) -> Entity {
    let light = PointLight { intensity: lumens, range: 1000.0, ..default() };
    stage.world().spawn((light, Transform::from_xyz(0.2, 0.3, 0.1))).id()
}

/// Runs frames until the lighting is solved and shown.
pub(crate) fn solve(stage: &mut Stage) {
    let solved = stage.headless.update_until("the solver", Duration::from_secs(60), |world| {
        let status = world.resource::<GiStatus>();
        assert!(!matches!(status.state, GiState::Failed { .. }), "{:?}", status.state);
        status.shown == status.submitted
            && status.quality.converged
            && status.state == GiState::Converged
    });
    let status = stage.world().resource::<GiStatus>();
    let (state, quality) = (&status.state, status.quality);
    let (shown, submitted, updates) = (status.shown, status.submitted, status.updates);
    solved.unwrap_or_else(|problem| {
        panic!("{problem}: {state:?}, {quality:?}, {updates} updates, {shown:?} of {submitted:?}")
    });
}

/// Mean E over the inner texels of the walls.
fn mean_irradiance(stage: &mut Stage, walls: &[Entity]) -> f32 {
    let lightmaps = stage.world().resource::<GiLightmaps>();
    let (mut sum, mut count) = (0.0, 0.0);
    for &wall in walls {
        let placement = lightmaps.placement(wall).expect("every wall has a lightmap");
        let rect = placement.rect;
        // The outermost texels may lie partly outside of the wall.
        for y in rect.y + 2..rect.y + rect.height - 2 {
            for x in rect.x + 2..rect.x + rect.width - 2 {
                sum += lightmaps.texel(placement.page, x, y).unwrap().y * PI;
                count += 1.0;
            }
        }
    }
    sum / count
}

/// Indirect irradiance in a closed room, whatever its shape: of the lamp's flux, the fraction
/// `albedo` goes on after each reflection (energy is conserved), so the walls' mean is
/// `flux * albedo / (area * (1 - albedo))`.
fn expected_irradiance(lumens: f32) -> f32 {
    lumens * ALBEDO / (24.0 * (1.0 - ALBEDO))
}

#[test]
fn a_closed_room_holds_the_light_that_energy_conservation_says() {
    let mut stage = Stage::solved();
    stage.world().insert_resource(GiSettings {
        page_size: 128,
        max_pages: 1,
        texels_per_metre: 6.0,
        rays_per_texel: 256,
        converged_paths: 256,
        ..default()
    });
    let walls = room(&mut stage);
    let lamp = lamp(&mut stage, 100.0);
    solve(&mut stage);
    for lumens in [100.0, 300.0] {
        stage.world().get_mut::<PointLight>(lamp).unwrap().intensity = lumens;
        stage.update();
        solve(&mut stage);
        let (mean, expected) = (mean_irradiance(&mut stage, &walls), expected_irradiance(lumens));
        // The texels near the edges, which are dimmer, are left out of the mean.
        assert!(
            mean > 0.95 * expected && mean < 1.15 * expected,
            "{lumens} lm: {mean} lx, energy conservation says {expected} lx"
        );
    }
    let status = stage.world().resource::<GiStatus>();
    assert_eq!(status.receivers, 6);
    assert!(status.left_out.is_empty(), "{:?}", status.left_out);
    assert!(status.updates > 1 && status.uploaded_bytes > 0);
}

#[test]
fn a_moving_thing_in_the_room_is_lit_by_probes() {
    let mut stage = Stage::solved();
    stage.world().insert_resource(GiSettings {
        page_size: 64,
        max_pages: 1,
        texels_per_metre: 3.0,
        rays_per_texel: 256,
        rays_per_probe: 256,
        converged_paths: 64,
        ..default()
    });
    room(&mut stage);
    lamp(&mut stage, 40.0);
    let box_of_room = Transform::from_scale(Vec3::splat(2.0));
    stage.world().spawn((GiProbeVolume { resolution: UVec3::splat(3) }, box_of_room));
    let mesh = stage.world().resource_mut::<Assets<Mesh>>().add(Sphere::new(0.2));
    let material = stage.matte();
    stage.world().spawn((
        Mesh3d(mesh),
        MeshMaterial3d(material),
        Transform::from_xyz(0.0, -0.3, 0.2),
    ));
    let camera = stage.camera;
    let view = Transform::from_xyz(0.0, -0.3, 0.9).looking_at(Vec3::new(0.0, -0.3, 0.0), Vec3::Y);
    stage.world().entity_mut(camera).insert(view);
    solve(&mut stage);
    // The lower edge of the sphere, which the lamp above doesn't reach.
    let (x, y) = (SIZE / 2, SIZE / 2 + SIZE / 12);
    let at =
        |picture: &crate::support::headless::Picture| picture.pixels[(y * SIZE + x) as usize][1];
    let lit = at(&stage.picture());
    stage.world().resource_mut::<GiControl>().enabled = false;
    let direct = at(&stage.picture());
    assert!(lit > direct + 40, "{lit} with indirect light, {direct} without");
    // E / pi times the albedo is about what the walls send back, 20 lx / pi / 2.
    let expected =
        Srgba::from(LinearRgba::gray(expected_irradiance(40.0) / PI * ALBEDO)).green * 255.0;
    assert!((f32::from(lit) - expected).abs() < 40.0, "{lit}, about {expected} expected");
}

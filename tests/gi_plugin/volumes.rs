//! Probe volumes in rendered pictures.

use bevy::{light::IrradianceVolume, prelude::*};
use farlight::{gi::solver::sh::ShRgb, prelude::*};

use crate::pictures::{SIZE, Stage};

const AXES: [Vec3; 6] = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];

/// The same radiance from everywhere.
fn uniform(radiance: f32) -> ShRgb {
    let mut probe = ShRgb::ZERO;
    // The constant basis function is 1 / (2 sqrt(pi)).
    probe.0[0] = Vec3::splat(radiance * 2.0 * std::f32::consts::PI.sqrt());
    probe
}

/// Looks at the origin from a direction, two metres away.
fn look_from(stage: &mut Stage, direction: Vec3) {
    let up = if direction.y.abs() > 0.5 { Vec3::Z } else { Vec3::Y };
    let camera = stage.camera;
    let view = Transform::from_translation(direction * 2.0).looking_at(Vec3::ZERO, up);
    stage.world().entity_mut(camera).insert(view);
}

fn volume(stage: &mut Stage, resolution: UVec3) -> Entity {
    let scale = Transform::from_scale(Vec3::splat(8.0));
    let volume = stage.world().spawn((GiProbeVolume { resolution }, scale)).id();
    stage.settle();
    volume
}

#[test]
fn each_side_of_a_dynamic_mesh_is_lit_by_its_own_axis() {
    let mut stage = Stage::new();
    let quad = stage.quad(false);
    let volume = volume(&mut stage, UVec3::ONE);
    for axis in AXES {
        // Light from this axis alone: E / pi towards it, and nothing on the far side.
        let mut probe = ShRgb::ZERO;
        probe.add_direction(axis, Vec3::new(1.0, 0.5, 0.25));
        let near = probe.irradiance(axis) / std::f32::consts::PI;
        let far = (probe.irradiance(-axis) / std::f32::consts::PI).max(Vec3::ZERO);
        stage.mock.light_volume(volume, UVec3::ONE, vec![probe]);
        for (side, expected) in [(axis, near), (-axis, far)] {
            let facing = Transform::from_rotation(Quat::from_rotation_arc(Vec3::Z, side));
            stage.world().entity_mut(quad).insert(facing);
            look_from(&mut stage, side);
            let picture = stage.picture();
            stage.assert_pixel(&picture, SIZE / 2, SIZE / 2, expected * 0.5);
        }
    }
}

#[test]
fn probes_lie_along_the_axes_in_their_order() {
    let mut stage = Stage::new();
    let mesh = stage.world().resource_mut::<Assets<Mesh>>().add(Cuboid::from_length(0.2));
    let material = stage.matte();
    let cube = stage.world().spawn((Mesh3d(mesh), MeshMaterial3d(material))).id();
    for axis in 0..3 {
        let mut resolution = UVec3::ONE;
        resolution[axis] = 2;
        let volume = volume(&mut stage, resolution);
        stage.mock.light_volume(volume, resolution, vec![uniform(0.2), uniform(0.8)]);
        let direction = Vec3::AXES[axis];
        for (place, radiance) in [(-3.0, 0.2), (3.0, 0.8), (0.0, 0.5)] {
            let at = direction * place;
            stage.world().entity_mut(cube).insert(Transform::from_translation(at));
            let camera = stage.camera;
            let view = Transform::from_translation(at + Vec3::Z * 2.0).looking_at(at, Vec3::Y);
            stage.world().entity_mut(camera).insert(view);
            let picture = stage.picture();
            // Interpolation at the front face of the cube, 0.1 m in front of its centre.
            let shift = if axis == 2 { 0.1 / 4.0 * 0.6 } else { 0.0 };
            let expected = if place == 0.0 { radiance + shift } else { radiance };
            stage.assert_pixel(&picture, SIZE / 2, SIZE / 2, Vec3::splat(expected * 0.5));
        }
        stage.world().entity_mut(volume).despawn();
        stage.update();
    }
}

#[test]
fn volumes_switch_with_the_indirect_light_and_go_with_their_tag() {
    let mut stage = Stage::new();
    stage.quad(false);
    let volume = volume(&mut stage, UVec3::splat(2));
    stage.mock.light_volume(volume, UVec3::splat(2), vec![uniform(0.8); 8]);
    let picture = stage.picture();
    stage.assert_all(&picture, Vec3::splat(0.4));
    for (enabled, expected) in [(false, 0.0), (true, 0.4)] {
        stage.world().resource_mut::<GiControl>().enabled = enabled;
        let picture = stage.picture();
        stage.assert_all(&picture, Vec3::splat(expected));
    }
    // Another resolution makes another texture.
    stage.world().entity_mut(volume).insert(GiProbeVolume { resolution: UVec3::splat(3) });
    stage.settle();
    stage.mock.light_volume(volume, UVec3::splat(3), vec![uniform(0.4); 27]);
    let picture = stage.picture();
    stage.assert_all(&picture, Vec3::splat(0.2));
    stage.world().entity_mut(volume).remove::<GiProbeVolume>();
    stage.settle();
    assert!(!stage.world().entity(volume).contains::<IrradianceVolume>());
    let picture = stage.picture();
    stage.assert_all(&picture, Vec3::ZERO);
}

//! A floor between two walls, with a block on it, under an environment, seen from straight above.

use std::{f32::consts::FRAC_1_PI, time::Duration};

use bevy::{camera::ScalingMode, prelude::*};
use farlight::{
    core::LightingChanged,
    gi::{
        ExtractedScene,
        solver::{
            World as SolverWorld,
            estimate::{GatherSettings, no_progress},
            receiver::{Receiver, gather_receivers},
            session::SnapshotId,
        },
    },
    ibl::environment_maps::Environment,
    prelude::*,
};

use crate::stage::{SIZE, Stage};

/// Metres that the camera sees.
const WIDTH: f32 = 3.2;
/// What the floor reflects.
const FLOOR: Vec3 = Vec3::new(0.6, 0.6, 0.55);
/// Seen from straight above, Burley's diffuse with this perceptual roughness is Lambert's on the mean
/// over all directions of light: the integral of (-0.5 + r (1 + c)) (1 - c)^5 c over c, the cosine to
/// the light, is 0 for r = 0.4, the square of it.
const ROUGHNESS: f32 = 0.632;

pub(crate) struct Terrace {
    pub(crate) stage: Stage,
    pub(crate) camera: Entity,
    pub(crate) floor: Entity,
}

/// A map with a soft sun, a blue side and a dark ground.
fn map() -> Environment {
    let texels = (0..64 * 32).map(|i| {
        let (x, y) = (i % 64, i / 64);
        match (x, y) {
            (40..44, 5..9) => Vec3::new(24.0, 20.0, 15.0),
            (10..30, 4..16) => Vec3::new(0.4, 0.7, 1.4),
            (_, 0..16) => Vec3::new(0.6, 0.7, 0.8),
            _ => Vec3::new(0.15, 0.12, 0.1),
        }
    });
    Environment::from_equirect(64, 32, texels.collect()).unwrap()
}

impl Terrace {
    pub(crate) fn new() -> Self {
        let mut stage = Stage::new();
        stage.world().insert_resource(GiSettings {
            page_size: 128,
            max_pages: 1,
            texels_per_metre: 5.0,
            rays_per_texel: 256,
            converged_paths: 1024,
            ..default()
        });
        let floor = thing(&mut stage, FLOOR, Vec3::new(4.0, 0.2, 4.0), Vec3::Y * -0.1);
        let red = Vec3::new(0.9, 0.5, 0.4);
        thing(&mut stage, red, Vec3::new(0.2, 2.4, 4.0), Vec3::new(-1.5, 1.2, 0.0));
        thing(&mut stage, red, Vec3::new(4.0, 2.4, 0.2), Vec3::new(0.0, 1.2, 1.5));
        let white = Vec3::splat(0.8);
        thing(&mut stage, white, Vec3::new(0.8, 0.5, 0.8), Vec3::new(0.9, 0.25, -0.8));
        let settings = ProgressiveLighting { brightness: 0.5, shadow_distance: 20.0, ..default() };
        stage.light(map(), settings);
        let camera = stage.camera(Vec3::Y * 6.0, Vec3::X);
        stage.world().entity_mut(camera).insert((
            Transform::from_xyz(0.0, 6.0, 0.0).looking_at(Vec3::ZERO, Vec3::NEG_Z),
            Projection::from(OrthographicProjection {
                scaling_mode: ScalingMode::Fixed { width: WIDTH, height: WIDTH },
                far: 20.0,
                ..OrthographicProjection::default_3d()
            }),
        ));
        Self { stage, camera, floor }
    }

    /// Adds probes, and a board of the floor's material in the air, which isn't solved for. Answers the
    /// height of its upper side and whether it is seen at a place.
    pub(crate) fn add_board(&mut self) -> (f32, impl Fn(f32, f32) -> bool + use<>) {
        let volume = Transform::from_xyz(0.0, 1.2, 0.0).with_scale(Vec3::new(4.0, 2.4, 4.0));
        self.stage.spawn((GiProbeVolume { resolution: UVec3::new(8, 6, 8) }, volume));
        let (edge, place) = (0.8, Vec3::new(-0.3, 0.8, 0.4));
        moving(&mut self.stage, FLOOR, Vec3::new(edge, 0.04, edge), place);
        let inside = edge * 0.5 - WIDTH / SIZE as f32;
        (place.y + 0.02, move |x, z| (x - place.x).abs().max((z - place.z).abs()) < inside)
    }

    /// Frames until light is solved and shown, and the picture refined.
    pub(crate) fn rest(&mut self) {
        let camera = self.camera;
        let rested = self.stage.headless.update_until(
            "light and picture",
            Duration::from_secs(120),
            |world| {
                let status = world.resource::<GiStatus>();
                assert!(!matches!(status.state, GiState::Failed { .. }), "{:?}", status.state);
                let refined = world.get::<Refinement>(camera).is_some_and(Refinement::is_refined);
                status.state == GiState::Converged && status.shown == status.submitted && refined
            },
        );
        rested.unwrap_or_else(|problem| {
            panic!("{problem}: {:?}, {:?}", self.told(), self.refinement())
        });
    }

    pub(crate) fn refinement(&mut self) -> Option<Refinement> {
        self.stage.world().get::<Refinement>(self.camera).copied()
    }

    /// What must not change in a still scene.
    pub(crate) fn told(&mut self) -> (GiState, SnapshotId, u64, u64) {
        let status = self.stage.world().resource::<GiStatus>();
        (status.state.clone(), status.submitted, status.updates, status.uploaded_bytes)
    }

    /// Whether solved light on surfaces became another in the last frame or two.
    pub(crate) fn relit(&mut self) -> bool {
        !self.stage.world().resource::<Messages<LightingChanged>>().is_empty()
    }

    /// Whether the floor is seen there, well away from walls and block: bilinear lookups blur contacts.
    pub(crate) fn is_free(x: f32, z: f32) -> bool {
        let block = (x - 0.9).abs().max((z + 0.8).abs()) < 0.4 + 0.25;
        x > -1.4 + 0.25 && z < 1.4 - 0.25 && !block
    }

    /// What the picture shows where `is_part`, of a surface of the floor's material at a height that faces
    /// up; what the path tracer says of it; and its part that comes straight from the sky.
    pub(crate) fn against_reference(
        &mut self,
        height: f32,
        is_part: impl Fn(f32, f32) -> bool,
    ) -> Vec<[f32; 3]> {
        let picture = self.stage.floats();
        let mut pixels = Vec::new();
        let mut receivers = Vec::new();
        for y in (1..SIZE).step_by(2) {
            for x in (1..SIZE).step_by(2) {
                let at = |i: u32| ((i as f32 + 0.5) / SIZE as f32 - 0.5) * WIDTH;
                let (x_world, z_world) = (at(x), at(y));
                if !is_part(x_world, z_world) {
                    continue;
                }
                pixels.push(picture[(y * SIZE + x) as usize]);
                let position = Vec3::new(x_world, height, z_world);
                receivers.push(Receiver { position, normal: Vec3::Y });
            }
        }
        let scene = self.stage.world().resource::<ExtractedScene>().scene.clone();
        let settings = GatherSettings { paths: 2048, seed: 7 };
        let world = SolverWorld::new(&scene);
        let light = gather_receivers(&world, &receivers, &settings, no_progress()).unwrap();
        let shown = |irradiance: Vec3| (irradiance * FLOOR * FRAC_1_PI).element_sum();
        pixels
            .iter()
            .zip(&light)
            .map(|(pixel, light)| {
                let whole = shown(light.direct.mean + light.indirect.mean);
                [pixel.element_sum(), whole, shown(light.direct.mean)]
            })
            .collect()
    }
}

/// A box that takes part in the indirect light.
fn thing(stage: &mut Stage, albedo: Vec3, size: Vec3, place: Vec3) -> Entity {
    let thing = moving(stage, albedo, size, place);
    stage.world().entity_mut(thing).insert(GiScene);
    thing
}

/// A box that moves, as far as lighting knows.
fn moving(stage: &mut Stage, albedo: Vec3, size: Vec3, place: Vec3) -> Entity {
    let mesh = stage.mesh(Cuboid::from_size(size));
    let material = stage.material(StandardMaterial {
        base_color: Color::linear_rgb(albedo.x, albedo.y, albedo.z),
        perceptual_roughness: ROUGHNESS,
        reflectance: 0.0,
        ..default()
    });
    stage.spawn((mesh, material, Transform::from_translation(place)))
}

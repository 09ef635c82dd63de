//! What is shown now, and how it becomes so.

use std::path::Path;

use bevy::{camera::Exposure, prelude::*};
use farlight::{
    ibl::{EnvironmentDots, environment_maps::Method},
    prelude::*,
};

/// cd/m² of a value of 1 in the maps that ship.
const BRIGHTNESS: f32 = 1000.0;
/// The maps that ship.
const NAMES: [&str; 5] = ["studio", "sky", "interior", "overcast", "evening"];

/// An environment to choose.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// What it is called.
    pub name: String,
    /// Its file, relative to the assets, or absolute.
    pub path: String,
}

/// What is shown.
#[derive(Resource, Clone, Debug, PartialEq)]
pub struct Shown {
    /// What there is to choose from.
    pub environments: Vec<Choice>,
    /// Index of the environment.
    pub environment: usize,
    /// Lights that stand for it.
    pub lights: u32,
    /// How many shine in a frame.
    pub per_frame: u32,
    /// How they are chosen.
    pub method: Method,
    /// Whether they shine.
    pub progressive: bool,
    /// Whether pictures are accumulated.
    pub accumulate: bool,
    /// Whether Bevy's image-based light takes over where they don't.
    pub image_based: bool,
    /// Whether they cast shadows.
    pub shadows: bool,
    /// Turn of the environment in degrees.
    pub turn: f32,
    /// Whether the camera sways.
    pub sway: bool,
    /// Whether the lights are drawn on the sky.
    pub dots: bool,
    /// Whether the flat map is shown.
    pub map: bool,
    /// Exposure value at ISO 100.
    pub exposure: f32,
}

impl Default for Shown {
    fn default() -> Self {
        let choice =
            |name: &str| Choice { name: name.into(), path: format!("environments/{name}.hdr") };
        Self {
            environments: NAMES.map(choice).to_vec(),
            environment: 0,
            lights: 200,
            per_frame: 5,
            method: Method::default(),
            progressive: true,
            accumulate: true,
            image_based: true,
            shadows: true,
            turn: 0.0,
            sway: false,
            dots: false,
            map: true,
            exposure: 9.7,
        }
    }
}

impl Shown {
    /// The chosen environment.
    pub fn chosen(&self) -> &Choice {
        &self.environments[self.environment % self.environments.len()]
    }
}

/// A shipped environment by its name, or a file, relative to where the program was started.
pub fn environment(name: &str) -> Result<Choice, String> {
    if NAMES.contains(&name) {
        return Ok(Choice { name: name.into(), path: format!("environments/{name}.hdr") });
    }
    let path = std::path::absolute(name).ok().filter(|path| path.is_file());
    let path = path.ok_or_else(|| {
        format!("--environment {name}: no such file, and none of {}", NAMES.join(", "))
    })?;
    let stem = Path::new(name).file_stem().unwrap_or_default();
    Ok(Choice {
        name: stem.to_string_lossy().into_owned(),
        path: path.to_string_lossy().into_owned(),
    })
}

/// Makes it so.
pub fn apply(
    mut commands: Commands,
    shown: Res<Shown>,
    server: Res<AssetServer>,
    mut lighting: ResMut<ProgressiveLighting>,
    mut cameras: Query<(Entity, &mut ProgressiveCamera, &mut Exposure)>,
) {
    if !shown.is_changed() {
        return;
    }
    lighting.set_if_neq(ProgressiveLighting {
        enabled: shown.progressive,
        environment: Some(server.load(&shown.chosen().path)),
        rotation: Quat::from_rotation_y(shown.turn.to_radians()),
        brightness: BRIGHTNESS,
        lights: shown.lights,
        per_frame: shown.per_frame,
        method: shown.method,
        shadows: shown.shadows,
        shadow_distance: 20.0,
        ..default()
    });
    for (entity, mut camera, mut exposure) in &mut cameras {
        camera.set_if_neq(ProgressiveCamera { accumulate: shown.accumulate, ..*camera });
        if exposure.ev100 != shown.exposure {
            exposure.ev100 = shown.exposure;
        }
        let mut camera = commands.entity(entity);
        if shown.image_based {
            camera.insert_if_new(ImageBasedFallback);
        } else {
            camera.remove::<ImageBasedFallback>();
        }
        if shown.dots {
            camera.insert_if_new(EnvironmentDots::default());
        } else {
            camera.remove::<EnvironmentDots>();
        }
    }
}

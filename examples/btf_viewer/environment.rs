//! The environment: read in a thread, then light and backdrop of the camera.

use std::collections::HashMap;

use bevy::{
    light::Skybox,
    prelude::*,
    tasks::{AsyncComputeTaskPool, Task, futures::check_ready},
};

use super::{
    equirect::{self, Cubes},
    state::{self, Config, Problems, Shown},
};

/// An environment's maps.
enum Entry {
    Reading(Task<Result<Cubes, String>>),
    Ready { backdrop: Handle<Image>, specular: Handle<Image>, diffuse: Handle<Image> },
    Failed(String),
}

/// All environments that were shown, by path.
#[derive(Resource, Default)]
pub struct Environments(HashMap<String, Entry>);

impl Environments {
    /// Whether the chosen one is still being read.
    pub fn busy(&self) -> bool {
        self.0.values().any(|entry| matches!(entry, Entry::Reading(_)))
    }
}

/// Reads the chosen environment and gives it to the camera.
pub fn show(
    mut commands: Commands,
    config: Res<Config>,
    shown: Res<Shown>,
    mut environments: ResMut<Environments>,
    mut images: ResMut<Assets<Image>>,
    mut problems: ResMut<Problems>,
    camera: Single<Entity, With<Camera3d>>,
) {
    for entry in environments.0.values_mut() {
        let Entry::Reading(task) = entry else { continue };
        match check_ready(task) {
            None => {}
            Some(Ok(Cubes { backdrop, specular, diffuse })) => {
                let [backdrop, specular, diffuse] =
                    [backdrop, specular, diffuse].map(|image| images.add(image));
                *entry = Entry::Ready { backdrop, specular, diffuse };
            }
            Some(Err(message)) => {
                error!("{message}");
                *entry = Entry::Failed(message);
            }
        }
    }
    let chosen = shown.environment.and_then(|i| config.0.environments.get(i));
    let Some(chosen) = chosen else {
        problems.environment = None;
        commands.entity(*camera).remove::<(Skybox, EnvironmentMapLight)>();
        return;
    };
    let entry = environments.0.entry(chosen.path.clone()).or_insert_with(|| {
        let path = state::on_disk(&chosen.path);
        Entry::Reading(AsyncComputeTaskPool::get().spawn(async move { equirect::read(&path) }))
    });
    match entry {
        Entry::Reading(_) => {}
        Entry::Failed(message) => {
            problems.environment = Some(message.clone());
            commands.entity(*camera).remove::<(Skybox, EnvironmentMapLight)>();
        }
        Entry::Ready { backdrop, specular, diffuse } => {
            problems.environment = None;
            // It turns with the lamps.
            let turn = chosen.turn + shown.light_direction.x - config.0.light.direction.0;
            let rotation = Quat::from_rotation_y(turn.to_radians());
            commands.entity(*camera).insert(EnvironmentMapLight {
                diffuse_map: diffuse.clone(),
                specular_map: specular.clone(),
                intensity: chosen.brightness,
                rotation,
                ..default()
            });
            if shown.backdrop {
                commands.entity(*camera).insert(Skybox {
                    image: Some(backdrop.clone()),
                    brightness: chosen.brightness,
                    rotation,
                });
            } else {
                commands.entity(*camera).remove::<Skybox>();
            }
        }
    }
}

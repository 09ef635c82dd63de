//! What the gallery's cameras have, and how they are exposed.

use bevy::{
    camera::{Exposure, Hdr},
    core_pipeline::tonemapping::Tonemapping,
    light::Skybox,
    prelude::*,
    render::renderer::RenderAdapterInfo,
};
use farlight::{
    panel::PanelCamera,
    xr::{DesktopCamera, XrEye},
};

use super::{
    moving::Visitor,
    plan::{ENTRANCE, Floor, HALL, RED, WINDOW},
    settings::Gallery,
    sky::{SkyPicture, skybox},
};

/// Height of eyes above the floor, in metres, of who wears no headset.
pub const EYES: f32 = 1.62;
/// Field of view across the height of a window, in degrees.
pub const FIELD: f32 = 62.0;
/// Seconds in which eyes get used to two thirds of another room's light.
const ADAPTATION: f32 = 0.8;

/// The exposure value at ISO 100 that somebody in a place has got used to.
#[derive(Resource, Clone, Copy, Debug)]
pub struct Adapted(pub f32);

impl Default for Adapted {
    fn default() -> Self {
        Self(exposure(ENTRANCE, &Floor::default()))
    }
}

/// What a photographer would choose in a room, as exposure value at ISO 100.
pub fn exposure(place: Vec3, floor: &Floor) -> f32 {
    match floor.room(place.with_y(1.0)) {
        Some(RED) => 6.7,
        Some(WINDOW) => 7.8,
        Some(HALL) => 8.7,
        // In the doors, between both.
        _ if place.x > 0.0 => 7.7,
        _ => 8.2,
    }
}

/// Makes the camera of the desktop.
pub fn spawn(mut commands: Commands, picture: Res<SkyPicture>) {
    let visitor = Visitor { yaw: 0.0, pitch: -0.06 };
    commands.spawn((
        Name::new("visitor"),
        (DesktopCamera, PanelCamera),
        Camera3d::default(),
        Projection::Perspective(PerspectiveProjection {
            fov: FIELD.to_radians(),
            near: 0.05,
            ..default()
        }),
        visitor,
        visitor.transform(ENTRANCE + Vec3::Y * EYES),
        of_every_camera(&picture),
    ));
}

/// What all cameras have.
pub fn of_every_camera(picture: &SkyPicture) -> impl Bundle {
    (Hdr, Tonemapping::TonyMcMapface, Exposure { ev100: Adapted::default().0 }, skybox(picture))
}

/// Eyes see as the camera of the desktop does, whenever they come.
pub fn open_eyes(
    eyes: Query<Entity, (With<XrEye>, Without<Skybox>)>,
    picture: Option<Res<SkyPicture>>,
    mut commands: Commands,
) {
    let Some(picture) = picture else { return };
    for eye in &eyes {
        commands.entity(eye).insert(of_every_camera(&picture));
    }
}

/// Many samples a pixel on graphics processors; drawing on the CPU they would halve the frame rate.
pub fn smooth_edges(
    adapter: Option<Res<RenderAdapterInfo>>,
    new: Query<Entity, (With<Camera3d>, Added<Exposure>)>,
    mut commands: Commands,
) {
    let on_cpu = adapter.is_some_and(|info| format!("{:?}", info.device_type) == "Cpu");
    for camera in &new {
        commands.entity(camera).insert(if on_cpu { Msaa::Off } else { Msaa::Sample4 });
    }
}

/// Eyes get used to the room that they are in; both to the same.
pub fn adapt(
    time: Res<Time>,
    floor: Res<Floor>,
    gallery: Res<Gallery>,
    mut adapted: ResMut<Adapted>,
    mut cameras: Query<(&mut Exposure, &Camera, &GlobalTransform)>,
) {
    let seen = cameras.iter().find(|(_, camera, _)| camera.is_active);
    if let Some((.., transform)) = seen {
        let wanted = exposure(transform.translation(), &floor);
        let part = 1.0 - (-time.delta_secs() / ADAPTATION).exp();
        adapted.0 += (wanted - adapted.0) * part;
    }
    for (mut exposure, ..) in &mut cameras {
        let ev100 = adapted.0 - gallery.exposure;
        if (exposure.ev100 - ev100).abs() > 1e-3 {
            exposure.ev100 = ev100;
        }
    }
}

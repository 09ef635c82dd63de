//! The cameras of both eyes, and what the runtime says of them.

use bevy::{
    camera::{ManualTextureViewHandle, RenderTarget, ShadowLodOrigin},
    prelude::*,
    render::{
        Extract, ExtractSchedule, Render, RenderApp, render_resource::PollType,
        renderer::RenderDevice, texture::ManualTextureViews,
    },
};
use bevy_mod_openxr::{
    init::should_run_frame_loop,
    render::{OxrWaitFrameSystem, XR_TEXTURE_INDEX, locate_views},
    resources::{OxrCurrentSessionConfig, OxrFrameState, OxrSessionStarted, OxrViews},
};
use bevy_mod_xr::{
    camera::XrViewInit,
    session::{
        XrFirst, XrHandleEvents, XrPreDestroySession, XrRenderSystems, XrSessionCreated, XrState,
    },
};

use crate::{
    FarlightXr, Fov, XrEye, XrHandPose, XrHead, XrSystems, XrTracking, XrView, eye_camera,
};
use farlight_bindings::Hand;

#[derive(Resource, Clone, Copy)]
struct Near(f32);

pub(super) fn build(app: &mut App, settings: &FarlightXr) {
    app.insert_resource(Near(settings.near))
        .add_systems(XrSessionCreated, spawn.after(XrViewInit))
        .add_systems(XrPreDestroySession, despawn)
        .add_systems(XrFirst, activate.after(OxrWaitFrameSystem).in_set(XrHandleEvents::FrameLoop))
        .add_systems(
            PostUpdate,
            read_views.after(locate_views).before(XrSystems::Follow).run_if(should_run_frame_loop),
        );
    if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
        render_app
            .init_resource::<DrawnViews>()
            .add_systems(XrPreDestroySession, finish_drawing)
            .add_systems(ExtractSchedule, extract_views)
            .add_systems(
                Render,
                submit_drawn_views
                    .run_if(should_run_frame_loop)
                    .after(locate_views)
                    .before(XrRenderSystems::PostRender),
            );
    }
}

fn spawn(
    config: Option<Res<OxrCurrentSessionConfig>>,
    near: Res<Near>,
    heads: Query<(), With<XrHead>>,
    hands: Query<&XrHandPose>,
    mut commands: Commands,
) {
    let Some(config) = config else { return };
    info!("each eye sees {} x {} pixels", config.resolution.x, config.resolution.y);
    for index in 0..2 {
        let target = RenderTarget::TextureView(ManualTextureViewHandle(XR_TEXTURE_INDEX + index));
        let mut eye = commands.spawn((eye_camera(index, near.0), target, OfSession));
        if index == 0 {
            // Shadows of lamps are as fine as they must be for who wears the headset.
            eye.insert(ShadowLodOrigin);
        }
    }
    if heads.is_empty() {
        commands.spawn((Name::new("head"), XrHead));
    }
    for hand in Hand::ALL {
        for aim in [false, true] {
            let pose = XrHandPose { hand, aim };
            if !hands.iter().any(|known| *known == pose) {
                let side = hand.name().to_lowercase();
                let what = if aim { "aim" } else { "grip" };
                commands.spawn((Name::new(format!("{side} {what}")), pose));
            }
        }
    }
}

/// An entity that ends with the session.
#[derive(Component)]
struct OfSession;

fn despawn(
    eyes: Query<Entity, With<OfSession>>,
    mut views: ResMut<ManualTextureViews>,
    mut commands: Commands,
) {
    for eye in &eyes {
        commands.entity(eye).despawn();
    }
    for index in 0..2 {
        views.remove(&ManualTextureViewHandle(XR_TEXTURE_INDEX + index));
    }
}

/// Eyes draw when the runtime wants pictures; never into what it has taken back.
fn activate(
    started: Option<Res<OxrSessionStarted>>,
    state: Option<Res<XrState>>,
    frame: Option<Res<OxrFrameState>>,
    mut eyes: Query<&mut Camera, (With<XrEye>, With<OfSession>)>,
) {
    let is_wanted =
        should_run_frame_loop(started, state) && frame.is_some_and(|frame| frame.should_render);
    for mut camera in &mut eyes {
        if camera.is_active != is_wanted {
            camera.is_active = is_wanted;
        }
    }
}

/// Pictures of the runtime must not go while they are being drawn.
fn finish_drawing(device: Res<RenderDevice>) {
    if let Err(error) = device.poll(PollType::wait_indefinitely()) {
        debug!("the graphics device doesn't finish: {error}");
    }
}

fn read_views(located: Option<Res<OxrViews>>, mut tracking: ResMut<XrTracking>) {
    let Some(located) = located else { return };
    let [left, right] = located.0[..] else { return };
    let eyes = Some([left, right].map(|view| XrView {
        pose: isometry(view.pose),
        fov: Fov {
            left: view.fov.angle_left,
            right: view.fov.angle_right,
            up: view.fov.angle_up,
            down: view.fov.angle_down,
        },
    }));
    if tracking.eyes != eyes {
        tracking.eyes = eyes;
    }
}

/// A pose as Bevy has them. A rotation that is none (some runtimes say zeros at first) is no turn.
pub(super) fn isometry(pose: openxr::Posef) -> Isometry3d {
    let (p, q) = (pose.position, pose.orientation);
    let rotation = Quat::from_xyzw(q.x, q.y, q.z, q.w);
    let rotation =
        if rotation.length_squared() > 0.5 { rotation.normalize() } else { Quat::IDENTITY };
    Isometry3d::new(Vec3::new(p.x, p.y, p.z), rotation)
}

/// What the eyes of the frame were drawn from.
#[derive(Resource, Default)]
struct DrawnViews(Vec<openxr::View>);

fn extract_views(located: Extract<Option<Res<OxrViews>>>, mut drawn: ResMut<DrawnViews>) {
    if let Some(located) = &*located {
        drawn.0.clone_from(&located.0);
    }
}

/// The runtime is told the poses that the frame was drawn from, so that it corrects exactly what has
/// changed since. (The render world's own, later ones would be nearer to what is to come, but light
/// that refines itself, motion vectors, shadows and what is culled go by the earlier ones.)
fn submit_drawn_views(drawn: Res<DrawnViews>, located: Option<ResMut<OxrViews>>) {
    if let Some(mut located) = located
        && drawn.0.len() == 2
    {
        located.0.clone_from(&drawn.0);
    }
}

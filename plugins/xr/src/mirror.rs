//! What an eye sees, on the desktop. The picture is that of the eye: the scene isn't drawn again.

use bevy::{
    core_pipeline::{Core2d, Core2dSystems, FullscreenShader},
    prelude::*,
    render::{
        Render, RenderApp, RenderSystems,
        extract_component::{ExtractComponent, ExtractComponentPlugin},
        render_resource::PipelineCache,
        renderer::{RenderContext, ViewQuery},
        view::{ExtractedView, ViewTarget},
    },
    window::PrimaryWindow,
};

use crate::{XrEye, XrStatus, show::Shower};

/// A camera that shows what an eye sees, instead of anything of its own: the middle of it, so that all of
/// the window is filled. User interfaces can be drawn over it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, ExtractComponent)]
#[require(Camera2d, Msaa = Msaa::Off)]
pub struct XrMirror {
    /// 0 is left, 1 right.
    pub eye: u32,
}

/// A mirror that is there because the app has a window.
#[derive(Component)]
struct OfWindow;

pub(crate) fn build(app: &mut App, of_window: bool) {
    if app.get_sub_app(RenderApp).is_none() {
        return;
    }
    app.add_plugins(ExtractComponentPlugin::<XrMirror>::default());
    if of_window {
        app.add_systems(First, mirror_in_window);
    }
    if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
        render_app.add_systems(Render, prepare.in_set(RenderSystems::Prepare)).add_systems(
            Core2d,
            mirror.after(Core2dSystems::MainPass).before(Core2dSystems::EarlyPostProcess),
        );
    }
}

fn mirror_in_window(
    status: Res<XrStatus>,
    windows: Query<(), With<PrimaryWindow>>,
    mirrors: Query<Entity, With<OfWindow>>,
    mut commands: Commands,
) {
    let wanted = *status == XrStatus::Running && !windows.is_empty();
    if wanted && mirrors.is_empty() {
        // Behind whatever else the app draws into its window.
        let camera = Camera { order: -1, ..default() };
        commands.spawn((Name::new("mirror"), XrMirror::default(), camera, OfWindow));
    } else if !wanted {
        for mirror in &mirrors {
            commands.entity(mirror).despawn();
        }
    }
}

fn prepare(
    mut shower: ResMut<Shower>,
    cache: Res<PipelineCache>,
    server: Res<AssetServer>,
    fullscreen: Res<FullscreenShader>,
    mirrors: Query<&ExtractedView, With<XrMirror>>,
) {
    for view in &mirrors {
        shower.pipeline(view.target_format, &cache, &server, &fullscreen);
    }
}

fn mirror(
    view: ViewQuery<(&XrMirror, &ViewTarget)>,
    eyes: Query<(&XrEye, &ViewTarget)>,
    shower: Res<Shower>,
    cache: Res<PipelineCache>,
    mut context: RenderContext,
) {
    let (mirror, target) = view.into_inner();
    let Some((_, eye)) = eyes.iter().find(|(eye, _)| eye.index == mirror.eye) else { return };
    let size = |target: &ViewTarget| {
        let size = target.main_texture().size();
        Vec2::new(size.width as f32, size.height as f32)
    };
    let part = filling(size(eye), size(target));
    let into = (target.main_texture_view(), target.main_texture_format());
    shower.show(&mut context, &cache, eye.main_texture_view(), part, into);
}

/// Size and place of the largest part in the middle of a picture that has a window's shape.
fn filling(picture: Vec2, window: Vec2) -> Vec4 {
    let wider = (window.x / window.y.max(1.0)) / (picture.x / picture.y.max(1.0)).max(1e-6);
    let size = if wider > 1.0 { Vec2::new(1.0, 1.0 / wider) } else { Vec2::new(wider, 1.0) };
    let place = (Vec2::ONE - size) / 2.0;
    Vec4::new(size.x, size.y, place.x, place.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_fills_the_window() {
        let square = Vec2::splat(512.0);
        assert_eq!(filling(square, square), Vec4::new(1.0, 1.0, 0.0, 0.0));
        assert_eq!(filling(square, Vec2::new(1000.0, 500.0)), Vec4::new(1.0, 0.5, 0.0, 0.25));
        assert_eq!(filling(square, Vec2::new(500.0, 1000.0)), Vec4::new(0.5, 1.0, 0.25, 0.0));
    }
}

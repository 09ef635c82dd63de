//! The whole map in a corner, with its lights.

use bevy::{
    asset::RenderAssetUsages,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use farlight::{
    ibl::{EnvironmentLights, PER_FRAME},
    prelude::*,
};

use super::shown::Shown;

/// Size of the map in pixels.
const SIZE: UVec2 = UVec2::new(320, 160);
/// Edge of the dots of this frame in pixels.
const DOT: f32 = 9.0;

/// The map.
#[derive(Component)]
pub struct FlatMap;

/// A light of this frame, by its place among them.
#[derive(Component)]
pub struct Mark(usize);

/// Makes it.
pub fn spawn(mut commands: Commands) {
    let node = Node {
        position_type: PositionType::Absolute,
        bottom: px(12),
        right: px(12),
        width: px(SIZE.x),
        height: px(SIZE.y),
        overflow: Overflow::clip(),
        ..default()
    };
    commands.spawn((FlatMap, node, ImageNode::default(), Visibility::Hidden)).with_children(
        |map| {
            for place in 0..*PER_FRAME.end() as usize {
                let node = Node {
                    position_type: PositionType::Absolute,
                    width: px(DOT),
                    height: px(DOT),
                    margin: UiRect::all(px(-0.5 * DOT)),
                    border: UiRect::all(px(1.5)),
                    border_radius: BorderRadius::MAX,
                    ..default()
                };
                let orange = BackgroundColor(Color::srgb(1.0, 0.6, 0.1));
                map.spawn((Mark(place), node, orange, BorderColor::all(Color::BLACK)));
            }
        },
    );
}

/// Paints map and lights where they are others.
pub fn paint(
    shown: Res<Shown>,
    lighting: Res<ProgressiveLighting>,
    lights: EnvironmentLights,
    maps: Res<Assets<EnvironmentMap>>,
    mut images: ResMut<Assets<Image>>,
    mut flat: Query<(&mut ImageNode, &mut Visibility), With<FlatMap>>,
) {
    let Ok((mut node, mut visibility)) = flat.single_mut() else { return };
    let wanted = if shown.map { Visibility::Inherited } else { Visibility::Hidden };
    let map = lighting.environment.as_ref().and_then(|map| maps.get(map));
    let Some(map) = map.filter(|_| shown.map && !lights.all().is_empty()) else {
        visibility.set_if_neq(Visibility::Hidden);
        return;
    };
    visibility.set_if_neq(wanted);
    if !lights.are_others() && !visibility.is_changed() {
        return;
    }
    let mut pixels = Vec::with_capacity((SIZE.x * SIZE.y * 4) as usize);
    let (width, height) = (map.0.width(), map.0.height());
    for y in 0..SIZE.y {
        for x in 0..SIZE.x {
            let [x, y] = [x * width / SIZE.x, y * height / SIZE.y];
            let radiance = 0.7 * map.0.texels()[(y * width + x) as usize];
            // Reinhard's curve, channel by channel: a small picture.
            let seen = radiance / (1.0 + radiance) * 1.4;
            pixels.extend(Color::linear_rgb(seen.x, seen.y, seen.z).to_srgba().to_u8_array());
        }
    }
    for light in lights.all() {
        let place = (place(light.direction) * SIZE.as_vec2()).as_uvec2();
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let [x, y] = [(place.x + dx) % SIZE.x, (place.y + dy).min(SIZE.y - 1)];
            let at = ((y * SIZE.x + x) * 4) as usize;
            let bright = if dx == 1 && dy == 1 { [0; 3] } else { [255; 3] };
            pixels[at..at + 3].copy_from_slice(&bright);
        }
    }
    node.image = images.add(Image::new(
        Extent3d { width: SIZE.x, height: SIZE.y, depth_or_array_layers: 1 },
        TextureDimension::D2,
        pixels,
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::RENDER_WORLD,
    ));
}

/// Moves the marks to the lights of this frame.
pub fn mark(lights: EnvironmentLights, mut marks: Query<(&Mark, &mut Node, &mut Visibility)>) {
    let shining = lights.shining();
    for (mark, mut node, mut visibility) in &mut marks {
        let light = shining.clone().nth(mark.0).and_then(|light| lights.all().get(light));
        let wanted = if light.is_some() { Visibility::Inherited } else { Visibility::Hidden };
        visibility.set_if_neq(wanted);
        if let Some(light) = light {
            let place = place(light.direction) * 100.0;
            (node.left, node.top) = (percent(place.x), percent(place.y));
        }
    }
}

/// Where a direction lies in the map, 0 to 1.
fn place(direction: Vec3) -> Vec2 {
    use std::f32::consts::{PI, TAU};
    let u = 0.5 + direction.x.atan2(-direction.z) / TAU;
    Vec2::new(u, direction.y.clamp(-1.0, 1.0).acos() / PI)
}

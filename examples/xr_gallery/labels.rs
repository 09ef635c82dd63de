//! What hangs on the walls: cards that say what is shown, and two paintings. Their pictures are made here,
//! text by egui's fonts, with all coarser copies, so that they are sharp and don't shimmer.

use bevy::prelude::*;
use farlight::{
    panel::egui::{
        Color32, FontDefinitions, FontFamily, FontId,
        epaint::{
            ColorImage,
            text::{Fonts, FontsView, TextOptions},
        },
    },
    prelude::*,
};

use super::textures;

/// Pixels a metre of a card.
const DENSITY: f32 = 2600.0;
/// Points a metre: a point of text is a millimetre.
const POINTS: f32 = 1000.0;
/// Linear colours of card and ink.
const CARD: Vec3 = Vec3::new(0.80, 0.79, 0.76);
const INK: Vec3 = Vec3::new(0.035, 0.035, 0.04);

/// A card on a wall.
struct Card {
    /// Its middle, on the wall.
    at: Vec3,
    /// Where it faces.
    normal: Vec3,
    /// Width and height in metres.
    size: Vec2,
    title: &'static str,
    text: &'static str,
}

const fn card(at: [f32; 3], normal: Vec3, title: &'static str, text: &'static str) -> Card {
    Card { at: Vec3::from_array(at), normal, size: Vec2::new(0.30, 0.15), title, text }
}

const CARDS: &[Card] = &[
    Card {
        at: Vec3::new(-1.55, 1.55, -3.0),
        normal: Vec3::Z,
        size: Vec2::new(0.62, 0.40),
        title: "Second light",
        text: "Sun and lantern are the only lamps here. All else is light that walls, floors and \
               ceilings give to each other, solved while you look.\n\nTake the lantern in the red room \
               and carry it about.",
    },
    card(
        [2.2, 1.45, -3.0],
        Vec3::Z,
        "Sphere",
        "A twill of indigo and ecru cotton, as measured from \
          every direction of light and view.",
    ),
    card([-3.35, 1.45, -3.0], Vec3::Z, "Rabbit", "The same cloth, cut and laid as a tailor would."),
    card(
        [5.55, 1.45, -3.0],
        Vec3::Z,
        "Rabbit, plaster",
        "It is white. What is red on it came from the \
          wall.",
    ),
    card([8.5, 1.45, -3.0], Vec3::Z, "Sphere, porcelain", "Lit by probes, as all that can move."),
    card([9.4, 1.45, 0.9], Vec3::NEG_X, "Small things", "Please touch."),
    card(
        [-8.0, 1.45, -3.0],
        Vec3::Z,
        "Drape",
        "A square of cloth that has fallen over a ball. Light \
          comes from the window, and from the blue wall.",
    ),
];

/// A painting on a wall.
struct Painting {
    at: Vec3,
    normal: Vec3,
    size: Vec2,
    /// Linear colours of its squares, from the outermost on.
    colours: [Vec3; 4],
}

const PAINTINGS: &[Painting] = &[
    Painting {
        at: Vec3::new(0.0, 1.95, -3.0),
        normal: Vec3::Z,
        size: Vec2::new(1.7, 1.7),
        colours: [
            Vec3::new(0.63, 0.42, 0.10),
            Vec3::new(0.66, 0.30, 0.05),
            Vec3::new(0.58, 0.17, 0.04),
            Vec3::new(0.45, 0.07, 0.035),
        ],
    },
    Painting {
        at: Vec3::new(-6.9, 1.75, 2.0),
        normal: Vec3::NEG_Z,
        size: Vec2::new(1.5, 1.5),
        colours: [
            Vec3::new(0.42, 0.47, 0.40),
            Vec3::new(0.22, 0.34, 0.33),
            Vec3::new(0.10, 0.22, 0.27),
            Vec3::new(0.04, 0.10, 0.17),
        ],
    },
];

/// Hangs everything up.
pub fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) {
    let mut fonts = Fonts::new(TextOptions::default(), FontDefinitions::default());
    let mut hang = |name: &'static str, image: Image, at: Vec3, normal: Vec3, size: Vec3| {
        let material = materials.add(StandardMaterial {
            base_color_texture: Some(images.add(image)),
            perceptual_roughness: 0.9,
            reflectance: 0.3,
            ..default()
        });
        let front = Rectangle::new(size.x, size.y).mesh().build();
        let turn = Transform::default().looking_to(-normal, Vec3::Y).rotation;
        let edge = materials.add(StandardMaterial {
            base_color: Color::linear_rgb(0.6, 0.59, 0.57),
            perceptual_roughness: 0.9,
            ..default()
        });
        // A little before its own body, which throws its shadow onto the wall.
        commands
            .spawn((
                Name::new(name),
                GiDynamic,
                Mesh3d(meshes.add(front)),
                MeshMaterial3d(material),
                Transform::from_translation(at + normal * (size.z + 0.001)).with_rotation(turn),
            ))
            .with_child((
                Mesh3d(meshes.add(Cuboid::from_size(size))),
                MeshMaterial3d(edge),
                Transform::from_xyz(0.0, 0.0, -0.5 * size.z - 0.001),
            ));
    };
    for card in CARDS {
        let picture = lettered(&mut fonts, card);
        hang(card.title, picture, card.at, card.normal, card.size.extend(0.004));
    }
    for painting in PAINTINGS {
        let picture = painted(&painting.colours);
        hang("painting", picture, painting.at, painting.normal, painting.size.extend(0.035));
    }
}

/// A card with its text.
fn lettered(fonts: &mut Fonts, card: &Card) -> Image {
    let pixels = (card.size * DENSITY).as_uvec2();
    let mut coverage = vec![0.0_f32; pixels.element_product() as usize];
    let mut view = fonts.with_pixels_per_point(DENSITY / POINTS);
    let large = card.size.y > 0.3;
    let (title, text, margin) = if large { (44.0, 24.0, 34.0) } else { (23.0, 15.0, 20.0) };
    let wrap = card.size.x * POINTS - 2.0 * margin;
    let mut down = margin * 0.8;
    for (size, text) in [(title, card.title), (text, card.text)] {
        down +=
            letters(&mut view, text, size, Vec2::new(margin, down), wrap, pixels, &mut coverage);
        down += size * 0.3;
    }
    let mixed = coverage.into_iter().map(|ink| CARD.lerp(INK, ink)).collect();
    textures::image(pixels.x, pixels.y, mixed, false)
}

/// Sets text at a place, in points, and says how high it is.
fn letters(
    view: &mut FontsView<'_>,
    text: &str,
    size: f32,
    at: Vec2,
    wrap: f32,
    pixels: UVec2,
    coverage: &mut [f32],
) -> f32 {
    let font = FontId::new(size, FontFamily::Proportional);
    let galley = view.layout(text.to_owned(), font, Color32::WHITE, wrap);
    let atlas: ColorImage = view.image();
    let scale = DENSITY / POINTS;
    for row in &galley.rows {
        for glyph in &row.row.glyphs {
            let from = glyph.uv_rect;
            let corner = Vec2::new(
                at.x + row.pos.x + glyph.pos.x + from.offset.x,
                at.y + row.pos.y + glyph.pos.y + from.offset.y,
            ) * scale;
            let corner = corner.round().as_ivec2();
            for y in from.min[1]..from.max[1] {
                for x in from.min[0]..from.max[0] {
                    let to =
                        corner + IVec2::new(i32::from(x - from.min[0]), i32::from(y - from.min[1]));
                    if to.cmplt(IVec2::ZERO).any() || to.cmpge(pixels.as_ivec2()).any() {
                        continue;
                    }
                    let ink = atlas.pixels[usize::from(y) * atlas.size[0] + usize::from(x)].a();
                    let cell = &mut coverage[(to.y as u32 * pixels.x + to.x as u32) as usize];
                    *cell = cell.max(f32::from(ink) / 255.0);
                }
            }
        }
    }
    galley.size().y
}

/// Squares in squares, a little below each other's middles.
fn painted(colours: &[Vec3; 4]) -> Image {
    const EDGE: u32 = 512;
    let mut pixels = Vec::with_capacity((EDGE * EDGE) as usize);
    for y in 0..EDGE {
        for x in 0..EDGE {
            let place = (Vec2::new(x as f32, y as f32) + 0.5) / EDGE as f32;
            let within = |half: f32, middle: f32| {
                let from = (place - Vec2::new(0.5, middle)).abs();
                from.max_element() < half
            };
            let rings = [(0.4, 0.55), (0.3, 0.6), (0.2, 0.65)];
            let depth = rings.iter().take_while(|(half, middle)| within(*half, *middle)).count();
            // Brush strokes, hardly seen.
            let stroke = 1.0 + 0.02 * (place.y * 310.0 + 9.0 * (place.x * 7.0).sin()).sin();
            pixels.push(colours[depth] * stroke);
        }
    }
    textures::image(EDGE, EDGE, pixels, false)
}

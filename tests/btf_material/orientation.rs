//! The right way round: pixels of a plane against the evaluator on the CPU, for every kind of UVs,
//! with and without tangents, from both sides.

use std::f32::consts::PI;

use bevy::{asset::RenderAssetUsages, mesh::Indices, mesh::PrimitiveTopology};
use farlight::btf::codec::{
    Angles, ColourSpace, Info, References, Rules, Samples, Scaled, Tables, linear,
};

use crate::*;

const COLUMNS: usize = 3;
const ROWS: usize = 2;
const ILLUMINANCE: f32 = 3.0;

/// Numbers from 0 to 1 without a pattern.
struct Noise(u32);

impl Noise {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((self.0 >> ((self.0 >> 28) + 4)) ^ self.0).wrapping_mul(277_803_737);
        ((word >> 22) ^ word) as f32 / u32::MAX as f32
    }

    fn rows(&mut self, columns: usize, count: usize, below: u32) -> Scaled {
        let count = columns * count;
        Scaled {
            columns,
            index: (0..count)
                .map(|_| ((self.next() * below as f32) as u32).min(below - 1))
                .collect(),
            scale: (0..count).map(|_| 0.7 + 0.6 * self.next()).collect(),
            range: None,
        }
    }
}

/// A material that looks different from everywhere.
pub(crate) fn uneven() -> Btf {
    let mut noise = Noise(7);
    let mut luminances = noise.rows(5, 6, 9);
    luminances.scale.iter_mut().for_each(|scale| *scale *= 700.0);
    let references = |noise: &mut Noise, columns: usize, count: usize, below: u32| References {
        columns,
        index: noise.rows(columns, count, below).index,
    };
    let mut texels = noise.rows(1, COLUMNS * ROWS, 6);
    texels.index = (0..(COLUMNS * ROWS) as u32).collect();
    let tables = Tables {
        colour_space: ColourSpace::YCbCr,
        beta_uniform_in_sine: true,
        texels,
        azimuths: noise.rows(8, 6, 5),
        elevations: noise.rows(4, 5, 7),
        slices: References {
            columns: 2,
            index: (0..7)
                .flat_map(|_| [(noise.next() * 5.9) as u32, (noise.next() * 3.9) as u32])
                .collect(),
        },
        luminances,
        shapes: Samples {
            columns: 5,
            value: (0..9 * 5).map(|_| 0.1 + 0.2 * noise.next()).collect(),
            range: None,
        },
        chromas: references(&mut noise, 5, 4, 3),
        colour_rows: references(&mut noise, 5, 3, 6),
        colours: Samples {
            columns: 2,
            value: (0..12).map(|_| 90.0 + 70.0 * noise.next()).collect(),
            range: None,
        },
    };
    Btf::new(Info::default(), COLUMNS, &tables).unwrap()
}

/// How the picture lies on a plane that faces +y: u and v of x and z.
#[derive(Clone, Copy)]
struct Placement {
    name: &'static str,
    u: Vec2,
    v: Vec2,
}

const PLACEMENTS: [Placement; 4] = [
    Placement { name: "plain", u: Vec2::new(0.5, 0.0), v: Vec2::new(0.0, 0.5) },
    Placement { name: "mirrored", u: Vec2::new(-0.5, 0.0), v: Vec2::new(0.0, 0.5) },
    Placement { name: "upside down", u: Vec2::new(0.5, 0.0), v: Vec2::new(0.0, -0.5) },
    Placement { name: "turned", u: Vec2::new(0.3, 0.4), v: Vec2::new(-0.4, 0.3) },
];

impl Placement {
    fn uv(self, place: Vec2) -> Vec2 {
        Vec2::new(self.u.dot(place), self.v.dot(place)) + 0.5
    }

    /// Where u grows and where v falls, in the world.
    fn directions(self) -> (Vec3, Vec3) {
        let inverse =
            Mat2::from_cols(Vec2::new(self.u.x, self.v.x), Vec2::new(self.u.y, self.v.y)).inverse();
        let world = |of_uv: Vec2| {
            let place = inverse * of_uv;
            Vec3::new(place.x, 0.0, place.y).normalize()
        };
        (world(Vec2::X), world(Vec2::NEG_Y))
    }

    fn quad(self, tangents: bool) -> Mesh {
        let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)];
        let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
            .with_inserted_attribute(
                Mesh::ATTRIBUTE_POSITION,
                corners.map(|(x, z)| [x, 0.0, z]).to_vec(),
            )
            .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 1.0, 0.0]; 4])
            .with_inserted_attribute(
                Mesh::ATTRIBUTE_UV_0,
                corners.map(|(x, z)| self.uv(Vec2::new(x, z)).to_array()).to_vec(),
            )
            .with_inserted_indices(Indices::U32(vec![0, 1, 2, 0, 2, 3]));
        if tangents {
            let (along, up) = self.directions();
            let side = Vec3::Y.cross(along).dot(up).signum();
            let tangent = along.extend(side).to_array();
            mesh.insert_attribute(Mesh::ATTRIBUTE_TANGENT, vec![tangent; 4]);
        }
        mesh
    }
}

/// What the evaluator on the CPU says of a place of the plane.
fn expected(
    btf: &Btf,
    placement: Placement,
    place: Vec2,
    normal: Vec3,
    light: Vec3,
    view: Vec3,
) -> Vec3 {
    let (along, up) = placement.directions();
    let local = |d: Vec3| Vec3::new(d.dot(along), d.dot(up), d.dot(normal));
    let texel = (placement.uv(place) * Vec2::new(COLUMNS as f32, ROWS as f32)).floor();
    let angles = Angles::from_directions(local(light), local(view));
    let value = btf.evaluate(texel.x as i32, texel.y as i32, angles, Rules::SHADING);
    (value / 255.0).map(linear) * (ILLUMINANCE / PI)
}

/// Half floats keep 1/2048; angles of f32 and tables of 16 bits leave 0.02 of 255 in a value, which
/// is 0.0006 at white. A wrong side or texel is off by more than ten times that nearly everywhere.
#[test]
fn every_uv_and_tangent_says_the_same_as_the_evaluator() {
    let mut stage = Stage::new();
    let btf = uneven();
    let handle = stage.btf(btf.clone());
    let material = stage.material(BtfMaterial {
        filter: BtfFilter::Nearest,
        double_sided: true,
        ..BtfMaterial::new(handle)
    });
    let camera = stage.float_camera(Vec3::Y, Vec3::ZERO, 1.6);
    let sun = stage.spawn(DirectionalLight { illuminance: ILLUMINANCE, ..default() });
    let blank = stage.mesh(Rectangle::default());
    let object = stage.spawn((Mesh3d(blank), material));
    stage.settle();
    let views = [Vec3::new(0.5, 0.8, 0.6), Vec3::new(-0.7, 1.0, -0.2), Vec3::new(0.3, -0.9, 0.4)];
    let lights = [Vec3::new(-0.3, 0.9, 0.5), Vec3::new(0.9, 0.5, 0.1)];
    let mut worst = 0.0_f32;
    for placement in PLACEMENTS {
        for tangents in [true, false] {
            let mesh = stage.mesh(placement.quad(tangents));
            stage.world().entity_mut(object).insert(Mesh3d(mesh));
            for (view, light) in views.into_iter().zip([lights[0], lights[1], -lights[0]]) {
                let (view, light) = (view.normalize(), light.normalize());
                let pose = Transform::from_translation(2.0 * view).looking_at(Vec3::ZERO, Vec3::Y);
                stage.world().entity_mut(camera).insert(pose);
                let shine = Transform::from_translation(light).looking_at(Vec3::ZERO, Vec3::Y);
                stage.world().entity_mut(sun).insert(shine);
                let pixels = stage.floats();
                let normal = Vec3::Y * view.y.signum();
                let mut compared = 0;
                for (x, y) in (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| (x, y))).step_by(13) {
                    // The ray of the pixel's centre meets the plane.
                    let on_screen = (Vec2::new(x as f32, y as f32) + 0.5) / SIZE as f32 - 0.5;
                    let from = pose * Vec3::new(1.6 * on_screen.x, -1.6 * on_screen.y, 0.0);
                    let hit = from - view * (from.y / view.y);
                    let place = Vec2::new(hit.x, hit.z);
                    let texel = placement.uv(place) * Vec2::new(COLUMNS as f32, ROWS as f32);
                    let to_edge = (texel - texel.round()).abs().min_element();
                    if place.abs().max_element() > 0.98 || to_edge < 0.02 {
                        continue;
                    }
                    let expected = expected(&btf, placement, place, normal, light, view);
                    let found = at(&pixels, x, y);
                    let off = ((found - expected).abs() / (expected + 0.1)).max_element();
                    assert!(
                        off < 0.004,
                        "{}, tangents {tangents}, view {view}, light {light}, place {place}: {found} instead of {expected}",
                        placement.name
                    );
                    worst = worst.max(off);
                    compared += 1;
                }
                assert!(compared > 60, "{compared} pixels");
            }
        }
    }
    println!("plane against the CPU: within {:.3} %", 100.0 * worst);
}

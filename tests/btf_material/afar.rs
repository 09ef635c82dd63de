//! Materials seen from afar, and measured ones to look at.

use std::path::Path;

use farlight::btf::codec::{ColourSpace, Info, References, Samples, Scaled, Tables, read};

use crate::*;

/// Black and white texels by turns, the same from everywhere.
fn checker(edge: u32) -> Btf {
    let rows = |columns: usize, index: Vec<u32>, scale: f32| Scaled {
        columns,
        scale: vec![scale; index.len()],
        index,
        range: None,
    };
    let columns = edge as usize;
    let texels = (0..edge * edge).map(|at| (at % edge + at / edge) % 2).collect();
    let tables = Tables {
        colour_space: ColourSpace::YCbCr,
        beta_uniform_in_sine: false,
        texels: rows(1, texels, 1.0),
        azimuths: rows(1, vec![0, 1], 1.0),
        elevations: rows(2, vec![0, 0, 1, 1], 1.0),
        slices: References { columns: 2, index: vec![0, 0, 1, 0] },
        // Video luma of white and black; both samples over beta are one half.
        luminances: Scaled {
            columns: 2,
            index: vec![0; 4],
            scale: vec![470.0, 470.0, 32.0, 32.0],
            range: None,
        },
        shapes: Samples { columns: 2, value: vec![0.5; 2], range: None },
        chromas: References { columns: 2, index: vec![0; 2] },
        colour_rows: References { columns: 2, index: vec![0; 2] },
        colours: Samples { columns: 2, value: vec![128.0; 2], range: None },
    };
    Btf::new(Info::default(), columns, &tables).unwrap()
}

/// One texel and one pixel meet at another place everywhere: without coarser pictures every pixel
/// would be black or white.
#[test]
fn what_is_small_does_not_flicker() {
    let mut stage = Stage::new();
    stage.light_in_front();
    let btf = stage.btf(checker(16));
    let material = stage.material(BtfMaterial {
        // Nearly seven texels a pixel.
        repeat: Vec2::splat(27.3),
        ..BtfMaterial::new(btf)
    });
    let square = stage.mesh(Rectangle::new(2.0, 2.0));
    stage.spawn((Mesh3d(square), material));
    stage.settle();
    let pixels = stage.floats();
    let mean = pixels.iter().map(|pixel| pixel.x).sum::<f32>() / pixels.len() as f32;
    let variance =
        pixels.iter().map(|pixel| (pixel.x - mean).powi(2)).sum::<f32>() / pixels.len() as f32;
    println!("checker from afar: mean {mean:.3}, deviation {:.3}", variance.sqrt());
    // Linear light is joined, not codes: half of white.
    assert!((mean - 0.5).abs() < 0.03 && variance.sqrt() < 0.1, "{mean}, {}", variance.sqrt());
}

/// Seen near, a material of a quarter of its resolution has the same mean and less detail; from afar,
/// one that may be finer than a pixel has more, since it is not averaged.
#[test]
fn the_resolution_of_a_material_can_be_chosen() {
    let mut stage = Stage::new();
    stage.light_in_front();
    let btf = stage.btf(checker(16));
    let square = stage.mesh(Rectangle::new(2.0, 2.0));
    let mut seen = |repeat: f32, coarseness: f32| {
        let material = stage.material(BtfMaterial {
            repeat: Vec2::splat(repeat),
            filter: BtfFilter::Nearest,
            coarseness,
            ..BtfMaterial::new(btf.clone())
        });
        let plane = stage.spawn((Mesh3d(square.clone()), material));
        stage.settle();
        let pixels = stage.floats();
        stage.world().despawn(plane);
        let mean = pixels.iter().map(|pixel| pixel.x).sum::<f32>() / pixels.len() as f32;
        let variance =
            pixels.iter().map(|pixel| (pixel.x - mean).powi(2)).sum::<f32>() / pixels.len() as f32;
        println!("repeated {repeat}, coarseness {coarseness}: {mean:.3} +- {:.3}", variance.sqrt());
        (mean, variance.sqrt())
    };
    // A quarter of a texel a pixel: black and white, which deviate by a half.
    let [near, halved] = [0.0, 2.0].map(|coarseness| seen(1.0, coarseness));
    assert!(near.1 > 0.45 && halved.1 < 0.1, "{near:?} {halved:?}");
    assert!((halved.0 - near.0).abs() < 0.03, "{near:?} {halved:?}");
    // Seven texels a pixel.
    let [far, whole] = [0.0, BtfMaterial::WHOLE_PICTURE].map(|coarseness| seen(27.3, coarseness));
    assert!(far.1 < 0.1 && whole.1 > 0.4, "{far:?} {whole:?}");
}

/// The made cloth, near and from afar: the mean colour stays, straight on and at an angle. Levels have
/// 0.5 to 4 % of error on average over many views and lights; a single one may be off by more.
#[test]
fn cloth_keeps_its_colour_from_afar() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/materials/cloth.fbtf");
    let btf = Btf::open(&path).unwrap();
    let mut stage = Stage::new();
    let camera = stage.float_camera(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 2.0);
    stage.spawn((
        DirectionalLight { illuminance: std::f32::consts::PI, ..default() },
        Transform::from_xyz(0.6, 0.5, 1.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    let btf = stage.btf(btf);
    // The plane fills the picture at an angle too.
    let square = stage.mesh(Rectangle::new(16.0, 16.0));
    for degrees in [0.0_f32, 60.0] {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let pose =
            Transform::from_xyz(3.0 * sine, 0.0, 3.0 * cosine).looking_at(Vec3::ZERO, Vec3::Y);
        stage.world().entity_mut(camera).insert(pose);
        let mut near = Vec3::ZERO;
        // Texels a pixel along the height: 1, 4, 16.
        for repeat in [8.0, 32.0, 128.0] {
            let material = stage.material(BtfMaterial {
                repeat: Vec2::splat(repeat),
                ..BtfMaterial::new(btf.clone())
            });
            let plane = stage.spawn((Mesh3d(square.clone()), material));
            stage.settle();
            let pixels = stage.floats();
            let mean = pixels.iter().sum::<Vec3>() / pixels.len() as f32;
            println!("cloth at {degrees} degrees, repeated {repeat}: {mean:.4}");
            if near == Vec3::ZERO {
                near = mean;
            }
            let off = (mean / near - 1.0).abs().max_element();
            assert!(off < 0.1, "{degrees}, {repeat}: {mean} instead of {near}");
            stage.world().despawn(plane);
        }
    }
}

/// Pictures in the target folder for a person to look at.
#[test]
fn measured_materials_are_shown() {
    let Some(data) = std::env::var_os("FARLIGHT_TEST_DATA") else {
        println!("SKIPPED: FARLIGHT_TEST_DATA does not name a folder of measured data");
        return;
    };
    for name in ["alu", "wallpaper", "corduroy"] {
        let folder = Path::new(&data).join("btfbase").join(name);
        let Ok(read::Material::Tables(btf)) = read::open(&folder, &read::Options::default()) else {
            println!("SKIPPED: no {name} in {}", folder.display());
            continue;
        };
        let mut stage = Stage::sized(256);
        stage.camera(Vec3::new(0.0, 1.2, 3.2), Vec3::new(0.0, 0.35, 0.0), 0.0);
        stage.spawn((
            PointLight {
                intensity: 4.0 * std::f32::consts::PI * 60.0,
                shadow_maps_enabled: true,
                ..default()
            },
            Transform::from_xyz(2.0, 3.0, 2.0),
        ));
        stage.world().resource_mut::<GlobalAmbientLight>().brightness = 0.2;
        let btf = stage.btf(btf);
        let ball = stage
            .material(BtfMaterial { repeat: Vec2::new(4.0, 2.0), ..BtfMaterial::new(btf.clone()) });
        let floor =
            stage.material(BtfMaterial { repeat: Vec2::splat(4.0), ..BtfMaterial::new(btf) });
        let mesh = stage.mesh(Sphere::new(0.7).mesh().uv(64, 48));
        stage.spawn((Mesh3d(mesh), ball, Transform::from_xyz(0.0, 0.7, 0.0)));
        let mesh = stage.mesh(Plane3d::default().mesh().size(8.0, 8.0));
        stage.spawn((Mesh3d(mesh), floor));
        stage.settle();
        let picture = stage.picture();
        stage.save(&picture, name);
        assert_eq!(picture.problem(), None, "{name}");
    }
}

//! Archives and folders of pictures, made here, with values that are known.

use std::f64::consts::PI;
use std::fs::File;
use std::io::{Cursor, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use farlight_btf_codec::{
    Angles, ImageBtf, Query, Resampled, Rules, compress, linear, read, srgb_encode,
};
use image::{ImageFormat, RgbImage};
use zip::write::SimpleFileOptions;

/// Theta and phi of the 81 directions of the Bonn measurements, in degrees.
fn grid() -> Vec<(u32, u32)> {
    let mut all = vec![(0, 0)];
    for (ring, count) in [(1, 6), (2, 12), (3, 18), (4, 20), (5, 24)] {
        all.extend((0..count).map(|k| (15 * ring, 360 / count * k)));
    }
    all
}

/// A picture of 2 x 1 texels: red tells the light, green the view, blue the texel.
fn picture(light: (u32, u32), view: (u32, u32)) -> Vec<u8> {
    let picture = RgbImage::from_fn(2, 1, |x, _| {
        let level = |(theta, phi): (u32, u32)| (2 * theta + phi / 6) as u8;
        image::Rgb([level(light), level(view), 100 + 50 * x as u8])
    });
    png(&picture)
}

fn png(picture: &RgbImage) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png).unwrap();
    bytes.into_inner()
}

fn archive(path: &Path, entries: &[(String, Vec<u8>)]) {
    let mut archive = zip::ZipWriter::new(File::create(path).unwrap());
    for (name, bytes) in entries {
        archive.start_file(name.as_str(), SimpleFileOptions::default()).unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap();
}

/// A whole set with the directions in names of the archive.
fn bonn(lights: &[(u32, u32)], views: &[(u32, u32)]) -> Vec<(String, Vec<u8>)> {
    let mut entries = vec![("set/readme.txt".to_owned(), b"about".to_vec())];
    for view in views {
        for light in lights {
            let name = format!(
                "set/tv{:03}/{:05} tl{:03} pl{:03} tv{:03} pv{:03}.png",
                view.0, 7, light.0, light.1, view.0, view.1
            );
            entries.push((name, picture(*light, *view)));
        }
    }
    entries
}

fn opened(path: &Path) -> ImageBtf {
    match read::open(path, &read::Options::default()).unwrap() {
        read::Material::Images(images) => images,
        read::Material::Tables(_) => panic!("tables?"),
    }
}

fn error(path: &Path) -> String {
    match read::open(path, &read::Options::default()) {
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    }
}

/// Linear mean of two 8-bit levels, encoded.
fn between(a: f32, b: f32) -> f32 {
    255.0 * srgb_encode(0.5 * (linear(a / 255.0) + linear(b / 255.0)))
}

#[test]
fn an_archive_gives_its_pictures_at_measured_directions_and_between() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wool.zip");
    let lights = grid();
    let views = [(0, 0), (15, 0), (15, 60), (15, 120), (15, 180), (15, 240), (15, 300)];
    archive(&path, &bonn(&lights, &views));
    let images = opened(&path);
    assert_eq!(images.size(), [2, 1]);
    assert_eq!(images.directions(), [7, 81]);
    assert_eq!(images.rings(), [Some(2), Some(6)]);
    assert_eq!(images.info().name, "wool");

    let level = |(theta, phi): (u32, u32)| (2 * theta + phi / 6) as f32;
    let value = |x: i32, light: (f64, f64), view: (f64, f64)| {
        images.evaluate(x, 0, Angles::from_degrees(light.0, light.1, view.0, view.1)).unwrap()
    };
    for light in &lights {
        let view = (15, 240);
        let found = value(1, (light.0.into(), light.1.into()), (15.0, 240.0));
        let expected = glam::Vec3::new(level(*light), level(view), 150.0);
        assert!(found.abs_diff_eq(expected, 0.01), "{light:?}: {found} instead of {expected}");
    }
    // Between two rings, and along one across the azimuth 0; x wraps round.
    let found = value(-2, (22.5, 60.0), (0.0, 0.0));
    assert!((found.x - between(level((15, 60)), level((30, 60)))).abs() < 0.01, "{found}");
    assert!((found.z - 100.0).abs() < 0.01);
    let found = value(0, (0.0, 0.0), (15.0, 330.0));
    assert!((found.y - between(level((15, 300)), level((15, 0)))).abs() < 0.01, "{found}");
    // Beyond the outermost ring light falls with its cosine; a view does not.
    let found = value(0, (85.0, 0.0), (80.0, 0.0));
    let falloff = ((85.0 * PI / 180.0).cos() / (75.0 * PI / 180.0).cos()) as f32;
    let expected = 255.0 * srgb_encode(falloff * linear(100.0 / 255.0));
    assert!((found.z - expected).abs() < 0.01, "{found}");
    assert_eq!(value(0, (90.0, 0.0), (0.0, 0.0)), glam::Vec3::ZERO);
    assert_eq!(value(0, (10.0, 0.0), (95.0, 0.0)), glam::Vec3::ZERO);
}

#[test]
fn many_values_at_once_are_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wool.zip");
    archive(&path, &bonn(&grid(), &grid()[..19]));
    let images = opened(&path);
    let queries: Vec<_> = (0..500)
        .map(|k| {
            let k = f64::from(k);
            let angles = Angles::from_degrees(k * 0.19, k * 7.3, k * 0.17, k * 11.1);
            Query { x: k as i32, y: 0, angles }
        })
        .collect();
    let all = images.evaluate_all(&queries).unwrap();
    for (Query { x, y, angles }, found) in queries.into_iter().zip(all) {
        let one = images.evaluate(x, y, angles).unwrap();
        assert!(one.abs_diff_eq(found, 1e-3), "{one} {found}");
    }
}

#[test]
fn damaged_archives_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("set.zip");
    let views = &grid()[..7];
    let good = bonn(views, views);
    let with = |change: &dyn Fn(&mut Vec<(String, Vec<u8>)>)| {
        let mut entries = good.clone();
        change(&mut entries);
        archive(&path, &entries);
        error(&path)
    };
    assert_eq!(with(&|_| ()), "");
    let missing = with(&|entries| drop(entries.remove(20)));
    assert!(missing.contains("1 of 49") && missing.contains("set.zip"), "{missing}");
    let twice = with(&|entries| {
        let (name, bytes) = entries[3].clone();
        entries.push((format!("again {name}"), bytes));
    });
    assert!(twice.contains("two pictures"), "{twice}");
    let below = with(&|entries| entries[3].0 = "tl091 pl000 tv000 pv000.png".to_owned());
    assert!(below.contains("tl091") && below.contains("above"), "{below}");
    let none = with(&|entries| entries.truncate(1));
    assert!(none.contains("no picture") && none.contains("readme.txt"), "{none}");
    std::fs::write(&path, b"PK\x03\x04 and nothing else").unwrap();
    assert!(error(&path).contains("set.zip"), "{}", error(&path));

    // What only decoding finds.
    let mut entries = good.clone();
    entries[9].1 = png(&RgbImage::new(3, 1));
    entries[10].1 = b"no picture".to_vec();
    archive(&path, &entries);
    let images = opened(&path);
    let errors: Vec<String> =
        (0..49).filter_map(|n| images.picture(n).err()).map(|e| e.to_string()).collect();
    assert_eq!(errors.len(), 2, "{errors:?}");
    assert!(errors[0].contains("3 x 1") && errors[0].contains("tl"), "{errors:?}");
    assert!(errors[1].contains("set.zip") && errors[1].contains("tl"), "{errors:?}");
}

/// A folder with pictures and a list, whose lines are given.
fn listed(folder: &Path, list: &str) -> PathBuf {
    for (name, level) in [("a.png", 10), ("b.png", 90), ("c.png", 200)] {
        let picture = RgbImage::from_pixel(2, 2, image::Rgb([level; 3]));
        std::fs::write(folder.join(name), png(&picture)).unwrap();
    }
    std::fs::write(folder.join("directions.ron"), list).unwrap();
    folder.to_owned()
}

#[test]
fn a_folder_with_a_list_has_any_directions() {
    let folder = tempfile::tempdir().unwrap();
    let list = "Directions(name: Some(\"velvet\"), size: Some((0.1, 0.2)), images: [
        (file: \"a.png\", light: (10, 0), view: (0, 0)),
        (file: \"b.png\", light: (50.5, 200), view: (0, 0)),
        (file: \"./c.png\", light: (20, 90), view: (40, 30)),
    ])";
    let images = opened(&listed(folder.path(), list));
    assert_eq!(images.info().name, "velvet");
    assert_eq!(images.info().size, Some([0.1, 0.2]));
    assert_eq!(images.directions(), [2, 2]);
    for (light, view, level) in [
        ((10.0, 0.0), (0.0, 0.0), 10.0),
        ((50.5, 200.0), (0.0, 77.0), 90.0),
        ((20.0, 90.0), (40.0, 30.0), 200.0),
    ] {
        let found =
            images.evaluate(0, 0, Angles::from_degrees(light.0, light.1, view.0, view.1)).unwrap();
        assert!((found.x - level).abs() < 0.01, "{light:?} {view:?}: {found}");
    }
}

#[test]
fn an_unpacked_archive_is_read_by_names() {
    let folder = tempfile::tempdir().unwrap();
    for light in [(0, 0), (30, 0), (30, 120), (30, 240)] {
        let name = format!("x_tl{:03}_pl{:03}_tv000_pv000.png", light.0, light.1);
        std::fs::write(folder.path().join(name), picture(light, (0, 0))).unwrap();
    }
    let images = opened(folder.path());
    assert_eq!(images.directions(), [1, 4]);
}

#[test]
fn wrong_lists_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    let entry = "(file: \"a.png\", light: (10, 0), view: (0, 0))";
    for (list, message) in [
        ("Directions(images: [])".to_owned(), "no pictures"),
        (format!("Directions(images: [{entry}, {entry}])"), "two pictures"),
        (format!("Directions(images: [{}])", entry.replace("10", "91")), "above"),
        (format!("Directions(images: [{}])", entry.replace("10", "NaN")), "above"),
        (format!("Directions(images: [{}])", entry.replace("a.png", "../a.png")), "within"),
        (format!("Directions(images: [{}])", entry.replace("a.png", "/a.png")), "within"),
        (format!("Directions(images: [{}])", entry.replace("a.png", "z.png")), "z.png"),
        (format!("Directions(images: [{}])", entry.replace("light", "lamp")), "lamp"),
        (format!("Directions(size: Some((0, 1)), images: [{entry}])"), "size"),
        ("Directions(".to_owned(), "directions.ron"),
    ] {
        let error = error(&listed(folder.path(), &list));
        assert!(error.contains(message), "{list}: {error}");
    }
}

#[test]
fn what_is_no_material_is_described() {
    let folder = tempfile::tempdir().unwrap();
    assert!(error(folder.path()).contains("empty"));
    std::fs::write(folder.path().join("notes.txt"), "nothing").unwrap();
    let message = error(folder.path());
    assert!(message.contains("notes.txt") && message.contains("directions.ron"), "{message}");
    let message = error(&folder.path().join("notes.txt"));
    assert!(message.contains("begins with \"nothing\""), "{message}");
    let message = error(&folder.path().join("none"));
    assert!(message.contains("none"), "{message}");
}

/// Lambertian pictures become Lambertian tables.
#[test]
fn resampled_pictures_are_compressed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("white.zip");
    let level = |theta: u32| {
        let cosine = f64::from(theta).to_radians().cos() as f32;
        (255.0 * srgb_encode(cosine)).round() as u8
    };
    let mut entries = Vec::new();
    for view in grid() {
        for light in grid() {
            let picture = RgbImage::from_pixel(3, 2, image::Rgb([level(light.0); 3]));
            let name =
                format!("tl{:03} pl{:03} tv{:03} pv{:03}.png", light.0, light.1, view.0, view.1);
            entries.push((name, png(&picture)));
        }
    }
    archive(&path, &entries);
    let images = opened(&path);
    let mut source = Resampled::new(&images, compress::Grid::default());
    let settings =
        compress::Settings { quality: compress::Quality::Error(1.0), ..Default::default() };
    let done = compress::compress(&mut source, &settings, &mut |_| ControlFlow::Continue(()));
    let compressed = done.unwrap().unwrap();
    println!("{:?}", compressed.report);
    let btf = compressed.into_btf(images.info().clone()).unwrap();
    assert_eq!(btf.size(), [3, 2]);
    // Along the slice through the normal, at the samples of alpha: one step of the pictures, and the
    // chord of the cosine over 15 degrees (1 - cos 7.5 degrees), encoded.
    for theta in [0.0, 18.0, 36.0, 54.0] {
        let angles = Angles::from_degrees(theta, 0.0, 30.0, 0.0);
        let value = btf.evaluate(1, 1, angles, Rules::default());
        let expected = 255.0 * srgb_encode(theta.to_radians().cos() as f32);
        assert!((value - expected).abs().max_element() < 3.0, "{theta}: {value} {expected}");
    }
}

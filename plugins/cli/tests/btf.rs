//! `farlight btf` as a user runs it.

mod support;

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use farlight_btf_codec::{Angles, Btf, Info, Rules, synthetic::lambert};
use image::RgbImage;
use support::{Folder, refused, succeeded};

/// A reddish Lambertian material of 3 x 2 texels.
fn material(folder: &Folder) -> PathBuf {
    let path = folder.at("red.fbtf");
    lambert([0.8, 0.3, 0.1], [3, 2]).unwrap().write(&path).unwrap();
    path
}

fn btf<S: AsRef<std::ffi::OsStr>>(arguments: &[S]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_farlight")).arg("btf").args(arguments).output().unwrap()
}

fn eval(material: &Path, queries: &Path, out: &Path, more: &[&str]) -> Output {
    let mut arguments: Vec<&std::ffi::OsStr> = vec!["eval".as_ref(), material.as_ref()];
    arguments.extend(["--queries".as_ref(), queries.as_os_str(), "--out".as_ref(), out.as_ref()]);
    arguments.extend(more.iter().map(AsRef::<std::ffi::OsStr>::as_ref));
    btf(&arguments)
}

#[test]
fn eval_keeps_order_and_fields_and_answers() {
    let folder = Folder::new("order");
    let material = material(&folder);
    let out = folder.at("out.csv");
    let queries = folder.write(
        "in.csv",
        "phi_v,note,x,y,theta_i,phi_i,theta_v\n\
         10.50,a, 1,-3,30,40,2e1\n\
         0,\"b, c\",100,7,75.0,0,80\n\
         0,,0,0,90.001,0,0\n",
    );
    succeeded(&eval(&material, &queries, &out, &[]));
    let text = fs::read_to_string(&out).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0].join(","), "x,y,theta_i,phi_i,theta_v,phi_v,r,g,b");
    assert_eq!(rows[1][..6], [" 1", "-3", "30", "40", "2e1", "10.50"]);
    assert_eq!(rows[2][..6], ["100", "7", "75.0", "0", "80", "0"]);
    assert_eq!(rows[3][6..], ["0", "0", "0"]);
    let btf = Btf::open(&material).unwrap();
    for (row, theta) in [(1, 30.0), (2, 75.0)] {
        let angles = Angles::from_degrees(theta, 0.0, 20.0, 10.5);
        let expected = btf.evaluate(0, 0, angles, Rules::default());
        for (field, expected) in rows[row][6..].iter().zip(expected.to_array()) {
            let found: f32 = field.parse().unwrap();
            // A Lambertian value depends on theta alone, but for interpolation.
            assert!((found - expected).abs() < 0.3, "{found} {expected}");
        }
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3, "nothing else is left");
}

#[test]
fn eval_explains_what_is_wrong() {
    let folder = Folder::new("wrong");
    let material = material(&folder);
    let out = folder.at("out.csv");
    let header = "x,y,theta_i,phi_i,theta_v,phi_v\n0,0,0,0,0,0\n";
    for (name, text, message) in [
        ("nan.csv", format!("{header}0,0,NaN,0,0,0\n"), "nan.csv:3: theta_i"),
        ("short.csv", format!("{header}0,0,1\n"), "short.csv:3"),
        ("word.csv", format!("{header}0,zero,0,0,0,0\n"), "word.csv:3: y"),
        ("head.csv", "x,y,theta_i,phi_i,theta_v\n".to_owned(), "no column phi_v"),
    ] {
        let error = refused(&eval(&material, &folder.write(name, &text), &out, &[]));
        assert!(error.contains(message), "{name}: {error}");
        assert!(!out.exists(), "{name}");
    }
    let good = folder.write("good.csv", header);
    let error = refused(&eval(&folder.at("none"), &good, &out, &[]));
    assert!(error.contains("none"), "{error}");
    let error = refused(&eval(&good, &good, &out, &[]));
    assert!(error.contains("no material") && error.contains("begins with"), "{error}");
    let error = refused(&eval(&material, &good, &folder.at("no/such/out.csv"), &[]));
    assert!(error.contains("out.csv"), "{error}");
    let parts = fs::read_dir(folder.path()).unwrap().flatten();
    assert!(!parts.map(|e| e.file_name()).any(|n| n.to_string_lossy().contains(".part")));
}

#[test]
fn import_keeps_values_and_adds_the_size() {
    let folder = Folder::new("import");
    let material = material(&folder);
    let out = folder.at("again.fbtf");
    let arguments = |size: &str| {
        ["import", material.to_str().unwrap(), "--out", out.to_str().unwrap(), "--size-m", size]
            .map(str::to_owned)
    };
    succeeded(&btf(&arguments("0.1,0.2")));
    let (before, after) = (Btf::open(&material).unwrap(), Btf::open(&out).unwrap());
    assert_eq!(after.words(), before.words());
    assert_eq!(*after.info(), Info { size: Some([0.1, 0.2]), ..before.info().clone() });
    assert!(refused(&btf(&arguments("0.1"))).contains("two"));
}

#[test]
fn info_tells_what_there_is() {
    let folder = Folder::new("info");
    let text = succeeded(&btf(&["info".as_ref(), material(&folder).as_os_str()]));
    for words in ["lambert", "3 x 2", "LDR", "luminances", "repaired     nothing", "mean colour"] {
        assert!(text.contains(words), "{words}: {text}");
    }
}

#[test]
fn pictures_are_evaluated_too() {
    let folder = Folder::new("pictures");
    let set = folder.at("set");
    fs::create_dir_all(&set).unwrap();
    for (light, level) in
        [("tl000 pl000", 200), ("tl060 pl000", 100), ("tl060 pl120", 120), ("tl060 pl240", 140)]
    {
        let picture = RgbImage::from_pixel(2, 2, image::Rgb([level, 10, 20]));
        picture.save(set.join(format!("{light} tv000 pv000.png"))).unwrap();
    }
    let queries = folder.write(
        "in.csv",
        "x,y,theta_i,phi_i,theta_v,phi_v\n0,0,0,0,0,0\n5,1,60,120,40,77\n0,0,60,-120,0,0\n",
    );
    let out = folder.at("out.csv");
    succeeded(&eval(&set, &queries, &out, &[]));
    let text = fs::read_to_string(&out).unwrap();
    let red =
        text.lines().skip(1).map(|line| line.split(',').nth(6).unwrap().parse::<f32>().unwrap());
    for (found, expected) in red.zip([200.0, 120.0, 140.0]) {
        assert!((found - expected).abs() < 0.01, "{found} {expected}");
    }
    let text = succeeded(&btf(&["info".as_ref(), set.as_os_str()]));
    for words in ["2 x 2", "4 for each view, 2 rings", "mean colour"] {
        assert!(text.contains(words), "{words}: {text}");
    }
}

#[test]
fn help_explains_the_files() {
    let text = succeeded(&btf(&["eval", "--help"]));
    for words in ["IN.csv", "OUT.csv", "MATERIAL is one of", "UBO2003", "--compat", "--no-repair"] {
        assert!(text.contains(words), "{words}: {text}");
    }
}

/// Test vectors of an existing evaluator, through the command.
#[test]
fn measured_materials_give_their_vectors() {
    let Some(data) = std::env::var_os("FARLIGHT_TEST_DATA") else {
        println!("SKIPPED: FARLIGHT_TEST_DATA is not set");
        return;
    };
    let data = PathBuf::from(data).join("btfbase");
    let folder = Folder::new("vectors");
    let out = folder.at("out.csv");
    for (name, kind, more) in [
        ("alu", "csv", &["--compat"][..]),
        ("wallpaper", "csv", &["--compat"]),
        // No text tables there: its binary is used.
        ("corduroy", "binary.csv", &["--compat", "--no-repair"]),
        ("corduroy", "binary_repaired.csv", &["--compat"]),
    ] {
        let material = data.join(name);
        let vectors = material.join(format!("{name}.{kind}"));
        succeeded(&eval(&material, &vectors, &out, more));
        let tags = fs::read_to_string(material.join(format!("{name}.tags.txt"))).unwrap();
        let (expected, found) =
            (fs::read_to_string(&vectors).unwrap(), fs::read_to_string(&out).unwrap());
        assert_eq!(expected.lines().count(), found.lines().count());
        let rows = expected.lines().zip(found.lines()).skip(1);
        for ((expected, found), tag) in rows.zip(tags.lines()) {
            let split = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
            let (expected, found) = (split(expected), split(found));
            assert_eq!(expected[..6], found[..6]);
            // Where 32-bit floats resolve the angles badly: FORMAT.md, section 9.
            let loose = ["exact90", "beta_pole", "beta_guard"].contains(&tag);
            let limit = if loose { 0.5 } else { 0.02 };
            for (a, b) in expected[6..].iter().zip(&found[6..]) {
                let error = a.parse::<f32>().unwrap() - b.parse::<f32>().unwrap();
                assert!(error.abs() <= limit, "{name} {kind}: {expected:?} {found:?}");
            }
        }
    }
    // A GPU gives the same.
    let vectors = data.join("alu/alu.csv");
    let gpu = folder.at("gpu.csv");
    let output = eval(&data.join("alu"), &vectors, &gpu, &["--backend", "gpu"]);
    if !output.status.success() {
        println!("SKIPPED: --backend gpu: {}", refused(&output));
        return;
    }
    succeeded(&eval(&data.join("alu"), &vectors, &out, &[]));
    let values = |path: &Path| -> Vec<f32> {
        let text = fs::read_to_string(path).unwrap();
        let fields = text.lines().skip(1).flat_map(|line| line.split(',').skip(6));
        fields.map(|field| field.parse().unwrap()).collect()
    };
    for (cpu, gpu) in values(&out).into_iter().zip(values(&gpu)) {
        // Near the horizon the two round angles differently.
        assert!((cpu - gpu).abs() < 0.5, "{cpu} {gpu}");
    }
}

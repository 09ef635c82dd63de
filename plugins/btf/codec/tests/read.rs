//! BTFbase data sets of other shapes than the measured ones, and wrong ones.

mod common;

use std::fs;

use common::base::Base;
use farlight_btf_codec::{Angles, Btf, ColourSpace, Rules, read};

fn open(path: &std::path::Path) -> Btf {
    match read::open(path, &read::Options::default()).unwrap() {
        read::Material::Tables(btf) => btf,
        read::Material::Images(_) => panic!("pictures?"),
    }
}

fn error(path: &std::path::Path) -> String {
    match read::open(path, &read::Options::default()) {
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    }
}

#[test]
fn text_and_repaired_binary_hold_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let base = Base::new();
    base.write_texts(folder.path());
    let text = open(folder.path());
    let binary = Btf::from_bytes(base.binary()).unwrap();
    for repair in &binary.info().repairs {
        println!("{repair}");
    }
    // One entry in each table of floats, two in the one of shapes.
    assert_eq!(binary.info().repairs.len(), 7);
    assert!(text.info().repairs.is_empty() && text.info().remarks.is_empty());
    assert_eq!(text.info().name, "made");
    assert_eq!(text.size(), [6, 4]);
    let [a, b] = [text.layout(), binary.layout()];
    assert_eq!([a.phi_count, a.theta_count, a.alpha_count, a.beta_count], [5, 4, 7, 9]);
    assert_eq!([b.phi_count, b.theta_count, b.alpha_count, b.beta_count], [5, 4, 7, 9]);
    assert_eq!(text.words(), binary.words());

    let plain = folder.path().join("any name");
    fs::write(&plain, base.binary()).unwrap();
    let options = read::Options { repairs: read::Repairs::No, ..Default::default() };
    let plain = read::read_binary(&plain, &options).unwrap();
    assert!(plain.info().repairs.is_empty());
    assert_ne!(plain.words(), text.words());
}

#[test]
fn high_dynamic_range_is_told_by_the_factor() {
    let base = Base { factor: "0.500000", ..Base::new() };
    let btf = Btf::from_bytes(base.binary()).unwrap();
    assert_eq!(btf.colour_space(), ColourSpace::LogLuv { factor: 0.5 });
    let value = btf.evaluate(0, 0, Angles::from_degrees(30.0, 0.0, 20.0, 0.0), Rules::SHADING);
    assert!(value.is_finite() && value.max_element() > 0.0, "{value}");
    let base = Base { factor: "1.000000", ..Base::new() };
    assert_eq!(Btf::from_bytes(base.binary()).unwrap().colour_space(), ColourSpace::YCbCr);
}

#[test]
fn a_folder_without_all_its_tables_uses_its_binary() {
    let folder = tempfile::tempdir().unwrap();
    let base = Base::new();
    base.write_texts(folder.path());
    fs::remove_file(folder.path().join("all_PDF2Dscale.txt")).unwrap();
    assert!(error(folder.path()).contains("all_PDF2Dscale.txt"));
    fs::write(folder.path().join("binary.btf"), base.binary()).unwrap();
    let btf = open(folder.path());
    assert_eq!(btf.info().source, "BTFbase, binary");
    assert!(btf.info().remarks[0].contains("all_PDF2Dscale.txt is missing"));

    let alone = tempfile::tempdir().unwrap();
    fs::write(alone.path().join("binary.btf"), base.binary()).unwrap();
    assert_eq!(open(alone.path()).words(), btf.words());
}

#[test]
fn one_of_several_materials_is_chosen_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let base = Base::new();
    base.write_texts(folder.path());
    for table in ["PDF6Dslices", "PDF6Dscale"] {
        let own = |name: &str| folder.path().join(format!("{name}_{table}.txt"));
        fs::copy(own("made"), own("other")).unwrap();
    }
    let message = error(folder.path());
    assert!(message.contains("made, other"), "{message}");
    // The description of the second: turned by a row and a column.
    let description = base.description().replacen("\n1\n", "\n2\n", 1)
        + "other ./in/ ./out/ ./tmp/ 1 1 4 6 0.0\n";
    fs::write(folder.path().join("all_materialInfo.txt"), description).unwrap();
    let choose = |name: &str| {
        let options = read::Options { material: Some(name.to_owned()), ..Default::default() };
        read::read_text(folder.path(), &options)
    };
    let [made, other] = ["made", "other"].map(|name| choose(name).unwrap());
    let angles = Angles::from_degrees(30.0, 10.0, 20.0, 0.0);
    for (x, y) in [(0, 0), (5, 3), (2, 1)] {
        let value = made.evaluate(x, y, angles, Rules::default());
        assert_eq!(other.evaluate(x + 1, y + 1, angles, Rules::default()), value);
    }
    assert!(choose("third").unwrap_err().to_string().contains("made, other"));
}

#[test]
fn a_missing_description_is_remarked() {
    let folder = tempfile::tempdir().unwrap();
    Base::new().write_texts(folder.path());
    let words = open(folder.path()).words().to_vec();
    fs::remove_file(folder.path().join("all_materialInfo.txt")).unwrap();
    let btf = open(folder.path());
    assert_eq!(btf.words(), words);
    assert!(btf.info().remarks[0].contains("all_materialInfo.txt"));
}

#[test]
fn errors_name_the_file_and_the_place() {
    let folder = tempfile::tempdir().unwrap();
    let base = Base::new();
    for (file, from, to, message) in [
        ("all_PDF1Dslice.txt", "3 9", "4 9", "instead of 4 rows of 9"),
        ("all_PDF1Dslice.txt", "3 9", "4000000000 9000000000", "more than"),
        ("all_PDF1Dslice.txt", "\n0.", "\nx0.", "line 2"),
        ("all_PDF3Dslices.txt", "\n0", "\n9", "elevations refers to row 9 of 3"),
        ("made_PDF6Dslices.txt", "\n1", "\n0", "not been compressed"),
        ("made_PDF6Dscale.txt", "4 6", "6 4", "another shape"),
        ("all_materialInfo.txt", "1 9 0 7", "1 9 0 8", "8 samples of alpha"),
        ("all_materialInfo.txt", "0 0 4 6", "0 0 6 4", "the description says 6 of 4"),
        ("all_materialInfo.txt", "1\n0\n0\n", "1\n1\n0\n", "merged"),
    ] {
        base.write_texts(folder.path());
        let path = folder.path().join(file);
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{file}");
        fs::write(&path, text.replacen(from, to, 1)).unwrap();
        let message_found = error(folder.path());
        assert!(message_found.contains(message), "{file}: {message_found}");
    }
    let bytes = base.binary();
    for cut in 0..bytes.len() {
        assert!(Btf::from_bytes(&bytes[..cut]).is_err(), "{cut}");
    }
    let longer = [bytes, vec![0]].concat();
    let error = Btf::from_bytes(longer).unwrap_err().to_string();
    assert!(error.contains("1 bytes after"), "{error}");
}

#[test]
fn another_first_line_is_remarked() {
    let mut bytes = Base::new().binary();
    bytes[..4].copy_from_slice(b"4711");
    let btf = Btf::from_bytes(&bytes).unwrap();
    assert!(btf.info().remarks[0].contains("4711"), "{:?}", btf.info());
    bytes[0] = b'x';
    assert!(Btf::from_bytes(&bytes).unwrap_err().to_string().contains("neither"));
}

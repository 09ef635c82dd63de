//! Test vectors of an existing evaluator, where the data is there.

use std::path::{Path, PathBuf};

use farlight_btf_codec::{Angles, Btf, Rules, read};

/// The folder of measured materials, or a word that the test was skipped.
fn materials() -> Option<PathBuf> {
    match std::env::var_os("FARLIGHT_TEST_DATA") {
        Some(data) => Some(PathBuf::from(data).join("btfbase")),
        None => {
            println!("SKIPPED: FARLIGHT_TEST_DATA is not set");
            None
        }
    }
}

/// Tags of rows whose angles f32 resolves badly (FORMAT.md, section 9).
const LOOSE: [&str; 3] = ["exact90", "beta_pole", "beta_guard"];

fn compare(btf: &Btf, vectors: &str, tags: &str) {
    let mut worst = [0.0_f32; 2];
    for (line, tag) in vectors.lines().skip(1).zip(tags.lines()) {
        let n: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
        let angles = Angles::from_degrees(n[2], n[3], n[4], n[5]);
        let value = btf.evaluate(n[0] as i32, n[1] as i32, angles, Rules::COMPATIBLE);
        let expected = glam::Vec3::new(n[6] as f32, n[7] as f32, n[8] as f32);
        let error = (value - expected).abs().max_element();
        let loose = LOOSE.contains(&tag);
        worst[usize::from(loose)] = worst[usize::from(loose)].max(error);
        let limit = if loose { 0.5 } else { 0.02 };
        assert!(error <= limit, "{line} ({tag}): {value} instead of {expected}");
    }
    println!("{}: worst {:.4}, where f32 is loose {:.4}", btf.info().name, worst[0], worst[1]);
}

/// Compares with the vectors in the file `name.kind`.
fn compare_file(folder: &Path, btf: &Btf, kind: &str) {
    let name = folder.file_name().unwrap().to_str().unwrap();
    let file = |end: &str| std::fs::read_to_string(folder.join(format!("{name}.{end}"))).unwrap();
    compare(btf, &file(kind), &file("tags.txt"));
}

#[test]
fn text_tables_give_the_vectors() {
    let Some(folder) = materials() else { return };
    for name in ["alu", "wallpaper"] {
        let folder = folder.join(name);
        let btf = read::read_text(&folder, &read::Options::default()).unwrap();
        compare_file(&folder, &btf, "csv");
    }
}

#[test]
fn binaries_give_the_vectors() {
    let Some(folder) = materials() else { return };
    for name in ["alu", "corduroy", "wallpaper"] {
        let folder = folder.join(name);
        let path = folder.join("binary.btf");
        let plain = read::Options { repairs: read::Repairs::No, ..Default::default() };
        compare_file(&folder, &read::read_binary(&path, &plain).unwrap(), "binary.csv");
        let repaired = read::read_binary(&path, &read::Options::default()).unwrap();
        compare_file(&folder, &repaired, "binary_repaired.csv");
    }
}

/// The rows of FORMAT.md, section 11: material, table, row and column.
fn wrapped_entries(note: &str) -> Vec<(String, String, u32, u32)> {
    let section = note.split("## 11.").nth(1).unwrap();
    let rows = section.lines().filter(|line| {
        line.starts_with("| ") && line.contains("PDF") || line.contains("| colours |")
    });
    rows.map(|line| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let (row, column) = cells[3].split_once(',').unwrap();
        let entry = (row.parse().unwrap(), column.parse().unwrap());
        (cells[1].to_owned(), cells[2].to_owned(), entry.0, entry.1)
    })
    .collect()
}

#[test]
fn wrapped_maxima_are_told_from_the_data() {
    let Some(folder) = materials() else { return };
    let note = std::fs::read_to_string(folder.join("FORMAT.md")).unwrap();
    let mut expected = wrapped_entries(&note);
    let mut found = Vec::new();
    for name in ["alu", "corduroy", "wallpaper"] {
        let path = folder.join(name).join("binary.btf");
        let btf = read::read_binary(&path, &read::Options::default()).unwrap();
        for repair in &btf.info().repairs {
            println!("{name}: {repair}");
            found.push((name.to_owned(), repair.table.clone(), repair.row, repair.column));
        }
    }
    expected.sort();
    found.sort();
    assert_eq!(found, expected);
}

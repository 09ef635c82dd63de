//! Test vectors of an existing evaluator, where the data is there.

mod measured;

use farlight_btf_codec::{Btf, Query, Rules, read};
use glam::Vec3;
use measured::{compare_binaries, compare_text, materials};

fn evaluate(btf: &Btf, queries: &[Query]) -> Vec<Vec3> {
    let value = |query: &Query| btf.evaluate(query.x, query.y, query.angles, Rules::COMPATIBLE);
    queries.iter().map(value).collect()
}

#[test]
fn text_tables_give_the_vectors() {
    let Some(folder) = materials() else { return };
    compare_text(&folder, evaluate);
}

#[test]
fn binaries_give_the_vectors() {
    let Some(folder) = materials() else { return };
    compare_binaries(&folder, evaluate);
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

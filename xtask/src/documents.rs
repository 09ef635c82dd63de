//! What the documents claim and a test can look up: links to files of this repository, versions,
//! commands.

use std::path::{Path, PathBuf};

use crate::{manifest, process};

/// The documents at the top and in `docs/`.
fn documents() -> Vec<(PathBuf, String)> {
    let root = process::root();
    let docs = std::fs::read_dir(root.join("docs")).into_iter().flatten();
    let below = docs.filter_map(|entry| Some(entry.ok()?.path()));
    let paths = ["README.md", "CHANGELOG.md"].map(|name| root.join(name));
    let paths = paths.into_iter().chain(below);
    paths
        .filter(|path| path.extension().is_some_and(|extension| extension == "md"))
        .map(|path| {
            let text = std::fs::read_to_string(&path).expect("a document");
            (path, text)
        })
        .collect()
}

/// Targets of Markdown links that are files, without anchors.
fn links(text: &str) -> Vec<&str> {
    text.split("](")
        .skip(1)
        .filter_map(|rest| rest.split_once(')'))
        .map(|(target, _)| target.split('#').next().unwrap_or_default())
        .filter(|target| !target.is_empty() && !target.contains("://"))
        .collect()
}

/// Rows of the Markdown table whose header starts with `first`, by cell.
fn table<'a>(text: &'a str, first: &str) -> Vec<Vec<&'a str>> {
    let cells = |line: &'a str| {
        let row = line.strip_prefix('|')?.strip_suffix('|')?;
        Some(row.split('|').map(str::trim).collect::<Vec<_>>())
    };
    text.lines()
        .map(cells)
        .skip_while(|row| row.as_ref().and_then(|row| row.first()) != Some(&first))
        .map_while(|row| row)
        .skip(2)
        .collect()
}

#[test]
fn linked_files_exist() {
    for (path, text) in documents() {
        for link in links(&text) {
            let folder = path.parent().unwrap_or(Path::new("."));
            assert!(folder.join(link).exists(), "{}: {link} does not exist", path.display());
        }
    }
}

#[test]
fn the_readme_names_the_locked_versions() {
    let root = process::root();
    let readme = std::fs::read_to_string(root.join("README.md")).expect("README.md");
    let lockfile = std::fs::read_to_string(root.join("Cargo.lock")).expect("Cargo.lock");
    let claims = table(&readme, "crate");
    assert!(claims.len() >= 5, "{claims:?}");
    for claim in claims {
        let (package, version) = (claim[0], claim[1]);
        let versions = manifest::versions(&lockfile, package);
        assert!(versions.contains(&version), "{package} {version}: locked is {versions:?}");
    }
}

#[test]
fn the_readme_s_table_of_plugins_is_true() {
    let root = process::root();
    let readme = std::fs::read_to_string(root.join("README.md")).expect("README.md");
    let plugins = table(&readme, "plugin");
    assert!(!plugins.is_empty());
    for cells in plugins {
        let exists = root.join("plugins").join(cells[0].trim_matches('`')).is_dir();
        let planned = cells[3] == "planned";
        assert!(exists != planned, "{}: state '{}', but exists is {exists}", cells[0], cells[3]);
    }
}

//! `cargo xtask assets`: what stands in assets/ is made here, byte for byte.

mod doorway;
mod environments;
mod furniture;
mod glb;
mod models;
mod pack;
mod part;
mod png;
mod shapes;
mod study;
mod textures;

use std::path::{Path, PathBuf};

use crate::{args::Args, process};

/// Help of the command.
pub(crate) const HELP: &str = "\
cargo xtask assets [--check | --materials]

Writes what this project makes itself: the scenes in assets/scenes/, the models in assets/models/ and
the environments in assets/environments/. With --check it writes nothing and fails if a file differs.
With --materials it writes assets/materials/ instead: that traces rays for some minutes. The same
machine makes the same file; others may differ in the last bits, so --check leaves these out.
";

/// Runs the command.
pub(crate) fn run(mut args: Args) -> Result<(), String> {
    let check = args.flag("--check");
    let materials = args.flag("--materials");
    args.finish()?;
    if materials {
        if check {
            return Err("--check and --materials exclude each other".to_owned());
        }
        return make_cloth();
    }
    for (path, bytes) in all() {
        if check {
            match std::fs::read(&path) {
                Ok(found) if found == bytes => continue,
                Ok(_) => {
                    return Err(format!("{} differs: run `cargo xtask assets`", path.display()));
                }
                Err(error) => return Err(format!("{}: {error}", path.display())),
            }
        }
        let folder = path.parent().unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder)
            .and_then(|()| std::fs::write(&path, &bytes))
            .map_err(|error| format!("{}: {error}", path.display()))?;
        println!("wrote {} ({} bytes)", path.display(), bytes.len());
    }
    Ok(())
}

fn make_cloth() -> Result<(), String> {
    let path = process::root().join("assets/materials/cloth.fbtf");
    let mut command = process::cargo();
    command.args(["run", "--release", "--package", "farlight_btf_codec"]);
    command.args(["--example", "woven_cloth", "--", "--out"]).arg(path);
    process::run(&mut command)
}

/// Every file: where it lies and what is in it.
fn all() -> Vec<(PathBuf, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets");
    let mut files = vec![
        (folder.join("scenes/doorway.glb"), doorway::glb()),
        (folder.join("scenes/study.glb"), study::glb()),
    ];
    let below = |name: &'static str| {
        let folder = folder.join(name);
        move |(file, bytes): (&str, Vec<u8>)| (folder.join(file), bytes)
    };
    files.extend(models::all().into_iter().map(below("models")));
    files.extend(environments::all().into_iter().map(below("environments")));
    files
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_committed_files_are_what_the_generators_make() {
        for (path, bytes) in super::all() {
            let found = std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
            assert!(
                found == bytes,
                "{} differs from its generator: run `cargo xtask assets`",
                path.display()
            );
        }
    }
}

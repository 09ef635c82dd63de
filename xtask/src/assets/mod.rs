//! `cargo xtask assets`: what stands in assets/ is made here, byte for byte.

mod doorway;
mod furniture;
mod glb;
mod pack;
mod part;
mod png;
mod shapes;
mod textures;

use std::path::{Path, PathBuf};

use crate::args::Args;

/// Help of the command.
pub(crate) const HELP: &str = "\
cargo xtask assets [--check]

Writes assets/scenes/doorway.glb. With --check it writes nothing and fails if the file differs.
";

/// Runs the command.
pub(crate) fn run(mut args: Args) -> Result<(), String> {
    let check = args.flag("--check");
    args.finish()?;
    let path = doorway_path();
    let bytes = doorway::glb();
    if check {
        return match std::fs::read(&path) {
            Ok(found) if found == bytes => Ok(()),
            Ok(_) => Err(format!("{} differs: run `cargo xtask assets`", path.display())),
            Err(error) => Err(format!("{}: {error}", path.display())),
        };
    }
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)
        .and_then(|()| std::fs::write(&path, &bytes))
        .map_err(|error| format!("{}: {error}", path.display()))?;
    println!("wrote {} ({} bytes)", path.display(), bytes.len());
    Ok(())
}

fn doorway_path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/scenes/doorway.glb")
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_committed_scene_is_what_the_generator_makes() {
        let found = std::fs::read(super::doorway_path()).expect("assets/scenes/doorway.glb");
        assert!(
            found == super::doorway::glb(),
            "assets/scenes/doorway.glb differs from its generator: run `cargo xtask assets`"
        );
    }
}

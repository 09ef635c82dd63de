//! The two facts that this tool reads from manifests: the features of the umbrella, and which
//! packages are locked. Both files are written by people and by cargo in a plain shape, so a few
//! lines replace a TOML parser.

/// Names of the `[features]` of a `Cargo.toml`, without `default`, in the file's order.
pub(crate) fn features(manifest: &str) -> Vec<String> {
    let mut names = Vec::new();
    let mut inside = false;
    // Inside a list that spans lines, a line such as `"a",` is no feature.
    let mut depth = 0_i32;
    for line in manifest.lines() {
        let line = line.trim();
        if depth == 0 && line.starts_with('[') {
            inside = line == "[features]";
            continue;
        }
        if !inside || line.is_empty() || line.starts_with('#') {
            continue;
        }
        if depth == 0
            && let Some((name, _)) = line.split_once('=')
        {
            names.push(name.trim().trim_matches('"').to_owned());
        }
        depth += line.matches('[').count() as i32 - line.matches(']').count() as i32;
    }
    names.retain(|name| name != "default");
    names
}

/// Whether a `Cargo.lock` names the package.
pub(crate) fn locks(lockfile: &str, package: &str) -> bool {
    let wanted = format!("name = \"{package}\"");
    lockfile.lines().any(|line| line.trim() == wanted)
}

/// All versions of a package in a `Cargo.lock`.
#[cfg(test)]
pub(crate) fn versions<'a>(lockfile: &'a str, package: &str) -> Vec<&'a str> {
    let wanted = format!("name = \"{package}\"");
    let lines = lockfile.lines().zip(lockfile.lines().skip(1));
    lines
        .filter(|(name, _)| *name == wanted)
        .filter_map(|(_, version)| version.strip_prefix("version = \"")?.strip_suffix('"'))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn features_without_default() {
        let manifest = "[package]\nname = \"x\"\n\n[features]\ndefault = [\"gi\"]\n## Doc.\n\
                        gi = [\"dep:gi\"]\nall = [\n    \"gi\",\n    \"a=b\",\n]\n\"remote\" = []\n\
                        [dependencies]\nserde = \"1\"\n";
        assert_eq!(features(manifest), ["gi", "all", "remote"]);
        assert!(features("[package]\n").is_empty());
    }

    #[test]
    fn the_real_manifest_has_gi() {
        let manifest = std::fs::read_to_string(crate::process::root().join("Cargo.toml")).unwrap();
        assert!(features(&manifest).contains(&"gi".to_owned()));
    }

    #[test]
    fn locked_packages_are_found_by_their_whole_name() {
        let lock = "[[package]]\nname = \"libudev-sys\"\nversion = \"0.1.4\"\n";
        assert!(locks(lock, "libudev-sys"));
        assert!(!locks(lock, "libudev"));
    }
}

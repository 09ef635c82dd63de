//! Names of files that are the same on every system and never leave their folder.

/// Longest file name that every file system takes, in bytes.
const LONGEST: usize = 255;

/// Whether a text is the plain name of a file: no folder, nothing that a system forbids, does not begin
/// with a dot or a space, nor end with one.
#[must_use]
pub fn is_plain(name: &str) -> bool {
    let edge = |c: char| c == '.' || c == ' ';
    !name.is_empty()
        && name.len() <= LONGEST
        && !name.starts_with(edge)
        && !name.ends_with(edge)
        && !name.contains(|c: char| c.is_control() || r#"/\:*?"<>|"#.contains(c))
}

/// A text as a part of a file name, with everything but letters, digits, `-` and `_` as `-`; at most 64
/// characters. It is never empty. Two texts may have the same one.
#[must_use]
pub fn part(text: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() || c == '_' { c } else { '-' };
    let part: String = text.chars().take(64).map(plain).collect();
    // Characters may be of four bytes: 64 of them with all the rest fit a file name only just.
    let cut = (0..=part.len().min(160)).rev().find(|&at| part.is_char_boundary(at)).unwrap_or(0);
    if cut == 0 { "-".to_owned() } else { part[..cut].to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_in_their_folder() {
        for name in ["room.glb", "room.lamp on.0.1a2b3c4d.ktx2", "Zimmer-ä.exr", "a..b"] {
            assert!(is_plain(name), "{name}");
        }
        let long = "x".repeat(256);
        for name in [
            "", ".", "..", "a/b", "a\\b", "C:a", "../a", ".bake", "a.", "a ", " a", "a\n", "a\0",
            &long, "a?",
        ] {
            assert!(!is_plain(name), "{name:?}");
        }
    }

    #[test]
    fn any_text_has_a_part() {
        assert_eq!(part("Lamp on, noon"), "Lamp-on--noon");
        assert_eq!(part("../x"), "---x");
        assert_eq!(part(""), "-");
        for text in ["..", "a/b", "\u{10ffff}\0", &"\u{20000}".repeat(100)] {
            let name = format!("{}.ktx2", part(text));
            assert!(is_plain(&name), "{name}");
        }
    }
}

//! Archives of measured pictures, as the University of Bonn distributed them (UBO2003).

use std::collections::BTreeSet;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::sync::Mutex;

use zip::ZipArchive;

use crate::images::{Direction, Source};
use crate::{BtfError, ImageBtf, Info};

/// Reads a zip archive of pictures, JPEG or PNG, one for each pair of directions.
///
/// The end of each name says the directions in degrees: `tl015 pl060 tv030 pv300.jpg` is light at
/// 15 degrees from the normal and azimuth 60, view at 30 and 300. Before that may stand anything;
/// blanks, `_` or `-` may stand between the four, or nothing. Other files are ignored. Pictures are
/// read when they are needed.
///
/// # Errors
///
/// Files that are no archives or damaged; directions that are missing (each view must have the same
/// lights), occur twice, or lie below the horizon; no picture at all.
pub fn read_archive(path: &Path) -> Result<ImageBtf, BtfError> {
    let file = File::open(path).map_err(|error| BtfError::io(path, error))?;
    let archive = ZipArchive::new(BufReader::new(file))
        .map_err(|error| BtfError::format(path, format!("no readable zip archive: {error}")))?;
    let mut entries = Vec::new();
    let mut directions = Vec::new();
    let mut other = Vec::new();
    for (number, raw) in archive.file_names_raw().enumerate() {
        let name = String::from_utf8_lossy(raw).into_owned();
        match directions_of(&name) {
            Some(pair) => {
                directions.push(
                    pair.map_err(|what| BtfError::format(path, format!("{name:?}: {what}")))?,
                );
                entries.push((number, name));
            }
            None if other.len() < 3 && !name.ends_with('/') => other.push(name),
            None => {}
        }
    }
    if entries.is_empty() {
        let found = if other.is_empty() {
            "it is empty".to_owned()
        } else {
            format!("there are {} entries: {:?}, ..", archive.len(), other.join(", "))
        };
        return Err(BtfError::format(
            path,
            format!("no picture whose name ends in tl000 pl000 tv000 pv000.jpg or .png; {found}"),
        ));
    }
    complete(&directions).map_err(|what| BtfError::format(path, what))?;
    let info = Info {
        name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        source: "measured pictures, zip archive".to_owned(),
        ..Info::default()
    };
    let source = Source::Archive { path: path.to_owned(), archive: Mutex::new(archive), entries };
    ImageBtf::new(info, &directions, source).map_err(|error| error.in_file(path))
}

/// Light and view of a picture, if its name says so.
pub(super) fn directions_of(name: &str) -> Option<Result<[Direction; 2], String>> {
    let (stem, extension) = name.rsplit_once('.')?;
    if !["jpg", "jpeg", "png"].contains(&extension.to_ascii_lowercase().as_str()) {
        return None;
    }
    let mut rest = stem;
    let mut angles = [0.0; 4];
    for (angle, mark) in angles.iter_mut().zip(["tl", "pl", "tv", "pv"]).rev() {
        let digits = rest.trim_end_matches(|c: char| c.is_ascii_digit() || c == '.');
        *angle = rest[digits.len()..].parse::<f64>().ok()?;
        let before = digits.len().checked_sub(2)?;
        if !digits.get(before..)?.eq_ignore_ascii_case(mark) {
            return None;
        }
        rest = digits[..before].trim_end_matches([' ', '_', '-']);
    }
    let [light_theta, light_phi, view_theta, view_phi] = angles;
    Some(
        direction(light_theta, light_phi)
            .and_then(|light| Ok([light, direction(view_theta, view_phi)?])),
    )
}

/// A direction in degrees, checked.
pub(super) fn direction(theta: f64, phi: f64) -> Result<Direction, String> {
    if (0.0..=90.0).contains(&theta) && phi.is_finite() {
        Ok(Direction::from_degrees(theta, phi))
    } else {
        Err(format!("the direction ({theta}, {phi}) is not above the surface"))
    }
}

/// Whether each view has all lights.
pub(super) fn complete(directions: &[[Direction; 2]]) -> Result<(), String> {
    let pairs: BTreeSet<&[Direction; 2]> = directions.iter().collect();
    let lights: BTreeSet<Direction> = directions.iter().map(|[light, _]| *light).collect();
    let views: BTreeSet<Direction> = directions.iter().map(|[_, view]| *view).collect();
    let missing = lights.len() * views.len() - pairs.len();
    if missing == 0 {
        return Ok(());
    }
    let examples: Vec<String> = views
        .iter()
        .flat_map(|view| lights.iter().map(move |light| [*light, *view]))
        .filter(|pair| !pairs.contains(pair))
        .take(3)
        .map(|[light, view]| format!("light {light} with view {view}"))
        .collect();
    Err(format!(
        "{missing} of {} pictures of {} lights and {} views are missing: {}",
        lights.len() * views.len(),
        lights.len(),
        views.len(),
        examples.join(", ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_read_from_the_end() {
        let expected = [Direction::from_degrees(15.0, 60.0), Direction::from_degrees(30.0, 300.0)];
        for name in [
            "00123 tl015 pl060 tv030 pv300.jpg",
            "a/tl000 pl000/x_tl015_pl060_tv030_pv300.JPG",
            "tl015pl060tv030pv300.png",
            "wool.v2 TL15 pl60-tv30.0 pv-60.jpeg".replace("pv-60", "pv300").as_str(),
        ] {
            assert_eq!(directions_of(name), Some(Ok(expected)), "{name}");
        }
        for name in ["tl015 pl060 tv030 pv300.txt", "tl015 pl060 tv030.jpg", "é.jpg", ".png", ""] {
            assert_eq!(directions_of(name), None, "{name}");
        }
        assert!(directions_of("tl015 pl060 tv095 pv300.jpg").is_some_and(|pair| pair.is_err()));
    }
}

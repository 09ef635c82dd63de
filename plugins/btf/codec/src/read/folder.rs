//! Folders of measured pictures with a list of their directions.

use std::path::{Component, Path};

use serde::Deserialize;

use super::archive::{complete, direction, directions_of};
use super::read_bounded;
use crate::images::Source;
use crate::{BtfError, ImageBtf, Info};

/// The list's name.
pub(super) const LIST: &str = "directions.ron";

/// What `directions.ron` holds.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Directions {
    #[serde(default)]
    name: Option<String>,
    /// Width and height in metres.
    #[serde(default)]
    size: Option<(f32, f32)>,
    images: Vec<Image>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Image {
    file: String,
    /// Degrees from the normal, azimuth in degrees.
    light: (f64, f64),
    view: (f64, f64),
}

/// Reads a folder of pictures, JPEG or PNG, all of one size and rectified (each texel at the same
/// place in all of them), whose directions `directions.ron` lists:
///
/// ```ron
/// Directions(
///     name: Some("velvet"),            // optional
///     size: Some((0.05, 0.05)),        // optional: width and height of a picture in metres
///     images: [
///         // Degrees from the normal, and azimuth in degrees: 0 along the columns, 90 along the
///         // rows of the picture.
///         (file: "0001.png", light: (15, 0), view: (0, 0)),
///         (file: "0002.png", light: (15, 60), view: (0, 0)),
///     ],
/// )
/// ```
///
/// Any directions will do; each view may have lights of its own. Without a list, the names of the
/// pictures must say their directions, as those of an archive do ([`read_archive`]).
/// Pictures are read when they are needed.
///
/// # Errors
///
/// Lists that are damaged or empty, directions that occur twice or lie below the horizon, pictures
/// outside the folder.
///
/// [`read_archive`]: super::read_archive
pub fn read_folder(folder: &Path) -> Result<ImageBtf, BtfError> {
    let path = folder.join(LIST);
    if !path.exists() {
        return read_named(folder);
    }
    let wrong = |what: String| BtfError::format(&path, what);
    let text = String::from_utf8(read_bounded(&path)?).map_err(|_| wrong("no text".to_owned()))?;
    let list: Directions = ron::from_str(&text).map_err(|error| wrong(error.to_string()))?;
    let mut directions = Vec::with_capacity(list.images.len());
    let mut files = Vec::with_capacity(list.images.len());
    for image in &list.images {
        let inside = |part| matches!(part, Component::Normal(_) | Component::CurDir);
        if !Path::new(&image.file).components().all(inside) || image.file.is_empty() {
            return Err(wrong(format!("{:?} is not within the folder", image.file)));
        }
        let pair = direction(image.light.0, image.light.1)
            .and_then(|light| Ok([light, direction(image.view.0, image.view.1)?]));
        directions.push(pair.map_err(|what| wrong(format!("{:?}: {what}", image.file)))?);
        files.push(folder.join(&image.file));
    }
    if let Some((width, height)) = list.size
        && !(width.is_finite() && height.is_finite() && width > 0.0 && height > 0.0)
    {
        return Err(wrong(format!("a size of {width} x {height} m")));
    }
    let info = Info {
        name: list.name.unwrap_or_else(|| name_of(folder)),
        source: "measured pictures, folder".to_owned(),
        size: list.size.map(|(width, height)| [width, height]),
        ..Info::default()
    };
    ImageBtf::new(info, &directions, Source::Folder(files)).map_err(|error| error.in_file(&path))
}

/// Whether a folder holds such pictures.
pub(super) fn is_folder(folder: &Path) -> bool {
    folder.join(LIST).exists() || !named(folder).is_empty()
}

/// Files whose names say their directions, in the order of the names.
fn named(folder: &Path) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut names: Vec<String> =
        entries.flatten().filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.retain(|name| directions_of(name).is_some());
    names.sort();
    names
}

/// An archive that was unpacked.
fn read_named(folder: &Path) -> Result<ImageBtf, BtfError> {
    let wrong = |what: String| BtfError::format(folder, what);
    let names = named(folder);
    let directions: Result<Vec<_>, String> =
        names.iter().filter_map(|name| directions_of(name)).collect();
    let directions = directions.map_err(wrong)?;
    complete(&directions).map_err(wrong)?;
    let info = Info {
        name: name_of(folder),
        source: "measured pictures, folder".to_owned(),
        ..Info::default()
    };
    let files = names.iter().map(|name| folder.join(name)).collect();
    ImageBtf::new(info, &directions, Source::Folder(files)).map_err(|error| error.in_file(folder))
}

fn name_of(folder: &Path) -> String {
    // A folder given as ".." has a name too.
    let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    folder.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

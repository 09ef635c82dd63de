//! The text form of the BTFbase format: a folder with one file a table.

mod table;

use std::fs;
use std::path::Path;

use self::table::{references, samples, scaled};
use super::description::{Description, Entry};
use super::{LIGHT_LIMIT, Options, read_bounded};
use crate::{Btf, BtfError, ColourSpace, Info, Tables};

/// Ends the name of the file that every material has.
const TEXELS: &str = "_PDF6Dslices.txt";
const DESCRIPTION: &str = "all_materialInfo.txt";

type Result<T> = std::result::Result<T, BtfError>;

/// Reads a folder of text tables: one material, or the one of several that the options name.
///
/// # Errors
///
/// Files that are missing or damaged, tables that contradict each other, several materials and no
/// name (the error lists them), variants of the format that are not understood.
pub fn read_text(folder: &Path, options: &Options) -> Result<Btf> {
    let mut remarks = Vec::new();
    let description = description(folder)?;
    let name = choose(folder, options)?;
    let entry = match &description {
        Some(description) => Some(entry(folder, description, &name, &mut remarks)?),
        None => None,
    };
    if description.is_none() {
        remarks.push(format!(
            "{DESCRIPTION} is missing: an LDR material sampled at equal steps of sin(beta) is \
             assumed"
        ));
    }

    // What materials share is named all_*, unless a folder keeps it for each material.
    let own = |table: &str| folder.join(format!("{name}_{table}.txt"));
    let shared = |table: &str| {
        let (all, own) = (folder.join(format!("all_{table}.txt")), own(table));
        if !all.exists() && own.exists() { own } else { all }
    };
    let mut texels = scaled(&own("PDF6Dslices"), &own("PDF6Dscale"), 1)?;
    let columns = texels.columns;
    if let Some(entry) = entry {
        if [texels.rows(), columns] != [entry.rows, entry.columns] {
            return Err(BtfError::format(
                own("PDF6Dslices"),
                format!(
                    "{} rows of {columns} texels; the description says {} of {}",
                    texels.rows(),
                    entry.rows,
                    entry.columns
                ),
            ));
        }
        texels.index = entry.place(&texels.index);
        texels.scale = entry.place(&texels.scale);
    }
    let tables = Tables {
        colour_space: entry.map_or(ColourSpace::YCbCr, |entry| entry.colour_space),
        beta_uniform_in_sine: description.as_ref().is_none_or(|d| d.beta_uniform_in_sine),
        texels,
        azimuths: scaled(&shared("PDF4Dslices"), &shared("PDF4Dscale"), 0)?,
        elevations: scaled(&shared("PDF3Dslices"), &shared("PDF3Dscale"), 0)?,
        slices: references(&shared("PDF2Dindices"))?,
        luminances: scaled(&shared("PDF2Dslices"), &shared("PDF2Dscale"), 0)?,
        shapes: samples(&shared("PDF1Dslice"))?,
        chromas: references(&shared("PDF2Dcolours"))?,
        colour_rows: references(&shared("indexAB"))?,
        colours: samples(&shared("colors"))?,
    };
    if let Some(description) = &description {
        for (axis, found, said) in [
            ("beta", tables.shapes.columns, description.beta),
            ("alpha", tables.luminances.columns, description.alpha),
            ("theta", tables.elevations.columns, description.theta),
            ("phi", tables.azimuths.columns, description.phi),
        ] {
            if found != said {
                let what = format!("{said} samples of {axis}, but the tables have {found}");
                return Err(BtfError::format(folder.join(DESCRIPTION), what));
            }
        }
    }
    let info = Info {
        name,
        source: "BTFbase, text".to_owned(),
        measured: description.map(|description| description.measured),
        light_limit: Some(LIGHT_LIMIT),
        remarks,
        ..Info::default()
    };
    Btf::new(info, columns, &tables).map_err(|error| error.in_file(folder))
}

/// Whether a folder holds text tables.
pub(super) fn is_text(folder: &Path) -> bool {
    names(folder).is_ok_and(|names| !names.is_empty())
}

/// What the folder says of itself, if it does.
fn description(folder: &Path) -> Result<Option<Description>> {
    let path = folder.join(DESCRIPTION);
    if !path.exists() {
        return Ok(None);
    }
    let text = text_of(&path)?;
    let parsed = Description::parse(text.lines(), 1).map_err(|error| error.in_file(&path))?;
    Ok(Some(parsed))
}

/// The material that is meant.
fn choose(folder: &Path, options: &Options) -> Result<String> {
    let mut names = names(folder)?;
    let listed = names.join(", ");
    match &options.material {
        Some(wanted) if names.contains(wanted) => Ok(wanted.clone()),
        Some(wanted) => {
            Err(BtfError::format(folder, format!("there is no {wanted:?}, only: {listed}")))
        }
        None => match names.len() {
            0 => Err(BtfError::format(
                folder,
                format!("no file NAME{TEXELS}: not a folder of BTFbase tables"),
            )),
            1 => Ok(names.remove(0)),
            _ => Err(BtfError::format(
                folder,
                format!("several materials, choose one by its name: {listed}"),
            )),
        },
    }
}

/// The materials whose texels are there, sorted.
fn names(folder: &Path) -> Result<Vec<String>> {
    let entries = fs::read_dir(folder).map_err(|error| BtfError::io(folder, error))?;
    let mut names: Vec<String> = entries
        .flatten()
        .filter_map(|entry| {
            let file = entry.file_name().into_string().ok()?;
            Some(file.strip_suffix(TEXELS)?.to_owned())
        })
        .collect();
    names.sort();
    Ok(names)
}

/// What the description says of a material.
fn entry<'a>(
    folder: &Path,
    description: &'a Description,
    name: &str,
    remarks: &mut Vec<String>,
) -> Result<&'a Entry> {
    match (
        description.materials.iter().find(|entry| entry.name == name),
        &description.materials[..],
    ) {
        (Some(entry), _) => Ok(entry),
        // The tables were renamed.
        (None, [only]) => {
            remarks.push(format!("the description calls the material {:?}", only.name));
            Ok(only)
        }
        (None, _) => Err(BtfError::format(
            folder.join(DESCRIPTION),
            format!("there is no {name:?}, only: {}", description.names()),
        )),
    }
}

fn text_of(path: &Path) -> Result<String> {
    String::from_utf8(read_bounded(path)?).map_err(|error| {
        let good = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + good.iter().filter(|byte| **byte == b'\n').count();
        BtfError::format(path, format!("line {line} is no text"))
    })
}

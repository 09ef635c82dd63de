//! The binary form of the BTFbase format: 18 lines of text, then quantized tables.

mod decode;
mod repair;

use std::path::Path;

use self::decode::{Codes, Cursor};
use super::description::Description;
use super::{LIGHT_LIMIT, Options, Repairs, read_bounded};
use crate::{Btf, BtfError, Info, References, Samples, Scaled, Tables};

/// The first line of every file that is known.
const FIRST_LINE: &str = "4627";

/// Reads a BTFbase binary.
///
/// The format's writer stores the greatest number of each table as the least one, by mistake. With
/// [`Repairs::Yes`] these entries are looked for and put right as far as the data tells them;
/// [`Info::repairs`] lists them.
///
/// # Errors
///
/// Files that can't be read, are damaged or cut off, or of a variant that is not understood.
pub fn read_binary(path: &Path, options: &Options) -> Result<Btf, BtfError> {
    binary_from_bytes(&read_bounded(path)?, options).map_err(|error| error.in_file(path))
}

/// Whether bytes begin as a BTFbase binary does: two lines with a number each. The first may be a
/// version, so others than the known one are tried too.
pub(crate) fn is_binary(bytes: &[u8]) -> bool {
    let number = |line: Option<&[u8]>| {
        line.is_some_and(|line| {
            (1..=10).contains(&line.len()) && line.iter().all(u8::is_ascii_digit)
        })
    };
    let mut lines =
        bytes.get(..bytes.len().min(64)).unwrap_or_default().split(|byte| *byte == b'\n');
    number(lines.next()) && number(lines.next()) && lines.next().is_some()
}

/// All tables as they are stored.
pub(super) struct Stored {
    pub(super) texels: Vec<u32>,
    pub(super) texel_scales: Codes,
    pub(super) shapes: Codes,
    pub(super) colours: Codes,
    pub(super) colour_rows: Vec<u32>,
    pub(super) luminances: Vec<u32>,
    pub(super) luminance_scales: Codes,
    pub(super) chromas: Vec<u32>,
    pub(super) slices: Vec<u32>,
    pub(super) elevations: Vec<u32>,
    pub(super) elevation_scales: Codes,
    pub(super) azimuths: Vec<u32>,
    pub(super) azimuth_scales: Codes,
}

/// Reads the bytes of a BTFbase binary; see [`read_binary`].
pub(crate) fn binary_from_bytes(bytes: &[u8], options: &Options) -> Result<Btf, BtfError> {
    let mut cursor = Cursor::new(bytes);
    let lines = cursor.lines(18)?;
    let [first, materials, description @ ..] = &lines[..] else {
        return Err(BtfError::Tables("cut off".to_owned()));
    };
    if materials.trim() != "1" {
        return Err(BtfError::Unsupported(format!(
            "a binary of {:?} materials; one is",
            materials.trim()
        )));
    }
    let description = Description::parse(description.iter().copied(), 3)?;
    let [material] = &description.materials[..] else {
        return Err(BtfError::Unsupported(format!(
            "a binary of {} materials: {}; one is",
            description.materials.len(),
            description.names()
        )));
    };
    if let Some(name) = options.material.as_ref().filter(|name| **name != material.name) {
        return Err(BtfError::Tables(format!("there is no {name:?}, only {:?}", material.name)));
    }
    let (rows, alpha) = (description.rows, description.alpha);
    let shared = |rows: usize, columns: usize| [rows, columns];
    let size = [material.rows, material.columns];
    let mut stored = Stored {
        texels: cursor.integers("PDF6Dslices", size)?,
        texel_scales: cursor.codes("PDF6Dscale", size)?,
        shapes: cursor.codes("PDF1D", shared(rows.shapes, description.beta))?,
        colours: cursor.codes("colours", shared(rows.colours, 2))?,
        colour_rows: cursor.integers("indexAB", shared(rows.colour_rows, description.beta))?,
        luminances: cursor.integers("PDF2Dslices", shared(rows.luminances, alpha))?,
        luminance_scales: cursor.codes("PDF2Dscale", shared(rows.luminances, alpha))?,
        chromas: cursor.integers("PDF2Dcolours", shared(rows.chromas, alpha))?,
        slices: cursor.integers("PDF2Dindices", shared(rows.slices, 2))?,
        elevations: cursor.integers("PDF3Dslices", shared(rows.elevations, description.theta))?,
        elevation_scales: cursor.codes("PDF3Dscale", shared(rows.elevations, description.theta))?,
        azimuths: cursor.integers("PDF4Dslices", shared(rows.azimuths, description.phi))?,
        azimuth_scales: cursor.codes("PDF4Dscale", shared(rows.azimuths, description.phi))?,
    };
    cursor.end()?;
    for (at, index) in stored.texels.iter_mut().enumerate() {
        *index = index.checked_sub(1).ok_or_else(|| {
            BtfError::Unsupported(format!(
                "texels that have not been compressed yet: row {}, column {}",
                at / material.columns,
                at % material.columns
            ))
        })?;
    }
    let mut remarks = Vec::new();
    if *first != FIRST_LINE {
        remarks.push(format!("the file begins with {first:?}, known ones with {FIRST_LINE:?}"));
    }
    let repairs = match options.repairs {
        Repairs::Yes => repair::repair(&mut stored)?,
        Repairs::No => Vec::new(),
    };

    let scaled = |index: Vec<u32>, scales: &Codes| Scaled {
        columns: scales.columns,
        index,
        scale: scales.values(),
        range: Some(scales.range),
    };
    let samples = |codes: &Codes| Samples {
        columns: codes.columns,
        value: codes.values(),
        range: Some(codes.range),
    };
    let references = |columns: usize, index: Vec<u32>| References { columns, index };
    let mut texels = scaled(material.place(&stored.texels), &stored.texel_scales);
    texels.scale = material.place(&texels.scale);
    let tables = Tables {
        colour_space: material.colour_space,
        beta_uniform_in_sine: description.beta_uniform_in_sine,
        texels,
        azimuths: scaled(stored.azimuths, &stored.azimuth_scales),
        elevations: scaled(stored.elevations, &stored.elevation_scales),
        slices: references(2, stored.slices),
        luminances: scaled(stored.luminances, &stored.luminance_scales),
        shapes: samples(&stored.shapes),
        chromas: references(alpha, stored.chromas),
        colour_rows: references(description.beta, stored.colour_rows),
        colours: samples(&stored.colours),
    };
    let info = Info {
        name: material.name.clone(),
        source: "BTFbase, binary".to_owned(),
        measured: Some(description.measured),
        light_limit: Some(LIGHT_LIMIT),
        repairs,
        remarks,
        ..Info::default()
    };
    Btf::new(info, material.columns, &tables)
}

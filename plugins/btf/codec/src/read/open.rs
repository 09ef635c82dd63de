//! Any material, told by its content.

use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use super::folder::{self, LIST};
use super::{Options, binary, read_archive, read_binary, read_folder, read_text, text};
use crate::{Btf, BtfError, ImageBtf, Info, file};

/// What a file or a folder holds.
#[derive(Debug)]
pub enum Material {
    /// Compressed tables.
    Tables(Btf),
    /// Pictures as they were measured.
    Images(ImageBtf),
}

impl Material {
    /// What is known of it.
    pub fn info(&self) -> &Info {
        match self {
            Self::Tables(btf) => btf.info(),
            Self::Images(images) => images.info(),
        }
    }

    /// Width and height in texels.
    pub fn size(&self) -> [u32; 2] {
        match self {
            Self::Tables(btf) => btf.size(),
            Self::Images(images) => images.size(),
        }
    }
}

/// Opens any material:
///
/// - a folder of BTFbase text tables ([`read_text`]); where some are missing and a `binary.btf` is
///   beside them, that one;
/// - a folder with a `binary.btf`, or such a file itself ([`read_binary`]);
/// - an own file, `.fbtf` ([`Btf::open`]);
/// - a zip archive of pictures ([`read_archive`]), or a folder of pictures with a list of their
///   directions ([`read_folder`]).
///
/// Names of files don't matter, except within folders.
///
/// # Errors
///
/// Nothing of that kind (the error says what was found), and whatever the readers say.
pub fn open(path: &Path, options: &Options) -> Result<Material, BtfError> {
    let metadata = fs::metadata(path).map_err(|error| BtfError::io(path, error))?;
    if metadata.is_dir() { open_folder(path, options) } else { open_file(path, options) }
}

fn open_folder(folder: &Path, options: &Options) -> Result<Material, BtfError> {
    let binary = folder.join("binary.btf");
    if text::is_text(folder) {
        match read_text(folder, options) {
            Err(BtfError::Io { path, source })
                if source.kind() == std::io::ErrorKind::NotFound && binary.exists() =>
            {
                let btf = read_binary(&binary, options)?;
                let mut info = btf.info().clone();
                let missing = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                info.remarks.push(format!("{missing} is missing: binary.btf was read instead"));
                return Ok(Material::Tables(btf.with_info(info)));
            }
            other => return other.map(Material::Tables),
        }
    }
    if binary.exists() {
        return read_binary(&binary, options).map(Material::Tables);
    }
    if folder::is_folder(folder) {
        return read_folder(folder).map(Material::Images);
    }
    Err(BtfError::format(
        folder,
        format!(
            "no material: neither BTFbase tables (NAME_PDF6Dslices.txt and others), nor binary.btf, \
             nor pictures with {LIST}; {}",
            contents(folder)?
        ),
    ))
}

/// A few words on what is in a folder.
fn contents(folder: &Path) -> Result<String, BtfError> {
    let entries = fs::read_dir(folder).map_err(|error| BtfError::io(folder, error))?;
    let mut names: Vec<String> =
        entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    Ok(match names.len() {
        0 => "it is empty".to_owned(),
        count => {
            let more = if count > 4 { ", .." } else { "" };
            names.truncate(4);
            format!("there are {count} files: {}{more}", names.join(", "))
        }
    })
}

fn open_file(path: &Path, options: &Options) -> Result<Material, BtfError> {
    let mut first = Vec::new();
    let io = |error| BtfError::io(path, error);
    File::open(path).map_err(io)?.take(64).read_to_end(&mut first).map_err(io)?;
    if file::is_own(&first) {
        return Btf::open(path).map(Material::Tables);
    }
    if binary::is_binary(&first) {
        return read_binary(path, options).map(Material::Tables);
    }
    if first.starts_with(b"PK") {
        return read_archive(path).map(Material::Images);
    }
    let begins = match first.len() {
        0 => "it is empty".to_owned(),
        _ => format!("it begins with \"{}\"", first[..first.len().min(16)].escape_ascii()),
    };
    Err(BtfError::format(
        path,
        format!(
            "no material: neither an .fbtf file, nor a BTFbase binary, nor a zip archive; {begins}"
        ),
    ))
}

//! `farlight btf import`: any material into the suite's own file.

use std::{ops::ControlFlow, path::PathBuf};

use farlight_btf_codec::{
    Btf, ImageBtf, Info, Resampled,
    compress::{Grid, Quality, Settings, compress},
    read::Material,
};

use super::Source;
use crate::{error::CliError, output::WholeFile, progress};

/// Convert a material into an .fbtf file, which the plugins load
///
/// The file holds the tables as shaders read them, with a checksum; it is read in place, without
/// unpacking. Values of tables stay the same; measured pictures are compressed, which takes minutes
/// for a set of 6561 pictures of 256 x 256 texels.
#[derive(clap::Args)]
#[command(after_help = materials!())]
pub(crate) struct Args {
    #[command(flatten)]
    source: Source,
    /// The file to write; written whole or not at all
    #[arg(long, value_name = "X.fbtf")]
    out: PathBuf,
    /// Width and height of the picture on the real surface in metres
    #[arg(long, value_name = "W,H", value_parser = parse_size)]
    size_m: Option<[f32; 2]>,
    /// For measured pictures, which are compressed: the root mean square error that a texel may have
    /// over all directions, in 1 of 255
    #[arg(long, value_name = "E", default_value_t = 6.0, value_parser = parse_error)]
    error: f32,
}

/// A number above 0.
fn parse_error(text: &str) -> Result<f32, String> {
    let error: f32 = text.parse().map_err(|_| "not a number".to_owned())?;
    if error.is_finite() && error > 0.0 {
        Ok(error)
    } else {
        Err("must be finite and above 0".to_owned())
    }
}

/// Two lengths with a comma, above 0.
fn parse_size(text: &str) -> Result<[f32; 2], String> {
    let numbers: Vec<f32> = text
        .split(',')
        .map(|t| t.trim().parse().map_err(|_| format!("{t:?} is not a number")))
        .collect::<Result<_, _>>()?;
    let [width, height] = numbers[..] else {
        return Err(format!("{} numbers, must be two: W,H", numbers.len()));
    };
    if [width, height].iter().all(|length| length.is_finite() && *length > 0.0) {
        Ok([width, height])
    } else {
        Err("must be finite and above 0".to_owned())
    }
}

/// Runs the subcommand.
pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    drop(WholeFile::create(&args.out)?);
    let btf = match args.source.open()? {
        Material::Tables(btf) => btf,
        Material::Images(images) => compressed(&images, args.error)?,
    };
    args.source.warn(btf.info());
    let btf = match args.size_m {
        None => btf,
        Some(size) => {
            let info = Info { size: Some(size), ..btf.info().clone() };
            btf.with_info(info)
        }
    };
    btf.write(&args.out)?;
    let [columns, rows] = btf.size();
    println!(
        "{}: {} of {columns} x {rows} texels, {} bytes",
        args.out.display(),
        btf.info().name,
        std::fs::metadata(&args.out).map_or(0, |data| data.len())
    );
    Ok(())
}

/// Measured pictures as tables.
fn compressed(images: &ImageBtf, error: f32) -> Result<Btf, CliError> {
    let settings = Settings { quality: Quality::Error(error), ..Settings::default() };
    let bar = progress::bar(1000, "compressed");
    let mut advance = |done: f32| {
        bar.set_position((1000.0 * done) as u64);
        ControlFlow::Continue(())
    };
    let mut source = Resampled::new(images, Grid::default());
    let compressed =
        compress(&mut source, &settings, &mut advance)?.ok_or_else(|| CliError::new("stopped"))?;
    bar.finish_and_clear();
    let report = compressed.report;
    println!(
        "compressed: root mean square error {:.2} of 255 ({:.1} dB), worst texel {:.2}",
        report.error,
        report.psnr(),
        report.worst_texel
    );
    let mut info = images.info().clone();
    info.remarks.push(format!("compressed with an error of {:.2} of 255", report.error));
    Ok(compressed.into_btf(info)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!(parse_size("0.1, 2"), Ok([0.1, 2.0]));
        for bad in ["1", "1,2,3", "0,1", "1,-1", "1,inf", "a,b", ""] {
            assert!(parse_size(bad).is_err(), "{bad}");
        }
    }
}

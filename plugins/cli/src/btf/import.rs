//! `farlight btf import`: any material into the suite's own file.

use std::path::PathBuf;

use farlight_btf_codec::{Info, read::Material};

use super::Source;
use crate::{error::CliError, output::WholeFile};

/// Convert a material into an .fbtf file, which the plugins load
///
/// The file holds the tables as shaders read them, with a checksum; it is read in place, without
/// unpacking. Values stay the same.
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
        Material::Images(_) => {
            return Err(CliError::new(format!(
                "{}: measured pictures must be compressed, which this build can't yet",
                args.source.path.display()
            )));
        }
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

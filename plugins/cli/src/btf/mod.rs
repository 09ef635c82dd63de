//! `farlight btf`: measured materials.

/// Ends the help of each subcommand.
macro_rules! materials {
    () => {
        "\
MATERIAL is one of
  a folder of BTFbase text tables   NAME_PDF6Dslices.txt, all_PDF4Dslices.txt and so on; where one of
                                    them is missing, the folder's binary.btf
  a folder with a binary.btf        or that file itself
  a zip archive of pictures         as UBO2003 has them: names end in tl000 pl000 tv000 pv000.jpg
  a folder of pictures              with directions.ron, or with such names
  an .fbtf file                     as import writes it"
    };
}

mod eval;
mod import;
mod info;
mod queries;
mod render;

use std::path::PathBuf;

use clap::Subcommand;
use farlight_btf_codec::{Btf, Info, read};

use crate::error::CliError;

/// Measured materials (BTFs): what is in a file, values, conversion, pictures
///
/// A bidirectional texture function says for each texel, each direction of light and each direction
/// of view how bright and of what colour a surface is.
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Info(info::Args),
    Import(import::Args),
    Eval(eval::Args),
    Render(render::Args),
}

/// Runs the subcommand.
pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    match &args.command {
        Command::Info(args) => info::run(args),
        Command::Import(args) => import::run(args),
        Command::Eval(args) => eval::run(args),
        Command::Render(args) => render::run(args),
    }
}

/// A material on the command line.
#[derive(clap::Args)]
struct Source {
    /// The material; what it is, is told by its content (see below)
    #[arg(value_name = "MATERIAL")]
    path: PathBuf,
    /// The material's name, where a folder of tables holds several
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Take a BTFbase binary as it is stored. Its writer stores the greatest number of each table
    /// as the least one; by default these entries are found and put right
    #[arg(long)]
    no_repair: bool,
}

impl Source {
    /// Opens it.
    fn open(&self) -> Result<read::Material, CliError> {
        let repairs = if self.no_repair { read::Repairs::No } else { read::Repairs::Yes };
        Ok(read::open(&self.path, &read::Options { repairs, material: self.name.clone() })?)
    }

    /// Says on the standard error what whoever uses the values should know.
    fn warn(&self, info: &Info) {
        for repair in &info.repairs {
            eprintln!("warning: {}: repaired: {repair}", self.path.display());
        }
        for remark in &info.remarks {
            eprintln!("warning: {}: {remark}", self.path.display());
        }
    }
}

/// Bytes of the tables.
fn table_bytes(btf: &Btf) -> u64 {
    btf.table_sizes().iter().map(|table| table.bytes).sum()
}

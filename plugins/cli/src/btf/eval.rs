//! `farlight btf eval`: values of a material for a list of queries.

use std::{path::PathBuf, thread, time::Instant};

use clap::ValueEnum;
use farlight_btf_codec::{
    Angles, Btf, ImageBtf, Query, Rules,
    gpu::{Gpu, GpuError, GpuEvaluator},
    read::Material,
};
use glam::Vec3;

use super::Source;
use super::queries::{Asked, COLUMNS, Queries};
use crate::{error::CliError, output::WholeFile, progress};

/// Evaluate a material for a list of texels and directions
///
/// Memory does not grow with the number of queries.
#[derive(clap::Args)]
#[command(after_help = FORMATS, after_long_help = FORMATS)]
pub(crate) struct Args {
    #[command(flatten)]
    source: Source,
    /// The queries, as CSV (see below)
    #[arg(long, value_name = "IN.csv")]
    queries: PathBuf,
    /// Where the values go, as CSV in the same order (see below); written whole or not at all
    #[arg(long, value_name = "OUT.csv")]
    out: PathBuf,
    /// What computes
    #[arg(long, value_enum, default_value_t = Backend::Cpu)]
    backend: Backend,
    /// Deviate from what is sound in the two ways in which existing evaluators of the BTFbase format
    /// do: the slope at the end of each interval over beta, and alpha near the axis across the view
    #[arg(long)]
    compat: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Backend {
    /// All cores of this machine
    Cpu,
    /// The graphics device, through the shaders of the plugin
    Gpu,
}

const FORMATS: &str = concat!(
    "\
IN.csv: a header with the columns x,y,theta_i,phi_i,theta_v,phi_v in any order; others are ignored
  x, y              column and row of the texel, whole numbers; they wrap round
  theta_i, phi_i    direction of the light in degrees: from the normal, and round it
  theta_v, phi_v    direction of the view in degrees

OUT.csv: x,y,theta_i,phi_i,theta_v,phi_v,r,g,b, one row a query, in the same order, the first six as
they stand in IN.csv. r, g, b have the cosine of the light in them and are gamma-encoded: 0 to 255 for
an LDR material, and beyond where it is brighter than white. Black where a theta is above 90.

",
    materials!()
);

/// Queries that are answered at once.
const CHUNK: usize = 1 << 16;

/// Answers queries.
trait Evaluate {
    /// Red, green and blue for each query.
    fn evaluate(&mut self, queries: &[Query]) -> Result<Vec<Vec3>, CliError>;
}

/// Runs the subcommand.
pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    let start = Instant::now();
    let material = args.source.open()?;
    let rules = if args.compat { Rules::COMPATIBLE } else { Rules::default() };
    args.source.warn(material.info());
    let mut evaluator: Box<dyn Evaluate + '_> = match (args.backend, &material) {
        (Backend::Cpu, Material::Tables(btf)) => Box::new(Cpu { btf, rules }),
        (Backend::Cpu, Material::Images(images)) => Box::new(Pictures(images)),
        (Backend::Gpu, Material::Tables(btf)) => {
            let gpu = Gpu::new().map_err(gpu_trouble)?;
            Box::new(GpuEvaluator::new(&gpu, btf, rules).map_err(gpu_trouble)?)
        }
        (Backend::Gpu, Material::Images(_)) => {
            return Err(CliError::new("--backend gpu: for compressed tables only; import them"));
        }
    };
    let count = evaluate_file(args, material.size(), evaluator.as_mut())?;
    println!("{}: {count} values; {:.1} s", args.out.display(), start.elapsed().as_secs_f64());
    Ok(())
}

/// All queries of the file; returns their number.
fn evaluate_file(
    args: &Args,
    size: [u32; 2],
    evaluator: &mut dyn Evaluate,
) -> Result<u64, CliError> {
    let mut queries = Queries::open(&args.queries)?;
    let length = std::fs::metadata(&args.queries).map_or(0, |data| data.len());
    let bar = progress::bar(length, "{bytes} of {total_bytes} of queries");
    let mut out = csv::Writer::from_writer(WholeFile::create(&args.out)?);
    let written = |error: csv::Error| {
        CliError::new(format!("{}: can't be written: {error}", args.out.display()))
    };
    out.write_record(COLUMNS.iter().chain(&["r", "g", "b"])).map_err(written)?;
    let (mut count, mut rows, mut asked) = (0, Vec::new(), Vec::new());
    loop {
        rows.clear();
        asked.clear();
        while rows.len() < CHUNK
            && let Some(row) = queries.next()?
        {
            asked.push(resolve(&row.asked, size));
            rows.push(row.fields);
        }
        if rows.is_empty() {
            break;
        }
        let values = evaluator.evaluate(&asked)?;
        for (fields, value) in rows.iter_mut().zip(values) {
            for channel in value.to_array() {
                fields.push_field(channel.to_string().as_bytes());
            }
            out.write_byte_record(fields).map_err(written)?;
        }
        count += rows.len() as u64;
        bar.set_position(queries.position());
    }
    bar.finish_and_clear();
    let file = out.into_inner().map_err(|error| {
        CliError::new(format!("{}: can't be written: {}", args.out.display(), error.error()))
    })?;
    file.finish()?;
    Ok(count)
}

/// The query as evaluators have it: the texel wrapped into `size`.
fn resolve(query: &Asked, size: [u32; 2]) -> Query {
    let wrap = |at: i64, size: u32| at.rem_euclid(i64::from(size)) as i32;
    // Below 0 is the other side of the normal.
    let side =
        |theta: f64, phi: f64| if theta < 0.0 { (-theta, phi + 180.0) } else { (theta, phi) };
    let [theta_i, phi_i, theta_v, phi_v] = query.degrees;
    let ((theta_i, phi_i), (theta_v, phi_v)) = (side(theta_i, phi_i), side(theta_v, phi_v));
    let angles = Angles::from_degrees(theta_i, phi_i, theta_v, phi_v);
    Query { x: wrap(query.x, size[0]), y: wrap(query.y, size[1]), angles }
}

/// Vectors on all cores.
struct Cpu<'a> {
    btf: &'a Btf,
    rules: Rules,
}

impl Evaluate for Cpu<'_> {
    fn evaluate(&mut self, queries: &[Query]) -> Result<Vec<Vec3>, CliError> {
        let mut values = vec![Vec3::ZERO; queries.len()];
        let threads = thread::available_parallelism().map_or(1, usize::from);
        let share = queries.len().div_ceil(threads).max(1);
        thread::scope(|scope| {
            for (queries, values) in queries.chunks(share).zip(values.chunks_mut(share)) {
                scope.spawn(|| self.btf.evaluate_batch(queries, self.rules, values));
            }
        });
        Ok(values)
    }
}

impl Evaluate for GpuEvaluator {
    fn evaluate(&mut self, queries: &[Query]) -> Result<Vec<Vec3>, CliError> {
        Self::evaluate(self, queries).map_err(gpu_trouble)
    }
}

fn gpu_trouble(error: GpuError) -> CliError {
    CliError::new(format!("--backend gpu: {error}"))
}

/// Between measured pictures.
struct Pictures<'a>(&'a ImageBtf);

impl Evaluate for Pictures<'_> {
    fn evaluate(&mut self, queries: &[Query]) -> Result<Vec<Vec3>, CliError> {
        Ok(self.0.evaluate_all(queries)?)
    }
}

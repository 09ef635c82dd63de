//! `farlight ibl compare`: error against the number of lights.

use std::{io::Write, path::PathBuf};

use farlight_environment::{LightExtractor, Method, measure::Truth};

use super::{Source, check_ending, plot};
use crate::{error::CliError, output::WholeFile, progress};

/// Compare the methods: error against the number of lights
///
/// The error is that of the diffuse irradiance of normals all round, without shadows: its difference from
/// what the whole map gives, over that, its channels added up; the mean over the normals and seeds of
/// the absolute value.
#[derive(clap::Args)]
#[command(after_help = maps!())]
pub(crate) struct Args {
    #[command(flatten)]
    source: Source,
    /// Numbers of lights, with commas, 1 to 4096 each
    #[arg(long, value_name = "N,..", default_value = "5,10,20,50,100,200,256,500,1000,2000,4096", value_parser = parse_counts)]
    counts: Counts,
    /// Seeds, from 0 on
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    seeds: u64,
    /// Normals, evenly over the sphere
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    normals: u32,
    /// A plot of the table
    #[arg(long, value_name = "X.svg")]
    out: Option<PathBuf>,
}

/// Numbers of lights, ascending.
#[derive(Clone)]
struct Counts(Vec<u32>);

fn parse_counts(text: &str) -> Result<Counts, String> {
    let count = |text: &str| match text.trim().parse::<u32>() {
        Ok(count) if (1..=4096).contains(&count) => Ok(count),
        Ok(count) => Err(format!("{count} lights: must be 1 to 4096")),
        Err(_) => Err(format!("{text:?} is not a number of lights")),
    };
    let mut counts: Vec<u32> = text.split(',').map(count).collect::<Result<_, _>>()?;
    counts.sort_unstable();
    counts.dedup();
    Ok(Counts(counts))
}

/// Runs the subcommand.
pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    let out = match &args.out {
        Some(path) => {
            check_ending(path, "svg")?;
            Some((path, WholeFile::create(path)?))
        }
        None => None,
    };
    let map = args.source.open()?;
    let truth = Truth::new(&map, args.normals as usize);
    if truth.normals().is_empty() {
        let path = args.source.path.display();
        return Err(CliError::new(format!(
            "{path}: the map is black: there is nothing to compare"
        )));
    }
    let counts = &args.counts.0;
    let bar = progress::bar(
        Method::ALL.len() as u64 * counts.len() as u64 * args.seeds,
        "{human_pos} of {human_len} sets of lights",
    );
    let curves = Method::ALL.map(|method| {
        let extractor = LightExtractor::new(&map, method);
        let mean = |count: &u32| {
            let errors = (0..args.seeds).map(|seed| {
                bar.inc(1);
                truth.error(&extractor.lights(*count, seed)).mean
            });
            errors.sum::<f64>() / args.seeds as f64
        };
        plot::Curve { method, errors: counts.iter().map(mean).collect() }
    });
    bar.finish_and_clear();

    let name = args.source.path.file_name().unwrap_or_default().to_string_lossy();
    println!("{name}: {} x {} texels", map.width(), map.height());
    println!(
        "error of the irradiance of {} normals in %, mean over {} seeds",
        truth.normals().len(),
        args.seeds
    );
    print!("{}", table(counts, &curves));
    if let Some((path, mut file)) = out {
        let title = format!("{name}: error of diffuse irradiance");
        file.write_all(plot::svg(&title, counts, &curves).as_bytes())
            .map_err(|error| CliError::io(path, "written", &error))?;
        file.finish()?;
        println!("{}: plot", path.display());
    }
    Ok(())
}

fn table(counts: &[u32], curves: &[plot::Curve]) -> String {
    let mut text = format!("{:>6}", "lights");
    for curve in curves {
        text += &format!("{:>13}", curve.method);
    }
    text.push('\n');
    for (at, count) in counts.iter().enumerate() {
        text += &format!("{count:>6}");
        for curve in curves {
            text += &format!("{:>13.3}", 100.0 * curve.errors[at]);
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts() {
        assert_eq!(parse_counts("7, 5,7").map(|counts| counts.0), Ok(vec![5, 7]));
        for bad in ["", "5,", "0", "4097", "a"] {
            assert!(parse_counts(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_table_has_a_row_a_count() {
        let curve = |method, errors: &[f64]| plot::Curve { method, errors: errors.to_vec() };
        let curves =
            [curve(Method::Independent, &[0.5, 0.1]), curve(Method::Centroids, &[0.25, 0.001])];
        let text = table(&[5, 4096], &curves);
        let rows: Vec<Vec<&str>> =
            text.lines().map(|line| line.split_whitespace().collect()).collect();
        assert_eq!(rows[0], ["lights", "independent", "centroids"]);
        assert_eq!(rows[1], ["5", "50.000", "25.000"]);
        assert_eq!(rows[2], ["4096", "10.000", "0.100"]);
    }
}

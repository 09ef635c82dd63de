//! `farlight btf info`: what a material is.

use farlight_btf_codec::{Angles, Btf, ColourSpace, ImageBtf, Info, Query, Rules, read::Material};
use glam::Vec3;

use super::{Source, table_bytes};
use crate::error::CliError;

/// Show what a material is: texels, directions, tables, what was repaired
#[derive(clap::Args)]
#[command(after_help = materials!())]
pub(crate) struct Args {
    #[command(flatten)]
    source: Source,
}

/// Runs the subcommand.
pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    match args.source.open()? {
        Material::Tables(btf) => print!("{}", tables(&btf)),
        Material::Images(images) => print!("{}", pictures(&images)?),
    }
    Ok(())
}

/// A line: what, and its value.
fn line(name: &str, value: impl std::fmt::Display) -> String {
    format!("{name:<12} {value}\n")
}

/// What is known of any material.
fn about(info: &Info, [columns, rows]: [u32; 2]) -> String {
    let mut text = line("name", &info.name);
    text += &line("source", &info.source);
    text += &line("texels", format_args!("{columns} x {rows}"));
    text += &line(
        "size",
        match info.size {
            Some([width, height]) => format!("{width} m x {height} m"),
            None => "unknown".to_owned(),
        },
    );
    text
}

/// All about compressed tables.
fn tables(btf: &Btf) -> String {
    let (info, layout) = (btf.info(), btf.layout());
    let [columns, rows] = btf.size();
    let mut text = about(info, btf.size());
    text += &line(
        "view",
        format_args!("{} azimuths x {} elevations", layout.phi_count, layout.theta_count),
    );
    text +=
        &line("light", format_args!("{} alpha x {} beta", layout.alpha_count, layout.beta_count));
    text += &line(
        "colours",
        match btf.colour_space() {
            ColourSpace::YCbCr => "LDR: YCbCr, values gamma-encoded, 255 is white".to_owned(),
            ColourSpace::LogLuv { factor } => {
                format!("HDR: LogLuv, values sRGB-encoded and divided by {factor}")
            }
        },
    );
    let values = mean_queries(btf.size())
        .into_iter()
        .map(|Query { x, y, angles }| btf.evaluate(x, y, angles, Rules::default()));
    text += &mean_colour(values.collect());
    text += &line("tables", "   rows  columns       bytes");
    for table in btf.table_sizes() {
        let numbers = format!("{:>7}  {:>7}  {:>10}", table.rows, table.columns, table.bytes);
        text += &format!("  {}", line(table.name, numbers));
    }
    let bytes = table_bytes(btf);
    text += &line("all tables", format_args!("{bytes} bytes"));
    text += &line(
        "measurement",
        match info.measured {
            None => "unknown".to_owned(),
            Some([views, lights]) => {
                let texels = u64::from(columns) * u64::from(rows);
                let pictures = u64::from(views) * u64::from(lights);
                let measured = texels.saturating_mul(pictures).saturating_mul(3);
                format!(
                    "{views} views x {lights} lights, {measured} bytes: {:.1} times the tables",
                    measured as f64 / bytes as f64
                )
            }
        },
    );
    if info.repairs.is_empty() {
        text += &line("repaired", "nothing");
    }
    for repair in &info.repairs {
        text += &line("repaired", repair);
    }
    for remark in &info.remarks {
        text += &line("remark", remark);
    }
    text
}

/// All about measured pictures.
fn pictures(images: &ImageBtf) -> Result<String, CliError> {
    let mut text = about(images.info(), images.size());
    let [views, lights] = images.directions();
    let [views_in, lights_in] = images.rings().map(|rings| match rings {
        Some(rings) => format!("{rings} rings"),
        None => "scattered".to_owned(),
    });
    text += &line("views", format_args!("{views}, {views_in}"));
    text += &line("lights", format_args!("{lights} for each view, {lights_in}"));
    let [columns, rows] = images.size().map(u64::from);
    let bytes = columns.saturating_mul(rows).saturating_mul(3 * images.pictures() as u64);
    text += &line("pictures", format_args!("{}, {bytes} bytes decoded", images.pictures()));
    let values = images.evaluate_all(&mean_queries(images.size()))?;
    text += &mean_colour(values);
    Ok(text)
}

/// At most 64 x 64 texels, spread evenly, seen along the normal, in light from all round.
fn mean_queries([columns, rows]: [u32; 2]) -> Vec<Query> {
    let steps = |count: u32| {
        let most = count.min(64);
        (0..most).map(move |step| (u64::from(step) * u64::from(count) / u64::from(most)) as i32)
    };
    let lights = [0.0, 60.0, 120.0, 180.0, 240.0, 300.0]
        .map(|phi| Angles::from_degrees(45.0, phi, 0.0, 0.0));
    let texels = steps(rows).flat_map(|y| steps(columns).map(move |x| (x, y)));
    texels.flat_map(|(x, y)| lights.map(|angles| Query { x, y, angles })).collect()
}

fn mean_colour(values: Vec<Vec3>) -> String {
    let mean = values.iter().sum::<Vec3>() / values.len() as f32;
    line(
        "mean colour",
        format_args!(
            "{:.1} {:.1} {:.1} (seen along the normal, lit from 45 degrees all round)",
            mean.x, mean.y, mean.z
        ),
    )
}

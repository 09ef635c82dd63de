//! `farlight bake`: light for the files of a game, or at given points.

mod parse;
mod points;
mod scene;
mod show;
mod summary;

use std::path::{Path, PathBuf};

use clap::{ArgGroup, ValueEnum};
use farlight_baker::{BakeOptions, Effort, Emission, Probes, Quality, Texels};
use glam::Vec3;

use crate::error::CliError;

/// Bake the light of a glTF scene for Bevy, or compute it at given points
///
/// With --out: lightmaps and probes. The folder gets the scene with second UV sets (NAME.glb), lightmap pages
/// (KTX2 for Bevy, OpenEXR to look at), an irradiance volume, and a manifest (NAME.baked.ron) that names
/// them; in a game, the component BakedLighting loads it. What did not change since the last bake
/// is not baked again; a bake that is stopped (Ctrl-C) writes what it has, and the next one goes on from
/// there. Point and spot lights end at their range (20 m where the file gives none), as in Bevy.
///
/// With --receivers and --result: numbers. The path tracer's irradiance, probes and visibility at
/// points that you give, with standard errors.
///
/// Light paths go on until they end, without a limit on reflections unless you set one; surfaces are
/// diffuse and reflect on both sides. Results are the same for the same seed on any number of
/// threads. Direct light is what arrives straight from point, spot and directional lights, and from the
/// sky. Everything else is indirect, light from emissive surfaces included.
#[derive(clap::Args)]
#[command(after_long_help = HELP, group = ArgGroup::new("what").required(true).args(["out", "receivers"]))]
pub(crate) struct Args {
    /// The scene: a .glb or .gltf file, with KHR_lights_punctual lights in cd and lx
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// Bake lightmaps and probes into this folder; it is made if it is missing
    #[arg(long, value_name = "DIR", help_heading = BAKE)]
    out: Option<PathBuf>,
    /// Lightmap texels a metre. Default: 16, fewer if they need more than 4 pages of 1024 x 1024
    #[arg(long, value_name = "TEXELS_PER_METRE", help_heading = BAKE, conflicts_with_all = ["receivers", "size"])]
    resolution: Option<f32>,
    /// One lightmap page of N x N texels (a power of two from 64 to 4096), as fine as fits
    #[arg(long, value_name = "N", help_heading = BAKE, conflicts_with = "receivers")]
    size: Option<u32>,
    /// How well: draft, medium or high (64, 256 or 1024 rays a texel) [default: medium]
    #[arg(long, value_name = "Q", help_heading = BAKE, conflicts_with_all = ["receivers", "samples", "time"])]
    quality: Option<Q>,
    /// Bake as well as possible in so many seconds, reading and writing included
    #[arg(long, value_name = "SECONDS", help_heading = BAKE, conflicts_with_all = ["receivers", "samples"], value_parser = parse::seconds)]
    time: Option<f64>,
    /// Most reflections of light; 0 is no limit
    #[arg(long, value_name = "N", help_heading = BAKE, conflicts_with = "receivers", default_value_t = 0)]
    bounces: u32,
    /// Added lights and scenarios, a BakeLights(...) in RON (see below). `farlight check` checks it
    #[arg(long, value_name = "EXTRA.ron", help_heading = BAKE, conflicts_with = "receivers")]
    lights: Option<PathBuf>,
    /// Bake only this scenario of EXTRA.ron; may be repeated. The others stay if they are up to date
    #[arg(long, value_name = "NAME", help_heading = BAKE, requires = "lights")]
    scenario: Vec<String>,
    /// What the numbers of emissive materials mean. A number: EV100 of the camera exposure they were chosen for
    /// (Bevy shows them as bright as their colour at any exposure), they emit 1.2 * 2^EV100 times
    /// as many cd/m2; this should fit GiSettings::exposure_ref. nits: they are cd/m2, as
    /// KHR_materials_emissive_strength has them
    #[arg(long, value_name = "EV100|nits", help_heading = BAKE, conflicts_with = "receivers", default_value = "9.7", value_parser = parse::emission)]
    emissive_exposure: Emission,
    /// Distance of probes in metres. Default: 0.5, more if they would be more than 2,000
    #[arg(long, value_name = "METRES", help_heading = BAKE, conflicts_with_all = ["receivers", "no_probes"])]
    probe_spacing: Option<f32>,
    /// No probes
    #[arg(long, help_heading = BAKE, conflicts_with = "receivers")]
    no_probes: bool,
    /// Don't filter noise
    #[arg(long, help_heading = BAKE, conflicts_with = "receivers")]
    no_denoise: bool,
    /// No OpenEXR files beside the KTX2 files
    #[arg(long, help_heading = BAKE, conflicts_with = "receivers")]
    no_exr: bool,
    /// Bake everything anew, whatever earlier bakes left
    #[arg(long, help_heading = BAKE, conflicts_with = "receivers")]
    force: bool,
    /// Go on watching the files, and bake again when they change, until Ctrl-C
    #[arg(long, help_heading = BAKE, conflicts_with = "receivers")]
    watch: bool,
    /// For tests: how often a bake saves what it has
    #[arg(long, value_name = "SECONDS", hide = true, conflicts_with = "receivers", value_parser = parse::seconds)]
    save_every: Option<f64>,
    /// What to compute at which points, as JSON (see below)
    #[arg(long, value_name = "IN.json", help_heading = POINTS, requires = "result", conflicts_with = "out")]
    receivers: Option<PathBuf>,
    /// Where the answers go, as JSON in the same order (see below); written whole or not at all
    #[arg(long, value_name = "OUT.json", help_heading = POINTS, requires = "receivers", conflicts_with = "out")]
    result: Option<PathBuf>,
    /// Let point and spot lights end at their range (20 m where the file gives none), as --out does; otherwise
    /// they fall with the square of the distance alone
    #[arg(long, help_heading = POINTS, conflicts_with = "out")]
    range_window: bool,
    /// With --out: rays a texel. With --receivers: paths a receiver and probe, rounded up to a multiple of
    /// 32 [default: 4096]. Four times as many halve the noise (powers of two do better)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 30))]
    samples: Option<u32>,
    /// Seed of all random numbers
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Radiance of the sky in cd/m2, the same from everywhere; black if not given
    #[arg(long, value_name = "R,G,B", value_parser = parse::rgb)]
    sky: Option<Vec3>,
    /// Metres a unit of the file: 0.001 for files in millimetres. Everything else is in metres
    #[arg(long, value_name = "S", default_value_t = 1.0, value_parser = parse::scale)]
    scale: f32,
}

const BAKE: &str = "Lightmaps and probes for a game";
const POINTS: &str = "Numbers at points";

const HELP: &str = "\
Example:
  farlight bake room.glb --out assets/room --lights room.lights.ron --quality draft --watch
      lights the room anew whenever it is exported
  farlight bake room.glb --out assets/room --lights room.lights.ron --quality high
      the last bake

EXTRA.ron (every part may be left out; cd, lx, metres, degrees; colours are linear RGB):
  BakeLights(
      add: [
          (name: \"lamp\", kind: Point, position: (0, 2.2, 0), intensity: (80, 70, 55), radius: 0.05),
          (name: \"desk\", kind: Spot(inner: 20, outer: 35), position: (1, 1.2, 0),
              direction: (0, -1, 0), intensity: (40, 36, 30), range: 5, direct: Realtime),
          (name: \"sun\", kind: Directional, direction: (0.3, -0.7, 1), angle: 0.27,
              intensity: (20000, 19000, 17000)),
      ],
      realtime: [\"Torch\"],            // lights of the file whose direct light is not baked
      radius: {\"Ceiling lamp\": 0.1},  // soft shadows of lights of the file
      scenarios: [
          (name: \"noon\", lights: [\"sun\"], sky: Constant((4000, 5000, 7000)), emission: {\"Shade\": 0}),
          (name: \"evening\", lights: [\"lamp\"], sky: Image(file: \"dusk.hdr\", scale: 10, rotation: 90)),
      ],
  )
  lights     names of added lights, and of nodes of the file; default: all of them shine
  sky        default: that of --sky
  emission   factors for the emission of materials, by name

IN.json (every part may be left out; light = index in the order of the light nodes in the file):
  {\"surface\": [{\"position\": [x, y, z], \"normal\": [x, y, z]}],
   \"probes\": [[x, y, z]],
   \"visibility\": [{\"point\": [x, y, z], \"light\": 0}]}

OUT.json:
  {\"surface\": [{\"direct\": [r, g, b], \"indirect\": [r, g, b], \"indirect_se\": [r, g, b],
                \"indirect_one_bounce\": [r, g, b], \"indirect_one_bounce_se\": [r, g, b]}],
   \"probes\": [{\"sh\": [[r, g, b] x 9], \"sh_se\": [[r, g, b] x 9]}],
   \"visibility\": [0 or 1]}

  direct, indirect     irradiance on the side of the normal (W/m2, or lx)
  indirect_one_bounce  the part of it that was reflected once at most
  sh                   incident indirect radiance in real orthonormal spherical harmonics, order
                       (0,0) (1,-1) (1,0) (1,1) (2,-2) .. (2,2), polar axis z, no Condon-Shortley
                       phase, not convolved with the cosine
  *_se                 standard error of the mean (one sigma)
  visibility           1 where nothing lies between the point and the light

  Emission is emissiveFactor times KHR_materials_emissive_strength, 1:1 as radiance.";

/// Names of efforts.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Q {
    Draft,
    Medium,
    High,
}

/// The files of the form with points.
struct Points<'a> {
    receivers: &'a Path,
    result: &'a Path,
}

/// Runs the subcommand.
pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    match (&args.out, &args.receivers, &args.result) {
        (Some(out), ..) => scene::run(args, args.options(out)),
        (None, Some(receivers), Some(result)) => points::run(args, &Points { receivers, result }),
        // The parser asks for one or the other.
        _ => Err(CliError::new("say --out DIR, or --receivers IN.json --result OUT.json")),
    }
}

impl Args {
    fn options(&self, out: &Path) -> BakeOptions {
        let quality = match self.quality {
            Some(Q::Draft) => Quality::Draft,
            Some(Q::High) => Quality::High,
            Some(Q::Medium) | None => Quality::Medium,
        };
        let mut options = BakeOptions::new(&self.scene, out);
        options.lights.clone_from(&self.lights);
        options.texels = match (self.size, self.resolution) {
            (Some(size), _) => Texels::Page(size),
            (None, Some(density)) => Texels::PerMetre(density),
            (None, None) => Texels::Standard,
        };
        options.effort = match (self.samples, self.time) {
            (Some(rays), _) => Effort::Rays(rays),
            (None, Some(seconds)) => Effort::Time(parse::duration(seconds)),
            (None, None) => Effort::Rays(quality.rays()),
        };
        options.bounces = self.bounces;
        options.sky = self.sky.unwrap_or_default();
        options.scale = self.scale;
        options.emission = self.emissive_exposure;
        options.seed = self.seed;
        options.exr = !self.no_exr;
        options.denoise = !self.no_denoise;
        options.probes = match (self.no_probes, self.probe_spacing) {
            (true, _) => Probes::None,
            (false, Some(metres)) => Probes::Spacing(metres),
            (false, None) => Probes::Standard,
        };
        options.scenarios.clone_from(&self.scenario);
        options.force = self.force;
        if let Some(seconds) = self.save_every {
            options.save_every = parse::duration(seconds);
        }
        options
    }
}

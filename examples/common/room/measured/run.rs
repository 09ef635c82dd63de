//! `--headless`: measures live, takes pictures, then computes references and writes the report.

use std::{
    path::Path,
    time::{Duration, Instant},
};

use bevy::{math::Vec3, prelude::*};
use farlight::{
    gi::{BackendFactory, GiUpdate},
    prelude::*,
};
use farlight_gi_solver::{
    atlas::{PageId, TexelRect},
    estimate::GatherSettings,
    session::{LightingUpdate, Quality, Tile},
};

use super::{
    args::Args,
    assets, build,
    compare::compare,
    headless::{Headless, Picture},
    live::{Live, Moment},
    measure::{Plan, measure},
    network::{Network, Traffic, Watch, watch_still},
    record::Log,
    reference::{TexelCentre, converge, converge_grids, dilate, texel_centres},
    report::{Percentiles, Report},
    scene,
};

/// Frames are made at this rate, so that a renderer on the CPU leaves some of it to the solver.
const FRAMES_PER_SECOND: f32 = 20.0;
/// How long the first light may take.
const PATIENCE: Duration = Duration::from_secs(120);
/// How long a server may be out of reach before the first light.
const UNREACHABLE: Duration = Duration::from_secs(20);
/// How long light at rest may take to converge, and for how long the link is watched afterwards.
const CONVERGING: Duration = Duration::from_secs(180);
const STILL: Duration = Duration::from_secs(10);
/// Time for the lighting to come to rest before the pictures are taken.
const REST: Duration = Duration::from_secs(3);
/// Rings of texels around charts that filtering may touch.
const DILATION: usize = 2;

/// Does it all.
pub fn run(
    args: &Args,
    light: BackendFactory,
    out: &Path,
    frames: Option<u32>,
) -> Result<(), String> {
    let pace = Duration::from_secs_f32(1.0 / FRAMES_PER_SECOND);
    let mut live = start(args, light, pace)?;
    let (watch, mut traffic) = (Watch::start(&mut live), Traffic::default());
    let first_light = first_light(&mut live)?;
    watch.end(&mut live, &mut traffic);
    live.run(REST.min(pace * frames.unwrap_or(u32::MAX)))?;
    live.frame_ms.clear();
    live.status_mut().timings.clear();

    let plan = Plan::new(frames, pace);
    let seen = measure(&mut live, &plan)?;
    let mut report = Report {
        adapter: live.headless.adapter(),
        processors: std::thread::available_parallelism().map_or(1, usize::from),
        picture_px: args.size.into(),
        lightmap_edge_texels: args.lightmap,
        lightmap_pages: live.log.lock().pages.len(),
        seed: args.seed,
        reference_paths: args.samples,
        light_speed_m_per_s: scene::LAMP_SPEED,
        frames: live.frame_ms.len(),
        paced_frames_per_s: FRAMES_PER_SECOND,
        frame_ms: Percentiles::of(&live.frame_ms),
        first_light_ms: first_light.as_secs_f32() * 1e3,
        after_stop_s: plan.after_stop.as_secs_f32(),
        watched_s: plan.watch.as_secs_f32(),
        system_cpu_ms: Percentiles::of(&live.collected.frame_cpu),
        system_wall_ms: Percentiles::of(&live.collected.frame_wall),
        stages_ms: live.collected.stages().into(),
        ..Report::default()
    };

    let shown = pictures(&mut live, out, REST.min(pace * frames.unwrap_or(u32::MAX)))?;
    let still = match frames {
        None => watch_still(&mut live, CONVERGING, STILL)?,
        Some(_) => None,
    };
    report.network = Network::new(&mut live, traffic, seen.traffic, still);
    let centres = {
        let state = live.log.lock();
        let placements: Vec<_> = state.placements.values().copied().collect();
        texel_centres(&shown.scene, &placements)
    };
    if centres.is_empty() {
        return Err("no texel of the lightmap lies on a surface".into());
    }
    report.lightmap_lit_texels = centres.len();
    compare(&seen, &shown, &centres, args, &mut report);
    reference_picture(&mut live, &shown, &centres, args, out)?;

    report.save(&out.join("report.json"))?;
    println!("{}", report.table());
    println!("pictures and report.json are in {}", out.display());
    Ok(())
}

/// The app, with a recorder between plugin and backend.
pub fn start(args: &Args, light: BackendFactory, pace: Duration) -> Result<Live, String> {
    let log = Log::default();
    let headless = Headless::new(args.size.into(), &assets(), |app| {
        let (log, edge) = (log.clone(), args.lightmap);
        build(app, args, move |settings| Box::new(log.record(light(settings), edge)));
    })?;
    let mut live = Live::new(headless, log, pace);
    live.frame()?;
    // Only the pictures are smooth: a renderer on the CPU leaves some of it to the solver.
    live.smooth_edges(false)?;
    Ok(live)
}

/// Waits until the first light is shown; the time since the first instance was submitted, to the end
/// of a frame that shows it (at most one frame late, since writes are told in the next).
pub fn first_light(live: &mut Live) -> Result<Duration, String> {
    eprintln!("loading, on {}", live.headless.adapter());
    let start = Instant::now();
    let mut reachable = Instant::now();
    loop {
        live.frame()?;
        let state = live.log.lock();
        let (lit, submitted) = (!state.pages.is_empty(), state.first_submit);
        drop(state);
        if let (true, Some(submitted)) = (lit && !live.writes.is_empty(), submitted) {
            // Writes are told a frame later: the frame that showed the light ended before this one.
            return Ok(submitted.elapsed());
        }
        match &live.status_mut().state {
            GiState::Failed { reason } => return Err(format!("the lighting failed: {reason}")),
            GiState::Disconnected { reason } if reachable.elapsed() > UNREACHABLE => {
                return Err(format!("no server for {UNREACHABLE:?}: {reason}"));
            }
            GiState::Disconnected { .. } => {}
            _ => reachable = Instant::now(),
        }
        if start.elapsed() > PATIENCE {
            let status = live.status_mut();
            return Err(format!(
                "no lighting arrived within {PATIENCE:?}: {:?}, {} receivers, left out: {:?}",
                status.state, status.receivers, status.left_out
            ));
        }
    }
}

/// Lets the lighting come to rest and takes the pictures; what they show.
fn pictures(live: &mut Live, out: &Path, rest: Duration) -> Result<Moment, String> {
    eprintln!("pictures");
    live.smooth_edges(true)?;
    live.lamp(|mut lamp| {
        lamp.paused = true;
        lamp.distance = scene::PICTURE_LAMP * lamp.path.length();
    });
    live.ball(|mut ball| {
        ball.paused = true;
        ball.distance = scene::PICTURE_BALL * ball.path.length();
    });
    live.run(rest)?;
    live.remember();
    live.flush()?;
    let shown = live.instants.pop().ok_or("what the pictures show was lost")?;
    for (view, name) in [
        (GiView::Full, "indirect.png"),
        (GiView::DirectOnly, "direct-only.png"),
        (GiView::LightmapOnly, "lightmap.png"),
    ] {
        live.headless.app.insert_resource(view);
        live.flush()?;
        save(&live.headless.capture()?, &out.join(name))?;
    }
    live.headless.app.insert_resource(GiView::Full);
    Ok(shown)
}

/// Puts the converged answer into the lightmap and the probes and takes the last picture.
fn reference_picture(
    live: &mut Live,
    shown: &Moment,
    centres: &[TexelCentre],
    args: &Args,
    out: &Path,
) -> Result<(), String> {
    eprint!("the reference of the picture ");
    let settings = GatherSettings { paths: args.samples, seed: args.seed.wrapping_add(1) };
    let light = converge(&shown.scene, centres, &settings);
    let edge = args.lightmap;
    let size = (edge * edge) as usize;
    let pages = live.log.lock().pages.len();
    let mut texels = vec![vec![None; size]; pages];
    for (centre, light) in centres.iter().zip(light.texels) {
        let [page, x, y] = centre.texel;
        if let Some(texel) = texels.get_mut(page as usize) {
            texel[(y * edge + x) as usize] = Some(light);
        }
    }
    let tiles = texels
        .into_iter()
        .enumerate()
        .map(|(page, mut texels)| {
            dilate(&mut texels, edge as usize, DILATION);
            Tile {
                page: PageId(page as u32),
                rect: TexelRect { x: 0, y: 0, width: edge, height: edge },
                texels: texels.into_iter().map(Option::unwrap_or_default).collect::<Vec<Vec3>>(),
            }
        })
        .collect();
    let grids = live.log.lock().grids.clone();
    let grids = converge_grids(&shown.scene, &grids, &settings);
    eprintln!();
    let update = GiUpdate::encode(&LightingUpdate {
        snapshot: live.log.lock().submitted,
        placements: Vec::new(),
        refused: Vec::new(),
        tiles,
        grids,
        quality: Quality::default(),
    });
    {
        let mut state = live.log.lock();
        state.muted = true;
        state.injected = Some(update);
    }
    live.writes.clear();
    let start = Instant::now();
    while live.writes.is_empty() {
        live.frame()?;
        if start.elapsed() > PATIENCE {
            return Err("the reference was never written into the lightmap".into());
        }
    }
    save(&live.headless.capture()?, &out.join("reference.png"))
}

fn save(picture: &Picture, path: &Path) -> Result<(), String> {
    picture.save(path)?;
    match picture.problem() {
        Some(problem) => Err(format!("{} is {problem}", path.display())),
        None => Ok(()),
    }
}

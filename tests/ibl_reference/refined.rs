//! Refined pictures against the sum over the whole environment.

use std::time::Instant;

use farlight::ibl::{
    EnvironmentMap, EnvironmentState, EnvironmentStatus, ProgressiveCamera, ProgressiveLighting,
    Refinement, environment_maps::Environment,
};

use crate::{
    integral::{GLOSSY, ROTATION, environment},
    lights::DIFFUSE,
    support::{
        headless::Picture,
        integral::{Grain, environment_reference},
    },
    *,
};

/// Of both directions every third pixel is compared.
const STEP: u32 = 3;

/// All of 4096 lights have shone once, eight at a time: a diffuse ball is within 1 % of the sum over
/// every texel, a glossy one within 3 %.
fn check(name: &str, diffuse: Surface) {
    let map = environment(name);
    let mut stage = Stage::new(&[diffuse, GLOSSY], 96);
    let handle = stage
        .world()
        .resource_mut::<Assets<EnvironmentMap>>()
        .add(EnvironmentMap(Arc::new(map.clone())));
    stage.world().insert_resource(ProgressiveLighting {
        environment: Some(handle),
        rotation: ROTATION,
        lights: 4096,
        per_frame: 8,
        shadows: false,
        seed: 5,
        ..default()
    });
    stage.refine();
    let pictures = stage.pictures();
    let kinds = [("diffuse", 0.01), ("glossy", 0.03)];
    for ((kind, limit), (stand, picture)) in
        kinds.into_iter().zip(stage.stands.iter().zip(pictures))
    {
        let (deviation, drawing) = compare(&stage.ball, &stand.surface, &map, &picture);
        let path = support::scratch(&format!("ibl_reference/{name}-{kind}.png"));
        drawing.save(path.clone()).unwrap();
        println!("{name}, {kind} ({}): {deviation}", stand.surface);
        assert!(
            deviation.absolute < limit,
            "{name}, {kind}: {deviation} ({}); ours, reference, ten times the difference: {}",
            stage.headless.adapter(),
            path.display()
        );
    }
}

impl Stage {
    /// Draws until all pictures are refined.
    fn refine(&mut self) {
        let cameras: Vec<_> = self.stands.iter().map(|stand| stand.camera).collect();
        for &camera in &cameras {
            self.world().entity_mut(camera).insert(ProgressiveCamera::default());
        }
        let start = Instant::now();
        let mut frames = 0;
        let refined = |world: &mut World| {
            frames += 1;
            let ready = world.resource::<EnvironmentStatus>().state == EnvironmentState::Ready;
            let is_refined = |&camera| world.get(camera).is_some_and(Refinement::is_refined);
            ready && cameras.iter().all(is_refined)
        };
        self.headless
            .update_until("refined pictures", Duration::from_secs(1200), refined)
            .unwrap_or_else(|problem| panic!("{problem}"));
        let EnvironmentStatus { lights, per_frame, .. } = self.world().resource();
        assert_eq!((*lights, *per_frame), (4096, 8));
        println!("{frames} frames in {:.1} s", start.elapsed().as_secs_f64());
        assert!(frames >= 512, "not all lights can have shone in {frames} frames");
    }
}

/// The deviation, and a drawing of ours, the reference and ten times the difference round grey.
fn compare(
    ball: &Ball,
    surface: &Surface,
    map: &Environment,
    picture: &[DVec3],
) -> (Deviation, Picture) {
    let pixels = ball.pixels(STEP);
    // A pixel is the mean over its area: of two by two points of it.
    let points: Vec<_> = pixels
        .iter()
        .flat_map(|&(_, centre)| {
            [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)]
                .map(|(x, y)| centre + 0.25 * DVec2::new(x, y))
        })
        .filter_map(|place| ball.seen_at(place))
        .collect();
    assert_eq!(points.len(), 4 * pixels.len(), "pixels at the outline");
    let sums = environment_reference(surface, map, ROTATION, Grain::TEXEL, &points);
    let reference = sums.chunks_exact(4).map(|part| part.iter().sum::<DVec3>() / 4.0);
    let pairs: Vec<_> = pixels.iter().map(|&(i, _)| picture[i]).zip(reference).collect();
    (Deviation::over(&pairs), drawing(&pixels, &pairs))
}

fn drawing(pixels: &[(usize, DVec2)], pairs: &[(DVec3, DVec3)]) -> Picture {
    /// Edge of the square that stands for a pixel.
    const ZOOM: u32 = 10;
    let edge = SIZE.div_ceil(STEP) * ZOOM;
    let mut drawn = vec![[0; 3]; (3 * edge * edge) as usize];
    let mean =
        pairs.iter().map(|pair| pair.1.element_sum()).sum::<f64>() / (3 * pairs.len()) as f64;
    let encode = |v: DVec3| {
        Srgba::from(LinearRgba::from_vec3((0.35 / mean * v).as_vec3())).to_u8_array_no_alpha()
    };
    for (&(i, _), &(ours, reference)) in pixels.iter().zip(pairs) {
        let grey = DVec3::splat(0.6 * mean);
        let three = [ours, reference, grey + 10.0 * (ours - reference)];
        let (x, y) = (i as u32 % SIZE / STEP * ZOOM, i as u32 / SIZE / STEP * ZOOM);
        for (part, value) in (0..).zip(three) {
            for at in 0..ZOOM * ZOOM {
                let x = part * edge + x + at % ZOOM;
                drawn[((y + at / ZOOM) * 3 * edge + x) as usize] = encode(value);
            }
        }
    }
    Picture { width: 3 * edge, height: edge, pixels: drawn }
}

#[test]
fn sky() {
    check("sky", DIFFUSE);
}

/// A measured material gets the same light.
#[test]
fn interior() {
    check("interior", Surface::Lambert { albedo: DVec3::splat(0.8) });
}

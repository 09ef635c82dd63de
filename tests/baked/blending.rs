//! Scenarios blended at run time.

use bevy::{light::IrradianceVolume, pbr::Lightmap, prelude::*};
use farlight::{baked::Blending, core::LightingChanged, prelude::*};

use crate::{
    folder::{Folder, PAGE, volume},
    stage::{SIZE, Stage},
    support::linear,
};

/// A texel of each scenario that no two neighbours share.
fn texel(scenario: usize, x: u32, y: u32) -> Vec3 {
    let seed = (x + y * PAGE) as f32 + 0.5;
    let wave = |phase: f32| 0.55 + 0.45 * (seed * (0.37 + 0.21 * scenario as f32) + phase).sin();
    Vec3::new(wave(0.0), 3.0 * wave(1.0), 200.0 * wave(2.0))
}

/// Two scenarios with pages and volumes.
fn day(test: &str) -> Folder {
    let names = ["noon", "evening"];
    let (folder, mut manifest) = Folder::square(test, &names.map(|name| (name, Vec3::ZERO)));
    manifest.volumes = vec![volume(Vec3::new(0.0, 0.0, 20.0), 8.0)];
    for (index, name) in names.into_iter().enumerate() {
        folder.page(&format!("{name}.0.ktx2"), |x, y| texel(index, x, y));
        let file = format!("{name}.volume0.ktx2");
        folder.volume(&file, [Vec3::new(1.0, 2.0, 4.0) * (1.0 + 2.0 * index as f32); 6]);
        manifest.scenarios[index].volumes = vec![file];
    }
    folder.manifest(&manifest);
    folder
}

fn check(stage: &mut Stage) {
    let root = stage.lit();
    let (page, voxels) = {
        let world = stage.world();
        let page = world.query::<&Lightmap>().single(world).unwrap().image.clone();
        let voxels = world.query::<&IrradianceVolume>().single(world).unwrap().voxels.clone();
        (page, voxels)
    };
    // What was read of the shared exponents, so that only the blending is compared.
    let stored = |scenario: usize, x: u32, y: u32| {
        use farlight::baked::format::rgb9e5;
        rgb9e5::decode(rgb9e5::encode(texel(scenario, x, y)))
    };
    for (noon, evening) in [(1.0, 0.0), (0.5, 0.5), (0.0, 1.0), (2.0, 0.25), (0.0, 0.0)] {
        stage.lighting(root).scenarios =
            [("noon", noon), ("evening", evening)].into_iter().collect();
        for _ in 0..3 {
            stage.update();
        }
        let found = linear::read(&mut stage.headless, &[&page]).remove(0);
        for (index, found) in found.iter().enumerate() {
            let (x, y) = (index as u32 % PAGE, index as u32 / PAGE);
            let expected = noon * stored(0, x, y) + evening * stored(1, x, y);
            // One step of a half float: 11 bits.
            let error = (*found - expected).abs() / expected.max(Vec3::splat(1e-4));
            assert!(error.max_element() <= 1.0 / 1024.0, "{x}, {y}: {found} and not {expected}");
        }
        let probe = stage.first_texel(&voxels);
        let expected = Vec3::new(1.0, 2.0, 4.0) * (noon + 3.0 * evening);
        assert!(probe.abs_diff_eq(expected, 0.01), "{probe} and not {expected}");
        let status = stage.status(root);
        assert_eq!(status.scenarios, [("noon".to_owned(), noon), ("evening".to_owned(), evening)]);
    }
}

#[test]
fn the_gpu_blends_as_its_twin() {
    let folder = day("gpu");
    let mut stage = Stage::new(&folder);
    assert_eq!(stage.world().resource::<BakedStatus>().blending, Blending::Gpu);
    check(&mut stage);
}

#[test]
fn the_cpu_blends_where_the_gpu_cannot() {
    let folder = day("cpu");
    let mut stage = Stage::with(&folder, BakedPlugin { blend_on_cpu: true });
    assert_eq!(stage.world().resource::<BakedStatus>().blending, Blending::Cpu);
    check(&mut stage);
}

fn changes(world: &World) -> usize {
    let messages = world.resource::<Messages<LightingChanged>>();
    messages.get_cursor().read(messages).count()
}

/// Weights that stand still cost nothing; each change blends each texture once.
#[test]
fn only_changes_cost() {
    let folder = day("changes");
    let mut stage = Stage::new(&folder);
    let root = stage.lit();
    for _ in 0..4 {
        stage.update();
    }
    let blends = |stage: &mut Stage| stage.world().resource::<BakedStatus>().blends;
    let before = blends(&mut stage);
    assert_eq!(before, 2, "a page and a volume");
    for _ in 0..10 {
        stage.update();
    }
    assert_eq!(blends(&mut stage), before);
    assert_eq!(changes(stage.world()), 0, "nothing more is told");
    let is_changed = |stage: &mut Stage| {
        let world = stage.world();
        world.query_filtered::<(), Changed<Lightmap>>().iter(world).count()
    };
    assert_eq!(is_changed(&mut stage), 0, "no component is touched");
    for step in 1..=5_u8 {
        stage.lighting(root).scenarios.blend("noon", "evening", f32::from(step) / 5.0);
        stage.update();
        assert!(changes(stage.world()) > 0, "step {step}");
    }
    stage.update();
    stage.update();
    assert_eq!(blends(&mut stage), before + 10);
    // The same weights, written again.
    stage.lighting(root).scenarios.blend("noon", "evening", 1.0);
    for _ in 0..4 {
        stage.update();
    }
    assert_eq!(blends(&mut stage), before + 10);
}

/// A single scenario is shown as it is, and may be dimmed all the same.
#[test]
fn a_single_scenario_can_be_dimmed() {
    for dimmable in [false, true] {
        let (folder, _) = Folder::square("dimmed", &[("lamp", Vec3::splat(0.4))]);
        let mut stage = Stage::new(&folder);
        let root = stage.spawn();
        stage.update();
        stage.lighting(root).dimmable = dimmable;
        stage.until_lit(root);
        let picture = stage.picture();
        stage.assert_all(&picture, Vec3::splat(0.2));
        let own = stage.world().resource::<BakedStatus>().blends > 0;
        assert_eq!(own, dimmable);
        stage.lighting(root).scenarios.set("lamp", 0.25);
        for _ in 0..4 {
            stage.update();
        }
        stage.until_lit(root);
        let picture = stage.picture();
        stage.assert_all(&picture, Vec3::splat(0.05));
        assert_eq!(stage.status(root).scenarios, [("lamp".to_owned(), 0.25)]);
        assert_eq!(picture.width, SIZE);
    }
}

#[test]
fn unknown_scenarios_are_said() {
    let folder = day("unknown");
    let mut stage = Stage::new(&folder);
    let root = stage.lit();
    stage.lighting(root).scenarios.show("midnight");
    for _ in 0..4 {
        stage.update();
    }
    let status = stage.status(root);
    assert_eq!(status.problems.len(), 1);
    assert!(status.problems[0].contains("midnight") && status.problems[0].contains("evening"));
}

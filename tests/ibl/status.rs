//! What becomes of maps is said, and the light before shines on meanwhile.

use std::{path::PathBuf, sync::Arc, time::Duration};

use bevy::prelude::*;
use farlight::{
    ibl::{
        EnvironmentCache, EnvironmentState,
        environment_maps::{Environment, LightCache},
    },
    prelude::*,
};

use crate::{stage::Stage, support};

fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let path = support::scratch(&format!("ibl/{name}"));
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(&path, bytes).unwrap();
    path
}

/// A KTX2 cube of 4 x 4 texels in blocks (`VK_FORMAT_BC7_UNORM_BLOCK`).
fn blocks() -> Vec<u8> {
    let mut bytes = b"\xABKTX 20\xBB\r\n\x1A\n".to_vec();
    let descriptor = 80 + 24;
    for word in [145, 1, 4, 4, 0, 0, 6, 1, 0, descriptor, 4, 0, 0] {
        bytes.extend(u32::to_le_bytes(word));
    }
    let data = u64::from(descriptor) + 8;
    for long in [0, 0, data, 96, 96] {
        bytes.extend(u64::to_le_bytes(long));
    }
    bytes.extend(4_u32.to_le_bytes());
    bytes.resize(data as usize + 96, 0);
    bytes
}

impl Stage {
    fn environment(&mut self, environment: Option<Handle<EnvironmentMap>>) {
        self.world().resource_mut::<ProgressiveLighting>().environment = environment;
    }

    /// The status once the map is there or can't be.
    fn settled(&mut self) -> EnvironmentStatus {
        self.update();
        let settled = |world: &mut World| {
            let state = &world.resource::<EnvironmentStatus>().state;
            !matches!(state, EnvironmentState::Loading | EnvironmentState::Choosing)
        };
        self.headless
            .update_until("the map", Duration::from_secs(60), settled)
            .unwrap_or_else(|problem| panic!("{problem}"));
        self.world().resource::<EnvironmentStatus>().clone()
    }
}

#[test]
fn maps_that_cannot_be_used_say_so_and_the_light_before_shines_on() {
    let mut stage = Stage::new();
    stage.ball();
    let camera = stage.camera(Vec3::new(0.0, 1.5, 3.0), Vec3::new(0.0, 0.3, 0.0));
    assert_eq!(stage.settled().state, EnvironmentState::None);

    let white = Environment::from_equirect(16, 8, vec![Vec3::ONE; 128]).unwrap();
    stage.light(white, ProgressiveLighting { lights: 20, brightness: 0.3, ..default() });
    let white = stage.world().resource::<ProgressiveLighting>().environment.clone();
    let status = stage.settled();
    assert_eq!((status.state, status.lights), (EnvironmentState::Ready, 20));
    stage.refine(camera);
    let lit = stage.floats();

    let bad = [
        PathBuf::from("environments/not-there.hdr"),
        file("broken.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\nshort"),
        file("blocks.ktx2", &blocks()),
    ];
    for path in bad {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let map = stage.world().resource::<AssetServer>().load(path);
        stage.environment(Some(map));
        stage.update();
        assert_eq!(stage.world().resource::<EnvironmentStatus>().per_frame, 5, "it shines on");
        let status = stage.settled();
        println!("{:?}", status.state);
        match status.state {
            EnvironmentState::Failed(reason) => assert!(reason.contains(&name), "{reason}"),
            other => panic!("{name} is {other:?}"),
        }
        assert_eq!((status.lights, status.per_frame), (20, 5), "{name}: the light before");
    }
    stage.refine(camera);
    let apart = Stage::apart(&lit, &stage.floats());
    assert!(apart < 2e-3, "the light before: {apart}");

    // A black map lights nothing, and is no trouble.
    let black = Environment::from_equirect(16, 8, vec![Vec3::ZERO; 128]).unwrap();
    let black = EnvironmentMap(Arc::new(black));
    let id = stage.world().resource_mut::<Assets<EnvironmentMap>>().add(black);
    stage.environment(Some(id.clone()));
    assert_eq!(stage.settled().state, EnvironmentState::Ready);
    stage.update();
    stage.refine(camera);
    assert!(stage.floats().iter().all(|pixel| *pixel == Vec3::ZERO), "a black map");

    // The same asset with other content.
    let content = stage.world().resource::<Assets<EnvironmentMap>>().get(&white.unwrap()).cloned();
    let mut maps = stage.world().resource_mut::<Assets<EnvironmentMap>>();
    *maps.get_mut(&id).unwrap() = content.unwrap();
    stage.update();
    assert_eq!(stage.settled().state, EnvironmentState::Ready);
    stage.update();
    stage.refine(camera);
    let apart = Stage::apart(&lit, &stage.floats());
    assert!(apart < 2e-3, "other content: {apart}");

    stage.environment(None);
    let status = stage.settled();
    assert_eq!((status.state, status.lights, status.per_frame), (EnvironmentState::None, 0, 0));
}

#[test]
fn chosen_lights_are_kept_on_disk() {
    let folder = support::scratch("ibl/lights");
    if folder.exists() {
        std::fs::remove_dir_all(&folder).unwrap();
    }
    let lit = |seed: u64| {
        let mut stage = Stage::new();
        stage.ball();
        stage.world().insert_resource(EnvironmentCache(Some(LightCache::new(&folder))));
        let map = Environment::from_equirect(8, 4, vec![Vec3::ONE; 32]).unwrap();
        let settings = ProgressiveLighting { lights: 20, seed, ..default() };
        stage.light(map, settings);
        let camera = stage.camera(Vec3::new(0.0, 1.5, 3.0), Vec3::new(0.0, 0.3, 0.0));
        assert_eq!(stage.settled().state, EnvironmentState::Ready);
        stage.refine(camera);
        let files = std::fs::read_dir(&folder).unwrap().count();
        (stage.floats(), files)
    };
    let (first, files) = lit(1);
    assert_eq!(files, 1);
    let (again, files) = lit(1);
    assert_eq!(files, 1);
    // The same lights, added up from another one on.
    let apart = first.iter().zip(&again).map(|(a, b)| (a - b).abs().max_element());
    let apart = apart.fold(0.0, f32::max);
    assert!(apart < 2e-3, "lights of the disk are those that were chosen: {apart}");
    assert_eq!(lit(2).1, 2);
}

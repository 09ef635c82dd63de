//! Lightmaps in rendered pictures.

use std::time::Duration;

use bevy::{pbr::Lightmap, prelude::*};
use farlight::{
    core::LightingChanged,
    gi::{ExtractedScene, solver::atlas::TexelRect},
    prelude::*,
};

use crate::{
    lightmapped_quad,
    mock::Mock,
    settle,
    support::{
        front,
        headless::{Headless, Picture},
    },
};

/// A renderer, its backend, a camera two metres in front of the origin that sees a square of two
/// metres, with exposure 1.
pub(crate) struct Stage {
    pub(crate) headless: Headless,
    pub(crate) mock: Mock,
    pub(crate) camera: Entity,
}

/// A picture's edge in pixels.
pub(crate) const SIZE: u32 = 64;

impl Stage {
    pub(crate) fn new() -> Self {
        let mock = Mock::default();
        let plugin = mock.plugin();
        Self::with_plugin(mock, plugin)
    }

    /// A stage whose lighting is solved.
    pub(crate) fn solved() -> Self {
        Self::with_plugin(Mock::default(), GiPlugin::default())
    }

    fn with_plugin(mock: Mock, plugin: GiPlugin) -> Self {
        let headless = Headless::new(UVec2::splat(SIZE), &crate::support::assets(), |app| {
            app.add_plugins(FarlightPlugins.set(plugin))
                .insert_resource(GlobalAmbientLight::NONE)
                .insert_resource(ClearColor(Color::BLACK));
            app.insert_resource(GiSettings { page_size: 64, ..default() });
        });
        let mut headless = headless.unwrap_or_else(|problem| panic!("{problem}"));
        headless.set_frame_time(Duration::from_millis(16));
        let camera = headless.app.world_mut().spawn(front::camera()).id();
        Self { headless, mock, camera }
    }

    pub(crate) fn world(&mut self) -> &mut World {
        self.headless.app.world_mut()
    }

    pub(crate) fn update(&mut self) {
        self.headless.update().unwrap_or_else(|problem| panic!("{problem}"));
    }

    pub(crate) fn settle(&mut self) {
        let mock = self.mock.clone();
        let frame = || {
            self.update();
            self.world().resource::<GiStatus>().converting
        };
        settle(frame, &mock);
    }

    /// A picture some frames later, when what was sent before is shown.
    pub(crate) fn picture(&mut self) -> Picture {
        for _ in 0..4 {
            self.update();
        }
        self.picture_now()
    }

    /// A picture of the very next frame.
    pub(crate) fn picture_now(&mut self) -> Picture {
        self.headless.capture().unwrap_or_else(|problem| panic!("{problem}"))
    }

    /// A matte grey quad that fills the picture.
    pub(crate) fn quad(&mut self, tagged: bool) -> Entity {
        let mesh = self.world().resource_mut::<Assets<Mesh>>().add(lightmapped_quad(2.0));
        let material = self.matte();
        let quad = self.world().spawn((Mesh3d(mesh), MeshMaterial3d(material))).id();
        if tagged {
            self.world().entity_mut(quad).insert(GiScene);
        }
        quad
    }

    pub(crate) fn matte(&mut self) -> Handle<StandardMaterial> {
        self.world().resource_mut::<Assets<StandardMaterial>>().add(StandardMaterial {
            base_color: Color::linear_rgb(0.5, 0.5, 0.5),
            perceptual_roughness: 1.0,
            reflectance: 0.0,
            ..default()
        })
    }

    /// Asserts a pixel's colour, given as linear light that leaves the surface.
    pub(crate) fn assert_pixel(&self, picture: &Picture, x: u32, y: u32, expected: Vec3) {
        front::assert_pixel(&self.headless, picture, x, y, expected);
    }

    pub(crate) fn assert_all(&self, picture: &Picture, expected: Vec3) {
        for (x, y) in [(5, 5), (SIZE / 2, SIZE / 2), (SIZE - 5, 9), (9, SIZE - 5)] {
            self.assert_pixel(picture, x, y, expected);
        }
    }
}

const RECT: TexelRect = TexelRect { x: 8, y: 16, width: 16, height: 16 };

#[test]
fn texels_appear_in_the_picture_at_their_place_with_their_brightness() {
    let mut stage = Stage::new();
    let quad = stage.quad(true);
    stage.settle();
    let picture = stage.picture();
    stage.assert_all(&picture, Vec3::ZERO);
    // Quarters of the square: red and green above, blue and grey below.
    let color = |x: u32, y: u32| match (x < RECT.width / 2, y < RECT.height / 2) {
        (true, true) => Vec3::new(0.8, 0.0, 0.0),
        (false, true) => Vec3::new(0.0, 0.8, 0.0),
        (true, false) => Vec3::new(0.0, 0.0, 0.8),
        (false, false) => Vec3::splat(0.4),
    };
    stage.mock.place(quad, RECT, color);
    let picture = stage.picture();
    let (low, high) = (SIZE / 4, SIZE * 3 / 4);
    // E / pi times the base colour of one half.
    stage.assert_pixel(&picture, low, low, Vec3::new(0.4, 0.0, 0.0));
    stage.assert_pixel(&picture, high, low, Vec3::new(0.0, 0.4, 0.0));
    stage.assert_pixel(&picture, low, high, Vec3::new(0.0, 0.0, 0.4));
    stage.assert_pixel(&picture, high, high, Vec3::splat(0.2));

    let lightmaps = stage.world().resource::<GiLightmaps>();
    let placement = *lightmaps.placement(quad).unwrap();
    assert_eq!(placement.rect, RECT);
    let texel = lightmaps.texel(placement.page, RECT.x, RECT.y).unwrap();
    assert!((texel.x - 0.8).abs() < 1e-3 && texel.y == 0.0);
}

#[test]
fn updates_are_told_when_they_are_written() {
    let mut stage = Stage::new();
    let quad = stage.quad(true);
    stage.settle();
    stage.mock.place(quad, RECT, |_, _| Vec3::ONE);
    let mut told = Vec::new();
    for _ in 0..6 {
        stage.update();
        let messages = stage.world().resource::<Messages<GiUpdated>>();
        let mut cursor = messages.get_cursor();
        told.extend(cursor.read(messages).map(|message| message.snapshot));
        if !told.is_empty() {
            break;
        }
    }
    assert!(!told.is_empty(), "no GiUpdated within 6 frames");
    let status = stage.world().resource::<GiStatus>();
    assert_eq!((status.updates, status.uploaded_bytes), (1, 16 * 16 * 8));
    assert_eq!(status.shown, told[0]);
}

/// Whoever keeps pictures hears of each frame in which light on surfaces changes, until it is still.
#[test]
fn light_that_changes_is_told_until_it_rests() {
    let mut stage = Stage::new();
    let quad = stage.quad(true);
    let scale = Transform::from_scale(Vec3::splat(8.0));
    let volume = stage.world().spawn((GiProbeVolume { resolution: UVec3::ONE }, scale)).id();
    // A row or two of texels a frame.
    stage.world().resource_mut::<GiSettings>().upload_bytes_per_frame = 4096;
    stage.settle();
    let mut cursor = stage.world().resource::<Messages<LightingChanged>>().get_cursor();
    let mut told = |stage: &mut Stage| {
        stage.update();
        cursor.read(stage.world().resource::<Messages<LightingChanged>>()).count()
    };
    let mut until_quiet = |stage: &mut Stage| {
        let frames = (0..100).take_while(|_| told(stage) > 0).count();
        assert!(frames < 100, "it never rests");
        assert_eq!((0..20).map(|_| told(stage)).sum::<usize>(), 0);
        frames
    };
    until_quiet(&mut stage);
    let written = |stage: &mut Stage| stage.world().resource::<GiStatus>().uploaded_bytes;
    let before = written(&mut stage);
    stage.mock.place(quad, RECT, |_, _| Vec3::splat(0.8));
    let frames = until_quiet(&mut stage);
    assert!(frames >= 2, "the frame that writes and the one after, {frames} in all");
    assert_eq!(written(&mut stage) - before, 16 * 16 * 8);
    let picture = stage.picture();
    stage.assert_all(&picture, Vec3::splat(0.4));

    stage.mock.light_volume(volume, UVec3::ONE, vec![farlight::gi::solver::sh::ShRgb::ZERO]);
    assert!(until_quiet(&mut stage) >= 1);
    for enabled in [false, true] {
        stage.world().resource_mut::<GiControl>().enabled = enabled;
        assert!(until_quiet(&mut stage) >= 1);
    }
    // An update that changes no texel.
    stage.mock.send(&crate::mock::empty());
    assert_eq!(until_quiet(&mut stage), 0);
    // Its lightmap goes, two frames later.
    stage.world().entity_mut(quad).remove::<GiScene>();
    stage.update();
    assert!(until_quiet(&mut stage) >= 1);
}

#[test]
fn switching_off_and_on_is_at_once_and_changes_no_entity() {
    let mut stage = Stage::new();
    let quad = stage.quad(true);
    stage.settle();
    stage.mock.place(quad, RECT, |_, _| Vec3::splat(0.8));
    let picture = stage.picture();
    stage.assert_all(&picture, Vec3::splat(0.4));
    // A budget of one row a frame: switching doesn't wait for it.
    stage.world().resource_mut::<GiSettings>().upload_bytes_per_frame = 4096;
    stage.update();
    for enabled in [false, true, false, true] {
        stage.world().resource_mut::<GiControl>().enabled = enabled;
        let picture = stage.picture_now();
        assert!(stage.world().entity(quad).contains::<Lightmap>());
        stage.assert_all(&picture, if enabled { Vec3::splat(0.4) } else { Vec3::ZERO });
    }
    // What arrives while it is off is there when it is on again.
    stage.world().resource_mut::<GiControl>().enabled = false;
    stage.mock.place(quad, RECT, |_, _| Vec3::splat(0.2));
    let picture = stage.picture();
    stage.assert_all(&picture, Vec3::ZERO);
    stage.world().resource_mut::<GiControl>().enabled = true;
    let picture = stage.picture();
    stage.assert_all(&picture, Vec3::splat(0.1));
}

#[test]
fn lightmaps_survive_everything_that_happens_to_their_meshes() {
    let mut stage = Stage::new();
    stage.world().spawn((
        DirectionalLight { illuminance: 0.0, shadow_maps_enabled: true, ..default() },
        Transform::from_xyz(1.0, 2.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    let quad = stage.quad(true);
    stage.settle();
    // Placed while nobody looks.
    let away = Transform::from_xyz(0.0, 0.0, 2.0).looking_to(Vec3::Z, Vec3::Y);
    let back = Transform::from_xyz(0.0, 0.0, 2.0);
    let camera = stage.camera;
    stage.world().entity_mut(camera).insert(away);
    stage.update();
    stage.mock.place(quad, RECT, |_, _| Vec3::splat(0.8));
    stage.settle();
    stage.world().entity_mut(camera).insert(back);
    let picture = stage.picture();
    stage.assert_all(&picture, Vec3::splat(0.4));
    // It moves to another rectangle.
    let moved = TexelRect { x: 40, y: 40, width: 8, height: 8 };
    stage.mock.place(quad, moved, |_, _| Vec3::splat(0.4));
    stage.settle();
    let picture = stage.picture();
    stage.assert_all(&picture, Vec3::splat(0.2));
    // Hidden, shown again, and placed anew.
    stage.world().entity_mut(quad).insert(Visibility::Hidden);
    stage.settle();
    stage.world().entity_mut(quad).insert(Visibility::Visible);
    stage.settle();
    let picture = stage.picture();
    stage.assert_all(&picture, Vec3::ZERO);
    stage.mock.place(quad, RECT, |_, _| Vec3::splat(0.6));
    let picture = stage.picture();
    stage.assert_all(&picture, Vec3::splat(0.3));
    // The tag goes, the mesh stays.
    stage.world().entity_mut(quad).remove::<GiScene>();
    stage.settle();
    assert!(!stage.world().entity(quad).contains::<Lightmap>());
    let picture = stage.picture();
    stage.assert_all(&picture, Vec3::ZERO);
    // Despawned, and another one at the same place.
    stage.world().entity_mut(quad).despawn();
    stage.settle();
    let quad = stage.quad(true);
    stage.settle();
    stage.mock.place(quad, RECT, |_, _| Vec3::splat(0.2));
    let picture = stage.picture();
    stage.assert_all(&picture, Vec3::splat(0.1));
}

#[test]
fn the_lightmap_view_shows_texels_on_white_and_goes_back() {
    let mut stage = Stage::new();
    let quad = stage.quad(true);
    // Direct light, which the view must not show.
    stage.world().spawn((
        DirectionalLight { illuminance: 1.0, ..default() },
        Transform::from_xyz(0.0, 0.0, 1.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    stage.settle();
    stage.mock.place(quad, RECT, |_, _| Vec3::new(0.5, 0.25, 0.1));
    stage.settle();
    let full = stage.picture();
    *stage.world().resource_mut::<GiView>() = GiView::LightmapOnly;
    let picture = stage.picture();
    stage.assert_all(&picture, Vec3::new(0.5, 0.25, 0.1));
    *stage.world().resource_mut::<GiView>() = GiView::DirectOnly;
    let direct = stage.picture();
    assert!(direct.mean() < full.mean() && direct.mean() > 1.0);
    *stage.world().resource_mut::<GiView>() = GiView::Full;
    let again = stage.picture();
    assert_eq!(full, again);
}

#[test]
fn a_despawned_light_is_gone() {
    // Bevy 0.19 can't despawn lights without a renderer, so this isn't among the other lights.
    let mut stage = Stage::new();
    let lamp = stage.world().spawn(PointLight::default()).id();
    stage.update();
    assert_eq!(stage.world().resource::<ExtractedScene>().scene.lights.len(), 1);
    stage.world().entity_mut(lamp).despawn();
    stage.update();
    assert!(stage.world().resource::<ExtractedScene>().scene.lights.is_empty());
}

#[test]
fn the_last_picture_stays_when_the_backend_fails() {
    let mut stage = Stage::new();
    let quad = stage.quad(true);
    stage.settle();
    stage.mock.place(quad, RECT, |_, _| Vec3::splat(0.8));
    stage.settle();
    stage.mock.lock().state = farlight::gi::BackendState::Failed("gone".into());
    let picture = stage.picture();
    stage.assert_all(&picture, Vec3::splat(0.4));
}

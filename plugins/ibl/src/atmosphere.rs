//! Bevy's atmosphere as the environment: its sky is drawn into a cube, read back, and becomes a map.
//!
//! # Why a camera of its own
//! Bevy scatters *every* directional light that a camera sees in the camera's atmosphere, and dims it on
//! materials by the air on its way (`bevy_pbr/src/render/pbr_lighting.wgsl`, `ATMOSPHERE`). Lights that
//! stand for the sky would light the sky once more, and those near the horizon and below it would go
//! out. So the sky is seen by a camera that sees only the game's own lights, and cameras that refine
//! have no `AtmosphereSettings`.

use bevy::{
    camera::{
        RenderTarget,
        visibility::{RenderLayers, VisibilitySystems},
    },
    light::{
        Atmosphere, AtmosphereEnvironmentMapLight, GeneratedEnvironmentMapLight,
        atmosphere::ScatteringMedium,
    },
    pbr::AtmosphereSettings,
    prelude::*,
    render::{
        gpu_readback::{Readback, ReadbackComplete},
        render_resource::{DownlevelFlags, TextureFormat, TextureUsages},
        renderer::{RenderAdapter, RenderDevice},
    },
    tasks::{AsyncComputeTaskPool, Task, futures::check_ready},
};
use std::{borrow::Cow, ops::RangeInclusive, sync::Arc};

use farlight_core::DerivedLight;
use farlight_environment::{Environment, EnvironmentError};
use half::f16;

use crate::{EnvironmentMap, ProgressiveCamera, ProgressiveLighting};

/// Edges of the cube; the smallest has rows that come back without padding.
const EDGES: RangeInclusive<u32> = 32..=512;
/// The first answers may be of frames before.
const SKIPPED: u32 = 3;
/// Answers until a black sky is believed: pipelines may still be compiled.
const BLACK: u32 = 60;
/// How much a light's colour or the air may change without another look, relative.
const SAME: f32 = 0.01;
/// The same for the camera, in metres.
const MOVED: f32 = 100.0;

/// A camera that looks at Bevy's atmosphere from where it is and makes it the
/// [`environment`](ProgressiveLighting::environment). It draws only when the sky has changed: the sun,
/// the [`Atmosphere`], or its own place (by 100 m); or when [`CaptureAtmosphere`] asks for it.
///
/// The map is radiance in cd/m² ([`brightness`](ProgressiveLighting::brightness) 1) of the sky and
/// the ground below the horizon, without the sun's disk: the sun is the game's own light. What the air
/// scatters are the directional lights on the camera's `RenderLayers`, never a `DerivedLight`.
///
/// Cameras that refine must have no `AtmosphereSettings` (Bevy would dim the lights of the sky by the air),
/// so nothing dims the sun for them: give it the strength that it has on the ground, and the sky a
/// sun of its own, on a layer of this camera's. Don't add `AtmosphereEnvironmentMapLight` to them:
/// it is the same light once more. [`AtmosphereState`] says what hinders.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Default, Debug, Clone)]
#[require(
    Camera3d,
    Camera { is_active: false, order: -1, ..default() },
    RenderTarget = RenderTarget::None { size: UVec2::ONE },
    Msaa = Msaa::Off,
    AtmosphereSettings,
    AtmosphereState,
    Capture
)]
pub struct AtmosphereEnvironment {
    /// Edge of the cube in texels, 32 to 512; rounded up to a power of two.
    pub edge: u32,
    /// Radians that the sun may turn until the sky is captured anew. Each new map begins a new cycle
    /// of lights: larger steps suit days that pass quickly.
    pub sun_step: f32,
}

impl Default for AtmosphereEnvironment {
    fn default() -> Self {
        Self { edge: 128, sun_step: 0.01 }
    }
}

/// Asks each [`AtmosphereEnvironment`] to capture its sky anew.
#[derive(Message, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CaptureAtmosphere;

/// What becomes of an [`AtmosphereEnvironment`].
#[derive(Component, Clone, Debug, Default, PartialEq, Eq)]
pub enum AtmosphereState {
    /// There is no [`Atmosphere`].
    #[default]
    None,
    /// The sky is being drawn, or becomes a map; the one before shines on.
    Capturing,
    /// The map is that of the sky.
    Ready,
    /// It can't be used; in words for the game's author.
    Failed(Cow<'static, str>),
}

/// What the sky depends on.
#[derive(Clone, Debug, PartialEq)]
struct Sky {
    /// Colour times illuminance, and the direction towards it.
    lights: Vec<(Vec3, Vec3)>,
    air: [f32; 8],
    medium: AssetId<ScatteringMedium>,
    from: Vec3,
    edge: u32,
}

impl Sky {
    fn is_like(&self, other: &Self, angle: f32) -> bool {
        let near = |a: f32, b: f32| (a - b).abs() <= SAME * a.abs().max(b.abs());
        let same_light = |(a, b): (&(Vec3, Vec3), &(Vec3, Vec3))| {
            (0..3).all(|i| near(a.0[i], b.0[i])) && a.1.distance(b.1) <= angle.max(0.0)
        };
        self.lights.len() == other.lights.len()
            && self.lights.iter().zip(&other.lights).all(same_light)
            && self.air == other.air
            && self.medium == other.medium
            && self.from.distance(other.from) <= MOVED
            && self.edge == other.edge
    }
}

/// How far the look at the sky is.
#[derive(Component, Default)]
pub(crate) struct Capture {
    /// The sky that the map shows or will show.
    of: Option<Sky>,
    /// Bevy's cube and its answers; a new one each time, since Bevy keeps what its first was made of.
    probe: Option<Entity>,
    task: Option<Task<Result<Environment, EnvironmentError>>>,
    map: Option<Handle<EnvironmentMap>>,
}

/// A cube that Bevy draws.
#[derive(Component)]
struct Probe {
    edge: u32,
    answers: u32,
    /// The texels, once they are the sky.
    sky: Option<Vec<u8>>,
}

pub(crate) fn build(app: &mut App) {
    app.add_message::<CaptureAtmosphere>().register_type::<AtmosphereEnvironment>().add_systems(
        PostUpdate,
        (read, capture, forget)
            .chain()
            .after(TransformSystems::Propagate)
            .after(VisibilitySystems::VisibilityPropagate)
            .run_if(resource_exists::<Assets<ScatteringMedium>>),
    );
}

/// Why this device draws no atmosphere; the conditions of Bevy's `AtmospherePlugin`.
fn hindrance(
    adapter: Option<&RenderAdapter>,
    device: Option<&RenderDevice>,
) -> Option<&'static str> {
    let (Some(adapter), Some(device)) = (adapter, device) else {
        return Some("there is no renderer that could draw the atmosphere");
    };
    let usages = adapter.get_texture_format_features(TextureFormat::Rgba16Float).allowed_usages;
    if !adapter.get_downlevel_capabilities().flags.contains(DownlevelFlags::COMPUTE_SHADERS)
        || !usages.contains(TextureUsages::STORAGE_BINDING)
        || device.limits().max_storage_textures_per_shader_stage == 0
    {
        return Some(
            "this GPU draws no atmosphere: it has no compute shaders that write half floats",
        );
    }
    None
}

/// Takes the cubes that Bevy has made for probes, and has them read.
fn read(
    mut commands: Commands,
    probes: Query<(Entity, &GeneratedEnvironmentMapLight), (With<Probe>, Without<Readback>)>,
) {
    for (probe, light) in &probes {
        commands
            .entity(probe)
            // It would be filtered for image-based light in each frame.
            .remove::<GeneratedEnvironmentMapLight>()
            .insert(Readback::texture(light.environment_map.clone()))
            .observe(answer);
    }
}

fn answer(event: On<ReadbackComplete>, mut probes: Query<&mut Probe>) {
    let Ok(mut probe) = probes.get_mut(event.entity) else { return };
    probe.answers += 1;
    if probe.sky.is_some() || probe.answers <= SKIPPED {
        return;
    }
    let is_black = event.data.chunks_exact(8).all(|texel| texel[..6].iter().all(|byte| *byte == 0));
    if !is_black || probe.answers >= BLACK {
        probe.sky = Some(event.data.clone());
    }
}

/// Looks where the sky has changed.
fn capture(
    mut commands: Commands,
    mut cameras: Query<(
        Entity,
        &AtmosphereEnvironment,
        &mut Camera,
        &mut Capture,
        &mut AtmosphereState,
        &GlobalTransform,
        Option<&RenderLayers>,
    )>,
    probes: Query<&Probe>,
    atmospheres: Query<(Entity, &Atmosphere, &GlobalTransform)>,
    lights: Query<
        (Entity, &DirectionalLight, &GlobalTransform, &InheritedVisibility, Option<&RenderLayers>),
        Without<DerivedLight>,
    >,
    dimmed: Query<(), (With<ProgressiveCamera>, With<AtmosphereSettings>)>,
    (adapter, device): (Option<Res<RenderAdapter>>, Option<Res<RenderDevice>>),
    mut asked: MessageReader<CaptureAtmosphere>,
    mut media: MessageReader<AssetEvent<ScatteringMedium>>,
    mut maps: ResMut<Assets<EnvironmentMap>>,
    mut settings: ResMut<ProgressiveLighting>,
) {
    if cameras.is_empty() {
        asked.clear();
        media.clear();
        return;
    }
    if !dimmed.is_empty() {
        warn_once!(
            "a ProgressiveCamera has AtmosphereSettings: Bevy dims the environment's lights by the \
             air, as if they were suns"
        );
    }
    let anew = asked.read().count() > 0;
    let media: Vec<_> = media
        .read()
        .filter_map(|event| match event {
            AssetEvent::Modified { id } => Some(*id),
            _ => None,
        })
        .collect();
    for (entity, wanted, mut camera, mut capture, mut state, from, layers) in &mut cameras {
        if let Some(why) = hindrance(adapter.as_deref(), device.as_deref()) {
            state.set_if_neq(AtmosphereState::Failed(why.into()));
            continue;
        }
        let from = from.translation();
        // As Bevy chooses it.
        let nearest = atmospheres.iter().min_by(|(a, _, at_a), (b, _, at_b)| {
            let distance = |at: &GlobalTransform| from.distance(at.translation());
            distance(at_a).total_cmp(&distance(at_b)).then_with(|| a.cmp(b))
        });
        let Some((_, air, at)) = nearest else {
            // Nothing is drawn without it; the map stays.
            give_up(&mut commands, &mut capture, &mut camera);
            state.set_if_neq(AtmosphereState::None);
            continue;
        };
        let layers = layers.unwrap_or_default();
        let mut suns: Vec<_> = lights
            .iter()
            .filter(|(.., visibility, on)| {
                visibility.get() && on.unwrap_or_default().intersects(layers)
            })
            .map(|(light, sun, at, ..)| {
                let color = sun.color.to_linear().to_vec3() * sun.illuminance;
                (light, (color, Vec3::from(at.back())))
            })
            .collect();
        suns.sort_unstable_by_key(|(light, _)| *light);
        let (centre, [r, g, b]) = (at.translation(), air.ground_albedo.to_array());
        let radii = [air.inner_radius, air.outer_radius];
        if anew || media.contains(&air.medium.id()) {
            // What is being captured may not show it.
            capture.of = None;
        }
        let sky = Sky {
            lights: suns.into_iter().map(|(_, sun)| sun).collect(),
            air: [radii[0], radii[1], r, g, b, centre.x, centre.y, centre.z],
            medium: air.medium.id(),
            from,
            edge: wanted.edge.clamp(*EDGES.start(), *EDGES.end()).next_power_of_two(),
        };

        if let Some(probe) = capture.probe {
            match probes.get(probe) {
                Ok(Probe { edge, sky: Some(texels), .. }) => {
                    let (edge, texels) = (*edge, texels.clone());
                    capture.task =
                        Some(AsyncComputeTaskPool::get().spawn(async move { map(edge, &texels) }));
                    commands.entity(probe).despawn();
                    capture.probe = None;
                    camera.is_active = false;
                }
                Ok(_) => continue,
                Err(_) => capture.probe = None,
            }
        }
        if let Some(task) = &mut capture.task {
            let Some(made) = check_ready(task) else { continue };
            capture.task = None;
            match made {
                Ok(map) => show(&mut capture, map, &mut maps, &mut settings),
                Err(error) => {
                    state.set_if_neq(AtmosphereState::Failed(error.to_string().into()));
                    continue;
                }
            }
            state.set_if_neq(AtmosphereState::Ready);
        }
        let same = capture.of.as_ref().is_some_and(|of| of.is_like(&sky, wanted.sun_step));
        if !same {
            let light = AtmosphereEnvironmentMapLight { size: UVec2::splat(sky.edge), ..default() };
            let probe = Probe { edge: sky.edge, answers: 0, sky: None };
            let name = Name::new("atmosphere of the environment");
            capture.probe = Some(commands.spawn((name, probe, light, ChildOf(entity))).id());
            capture.of = Some(sky);
            camera.is_active = true;
            state.set_if_neq(AtmosphereState::Capturing);
        }
    }
}

fn give_up(commands: &mut Commands, capture: &mut Mut<Capture>, camera: &mut Mut<Camera>) {
    if let Some(probe) = capture.probe.take() {
        commands.entity(probe).try_despawn();
    }
    if camera.is_active {
        camera.is_active = false;
    }
    capture.of = None;
    capture.task = None;
}

/// Makes the map the environment; later ones take its place where it still is.
fn show(
    capture: &mut Capture,
    map: Environment,
    maps: &mut Assets<EnvironmentMap>,
    settings: &mut ProgressiveLighting,
) {
    let map = EnvironmentMap(Arc::new(map));
    match &capture.map {
        Some(handle) => {
            if maps.insert(handle.id(), map).is_err() {
                warn!("the atmosphere's map is gone");
            }
        }
        None => {
            let handle = maps.add(map);
            settings.environment = Some(handle.clone());
            capture.map = Some(handle);
        }
    }
}

/// Probes go with their cameras; what else was captured has none to be for.
fn forget(
    mut removed: RemovedComponents<AtmosphereEnvironment>,
    mut commands: Commands,
    probes: Query<(Entity, &ChildOf), With<Probe>>,
    mut cameras: Query<&mut Camera>,
) {
    for camera in removed.read() {
        for (probe, _) in probes.iter().filter(|(_, of)| of.parent() == camera) {
            commands.entity(probe).try_despawn();
        }
        if let Ok(mut entity) = commands.get_entity(camera) {
            entity.try_remove::<(Capture, AtmosphereState)>();
        }
        if let Ok(mut camera) = cameras.get_mut(camera) {
            camera.is_active = false;
        }
    }
}

/// The map of a cube's texels: six faces of RGBA half floats.
fn map(edge: u32, texels: &[u8]) -> Result<Environment, EnvironmentError> {
    let half = |bytes: &[u8]| f16::from_le_bytes([bytes[0], bytes[1]]).to_f32();
    let texels: Vec<_> = texels
        .chunks_exact(8)
        .map(|texel| Vec3::new(half(texel), half(&texel[2..]), half(&texel[4..])))
        .collect();
    let area = (edge * edge) as usize;
    let faces =
        std::array::from_fn(|face| texels.get(face * area..(face + 1) * area).unwrap_or_default());
    Environment::from_cube(edge, faces)
}

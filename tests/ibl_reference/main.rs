//! Light from all round on a ball: what is drawn against what the CPU sums up.

#[path = "../support/mod.rs"]
mod support;

mod integral;
mod lights;
mod one_light;
mod refined;

use std::{fmt, sync::Arc, time::Duration};

use bevy::{
    math::{DVec2, DVec3},
    prelude::*,
};
use farlight::{
    btf::{BtfStatus, codec::synthetic},
    prelude::*,
};
use support::{ball::Ball, headless::Headless, linear, shading::Surface};

/// Edge of a picture in pixels.
const SIZE: u32 = 64;

/// Balls far apart, each before a camera of its own.
struct Stage {
    headless: Headless,
    ball: Ball,
    stands: Vec<Stand>,
}

/// A ball and its picture.
struct Stand {
    surface: Surface,
    target: Handle<Image>,
    camera: Entity,
}

impl Stage {
    /// Metres between balls: no camera sees another one's.
    const APART: f32 = 16.0;

    /// `sectors` is how many facets a ball has round its axis.
    fn new(surfaces: &[Surface], sectors: u32) -> Self {
        let headless = Headless::new(UVec2::splat(SIZE), &support::assets(), |app| {
            app.add_plugins(FarlightPlugins)
                .insert_resource(farlight::ibl::EnvironmentCache(None))
                .insert_resource(GlobalAmbientLight::NONE)
                .insert_resource(ClearColor(Color::BLACK));
        });
        let mut headless = headless.unwrap_or_else(|problem| panic!("{problem}"));
        headless.set_frame_time(Duration::from_millis(16));
        let ball = Ball::filling(SIZE);
        let mesh = headless.app.world_mut().resource_mut::<Assets<Mesh>>().add(ball.mesh(sectors));
        let mut stage = Self { headless, ball, stands: Vec::new() };
        for (i, &surface) in (0_u8..).zip(surfaces) {
            let place = Vec3::X * Self::APART * f32::from(i);
            let target = linear::target(&mut stage.headless.app, UVec2::splat(SIZE));
            let eye = (linear::camera(&target), ball.projection(), ball.pose_at(place));
            let camera = stage.world().spawn(eye).id();
            let object = (Mesh3d(mesh.clone()), Transform::from_translation(place));
            let object = stage.world().spawn(object).id();
            stage.cover(object, &surface);
            stage.stands.push(Stand { surface, target, camera });
        }
        stage
    }

    fn world(&mut self) -> &mut World {
        self.headless.app.world_mut()
    }

    fn cover(&mut self, object: Entity, surface: &Surface) {
        if let Some(material) = surface.bevy() {
            let material = self.world().resource_mut::<Assets<StandardMaterial>>().add(material);
            self.world().entity_mut(object).insert(MeshMaterial3d(material));
        } else {
            let &Surface::Lambert { albedo } = surface else { unreachable!("Bevy has the others") };
            let btf = synthetic::lambert(albedo.as_vec3().to_array(), [4, 4]).unwrap();
            let btf = self.world().resource_mut::<Assets<BtfAsset>>().add(BtfAsset(Arc::new(btf)));
            let material = BtfMaterial::new(btf);
            let material = self.world().resource_mut::<Assets<BtfMaterial>>().add(material);
            self.world().entity_mut(object).insert(MeshMaterial3d(material));
            let ready = |world: &mut World| {
                let status = world.resource::<BtfStatus>();
                status.waiting == 0 && status.resident > 0
            };
            self.headless
                .update_until("a material on the GPU", Duration::from_secs(60), ready)
                .unwrap_or_else(|problem| panic!("{problem}"));
        }
    }

    /// What each camera sees.
    fn pictures(&mut self) -> Vec<Vec<DVec3>> {
        let targets: Vec<_> = self.stands.iter().map(|stand| &stand.target).collect();
        let pictures = linear::read(&mut self.headless, &targets);
        pictures
            .into_iter()
            .map(|pixels| pixels.into_iter().map(Vec3::as_dvec3).collect())
            .collect()
    }
}

/// How a picture deviates from its reference over pixels that the light reaches.
struct Deviation {
    /// Mean of absolute over mean of reference values, of all channels.
    absolute: f64,
    /// Mean of deviations with their sign, over the same.
    signed: f64,
    /// Largest of a pixel's channel, relative to the reference's mean or to itself, whichever is more.
    worst: f64,
    pixels: usize,
}

impl Deviation {
    /// Pairs of ours and the reference's.
    fn over(pairs: &[(DVec3, DVec3)]) -> Self {
        let lit: Vec<_> =
            pairs.iter().filter(|(_, reference)| reference.element_sum() > 0.0).collect();
        let sum = |f: &dyn Fn(DVec3, DVec3) -> f64| lit.iter().map(|&&(a, b)| f(a, b)).sum::<f64>();
        let total = sum(&|_, b| b.element_sum()).max(f64::MIN_POSITIVE);
        let mean = total / (3 * lit.len().max(1)) as f64;
        let worst = |a: DVec3, b: DVec3| ((a - b).abs() / b.max(DVec3::splat(mean))).max_element();
        Self {
            absolute: sum(&|a, b| (a - b).abs().element_sum()) / total,
            signed: sum(&|a, b| (a - b).element_sum()) / total,
            worst: lit.iter().map(|&&(a, b)| worst(a, b)).fold(0.0, f64::max),
            pixels: lit.len(),
        }
    }
}

impl fmt::Display for Deviation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { absolute, signed, worst, pixels } = self;
        write!(
            f,
            "{:.3} % (signed {:+.3} %, worst {:.2} %, {pixels} pixels)",
            100.0 * absolute,
            100.0 * signed,
            100.0 * worst
        )
    }
}

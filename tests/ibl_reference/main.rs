//! Light from all round on a ball: what is drawn against what the CPU sums up.

#[path = "../support/mod.rs"]
mod support;

mod integral;
mod one_light;

use std::{fmt, sync::Arc, time::Duration};

use bevy::{math::DVec3, prelude::*};
use farlight::{
    btf::{BtfStatus, codec::synthetic},
    prelude::*,
};
use support::{ball::Ball, headless::Headless, linear::LinearTarget, shading::Surface};

/// Edge of a picture in pixels.
const SIZE: u32 = 64;

/// A ball and a camera.
struct Stage {
    headless: Headless,
    target: LinearTarget,
    ball: Ball,
    object: Entity,
}

impl Stage {
    fn new(surface: &Surface) -> Self {
        Self::with(surface, |_| {})
    }

    /// `configure` may add plugins.
    fn with(surface: &Surface, configure: impl FnOnce(&mut App)) -> Self {
        let headless = Headless::new(UVec2::splat(SIZE), &support::assets(), |app| {
            app.add_plugins(FarlightPlugins)
                .insert_resource(GlobalAmbientLight::NONE)
                .insert_resource(ClearColor(Color::BLACK));
            configure(app);
        });
        let mut headless = headless.unwrap_or_else(|problem| panic!("{problem}"));
        headless.set_frame_time(Duration::from_millis(16));
        let target = LinearTarget::new(&mut headless.app, SIZE);
        let ball = Ball::filling(SIZE);
        let world = headless.app.world_mut();
        world.spawn((target.camera(), ball.projection(), ball.pose()));
        let mesh = world.resource_mut::<Assets<Mesh>>().add(ball.mesh());
        let object = world.spawn((Mesh3d(mesh), Transform::default())).id();
        let mut stage = Self { headless, target, ball, object };
        stage.cover(surface);
        stage
    }

    fn world(&mut self) -> &mut World {
        self.headless.app.world_mut()
    }

    /// Gives the ball another surface.
    fn cover(&mut self, surface: &Surface) {
        let object = self.object;
        if let Some(material) = surface.bevy() {
            let material = self.world().resource_mut::<Assets<StandardMaterial>>().add(material);
            self.world()
                .entity_mut(object)
                .remove::<MeshMaterial3d<BtfMaterial>>()
                .insert(MeshMaterial3d(material));
        } else {
            let &Surface::Lambert { albedo } = surface else { unreachable!("Bevy has the others") };
            let btf = synthetic::lambert(albedo.as_vec3().to_array(), [4, 4]).unwrap();
            let btf = self.world().resource_mut::<Assets<BtfAsset>>().add(BtfAsset(Arc::new(btf)));
            let material = BtfMaterial::new(btf);
            let material = self.world().resource_mut::<Assets<BtfMaterial>>().add(material);
            self.world()
                .entity_mut(object)
                .remove::<MeshMaterial3d<StandardMaterial>>()
                .insert(MeshMaterial3d(material));
            let ready = |world: &mut World| {
                let status = world.resource::<BtfStatus>();
                status.waiting == 0 && status.resident > 0
            };
            self.headless
                .update_until("a material on the GPU", Duration::from_secs(60), ready)
                .unwrap_or_else(|problem| panic!("{problem}"));
        }
    }

    fn picture(&mut self) -> Vec<DVec3> {
        self.target.read(&mut self.headless).into_iter().map(Vec3::as_dvec3).collect()
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

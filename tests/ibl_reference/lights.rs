//! Lights against the environment that they stand for, both on the CPU.

use farlight_environment::{LightRequest, Method};

use crate::{
    integral::{GLOSSY, ROTATION, deviation, environment, points},
    support::integral::{Grain, lit_by, rays, turned},
    *,
};

pub(crate) const DIFFUSE: Surface = Surface::Standard {
    base_color: DVec3::new(0.8, 0.8, 0.8),
    metallic: 0.0,
    perceptual_roughness: 1.0,
    reflectance: 0.0,
};

/// What 4096 lights leave to be desired, whoever draws them: a diffuse ball within 1 %, a glossy one
/// within 3 % of the whole environment.
#[test]
fn lights_stand_for_the_environment() {
    let points = points(4);
    for name in ["sky", "overcast", "interior", "evening", "studio"] {
        let environment = environment(name);
        let whole = rays(&environment, ROTATION, Grain::TEXEL);
        let request = LightRequest { count: 4096, seed: 5, ..default() };
        let lights = turned(&environment.lights(&request), ROTATION);
        for (kind, surface, limit) in [("diffuse", DIFFUSE, 0.01), ("glossy", GLOSSY, 0.03)] {
            let reference = lit_by(&surface, &whole, &points);
            let deviation = deviation(&lit_by(&surface, &lights, &points), &reference);
            println!("{name}, {kind}, 4096 lights by {}: {deviation}", Method::default());
            assert!(deviation.absolute < limit, "{name}, {kind}: {deviation}");
        }
    }
}

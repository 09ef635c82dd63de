//! Maps of every kind, and what is wrong with some of them.

use std::f32::consts::{PI, TAU};

use farlight_environment::{Environment, EnvironmentError, LightRequest, Method, Repairs};
use glam::Vec3;

fn close(found: Vec3, expected: Vec3, tolerance: f32) {
    let error = (found - expected).abs().max_element() / expected.max_element().max(1e-30);
    assert!(error < tolerance, "{found} is not {expected}: {error}");
}

#[test]
fn an_even_map_of_any_size_lights_every_side_with_pi() {
    let radiance = Vec3::new(1.0, 0.5, 0.0);
    for (width, height) in [(1, 1), (2, 1), (7, 3), (1024, 512), (4001, 2000)] {
        let texels = vec![radiance; (width * height) as usize];
        let map = Environment::from_equirect(width, height, texels).unwrap();
        for normal in [Vec3::Y, -Vec3::Y, Vec3::X, Vec3::new(0.6, 0.48, -0.64)] {
            close(map.irradiance(normal), PI * radiance, 1e-4);
            close(map.radiance(normal), radiance, 1e-6);
        }
    }
}

#[test]
fn large_maps_keep_their_energy() {
    // Not a multiple of the size it is averaged down to, and one bright texel near the zenith.
    let (width, height) = (4099, 2051);
    let mut texels = vec![Vec3::splat(0.25); width * height];
    texels[40 * width + 3000] = Vec3::new(1e6, 2e6, 0.0);
    let map = Environment::from_equirect(width as u32, height as u32, texels).unwrap();
    assert_eq!([map.width(), map.height()], [2048, 1024]);
    let edge = |row: f32| (f64::from(row) / height as f64 * std::f64::consts::PI).cos();
    let solid_angle = ((edge(40.0) - edge(41.0)) as f32) * TAU / width as f32;
    let polar = 40.5 / height as f32 * PI;
    let bright = Vec3::new(1e6, 2e6, 0.0) * solid_angle * polar.cos();
    close(map.irradiance(Vec3::Y), Vec3::splat(0.25 * PI) + bright, 1e-4);
    assert!(map.repairs().is_none());
}

#[test]
fn values_that_are_no_radiance_are_repaired_and_counted() {
    let mut texels = vec![Vec3::ONE; 32];
    texels[3] = Vec3::new(f32::NAN, -1.0, f32::INFINITY);
    texels[9] = Vec3::new(7.0, f32::MAX, f32::NEG_INFINITY);
    let map = Environment::from_equirect(8, 4, texels).unwrap();
    assert_eq!(map.repairs(), Repairs { nan: 1, infinite: 2, negative: 2 });
    close(map.texels()[3], Vec3::new(0.0, 0.0, 7.0), 1e-6);
    close(map.texels()[9], Vec3::new(7.0, 7.0, 0.0), 1e-6);
    let nothing = Environment::from_equirect(2, 1, vec![Vec3::INFINITY; 2]).unwrap();
    assert_eq!(nothing.texels(), [Vec3::ZERO; 2]);
}

#[test]
fn sizes_that_contradict_each_other_are_errors() {
    for (width, height, texels) in [(0, 4, 0), (4, 0, 0), (4, 2, 7), (1 << 17, 1, 1 << 17)] {
        let map = Environment::from_equirect(width, height, vec![Vec3::ONE; texels]);
        assert!(matches!(map, Err(EnvironmentError::Size(_))), "{width} x {height}");
    }
}

#[test]
fn a_black_map_gives_lights_without_light() {
    let map = Environment::from_equirect(16, 8, vec![Vec3::ZERO; 128]).unwrap();
    for method in Method::ALL {
        let lights = map.lights(&LightRequest { count: 20, method, seed: 4 });
        assert_eq!(lights.len(), 20);
        for light in lights {
            assert_eq!(light.irradiance, Vec3::ZERO);
            assert!((light.direction.length() - 1.0).abs() < 1e-6);
        }
        assert_eq!(map.irradiance(Vec3::Y), Vec3::ZERO);
    }
}

#[test]
fn one_texel_with_all_energy_gives_lights_within_it() {
    // The texel at column 5 of 8, row 1 of 4: to the right of ahead, above the horizon.
    let mut texels = vec![Vec3::ZERO; 32];
    texels[8 + 5] = Vec3::new(0.0, 0.0, 1e9);
    let map = Environment::from_equirect(8, 4, texels).unwrap();
    let solid_angle = (PI / 4.0).cos() * TAU / 8.0;
    let (sin, cos) = (0.375 * PI).sin_cos();
    let centre = Vec3::new(sin * sin, cos, -sin * cos);
    for method in Method::ALL {
        for count in [1, 7, 4096] {
            let lights = map.lights(&LightRequest { count, method, seed: 1 });
            assert_eq!(lights.len(), count as usize);
            let sum: Vec3 = lights.iter().map(|light| light.irradiance).sum();
            close(sum, Vec3::new(0.0, 0.0, 1e9 * solid_angle), 1e-3);
            for light in &lights {
                // Parallels are bent, so that the middle of a piece may lie a little above its edge.
                let inwards = if method == Method::Centroids { 0.1 } else { 0.0 };
                let inside = light.direction.lerp(centre, inwards);
                assert_eq!(map.radiance(inside).z, 1e9, "{method}: {}", light.direction);
            }
        }
    }
}

//! Lights against the map that they replace.

mod common;

use common::{Error, maps, mean_error, normals};
use farlight_environment::{LightRequest, Method};

#[test]
fn independent_lights_err_as_known() {
    for (name, map) in maps() {
        let error = mean_error(&map, 200, Method::Independent, 16);
        println!("{name}: {error}");
        // Figures of another implementation of the method on such maps: 7 to 14 %.
        assert!(error.mean > 0.03 && error.mean < 0.2, "{name}: {error}");
    }
}

#[test]
fn lights_are_unit_vectors_and_the_seed_decides_them() {
    for (name, map) in maps() {
        for method in Method::ALL {
            let request = LightRequest { count: 50, method, seed: 7 };
            let lights = map.lights(&request);
            assert_eq!(lights, map.lights(&request), "{name}, {method}");
            assert_ne!(
                lights,
                map.lights(&LightRequest { seed: 8, ..request }),
                "{name}, {method}"
            );
            for light in lights {
                assert!((light.direction.length() - 1.0).abs() < 1e-5);
                assert!(light.irradiance.is_finite() && light.irradiance.min_element() >= 0.0);
            }
        }
    }
}

#[test]
fn the_measure_finds_a_difference() {
    let sums = vec![glam::Vec3::ONE; normals().len()];
    let twice: Vec<_> = sums.iter().map(|sum| 2.0 * *sum).collect();
    assert_eq!(Error::of(&twice, &sums).mean, 1.0);
}

use glam::Vec3;

use super::{Gpu, GpuError, GpuEvaluator};
use crate::{Angles, Query, Rules, SliceAngles, synthetic};

fn gpu() -> Option<Gpu> {
    Gpu::new().map_err(|error| println!("SKIPPED: {error}")).ok()
}

#[test]
fn tables_beyond_the_limit_are_an_error() {
    let Some(gpu) = gpu() else { return };
    let btf = synthetic::lambert([0.5; 3], [4, 4]).unwrap();
    let bytes = 4 * btf.words().len() as u64;
    let error = GpuEvaluator::new(&gpu.clone().limited(bytes - 1), &btf, Rules::SHADING);
    assert!(matches!(error, Err(GpuError::TooLarge { .. })), "{error:?}");
    // And a small limit makes small chunks, of which any number follow each other.
    let evaluator = GpuEvaluator::new(&gpu.limited(bytes), &btf, Rules::SHADING).unwrap();
    let count = 3 * evaluator.chunk + 1;
    assert_eq!(evaluator.evaluate(&vec![Query::default(); count]).unwrap().len(), count);
}

#[test]
fn lights_add_up() {
    let Some(gpu) = gpu() else { return };
    let btf = synthetic::lambert([0.9, 0.5, 0.1], [4, 4]).unwrap();
    let lights = [
        Vec3::Z,
        Vec3::new(0.6, 0.0, 0.8),
        Vec3::new(-0.36, 0.48, 0.8),
        Vec3::new(0.0, -0.8, -0.6),
        Vec3::X,
    ];
    let mut views = Vec::new();
    for at in 0..1000_u16 {
        let angles = Angles {
            theta_v: f32::from(at % 40) * 0.039,
            phi_v: f32::from(at) * 0.1 - 30.0,
            ..Angles::default()
        };
        views.push(Query { x: i32::from(at), y: i32::from(at / 3), angles });
    }
    for count in [0, 1, lights.len()] {
        let lights = &lights[..count];
        let evaluator = GpuEvaluator::with_lights(&gpu, &btf, Rules::SHADING, lights).unwrap();
        for (view, value) in views.iter().zip(evaluator.evaluate(&views).unwrap()) {
            let Angles { theta_v, phi_v, .. } = view.angles;
            let slices = btf.view_slices(view.x, view.y, theta_v, phi_v);
            let mut expected = Vec3::ZERO;
            for light in lights.iter().filter(|light| light.z >= 0.0) {
                let (sin, cos) = phi_v.sin_cos();
                let across = light.x * sin - light.y * cos;
                let mirror = -(light.x * cos + light.y * sin);
                let light = SliceAngles::from_vector(across, mirror, light.z, false);
                expected += btf.evaluate_slices(&slices, light, Rules::SHADING);
            }
            // Beside the horizon the table falls by 255 in the last degrees: 1e-6 rad is 0.004.
            let error = (value - expected).abs().max_element();
            assert!(error <= 0.02, "{count} lights, {view:?}: {value} instead of {expected}");
        }
    }
}

#[test]
fn time_passes() {
    let Some(gpu) = gpu() else { return };
    let btf = synthetic::lambert([0.5; 3], [4, 4]).unwrap();
    let evaluator = GpuEvaluator::new(&gpu, &btf, Rules::SHADING).unwrap();
    let timing = evaluator.time(&vec![Query::default(); 100_000], 3).unwrap();
    assert_eq!(timing.queries, 100_000);
    assert!(timing.shortest <= timing.median && !timing.median.is_zero(), "{timing:?}");
    assert!(evaluator.time(&[], 0).unwrap().median.is_zero());
}

#[test]
fn a_lost_device_is_an_error() {
    let Some(gpu) = gpu() else { return };
    let btf = synthetic::lambert([0.5; 3], [4, 4]).unwrap();
    let evaluator = GpuEvaluator::new(&gpu, &btf, Rules::SHADING).unwrap();
    gpu.device.destroy();
    for _ in 0..2 {
        let error = evaluator.evaluate(&[Query::default()]);
        assert!(matches!(error, Err(GpuError::Lost { .. })), "{error:?}");
    }
    let error = GpuEvaluator::new(&gpu, &btf, Rules::SHADING);
    assert!(matches!(error, Err(GpuError::Lost { .. })), "{:?}", error.err());
}

use glam::Vec3;
use wgpu::util::DeviceExt;

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

/// What `shaders/math.wgsl` says of its errors holds on this device.
#[test]
fn elementary_functions_are_as_exact_as_they_say() {
    const SOURCE: &str = "
        #import farlight::math::{arc_cosine, arc_sine, arc_tangent, sine_cosine}
        @group(0) @binding(0) var<storage, read> input: array<vec2<f32>>;
        @group(0) @binding(1) var<storage, read_write> output: array<vec4<f32>>;
        @compute @workgroup_size(64)
        fn main(@builtin(global_invocation_id) id: vec3<u32>) {
            if id.x >= arrayLength(&input) { return; }
            let p = input[id.x];
            let turn = sine_cosine(10.0 * p.x);
            output[2u * id.x] = vec4(arc_tangent(p.y, p.x), arc_sine(p.x), arc_cosine(p.x), 0.0);
            output[2u * id.x + 1u] = vec4(turn, 0.0, 0.0);
        }";
    let Some(gpu) = gpu() else { return };
    let points: Vec<[f32; 2]> = (0..=400)
        .flat_map(|at| {
            [-1.0_f32, -0.5, -1e-4, 0.0, 1e-6, 0.2, 1.0].map(|y| [at as f32 / 200.0 - 1.0, y])
        })
        .collect();
    let module = farlight_shaders::compose_source(SOURCE, "test", &[]).unwrap();
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module)),
    });
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: None,
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    let input = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: None,
        contents: bytemuck::cast_slice(&points),
        usage: wgpu::BufferUsages::STORAGE,
    });
    use wgpu::BufferUsages as Usage;
    let bytes = (points.len() * 32) as u64;
    let [output, read] =
        [Usage::STORAGE | Usage::COPY_SRC, Usage::COPY_DST | Usage::MAP_READ].map(|usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: bytes,
                usage,
                mapped_at_creation: false,
            })
        });
    let bindings = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[(0, &input), (1, &output)].map(|(binding, buffer)| wgpu::BindGroupEntry {
            binding,
            resource: buffer.as_entire_binding(),
        }),
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &bindings, &[]);
        pass.dispatch_workgroups(points.len().div_ceil(64) as u32, 1, 1);
    }
    encoder.copy_buffer_to_buffer(&output, 0, &read, 0, bytes);
    gpu.queue.submit([encoder.finish()]);
    let found = gpu.read::<[f32; 8]>(&read, bytes).unwrap();
    let mut worst = [0.0_f64; 5];
    for ([x, y], found) in points.iter().zip(&found) {
        let (x, y) = (f64::from(*x), f64::from(*y));
        let (sine, cosine) = f64::from(10.0 * x as f32).sin_cos();
        let expected = [y.atan2(x), x.asin(), x.acos(), sine, cosine];
        let found = [found[0], found[1], found[2], found[4], found[5]];
        for (worst, (found, expected)) in worst.iter_mut().zip(found.into_iter().zip(expected)) {
            *worst = worst.max((f64::from(found) - expected).abs());
        }
    }
    println!("arc tangent, sine, cosine; sine, cosine: {worst:?}");
    // The fits' own errors, and a unit in the last place of an angle of pi at each of three steps.
    assert!(worst.iter().all(|worst| *worst <= 1.2e-6), "{worst:?}");
}

//! What our systems cost a frame. Nothing is asserted: figures depend on the machine.

use bevy::prelude::*;
use farlight::{gi::StageTimes, gi::solver::atlas::TexelRect, prelude::*};

use crate::{lightmapped_quad, pictures::Stage};

fn print(what: &str, times: &StageTimes) {
    let (cpu, wall) = (times.cpu_stats(), times.wall_stats());
    println!(
        "{what:8} cpu median {:?} p95 {:?} p99 {:?} max {:?}, wall p99 {:?} max {:?} ({} frames)",
        cpu.median, cpu.p95, cpu.p99, cpu.max, wall.p99, wall.max, cpu.samples
    );
}

fn print_all(title: &str, stage: &mut Stage) {
    println!("{title}");
    let mut status = stage.world().resource_mut::<GiStatus>();
    let timings = &status.timings;
    print("extract", &timings.extract);
    print("apply", &timings.apply);
    print("upload", &timings.upload);
    print("frame", &timings.frame);
    status.timings.clear();
}

#[test]
#[ignore = "prints what our systems cost; run it alone on an idle machine"]
fn what_a_frame_costs() {
    let mut stage = Stage::new();
    stage.world().insert_resource(GiSettings { page_size: 512, max_pages: 1, ..default() });
    let root = stage.world().spawn((GiScene, Transform::default(), Visibility::default())).id();
    let material = stage.matte();
    let mut quads = Vec::new();
    for i in 0..2000 {
        let mesh = if i % 10 == 0 {
            let mesh = lightmapped_quad(0.01 + i as f32 * 1e-6);
            stage.world().resource_mut::<Assets<Mesh>>().add(mesh)
        } else {
            let last: &Handle<Mesh> = quads.last().map(|(_, mesh)| mesh).unwrap();
            last.clone()
        };
        let place = Transform::from_xyz((i % 50) as f32 * 0.04 - 1.0, (i / 50) as f32 * 0.04, 0.0);
        let bundle = (Mesh3d(mesh.clone()), MeshMaterial3d(material.clone()), place, ChildOf(root));
        quads.push((stage.world().spawn(bundle).id(), mesh));
    }
    let lamps = [0.0_f32; 50].map(|x| {
        stage.world().spawn((PointLight::default(), Transform::from_xyz(x, 0.0, 1.0))).id()
    });
    let box_of_room = Transform::from_scale(Vec3::splat(2.0));
    let resolution = UVec3::splat(8);
    let volume = stage.world().spawn((GiProbeVolume { resolution }, box_of_room)).id();
    stage.settle();
    print_all("loading 2000 meshes, 200 of them different", &mut stage);

    for (i, &(quad, _)) in quads.iter().enumerate() {
        let (x, y) = (i as u32 % 50 * 8, i as u32 / 50 * 8);
        stage.mock.place(quad, TexelRect { x, y, width: 8, height: 8 }, |_, _| Vec3::ONE);
    }
    for _ in 0..8 {
        stage.update();
    }
    print_all("placing 2000 lightmaps at once", &mut stage);

    for _ in 0..200 {
        stage.update();
    }
    print_all("a still scene", &mut stage);

    for i in 0..400 {
        for lamp in &lamps[..5] {
            stage.world().get_mut::<Transform>(*lamp).unwrap().translation.x = i as f32 * 0.01;
        }
        if i % 3 == 0 {
            let rect = TexelRect { x: 0, y: 0, width: 128, height: 128 };
            stage.mock.place(quads[0].0, rect, |x, _| Vec3::splat(x as f32 * 0.01));
            let probes = vec![farlight::gi::solver::sh::ShRgb::ZERO; 512];
            stage.mock.light_volume(volume, resolution, probes);
        }
        stage.update();
    }
    print_all("5 lights move, 128x128 texels and 512 probes every third frame", &mut stage);
}

//! Values of the GPU, against test vectors and against the CPU.

mod contract;
mod made;
#[path = "../measured/mod.rs"]
mod measured;
mod twins;

use farlight_btf_codec::gpu::{Gpu, GpuEvaluator};
use farlight_btf_codec::{Btf, Query, Rules};
use glam::Vec3;
use measured::{compare_binaries, compare_text, materials};

fn gpu() -> Option<Gpu> {
    match Gpu::new() {
        Ok(gpu) => {
            println!("on {}", gpu.adapter());
            Some(gpu)
        }
        Err(error) => {
            println!("SKIPPED: {error}");
            None
        }
    }
}

fn evaluate(gpu: &Gpu, btf: &Btf, queries: &[Query]) -> Vec<Vec3> {
    GpuEvaluator::new(gpu, btf, Rules::COMPATIBLE).unwrap().evaluate(queries).unwrap()
}

#[test]
fn text_tables_give_the_vectors() {
    let (Some(folder), Some(gpu)) = (materials(), gpu()) else { return };
    compare_text(&folder, |btf, queries| evaluate(&gpu, btf, queries));
}

#[test]
fn binaries_give_the_vectors() {
    let (Some(folder), Some(gpu)) = (materials(), gpu()) else { return };
    compare_binaries(&folder, |btf, queries| evaluate(&gpu, btf, queries));
}

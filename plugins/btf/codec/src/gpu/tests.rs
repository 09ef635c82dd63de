use super::{Gpu, GpuError, GpuEvaluator, Query};
use crate::{Rules, synthetic};

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

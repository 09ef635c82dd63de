//! Gathered light as bytes.

use farlight_gi_solver::{
    World,
    bake::{Density, Gathered, Gatherer, GathererSettings, Layout, LayoutSettings, SavedError},
    estimate::no_progress,
    scene::DirectSky,
};
use glam::Vec3;

use crate::{common::two_rooms, scenes::built};

const LAYOUT: LayoutSettings =
    LayoutSettings { page_size: 64, max_pages: 1, density: Density::Fit };

#[test]
fn what_was_saved_comes_back_and_nothing_else_does() {
    let mut builder = two_rooms(true);
    builder.point_light(1, Vec3::new(2.0, 2.5, 2.0), Vec3::splat(100.0));
    let (scene, receivers) = built(builder);
    let world = World::new(&scene);
    let layout = Layout::new(&scene, &world, receivers.iter().copied(), &LAYOUT);
    let other = Layout::new(&scene, &world, receivers.iter().copied().skip(1), &LAYOUT);
    let settings = GathererSettings { seed: 1, bounces: 0, direct_sky: DirectSky::Included };
    let gatherer = Gatherer::new(&world, &layout, settings, no_progress()).unwrap();
    let mut gathered = Gathered::new(&layout);
    gatherer.pass(&mut gathered, 4, no_progress()).unwrap();

    let bytes = gathered.to_bytes();
    assert_eq!(Gathered::from_bytes(&layout, &bytes), Ok(gathered.clone()));
    assert!(matches!(Gathered::from_bytes(&other, &bytes), Err(SavedError::Texels { .. })));
    assert_eq!(Gathered::from_bytes(&layout, b"PNG"), Err(SavedError::Foreign));
    // Cut off anywhere, or with any bit changed: an error, whatever it is.
    for length in (0..64).chain((64..bytes.len()).step_by(997)) {
        assert!(Gathered::from_bytes(&layout, &bytes[..length]).is_err(), "{length}");
    }
    let longer = [&bytes[..], &[0]].concat();
    assert!(Gathered::from_bytes(&layout, &longer).is_err());
    let (mut changed, mut refused) = (bytes.clone(), 0);
    let places = (0..32 * 8).chain((256..bytes.len() * 8).step_by(4999));
    let count = places.clone().count();
    for bit in places {
        changed[bit / 8] ^= 1 << (bit % 8);
        refused += usize::from(Gathered::from_bytes(&layout, &changed).is_err());
        changed[bit / 8] ^= 1 << (bit % 8);
    }
    assert_eq!(refused, count);
    assert!(SavedError::Version(7).to_string().contains('7'));
}

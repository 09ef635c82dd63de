//! Where receivers lie on the pages.

use farlight_gi_solver::{
    World,
    bake::{Density, Layout, LayoutSettings},
};
use glam::Vec3;

use crate::{
    common::{Builder, two_rooms},
    scenes::built,
};

fn fit(builder: Builder, page_size: u32) -> Layout {
    let (scene, receivers) = built(builder);
    let settings = LayoutSettings { page_size, max_pages: 1, density: Density::Fit };
    Layout::new(&scene, &World::new(&scene), receivers, &settings)
}

/// Part of the page that rectangles take, padding not counted.
fn used(layout: &Layout) -> f32 {
    let area: usize = layout.placements.iter().map(|p| p.rect.area()).sum();
    area as f32 / (layout.page_size * layout.page_size) as f32
}

#[test]
fn the_densest_that_fits_fills_the_page() {
    // 200 quads of 0.2 to 1.2 m.
    let mut many = Builder::default();
    for i in 0..200_u32 {
        let edge = |k: u32| 0.2 + (i * k % 101) as f32 * 0.01;
        let origin = Vec3::X * (2 * i) as f32;
        many.quad(origin, Vec3::Z * edge(7), Vec3::X * edge(13), Vec3::ONE);
    }
    for (what, builder, page, least) in
        [("many", many, 1024, 0.75), ("rooms", two_rooms(true), 256, 0.75)]
    {
        let layout = fit(builder, page);
        assert!(layout.refused.is_empty());
        assert_eq!(layout.page_count, 1);
        println!(
            "{what}: {} of the page, {} texels a metre",
            used(&layout),
            layout.texels_per_metre
        );
        assert!(used(&layout) > least, "{what}: {}", used(&layout));
    }
    // One square takes the page but for its border.
    let mut one = Builder::default();
    one.quad(Vec3::ZERO, Vec3::Z * 3.0, Vec3::X * 3.0, Vec3::ONE);
    let layout = fit(one, 64);
    assert_eq!((layout.placements[0].rect.width, layout.len()), (62, 62 * 62));
}

/// Asking for a density gives that, or less where there is no room.
#[test]
fn densities_are_kept_where_there_is_room() {
    let (scene, receivers) = built(two_rooms(true));
    let world = World::new(&scene);
    let with = |density, max_pages| {
        let settings =
            LayoutSettings { page_size: 128, max_pages, density: Density::TexelsPerMetre(density) };
        Layout::new(&scene, &world, receivers.iter().copied(), &settings)
    };
    let (roomy, tight) = (with(16.0, 4), with(16.0, 1));
    assert_eq!(roomy.texels_per_metre, 16.0);
    assert!(tight.texels_per_metre < 16.0 && tight.page_count == 1 && tight.refused.is_empty());
}

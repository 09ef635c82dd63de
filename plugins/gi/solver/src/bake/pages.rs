//! Texels on their pages.

use std::f32::consts::PI;

use glam::Vec3;

use super::Layout;

/// The pages of a layout from the irradiance of its texels: each `page_size * page_size` values E / π,
/// rows from the top. Texels in the neighbourhood of charts are filled from them; others are black.
#[must_use]
pub fn pages(layout: &Layout, irradiance: &[Vec3]) -> Vec<Vec<Vec3>> {
    let size = layout.page_size as usize;
    let mut pages = vec![vec![Vec3::ZERO; size * size]; layout.page_count as usize];
    let receivers = layout.patches.receivers.iter().zip(&layout.plans).zip(&layout.placements);
    for ((receiver, plan), place) in receivers {
        let first = receiver.first as usize;
        let mut texels = vec![Vec3::ZERO; (plan.width * plan.height) as usize];
        for (i, &at) in plan.place.iter().enumerate() {
            texels[at as usize] = irradiance[first + i] / PI;
        }
        plan.apply(&mut texels);
        // The plan's rectangle has a border of one texel around the placement.
        let page = &mut pages[place.page.0 as usize];
        for (y, row) in texels.chunks_exact(plan.width as usize).enumerate() {
            let start = (place.rect.y as usize + y - 1) * size + place.rect.x as usize - 1;
            page[start..start + row.len()].copy_from_slice(row);
        }
    }
    pages
}

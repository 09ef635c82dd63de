//! Second UV sets: the solver's unwrapper behind a form that fits Bevy's meshes.

use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

use farlight_gi_solver::{
    scene::Mesh,
    unwrap::{UnwrapOptions, Unwrapped, ensure_uv1_with},
};

/// Stops an unwrapping when the last copy but the task's own is dropped.
pub(crate) struct StopOnDrop(pub(crate) Arc<AtomicBool>);

impl Drop for StopOnDrop {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Checks the second UV set and makes one where it is missing, overlaps or tiles. Gutters between
/// charts are made for `texels_per_metre` of the mesh at its own scale.
pub(crate) fn second_uv_set(
    mesh: &Mesh,
    texels_per_metre: f32,
    stop: &AtomicBool,
) -> Result<Unwrapped, String> {
    let corner = |i: u32| mesh.positions[i as usize];
    let area: f32 = mesh
        .triangles
        .iter()
        .map(|&[a, b, c]| (corner(b) - corner(a)).cross(corner(c) - corner(a)).length() * 0.5)
        .sum();
    // Charts cover about half of their square.
    let texels = ((2.0 * area).sqrt() * texels_per_metre).clamp(16.0, 2048.0);
    let options = UnwrapOptions { texels: texels as u32, ..UnwrapOptions::default() };
    let go_on = || !stop.load(Ordering::Relaxed);
    ensure_uv1_with(mesh, &options, &go_on).map_err(|error| error.to_string())
}

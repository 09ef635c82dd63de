//! Keep, crop, pack anew, make, or leave out.

use std::borrow::Cow;

use farlight_gi_solver::{
    scene::Mesh,
    unwrap::{UnwrapError, UnwrapOptions, Unwrapped, charts, check_uv1, density, gutter, make_uv1},
};
use glam::{UVec2, Vec3, Vec3A};

use super::{
    SecondSet, UvCache, UvOptions, UvSet, cache,
    crop::{self, Bounds, Crop},
    facts::Facts,
    size::Sizes,
};

/// Largest spread of a set's texel density that is kept: 5 % of the surface have this many times the
/// texels a metre of another 5 %. Four times are two mip levels: where one part is right, the other
/// looks like a quarter of the resolution that was asked for. Authors give important parts up to
/// about twice the density on purpose, which stays.
const UNEVEN: f32 = 4.0;
/// Smallest distance between charts in texels that is kept: nearer ones share texels, whatever a bake
/// writes there.
const NEAREST: f32 = 1.0;
/// Texels along an edge of the square in which overlaps are looked for.
const OVERLAPS: u32 = 1024;

/// `None` if `go_on` was false.
pub(super) fn decide(
    facts: &Facts<'_>,
    options: &UvOptions,
    store: &dyn UvCache,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Option<SecondSet> {
    let left_out = |reason: String| SecondSet {
        set: UvSet::None { reason },
        vertices: facts.vertices.cloned(),
        sizes: Default::default(),
        texels_per_metre: 0.0,
        gutter: 0.0,
    };
    if facts.skinned {
        return Some(left_out("a skeleton moves it: it is lit by probes".into()));
    }
    let Some(sizes) = Sizes::of(facts.mesh, &facts.instances) else {
        return Some(left_out("the scene does not show it".into()));
    };
    let work = Work { facts, options, mesh: in_metres(facts.mesh, &sizes), sizes, go_on };
    let (set, size, found) = match work.own() {
        Own::Good { set, size, gutter } => (set, size, gutter),
        Own::Bad { why, .. } if facts.fixed => {
            return Some(left_out(format!(
                "a texture of its material is placed by the second UV set (TEXCOORD_1), which can't \
                 hold a lightmap: {why}. Place textures by the first set, then a second is made"
            )));
        }
        Own::Bad { why, repack } => match work.make(store, repack) {
            Ok(unwrapped) => {
                let (size, gutter) = (unwrapped.size, unwrapped.gutter);
                (UvSet::Made { unwrapped, why }, size, gutter)
            }
            Err(UnwrapError::Cancelled) => return None,
            Err(error) => return Some(left_out(error.to_string())),
        },
    };
    let uv1;
    let measured = match set.unwrapped() {
        Some(unwrapped) => {
            uv1 = unwrapped.apply(&work.mesh);
            &uv1
        }
        None => &work.mesh,
    };
    Some(SecondSet {
        texels_per_metre: density(measured, size).p50,
        gutter: (found * work.sizes.smallest()).min(options.padding as f32),
        sizes: work.sizes.texels(size),
        vertices: facts.vertices.cloned(),
        set,
    })
}

/// The mesh as large as its largest instance: texels are for metres there, whichever way it is scaled.
fn in_metres<'a>(mesh: &'a Mesh, sizes: &Sizes) -> Cow<'a, Mesh> {
    if sizes.linear == glam::Mat3A::IDENTITY {
        return Cow::Borrowed(mesh);
    }
    let mut mesh = mesh.clone();
    for p in &mut mesh.positions {
        *p = Vec3::from(sizes.linear * Vec3A::from(*p));
    }
    Cow::Owned(mesh)
}

struct Work<'a> {
    facts: &'a Facts<'a>,
    options: &'a UvOptions,
    /// In metres.
    mesh: Cow<'a, Mesh>,
    sizes: Sizes,
    go_on: &'a (dyn Fn() -> bool + Sync),
}

/// What is thought of the file's own set.
enum Own {
    Good { set: UvSet, size: UVec2, gutter: f32 },
    Bad { why: String, repack: bool },
}

impl Work<'_> {
    fn max_texels(&self) -> u32 {
        self.options.max_texels.clamp(8, 8192)
    }

    fn texels_per_metre(&self) -> f32 {
        // Beyond either end sizes are those of the ends anyway.
        self.options.texels_per_metre.clamp(1e-6, 1e9)
    }

    /// Texels at each border.
    fn margin(&self) -> f32 {
        (self.options.padding.div_ceil(2) as f32).clamp(1.0, self.max_texels() as f32 / 8.0)
    }

    fn own(&self) -> Own {
        let mesh = &*self.mesh;
        if let Err(problem) = check_uv1(mesh, OVERLAPS) {
            return Own::Bad { why: problem.to_string(), repack: false };
        }
        let found = density(mesh, UVec2::ONE);
        if found.spread() > UNEVEN && !self.facts.fixed {
            let why = format!(
                "some parts get {:.0} times as many texels a metre as others",
                found.spread()
            );
            return Own::Bad { why, repack: true };
        }
        let bounds = Bounds::of(mesh);
        let edge = self.texels_per_metre() / found.p50.max(1e-12);
        if self.facts.fixed {
            let size = UVec2::splat((edge.round() as u32).clamp(1, self.max_texels()));
            let gutter = gutter(mesh, &charts(mesh), size, self.options.padding as f32);
            let unwrapped = crop::unchanged(mesh, mesh.uv1.clone(), size);
            return Own::Good { set: self.same_vertices(unwrapped, true), size, gutter };
        }
        let crop = Crop::new(&bounds, edge, self.margin(), self.max_texels());
        let charts = charts(mesh);
        let square = UVec2::splat((crop.edge.round() as u32).max(1));
        let gutter = gutter(mesh, &charts, square, self.options.padding as f32);
        if gutter < NEAREST {
            let why = format!(
                "its charts are only {gutter:.1} texels apart at {square} texels: give islands a margin"
            );
            return Own::Bad { why, repack: true };
        }
        let unwrapped = crop.apply(mesh);
        let set = self.same_vertices(unwrapped, crop.is_identity(&bounds));
        Own::Good { set, size: crop.size, gutter }
    }

    /// A set on the mesh's own vertices, as the engine will have them.
    fn same_vertices(&self, mut unwrapped: Unwrapped, same_uvs: bool) -> UvSet {
        let mesh = self.facts.mesh;
        let flat = mesh.normals.is_empty() && !crop::is_split(mesh);
        if same_uvs && self.facts.vertices.is_none() && self.facts.floats && !flat {
            return UvSet::Kept;
        }
        if flat {
            crop::split(&mut unwrapped);
        }
        UvSet::Cropped { unwrapped }
    }

    fn make(&self, store: &dyn UvCache, repack: bool) -> Result<Unwrapped, UnwrapError> {
        // Gutters must hold in the smallest instance too.
        let padding = self.options.padding.clamp(1, 64) as f32 / self.sizes.smallest();
        let options = UnwrapOptions {
            texels: self.max_texels(),
            density: Some(self.texels_per_metre()),
            padding: padding.ceil() as u32,
            distortion: 1.5,
            thorough: true,
            max_time: std::time::Duration::from_secs(600),
            ..Default::default()
        };
        let numbers = [
            options.texels,
            self.texels_per_metre().to_bits(),
            options.padding,
            options.distortion.to_bits(),
            u32::from(repack),
        ];
        let key = cache::key(&self.mesh, &numbers);
        let kept = store.get(key).and_then(|bytes| cache::decode(&bytes, &self.mesh));
        let mut unwrapped = match kept {
            Some(unwrapped) => unwrapped,
            None => {
                let unwrapped = self.make_anew(&options, repack)?;
                store.put(key, &cache::encode(&unwrapped));
                unwrapped
            }
        };
        if self.mesh.normals.is_empty() {
            crop::split(&mut unwrapped);
        }
        Ok(unwrapped)
    }

    fn make_anew(&self, options: &UnwrapOptions, repack: bool) -> Result<Unwrapped, UnwrapError> {
        if repack {
            let unwrapped = make_uv1(&self.mesh, options, true, self.go_on)?;
            let spread = density(&unwrapped.apply(&self.mesh), unwrapped.size).spread();
            // Otherwise the charts themselves are uneven.
            if spread <= UNEVEN {
                return Ok(unwrapped);
            }
        }
        make_uv1(&self.mesh, options, false, self.go_on)
    }
}

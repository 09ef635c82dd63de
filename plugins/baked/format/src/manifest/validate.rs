//! What a manifest may say.

use std::collections::HashSet;

use glam::{Mat3, Vec3};

use super::{Light, LightKind, Manifest, ManifestError, Receiver, Scenario, VERSION, Volume};
use crate::name;

/// Longest edge of a page in texels: what every desktop GPU takes.
pub const PAGE_SIZE: u32 = 8192;
/// Most pages of a scenario.
pub const MOST_PAGES: u32 = 1024;
/// Most probes of a volume.
pub const MOST_PROBES: u64 = 1 << 22;
/// Longest side of a volume's texture: what WebGPU promises for 3D textures.
pub const VOLUME_TEXELS: u32 = 2048;

type Checked = Result<(), ManifestError>;

impl Manifest {
    /// Checks that everything is in its range and that indices and counts fit each other.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn validate(&self) -> Checked {
        if self.version != VERSION {
            return Err(ManifestError::Version { found: self.version });
        }
        file("scene", &self.scene, ".glb")?;
        positive("settings.scale", self.settings.scale)?;
        not_negative("settings.texels_per_metre", [self.settings.texels_per_metre])?;
        ensure(self.pages <= MOST_PAGES, "pages", || {
            format!("{} pages are more than {MOST_PAGES}", self.pages)
        })?;
        let least = self.pages.min(1);
        ensure((least..=PAGE_SIZE).contains(&self.page_size), "page_size", || {
            format!("{} is not {least} to {PAGE_SIZE}", self.page_size)
        })?;
        self.primitives()?;
        for (at, volume) in self.volumes.iter().enumerate() {
            volume.validate().map_err(|error| error.within(&format!("volumes[{at}]")))?;
        }
        ensure(!self.scenarios.is_empty(), "scenarios", || "there is none".to_owned())?;
        let mut names = HashSet::new();
        for (at, scenario) in self.scenarios.iter().enumerate() {
            let within = |error: ManifestError| error.within(&format!("scenarios[{at}]"));
            ensure(names.insert(&scenario.name), "name", || {
                format!("{:?} is the name of another scenario", scenario.name)
            })
            .and_then(|()| scenario.validate(self))
            .map_err(within)?;
        }
        Ok(())
    }

    /// Receivers, and what was left out: no primitive twice.
    fn primitives(&self) -> Checked {
        let mut seen = HashSet::new();
        for (at, receiver) in self.receivers.iter().enumerate() {
            receiver
                .validate(self)
                .and_then(|()| {
                    let new = seen.insert((receiver.node, receiver.primitive));
                    ensure(new, "primitive", || twice(receiver.node, receiver.primitive))
                })
                .map_err(|error| error.within(&format!("receivers[{at}]")))?;
        }
        for (at, left_out) in self.left_out.iter().enumerate() {
            let new = seen.insert((left_out.node, left_out.primitive));
            ensure(new, "primitive", || twice(left_out.node, left_out.primitive))
                .map_err(|error| error.within(&format!("left_out[{at}]")))?;
        }
        Ok(())
    }
}

impl Receiver {
    fn validate(&self, manifest: &Manifest) -> Checked {
        ensure(self.page < manifest.pages, "page", || {
            format!("there is no page {}, only {}", self.page, manifest.pages)
        })?;
        let [x, y, width, height] = self.rect;
        let inside = |start: u32, side: u32| {
            side > 0 && start.checked_add(side).is_some_and(|end| end <= manifest.page_size)
        };
        ensure(inside(x, width) && inside(y, height), "rect", || {
            format!(
                "({x}, {y}, {width}, {height}) is no rectangle of a page of {} texels",
                manifest.page_size
            )
        })
    }
}

impl Volume {
    fn validate(&self) -> Checked {
        let [x, y, z, translation] = self.transform.map(Vec3::from);
        let finite = [x, y, z, translation].iter().all(|column| column.is_finite());
        // Every side has a length, and they are not in one plane.
        let volume = Mat3::from_cols(x, y, z).determinant();
        ensure(finite && volume.is_normal(), "transform", || {
            "is not the transform of a box".to_owned()
        })?;
        let [nx, ny, nz] = self.resolution;
        let sides = [nx, ny.saturating_mul(2), nz.saturating_mul(3)];
        let fits = sides.iter().all(|side| (1..=VOLUME_TEXELS).contains(side));
        // Sides that fit have a product that does.
        let few = || self.resolution.map(u64::from).iter().product::<u64>() <= MOST_PROBES;
        ensure(fits && few(), "resolution", || {
            format!(
                "{nx} x {ny} x {nz} probes are none, more than {MOST_PROBES}, or their texture of {} x \
                 {} x {} has a side of more than {VOLUME_TEXELS}",
                sides[0], sides[1], sides[2]
            )
        })
    }
}

impl Scenario {
    fn validate(&self, manifest: &Manifest) -> Checked {
        ensure(!self.name.is_empty(), "name", || "it has none".to_owned())?;
        count("pages", self.pages.len(), manifest.pages as usize, "pages")?;
        for (at, page) in self.pages.iter().enumerate() {
            file(&format!("pages[{at}].ktx2"), &page.ktx2, ".ktx2")?;
            if !page.exr.is_empty() {
                file(&format!("pages[{at}].exr"), &page.exr, ".exr")?;
            }
        }
        count("volumes", self.volumes.len(), manifest.volumes.len(), "volumes")?;
        for (at, volume) in self.volumes.iter().enumerate() {
            file(&format!("volumes[{at}]"), volume, ".ktx2")?;
        }
        let mut nodes = HashSet::new();
        for (at, light) in self.lights.iter().enumerate() {
            let new = light.node.is_none_or(|node| nodes.insert(node));
            ensure(new, "node", || "another light has the same".to_owned())
                .and_then(|()| light.validate())
                .map_err(|error| error.within(&format!("lights[{at}]")))?;
        }
        not_negative("sky", self.sky)?;
        not_negative("relative_error", [self.relative_error])
    }
}

impl Light {
    fn validate(&self) -> Checked {
        ensure(Vec3::from(self.position).is_finite(), "position", || not_finite(&self.position))?;
        let direction = Vec3::from(self.direction);
        ensure(direction.is_finite(), "direction", || not_finite(&self.direction))?;
        let directed = !matches!(self.kind, LightKind::Point);
        ensure(!directed || (direction.length() - 1.0).abs() < 1e-3, "direction", || {
            format!("{:?} is not of length 1", self.direction)
        })?;
        if let LightKind::Spot { inner, outer } = self.kind {
            let ordered = 0.0 <= inner && inner <= outer && outer <= std::f32::consts::FRAC_PI_2;
            ensure(ordered, "kind", || {
                format!("0 <= inner <= outer <= π/2 is not so for {inner} and {outer}")
            })?;
        }
        not_negative("intensity", self.intensity)?;
        not_negative("range", [self.range])?;
        not_negative("radius", [self.radius])
    }
}

impl ManifestError {
    /// The same error, of a field of a field.
    fn within(self, outer: &str) -> Self {
        match self {
            Self::Field { field, problem } => {
                Self::Field { field: format!("{outer}.{field}"), problem }
            }
            other => other,
        }
    }
}

fn ensure(good: bool, field: &str, problem: impl FnOnce() -> String) -> Checked {
    if good {
        Ok(())
    } else {
        Err(ManifestError::Field { field: field.to_owned(), problem: problem() })
    }
}

fn positive(field: &str, value: f32) -> Checked {
    ensure(value.is_finite() && value > 0.0, field, || format!("{value} is not above 0"))
}

fn not_negative<const N: usize>(field: &str, values: [f32; N]) -> Checked {
    match values.into_iter().find(|value| !(value.is_finite() && *value >= 0.0)) {
        Some(value) => ensure(false, field, || format!("{value} is not 0 or more")),
        None => Ok(()),
    }
}

fn not_finite(values: &[f32]) -> String {
    format!("{values:?} is not finite")
}

fn file(field: &str, text: &str, end: &str) -> Checked {
    let plain = name::is_plain(text) && text.len() > end.len() && text.ends_with(end);
    ensure(plain, field, || format!("{text:?} is not the plain name of a {end} file"))
}

fn count(field: &str, found: usize, expected: usize, what: &str) -> Checked {
    ensure(found == expected, field, || {
        format!("it has {found} {what}, the manifest says {expected}")
    })
}

fn twice(node: u32, primitive: u32) -> String {
    format!("primitive {primitive} of node {node} comes twice")
}

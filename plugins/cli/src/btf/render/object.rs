//! Objects to show a material on, by formula: no meshes, no triangles at the silhouette.
//!
//! Right-handed, y up. All fit into a sphere of radius 1.5 round the origin; the picture's columns run
//! to the right and its rows down, seen from outside.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

/// What carries the material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Shape {
    /// Of radius 1
    Sphere,
    /// A square of side 2 that stands upright and faces azimuth 0
    Plane,
    /// Upright, of radius 0.8 and height 2
    Cylinder,
    /// A curtain of width and height 2.4 whose folds shadow each other
    Cloth,
}

/// A ray with a unit direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    pub(super) origin: Vec3,
    pub(super) direction: Vec3,
}

impl Ray {
    fn at(&self, t: f32) -> Vec3 {
        self.origin + t * self.direction
    }
}

/// A point of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    pub(super) position: Vec3,
    /// To the picture's right, along the columns.
    pub(super) tangent: Vec3,
    /// To the picture's top: azimuth 90 degrees points to decreasing row.
    pub(super) bitangent: Vec3,
    pub(super) normal: Vec3,
    /// Place in the picture in units of length, from its left and top.
    pub(super) place: Vec2,
}

impl Hit {
    /// Tangent and normal are made orthonormal.
    fn new(position: Vec3, tangent: Vec3, normal: Vec3, place: Vec2) -> Self {
        let normal = normal.normalize();
        let tangent = (tangent - normal * normal.dot(tangent)).normalize();
        Self { position, tangent, bitangent: normal.cross(tangent), normal, place }
    }

    /// A direction in the frame of the surface.
    pub(super) fn local(&self, world: Vec3) -> Vec3 {
        Vec3::new(world.dot(self.tangent), world.dot(self.bitangent), world.dot(self.normal))
    }

    /// A direction in the world.
    pub(super) fn world(&self, local: Vec3) -> Vec3 {
        local.x * self.tangent + local.y * self.bitangent + local.z * self.normal
    }
}

impl Shape {
    /// Radius of a sphere round the origin that holds the object.
    pub(super) fn radius(self) -> f32 {
        match self {
            Self::Sphere => 1.0,
            Self::Plane => 1.2,
            Self::Cylinder => 1.29,
            Self::Cloth => 1.4,
        }
    }

    /// What places are to be multiplied by for a picture of this width: objects that close on themselves
    /// get a whole number of pictures round them, so that no seam shows.
    pub(super) fn scale(self, width: f32) -> f32 {
        let round = |length: f32| (length / width).round().max(1.0) * width / length;
        match self {
            Self::Sphere => round(TAU),
            Self::Cylinder => round(TAU * CYLINDER_RADIUS),
            Self::Plane | Self::Cloth => 1.0,
        }
    }

    /// The closest point of its outer side.
    pub(super) fn hit(self, ray: &Ray) -> Option<Hit> {
        match self {
            Self::Sphere => sphere(ray),
            Self::Plane => plane(ray),
            Self::Cylinder => cylinder(ray),
            Self::Cloth => cloth(ray),
        }
    }

    /// Whether the object itself keeps light from one of its points.
    pub(super) fn shadows(self, hit: &Hit, light: Vec3) -> bool {
        // The others are convex.
        self == Self::Cloth
            && march(&Ray { origin: hit.position + 1e-3 * hit.normal, direction: light }).is_some()
    }
}

fn sphere(ray: &Ray) -> Option<Hit> {
    let b = ray.origin.dot(ray.direction);
    let root = b * b - (ray.origin.length_squared() - 1.0);
    let t = -b - (root >= 0.0).then(|| root.sqrt())?;
    (t > 0.0).then(|| {
        let p = ray.at(t).normalize();
        let azimuth = p.x.atan2(p.z);
        let latitude = p.y.clamp(-1.0, 1.0).asin();
        // Any tangent will do at the very pole.
        let tangent = Vec3::new(azimuth.cos(), 0.0, -azimuth.sin());
        Hit::new(p, tangent, p, Vec2::new(azimuth + PI, PI / 2.0 - latitude))
    })
}

fn plane(ray: &Ray) -> Option<Hit> {
    let t = -ray.origin.z / ray.direction.z;
    let p = ray.at(t);
    (t > 0.0 && ray.direction.z < 0.0 && p.x.abs() <= 1.0 && p.y.abs() <= 1.0)
        .then(|| Hit::new(p, Vec3::X, Vec3::Z, Vec2::new(p.x + 1.0, 1.0 - p.y)))
}

const CYLINDER_RADIUS: f32 = 0.8;

fn cylinder(ray: &Ray) -> Option<Hit> {
    let flat = |v: Vec3| Vec2::new(v.x, v.z);
    let (o, d) = (flat(ray.origin), flat(ray.direction));
    let a = d.length_squared();
    let b = o.dot(d);
    let root = b * b - a * (o.length_squared() - CYLINDER_RADIUS * CYLINDER_RADIUS);
    if root >= 0.0 && a > 0.0 {
        let t = (-b - root.sqrt()) / a;
        let p = ray.at(t);
        if t > 0.0 && p.y.abs() <= 1.0 {
            let azimuth = p.x.atan2(p.z);
            let tangent = Vec3::new(azimuth.cos(), 0.0, -azimuth.sin());
            let place = Vec2::new((azimuth + PI) * CYLINDER_RADIUS, 1.0 - p.y);
            return Some(Hit::new(p, tangent, Vec3::new(p.x, 0.0, p.z), place));
        }
    }
    // The lids: rows run down, so towards the viewer on the upper one.
    let top = if ray.direction.y < 0.0 { 1.0 } else { -1.0 };
    let t = (top - ray.origin.y) / ray.direction.y;
    let p = ray.at(t);
    (t > 0.0 && flat(p).length() <= CYLINDER_RADIUS)
        .then(|| Hit::new(p, Vec3::X, top * Vec3::Y, Vec2::new(p.x + 1.0, top * p.z + 1.0)))
}

const CLOTH_HALF: f32 = 1.2;
/// Most that the curtain comes forward or goes back.
const CLOTH_DEPTH: f32 = 0.2;

/// How far forward the curtain is: folds that fan out a little towards the hem.
fn fold(x: f32, y: f32) -> f32 {
    let down = (CLOTH_HALF - y) / (2.0 * CLOTH_HALF);
    let depth = CLOTH_DEPTH * (0.45 + 0.55 * down);
    let phase = 7.5 * x + 0.7 * (2.1 * x + 1.0).sin() + 0.5 * (1.3 * y).sin();
    depth * (0.8 * phase.sin() + 0.2 * (2.0 * phase + 1.0 + y).sin())
}

/// Slopes of [`fold`].
fn slope(x: f32, y: f32) -> Vec2 {
    const STEP: f32 = 1e-3;
    let along = |dx: f32, dy: f32| fold(x + dx, y + dy) - fold(x - dx, y - dy);
    Vec2::new(along(STEP, 0.0), along(0.0, STEP)) / (2.0 * STEP)
}

/// Where a ray first passes through the curtain.
fn march(ray: &Ray) -> Option<f32> {
    const STEPS: usize = 160;
    // The box round it.
    let half = Vec3::new(CLOTH_HALF, CLOTH_HALF, CLOTH_DEPTH);
    let inverse = ray.direction.recip();
    let (a, b) = ((-half - ray.origin) * inverse, (half - ray.origin) * inverse);
    let near = a.min(b).max_element().max(0.0);
    let far = a.max(b).min_element();
    if near.partial_cmp(&far) != Some(std::cmp::Ordering::Less) {
        return None;
    }
    let above = |t: f32| {
        let p = ray.at(t);
        p.z - fold(p.x, p.y)
    };
    let step = (far - near) / STEPS as f32;
    let (mut from, mut height) = (near, above(near));
    for at in 1..=STEPS {
        let to = near + step * at as f32;
        let next = above(to);
        if (height > 0.0) != (next > 0.0) {
            let mut to = to;
            for _ in 0..20 {
                let middle = 0.5 * (from + to);
                if (above(middle) > 0.0) == (height > 0.0) { from = middle } else { to = middle }
            }
            return Some(to);
        }
        (from, height) = (to, next);
    }
    None
}

fn cloth(ray: &Ray) -> Option<Hit> {
    let p = ray.at(march(ray)?);
    let slope = slope(p.x, p.y);
    let normal = Vec3::new(-slope.x, -slope.y, 1.0);
    let tangent = Vec3::new(1.0, 0.0, slope.x);
    // The back shows the material too.
    let side = if normal.dot(ray.direction) < 0.0 { 1.0 } else { -1.0 };
    Some(Hit::new(p, side * tangent, side * normal, Vec2::new(side * length(p.x, p.y), 1.2 - p.y)))
}

/// Length of the curtain from its left edge along a horizontal line.
fn length(x: f32, y: f32) -> f32 {
    const STEPS: usize = 64;
    let step = (x + CLOTH_HALF) / STEPS as f32;
    let (mut from, mut sum) = (fold(-CLOTH_HALF, y), 0.0);
    for at in 1..=STEPS {
        let to = fold(step * at as f32 - CLOTH_HALF, y);
        sum += step.hypot(to - from);
        from = to;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPES: [Shape; 4] = [Shape::Sphere, Shape::Plane, Shape::Cylinder, Shape::Cloth];

    fn ray(azimuth: f32, elevation: f32, aside: Vec2) -> Ray {
        let towards = super::super::direction(azimuth, elevation);
        let right = Vec3::Y.cross(towards).normalize();
        let origin = 5.0 * towards + aside.x * right + aside.y * towards.cross(right);
        Ray { origin, direction: -towards }
    }

    /// The place in the picture grows along the tangent and falls along the bitangent, one unit a unit
    /// of length: the picture is neither mirrored, upside down nor stretched.
    #[test]
    fn frames_follow_the_picture() {
        for shape in SHAPES {
            for (azimuth, elevation) in [(5.0, 3.0), (-35.0, 20.0), (20.0, -30.0)] {
                let ray = ray(azimuth, elevation, Vec2::new(0.11, 0.07));
                let hit = shape.hit(&ray).unwrap();
                assert!(hit.normal.dot(ray.direction) < 0.0, "{shape:?}");
                assert!(hit.tangent.cross(hit.bitangent).distance(hit.normal) < 1e-4);
                let moved = |by: Vec3| {
                    let target = hit.position + by;
                    let direction = (target - ray.origin).normalize();
                    shape.hit(&Ray { direction, ..ray }).unwrap().place - hit.place
                };
                let step = 0.004;
                let right = moved(hit.tangent * step) / step;
                let up = moved(hit.bitangent * step) / step;
                assert!(right.x > 0.8 && right.x < 1.3, "{shape:?}: {right}");
                assert!(right.y.abs() < 0.2, "{shape:?}: {right}");
                assert!(up.y < -0.8 && up.y > -1.3, "{shape:?}: {up}");
                // A curtain that fans out shears its picture a little.
                assert!(
                    up.x.abs() < if shape == Shape::Cloth { 0.5 } else { 0.2 },
                    "{shape:?}: {up}"
                );
            }
        }
    }

    #[test]
    fn only_the_curtain_shadows_itself() {
        let hit = |shape: Shape, aside| shape.hit(&ray(0.0, 0.0, aside)).unwrap();
        let mut dark = 0;
        for at in 0..200 {
            let aside = Vec2::new(at as f32 / 100.0 - 1.0, 0.1);
            let light = super::super::direction(80.0, 5.0);
            dark += usize::from(Shape::Cloth.shadows(&hit(Shape::Cloth, aside), light));
            assert!(!Shape::Cloth.shadows(&hit(Shape::Cloth, aside), Vec3::Z), "{aside}");
        }
        assert!((40..180).contains(&dark), "{dark} of 200");
        assert!(!Shape::Sphere.shadows(&hit(Shape::Sphere, Vec2::ZERO), Vec3::Z));
    }

    #[test]
    fn rays_that_pass_by_hit_nothing() {
        for shape in SHAPES {
            assert!(shape.hit(&ray(10.0, 10.0, Vec2::new(3.0, 0.0))).is_none(), "{shape:?}");
            let behind = Ray { origin: Vec3::new(0.0, 0.0, 9.0), direction: Vec3::Z };
            assert!(shape.hit(&behind).is_none(), "{shape:?}");
        }
    }
}

//! From hits to texels.

use glam::{Vec2, Vec3};

use super::Layout;
use crate::{
    Hit, Ray, World,
    lightmap::{NONE, SurfacePoint, barycentric},
};

/// Triangles with more texels a square metre have next to no area: nothing is known about them.
const MOST_DENSE: f32 = 1e12;

/// Normals of a texel's point and of what it answers for agree within this cosine.
const ALIKE: f32 = 0.7;

/// Whether light at a surface says something about light at another beside it.
pub(super) fn alike(a: Vec3, b: Vec3) -> bool {
    a.dot(b) > ALIKE
}

/// Which texel shows the front of a surface at a hit.
pub(super) struct TexelMap {
    triangles: Vec<Triangle>,
}

/// All that is asked about a triangle, in one place of memory.
#[derive(Clone, Copy)]
struct Triangle {
    /// Corners in texels of its receiver's rectangle.
    corners: [Vec2; 3],
    /// Texels a square metre.
    density: f32,
    receiver: u32,
    chart: u32,
}

/// A texel that a ray met.
#[derive(Clone, Copy, Debug)]
pub(super) struct Met {
    pub(super) texel: u32,
    /// The triangle of the world.
    pub(super) triangle: u32,
    /// The way there.
    pub(super) way: Vec3,
    /// Whether the point lies in the texel itself, not beside a chart's last texel.
    pub(super) exact: bool,
    /// Texels a square metre there.
    pub(super) density: f32,
    /// Distance in metres.
    pub(super) distance: f32,
    /// Cosine of the angle between the surface's normal and the direction back.
    pub(super) cos: f32,
}

impl Met {
    /// Density per solid angle of the met point, for one texel in the unit square of each texel.
    pub(super) fn solid_angle_pdf(&self) -> f32 {
        self.density * self.distance * self.distance / self.cos
    }
}

impl TexelMap {
    pub(super) fn new(world: &World, layout: &Layout) -> Self {
        let nothing =
            Triangle { corners: [Vec2::ZERO; 3], density: 0.0, receiver: NONE, chart: NONE };
        let mut triangles = vec![nothing; world.triangle_count()];
        for (index, receiver) in layout.patches.receivers.iter().enumerate() {
            let instance = &world.instances()[receiver.instance as usize];
            let texels = &receiver.texels;
            let size = Vec2::new(texels.width as f32, texels.height as f32);
            for (i, corners) in instance.mesh.triangles.iter().enumerate() {
                let corners = corners.map(|v| instance.mesh.uv1[v as usize] * size);
                let triangle = instance.first_triangle as usize + i;
                let area = |a: f32, b: f32| if b > 0.0 { a.abs() / b } else { 0.0 };
                let [a, b, c] = world.corners(triangle as u32);
                let density = area(
                    (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]),
                    (b - a).cross(c - a).length(),
                );
                let usable = density > 0.0 && density < MOST_DENSE;
                let receiver = if usable { index as u32 } else { NONE };
                triangles[triangle] =
                    Triangle { corners, density, receiver, chart: texels.triangle_chart[i] };
            }
        }
        Self { triangles }
    }

    /// The texel that a ray met: `None` for backs, for surfaces without texels, and where the surface turns so
    /// much within the texel that its light says nothing about the point.
    pub(super) fn meet(&self, world: &World, layout: &Layout, ray: &Ray, hit: &Hit) -> Option<Met> {
        let triangle = &self.triangles[hit.triangle as usize];
        if triangle.receiver == NONE {
            return None;
        }
        let normal = world.normal(hit.triangle);
        let cos = -normal.dot(ray.direction);
        if cos <= 1e-6 {
            return None;
        }
        let [a, b, c] = triangle.corners;
        let p = a + (b - a) * hit.u + (c - a) * hit.v;
        let receiver = &layout.patches.receivers[triangle.receiver as usize];
        let texels = &receiver.texels;
        let own = texels.at(p.x.floor() as i64, p.y.floor() as i64, triangle.chart);
        let found = own.or_else(|| {
            let first = world.instances()[receiver.instance as usize].first_triangle;
            texels.lookup(
                hit.triangle - first,
                p / Vec2::new(texels.width as f32, texels.height as f32),
            )
        })?;
        let texel = receiver.first + found;
        alike(normal, layout.patches.normal[texel as usize]).then_some(Met {
            texel,
            triangle: hit.triangle,
            way: ray.direction * hit.t,
            exact: own.is_some(),
            density: triangle.density,
            distance: hit.t,
            cos,
        })
    }

    /// The point at a place in a texel, 0..1 along both axes, as a ray from `origin` would meet it.
    /// `None` where the texel is not covered, where it would not be [met](Self::meet), or from behind.
    pub(super) fn point(
        &self,
        world: &World,
        layout: &Layout,
        texel: u32,
        place: Vec2,
        origin: Vec3,
    ) -> Option<Met> {
        let SurfacePoint { triangle, bary } = self.point_in(world, layout, texel, place)?;
        let [a, b, c] = world.corners(triangle);
        let way = a + (b - a) * bary.x + (c - a) * bary.y - origin;
        let distance = way.length();
        let normal = world.normal(triangle);
        let cos = -normal.dot(way) / distance;
        let usable = cos > 1e-6 && alike(normal, layout.patches.normal[texel as usize]);
        let density = self.triangles[triangle as usize].density;
        let met = Met { texel, triangle, way, exact: true, density, distance, cos };
        (usable && density > 0.0).then_some(met)
    }

    /// The surface point at a place in a texel, with the world's triangle; `None` where the texel is not
    /// covered.
    pub(super) fn point_in(
        &self,
        world: &World,
        layout: &Layout,
        texel: u32,
        place: Vec2,
    ) -> Option<SurfacePoint> {
        let receiver = layout.receiver_of(texel);
        let first = world.instances()[receiver.instance as usize].first_triangle;
        let inside = (texel - receiver.first) as usize;
        let [x, y] = receiver.texels.coords[inside].map(f32::from);
        let at = Vec2::new(x, y) + place;
        receiver.texels.triangles_in(inside).iter().find_map(|triangle| {
            let triangle = first + triangle;
            let bary = barycentric(&self.triangles[triangle as usize].corners, at)?;
            Some(SurfacePoint { triangle, bary })
        })
    }
}

//! Pictures of all directions that are not equirectangular: cubes and angular maps.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use crate::layout::{Cube, Shape};

/// Texels of smaller pictures are too large to take their solid angle from their middles.
const FINE_EDGE: usize = 512;

/// A picture's geometry.
#[derive(Clone, Copy)]
pub(crate) struct Projection {
    kind: Kind,
    pub(crate) width: usize,
    pub(crate) height: usize,
}

#[derive(Clone, Copy)]
enum Kind {
    Angular,
    Cube { cube: Cube, edge: usize },
}

impl Projection {
    /// None for an equirectangular picture.
    pub(crate) fn new(shape: Shape, [width, height]: [usize; 2]) -> Option<Self> {
        let kind = match shape {
            Shape::Equirect => return None,
            Shape::Angular => Kind::Angular,
            Shape::Cube(cube) => Kind::Cube { cube, edge: width / cube.squares()[0] as usize },
        };
        Some(Self { kind, width, height })
    }

    /// Texels from straight up to straight down.
    pub(crate) fn rows_round(&self) -> usize {
        match self.kind {
            Kind::Angular => self.width / 2,
            Kind::Cube { edge, .. } => 2 * edge,
        }
    }

    /// Solid angle of a texel; 0 where the picture shows nothing.
    pub(crate) fn solid_angle(&self, x: usize, y: usize) -> f64 {
        match self.kind {
            Kind::Angular => {
                let step = 2.0 / self.width as f64;
                // r dr dphi of the disk are sin(pi r) pi dr dphi of the sphere.
                let density = |part: DVec2| match ((DVec2::new(x as f64, y as f64) + part) * step
                    - 1.0)
                    .length()
                {
                    r if r >= 1.0 => 0.0,
                    r if r < 1e-9 => PI * PI,
                    r => PI * (PI * r).sin() / r,
                };
                let corner = DVec2::new(x as f64, y as f64) * step - 1.0;
                let mean = if self.width > FINE_EDGE && (corner + 0.5 * step).length() + step < 1.0
                {
                    density(DVec2::splat(0.5))
                } else {
                    // Parts of a texel, because the circle cuts some.
                    let part = |at| DVec2::new(f64::from(at % 4), f64::from(at / 4)) * 0.25 + 0.125;
                    (0..16).map(|at| density(part(at))).sum::<f64>() / 16.0
                };
                mean * step * step
            }
            Kind::Cube { cube, edge } => {
                if face_at(cube, edge, x, y).is_none() {
                    return 0.0;
                }
                let at = |i: usize| 2.0 * (i % edge) as f64 / edge as f64 - 1.0;
                let (s, t, step) = (at(x), at(y), 2.0 / edge as f64);
                if edge > FINE_EDGE {
                    let middle = DVec2::new(s, t) + 0.5 * step;
                    return step * step * (1.0 + middle.length_squared()).powf(-1.5);
                }
                // Solid angle of the rectangle from the middle of the face to a corner.
                let corner = |s: f64, t: f64| (s * t).atan2((1.0 + s * s + t * t).sqrt());
                let [right, below] = [s + step, t + step];
                corner(right, below) - corner(s, below) - corner(right, t) + corner(s, t)
            }
        }
    }

    /// The middle of a texel that shows something.
    pub(crate) fn direction(&self, x: usize, y: usize) -> DVec3 {
        match self.kind {
            Kind::Angular => {
                let at =
                    DVec2::new(x as f64 + 0.5, y as f64 + 0.5) * (2.0 / self.width as f64) - 1.0;
                let (sin, cos) = (PI * at.length().min(1.0)).sin_cos();
                let out = at.normalize_or_zero() * sin;
                DVec3::new(out.x, -out.y, -cos)
            }
            Kind::Cube { cube, edge } => {
                let face = face_at(cube, edge, x, y).unwrap_or(0);
                let at = |i: usize| (2.0 * (i % edge) as f64 + 1.0) / edge as f64 - 1.0;
                let (mut s, mut t) = (at(x), at(y));
                if cube.is_turned(face) {
                    (s, t) = (-s, -t);
                }
                from_face(face, s, t).normalize()
            }
        }
    }

    /// The texel in a direction.
    pub(crate) fn texel(&self, direction: DVec3) -> usize {
        let cell = |at: f64, count: usize| {
            ((0.5 * (at + 1.0) * count as f64).max(0.0) as usize).min(count - 1)
        };
        let (x, y) = match self.kind {
            Kind::Angular => {
                let out = DVec2::new(direction.x, -direction.y);
                let angle = out.length().atan2(-direction.z);
                let at = out.try_normalize().unwrap_or(DVec2::X) * (angle / PI);
                (cell(at.x, self.width), cell(at.y, self.height))
            }
            Kind::Cube { cube, edge } => {
                let (face, mut s, mut t) = to_face(direction);
                if cube.is_turned(face) {
                    (s, t) = (-s, -t);
                }
                let [column, row] = cube.square(face).map(|at| at as usize);
                (column * edge + cell(s, edge), row * edge + cell(t, edge))
            }
        };
        y * self.width + x
    }
}

/// The face that a texel of a picture of a cube lies on.
fn face_at(cube: Cube, edge: usize, x: usize, y: usize) -> Option<usize> {
    let square = [(x / edge) as u32, (y / edge) as u32];
    (0..6).find(|face| cube.square(*face) == square)
}

/// The direction of a point of a face, -1 to 1 to the right and down.
///
/// Vulkan 1.3, "Cube Map Face Selection", whose frame is left-handed: seen from within, its +Z is ahead,
/// +X right and +Y up. Ahead is -z here, as Bevy's skybox has it.
fn from_face(face: usize, s: f64, t: f64) -> DVec3 {
    match face {
        0 => DVec3::new(1.0, -t, s),
        1 => DVec3::new(-1.0, -t, -s),
        2 => DVec3::new(s, 1.0, -t),
        3 => DVec3::new(s, -1.0, t),
        4 => DVec3::new(s, -t, -1.0),
        _ => DVec3::new(-s, -t, 1.0),
    }
}

/// The face in a direction, and where on it.
fn to_face(d: DVec3) -> (usize, f64, f64) {
    let size = d.abs();
    if size.x >= size.y && size.x >= size.z {
        if d.x > 0.0 { (0, d.z / size.x, -d.y / size.x) } else { (1, -d.z / size.x, -d.y / size.x) }
    } else if size.y >= size.z {
        if d.y > 0.0 { (2, d.x / size.y, -d.z / size.y) } else { (3, d.x / size.y, d.z / size.y) }
    } else if d.z < 0.0 {
        (4, d.x / size.z, -d.y / size.z)
    } else {
        (5, -d.x / size.z, -d.y / size.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPES: [(Shape, [usize; 2]); 5] = [
        (Shape::Angular, [48, 48]),
        (Shape::Cube(Cube::LyingCross), [48, 36]),
        (Shape::Cube(Cube::StandingCross), [36, 48]),
        (Shape::Cube(Cube::Row), [72, 12]),
        (Shape::Cube(Cube::Column), [12, 72]),
    ];

    #[test]
    fn texels_cover_the_sphere_and_lie_where_they_say() {
        for (shape, size) in SHAPES {
            let projection = Projection::new(shape, size).unwrap();
            let mut whole = 0.0;
            for at in 0..size[0] * size[1] {
                let (x, y) = (at % size[0], at / size[0]);
                let solid_angle = projection.solid_angle(x, y);
                whole += solid_angle;
                // Of a texel that the circle of an angular map cuts the middle may lie outside.
                if solid_angle > 0.0 && (shape != Shape::Angular || solid_angle > 1e-3) {
                    assert_eq!(projection.texel(projection.direction(x, y)), at, "{shape:?}");
                }
            }
            // Exact for cubes; the circle is cut into quarters of texels.
            let tolerance = if shape == Shape::Angular { 2e-3 } else { 1e-12 };
            assert!((whole / (4.0 * PI) - 1.0).abs() < tolerance, "{shape:?}: {whole}");
        }
    }

    #[test]
    fn neighbours_in_a_cross_are_neighbours_on_the_sphere() {
        for (shape, size) in &SHAPES[1..3] {
            let projection = Projection::new(*shape, *size).unwrap();
            let seen = |x: usize, y: usize| projection.solid_angle(x, y) > 0.0;
            for at in 0..size[0] * size[1] {
                let (x, y) = (at % size[0], at / size[0]);
                for (x1, y1) in [(x + 1, y), (x, y + 1)] {
                    if x1 < size[0] && y1 < size[1] && seen(x, y) && seen(x1, y1) {
                        let angle =
                            projection.direction(x, y).angle_between(projection.direction(x1, y1));
                        // Texels in the middle of a face are 2 / 12 wide.
                        assert!(angle < 0.17, "{shape:?} {x} {y}: {angle}");
                    }
                }
            }
        }
    }

    #[test]
    fn ahead_is_the_middle_and_right_is_right() {
        let at = |shape, size, direction| {
            let projection = Projection::new(shape, size).unwrap();
            let texel = projection.texel(direction);
            (texel % size[0], texel / size[0])
        };
        let ahead_right_up = DVec3::new(0.2, 0.3, -1.0);
        let (x, y) = at(Shape::Angular, [100, 100], ahead_right_up);
        assert!((51..60).contains(&x) && (40..48).contains(&y), "{x} {y}");
        // To the right, at a quarter of the way round: halfway out.
        let (x, y) = at(Shape::Angular, [100, 100], DVec3::new(1.0, 0.01, -0.01));
        assert!((73..77).contains(&x) && (48..52).contains(&y), "{x} {y}");
        // The face ahead is the second square of the middle row, then comes the right one.
        let (x, y) = at(Shape::Cube(Cube::LyingCross), [400, 300], ahead_right_up);
        assert!((150..170).contains(&x) && (130..150).contains(&y), "{x} {y}");
        let (x, y) = at(Shape::Cube(Cube::LyingCross), [400, 300], DVec3::new(1.0, 0.1, 0.1));
        assert!((250..260).contains(&x) && (140..150).contains(&y), "{x} {y}");
    }
}

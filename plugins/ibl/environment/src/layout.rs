//! How a picture shows all directions.

use std::{fmt, str::FromStr};

use serde::{Deserialize, Serialize};

use crate::{EnvironmentError, UnknownName};

/// How a picture shows all directions. In each of them the map's frame is right-handed with y up,
/// and straight ahead is -z.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Layout {
    /// By the shape of the picture: 2:1 is equirectangular, 1:1 is angular (a KTX2 file is a cube),
    /// 4:3, 3:4, 6:1 and 1:6 are cubes. Anything else is an error.
    #[default]
    Auto,
    /// Longitude and latitude: `u = 0.5 + atan2(x, -z) / 2π`, `v = acos(y) / π`; any shape.
    Equirect,
    /// Debevec's angular map (light probe): the centre is straight ahead, the angle from there grows
    /// evenly up to straight back at the circle that touches the edges
    /// (<https://www.pauldebevec.com/Probes/>).
    Angular,
    /// Six squares: a cross lying (4:3) or standing (3:4, its lowest square upside down), or a strip
    /// in the order +X, -X, +Y, -Y, +Z, -Z (6:1, 1:6); each face as Vulkan has it.
    Cube,
}

impl Layout {
    const NAMES: [(&str, Self); 4] = [
        ("auto", Self::Auto),
        ("equirect", Self::Equirect),
        ("angular", Self::Angular),
        ("cube", Self::Cube),
    ];

    /// What a picture of this size is.
    pub(crate) fn resolve(self, [width, height]: [u32; 2]) -> Result<Shape, EnvironmentError> {
        let [w, h] = [u64::from(width), u64::from(height)];
        let wrong = |what: &str| {
            Err(EnvironmentError::Size(format!("a picture of {width} x {height} texels {what}")))
        };
        let cube = [Cube::LyingCross, Cube::StandingCross, Cube::Row, Cube::Column]
            .into_iter()
            .find(|cube| {
                let [columns, rows] = cube.squares().map(u64::from);
                w * rows == h * columns && w % columns == 0
            });
        match (self, cube) {
            (Self::Equirect, _) => Ok(Shape::Equirect),
            (Self::Angular, _) if w == h => Ok(Shape::Angular),
            (Self::Angular, _) => wrong("is no square, as an angular map must be"),
            (Self::Cube | Self::Auto, Some(cube)) => Ok(Shape::Cube(cube)),
            (Self::Cube, None) => wrong("is no cube: needed is 4:3, 3:4, 6:1 or 1:6"),
            (Self::Auto, None) if w == 2 * h => Ok(Shape::Equirect),
            (Self::Auto, None) if w == h => Ok(Shape::Angular),
            (Self::Auto, None) => wrong(
                "doesn't say how it is laid out (equirectangular maps are 2:1, angular ones 1:1, \
                 cubes 4:3, 3:4, 6:1 or 1:6); name the layout",
            ),
        }
    }
}

impl FromStr for Layout {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        UnknownName::find("layout", &Self::NAMES, name)
    }
}

impl fmt::Display for Layout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(Self::NAMES.iter().find(|(_, layout)| layout == self).map_or("", |(name, _)| name))
    }
}

/// A layout of which the size was checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shape {
    Equirect,
    Angular,
    Cube(Cube),
}

/// Where a picture has the faces of a cube.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cube {
    LyingCross,
    StandingCross,
    Row,
    Column,
}

impl Cube {
    /// Squares beside each other and above each other.
    pub(crate) fn squares(self) -> [u32; 2] {
        match self {
            Self::LyingCross => [4, 3],
            Self::StandingCross => [3, 4],
            Self::Row => [6, 1],
            Self::Column => [1, 6],
        }
    }

    /// Column and row of the square that holds a face (+X, -X, +Y, -Y, +Z, -Z).
    pub(crate) fn square(self, face: usize) -> [u32; 2] {
        match self {
            Self::LyingCross => [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [3, 1]][face],
            Self::StandingCross => [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [1, 3]][face],
            Self::Row => [face as u32, 0],
            Self::Column => [0, face as u32],
        }
    }

    /// Whether a face stands upside down.
    pub(crate) fn is_turned(self, face: usize) -> bool {
        self == Self::StandingCross && face == 5
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shape_of_a_picture_tells_its_layout() {
        for (size, shape) in [
            ([1024, 512], Shape::Equirect),
            ([640, 640], Shape::Angular),
            ([400, 300], Shape::Cube(Cube::LyingCross)),
            ([300, 400], Shape::Cube(Cube::StandingCross)),
            ([600, 100], Shape::Cube(Cube::Row)),
            ([100, 600], Shape::Cube(Cube::Column)),
        ] {
            assert_eq!(Layout::Auto.resolve(size).unwrap(), shape);
        }
        for (layout, size) in [
            (Layout::Auto, [3, 1]),
            (Layout::Auto, [1023, 512]),
            (Layout::Angular, [2, 1]),
            (Layout::Cube, [2, 1]),
            (Layout::Cube, [402, 301]),
        ] {
            let error = layout.resolve(size).unwrap_err().to_string();
            assert!(error.contains(&format!("{} x {}", size[0], size[1])), "{error}");
        }
        assert_eq!(Layout::Equirect.resolve([7, 3]).unwrap(), Shape::Equirect);
    }

    #[test]
    fn names_are_read_as_they_are_written() {
        for (name, layout) in Layout::NAMES {
            assert_eq!(name.parse(), Ok(layout));
            assert_eq!(layout.to_string(), name);
        }
        let error = "dome".parse::<Layout>().unwrap_err().to_string();
        assert_eq!(error, "there is no layout dome; known: auto, equirect, angular, cube");
    }
}

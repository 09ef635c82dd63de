//! What a BTFbase data set says of itself: `all_materialInfo.txt`, or the first lines of a binary.

use crate::{BtfError, ColourSpace};

/// A parsed description.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Description {
    /// Numbers of directions of view and light that were measured.
    pub(super) measured: [u32; 2],
    /// Whether beta is sampled at equal steps of its sine.
    pub(super) beta_uniform_in_sine: bool,
    pub(super) beta: usize,
    pub(super) alpha: usize,
    pub(super) theta: usize,
    pub(super) phi: usize,
    pub(super) rows: RowCounts,
    pub(super) materials: Vec<Entry>,
}

/// Rows of the tables that materials share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RowCounts {
    pub(super) shapes: usize,
    pub(super) colours: usize,
    pub(super) colour_rows: usize,
    pub(super) slices: usize,
    pub(super) luminances: usize,
    pub(super) chromas: usize,
    pub(super) elevations: usize,
    pub(super) azimuths: usize,
}

/// One material of the data set.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entry {
    pub(super) name: String,
    /// What a row and a column of texels count from.
    pub(super) origin: [i64; 2],
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) colour_space: ColourSpace,
}

type Result<T> = std::result::Result<T, BtfError>;

impl Description {
    /// From lines, the first of which has the number `first`.
    ///
    /// Errors know no file: [`BtfError::in_file`] adds it.
    pub(super) fn parse<'a>(lines: impl Iterator<Item = &'a str>, first: usize) -> Result<Self> {
        let mut lines = Lines { lines: lines.enumerate(), first, number: first };
        lines.next()?; // the folder that it was made in
        let [stored] = lines.numbers("the number of materials")?;
        let [_in_database] = lines.numbers("the number of materials in the database")?;
        let [_shared] = lines.numbers("the flag of a shared database")?;
        for (flag, variant) in [
            ("the flag of merged 3D and 4D tables", "3D and 4D tables merged into one"),
            ("the flag of compact 2D tables", "compact 2D tables"),
        ] {
            if lines.numbers(flag)? != [0] {
                return Err(BtfError::Unsupported(variant.to_owned()));
            }
        }
        let [channels] = lines.numbers("the number of channels less one")?;
        if channels != 2 {
            return Err(BtfError::Unsupported(format!(
                "{} colour channels; three are",
                channels.saturating_add(1)
            )));
        }
        let [views] = lines.numbers("the number of views")?;
        let [lights] = lines.numbers("the number of lights")?;
        lines.next()?; // size of the tiles that it was made in
        let axes: [u64; 12] = lines.numbers("the samples of the axes")?;
        let [in_sine, beta, _, alpha, _, theta, _, phi, _, _, _, code] = axes;
        if code != 0 {
            return Err(BtfError::Unsupported("a \"code BTF\"".to_owned()));
        }
        lines.next()?; // where searches begin
        let counts: [u64; 10] = lines.numbers("the numbers of rows")?;
        let rows = counts.map(|count| usize::try_from(count).unwrap_or(usize::MAX));
        let [shapes, colours, colour_rows, slices, luminances, chromas, elevations, _, azimuths, _] =
            rows;
        lines.next()?; // metric and thresholds of the compression
        let mut materials = Vec::new();
        while (materials.len() as u64) < stored
            && let Some(line) = lines.next_full()
        {
            materials.push(Entry::parse(line).ok_or_else(|| {
                lines.wrong("is no material: name, paths, origin, rows, columns, HDR factor")
            })?);
        }
        if (materials.len() as u64) < stored {
            return Err(BtfError::Tables(format!(
                "cut off: {} of {stored} materials described",
                materials.len()
            )));
        }
        Ok(Self {
            measured: [views, lights].map(|count| u32::try_from(count).unwrap_or(u32::MAX)),
            beta_uniform_in_sine: in_sine != 0,
            beta: beta as usize,
            alpha: alpha as usize,
            theta: theta as usize,
            phi: phi as usize,
            rows: RowCounts {
                shapes,
                colours,
                colour_rows,
                slices,
                luminances,
                chromas,
                elevations,
                azimuths,
            },
            materials,
        })
    }

    /// Names of the materials, for messages.
    pub(super) fn names(&self) -> String {
        let names: Vec<&str> =
            self.materials.iter().take(20).map(|material| material.name.as_str()).collect();
        names.join(", ") + if self.materials.len() > 20 { ", .." } else { "" }
    }
}

impl Entry {
    /// Name, paths (blanks may stand in them), then five numbers.
    fn parse(line: &str) -> Option<Self> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let (texts, numbers) = words.split_at_checked(words.len().checked_sub(5)?)?;
        let name = (*texts.first()?).to_owned();
        let factor: f32 = numbers[4].parse().ok()?;
        let colour_space = if factor == 0.0 || factor == 1.0 {
            ColourSpace::YCbCr
        } else {
            ColourSpace::LogLuv { factor }
        };
        Some(Self {
            name,
            origin: [numbers[0].parse().ok()?, numbers[1].parse().ok()?],
            rows: numbers[2].parse().ok()?,
            columns: numbers[3].parse().ok()?,
            colour_space,
        })
    }

    /// Moves texels from where they are stored to where queries look for them: a query counts rows
    /// and columns from the origin, and wraps round.
    pub(super) fn place<T: Copy>(&self, texels: &[T]) -> Vec<T> {
        let wrap = |origin: i64, count: usize| origin.rem_euclid(count.max(1) as i64) as usize;
        let [down, right] = [wrap(self.origin[0], self.rows), wrap(self.origin[1], self.columns)];
        let mut placed = texels.to_vec();
        if self.columns > 0 {
            placed.rotate_right(down * self.columns);
            for row in placed.chunks_exact_mut(self.columns) {
                row.rotate_right(right);
            }
        }
        placed
    }
}

struct Lines<I> {
    lines: I,
    first: usize,
    /// Of the line that was read last.
    number: usize,
}

impl<'a, I: Iterator<Item = (usize, &'a str)>> Lines<I> {
    fn next(&mut self) -> Result<&'a str> {
        let cut_off = || BtfError::Tables("the description is cut off".to_owned());
        let (at, line) = self.lines.next().ok_or_else(cut_off)?;
        self.number = at + self.first;
        Ok(line)
    }

    fn next_full(&mut self) -> Option<&'a str> {
        let (at, line) = self.lines.find(|(_, line)| !line.trim().is_empty())?;
        self.number = at + self.first;
        Some(line)
    }

    fn numbers<const N: usize>(&mut self, what: &str) -> Result<[u64; N]> {
        let line = self.next()?;
        let numbers: Option<Vec<u64>> =
            line.split_whitespace().map(|word| word.parse().ok()).collect();
        numbers
            .and_then(|numbers| numbers.try_into().ok())
            .ok_or_else(|| self.wrong(&format!("should be {what}: {N} whole numbers")))
    }

    fn wrong(&self, what: &str) -> BtfError {
        BtfError::Tables(format!("line {} {what}", self.number))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINES: &str = "./base/\n2\n2\n1\n0\n0\n2\n81\n80\n32\n1 9 0 7 0 5 0 4 0 0 0 0\n\
                         0 0 0 0 0 0 0 0 0 0\n1 2 3 4 5 6 7 0 8 0\n2 0.5\n\
                         one ./a b/ ./c/ ./d/ 0 0 2 3 0.000000\n\n\
                         two ./e/ ./f/ ./g/ 1 -1 2 3 0.5\n";

    fn parse(text: &str) -> std::result::Result<Description, String> {
        Description::parse(text.lines(), 1).map_err(|error| error.to_string())
    }

    #[test]
    fn everything_is_found() {
        let description = parse(LINES).unwrap();
        assert_eq!(description.measured, [81, 80]);
        assert!(description.beta_uniform_in_sine);
        let Description { beta, alpha, theta, phi, .. } = description;
        assert_eq!([beta, alpha, theta, phi], [9, 7, 5, 4]);
        assert_eq!(description.rows.elevations, 7);
        assert_eq!(description.rows.azimuths, 8);
        assert_eq!(description.names(), "one, two");
        assert_eq!(description.materials[0].colour_space, ColourSpace::YCbCr);
        let two = &description.materials[1];
        assert_eq!(two.colour_space, ColourSpace::LogLuv { factor: 0.5 });
        // A query for (0, 0) wants the stored row 0 - 1 and column 0 + 1.
        assert_eq!(two.place(&[1, 2, 3, 4, 5, 6]), [5, 6, 4, 2, 3, 1]);
    }

    #[test]
    fn variants_and_damage_are_refused() {
        for (from, to, message) in [
            ("1\n0\n0\n2\n", "1\n1\n0\n2\n", "merged"),
            ("1\n0\n0\n2\n", "1\n0\n1\n2\n", "compact"),
            ("1\n0\n0\n2\n", "1\n0\n0\n0\n", "1 colour channels"),
            ("4 0 0 0 0\n", "4 0 0 0 1\n", "code BTF"),
            ("81\n80", "81\n-80", "line 9"),
            ("1 -1 2 3 0.5", "1 -1 2 x 0.5", "line 17"),
            ("1 -1 2 3 0.5", "1 -1 2 3", "line 17"),
        ] {
            let error = parse(&LINES.replace(from, to)).err().unwrap_or_default();
            assert!(error.contains(message), "{to}: {error}");
        }
        let cut = LINES.lines().take(15).collect::<Vec<_>>().join("\n");
        assert!(parse(&cut).unwrap_err().contains("1 of 2"));
    }
}

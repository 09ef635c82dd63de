//! A made-up BTFbase data set, with other numbers of samples than the measured ones have, as text and
//! as a binary with the writer's mistake.

use std::path::Path;

/// What a table holds.
pub(crate) enum Content {
    Integers(Vec<u32>),
    /// Least and greatest number, and codes from 0 to 256 between them.
    Floats([f32; 2], Vec<u16>),
}

pub(crate) struct Table {
    /// Its text file, without the part that names the material.
    name: &'static str,
    columns: usize,
    content: Content,
}

pub(crate) struct Base {
    /// In the order of a binary.
    pub(crate) tables: Vec<Table>,
    pub(crate) factor: &'static str,
}

/// Texels, azimuths, elevations, alpha, beta.
const COLUMNS: [usize; 5] = [6, 5, 4, 7, 9];

impl Base {
    pub(crate) fn new() -> Self {
        let [texels, phi, theta, alpha, beta] = COLUMNS;
        let integers = |name, columns, content: Vec<u32>| Table {
            name,
            columns,
            content: Content::Integers(content),
        };
        let floats = |name, columns, range, codes: Vec<u16>| Table {
            name,
            columns,
            content: Content::Floats(range, codes),
        };
        let smooth = |count: usize, at: usize, value: u16| {
            let mut codes = vec![128; count];
            codes[at] = value;
            codes
        };
        // Low on the left, high on the right.
        let texel_scales: Vec<u16> = [
            [90, 60, 90, 150, 200, 170],
            [60, 0, 70, 160, 210, 180],
            [80, 70, 100, 220, 256, 230],
            [100, 80, 110, 170, 215, 190],
        ]
        .concat();
        // The sum of a row is the same.
        let curve = [10, 40, 90, 180, 256, 170, 80, 50, 0];
        let shapes = [
            curve,
            {
                let mut mirrored = curve;
                mirrored.reverse();
                mirrored
            },
            [40, 80, 100, 130, 176, 130, 100, 80, 40],
        ]
        .concat();
        let tables = vec![
            integers("PDF6Dslices", texels, (0..24).map(|at| 1 + at % 3).collect()),
            floats("PDF6Dscale", texels, [0.9, 1.1], texel_scales),
            floats("PDF1Dslice", beta, [0.02, 0.25], shapes),
            floats("colors", 2, [90.0, 150.0], vec![0, 250, 20, 230, 240, 30, 256, 10]),
            integers(
                "indexAB",
                beta,
                [[0, 1, 0, 1, 0, 1, 0, 1, 0], [2, 3, 3, 2, 2, 3, 3, 2, 2]].concat(),
            ),
            integers("PDF2Dslices", alpha, (0..21).map(|at| at % 3).collect()),
            floats(
                "PDF2Dscale",
                alpha,
                [300.0, 1500.0],
                [
                    [0, 10, 60, 100, 60, 20, 10],
                    [30, 60, 180, 256, 190, 70, 20],
                    [40, 80, 90, 90, 90, 80, 40],
                ]
                .concat(),
            ),
            integers("PDF2Dcolours", alpha, [[0; 7], [1; 7]].concat()),
            integers("PDF2Dindices", 2, vec![1, 0, 1, 1, 2, 0]),
            integers("PDF3Dslices", theta, [[0; 4], [1; 4], [2; 4]].concat()),
            floats(
                "PDF3Dscale",
                theta,
                [0.7, 1.2],
                [[20, 0, 30, 60], [200, 240, 256, 230], [128; 4]].concat(),
            ),
            integers("PDF4Dslices", phi, [[2; 5], [2; 5], [0, 1, 2, 1, 0]].concat()),
            floats(
                "PDF4Dscale",
                phi,
                [0.98, 1.02],
                [smooth(5, 0, 0), smooth(5, 3, 256), vec![100, 110, 120, 110, 90]]
                    .concat()
                    .into_iter()
                    .enumerate()
                    .map(|(at, code)| match at {
                        1 | 4 => 30,
                        7 | 9 => 230,
                        _ => code,
                    })
                    .collect(),
            ),
        ];
        Self { tables, factor: "0.000000" }
    }

    fn rows(&self, name: &str) -> usize {
        let table = self.tables.iter().find(|table| table.name == name).unwrap();
        let count = match &table.content {
            Content::Integers(integers) => integers.len(),
            Content::Floats(_, codes) => codes.len(),
        };
        count / table.columns
    }

    /// The lines of `all_materialInfo.txt`.
    pub(crate) fn description(&self) -> String {
        let [_, phi, theta, alpha, beta] = COLUMNS;
        let rows = [
            "PDF1Dslice",
            "colors",
            "indexAB",
            "PDF2Dindices",
            "PDF2Dslices",
            "PDF2Dcolours",
            "PDF3Dslices",
            "",
            "PDF4Dslices",
            "",
        ]
        .map(|name| if name.is_empty() { 0 } else { self.rows(name) }.to_string())
        .join(" ");
        format!(
            "./base/\n1\n1\n1\n0\n0\n2\n81\n81\n32\n1 {beta} 0 {alpha} 0 {theta} 0 {phi} 0 0 0 0\n\
             0 0 0 0 0 0 0 0 0 0\n{rows}\n2 0.006 0.8\n\n\
             made ./in/ ./out/ ./tmp/ 0 0 4 6 {}\n",
            self.factor
        )
    }

    /// The file as the format's writer makes it: code 256 becomes 0.
    pub(crate) fn binary(&self) -> Vec<u8> {
        let mut bytes = format!("4627\n1\n{}", self.description()).into_bytes();
        for table in &self.tables {
            let mut packed;
            match &table.content {
                Content::Integers(integers) => {
                    let (min, max) =
                        (*integers.iter().min().unwrap(), *integers.iter().max().unwrap());
                    bytes.extend([min, max].map(u32::to_le_bytes).concat());
                    let width = (u32::BITS - (max - min).leading_zeros()) as usize;
                    packed = vec![0_u8; (integers.len() * width / 32 + 1) * 4];
                    for (at, integer) in integers.iter().enumerate() {
                        for bit in 0..width {
                            let place = at * width + bit;
                            packed[place / 8] |= ((integer - min) as u8 >> bit & 1) << (place % 8);
                        }
                    }
                }
                Content::Floats(range, codes) => {
                    bytes.extend(range.map(f32::to_le_bytes).concat());
                    let shape = [codes.len() / table.columns, table.columns];
                    bytes.extend(shape.map(|count| (count as u32).to_le_bytes()).concat());
                    packed = codes.iter().map(|code| *code as u8).collect();
                    packed.resize((codes.len() / 4 + 1) * 4, 0);
                }
            }
            bytes.extend(packed);
        }
        bytes
    }

    /// Names and texts of all files of a folder.
    pub(crate) fn texts(&self) -> Vec<(String, String)> {
        let mut files = vec![("all_materialInfo.txt".to_owned(), self.description())];
        for table in &self.tables {
            let prefix = if table.name.starts_with("PDF6D") { "made" } else { "all" };
            let numbers: Vec<String> = match &table.content {
                Content::Integers(integers) => integers.iter().map(u32::to_string).collect(),
                Content::Floats([min, max], codes) => codes
                    .iter()
                    .map(|code| format!("{:.6}", min + f32::from(*code) * ((max - min) / 256.0)))
                    .collect(),
            };
            let (least, greatest) = match &table.content {
                Content::Integers(integers) => (
                    integers.iter().min().unwrap().to_string(),
                    integers.iter().max().unwrap().to_string(),
                ),
                Content::Floats([min, max], _) => (format!("{min:.6}"), format!("{max:.6}")),
            };
            let rows = numbers.len() / table.columns;
            let mut text = format!("{rows} {} {least} {greatest}\n", table.columns);
            for row in numbers.chunks(table.columns) {
                text += &(row.join(" ") + " \n");
            }
            files.push((format!("{prefix}_{}.txt", table.name), text));
        }
        files
    }

    pub(crate) fn write_texts(&self, folder: &Path) {
        for (name, text) in self.texts() {
            std::fs::write(folder.join(name), text).unwrap();
        }
    }
}

//! Greatest numbers that were stored as least ones.
//!
//! The writer of the format rounds a number to a code from 0 (the least of its table) to 256 (the
//! greatest) and stores the lowest 8 bits: the greatest number becomes code 0. Both the least and
//! the greatest occur in every table whose numbers differ, so of all codes 0 at least one is a
//! greatest and one a least number. Which is which is told by what surrounds an entry:
//!
//! | table | an entry is judged by |
//! |---|---|
//! | PDF1D | the sum of its row: that of all rows is nearly the same |
//! | colours | the colours beside it in the rows that use it |
//! | PDF2Dscale | the entries beside it: light over alpha is smooth |
//! | PDF3Dscale | the luminance of the view beside it, over the luminance of its own slice |
//! | PDF4Dscale | the luminance of the azimuths beside it, likewise; more of views near the normal, where the azimuth matters least |
//! | PDF6Dscale | the luminance of the texels beside it, over that of its own row |

use super::Stored;
use super::decode::Codes;
use crate::{BtfError, Certainty, Repair};

/// What stands for a number that was wrapped.
const GREATEST: u16 = 256;
/// From this share of a table's half range on, the surroundings speak for themselves.
const CLEAR: f32 = 0.35;

type Result<T> = std::result::Result<T, BtfError>;

/// Puts wrapped entries right; each table with the help of those below it.
pub(super) fn repair(stored: &mut Stored) -> Result<Vec<Repair>> {
    let mut found = Vec::new();
    shapes(&mut stored.shapes, &mut found);
    let judged = colours(stored)?;
    decide(&mut stored.colours, &judged, &mut found);

    let columns = stored.luminance_scales.columns;
    let judged = judge(&stored.luminance_scales, |entry| {
        let scales = &stored.luminance_scales;
        let beside = beside(scales, entry / columns, entry % columns);
        Ok(mean(beside.map(|column| scales.value(entry - entry % columns + column))))
    })?;
    decide(&mut stored.luminance_scales, &judged, &mut found);

    // Luminance of each row: first as sums over beta, then over alpha, and so on upwards.
    let shapes: Vec<f32> = sums(&stored.shapes.values(), stored.shapes.columns);
    let luminances = weighted(&stored.luminances, &stored.luminance_scales, &shapes)?;
    let luminances = sums(&luminances, columns);
    let slices = stored.slices.as_chunks().0.iter();
    let slices: Vec<f32> = slices
        .map(|[luminance, _]: &[u32; 2]| get(&luminances, *luminance))
        .collect::<Result<_>>()?;

    let columns = stored.elevation_scales.columns;
    let judged = judge(&stored.elevation_scales, |entry| {
        let scales = &stored.elevation_scales;
        let row = entry - entry % columns;
        let beside: Vec<usize> = beside(scales, entry / columns, entry % columns).collect();
        let beside = beside.into_iter().map(|column| row + column);
        let seen = seen(scales, &stored.elevations, &slices, beside)?;
        Ok(continued(&seen, &[]) / get(&slices, stored.elevations[entry])?)
    })?;
    decide(&mut stored.elevation_scales, &judged, &mut found);

    let elevations = weighted(&stored.elevations, &stored.elevation_scales, &slices)?;
    // From 1 along the normal to 0 at the horizon.
    let weight = |column: usize| (1.0 - column as f32 / (columns - 1).max(1) as f32).powi(2);
    let steep: Vec<f32> = elevations
        .chunks_exact(columns)
        .map(|row| row.iter().enumerate().map(|(column, light)| weight(column) * light).sum())
        .collect();
    let columns = stored.azimuth_scales.columns;
    let judged = judge(&stored.azimuth_scales, |entry| {
        let row = entry - entry % columns;
        let seen = |steps: usize| {
            let around =
                [columns - steps % columns, steps].map(|step| (entry % columns + step) % columns);
            seen(&stored.azimuth_scales, &stored.azimuths, &steep, around.map(|at| row + at))
        };
        Ok(continued(&seen(1)?, &seen(2)?) / get(&steep, stored.azimuths[entry])?)
    })?;
    decide(&mut stored.azimuth_scales, &judged, &mut found);

    let elevations = sums(&elevations, stored.elevation_scales.columns);
    let azimuths = weighted(&stored.azimuths, &stored.azimuth_scales, &elevations)?;
    let azimuths = sums(&azimuths, columns);
    let columns = stored.texel_scales.columns;
    let rows = stored.texels.len() / columns;
    let judged = judge(&stored.texel_scales, |entry| {
        let (row, column) = (entry / columns, entry % columns);
        let seen = |steps: usize| {
            let (down, right) = (steps % rows, steps % columns);
            let around = [
                (row + rows - down) % rows * columns + column,
                (row + down) % rows * columns + column,
                row * columns + (column + columns - right) % columns,
                row * columns + (column + right) % columns,
            ];
            seen(&stored.texel_scales, &stored.texels, &azimuths, around)
        };
        Ok(continued(&seen(1)?, &seen(2)?) / get(&azimuths, stored.texels[entry])?)
    })?;
    decide(&mut stored.texel_scales, &judged, &mut found);
    Ok(found)
}

/// An entry of code 0, and the number that its surroundings suggest.
struct Judged {
    entry: usize,
    suggested: f32,
}

fn judge(codes: &Codes, suggest: impl Fn(usize) -> Result<f32>) -> Result<Vec<Judged>> {
    if codes.range[0] == codes.range[1] {
        return Ok(Vec::new());
    }
    let zeros = codes.codes.iter().enumerate().filter(|(_, code)| **code == 0);
    zeros.map(|(entry, _)| Ok(Judged { entry, suggested: suggest(entry)? })).collect()
}

/// Takes entries for the greatest number that are nearer to it than to the least: at least one, and
/// not all.
fn decide(codes: &mut Codes, judged: &[Judged], found: &mut Vec<Repair>) {
    let [min, max] = codes.range;
    // From -1, surely the least, to 1, surely the greatest number.
    let lean = |judged: &Judged| {
        let lean = (judged.suggested - min - (max - judged.suggested)) / (max - min);
        if lean.is_finite() { lean.clamp(-1.0, 1.0) } else { 0.0 }
    };
    let mut order: Vec<(f32, usize)> = judged.iter().map(|one| (lean(one), one.entry)).collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0));
    let leaning = order.iter().filter(|(lean, _)| *lean > 0.0).count();
    let wrapped = match order.len() {
        0 => 0,
        // Both a least and a greatest number, if the file is as expected.
        1 => usize::from(order[0].0 > CLEAR),
        several => leaning.clamp(1, several - 1),
    };
    // How far apart the two kinds are, in the same measure.
    let gap = match (order.get(wrapped.wrapping_sub(1)), order.get(wrapped)) {
        (Some((last, _)), Some((next, _))) => 0.5 * (last - next),
        _ => 0.0,
    };
    for (lean, entry) in &order[..wrapped] {
        let clear = if order.len() == 2 { gap > CLEAR } else { gap > 0.0 && *lean > CLEAR };
        let certainty = if clear { Certainty::Likely } else { Certainty::Guess };
        wrap(codes, *entry, certainty, found);
    }
}

fn wrap(codes: &mut Codes, entry: usize, certainty: Certainty, found: &mut Vec<Repair>) {
    codes.codes[entry] = GREATEST;
    found.push(Repair {
        table: codes.name.to_owned(),
        row: (entry / codes.columns) as u32,
        column: (entry % codes.columns) as u32,
        from: codes.range[0],
        to: codes.range[1],
        certainty,
    });
}

/// Rows of shapes have one sum: a row that lacks the range of the table holds a wrapped entry.
fn shapes(shapes: &mut Codes, found: &mut Vec<Repair>) {
    let [min, max] = shapes.range;
    let columns = shapes.columns;
    if min == max {
        return;
    }
    let sums = sums(&shapes.values(), columns);
    // What a whole row sums to: the middle of those that lack nothing.
    let greatest = sums.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let mut whole: Vec<f32> =
        sums.iter().copied().filter(|sum| greatest - sum < 0.5 * (max - min)).collect();
    whole.sort_by(f32::total_cmp);
    let usual = whole.get(whole.len() / 2).copied().unwrap_or_default();
    for (row, sum) in sums.into_iter().enumerate() {
        let zeros = (0..columns).filter(|column| shapes.codes[row * columns + column] == 0);
        let mut zeros: Vec<(f32, usize)> = zeros
            .map(|column| {
                let beside = beside(shapes, row, column);
                (mean(beside.map(|column| shapes.value(row * columns + column))), column)
            })
            .collect();
        let missing = ((usual - sum) / (max - min)).round().max(0.0) as usize;
        let certainty = if zeros.len() <= missing { Certainty::Certain } else { Certainty::Guess };
        zeros.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (_, column) in zeros.into_iter().take(missing) {
            wrap(shapes, row * columns + column, certainty, found);
        }
    }
}

/// What the colours suggest that stand beside a colour in rows over beta, or over alpha.
fn colours(stored: &Stored) -> Result<Vec<Judged>> {
    let colours = &stored.colours;
    let beta = stored.shapes.columns;
    let alpha = stored.luminance_scales.columns;
    let rows: Vec<&[u32]> = stored.colour_rows.chunks_exact(beta).collect();
    judge(colours, |entry| {
        let (colour, channel) = ((entry / 2) as u32, entry % 2);
        let (mut sum, mut count) = (0.0, 0_u32);
        let mut pair = |a: u32, b: u32| {
            for (own, other) in [(a, b), (b, a)] {
                let at = 2 * other as usize + channel;
                if own == colour && other != colour && colours.codes.get(at).is_some_and(|c| *c > 0)
                {
                    sum += f64::from(colours.value(at));
                    count += 1;
                }
            }
        };
        for row in &rows {
            row.windows(2).for_each(|two| pair(two[0], two[1]));
        }
        for chroma in stored.chromas.chunks_exact(alpha) {
            for two in chroma.windows(2).filter(|two| two[0] != two[1]) {
                let (below, above) = (get(&rows, two[0])?, get(&rows, two[1])?);
                below.iter().zip(above).for_each(|(a, b)| pair(*a, *b));
            }
        }
        Ok((sum / f64::from(count)) as f32)
    })
}

/// The nearest columns before and behind one whose code is not 0.
fn beside(codes: &Codes, row: usize, column: usize) -> impl Iterator<Item = usize> {
    let columns = codes.columns;
    let row = &codes.codes[row * columns..][..columns];
    let good = |column: &usize| row[*column] != 0;
    let (before, behind) = ((0..column).rev().find(good), (column + 1..columns).find(good));
    before.into_iter().chain(behind)
}

/// Luminance of the entries whose code is not 0: their factors times that of the rows below.
fn seen(
    scales: &Codes,
    indices: &[u32],
    below: &[f32],
    entries: impl IntoIterator<Item = usize>,
) -> Result<Vec<f32>> {
    let good = entries.into_iter().filter(|entry| scales.codes[*entry] != 0);
    good.map(|entry| Ok(scales.value(entry) * get(below, indices[entry])?)).collect()
}

/// What stands between neighbours, curved as those two steps away say.
fn continued(near: &[f32], far: &[f32]) -> f32 {
    let near = mean(near.iter().copied());
    if far.is_empty() { near } else { (4.0 * near - mean(far.iter().copied())) / 3.0 }
}

/// NaN of nothing.
fn mean(numbers: impl Iterator<Item = f32>) -> f32 {
    let (sum, count) = numbers.fold((0.0, 0.0), |(sum, count), n| (sum + n, count + 1.0));
    sum / count
}

fn sums(numbers: &[f32], columns: usize) -> Vec<f32> {
    numbers.chunks_exact(columns).map(|row| row.iter().sum()).collect()
}

/// Each entry's factor times what it refers to.
fn weighted(indices: &[u32], scales: &Codes, below: &[f32]) -> Result<Vec<f32>> {
    let entries = indices.iter().enumerate();
    entries.map(|(entry, index)| Ok(scales.value(entry) * get(below, *index)?)).collect()
}

fn get<T: Copy>(table: &[T], row: u32) -> Result<T> {
    table
        .get(row as usize)
        .copied()
        .ok_or_else(|| BtfError::Tables(format!("an index refers to row {row} of {}", table.len())))
}

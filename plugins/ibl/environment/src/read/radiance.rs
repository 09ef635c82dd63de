//! Radiance pictures: RGBE, plain or with run lengths.
//!
//! G. Ward, *Real Pixels*, Graphics Gems II, 1991; G. Ward, *Radiance File Formats*
//! (<https://floyd.lbl.gov/radiance/refer/filefmts.pdf>), "Picture File Format". `EXPOSURE` and `COLORCORR`
//! are left alone, as in other readers: they would make the light differ from the picture that a game
//! shows of the same file.

use glam::Vec3;

use crate::{Environment, EnvironmentError, Layout, shrink::Shrink};

/// A header is not longer than this.
const LONGEST_HEADER: usize = 1 << 16;

fn wrong(what: impl Into<String>) -> EnvironmentError {
    EnvironmentError::format("Radiance", what)
}

pub(super) fn read(bytes: &[u8], layout: Layout) -> Result<Environment, EnvironmentError> {
    let mut rest = bytes;
    let header = Header::read(&mut rest)?;
    let mut shrink = Shrink::new([header.width, header.height], layout)?;
    let [width, height] = [header.width as usize, header.height as usize];
    let mut row = vec![[0_u8; 4]; width];
    let mut texels = vec![Vec3::ZERO; width];
    for y in 0..height {
        let ended = || wrong(format!("it ends in row {y} of {height}"));
        match read_row(&mut rest, &mut row) {
            Ok(()) => {}
            Err(Broken::Ended) => return Err(ended()),
            Err(Broken::Overlong) => return Err(wrong(format!("a run goes beyond row {y}"))),
        }
        for (texel, rgbe) in texels.iter_mut().zip(&row) {
            *texel = decode(*rgbe);
        }
        if header.from_right {
            texels.reverse();
        }
        shrink.row(if header.from_bottom { height - 1 - y } else { y }, 0, &texels);
    }
    Ok(shrink.finish())
}

struct Header {
    width: u32,
    height: u32,
    from_bottom: bool,
    from_right: bool,
}

impl Header {
    fn read(rest: &mut &[u8]) -> Result<Self, EnvironmentError> {
        let start = rest.len();
        loop {
            let line = line(rest).ok_or_else(|| wrong("the header does not end"))?;
            if start - rest.len() > LONGEST_HEADER {
                return Err(wrong("the header does not end"));
            }
            if line.is_empty() {
                break;
            }
            if let Some(format) = line.strip_prefix("FORMAT=")
                && format.trim() != "32-bit_rle_rgbe"
            {
                let what = format!("a Radiance picture of format {format:?}; convert it to RGBE");
                return Err(EnvironmentError::Unsupported(what));
            }
        }
        let line = line(rest).ok_or_else(|| wrong("there is no line with its size"))?;
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let [vertical @ ("-Y" | "+Y"), height, horizontal @ ("+X" | "-X"), width] = words[..]
        else {
            return Err(wrong(format!("{line:?} is no size such as \"-Y 512 +X 1024\"")));
        };
        let number = |text: &str| {
            text.parse::<u32>().map_err(|_| wrong(format!("{line:?}: {text:?} is no size")))
        };
        Ok(Self {
            width: number(width)?,
            height: number(height)?,
            from_bottom: vertical == "+Y",
            from_right: horizontal == "-X",
        })
    }
}

/// The text before the next line feed.
fn line(rest: &mut &[u8]) -> Option<String> {
    let end = rest.iter().take(LONGEST_HEADER).position(|byte| *byte == b'\n')?;
    let (line, after) = rest.split_at(end);
    *rest = &after[1..];
    Some(String::from_utf8_lossy(line.trim_ascii_end()).into_owned())
}

enum Broken {
    Ended,
    Overlong,
}

fn take<const N: usize>(rest: &mut &[u8]) -> Result<[u8; N], Broken> {
    let (head, tail) = rest.split_first_chunk().ok_or(Broken::Ended)?;
    *rest = tail;
    Ok(*head)
}

fn read_row(rest: &mut &[u8], row: &mut [[u8; 4]]) -> Result<(), Broken> {
    let first: [u8; 4] = *rest.first_chunk().ok_or(Broken::Ended)?;
    let width = row.len();
    let by_channel = first[..2] == [2, 2]
        && first[2] < 128
        && usize::from(u16::from_be_bytes([first[2], first[3]])) == width
        && (8..1 << 15).contains(&width);
    if by_channel {
        *rest = &rest[4..];
        (0..4).try_for_each(|channel| read_channel(rest, row, channel))
    } else {
        read_pixels(rest, row)
    }
}

/// One channel of a row: runs above 128, else plain bytes.
fn read_channel(rest: &mut &[u8], row: &mut [[u8; 4]], channel: usize) -> Result<(), Broken> {
    let mut x = 0;
    while x < row.len() {
        let [count] = take(rest)?;
        let run = count > 128;
        let length = usize::from(if run { count - 128 } else { count });
        let to = row.get_mut(x..x + length).ok_or(Broken::Overlong)?;
        if run {
            let [value] = take(rest)?;
            to.iter_mut().for_each(|pixel| pixel[channel] = value);
        } else {
            let (plain, tail) = rest.split_at_checked(length).ok_or(Broken::Ended)?;
            to.iter_mut().zip(plain).for_each(|(pixel, value)| pixel[channel] = *value);
            *rest = tail;
        }
        x += length;
    }
    Ok(())
}

/// Whole pixels; (1, 1, 1, n) repeats the one before n times, and again with n of eight higher bits.
fn read_pixels(rest: &mut &[u8], row: &mut [[u8; 4]]) -> Result<(), Broken> {
    let (mut x, mut shift) = (0, 0);
    while x < row.len() {
        let pixel: [u8; 4] = take(rest)?;
        if pixel[..3] == [1, 1, 1] && x > 0 {
            let length = usize::from(pixel[3]).checked_shl(shift).ok_or(Broken::Overlong)?;
            let end = x.checked_add(length).filter(|end| *end <= row.len());
            let end = end.ok_or(Broken::Overlong)?;
            let repeated = row[x - 1];
            row[x..end].fill(repeated);
            x = end;
            shift += 8;
        } else {
            row[x] = pixel;
            x += 1;
            shift = 0;
        }
    }
    Ok(())
}

fn decode([r, g, b, exponent]: [u8; 4]) -> Vec3 {
    if exponent == 0 {
        return Vec3::ZERO;
    }
    let scale = f64::from(i32::from(exponent) - 136).exp2();
    Vec3::from([r, g, b].map(|mantissa| (f64::from(mantissa) * scale) as f32))
}

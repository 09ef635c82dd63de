//! Radiance pictures (RGBE with run lengths), as `image` and Bevy read them.
//!
//! G. Ward, *Real Pixels*, Graphics Gems II, 1991; the run-length form of scan lines is that of the
//! Radiance reference manual.

/// Rows from the top, linear values.
pub(super) fn write(width: usize, pixels: &[[f64; 3]]) -> Vec<u8> {
    let height = pixels.len() / width;
    let mut file =
        format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    for row in pixels.chunks_exact(width) {
        let row: Vec<[u8; 4]> = row.iter().map(|&p| rgbe(p)).collect();
        file.extend([2, 2, (width >> 8) as u8, (width & 255) as u8]);
        for channel in 0..4 {
            let bytes: Vec<u8> = row.iter().map(|p| p[channel]).collect();
            runs(&bytes, &mut file);
        }
    }
    file
}

/// Three mantissas and the exponent that they share.
fn rgbe(p: [f64; 3]) -> [u8; 4] {
    let greatest = p[0].max(p[1]).max(p[2]);
    if greatest < 1e-30 {
        return [0; 4];
    }
    let mut exponent = 0;
    let mut scale = 1.0;
    while greatest * scale >= 1.0 {
        scale *= 0.5;
        exponent += 1;
    }
    while greatest * scale < 0.5 {
        scale *= 2.0;
        exponent -= 1;
    }
    let [r, g, b] = p.map(|v| (v * scale * 256.0).round().min(255.0) as u8);
    [r, g, b, (exponent + 128) as u8]
}

/// Runs of four and more equal bytes, the rest as it is.
fn runs(bytes: &[u8], file: &mut Vec<u8>) {
    let run_at = |i: usize| bytes[i..].iter().take(127).take_while(|&&b| b == bytes[i]).count();
    let mut i = 0;
    while i < bytes.len() {
        let run = run_at(i);
        if run >= 4 {
            file.extend([128 + run as u8, bytes[i]]);
            i += run;
            continue;
        }
        let mut end = i;
        while end < bytes.len() && end - i < 128 && run_at(end) < 4 {
            end += 1;
        }
        file.push((end - i) as u8);
        file.extend(&bytes[i..end]);
        i = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_kept_to_one_part_in_256() {
        for v in [1e-4, 0.02, 0.5, 0.999, 1.0, 7.3, 4000.0] {
            let [m, _, _, e] = rgbe([v, v * 0.5, 0.0]);
            let back = f64::from(m) / 256.0 * 2_f64.powi(i32::from(e) - 128);
            assert!((back / v - 1.0).abs() < 1.0 / 256.0, "{v}: {back}");
        }
    }

    #[test]
    fn runs_and_the_rest_come_back() {
        let row: Vec<u8> = [&[1, 2, 3][..], &[7; 300], &[4, 4, 5, 6, 6, 6], &[9; 5]].concat();
        let mut packed = Vec::new();
        runs(&row, &mut packed);
        let (mut back, mut i) = (Vec::new(), 0);
        while i < packed.len() {
            let count = packed[i] as usize;
            if count > 128 {
                back.extend(vec![packed[i + 1]; count - 128]);
                i += 2;
            } else {
                back.extend(&packed[i + 1..=i + count]);
                i += count + 1;
            }
        }
        assert_eq!(back, row);
        assert!(packed.len() < 30);
    }
}

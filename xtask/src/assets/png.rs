//! Palette images as PNG, byte for byte the same everywhere.

/// An image of at most 256 colours.
pub(super) struct Indexed {
    /// Columns.
    pub(super) width: usize,
    /// sRGB colours.
    pub(super) palette: Vec<[u8; 3]>,
    /// One index a pixel, rows from the top.
    pub(super) pixels: Vec<u8>,
}

impl Indexed {
    /// An image whose pixels are computed in sRGB and rounded to steps of 1/63, so that few colours
    /// occur.
    pub(super) fn paint(
        width: usize,
        height: usize,
        mut color: impl FnMut(usize, usize) -> [f64; 3],
    ) -> Self {
        let mut image = Self { width, palette: Vec::new(), pixels: Vec::new() };
        for y in 0..height {
            for x in 0..width {
                let step = |v: f64| (v.clamp(0.0, 1.0) * 63.0).round() as u32 * 255 / 63;
                let color = color(x, y).map(|v| step(v) as u8);
                let index = image.palette.iter().position(|&c| c == color).unwrap_or_else(|| {
                    image.palette.push(color);
                    image.palette.len() - 1
                });
                image.pixels.push(u8::try_from(index).expect("at most 256 colours"));
            }
        }
        image
    }

    /// The file: palette, and pixels in stored (uncompressed) deflate blocks.
    pub(super) fn to_png(&self) -> Vec<u8> {
        let height = self.pixels.len() / self.width;
        let mut header = Vec::new();
        header.extend((self.width as u32).to_be_bytes());
        header.extend((height as u32).to_be_bytes());
        // 8 bits, palette, deflate, adaptive filters, not interlaced.
        header.extend([8, 3, 0, 0, 0]);
        let mut rows = Vec::new();
        for row in self.pixels.chunks(self.width) {
            rows.push(0);
            rows.extend(row);
        }
        let mut png = b"\x89PNG\r\n\x1a\n".to_vec();
        chunk(&mut png, *b"IHDR", &header);
        chunk(&mut png, *b"PLTE", self.palette.as_flattened());
        chunk(&mut png, *b"IDAT", &zlib_stored(&rows));
        chunk(&mut png, *b"IEND", &[]);
        png
    }
}

fn chunk(png: &mut Vec<u8>, kind: [u8; 4], data: &[u8]) {
    png.extend((data.len() as u32).to_be_bytes());
    let start = png.len();
    png.extend(kind);
    png.extend(data);
    let crc = crc32(&png[start..]);
    png.extend(crc.to_be_bytes());
}

/// RFC 1950 around RFC 1951, section 3.2.4.
fn zlib_stored(data: &[u8]) -> Vec<u8> {
    let mut zlib = vec![0x78, 0x01];
    let mut blocks = data.chunks(0xffff).peekable();
    while let Some(block) = blocks.next() {
        zlib.push(u8::from(blocks.peek().is_none()));
        let length = block.len() as u16;
        zlib.extend(length.to_le_bytes());
        zlib.extend((!length).to_le_bytes());
        zlib.extend(block);
    }
    let (mut a, mut b) = (1_u32, 0_u32);
    for &byte in data {
        a = (a + u32::from(byte)) % 65521;
        b = (b + a) % 65521;
    }
    zlib.extend((b << 16 | a).to_be_bytes());
    zlib
}

fn crc32(data: &[u8]) -> u32 {
    !data.iter().fold(!0_u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| {
            if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 }
        })
    })
}

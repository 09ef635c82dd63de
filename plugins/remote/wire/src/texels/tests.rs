use std::{sync::Arc, time::Duration};

use farlight_gi_solver::{
    scene::InstanceId,
    session::{GridId, Placement, SnapshotId, Tile},
    sh::ShRgb,
};
use glam::{UVec3, Vec3};
use half::f16;

use super::*;
use crate::{HalfTile, Limits, ServerTimes, WireError};

fn rect(x: u32, y: u32, width: u32, height: u32) -> TexelRect {
    TexelRect { x, y, width, height }
}

/// Repeatable noise in 0..1.
fn noise(i: u32) -> f32 {
    let i = (i ^ 61 ^ (i >> 16)).wrapping_mul(0x9e37_79b9);
    let i = (i ^ (i >> 15)).wrapping_mul(0x85eb_ca6b);
    ((i ^ (i >> 13)) >> 8) as f32 / (1 << 24) as f32
}

/// Light as on a wall, with an edge, and noise of `amount`.
fn tile(page: u32, area: TexelRect, amount: f32) -> HalfTile {
    let texels = (0..area.area() as u32)
        .map(|i| {
            let (x, y) = ((area.x + i % area.width) as f32, (area.y + i / area.width) as f32);
            let lit = if x + 2.0 * y > 90.0 { 8.0 } else { 0.4 };
            let level = lit * (1.0 + 0.3 * (x * 0.1).sin() + 0.2 * (y * 0.07).cos());
            let level = level * (1.0 + amount * (noise(i + page * 9999) - 0.5));
            Vec3::new(1.0, 0.8, 0.5 + 0.01 * x) * level
        })
        .collect();
    HalfTile::new(&Tile { page: PageId(page), rect: area, texels })
}

fn grid(id: u64, resolution: UVec3) -> HalfGrid {
    let probe = |i: u32| {
        let mut sh = ShRgb::ZERO;
        for k in 0..40 {
            let at = |j| noise(i / 3 * 7 + k * 3 + j) - 0.5;
            let direction = Vec3::new(at(0), at(1), at(2)).normalize_or(Vec3::Y);
            let radiance = Vec3::new(1.0, 0.7, 0.3) * (1.0 + direction.y + 0.1 * noise(i));
            sh.add_direction(direction, radiance * (12.57 / 40.0));
        }
        sh
    };
    let probes = (0..resolution.element_product()).map(probe).collect();
    HalfGrid::new(&farlight_gi_solver::session::GridUpdate { grid: GridId(id), resolution, probes })
}

fn message() -> LightingMessage {
    LightingMessage {
        sequence: 77,
        snapshot: SnapshotId(1 << 40),
        times: ServerTimes {
            held: Duration::from_micros(12_345),
            solve: Duration::from_micros(9_999),
            encode: Duration::ZERO,
        },
        quality: Quality { relative_error: 0.011, rays_per_texel: 512, converged: false },
        placements: vec![
            Placement { instance: InstanceId(3), page: PageId(0), rect: rect(1, 1, 62, 38) },
            Placement {
                instance: InstanceId(u64::MAX),
                page: PageId(63),
                rect: rect(0, 0, 4096, 1),
            },
        ],
        refused: vec![(InstanceId(9), Arc::from("the mesh has no second UV set"))],
        tiles: vec![
            tile(0, rect(0, 0, 32, 32), 0.02),
            tile(0, rect(32, 0, 31, 32), 0.02),
            tile(1, rect(5, 7, 1, 1), 0.0),
            tile(2, rect(0, 4095, 9, 1), 0.5),
            tile(2, rect(4095, 0, 1, 9), 0.5),
        ],
        grids: vec![grid(4, UVec3::new(5, 3, 2)), HalfGrid { first: 7, ..grid(5, UVec3::ONE) }],
    }
}

/// As [`message`], but with nothing that would be left out.
fn valid() -> LightingMessage {
    let mut message = message();
    message.grids[1].resolution = UVec3::new(2, 2, 2);
    message
}

fn decode(bytes: &[u8]) -> Result<LightingMessage, WireError> {
    LightingMessage::decode(bytes, &Limits::default())
}

#[test]
fn light_comes_back_as_the_encoder_says() {
    let message = valid();
    let rounded = message.rounded();
    assert_eq!(decode(&message.encode()), Ok(rounded.clone()));
    assert_eq!(rounded.rounded(), rounded, "sending it on changes nothing");
    let plain = LightingMessage { tiles: vec![], grids: vec![], ..message.clone() };
    let head = LightingMessage { tiles: vec![], grids: vec![], ..rounded };
    assert_eq!(plain, head, "the rest is exact");
    let empty = LightingMessage::default();
    assert_eq!(decode(&empty.encode()), Ok(empty.clone()));
    assert!(empty.encode().len() < 32);
}

#[test]
fn every_half_comes_back_within_the_bound() {
    // Any order of values, as badly predictable as can be.
    let texels =
        (0..65536_u32).map(|i| std::array::from_fn(|c| ((i * 40_503) >> c) as u16)).collect();
    let tile = HalfTile { page: PageId(0), rect: rect(0, 0, 256, 256), texels };
    for relative_error in [0.0, 0.012, 0.5] {
        let quality = Quality { relative_error, ..Quality::default() };
        let bound = Step::of(&quality).error();
        let message = LightingMessage { quality, tiles: vec![tile.clone()], ..Default::default() };
        let back = decode(&message.encode()).unwrap();
        assert_eq!(back, message.rounded());
        for (sent, got) in tile.texels.iter().flatten().zip(back.tiles[0].texels.iter().flatten()) {
            let (sent, got) = (f16::from_bits(*sent).to_f32(), f16::from_bits(*got).to_f32());
            assert!(got.is_finite() && got >= 0.0);
            if sent.is_finite() && sent >= 0.0 {
                assert!((sent - got).abs() <= bound * sent.max(6.2e-5) * 1.0001, "{sent} {got}");
            }
        }
    }
}

#[test]
fn probes_come_back_within_a_part_of_their_mean() {
    let message = LightingMessage { grids: vec![grid(1, UVec3::splat(6))], ..Default::default() };
    let bytes = message.encode();
    let back = decode(&bytes).unwrap();
    assert_eq!(back, message.rounded());
    for (sent, got) in message.grids[0].to_probes().zip(back.grids[0].to_probes()) {
        let bound = sent.0[0].abs() * (1.001 / 1024.0);
        for (a, b) in sent.0.iter().zip(got.0) {
            assert!((*a - b).abs().cmple(bound).all(), "{sent:?} {got:?}");
        }
    }
    let ratio = 216.0 * 54.0 / bytes.len() as f64;
    assert!(ratio > 1.5, "{ratio}");
}

#[test]
fn odd_probes_come_back_finite_and_stay() {
    // Every half somewhere: no mean but large coefficients, negative ones, NaN, infinities.
    let value = |i: u32| (i.wrapping_mul(2_654_435_761) >> 9) as u16;
    let probes: Vec<[[u16; 3]; 9]> = (0..2000_u32)
        .map(|i| {
            std::array::from_fn(|k| {
                std::array::from_fn(|c| value(i * 27 + k as u32 * 3 + c as u32))
            })
        })
        .chain([[[0; 3]; 9], [[0x7bff; 3]; 9], [[0xfbff; 3]; 9], [[1; 3]; 9], [[0x8000; 3]; 9]])
        .collect();
    let resolution = UVec3::new(probes.len() as u32, 1, 1);
    let grids = vec![HalfGrid { grid: GridId(0), resolution, first: 0, probes }];
    let message = LightingMessage { grids, ..Default::default() };
    let back = decode(&message.encode()).unwrap();
    assert_eq!(back, message.rounded());
    assert_eq!(back.rounded(), back);
    assert!(back.grids[0].to_probes().all(|sh| sh.0.iter().all(|c| c.is_finite())));
    // What is finite keeps its size.
    for (sent, got) in message.grids[0].probes.iter().zip(&back.grids[0].probes) {
        for c in 0..3 {
            let values = |p: &[[u16; 3]; 9]| p.map(|v| f16::from_bits(v[c]).to_f32());
            let (sent, got) = (values(sent), values(got));
            if sent.iter().all(|v| v.is_finite()) {
                let largest = sent.iter().map(|v| v.abs()).fold(6.2e-5, f32::max);
                for (a, b) in sent.iter().zip(got) {
                    assert!((a - b).abs() <= largest / 1000.0, "{sent:?} {got:?}");
                }
            }
        }
    }
}

#[test]
fn light_gets_small() {
    let tiles = (0..4).map(|i| tile(0, rect(i * 32, 0, 32, 32), 0.02)).collect();
    let message = LightingMessage { tiles, ..Default::default() };
    let ratio = 4.0 * 1024.0 * 6.0 / message.encode().len() as f64;
    println!("{ratio:.2} times smaller than halves");
    assert!(ratio > 2.8, "{ratio}");
    let smooth = (0..4).map(|i| tile(0, rect(i * 32, 0, 32, 32), 0.0)).collect();
    let message = LightingMessage { tiles: smooth, ..message };
    let ratio = 4.0 * 1024.0 * 6.0 / message.encode().len() as f64;
    println!("{ratio:.2} times smaller without noise");
    assert!(ratio > 6.0, "{ratio}");
}

#[test]
fn black_is_bounded_below() {
    let black =
        HalfTile { page: PageId(0), rect: rect(0, 0, 256, 256), texels: vec![[0; 3]; 65536] };
    let message = LightingMessage { tiles: vec![black], ..Default::default() };
    let bytes = message.encode();
    assert!((1024..1100).contains(&bytes.len()), "{}", bytes.len());
    assert_eq!(decode(&bytes), Ok(message));
}

#[test]
fn what_is_not_valid_is_left_out() {
    let mut message = message();
    let good = valid().rounded();
    let tile = |page, rect: TexelRect| HalfTile {
        page: PageId(page),
        rect,
        texels: vec![[0; 3]; rect.area()],
    };
    message.tiles.push(tile(64, rect(0, 0, 1, 1)));
    message.tiles.push(tile(0, rect(4096, 0, 1, 1)));
    message.tiles.push(tile(0, rect(0, 4090, 1, 7)));
    message.tiles.push(tile(0, rect(0, 0, 0, 7)));
    message.tiles.push(HalfTile { rect: rect(0, 0, 3, 3), ..tile(0, rect(0, 0, 2, 2)) });
    message.placements.push(Placement { page: PageId(64), ..message.placements[0] });
    message.grids.push(grid(6, UVec3::ZERO));
    message.grids.push(HalfGrid { resolution: UVec3::MAX, ..grid(7, UVec3::ONE) });
    let back = decode(&message.encode()).unwrap();
    assert_eq!((back.tiles, back.placements), (good.tiles, good.placements));
    assert_eq!(back.grids.len(), 1, "the run beyond its grid went too");
    let long = "ä".repeat(200);
    message.refused = vec![(InstanceId(1), Arc::from(long)); 5000];
    let back = decode(&message.encode()).unwrap();
    assert_eq!((back.refused.len(), back.refused[0].1.len()), (REFUSED, REASON));
}

/// Brighter light with the same noise: almost nothing but the difference is sent.
#[test]
fn tiles_beside_a_base_are_small_and_exact() {
    let mut new = valid();
    new.tiles[1] = tile(0, rect(32, 0, 31, 32), 0.5);
    let old = LightingMessage { sequence: 3, ..new.clone() }.rounded();
    for texel in new.tiles.iter_mut().flat_map(|tile| &mut tile.texels) {
        *texel = texel.map(|bits| f16::from_f32(f16::from_bits(bits).to_f32() * 1.2).to_bits());
    }
    // One tile the other side does not have, one has become another light altogether.
    new.tiles[3].rect.x = 16;
    new.tiles[0].texels.reverse();
    for probe in new.grids.iter_mut().flat_map(|grid| &mut grid.probes) {
        *probe = probe
            .map(|c| c.map(|bits| f16::from_f32(f16::from_bits(bits).to_f32() * 1.1).to_bits()));
    }
    let find = |piece: Piece| {
        let tile = old.tiles.iter().find(|t| t.piece() == piece).map(|t| &t.texels[..]);
        let run = || old.grids.iter().find(|g| g.piece() == piece);
        tile.or_else(|| Some(run()?.probes.as_flattened()))
    };
    let (bytes, sent) = new.clone().encode_beside(|piece| Some((3, find(piece)?)));
    let base = |piece, number| find(piece).filter(|_| number == 3);
    let limits = Limits::default();
    let back = LightingMessage::decode_beside(&bytes, &limits, base).unwrap();
    assert_eq!(back, sent);
    assert_eq!(back.tiles[0], new.rounded().tiles[0], "coded by itself");
    assert!(bytes.len() + 1000 < new.encode().len(), "{} {}", bytes.len(), new.encode().len());
    for (tile, exact) in back.tiles.iter().zip(&new.tiles) {
        for (got, sent) in tile.texels.iter().flatten().zip(exact.texels.iter().flatten()) {
            assert!(got.abs_diff(*sent) <= Step::of(&new.quality).units(), "{got} {sent}");
        }
    }
    // Who has lost a base still finds the others.
    let gone = [new.tiles[1].piece(), new.grids[0].piece()];
    let lost = |piece, number| base(piece, number).filter(|_| !gone.contains(&piece));
    let back = LightingMessage::decode_beside(&bytes, &limits, lost).unwrap();
    assert!(back.grids[0].probes.is_empty() && !back.is_whole());
    assert_eq!(back.grids[1], sent.grids[1]);
    for (i, tile) in back.tiles.iter().enumerate() {
        if i == 1 {
            assert!(tile.texels.is_empty());
        } else {
            assert_eq!(tile, &sent.tiles[i]);
        }
    }
    assert!(decode(&bytes).is_err());
}

#[test]
fn cut_and_lengthened_messages_are_refused() {
    let bytes = valid().encode();
    for length in 0..bytes.len() {
        assert!(decode(&bytes[..length]).is_err(), "{length}");
    }
    let longer = [&bytes[..], &[0]].concat();
    assert!(decode(&longer).is_err());
}

#[test]
fn limits_hold() {
    let message = valid();
    let bytes = message.encode();
    let texels = message.texels();
    let exact = Limits { texels, probes: 31, objects: 2, ..Limits::default() };
    assert!(LightingMessage::decode(&bytes, &exact).is_ok());
    for limits in [
        Limits { texels: texels - 1, ..exact },
        Limits { probes: 30, ..exact },
        Limits { objects: 1, ..exact },
    ] {
        let error = LightingMessage::decode(&bytes, &limits).unwrap_err();
        assert!(matches!(error, WireError::TooLarge { .. }), "{error}");
    }
}

/// Writes a message by hand, with some of its parts wrong.
#[derive(Clone, Copy)]
struct Forged {
    error: f32,
    rect: [u64; 5],
    distance: u64,
    resolution: [u64; 3],
    first: u64,
    count: u64,
    code: usize,
}

const FAIR: Forged = Forged {
    error: 0.0,
    rect: [0, 0, 0, 8, 8],
    distance: 0,
    resolution: [2, 2, 2],
    first: 4,
    count: 4,
    code: 2,
};

impl Forged {
    fn decode(self) -> Result<LightingMessage, WireError> {
        let mut out = Writer::default();
        (0..2).for_each(|_| out.varint(0));
        (0..3).for_each(|_| out.u32(0));
        out.f32(self.error);
        // Rays, convergence, no placements, nothing refused, one tile, one grid.
        out.raw(&[0, 0, 0, 0, 1]);
        self.rect.into_iter().for_each(|n| out.varint(n));
        out.varint(self.distance);
        out.raw(&[1, 9]);
        self.resolution.into_iter().for_each(|n| out.varint(n));
        out.varint(self.first);
        out.varint(self.count);
        out.varint(self.distance);
        out.bytes(&vec![0; self.code]);
        decode(&out.finish())
    }
}

#[test]
fn lies_are_refused() {
    assert!(FAIR.decode().is_ok());
    let refused = |forged: Forged| assert!(forged.decode().is_err());
    refused(Forged { error: f32::NAN, ..FAIR });
    refused(Forged { distance: 1, ..FAIR });
    for rect in [
        [64, 0, 0, 8, 8],
        [0, 4096, 0, 1, 8],
        [0, 4095, 0, 2, 8],
        [0, 0, 0, 0, 8],
        [0, 0, 0, 8, 4097],
        [0, u64::from(u32::MAX), 0, 2, 8],
        [0, 1 << 32, 0, 8, 8],
        [1 << 32, 0, 0, 8, 8],
    ] {
        refused(Forged { rect, ..FAIR });
    }
    for resolution in [[1 << 16, 1 << 16, 1], [0, 2, 2], [1 << 21, 1, 1], [1 << 32, 1, 1]] {
        refused(Forged { resolution, ..FAIR });
    }
    refused(Forged { first: 5, ..FAIR });
    refused(Forged { count: u64::from(u32::MAX), ..FAIR });
    refused(Forged { first: u64::from(u32::MAX), count: 1, ..FAIR });
    // 64 texels and 4 probes need two bytes.
    refused(Forged { code: 1, ..FAIR });
    refused(Forged { rect: [0, 0, 0, 4096, 4096], code: 1000, ..FAIR });
}

/// The format is part of the protocol's version: if this fails, raise that.
#[test]
fn golden_bytes() {
    let message = LightingMessage {
        sequence: 300,
        snapshot: SnapshotId(5),
        quality: Quality { relative_error: 0.012, rays_per_texel: 1024, converged: true },
        placements: vec![Placement {
            instance: InstanceId(8),
            page: PageId(1),
            rect: rect(4, 4, 6, 3),
        }],
        refused: vec![(InstanceId(9), Arc::from("why"))],
        tiles: vec![tile(1, rect(4, 4, 6, 3), 0.1)],
        grids: vec![grid(2, UVec3::new(2, 1, 1))],
        ..Default::default()
    };
    let bytes = message.encode();
    let hex: String = bytes.iter().map(|b| format!("{b:02x}")).collect();
    assert_eq!(hex, GOLDEN);
    assert_eq!(decode(&bytes), Ok(message.rounded()));
}

const GOLDEN: &str = "\
    ac0205000000000000000000000000a69b443c8008010108010404060301090377687901010404060300010202010100\
    02\
    0046390209d6877d05713605b8a6a8982c70503495a4cb561c48119778ea739e14d7ae163da1a1ee\
    e70f6e7df165f4da1a37e95c525ea9b8586e99c3f0c535d389359e62088412cf";

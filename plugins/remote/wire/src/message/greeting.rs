//! The first message of each side.

use farlight_gi_solver::session::{SessionSettings, SnapshotId};

use super::{MAJOR, MINOR, Service, clip, service};
use crate::{
    Channel, ClientHello, Limits, Token, Welcome, WireError,
    codec::{Reader, Writer},
};

/// What greetings begin with.
const MARK: [u8; 8] = *b"farlight";
/// Kinds of greetings.
const HELLO: u16 = 1;
const WELCOME: u16 = 2;
/// Bytes of a client's name; characters are at most four bytes.
const MAX_NAME: usize = 256;

impl ClientHello {
    /// Characters of a name at most; longer ones are cut off.
    pub const NAME_CHARS: usize = 64;

    pub(crate) fn encode(&self) -> Vec<u8> {
        let mut w = begin(HELLO);
        w.raw(&self.token.0);
        w.u8(self.resume.is_some().into());
        w.raw(&self.resume.map_or([0; 16], |key| key.0));
        w.bytes(clip(&self.name, MAX_NAME).as_bytes());
        write_settings(&mut w, &self.settings);
        service::write(&mut w, &Service::ALL);
        w.finish()
    }

    /// Reads the first message of a connection.
    ///
    /// # Errors
    /// It is not a greeting, of a version that can't be understood, or asks for nothing that this
    /// server has.
    pub fn read(channel: Channel, message: &[u8], limits: &Limits) -> Result<Self, WireError> {
        if channel != Channel::Control {
            return Err(WireError::Unexpected("a greeting on another channel".into()));
        }
        let mut r = open("the greeting", message, HELLO)?;
        let token = Token(r.array()?);
        let (has_key, key) = (r.flag()?, r.array()?);
        let name = r.text(MAX_NAME)?;
        let name = name.chars().filter(|c| !c.is_control()).take(Self::NAME_CHARS).collect();
        let settings = read_settings(&mut r)?;
        let edge = settings.page_size as usize;
        let texels = edge.saturating_mul(edge).saturating_mul(settings.max_pages as usize);
        WireError::check("texels of the lightmap pages", texels, limits.texels)?;
        if super::agree(&Service::ALL, &service::read(&mut r)?).is_empty() {
            return Err(r.invalid("the client asks for services that this version lacks"));
        }
        Ok(Self { name, token, resume: has_key.then_some(Token(key)), settings })
    }
}

impl Welcome {
    pub(crate) fn encode(&self) -> Vec<u8> {
        let mut w = begin(WELCOME);
        w.raw(&self.key.0);
        w.u8(self.resumed.into());
        w.u64(self.snapshot.0);
        write_settings(&mut w, &self.settings);
        service::write(&mut w, &Service::ALL);
        w.finish()
    }

    pub(crate) fn read(message: &[u8]) -> Result<Self, WireError> {
        let mut r = open("the welcome", message, WELCOME)?;
        let (key, resumed) = (Token(r.array()?), r.flag()?);
        let snapshot = SnapshotId(r.u64()?);
        let settings = read_settings(&mut r)?;
        if super::agree(&Service::ALL, &service::read(&mut r)?).is_empty() {
            return Err(r.invalid("the server has no service that this version knows"));
        }
        Ok(Self { key, resumed, snapshot, settings })
    }
}

fn begin(kind: u16) -> Writer {
    let mut w = Writer::default();
    w.raw(&MARK);
    w.u16(MAJOR);
    w.u16(MINOR);
    w.u16(kind);
    w
}

fn open<'a>(what: &'static str, message: &'a [u8], expected: u16) -> Result<Reader<'a>, WireError> {
    let mut r = Reader::new(what, message);
    if r.array()? != MARK {
        return Err(r.invalid("it does not begin with the mark of this protocol"));
    }
    let (major, _minor) = (r.u16()?, r.u16()?);
    if major != MAJOR {
        return Err(WireError::Version { ours: MAJOR, theirs: major });
    }
    match r.u16()? {
        kind if kind == expected => Ok(r),
        kind => Err(r.invalid(format_args!("kind {kind} is not expected here"))),
    }
}

fn write_settings(w: &mut Writer, settings: &SessionSettings) {
    w.u32(settings.page_size);
    w.u32(settings.max_pages);
    w.f32(settings.texels_per_metre);
    w.u32(settings.rays_per_texel);
    w.u32(settings.rays_per_probe);
    w.u64(settings.ray_memory as u64);
    w.u32(settings.bounces);
    w.u32(settings.converged_paths);
    w.u64(settings.seed);
}

fn read_settings(r: &mut Reader<'_>) -> Result<SessionSettings, WireError> {
    let settings = SessionSettings {
        page_size: r.u32()?,
        max_pages: r.u32()?,
        texels_per_metre: r.floats::<1>()?[0],
        rays_per_texel: r.u32()?,
        rays_per_probe: r.u32()?,
        ray_memory: usize::try_from(r.u64()?).unwrap_or(usize::MAX),
        bounces: r.u32()?,
        converged_paths: r.u32()?,
        seed: r.u64()?,
        threads: 0,
    };
    let page = settings.page_size;
    if !(page.is_power_of_two() && (16..=4096).contains(&page)) {
        return Err(r.invalid(format_args!("pages of {page} texels; 16 to 4096 are known")));
    }
    if !(1..=64).contains(&settings.max_pages) {
        return Err(r.invalid(format_args!("{} pages; 1 to 64 are known", settings.max_pages)));
    }
    Ok(settings)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hello() -> ClientHello {
        ClientHello {
            name: "game".into(),
            token: Token([3; 16]),
            resume: Some(Token([4; 16])),
            settings: SessionSettings { page_size: 128, threads: 0, ..Default::default() },
        }
    }

    #[test]
    fn greetings_come_back() {
        let read = |hello: &ClientHello| {
            ClientHello::read(Channel::Control, &hello.encode(), &Limits::default())
        };
        assert_eq!(read(&hello()), Ok(hello()));
        let fresh = ClientHello { resume: None, ..hello() };
        assert_eq!(read(&fresh), Ok(fresh.clone()));
        let odd = ClientHello { name: format!("a\n{}", "é".repeat(300)), ..hello() };
        assert_eq!(read(&odd).map(|h| h.name), Ok(format!("a{}", "é".repeat(63))));
        let welcome = Welcome {
            key: Token([5; 16]),
            resumed: true,
            snapshot: SnapshotId(9),
            settings: hello().settings,
        };
        assert_eq!(Welcome::read(&welcome.encode()), Ok(welcome));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let bytes = hello().encode();
        let read = |bytes: &[u8]| ClientHello::read(Channel::Control, bytes, &Limits::default());
        for end in 0..bytes.len() {
            assert!(read(&bytes[..end]).is_err(), "{end}");
        }
        let mut other = bytes.clone();
        other[8] = 77;
        assert_eq!(read(&other), Err(WireError::Version { ours: MAJOR, theirs: 77 }));
        let mut other = bytes.clone();
        other[0] = b'F';
        assert!(matches!(read(&other), Err(WireError::Invalid { .. })));
        assert!(Welcome::read(&bytes).is_err());
        let limits = Limits { texels: 1000, ..Default::default() };
        let small = ClientHello::read(Channel::Control, &bytes, &limits);
        assert!(matches!(small, Err(WireError::TooLarge { .. })), "{small:?}");
        let mut longer = bytes;
        longer.extend([1, 2, 3]);
        assert!(read(&longer).is_ok(), "a newer version may add fields");
    }
}

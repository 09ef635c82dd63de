//! The few functions of Embree 3 that the comparison needs, found at run time.
//!
//! Layouts and constants are those of Embree 3.13's `rtcore_ray.h`, `rtcore_common.h`,
//! `rtcore_geometry.h` and `rtcore_scene.h`.

use std::{
    ffi::{c_char, c_int, c_uint, c_void},
    ptr::{null, null_mut},
};

use farlight_gi_solver::tracer::Ray;
use glam::Vec3;
use libloading::Library;

use crate::Peer;

const INVALID: u32 = u32::MAX;
const GEOMETRY_TYPE_TRIANGLE: c_int = 0;
const BUFFER_TYPE_INDEX: c_int = 0;
const BUFFER_TYPE_VERTEX: c_int = 1;
const FORMAT_UINT3: c_int = 0x5003;
const FORMAT_FLOAT3: c_int = 0x9003;
const DEVICE_PROPERTY_VERSION: c_int = 0;

type Handle = *mut c_void;

#[repr(C, align(16))]
struct RtcRay {
    origin: [f32; 3],
    t_near: f32,
    direction: [f32; 3],
    time: f32,
    t_far: f32,
    mask: u32,
    id: u32,
    flags: u32,
}

#[repr(C, align(16))]
struct RtcRayHit {
    ray: RtcRay,
    normal: [f32; 3],
    u: f32,
    v: f32,
    primitive: u32,
    geometry: u32,
    instance: [u32; 1],
}

#[repr(C)]
struct RtcContext {
    flags: c_int,
    filter: *const c_void,
    instance: [u32; 1],
}

/// `RTCBuildQuality`.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Quality {
    Medium = 1,
    High = 2,
}

/// The loaded library.
pub(crate) struct Embree {
    new_device: unsafe extern "C" fn(*const c_char) -> Handle,
    device_property: unsafe extern "C" fn(Handle, c_int) -> isize,
    new_scene: unsafe extern "C" fn(Handle) -> Handle,
    set_quality: unsafe extern "C" fn(Handle, c_int),
    new_geometry: unsafe extern "C" fn(Handle, c_int) -> Handle,
    new_buffer: unsafe extern "C" fn(Handle, c_int, c_uint, c_int, usize, usize) -> *mut c_void,
    commit_geometry: unsafe extern "C" fn(Handle),
    attach_geometry: unsafe extern "C" fn(Handle, Handle) -> c_uint,
    commit_scene: unsafe extern "C" fn(Handle),
    intersect: unsafe extern "C" fn(Handle, *mut RtcContext, *mut RtcRayHit),
    occluded: unsafe extern "C" fn(Handle, *mut RtcContext, *mut RtcRay),
    _library: Library,
}

/// A scene of one triangle mesh. Its device lives as long as the program.
pub(crate) struct Scene<'a> {
    library: &'a Embree,
    device: Handle,
    scene: Handle,
    quality: Quality,
}

impl Embree {
    /// Looks for Embree 3 where the system keeps its libraries.
    pub(crate) fn load() -> Result<&'static Self, String> {
        let names = ["libembree3.so.3", "libembree3.so", "embree3.dll", "libembree3.dylib"];
        let mut reason = String::new();
        for name in names {
            // SAFETY: Embree's initialization is that of any shared library.
            match unsafe { Library::new(name) } {
                Ok(library) => return Self::resolve(library).map(|e| &*Box::leak(Box::new(e))),
                Err(e) => reason = format!("{e} (Debian and Ubuntu: libembree-dev, version 3)"),
            }
        }
        Err(reason)
    }

    fn resolve(library: Library) -> Result<Self, String> {
        macro_rules! get {
            ($name:literal) => {
                // SAFETY: the type is that of Embree 3's header.
                *unsafe { library.get($name) }.map_err(|e| e.to_string())?
            };
        }
        Ok(Self {
            new_device: get!(b"rtcNewDevice\0"),
            device_property: get!(b"rtcGetDeviceProperty\0"),
            new_scene: get!(b"rtcNewScene\0"),
            set_quality: get!(b"rtcSetSceneBuildQuality\0"),
            new_geometry: get!(b"rtcNewGeometry\0"),
            new_buffer: get!(b"rtcSetNewGeometryBuffer\0"),
            commit_geometry: get!(b"rtcCommitGeometry\0"),
            attach_geometry: get!(b"rtcAttachGeometry\0"),
            commit_scene: get!(b"rtcCommitScene\0"),
            intersect: get!(b"rtcIntersect1\0"),
            occluded: get!(b"rtcOccluded1\0"),
            _library: library,
        })
    }

    /// Builds a scene of these triangles with Embree's default flags.
    pub(crate) fn scene(&self, triangles: &[[Vec3; 3]], quality: Quality) -> Scene<'_> {
        // SAFETY: calls as the header asks for them; the buffers have the sizes given.
        unsafe {
            let device = (self.new_device)(null());
            let scene = (self.new_scene)(device);
            (self.set_quality)(scene, quality as c_int);
            let mesh = (self.new_geometry)(device, GEOMETRY_TYPE_TRIANGLE);
            let n = triangles.len();
            let vertices = (self.new_buffer)(mesh, BUFFER_TYPE_VERTEX, 0, FORMAT_FLOAT3, 12, 3 * n);
            std::ptr::copy_nonoverlapping(
                triangles.as_ptr().cast::<Vec3>(),
                vertices.cast(),
                3 * n,
            );
            let indices = (self.new_buffer)(mesh, BUFFER_TYPE_INDEX, 0, FORMAT_UINT3, 12, n);
            for i in 0..3 * n {
                indices.cast::<u32>().add(i).write(i as u32);
            }
            (self.commit_geometry)(mesh);
            (self.attach_geometry)(scene, mesh);
            (self.commit_scene)(scene);
            Scene { library: self, device, scene, quality }
        }
    }
}

fn context() -> RtcContext {
    RtcContext { flags: 0, filter: null_mut(), instance: [INVALID] }
}

fn convert(ray: &Ray) -> RtcRay {
    RtcRay {
        origin: ray.origin.to_array(),
        t_near: ray.t_min,
        direction: ray.direction.to_array(),
        time: 0.0,
        t_far: ray.t_max,
        mask: u32::MAX,
        id: 0,
        flags: 0,
    }
}

impl Peer for Scene<'_> {
    fn name(&self) -> String {
        // SAFETY: the device is alive.
        let v = unsafe { (self.library.device_property)(self.device, DEVICE_PROPERTY_VERSION) };
        let version = format!("{}.{}.{}", v / 10000, v / 100 % 100, v % 100);
        format!("Embree {version} ({:?} quality)", self.quality)
    }

    #[inline]
    fn closest(&self, ray: &Ray) -> f32 {
        let mut context = context();
        let mut query = RtcRayHit {
            ray: convert(ray),
            normal: [0.0; 3],
            u: 0.0,
            v: 0.0,
            primitive: INVALID,
            geometry: INVALID,
            instance: [INVALID],
        };
        // SAFETY: the scene is committed; the structures are laid out as the header says.
        unsafe { (self.library.intersect)(self.scene, &mut context, &mut query) };
        if query.geometry == INVALID { f32::INFINITY } else { query.ray.t_far }
    }

    #[inline]
    fn occluded(&self, ray: &Ray) -> bool {
        let mut context = context();
        let mut query = convert(ray);
        // SAFETY: as in `closest`.
        unsafe { (self.library.occluded)(self.scene, &mut context, &mut query) };
        query.t_far < 0.0
    }
}

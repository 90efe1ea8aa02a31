//! Embree 3 and 4 through their C API, opened at run time. Declarations below are our own.
use crate::clock;
use crate::peer::*;
use libloading::Library;
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::ffi::{CStr, CString, c_char, c_int, c_uint, c_void};
use std::rc::{Rc, Weak};

type P = *mut c_void;

const ROBUST: c_uint = 4;
const COMPACT: c_uint = 2;
const MEDIUM: c_uint = 1;
const HIGH: c_uint = 2;

#[repr(C, align(16))]
#[derive(Clone, Copy)]
struct RayHit1 {
    org: [f32; 3],
    tnear: f32,
    dir: [f32; 3],
    time: f32,
    tfar: f32,
    mask: u32,
    id: u32,
    flags: u32,
    ng: [f32; 3],
    u: f32,
    v: f32,
    prim: u32,
    geom: u32,
    inst: [u32; 2], // second word: instance primitive id of newer versions
}

macro_rules! packet {
    ($name:ident, $k:literal, $align:literal) => {
        #[repr(C, align($align))]
        #[derive(Clone, Copy)]
        struct $name {
            valid: [i32; $k],
            org: [[f32; $k]; 3],
            tnear: [f32; $k],
            dir: [[f32; $k]; 3],
            time: [f32; $k],
            tfar: [f32; $k],
            mask: [u32; $k],
            id: [u32; $k],
            flags: [u32; $k],
            ng: [[f32; $k]; 3],
            uv: [[f32; $k]; 2],
            prim: [u32; $k],
            geom: [u32; $k],
            inst: [[u32; $k]; 2],
        }
        impl $name {
            #[inline(always)]
            fn load(rays: &[Ray]) -> Self {
                // lanes past the end repeat the last ray (they stay invalid)
                let mut p: Self = unsafe { std::mem::zeroed() };
                for k in 0..$k {
                    let r = &rays[k.min(rays.len() - 1)];
                    p.valid[k] = if k < rays.len() { -1 } else { 0 };
                    for a in 0..3 {
                        p.org[a][k] = r.o[a];
                        p.dir[a][k] = r.d[a];
                    }
                    p.tfar[k] = r.tmax;
                }
                p.mask = [u32::MAX; $k];
                p.geom = [u32::MAX; $k];
                p.prim = [u32::MAX; $k];
                p.inst = [[u32::MAX; $k]; 2];
                p
            }
        }
    };
}
packet!(Packet8, 8, 64);
packet!(Packet16, 16, 64);

/// Query context: version 3 reads {flags, filter, instance ids}; version 4 takes {flags, features, context, ..}.
#[repr(C)]
struct Context3 {
    flags: u32,
    filter: P,
    inst: u32,
    pad: [u32; 3],
}
#[repr(C)]
struct Context4 {
    inst: [u32; 4],
}
#[repr(C)]
struct Args4 {
    flags: u32,
    features: u32,
    context: *mut Context4,
    filter: P,
    callback: P,
    width: f32,
    pad: u32,
}

pub struct Lib {
    /// Never closed: unloading Embree's task scheduler at exit is not safe.
    lib: &'static Library,
    pub major: u32,
    pub version: String,
    scenes: RefCell<HashMap<Key, Weak<Built1>>>,
}

type Key = (&'static str, c_uint, c_uint);

impl Lib {
    /// Opens the first of `paths` that can be opened.
    pub fn open(paths: &[String]) -> Option<Lib> {
        for p in paths {
            let Ok(lib) = (unsafe { Library::new(p) }) else { continue };
            let mut l =
                Lib { lib: Box::leak(Box::new(lib)), major: 0, version: String::new(), scenes: Default::default() };
            unsafe {
                let dev = l.device("threads=1");
                let prop: unsafe extern "C" fn(P, c_int) -> isize = l.f("rtcGetDeviceProperty");
                let v = [1, 2, 3].map(|k| prop(dev, k));
                l.major = v[0] as u32;
                l.version = format!("{}.{}.{}", v[0], v[1], v[2]);
                let rel: unsafe extern "C" fn(P) = l.f("rtcReleaseDevice");
                rel(dev);
            }
            return Some(l);
        }
        None
    }
    fn f<T: Copy>(&self, name: &str) -> T {
        let n = CString::new(name).unwrap();
        unsafe { *self.lib.get::<T>(n.as_bytes_with_nul()).unwrap_or_else(|e| panic!("{name}: {e}")) }
    }
    unsafe fn device(&self, cfg: &str) -> P {
        let new: unsafe extern "C" fn(*const c_char) -> P = self.f("rtcNewDevice");
        let c = CString::new(cfg).unwrap();
        let d = unsafe { new(c.as_ptr()) };
        assert!(!d.is_null(), "rtcNewDevice({cfg})");
        let on_error: unsafe extern "C" fn(P, extern "C" fn(P, c_int, *const c_char), P) =
            self.f("rtcSetDeviceErrorFunction");
        extern "C" fn report(_: P, code: c_int, s: *const c_char) {
            eprintln!("embree error {code}: {}", unsafe { CStr::from_ptr(s) }.to_string_lossy());
        }
        unsafe { on_error(d, report, std::ptr::null_mut()) };
        d
    }
}

struct Built1 {
    lib: Rc<Lib>,
    dev: P,
    scene: P,
    ms: f64,
    bytes: usize,
    _verts: Vec<f32>,
    _index: Vec<u32>,
    _live: Box<Cell<isize>>,
}

impl Drop for Built1 {
    fn drop(&mut self) {
        unsafe {
            let a: unsafe extern "C" fn(P) = self.lib.f("rtcReleaseScene");
            a(self.scene);
            let b: unsafe extern "C" fn(P) = self.lib.f("rtcReleaseDevice");
            b(self.dev);
        }
    }
}

extern "C" fn monitor(p: P, bytes: isize, _post: bool) -> bool {
    let c = unsafe { &*(p as *const Cell<isize>) };
    c.set(c.get() + bytes);
    true
}

fn build(lib: &Rc<Lib>, key: Key, tris: &[Tri]) -> Rc<Built1> {
    if let Some(s) = lib.scenes.borrow().get(&key).and_then(|w| w.upgrade()) {
        return s;
    }
    let (cfg, flags, quality) = key;
    // buffers stay ours ("shared"); 16 bytes of padding are required after the last vertex
    let mut verts: Vec<f32> = tris.iter().flatten().flatten().copied().collect();
    verts.extend([0.0; 4]);
    let index: Vec<u32> = (0..tris.len() as u32 * 3).collect();
    let live = Box::new(Cell::new(0isize));
    unsafe {
        let dev = lib.device(&format!("threads=1{}{cfg}", if cfg.is_empty() { "" } else { "," }));
        let mon: unsafe extern "C" fn(P, extern "C" fn(P, isize, bool) -> bool, P) =
            lib.f("rtcSetDeviceMemoryMonitorFunction");
        mon(dev, monitor, &*live as *const _ as P);
        let new_scene: unsafe extern "C" fn(P) -> P = lib.f("rtcNewScene");
        let scene_flags: unsafe extern "C" fn(P, c_uint) = lib.f("rtcSetSceneFlags");
        let scene_quality: unsafe extern "C" fn(P, c_uint) = lib.f("rtcSetSceneBuildQuality");
        let new_geom: unsafe extern "C" fn(P, c_uint) -> P = lib.f("rtcNewGeometry");
        let buffer: unsafe extern "C" fn(P, c_uint, c_uint, c_uint, *const c_void, usize, usize, usize) =
            lib.f("rtcSetSharedGeometryBuffer");
        let geom_quality: unsafe extern "C" fn(P, c_uint) = lib.f("rtcSetGeometryBuildQuality");
        let commit_geom: unsafe extern "C" fn(P) = lib.f("rtcCommitGeometry");
        let attach: unsafe extern "C" fn(P, P) -> c_uint = lib.f("rtcAttachGeometry");
        let release_geom: unsafe extern "C" fn(P) = lib.f("rtcReleaseGeometry");
        let commit: unsafe extern "C" fn(P) = lib.f("rtcCommitScene");
        let scene = new_scene(dev);
        scene_flags(scene, flags);
        scene_quality(scene, quality);
        let g = new_geom(dev, 0);
        geom_quality(g, quality);
        buffer(g, 1, 0, 0x9003, verts.as_ptr() as _, 0, 12, tris.len() * 3);
        buffer(g, 0, 0, 0x5003, index.as_ptr() as _, 0, 12, tris.len());
        commit_geom(g);
        attach(scene, g);
        release_geom(g);
        let t0 = clock::thread();
        commit(scene);
        let ms = (clock::thread() - t0) * 1e3;
        // compact scenes keep only indices in the leaves and read the caller's buffers during traversal
        let extra = if flags & COMPACT != 0 { 48 * tris.len() } else { 0 };
        let bytes = live.get().max(0) as usize + extra;
        let b = Rc::new(Built1 { lib: lib.clone(), dev, scene, ms, bytes, _verts: verts, _index: index, _live: live });
        lib.scenes.borrow_mut().insert(key, Rc::downgrade(&b));
        b
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Mode {
    Single,
    P8,
    P16,
    Stream64,
}

struct Embree {
    lib: Rc<Lib>,
    key: Key,
    mode: Mode,
    coherent: bool,
    extra: bool,
    scene: Option<Rc<Built1>>,
}

/// Calls `$go(context pointer)` with a version 3 context or version 4 arguments.
macro_rules! with_context {
    ($self:ident, $p:ident => $body:block) => {
        if $self.lib.major == 3 {
            let mut c =
                Context3 { flags: $self.coherent as u32, filter: std::ptr::null_mut(), inst: u32::MAX, pad: [0; 3] };
            let $p = &mut c as *mut _ as P;
            $body
        } else {
            let mut c = Context4 { inst: [u32::MAX; 4] };
            let mut a = Args4 {
                flags: ($self.coherent as u32) << 16,
                features: u32::MAX,
                context: &mut c,
                filter: std::ptr::null_mut(),
                callback: std::ptr::null_mut(),
                width: 0.0,
                pad: 0,
            };
            let $p = &mut a as *mut _ as P;
            $body
        }
    };
}

#[inline(always)]
fn fill(r: &Ray) -> RayHit1 {
    RayHit1 {
        org: r.o,
        tnear: 0.0,
        dir: r.d,
        time: 0.0,
        tfar: r.tmax,
        mask: u32::MAX,
        id: 0,
        flags: 0,
        ng: [0.0; 3],
        u: 0.0,
        v: 0.0,
        prim: u32::MAX,
        geom: u32::MAX,
        inst: [u32::MAX; 2],
    }
}
#[inline(always)]
fn hit(geom: u32, t: f32, prim: u32) -> Hit {
    if geom == u32::MAX { Hit::MISS } else { Hit { t, prim } }
}

macro_rules! packets {
    ($self:ident, $rays:ident, $out:ident, $k:literal, $ty:ident, $isect:literal, $occl:literal, closest) => {{
        let s = $self.scene.as_ref().unwrap().scene;
        let f: P = $self.lib.f::<P>($isect);
        with_context!($self, ctx => {
            for (r, o) in $rays.chunks($k).zip($out.chunks_mut($k)) {
                let mut p = $ty::load(r);
                unsafe {
                    let (v, body) = (p.valid.as_ptr(), p.org.as_mut_ptr() as P);
                    if $self.lib.major == 3 {
                        let f: unsafe extern "C" fn(*const i32, P, P, P) = std::mem::transmute(f);
                        f(v, s, ctx, body)
                    } else {
                        let f: unsafe extern "C" fn(*const i32, P, P, P) = std::mem::transmute(f);
                        f(v, s, body, ctx)
                    }
                }
                for (k, o) in o.iter_mut().enumerate() {
                    *o = hit(p.geom[k], p.tfar[k], p.prim[k]);
                }
            }
        })
    }};
    ($self:ident, $rays:ident, $out:ident, $k:literal, $ty:ident, $isect:literal, $occl:literal, any) => {{
        let s = $self.scene.as_ref().unwrap().scene;
        let f: P = $self.lib.f::<P>($occl);
        with_context!($self, ctx => {
            for (r, o) in $rays.chunks($k).zip($out.chunks_mut($k)) {
                let mut p = $ty::load(r);
                unsafe {
                    let (v, body) = (p.valid.as_ptr(), p.org.as_mut_ptr() as P);
                    let f: unsafe extern "C" fn(*const i32, P, P, P) = std::mem::transmute(f);
                    if $self.lib.major == 3 { f(v, s, ctx, body) } else { f(v, s, body, ctx) }
                }
                for (k, o) in o.iter_mut().enumerate() {
                    *o = p.tfar[k] < 0.0;
                }
            }
        })
    }};
}

impl Peer for Embree {
    fn name(&self) -> String {
        let (cfg, flags, q) = self.key;
        let mut n = format!("embree{}-", self.lib.major);
        n += match self.mode {
            Mode::Single => "i1",
            Mode::P8 => "p8",
            Mode::P16 => "p16",
            Mode::Stream64 => "stream64",
        };
        if self.coherent {
            n += "-coh";
        }
        if q == HIGH {
            n += "-high";
        }
        if flags & ROBUST != 0 {
            n += "-robust";
        }
        if flags & COMPACT != 0 {
            n += "-compact";
        }
        if cfg == "max_isa=avx2" {
            n += "-avx2";
        } else if cfg.contains("qbvh8") {
            n += "-qbvh8";
        }
        n
    }
    fn info(&self) -> String {
        let (cfg, flags, q) = self.key;
        let (node, tri) = if cfg.contains("qbvh8") {
            ("8-wide 8-bit-quantized nodes", "Triangle4 leaves, 4-wide Moeller-Trumbore")
        } else if flags & COMPACT != 0 {
            ("4-wide float nodes, 128 B", "Triangle4i leaves (indices), 4-wide")
        } else if flags & ROBUST != 0 {
            ("8-wide float nodes, 256 B", "Triangle4v leaves (vertices), 4-wide Pluecker (watertight)")
        } else {
            ("8-wide float nodes, 256 B", "Triangle4 leaves (v0,e1,e2), 176 B, 4-wide Moeller-Trumbore")
        };
        let rays = match self.mode {
            Mode::Single => "1 ray x 8 boxes",
            Mode::P8 => "packets of 8 rays (falls back to single when few are active)",
            Mode::P16 => "packets of 16 rays (falls back to single when few are active)",
            Mode::Stream64 => "streams of 64 rays (rtcIntersect1M)",
        };
        format!(
            "Embree {} {}, {} build, {node}, {tri}, {rays}",
            self.lib.version,
            if cfg.contains("avx2") { "AVX2" } else { "AVX2/AVX-512 (chosen by CPU)" },
            if flags & ROBUST != 0 || q == MEDIUM { "binned SAH" } else { "SAH with spatial splits" },
        )
    }
    fn extra(&self) -> bool {
        self.extra
    }
    fn build(&mut self, tris: &[Tri]) -> Built {
        let b = build(&self.lib, self.key, tris);
        let r = Built { ms: b.ms, bytes: Some(b.bytes) };
        self.scene = Some(b);
        r
    }
    fn clear(&mut self) {
        self.scene = None;
    }
    fn closest(&self, rays: &[Ray], out: &mut [Hit]) {
        let s = self.scene.as_ref().unwrap().scene;
        match self.mode {
            Mode::Single => {
                let f: unsafe extern "C" fn(P, P, P) = self.lib.f("rtcIntersect1");
                let three = self.lib.major == 3;
                with_context!(self, ctx => {
                    for (r, o) in rays.iter().zip(out) {
                        let mut h = fill(r);
                        let p = &mut h as *mut _ as P;
                        unsafe { if three { f(s, ctx, p) } else { f(s, p, ctx) } }
                        *o = hit(h.geom, h.tfar, h.prim);
                    }
                })
            }
            Mode::P8 => packets!(self, rays, out, 8, Packet8, "rtcIntersect8", "rtcOccluded8", closest),
            Mode::P16 => packets!(self, rays, out, 16, Packet16, "rtcIntersect16", "rtcOccluded16", closest),
            Mode::Stream64 => {
                let f: unsafe extern "C" fn(P, P, *mut RayHit1, c_uint, usize) = self.lib.f("rtcIntersect1M");
                with_context!(self, ctx => {
                    for (r, o) in rays.chunks(64).zip(out.chunks_mut(64)) {
                        let mut h: [RayHit1; 64] = std::array::from_fn(|k| fill(&r[k.min(r.len() - 1)]));
                        unsafe { f(s, ctx, h.as_mut_ptr(), r.len() as c_uint, size_of::<RayHit1>()) };
                        for (o, h) in o.iter_mut().zip(&h) {
                            *o = hit(h.geom, h.tfar, h.prim);
                        }
                    }
                })
            }
        }
    }
    fn any(&self, rays: &[Ray], out: &mut [bool]) {
        let s = self.scene.as_ref().unwrap().scene;
        match self.mode {
            Mode::Single => {
                let f: unsafe extern "C" fn(P, P, P) = self.lib.f("rtcOccluded1");
                let three = self.lib.major == 3;
                with_context!(self, ctx => {
                    for (r, o) in rays.iter().zip(out) {
                        let mut h = fill(r);
                        let p = &mut h as *mut _ as P;
                        unsafe { if three { f(s, ctx, p) } else { f(s, p, ctx) } }
                        *o = h.tfar < 0.0;
                    }
                })
            }
            Mode::P8 => packets!(self, rays, out, 8, Packet8, "rtcIntersect8", "rtcOccluded8", any),
            Mode::P16 => packets!(self, rays, out, 16, Packet16, "rtcIntersect16", "rtcOccluded16", any),
            Mode::Stream64 => {
                let f: unsafe extern "C" fn(P, P, *mut RayHit1, c_uint, usize) = self.lib.f("rtcOccluded1M");
                with_context!(self, ctx => {
                    for (r, o) in rays.chunks(64).zip(out.chunks_mut(64)) {
                        let mut h: [RayHit1; 64] = std::array::from_fn(|k| fill(&r[k.min(r.len() - 1)]));
                        unsafe { f(s, ctx, h.as_mut_ptr(), r.len() as c_uint, size_of::<RayHit1>()) };
                        for (o, h) in o.iter_mut().zip(&h) {
                            *o = h.tfar < 0.0;
                        }
                    }
                })
            }
        }
    }
}

pub fn peers(e4: Option<Lib>, e3: Option<Lib>) -> Vec<Box<dyn Peer>> {
    let mut v: Vec<Box<dyn Peer>> = vec![];
    let mut add = |lib: &Rc<Lib>, cfg: &'static str, flags, q, mode, coherent, extra| {
        v.push(Box::new(Embree { lib: lib.clone(), key: (cfg, flags, q), mode, coherent, extra, scene: None }));
    };
    use Mode::*;
    let newest = e4.is_some();
    if let Some(l) = e4 {
        let l = Rc::new(l);
        add(&l, "", 0, MEDIUM, Single, false, false); // the reference
        add(&l, "", ROBUST, MEDIUM, Single, false, false); // the judge of correctness
        add(&l, "", 0, HIGH, Single, false, false);
        add(&l, "max_isa=avx2", 0, MEDIUM, Single, false, false);
        add(&l, "", COMPACT, MEDIUM, Single, false, true);
        add(&l, "", 0, MEDIUM, P8, false, true);
        add(&l, "", 0, MEDIUM, P8, true, false);
        add(&l, "", 0, MEDIUM, P16, false, false);
        add(&l, "", 0, MEDIUM, P16, true, false);
        add(&l, "", 0, HIGH, P16, true, true);
        add(&l, "tri_accel=qbvh8.triangle4", 0, MEDIUM, Single, false, true);
    }
    if let Some(l) = e3 {
        let l = Rc::new(l);
        add(&l, "", 0, MEDIUM, Single, false, false);
        if !newest {
            add(&l, "", ROBUST, MEDIUM, Single, false, false);
        }
        add(&l, "", 0, HIGH, Single, false, newest);
        add(&l, "", 0, MEDIUM, P16, true, newest);
        add(&l, "", 0, MEDIUM, Stream64, false, newest);
        add(&l, "", 0, MEDIUM, Stream64, true, false);
    }
    v
}

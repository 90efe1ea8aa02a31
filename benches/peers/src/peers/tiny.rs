//! tinybvh (C++): most rows through shim/tiny_shim.cpp, one through the tinybvh-rs wrapper itself.
use crate::clock;
use crate::peer::*;
use std::ffi::c_void;

unsafe extern "C" {
    fn tb_build(kind: i32, quality: i32, verts: *const f32, tris: u32, bytes: *mut usize) -> *mut c_void;
    fn tb_free(h: *mut c_void);
    fn tb_closest(h: *mut c_void, r: *const Ray, n: usize, out: *mut Hit);
    fn tb_any(h: *mut c_void, r: *const Ray, n: usize, out: *mut bool);
    fn tb_version() -> i32;
}

#[repr(align(64))]
#[derive(Clone, Copy)]
struct Block([f32; 16]);

/// The 3 x 16-byte vertices that tinybvh wants, 64-byte aligned.
fn verts4(tris: &[Tri]) -> Vec<Block> {
    let mut v = vec![Block([0.0; 16]); (tris.len() * 12).div_ceil(16)];
    for (i, p) in tris.iter().flatten().enumerate() {
        for k in 0..3 {
            v[i / 4].0[i % 4 * 4 + k] = p[k];
        }
    }
    v
}

struct Tiny {
    name: &'static str,
    layout: &'static str,
    kind: i32,
    quality: i32,
    extra: bool,
    max: usize,
    verts: Vec<Block>,
    h: *mut c_void,
}

impl Drop for Tiny {
    fn drop(&mut self) {
        self.clear()
    }
}

impl Peer for Tiny {
    fn name(&self) -> String {
        format!("tinybvh-{}", self.name)
    }
    fn info(&self) -> String {
        let v = unsafe { tb_version() };
        let q = ["binned SAH build", "SBVH build (spatial splits)", "binned SAH + reinsertion optimizer"]
            [self.quality as usize];
        format!("tinybvh {}.{}.{}, {}, {q}", v / 10000, v / 100 % 100, v % 100, self.layout)
    }
    fn can(&self) -> Can {
        if self.kind == 5 { Can::PrimaryTiles } else { Can::All }
    }
    fn extra(&self) -> bool {
        self.extra
    }
    fn max_tris(&self) -> usize {
        self.max
    }
    fn build(&mut self, tris: &[Tri]) -> Built {
        self.clear();
        self.verts = verts4(tris);
        let mut bytes = 0;
        let t0 = clock::thread();
        self.h = unsafe { tb_build(self.kind, self.quality, self.verts.as_ptr() as _, tris.len() as u32, &mut bytes) };
        Built { ms: (clock::thread() - t0) * 1e3, bytes: Some(bytes) }
    }
    fn clear(&mut self) {
        if !self.h.is_null() {
            unsafe { tb_free(self.h) };
            self.h = std::ptr::null_mut();
            self.verts = vec![];
        }
    }
    fn closest(&self, rays: &[Ray], out: &mut [Hit]) {
        unsafe { tb_closest(self.h, rays.as_ptr(), rays.len(), out.as_mut_ptr()) }
    }
    fn any(&self, rays: &[Ray], out: &mut [bool]) {
        unsafe { tb_any(self.h, rays.as_ptr(), rays.len(), out.as_mut_ptr()) }
    }
}

/// BVH8_CPU through the Rust wrapper: one foreign call per ray, no any-hit query (closest hit with a limit instead).
#[repr(align(64))]
struct Aligned(tinybvh_rs::Ray);

#[derive(Default)]
struct Wrapper {
    bvh: Option<tinybvh_rs::bvh8_cpu::BVH>,
}

impl Peer for Wrapper {
    fn name(&self) -> String {
        "tinybvh-rs-BVH8".into()
    }
    fn info(&self) -> String {
        "tinybvh-rs wrapper, BVH8_CPU after new_hq + split_leaves(4); no any-hit query: shadow rays use closest hit"
            .into()
    }
    fn build(&mut self, tris: &[Tri]) -> Built {
        use tinybvh_rs::*;
        self.clear();
        let v: Vec<[f32; 4]> = tris.iter().flatten().map(|p| [p[0], p[1], p[2], 0.0]).collect();
        let t0 = clock::thread();
        let mut b = bvh::BVH::new_hq(v.as_slice().into()).unwrap();
        b.split_leaves(4);
        let m = mbvh::BVH::new(&b);
        let b8 = bvh8_cpu::BVH::new(&m).unwrap();
        let ms = (clock::thread() - t0) * 1e3;
        self.bvh = Some(b8);
        // the intermediate trees are not needed for traversal: BVH8_CPU holds its own triangles.
        Built { ms, bytes: None }
    }
    fn clear(&mut self) {
        self.bvh = None;
    }
    fn extra(&self) -> bool {
        true
    }
    fn closest(&self, rays: &[Ray], out: &mut [Hit]) {
        use tinybvh_rs::Intersector;
        let b = self.bvh.as_ref().unwrap();
        for (r, o) in rays.iter().zip(out) {
            // Not Ray::new: the C++ type is 64-byte aligned, the wrapper's is 16-byte aligned, which crashes where
            // the C++ side was compiled to aligned 32/64-byte moves.
            let mut q = Aligned(tinybvh_rs::Ray {
                origin: r.o,
                padding_0: 0xffff, // ray mask
                dir: r.d,
                r_d: r.d.map(|x| 1.0 / x),
                ..Default::default()
            });
            let t0 = r.tmax.min(tinybvh_rs::INFINITE);
            q.0.hit.t = t0;
            b.intersect(&mut q.0);
            *o = if q.0.hit.t < t0 { Hit { t: q.0.hit.t, prim: q.0.hit.prim } } else { Hit::MISS };
        }
    }
    fn any(&self, rays: &[Ray], out: &mut [bool]) {
        let mut h = vec![Hit::MISS; rays.len()];
        self.closest(rays, &mut h);
        for (o, h) in out.iter_mut().zip(&h) {
            *o = h.t < f32::INFINITY;
        }
    }
}

pub fn peers() -> Vec<Box<dyn Peer>> {
    let row = |name, layout, kind, quality, extra, max| -> Box<dyn Peer> {
        Box::new(Tiny { name, layout, kind, quality, extra, max, verts: vec![], h: std::ptr::null_mut() })
    };
    const BVH: &str = "BVH: 2-wide 32 B nodes, one box at a time, 48 B triangles (SSE-ish scalar)";
    const SOA: &str = "BVH_SoA: 2-wide 64 B nodes, both boxes in SSE registers";
    const B4: &str = "BVH4_CPU: 4-wide 128 B nodes (SSE), 4-triangle SoA leaves of 192 B";
    const B8: &str = "BVH8_CPU: 8-wide 256 B nodes (AVX2+FMA), 4-triangle SoA leaves of 192 B (SSE)";
    let none = usize::MAX;
    vec![
        row("BVH", BVH, 0, 0, false, none),
        row("BVH-hq", BVH, 0, 1, true, none),
        row("SoA-hq", SOA, 1, 1, true, none),
        row("BVH4-hq", B4, 2, 1, true, none),
        row("BVH8", B8, 3, 0, false, none),
        row("BVH8-hq", B8, 3, 1, false, 600_000),
        row("BVH8-opt", B8, 3, 2, true, 300_000),
        row("CWBVH-hq", "BVH8_CWBVH: 80 B compressed 8-wide nodes, scalar reference traversal", 4, 1, true, none),
        row("packet256", "BVH + Intersect256Rays: frustum packets of 256 primary rays, scalar", 5, 0, false, none),
        Box::new(Wrapper::default()),
    ]
}

//! flashray behind a C interface: batches of rays in, answers out.
//!
//! The harness compiles all Rust code for the machine that it runs on. What is measured of flashray is what a user gets
//! who asks for nothing, so it stands in a library of its own that is built with the default flags and opened at run
//! time. A call takes thousands of rays; what it costs is nothing beside them.
use flashray::blob::Buffer;
use flashray::build::{Config, Mesh, to_buffer};
use flashray::walk::Isa;
use flashray::{Kind, Scene};
use std::ffi::{CString, c_char};
use std::sync::OnceLock;

/// The harness's ray.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Ray {
    o: [f32; 3],
    tmax: f32,
    d: [f32; 3],
    pad: u32,
}

/// The harness's hit; a miss has an infinite `t`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Hit {
    t: f32,
    prim: u32,
}

/// How rays are handed over.
#[derive(Clone, Copy)]
enum Mode {
    Single,
    /// Many a call.
    Group,
}

/// What is measured: a name, the structure, how it is built, and how it is asked.
struct Row {
    name: &'static str,
    structure: &'static str,
    config: fn() -> Config,
    /// The instruction set; the fastest unless said.
    lanes: Option<&'static str>,
    mode: Mode,
    /// Whether only those see it who ask for it.
    extra: bool,
    info: &'static str,
}

const fn row(name: &'static str, structure: &'static str, config: fn() -> Config, mode: Mode) -> Row {
    Row { name, structure, config, lanes: None, mode, extra: false, info: "" }
}

impl Row {
    const fn lanes(mut self, lanes: &'static str, extra: bool) -> Self {
        (self.lanes, self.extra) = (Some(lanes), extra);
        self
    }

    const fn info(mut self, info: &'static str) -> Self {
        self.info = info;
        self
    }
}

fn wide() -> Config {
    Config::new(Kind::Wide)
}

fn bvh() -> Config {
    Config::new(Kind::Bvh)
}

const ROWS: [Row; 7] = [
    row("flashray-wide", "wide", wide, Mode::Single).info("eight-wide, f32 boxes, 4-wide watertight triangles"),
    row("flashray-wide-group", "wide", wide, Mode::Group).info("the same, closest_hits and any_hits of 1024 rays"),
    row("flashray-wide-avx2", "wide", wide, Mode::Single).lanes("avx2", true).info("1 ray x 8 boxes"),
    row("flashray-wide-sse2", "wide", wide, Mode::Single).lanes("sse2", false).info("1 ray x 2 x 4 boxes"),
    row("flashray-wide-scalar", "wide", wide, Mode::Single).lanes("scalar", false).info("box by box"),
    row("flashray-bvh", "bvh", bvh, Mode::Single).info("binary, 64-byte pair nodes, scalar"),
    row("flashray-bvh-group", "bvh", bvh, Mode::Group).info("the same, closest_hits and any_hits of 1024 rays"),
];

/// A scene and the blob it lies in.
pub struct Handle {
    blob: *mut Buffer,
    scene: Scene<'static>,
}

impl Drop for Handle {
    fn drop(&mut self) {
        // SAFETY: it came from `Box::into_raw`, and the scene that borrows it is not used again.
        drop(unsafe { Box::from_raw(self.blob) });
    }
}

/// The instruction set of a row, if this machine has it.
fn isa(row: &Row) -> Option<Isa> {
    row.lanes.map_or(Some(Isa::best()), |name| Isa::all().find(|isa| isa.name() == name))
}

/// The rows: a line each of number, name, structure, 1 if extra, and info, with tabs between.
#[unsafe(no_mangle)]
pub extern "C" fn flashray_rows() -> *const c_char {
    static TEXT: OnceLock<CString> = OnceLock::new();
    let text = || {
        let here = ROWS.iter().enumerate().filter(|(_, row)| isa(row).is_some());
        let line = |(i, row): (usize, &Row)| {
            let lanes = isa(row).map_or("", Isa::name);
            let lanes = if row.structure == "wide" { format!("; {lanes}") } else { String::new() };
            format!("{i}\t{}\t{}\t{}\t{}{lanes}", row.name, row.structure, u8::from(row.extra), row.info)
        };
        CString::new(here.map(line).collect::<Vec<_>>().join("\n")).unwrap_or_default()
    };
    TEXT.get_or_init(text).as_ptr()
}

/// Builds the structure of a row; null if it can not be built. `bytes` becomes the size of the blob.
///
/// # Safety
/// `triangles` has `count` of them, `numbers` those of each one's corners, and `bytes` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flashray_build(
    row: usize,
    triangles: *const [[f32; 3]; 3],
    numbers: *const [u32; 3],
    count: usize,
    bytes: *mut usize,
) -> *mut Handle {
    // SAFETY: as the caller promises.
    let (corners, numbers) = unsafe {
        (std::slice::from_raw_parts(triangles, count).as_flattened(), std::slice::from_raw_parts(numbers, count))
    };
    let Some(Ok(blob)) = ROWS.get(row).map(|row| to_buffer(&Mesh::new(corners, numbers), &(row.config)())) else {
        return std::ptr::null_mut();
    };
    let blob = Box::into_raw(Box::new(blob));
    // SAFETY: it came from `into_raw`, and lives until the handle is dropped, after the scene's last use.
    let read: &'static Buffer = unsafe { &*blob };
    // SAFETY: as the caller promises.
    unsafe { bytes.write(read.len()) };
    match Scene::trust(read) {
        Ok(scene) => Box::into_raw(Box::new(Handle { blob, scene })),
        Err(_) => std::ptr::null_mut(),
    }
}

/// Frees what `flashray_build` returned.
///
/// # Safety
/// Once, and nobody uses it any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flashray_free(handle: *mut Handle) {
    // SAFETY: as the caller promises.
    drop(unsafe { Box::from_raw(handle) });
}

/// The closest hits of `count` rays.
///
/// # Safety
/// The handle is from `flashray_build` for the structure of this row; there are `count` rays and places for hits.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flashray_closest(
    handle: *const Handle,
    row: usize,
    rays: *const Ray,
    count: usize,
    hits: *mut Hit,
) {
    // SAFETY: as the caller promises.
    let (handle, rays, hits) =
        unsafe { (&*handle, std::slice::from_raw_parts(rays, count), std::slice::from_raw_parts_mut(hits, count)) };
    let Some((scene, mode)) = ask(handle, row) else { return };
    match mode {
        Mode::Single => rays.iter().zip(hits).for_each(|(ray, hit)| *hit = told(scene.closest_hit(&asked(ray)))),
        Mode::Group => {
            let (mut questions, mut answers) = ([asked(&NONE); CALL], [None; CALL]);
            for (rays, hits) in rays.chunks(CALL).zip(hits.chunks_mut(CALL)) {
                ask_all(&mut questions, rays);
                scene.closest_hits(&questions[..rays.len()], &mut answers);
                hits.iter_mut().zip(&answers).for_each(|(hit, answer)| *hit = told(*answer));
            }
        }
    }
}

/// Whether `count` rays hit anything.
///
/// # Safety
/// As `flashray_closest`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn flashray_any(
    handle: *const Handle,
    row: usize,
    rays: *const Ray,
    count: usize,
    found: *mut bool,
) {
    // SAFETY: as the caller promises.
    let (handle, rays, found) =
        unsafe { (&*handle, std::slice::from_raw_parts(rays, count), std::slice::from_raw_parts_mut(found, count)) };
    let Some((scene, mode)) = ask(handle, row) else { return };
    match mode {
        Mode::Single => rays.iter().zip(found).for_each(|(ray, found)| *found = scene.any_hit(&asked(ray))),
        Mode::Group => {
            let mut questions = [asked(&NONE); CALL];
            for (rays, found) in rays.chunks(CALL).zip(found.chunks_mut(CALL)) {
                ask_all(&mut questions, rays);
                scene.any_hits(&questions[..rays.len()], found);
            }
        }
    }
}

/// Rays of a call, which makes groups of them as it likes: as many as a square of 32 by 32 pixels.
const CALL: usize = 1024;
/// A ray to fill places with.
const NONE: Ray = Ray { o: [0.0; 3], tmax: 0.0, d: [0.0; 3], pad: 0 };

fn ask(handle: &Handle, row: usize) -> Option<(Scene<'static>, Mode)> {
    let row = ROWS.get(row)?;
    Some((handle.scene.with_isa(isa(row)?), row.mode))
}

fn asked(ray: &Ray) -> flashray::Ray {
    flashray::Ray { origin: ray.o, dir: ray.d, t_min: 0.0, t_max: ray.tmax }
}

/// Field by field: a ray made in one place and moved to another as a whole is waited for there.
fn ask_all(questions: &mut [flashray::Ray], rays: &[Ray]) {
    for (question, ray) in questions.iter_mut().zip(rays) {
        (question.origin, question.dir) = (ray.o, ray.d);
        (question.t_min, question.t_max) = (0.0, ray.tmax);
    }
}

fn told(hit: Option<flashray::Hit>) -> Hit {
    hit.map_or(Hit { t: f32::INFINITY, prim: u32::MAX }, |hit| Hit { t: hit.t, prim: hit.prim })
}

//! `flashray` in WebAssembly. The module imports nothing: JavaScript lends it the blob's bytes and asks.
//!
//! In this order: [`scene_reserve`], copy the blob to the address it gives, [`scene_load`]; then as often as wanted:
//! write a ray to [`query_address`], call [`closest_hit`], read the hit behind the ray. All numbers are little-endian.
#![no_std]

use core::cell::UnsafeCell;
use core::panic::PanicInfo;
use flashray::{Ray, Scene};
use probe::Answer;

#[path = "../../probe.rs"]
mod probe;

/// Bytes of a page, the unit in which WebAssembly's memory grows.
const PAGE: usize = 65536;
/// What [`scene_load`] answers where no rule of the blob's is broken, but its length is more than was reserved.
const NOT_RESERVED: i32 = -1;

/// The exchange between JavaScript and [`closest_hit`].
#[repr(C)]
struct Query {
    /// Offset 0: `ox oy oz t_min dx dy dz t_max`.
    ray: [f32; 8],
    /// Offset 32: `t u v` as f32, `prim` as u32. A miss is infinity, 0, 0, 0xffffffff.
    hit: [u32; 4],
}

/// All that the module remembers.
struct State {
    /// Address and length of the reserved region.
    region: (usize, usize),
    scene: Option<Scene<'static>>,
    query: Query,
}

struct Global(UnsafeCell<State>);

// SAFETY: WebAssembly without threads: nothing is ever at two places of this module at once.
unsafe impl Sync for Global {}

static STATE: Global =
    Global(UnsafeCell::new(State { region: (0, 0), scene: None, query: Query { ray: [0.0; 8], hit: [0; 4] } }));

/// The state. Each exported function calls this once, and no exported function calls another.
fn state() -> &'static mut State {
    // SAFETY: one thread (see above), one call in each exported function, whose reference is gone when it returns.
    unsafe { &mut *STATE.0.get() }
}

/// Makes room for a blob of `len` bytes; returns its address, a multiple of 65,536, or 0 if there is no memory.
///
/// The scene loaded before is dropped, and its room is used again if it is large enough.
#[unsafe(no_mangle)]
extern "C" fn scene_reserve(len: usize) -> usize {
    let state = state();
    state.scene = None;
    if len > state.region.1 || state.region.0 == 0 {
        let pages = len.div_ceil(PAGE).max(1);
        let before = core::arch::wasm32::memory_grow::<0>(pages);
        if before == usize::MAX {
            return 0;
        }
        state.region = (before.wrapping_mul(PAGE), pages.wrapping_mul(PAGE));
    }
    state.region.0
}

/// Checks the blob of `len` bytes in the reserved room: 0 if it is good, else the number of the first rule that it
/// breaks (`docs/format.md`), or -1 if `len` bytes were not reserved.
///
/// The bytes must stay as they are until the next [`scene_reserve`].
#[unsafe(no_mangle)]
extern "C" fn scene_load(len: usize) -> i32 {
    let state = state();
    let (start, room) = state.region;
    state.scene = None;
    if start == 0 || len > room {
        return NOT_RESERVED;
    }
    // SAFETY: `memory_grow` made these bytes, zeroed, for this region alone, and WebAssembly's memory never shrinks.
    let bytes = unsafe { core::slice::from_raw_parts(core::ptr::with_exposed_provenance(start), len) };
    match Scene::from_bytes(bytes) {
        Ok(scene) => {
            state.scene = Some(scene);
            0
        }
        Err(error) => i32::from(error.rule.number()),
    }
}

/// The address of 48 bytes: the ray for [`closest_hit`] (32) and its answer (16).
#[unsafe(no_mangle)]
extern "C" fn query_address() -> usize {
    (&raw const state().query).expose_provenance()
}

/// Answers the ray at [`query_address`], behind it: 1 for a hit, 0 for none or where no scene is loaded.
#[unsafe(no_mangle)]
extern "C" fn closest_hit() -> u32 {
    let State { scene, query, .. } = state();
    let [ox, oy, oz, t_min, dx, dy, dz, t_max] = query.ray;
    let ray = Ray::new([ox, oy, oz], [dx, dy, dz]).within(t_min, t_max);
    let hit = scene.and_then(|scene| scene.closest_hit(&ray));
    query.hit = probe::record(hit);
    u32::from(hit.is_some())
}

/// The probe's CRC-32; 0 where no scene is loaded.
#[unsafe(no_mangle)]
extern "C" fn probe_crc() -> u32 {
    answer().crc
}

/// The probe's number of hits; 0 where no scene is loaded.
#[unsafe(no_mangle)]
extern "C" fn probe_hits() -> u32 {
    answer().hits
}

fn answer() -> Answer {
    match &state().scene {
        Some(scene) => probe::run(scene, &mut ()),
        None => Answer { crc: 0, hits: 0 },
    }
}

#[cfg(not(debug_assertions))]
unsafe extern "C" {
    /// Defined nowhere: if a panic can happen, the module does not link, or imports this.
    fn flashray_web_can_panic() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    #[cfg(not(debug_assertions))]
    // SAFETY: no such function exists, so that no module with this call runs.
    unsafe {
        flashray_web_can_panic()
    }
    #[cfg(debug_assertions)]
    core::arch::wasm32::unreachable()
}

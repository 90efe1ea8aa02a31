//! Queries to be timed in WebAssembly. In this order: [`room`] for a blob and for rays, copy both there, [`load`], then
//! [`closest`] and [`any`] as often as wanted.
#![no_std]

use core::cell::UnsafeCell;
use core::panic::PanicInfo;
use flashray::{Ray, Scene};

/// Bytes of a page, the unit in which WebAssembly's memory grows.
const PAGE: usize = 65536;

struct Global(UnsafeCell<Option<Scene<'static>>>);

// SAFETY: WebAssembly without threads: nothing is ever at two places of this module at once.
unsafe impl Sync for Global {}

static SCENE: Global = Global(UnsafeCell::new(None));

/// Room for so many bytes: its address, a multiple of 65,536, or 0 if there is no memory.
#[unsafe(no_mangle)]
pub extern "C" fn room(len: usize) -> usize {
    let before = core::arch::wasm32::memory_grow::<0>(len.div_ceil(PAGE).max(1));
    if before == usize::MAX { 0 } else { before.wrapping_mul(PAGE) }
}

/// Loads the blob at an address of [`room`]: 1 if it is good.
///
/// # Safety
/// `len` bytes are there, and stay as they are.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn load(at: usize, len: usize) -> u32 {
    // SAFETY: the caller's promise; no one else has a reference to the scene.
    unsafe {
        let bytes = core::slice::from_raw_parts(core::ptr::with_exposed_provenance(at), len);
        let scene = Scene::from_bytes(bytes).ok();
        let loaded = scene.is_some();
        *SCENE.0.get() = scene;
        u32::from(loaded)
    }
}

/// How many of the `count` rays at an address hit, by `closest_hit`. A ray is `ox oy oz t_min dx dy dz t_max`.
///
/// # Safety
/// So many rays are there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn closest(at: usize, count: usize) -> u32 {
    // SAFETY: the caller's promise.
    unsafe { hits(at, count, |scene, ray| scene.closest_hit(ray).is_some()) }
}

/// The same by `any_hit`.
///
/// # Safety
/// As for [`closest`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn any(at: usize, count: usize) -> u32 {
    // SAFETY: the caller's promise.
    unsafe { hits(at, count, Scene::any_hit) }
}

#[inline(always)]
unsafe fn hits(at: usize, count: usize, is_hit: impl Fn(&Scene<'static>, &Ray) -> bool) -> u32 {
    // SAFETY: the caller's promise; no one writes the scene meanwhile.
    let (rays, scene) = unsafe {
        let rays = core::slice::from_raw_parts(core::ptr::with_exposed_provenance::<[f32; 8]>(at), count);
        (rays, &*SCENE.0.get())
    };
    let Some(scene) = scene else { return 0 };
    let hit = |&&[ox, oy, oz, t_min, dx, dy, dz, t_max]: &&[f32; 8]| {
        is_hit(scene, &Ray::new([ox, oy, oz], [dx, dy, dz]).within(t_min, t_max))
    };
    rays.iter().filter(hit).fold(0, |n, _| n + 1)
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    core::arch::wasm32::unreachable()
}

//! One query by one structure's own view, without a [`flashray::Scene`]: what a structure costs in flash alone.
//!
//! `FLASHRAY_ONLY` names the structure when this is built; without it there is everything but view and walk, to be
//! subtracted. `benches/firmware.sh` does so. It links, and is not made to run.
#![no_std]
#![no_main]

use core::hint::black_box;
use core::panic::PanicInfo;
use flashray::blob::Blob;
use flashray::blob::prims::Prims;
use flashray::geom::place::Place;
use flashray::geom::ray::Prepared;
use flashray::walk::mailbox::NoMailbox;
use flashray::walk::{Best, Fuel, Stop};
use flashray::{BlobError, Hit, Ray};

mod scenes {
    include!(concat!(env!("OUT_DIR"), "/scenes.rs"));
}

// `walk`: the view's parse and walk of the structure, or neither.
include!(concat!(env!("OUT_DIR"), "/only.rs"));

type Walked = Result<Result<bool, Stop>, BlobError>;

/// The closest hit in an unchecked blob, found as `Scene::trust` and `Scene::closest_hit` do it; but `t` of a tiny
/// direction is left as it was scaled.
fn query(bytes: &[u8], ray: &Ray) -> Result<Option<Hit>, BlobError> {
    let blob = Blob::parse(bytes)?;
    let (header, prims) = (blob.header(), Prims::parse(&blob)?);
    let mut best = Best::new(ray.t_max);
    let place = Place::new(&header.bounds, header.local, header.longest);
    let Some(ray) = Prepared::new(ray, &place) else { return Ok(None) };
    let walked = walk(&blob, black_box(&prims), black_box(&ray), &mut best, &mut Fuel(header.steps), &mut NoMailbox)?;
    Ok(if walked.is_ok() { best.hit() } else { None })
}

#[cortex_m_rt::entry]
fn main() -> ! {
    loop {
        let ray = black_box(Ray::new([0.0; 3], [1.0; 3]));
        let _ = black_box(query(black_box(scenes::SCENES[0]), &ray));
    }
}

unsafe extern "C" {
    /// Defined nowhere: if a panic can happen, the program does not link.
    fn flashray_firmware_can_panic() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    // SAFETY: no such function exists, so that no program with this call does.
    unsafe { flashray_firmware_can_panic() }
}

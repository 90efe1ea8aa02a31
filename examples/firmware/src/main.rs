//! The probe on a bare machine: prints what it found and what it took, one `key=value` a line.
//!
//! On Cortex-M it runs under QEMU; elsewhere it only links, which proves the same: without `std`, without a heap and,
//! in a release build, without a way to panic.
#![no_std]
#![no_main]

use core::panic::PanicInfo;

#[cfg(target_arch = "arm")]
mod platform;
#[cfg(target_arch = "arm")]
mod report;

/// The blobs, as `flashray emit --as rust` wrote them.
mod scenes {
    include!(concat!(env!("OUT_DIR"), "/scenes.rs"));
}

#[cfg(target_arch = "arm")]
#[cortex_m_rt::entry]
fn main() -> ! {
    platform::exit(report::run().is_ok())
}

/// No clock and no output: the answer goes to where a debugger finds it.
#[cfg(not(target_arch = "arm"))]
#[unsafe(no_mangle)]
extern "C" fn _start() -> ! {
    loop {
        for blob in core::hint::black_box(&scenes::SCENES) {
            let _ = core::hint::black_box(flashray_firmware::answer(blob));
        }
    }
}

#[cfg(not(debug_assertions))]
unsafe extern "C" {
    /// Defined nowhere: if a panic can happen, the program does not link.
    fn flashray_firmware_can_panic() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    #[cfg(not(debug_assertions))]
    // SAFETY: no such function exists, so that no program with this call does.
    unsafe {
        flashray_firmware_can_panic()
    }
    #[cfg(all(debug_assertions, target_arch = "arm"))]
    platform::exit(false);
    #[cfg(all(debug_assertions, not(target_arch = "arm")))]
    loop {}
}

//! What the program needs of an MPS2 board under QEMU: output, an instruction clock, the stack, the memory map.
use core::arch::asm;
use core::ptr;

/// Instructions per tick: under `-icount shift=0` an instruction takes 1 ns, and the timer runs at 25 MHz.
pub const TICK: u32 = 40;

/// Registers of the first CMSDK APB timer.
const TIMER_CTRL: usize = 0x4000_0000;
const TIMER_VALUE: usize = 0x4000_0004;
const TIMER_RELOAD: usize = 0x4000_0008;

/// Semihosting: write a character, end the program.
const SYS_WRITEC: usize = 0x03;
const SYS_EXIT: usize = 0x18;
/// What `SYS_EXIT` gives as a reason.
const APPLICATION_EXIT: usize = 0x2_0026;
const RUN_TIME_ERROR: usize = 0x2_0023;

/// So much of the stack is painted.
pub const WINDOW: usize = 16 * 1024;
const PAINT: u32 = 0xc5a3_5c3a;

/// Asks the debugger (here QEMU) for a service.
///
/// # Safety
/// `argument` must be what the service `operation` takes: for `SYS_WRITEC` the address of a readable byte, for
/// `SYS_EXIT` a number.
unsafe fn semihost(operation: usize, argument: usize) {
    // SAFETY: the debugger handles this breakpoint, puts its answer in r0 and returns to the next instruction. It
    // reads memory (so no `nomem`), and touches neither the stack nor the flags.
    unsafe { asm!("bkpt #0xab", inout("r0") operation => _, in("r1") argument, options(nostack, preserves_flags)) }
}

/// Prints one byte.
pub fn write(byte: u8) {
    // SAFETY: SYS_WRITEC takes the address of a byte, and `byte` lives until the call is over.
    unsafe { semihost(SYS_WRITEC, (&raw const byte).expose_provenance()) }
}

/// Ends QEMU, with exit code 0 or 1.
pub fn exit(good: bool) -> ! {
    let reason = if good { APPLICATION_EXIT } else { RUN_TIME_ERROR };
    loop {
        // SAFETY: SYS_EXIT takes a number.
        unsafe { semihost(SYS_EXIT, reason) }
    }
}

/// Starts the instruction clock.
pub fn start_clock() {
    for (register, value) in [(TIMER_RELOAD, u32::MAX), (TIMER_VALUE, u32::MAX), (TIMER_CTRL, 1)] {
        // SAFETY: these are registers of a device of this board that nothing else uses, and no memory of Rust's.
        unsafe { ptr::with_exposed_provenance_mut::<u32>(register).write_volatile(value) }
    }
}

/// Ticks since some moment: the timer counts down, and round after 2^32.
#[inline(always)]
fn ticks() -> u32 {
    // SAFETY: a register of a device of this board; reading it changes nothing.
    !unsafe { ptr::with_exposed_provenance::<u32>(TIMER_VALUE).read_volatile() }
}

/// Runs `work`; returns how many ticks it took and how many bytes of stack.
#[inline(never)]
pub fn measure(work: impl FnOnce()) -> (u32, u32) {
    let top = stack_pointer() & !3;
    let bottom = top.saturating_sub(WINDOW);
    for address in (bottom..top).step_by(4) {
        // SAFETY: RAM below the stack pointer, of which nobody has a reference: the stack is the only thing there (the
        // RAM is 4 MiB, statics are a few bytes at its other end) and interrupts are never enabled.
        unsafe { ptr::with_exposed_provenance_mut::<u32>(address).write_volatile(PAINT) }
    }
    let before = ticks();
    deeper(work);
    let taken = ticks().wrapping_sub(before);
    let painted = |&address: &usize| {
        // SAFETY: as above; after `work` has returned nothing of it is in use.
        PAINT == unsafe { ptr::with_exposed_provenance::<u32>(address).read_volatile() }
    };
    let clean = (bottom..top).step_by(4).take_while(painted).count();
    (taken, WINDOW.saturating_sub(clean.saturating_mul(4)) as u32)
}

/// A frame of its own, below the one that measures.
#[inline(never)]
fn deeper(work: impl FnOnce()) {
    work();
}

#[inline(always)]
fn stack_pointer() -> usize {
    let sp;
    // SAFETY: copies one register into another.
    unsafe { asm!("mov {}, sp", out(reg) sp, options(nomem, nostack, preserves_flags)) }
    sp
}

unsafe extern "C" {
    static __etext: u8;
    static __srodata: u8;
    static __erodata: u8;
    static __sdata: u8;
    static __edata: u8;
    static __sbss: u8;
    static __ebss: u8;
}

/// Bytes of statics in RAM.
pub fn static_ram() -> u32 {
    between(&raw const __sdata, &raw const __edata).saturating_add(between(&raw const __sbss, &raw const __ebss))
}

/// Bytes of code and constants in flash, without the blobs.
pub fn flash(blobs: &[&[u8]]) -> u32 {
    let constants = (&raw const __srodata).addr()..(&raw const __erodata).addr();
    let inside = blobs.iter().filter(|blob| constants.contains(&blob.as_ptr().addr()));
    let inside = inside.fold(0u32, |sum, blob| sum.saturating_add(blob.len() as u32));
    let code = between(ptr::null(), &raw const __etext);
    let data = between(&raw const __sdata, &raw const __edata);
    let data = between(&raw const __srodata, &raw const __erodata).saturating_add(data);
    code.saturating_add(data).saturating_sub(inside)
}

fn between(start: *const u8, end: *const u8) -> u32 {
    end.addr().saturating_sub(start.addr()) as u32
}

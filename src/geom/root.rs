//! The square root: one instruction where the target has it, `libm`'s elsewhere. All are correctly rounded, so all
//! agree.

/// The square root of `x`; NaN below 0.
#[inline(always)]
pub fn sqrt(x: f32) -> f32 {
    #[cfg(feature = "std")]
    return x.sqrt();
    #[cfg(all(not(feature = "std"), target_arch = "arm", target_abi = "eabihf"))]
    return vsqrt(x);
    #[cfg(all(not(feature = "std"), not(all(target_arch = "arm", target_abi = "eabihf"))))]
    return libm::sqrtf(x);
}

/// `core` has no square root, and `libm`'s is software on Cortex-M4F: 14 cycles against some hundred.
#[cfg(all(not(feature = "std"), target_arch = "arm", target_abi = "eabihf"))]
#[allow(unsafe_code)]
#[inline(always)]
fn vsqrt(x: f32) -> f32 {
    let mut bits = x.to_bits();
    // SAFETY: a hard-float target has single-precision registers and these instructions (Armv7-M Architecture Reference
    // Manual, A7.7: VMOV, VSQRT). They read and write the one general register and s0, which is declared as
    // overwritten, and touch neither memory, stack nor condition flags.
    unsafe {
        core::arch::asm!(
            "vmov s0, {0}",
            "vsqrt.f32 s0, s0",
            "vmov {0}, s0",
            inout(reg) bits,
            out("s0") _,
            options(pure, nomem, nostack, preserves_flags)
        );
    }
    f32::from_bits(bits)
}

//! See `flashray_fuzz::build_then_agree`: it lives in the library so that crash files can be replayed without
//! libFuzzer.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| flashray_fuzz::build_then_agree::run(data));

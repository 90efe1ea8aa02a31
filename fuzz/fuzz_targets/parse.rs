//! See `flashray_fuzz::parse`: it lives in the library so that crash files can be replayed without libFuzzer.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| flashray_fuzz::parse::run(data));

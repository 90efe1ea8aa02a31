//! Every find of a fuzzer, played once more: `tests/crashes/<target>-<what>.bin` of the crate goes through its target.
use flashray_fuzz::good;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

/// A test for each find, named `<target>::<what>`, and the files of all of them.
macro_rules! finds {
    ($($target:ident: $($what:ident),+;)+) => {
        $(mod $target {
            $(#[test]
            fn $what() {
                let path = super::folder().join(super::file(stringify!($target), stringify!($what)));
                flashray_fuzz::$target::run(&std::fs::read(path).expect("a readable find"));
            })+
        })+

        fn listed() -> BTreeSet<String> {
            BTreeSet::from([$($(file(stringify!($target), stringify!($what))),+),+])
        }
    };
}

finds! {
    build_then_agree: distances_underflow, far_origin, grid_beyond_half_range, rescaled_denormal_t, rescaled_infinite_t, rescaled_interval;
    parse: nested_lists_without_grids, wide_nodes_in_circles;
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/crashes")
}

fn file(target: &str, what: &str) -> String {
    format!("{target}-{}.bin", what.replace('_', "-"))
}

/// A find that is saved and not named above would never be played, and nobody would know.
#[test]
fn every_find_is_a_test() {
    let entries = fs::read_dir(folder()).expect("the folder of finds");
    let names = entries.map(|entry| entry.expect("a file").file_name().to_string_lossy().into_owned());
    let saved: BTreeSet<_> = names.filter(|name| name != "README.md").collect();
    assert_eq!(saved, listed(), "files in tests/crashes, and those that this file names");
}

/// The comparison of builds with a heap and without is skipped where an arena would be too small: rarely.
#[test]
fn arenas_are_large_enough() {
    let mut random = good::Random(0);
    for i in 0..500 {
        let data: Vec<_> = (0..64 << (i % 6)).map(|_| random.word() as u8).collect();
        flashray_fuzz::build_then_agree::run(&data);
    }
    let arenas = flashray_fuzz::build_then_agree::ARENAS.each_ref();
    let [built, skipped] = arenas.map(|n| n.load(Ordering::Relaxed));
    assert!(built > 1000 && skipped < built / 100, "{built} builds in arenas, {skipped} skipped");
}

/// Seeds that the targets refuse would fuzz nothing: blobs of the library's own builder pass every mode of `parse`.
#[test]
fn good_blobs_are_good() {
    for good in good::all() {
        assert!(flashray::Scene::from_bytes(&good.bytes).is_ok(), "{}", good.name);
    }
}

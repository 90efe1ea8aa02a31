//! Every find of a fuzzer, played once more: `tests/crashes/<target>-<what>.bin` of the crate goes through its target.
use flashray_fuzz::{TARGETS, build_then_agree, good};
use std::fs;
use std::path::Path;
use std::sync::atomic::Ordering;

#[test]
fn finds_stay_fixed() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/crashes");
    for entry in fs::read_dir(folder).expect("the folder of finds") {
        let path = entry.expect("a file").path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if !name.ends_with(".bin") {
            continue;
        }
        let target = TARGETS.iter().find(|(target, _)| name.starts_with(&format!("{target}-")));
        let (_, run) = target.unwrap_or_else(|| panic!("{name} begins with no target's name"));
        println!("{name}");
        run(&fs::read(&path).expect("a readable find"));
    }
}

/// The comparison of builds with a heap and without is skipped where an arena would be too small: rarely.
#[test]
fn arenas_are_large_enough() {
    let mut random = good::Random(0);
    for i in 0..500 {
        let data: Vec<_> = (0..64 << (i % 6)).map(|_| random.word() as u8).collect();
        build_then_agree::run(&data);
    }
    let [built, skipped] = build_then_agree::ARENAS.each_ref().map(|n| n.load(Ordering::Relaxed));
    assert!(built > 1000 && skipped < built / 100, "{built} builds in arenas, {skipped} skipped");
}

/// Seeds that the targets refuse would fuzz nothing: blobs of the library's own builder pass every mode of `parse`.
#[test]
fn good_blobs_are_good() {
    for good in good::all() {
        assert!(flashray::Scene::from_bytes(&good.bytes).is_ok(), "{}", good.name);
    }
}

//! Every find of a fuzzer, played once more: `tests/crashes/<target>-<what>.bin` of the crate goes through its target.
use flashray_fuzz::TARGETS;
use std::fs;
use std::path::Path;

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

/// Seeds that the targets refuse would fuzz nothing: blobs of the library's own builder pass every mode of `parse`.
#[test]
fn good_blobs_are_good() {
    for good in flashray_fuzz::good::all() {
        assert!(flashray::Scene::from_bytes(&good.bytes).is_ok(), "{}", good.name);
    }
}

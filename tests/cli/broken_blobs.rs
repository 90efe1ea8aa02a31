//! Blobs and rays that are no good are refused by every verb, with the rule that they break.
use super::Folder;

/// Every verb that takes a blob.
const VERBS: [&str; 8] = [
    "info BLOB",
    "info BLOB --json",
    "check BLOB",
    "rays BLOB -o out --count 10",
    "trace BLOB --rays rays -o out",
    "render BLOB -o out --size 8x8",
    "emit BLOB --as rust -o out",
    "emit BLOB --as c -o out",
];

/// All verbs refuse the blob `name`, for the reason given.
fn refused(folder: &Folder, name: &str, why: &str) {
    for verb in VERBS {
        folder.fails(&verb.replace("BLOB", name), &[&format!("flashray: {name}: "), why]);
    }
}

#[test]
fn damaged_blobs() {
    let folder = Folder::with_cube("broken-blobs");
    folder.ok("rays cube.fray -o rays --count 10");
    let good = folder.get("cube.fray");
    let changed = |at: usize| {
        let mut bytes = good.clone();
        bytes[at] ^= 0x10;
        bytes
    };
    for (name, bytes, why) in [
        ("empty.fray", vec![], "rule 1, header: "),
        ("short.fray", good[..79].to_vec(), "rule 1, header: "),
        ("half.fray", good[..good.len() / 2].to_vec(), "rule 5, header: "),
        ("odd.fray", good[..good.len() - 1].to_vec(), "rule 5, header: "),
        ("long.fray", [&good[..], &[0]].concat(), "rule 5, header: "),
        ("magic.fray", changed(0), "rule 3, header: "),
        ("version.fray", changed(4), "rule 4, header: the format version is one that this library reads (found 18"),
        ("header.fray", changed(12), "rule 14, header: "),
        ("body.fray", changed(good.len() - 9), "rule 14, header: "),
        ("mesh.fray", folder.get("cube.obj"), "rule 3, header: "),
    ] {
        folder.put(name, bytes);
        refused(&folder, name, why);
    }
}

#[test]
fn blobs_that_are_not_there() {
    let folder = Folder::with_cube("broken-missing");
    folder.ok("rays cube.fray -o rays --count 10");
    std::fs::create_dir(folder.path("folder.fray")).expect("a folder");
    refused(&folder, "nosuch.fray", "No such file");
    refused(&folder, "folder.fray", "is a directory");
}

#[test]
fn rays_that_are_no_rays() {
    let folder = Folder::with_cube("broken-rays");
    for length in [1, 31, 33, 65] {
        folder.put("rays", vec![0; length]);
        let why = format!("{length} bytes are no whole number of rays of 32");
        folder.fails("trace cube.fray --rays rays -o out", &["flashray: rays: ", &why]);
        folder.fails("trace cube.fray --rays rays -o out --any --json", &["flashray: rays: ", &why]);
    }
    folder.fails("trace cube.fray --rays nosuch -o out", &["flashray: nosuch: ", "No such file"]);
    folder.fails("trace cube.fray --rays . -o out", &["flashray: .: ", "is a directory"]);
}

//! The measuring of speed, on small scenes.
use super::Folder;
use flashray::walk::Isa;
use serde_json::Value;
use std::collections::BTreeSet;

const KINDS: [&str; 4] = ["camera", "diffuse", "shadow", "chord"];

/// A number and its quartiles, in order.
fn spread(value: &Value, what: &str) {
    let [low, median, high] = ["lower_quartile", "median", "upper_quartile"].map(|key| value[key].as_f64());
    assert!(low.is_some_and(|low| low > 0.0) && low <= median && median <= high, "{what}: {value}");
}

/// All that a file's part must have, and which structures and ways are in it.
fn whole(file: &Value, structures: &[&str]) {
    let rows = |key: &str| file[key].as_array().expect("an array").clone();
    let found: Vec<Value> = rows("structures").iter().map(|row| row["kind"].clone()).collect();
    assert_eq!(found, structures);
    for row in rows("structures") {
        assert!(row["bytes"].as_u64() > Some(0) && row["bytes_per_primitive"].as_f64() > Some(0.0), "{row}");
        for kind in KINDS {
            for what in ["nodes_per_ray", "tests_per_ray", "nodes_per_ray_in_groups", "tests_per_ray_in_groups"] {
                assert!(row[what][kind].is_f64(), "{what}, {kind}: {row}");
            }
        }
        assert!(row["tests_per_ray"]["camera"].as_f64() > Some(0.0), "{row}");
        // In the list no node is visited.
        assert_eq!(row["nodes_per_ray"]["camera"].as_f64() > Some(0.0), row["kind"] != "list", "{row}");
    }
    let mut ways = BTreeSet::new();
    for row in rows("ways") {
        let part = |key: &str| row[key].as_str().unwrap_or("-").to_owned();
        assert!(ways.insert([part("kind"), part("lanes"), part("mode")]), "twice: {row}");
        for kind in KINDS {
            spread(&row["mrays_per_second"][kind], kind);
        }
        spread(&row["miss_nanoseconds"], "a miss");
    }
    for structure in structures {
        let lanes: Vec<&str> =
            if structure.starts_with("wide") { Isa::all().map(Isa::name).collect() } else { vec!["-"] };
        for lanes in lanes {
            for mode in ["single", "group"] {
                assert!(ways.contains(&[*structure, lanes, mode].map(str::to_owned)), "no {structure} {lanes} {mode}");
            }
        }
    }
}

#[test]
fn each_structure_is_measured_in_every_way() {
    let folder = Folder::with_cube("bench");
    let before = folder.snapshot();
    let facts = folder.json("bench cube.obj --rays 100 --rounds 3 --json");
    assert_eq!(facts["rounds"], 3);
    let [file] = &facts["files"].as_array().expect("files")[..] else { panic!("{facts}") };
    assert_eq!((&file["file"], &file["primitives"]), (&"cube.obj".into(), &12.into()));
    // A square of squares of 8 by 8.
    assert_eq!((&file["rays"]["camera"], &file["rays"]["chord"]), (&64.into(), &100.into()));
    assert!(file["structures"][0]["build_seconds"].is_f64());
    whole(file, &["wide", "bvh"]);
    folder.assert_is(&before, "bench");
}

#[test]
fn files_and_structures_are_those_asked_for() {
    let folder = Folder::with_cube("bench-files");
    folder.ok("build cube.obj -o moved.fray --local 5,6,7");
    std::fs::rename(folder.path("moved.fray"), folder.path("moved.bin")).expect("a file to rename");
    let facts =
        folder.json("bench cube.fray moved.bin spd:tree:2 --structure bvh,list,wide,wide4 --rays 64 --rounds 1 --json");
    let files = facts["files"].as_array().expect("files");
    let names: Vec<&str> = files.iter().filter_map(|file| file["file"].as_str()).collect();
    assert_eq!(names, ["cube.fray", "moved.bin", "spd:tree:2"]);
    whole(&files[0], &["bvh"]);
    whole(&files[1], &["bvh"]);
    whole(&files[2], &["bvh", "list", "wide", "wide4"]);
    // As it is, with nothing built; and the same rays, wherever coordinates start.
    for file in &files[..2] {
        assert_eq!((&file["structures"][0]["build_seconds"], &file["primitives"]), (&Value::Null, &12.into()));
    }
    assert_eq!(files[0]["rays"], files[1]["rays"]);
}

#[test]
fn the_tables_name_every_way() {
    let folder = Folder::with_cube("bench-table");
    let table = folder.ok("bench cube.obj spd:tree:1 --rays 64 --rounds 2");
    for row in ["wide scalar single ", "wide scalar group ", "bvh - single ", "bvh - group ", "wide ", "bvh "] {
        let rows = table.lines().filter(|line| line.starts_with(row)).count();
        assert!(rows >= 2, "{row}: {table}");
    }
    assert_eq!(table.matches("Mrays/s\n").count(), 2, "{table}");
    assert_eq!(table.matches("a miss: ").count(), 1, "{table}");
    assert!(table.lines().all(|line| line.len() < 140), "{table}");
}

#[test]
fn scenes_without_a_hit_or_a_primitive_are_measured() {
    let folder = Folder::new("bench-empty");
    // No ray meets a point, so none starts there.
    folder.put("point.obj", "v 1 2 3\nf 1 1 1\n");
    folder.put("empty.fray", include_bytes!("../golden/v1-bvh-empty.fray"));
    let facts = folder.json("bench point.obj empty.fray --rays 64 --rounds 1 --json");
    for file in facts["files"].as_array().expect("files") {
        for row in file["ways"].as_array().expect("ways") {
            assert!(row["mrays_per_second"]["camera"]["median"].as_f64() > Some(0.0), "{row}");
            assert_eq!(row["mrays_per_second"]["diffuse"], Value::Null, "{row}");
        }
    }
    folder.ok("bench point.obj empty.fray --rays 64 --rounds 1");
}

#[test]
fn what_can_not_be_measured_is_said_in_a_line() {
    let folder = Folder::with_cube("bench-bad");
    let blob = folder.get("cube.fray");
    folder.put("short.fray", &blob[..blob.len() - 4]);
    folder.put("short.bin", &blob[..blob.len() - 4]);
    folder.put("bad.obj", "v 1 2\n");
    folder.fails("bench nosuch.obj", &["flashray: nosuch.obj: no such file"]);
    folder.fails("bench nosuch.fray", &["flashray: nosuch.fray: "]);
    folder.fails("bench cube.fray bad.obj --rays 64 --rounds 1", &["flashray: bad.obj: "]);
    folder.fails("bench short.fray", &["flashray: short.fray: rule "]);
    folder.fails("bench short.bin", &["flashray: short.bin: rule "]);
    folder.fails("bench spd:nosuch", &["flashray: spd:nosuch: no such scene"]);
}

#[test]
fn rays_of_one_kind_go_to_a_file() {
    let folder = Folder::with_cube("bench-rays");
    for (kind, count) in [("camera", 64), ("diffuse", 100), ("shadow", 100), ("chord", 100)] {
        let said = folder.ok(&format!("rays cube.fray -o {kind}.rays --kind {kind} --count 100"));
        assert_eq!(said, format!("{kind}.rays: {count} rays\n"));
        assert_eq!(folder.get(&format!("{kind}.rays")).len(), count * 32);
        folder.ok(&format!("trace cube.fray --rays {kind}.rays -o hits"));
    }
}

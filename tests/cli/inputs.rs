//! Several inputs become one scene, and every format is read.
use super::broken::{GLTF, glb, ply, stl, triangle};
use super::{CUBE, Folder};
use flashray::Scene;
use flashray::blob::Buffer;
use flashray::blob::prims::Primitive;

/// The primitives of a blob in the order of the caller's numbers, which must be 0, 1, 2 and so on.
fn primitives(folder: &Folder, blob: &str) -> Vec<Primitive> {
    let bytes = Buffer::from(&folder.get(blob)[..]);
    let mut all: Vec<_> = Scene::from_bytes(&bytes).expect("a good blob").primitives().collect();
    all.sort_by_key(|(id, _)| *id);
    let ids: Vec<u32> = all.iter().map(|(id, _)| *id).collect();
    assert_eq!(ids, (0..all.len() as u32).collect::<Vec<_>>());
    all.into_iter().map(|(_, primitive)| primitive).collect()
}

/// The documented order of kinds.
fn rank(primitive: &Primitive) -> u32 {
    match primitive {
        Primitive::Triangle(_) => 0,
        Primitive::Sphere(_) => 1,
        Primitive::Box(_) => 2,
        Primitive::Cylinder(_) => 3,
        Primitive::Cone(_) => 4,
        other => panic!("a new kind: {other:?}"),
    }
}

#[test]
fn numbers_run_through_each_kind_in_the_order_of_the_inputs() {
    let folder = Folder::new("inputs");
    folder.put("cube.obj", CUBE);
    folder.put("far.obj", CUBE.replace("v -1", "v 98").replace("v 1", "v 102"));
    let inputs = ["cube.obj", "spd:tree:1", "spd:lattice:1", "far.obj", "spd:balls:1"];
    let mut expected = Vec::new();
    for input in inputs {
        folder.ok(&format!("build {input} -o one.fray --structure list"));
        expected.extend(primitives(&folder, "one.fray"));
    }
    // A stable sort: within a kind the order stays that of the inputs.
    expected.sort_by_key(rank);
    for structure in ["list", "bvh"] {
        let facts = folder.json(&format!("build {} -o all.fray --structure {structure} --json", inputs.join(" ")));
        assert_eq!(facts["primitives"], expected.len());
        assert_eq!(format!("{:?}", primitives(&folder, "all.fray")), format!("{expected:?}"), "{structure}");
    }
    let kinds: Vec<u32> = expected.iter().map(rank).collect();
    assert_eq!([0, 1, 3, 4].map(|kind| kinds.iter().filter(|k| **k == kind).count()), [28, 21, 12, 3]);
}

#[test]
fn every_format_is_read() {
    let folder = Folder::new("formats");
    folder.put("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.put("a.ply", ply("0 0 0", 2));
    folder.put("a.stl", stl(&triangle(0.0)));
    folder.put("a.gltf", GLTF);
    folder.put("a.bin", triangle(0.0));
    folder.put("a.glb", glb(&triangle(0.0)));
    folder.ok("build a.obj -o truth");
    for ending in ["ply", "stl", "gltf", "glb"] {
        folder.ok(&format!("build a.{ending} -o a.fray"));
        assert!(folder.get("a.fray") == folder.get("truth"), "{ending}: another blob than the OBJ's");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn devices_are_not_blobs_and_pipes_may_be() {
    use std::io::Write as _;
    let folder = Folder::with_cube("inputs-devices");
    let verbs = ["info ZERO", "check ZERO", "emit ZERO --as rust -o out", "rays ZERO -o out", "render ZERO -o out"];
    let traces = ["trace ZERO --rays ZERO -o out", "trace cube.fray --rays ZERO -o out"];
    for verb in verbs.into_iter().chain(traces) {
        folder.fails(&verb.replace("ZERO", "/dev/zero"), &["flashray: /dev/zero: ", "device"]);
    }
    let (reader, mut writer) = std::io::pipe().expect("a pipe");
    // The blob is shorter than what a pipe holds.
    writer.write_all(&folder.get("cube.fray")).expect("a pipe takes this");
    drop(writer);
    let output = folder.command("check /dev/stdin").stdin(reader).output().expect("the command starts");
    assert_eq!((output.status.code(), super::text(&output.stderr).as_str()), (Some(0), ""));
}

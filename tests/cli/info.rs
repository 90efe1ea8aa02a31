//! What `info` and `check` say is what the library says.
use super::Folder;
use flashray::blob::Buffer;
use flashray::bvh::{Child, View};
use flashray::{Aabb, Scene};
use serde_json::json;

/// Inner nodes on the longest way to a leaf.
fn depth(view: &View<'_>, child: Child) -> u32 {
    if !child.is_node() {
        return 0;
    }
    let node = view.nodes[child.number() as usize];
    1 + depth(view, node.child[0]).max(depth(view, node.child[1]))
}

fn area(b: &Aabb) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|k| f64::from(b.max[k]) - f64::from(b.min[k]));
    x * y + y * z + z * x
}

/// Expected visits and tests below a child that a ray is certain to meet.
fn cost(view: &View<'_>, child: Child, bounds: &Aabb) -> f64 {
    if !child.is_node() {
        return f64::from(child.len());
    }
    let node = view.nodes[child.number() as usize];
    let below = [0, 1].map(|k| area(&node.bounds(k)) / area(bounds) * cost(view, node.child[k], &node.bounds(k)));
    1.0 + below[0] + below[1]
}

#[test]
fn info_says_what_the_library_says() {
    let folder = Folder::new("info");
    for options in ["", "--rule seed --leaf 2", "--structure list"] {
        folder.ok(&format!("build spd:balls:2 -o b.fray --local 1,2,3 {options}"));
        let bytes = Buffer::from(&folder.get("b.fray")[..]);
        let scene = Scene::from_bytes(&bytes).expect("a good blob");
        let (limits, bounds) = (scene.limits(), scene.bounds());
        let facts = folder.json("info b.fray --json");
        assert_eq!(facts["kind"], scene.kind().name());
        assert_eq!(facts["version"], flashray::blob::VERSION);
        assert_eq!(facts["bytes"], bytes.len());
        assert_eq!(facts["primitives"], scene.len());
        assert_eq!(facts["bytes_per_primitive"], json!(bytes.len() as f64 / 93.0));
        assert_eq!(facts["limits"], json!({ "stack": limits.stack, "steps": limits.steps }));
        assert_eq!(facts["bounds"], json!({ "min": bounds.min, "max": bounds.max }));
        assert_eq!(facts["local_origin"], json!([1.0, 2.0, 3.0]));
        let checksum = u32::from_le_bytes(bytes[12..16].try_into().expect("4 bytes"));
        assert_eq!(facts["checksum"], format!("{checksum:08x}"));
        let sah = facts["sah_cost"].as_f64().expect("a number");
        assert_eq!(facts["end_point_overlap"].is_null(), scene.kind() == flashray::Kind::List);
        if let Some(view) = scene.bvh() {
            assert_eq!(facts["nodes"], view.nodes.len());
            assert_eq!(facts["leaves"], view.nodes.len() + 1);
            assert_eq!(facts["depth"], depth(&view, Child::node(0)));
            let expected = cost(&view, Child::node(0), &bounds);
            assert!((sah / expected - 1.0).abs() < 1e-6, "{options}: {sah}, not {expected}");
        } else {
            assert_eq!((&facts["nodes"], &facts["depth"], sah), (&json!(0), &json!(0), 93.0));
        }
    }
}

#[test]
fn info_says_the_width_of_nodes() {
    let folder = Folder::new("info-width");
    for (options, width, node) in [("wide", 8, 256), ("wide --width 8", 8, 256), ("wide --width 4", 4, 128)] {
        folder.ok(&format!("build spd:balls:2 -o b.fray --structure {options}"));
        let facts = folder.json("info b.fray --json");
        assert_eq!((&facts["kind"], &facts["width"]), (&json!("wide"), &json!(width)));
        let section = if width == 4 { "wide4 nodes" } else { "wide nodes" };
        assert_eq!(facts["sections"][section].as_u64(), facts["nodes"].as_u64().map(|nodes| nodes * node));
        let said = folder.ok("info b.fray");
        assert!(said.contains(&format!("width        {width} children of a node at most")), "{said}");
    }
    folder.ok("build spd:balls:2 -o b.fray");
    assert_eq!(folder.json("info b.fray --json")["width"], json!(null));
    assert!(!folder.ok("info b.fray").contains("width"));
}

#[test]
fn info_for_people_has_the_same_numbers() {
    let folder = Folder::with_cube("info-text");
    let (facts, said) = (folder.json("info cube.fray --json"), folder.ok("info cube.fray"));
    let line = |start: &str| said.lines().find(|l| l.starts_with(start)).unwrap_or_else(|| panic!("{start}: {said}"));
    let checksum = facts["checksum"].as_str().expect("text");
    for (start, parts) in [
        ("kind ", vec!["bvh".to_string(), "version 2".into()]),
        ("checksum ", vec![checksum.into()]),
        ("bytes ", vec![format!("{} ", facts["bytes"])]),
        ("primitives ", vec!["12".into()]),
        ("  triangles ", vec![format!("{} ", 12 * 36)]),
        ("nodes ", vec![format!("{} ", facts["nodes"]), format!("depth {}", facts["depth"])]),
        ("SAH cost ", vec![format!("{:.2}", facts["sah_cost"].as_f64().expect("a number"))]),
        ("EPO ", vec![format!("{:.3},", facts["end_point_overlap"].as_f64().expect("a number"))]),
        ("ray cost ", vec![format!("{:.2},", facts["ray_cost"]["all"].as_f64().expect("a number"))]),
        ("  chord ", vec![format!("{:.2}:", facts["ray_cost"]["chord"]["cost"].as_f64().expect("a number"))]),
        (
            "worst case ",
            vec![format!("stack {} ", facts["limits"]["stack"]), format!("{} steps", facts["limits"]["steps"])],
        ),
        ("bounds ", vec!["[-1.0, -1.0, -1.0] .. [1.0, 1.0, 1.0]".into()]),
        ("local origin ", vec!["[0.0, 0.0, 0.0]".into()]),
    ] {
        for part in parts {
            assert!(line(start).contains(&part), "no `{part}` in `{}`", line(start));
        }
    }
}

/// Two squares that cross: half of each lies in the other's box. A ray that ends there visits both leaves.
#[test]
fn info_knows_the_overlap_at_end_points() {
    let folder = Folder::new("info-overlap");
    folder.put(
        "cross.obj",
        "v 0 0 1\nv 2 0 1\nv 2 2 1\nv 0 2 1\nv 1 0 0\nv 3 0 2\nv 3 2 2\nv 1 2 0\nf 1 2 3 4\nf 5 6 7 8\n",
    );
    let cost = |options: &str| {
        folder.ok(&format!("build cross.obj -o cross.fray {options}"));
        folder.json("info cross.fray --json")
    };
    // Leaves of two triangles, and no inner node but the root. Of the slanting square a line lies in the flat one's box;
    // of the flat one half, an area of 2, lies in the slanting one's box: two tests in vain.
    let facts = cost("--rule seed --leaf 2");
    let (overlap, expected) =
        (facts["end_point_overlap"].as_f64().expect("a number"), 2.0 * 2.0 / (4.0 + 32f64.sqrt()));
    assert_eq!(facts["nodes"], 1, "{facts}");
    assert!((overlap - expected).abs() < 0.01, "{overlap}, not {expected}");
    // One leaf of everything is never visited in vain, and of other structures nothing is said.
    assert_eq!(cost("--structure list")["end_point_overlap"], json!(null));
}

/// The same rays whatever the structure: the list tests everything, and a hierarchy of one leaf too.
#[test]
fn info_measures_what_rays_cost() {
    let folder = Folder::new("info-cost");
    for (structure, step, test) in [("list", 1.0, 1.0), ("bvh", 3.0, 1.0), ("sphere", 3.0, 1.0), ("wide", 1.0, 0.6)] {
        folder.put("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n");
        folder.ok(&format!("build one.obj -o one.fray --structure {structure} --local 5,0,0"));
        let cost = &folder.json("info one.fray --json")["ray_cost"];
        let number = |value: &serde_json::Value| value.as_f64().expect("a number");
        // Constants are f32.
        assert!((number(&cost["step"]) - step).abs() < 1e-6 && (number(&cost["test"]) - test).abs() < 1e-6, "{cost}");
        for kind in ["camera", "diffuse", "shadow", "chord"] {
            let of = &cost[kind];
            assert!(number(&of["rays"]) >= 16.0 && number(&of["steps"]) == 0.0, "{structure}: {cost}");
            assert!(number(&of["tests"]) <= 1.0, "{structure}: {cost}");
            assert!((number(&of["cost"]) - number(&of["tests"]) * test).abs() < 1e-6, "{structure}: {cost}");
        }
        assert!(number(&cost["camera"]["tests"]) > 0.5, "{structure}: {cost}");
    }
}

#[test]
fn info_has_numbers_for_a_scene_without_area() {
    let folder = Folder::new("info-flat");
    folder.put("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\nf 1 2 3\nf 2 3 4\nf 1 2 4\nf 1 3 4\n");
    folder.ok("build line.obj -o line.fray --leaf 1");
    let facts = folder.json("info line.fray --json");
    assert!(facts["sah_cost"].as_f64().is_some_and(|cost| cost >= 1.0), "{facts}");
    assert!(!folder.ok("info line.fray").contains("NaN"));
}

#[test]
fn check_says_ok_or_why_not() {
    let folder = Folder::with_cube("check");
    let mut blob = folder.get("cube.fray");
    let bytes = blob.len();
    assert_eq!(folder.ok("check cube.fray"), format!("cube.fray: ok: bvh, 12 primitives, {bytes} bytes\n"));
    assert_eq!(folder.json("check cube.fray --json"), json!({ "ok": true, "bytes": bytes, "error": null }));
    blob[bytes - 1] ^= 1;
    folder.put("bad.fray", blob);
    let output = folder.run("check bad.fray --json");
    assert_eq!(output.status.code(), Some(1));
    let facts: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON though it failed");
    assert_eq!((&facts["ok"], &facts["bytes"]), (&json!(false), &json!(bytes)));
    let error = facts["error"].as_str().expect("a sentence");
    assert!(error.starts_with("bad.fray: rule 14, "), "{error}");
    assert_eq!(super::text(&output.stderr), format!("flashray: {error}\n"));
}

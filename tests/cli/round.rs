//! Build, check, make rays, trace: every structure gives the list's bytes.
use super::{Folder, MISS};
use flashray::Ray;
use serde_json::json;

/// Options of `build` whose blobs must all answer alike.
const VARIANTS: [&str; 6] = [
    "--structure list --rule seed",
    "--structure bvh",
    "--structure bvh --rule seed",
    "--structure bvh --rule sah --leaf 1",
    "--leaf 15",
    "--json",
];

/// Builds the list and all variants of `input`, and compares what they answer to 600 rays.
fn round(folder: &Folder, input: &str, prims: u64) {
    folder.ok(&format!("build {input} -o list.fray --structure list"));
    folder.ok("rays list.fray -o rays --count 600 --seed 3");
    assert_eq!(folder.get("rays").len(), 600 * 32);
    let facts = folder.json("trace list.fray --rays rays -o truth --json");
    let truth = folder.get("truth");
    assert_eq!(truth.len(), 600 * 16);
    let found = truth.chunks_exact(16).filter(|hit| **hit != MISS).count();
    assert!(found > 100 && found < 600, "{input}: {found} of 600 rays hit");
    assert_eq!((facts["rays"].as_u64(), facts["hits"].as_u64()), (Some(600), Some(found as u64)));
    for options in VARIANTS {
        let said = folder.ok(&format!("build {input} -o b.fray {options}"));
        assert!(said.contains(&prims.to_string()), "{options}: {said}");
        let checked = folder.ok("check b.fray");
        assert!(checked.starts_with("b.fray: ok: ") && checked.contains(&format!(" {prims} primitives")), "{checked}");
        folder.ok("trace b.fray --rays rays -o hits");
        assert!(folder.get("hits") == truth, "{input} {options}: answers differ from the list's");
    }
}

#[test]
fn every_structure_of_a_generated_scene_answers_like_the_list() {
    round(&Folder::new("round-balls"), "spd:balls:2", 93);
}

#[test]
fn every_structure_of_a_mesh_file_answers_like_the_list() {
    round(&Folder::with_cube("round-cube"), "cube.obj", 12);
}

#[test]
fn build_says_what_it_made() {
    let folder = Folder::new("build-says");
    let facts = folder.json("build spd:balls:2 -o a.fray --json");
    let bytes = folder.get("a.fray").len();
    assert_eq!((&facts["kind"], &facts["primitives"], &facts["bytes"]), (&json!("bvh"), &json!(93), &json!(bytes)));
    assert!(facts["seconds"].as_f64().is_some_and(|s| (0.0..60.0).contains(&s)), "{facts}");
    let said = folder.ok("build spd:balls:2 -o b.fray");
    assert!(said.starts_with(&format!("b.fray: bvh, 93 primitives, {bytes} bytes, ")), "{said}");
    assert!(folder.get("a.fray") == folder.get("b.fray"), "two builds differ");
    assert_eq!(folder.json("build spd:balls:2 -o c.fray --structure list --json")["kind"], "list");
    let sizes = ["1", "4", "15"].map(|leaf| {
        folder.ok(&format!("build spd:balls:2 -o c.fray --rule seed --leaf {leaf}"));
        folder.get("c.fray").len()
    });
    assert!(sizes[0] > sizes[1] && sizes[1] > sizes[2], "larger leaves, fewer nodes: {sizes:?}");
}

#[test]
fn a_local_origin_is_kept_and_agrees_with_the_list() {
    let folder = Folder::with_cube("local");
    for structure in ["list", "bvh"] {
        folder.ok(&format!("build cube.obj -o {structure}.fray --structure {structure} --local -0.5,2,1e3"));
        assert_eq!(folder.json(&format!("info {structure}.fray --json"))["local_origin"], json!([-0.5, 2.0, 1000.0]));
    }
    folder.ok("rays list.fray -o rays --count 400");
    folder.ok("trace list.fray --rays rays -o truth");
    folder.ok("trace bvh.fray --rays rays -o hits");
    assert!(folder.get("hits") == folder.get("truth"));
    let found = folder.get("truth").chunks_exact(16).filter(|hit| **hit != MISS).count();
    assert!(found > 50, "rays are made where the scene is, not around its local origin: {found} hits");
}

#[test]
fn modes_threads_and_any_agree() {
    let folder = Folder::new("modes");
    folder.ok("build spd:balls:2 -o b.fray");
    // More than one chunk of 4096, and not a whole number of groups of 64.
    folder.ok("rays b.fray -o rays --count 9001");
    folder.ok("trace b.fray --rays rays -o truth");
    let truth = folder.get("truth");
    assert_eq!(truth.len(), 9001 * 16);
    for options in [
        "--mode single",
        "--mode group",
        "--mode packet",
        "--mode packet --packet 16",
        "--threads 1",
        "--threads 3 --mode group",
    ] {
        folder.ok(&format!("trace b.fray --rays rays -o hits {options}"));
        assert!(folder.get("hits") == truth, "{options}");
        folder.ok(&format!("trace b.fray --rays rays -o any --any {options}"));
        let expected: Vec<u8> = truth.chunks_exact(16).map(|hit| u8::from(*hit != MISS)).collect();
        assert!(folder.get("any") == expected, "--any {options}");
        assert!(expected.contains(&0) && expected.contains(&1));
    }
    assert_eq!(folder.json("trace b.fray --rays rays -o hits --threads 3 --json")["threads"], 3);
    let facts = folder.json("trace b.fray --rays rays -o hits --any --json");
    assert_eq!(facts["hits"].as_u64(), Some(folder.get("hits").iter().map(|b| u64::from(*b)).sum()));
    assert!(facts["seconds"].is_f64() && facts["mrays_per_second"].is_f64(), "{facts}");
}

/// A hit's 16 bytes.
fn hit(t: f32, u: f32, v: f32, prim: u32) -> Vec<u8> {
    [t.to_bits(), u.to_bits(), v.to_bits(), prim].iter().flat_map(|word| word.to_le_bytes()).collect()
}

#[test]
fn rays_written_by_hand_hit_where_geometry_says() {
    let folder = Folder::with_cube("by-hand");
    let down = Ray::new([0.5, -0.25, 5.0], [0.0, 0.0, -1.0]);
    let rays = [
        down,
        Ray::new([-0.5, 0.25, 5.0], [0.0, 0.0, -2.0]),
        down.within(4.5, f32::INFINITY),
        down.within(0.0, 3.0),
        Ray::new([0.5, -0.25, 5.0], [0.0, 0.0, 1.0]),
        Ray::new([f32::NAN, 0.0, 5.0], [0.0, 0.0, -1.0]),
        Ray::new([0.0, 0.0, 5.0], [0.0; 3]),
    ];
    let miss = || MISS.to_vec();
    let expected =
        [hit(4.0, 0.375, 0.375, 0), hit(2.0, 0.25, 0.375, 1), hit(6.0, 0.25, 0.125, 3), miss(), miss(), miss(), miss()];
    folder.put_rays("rays", &rays);
    let said = folder.ok("trace cube.fray --rays rays -o hits");
    assert!(said.starts_with("hits: 7 rays, 3 hits, "), "{said}");
    for (i, hit) in folder.get("hits").chunks_exact(16).enumerate() {
        assert_eq!(hit, expected[i], "ray {i}");
    }
    assert_eq!(folder.get("hits").len(), 7 * 16);
    folder.ok("trace cube.fray --rays rays -o hits --any");
    assert_eq!(folder.get("hits"), [1, 1, 1, 0, 0, 0, 0]);
    folder.put("none", []);
    folder.ok("trace cube.fray --rays none -o hits");
    assert!(folder.get("hits").is_empty());
}

#[test]
fn rays_depend_on_the_seed_and_on_nothing_else() {
    let folder = Folder::with_cube("rays");
    let rays = |options: &str| {
        folder.ok(&format!("rays cube.fray -o rays {options}"));
        folder.get("rays")
    };
    let first = rays("--count 100");
    assert_eq!(first.len(), 3200);
    assert!(rays("--count 100 --seed 1") == first, "the seed is 1 if none is given");
    assert!(rays("--count 100 --seed 2") != first);
    assert!(rays("--count 0").is_empty());
    assert_eq!(rays("--count 1").len(), 32);
}

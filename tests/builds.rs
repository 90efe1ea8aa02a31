//! Builders: lent memory, bad meshes, hostile soups, and the golden blobs.
use crate::common::meshes::{icosphere, mixed};
use crate::common::{bits, build, configs};
use crate::soup::Soup;
use flashray::blob::Buffer;
use flashray::build::{Arena, BuildError, Config, Mesh, Needs, Quality, What, into, to_vec};
use flashray::{Kind, Ray, Scene, Sphere};
use std::fs;
use std::path::PathBuf;

#[test]
fn building_in_lent_memory_gives_the_same_bytes_and_says_what_is_full() {
    let soup = mixed(100, 3);
    let mesh = soup.mesh();
    for config in configs() {
        let expected = to_vec(&mesh, &config).expect("a good mesh");
        let needs = Needs::new(&mesh, &config).expect("small enough");
        assert!(needs.refs >= 100 && needs.bytes >= expected.len());
        let (mut refs, mut nodes) = (heapless::Vec::<_, 4096>::new(), heapless::Vec::<_, 99>::new());
        let (mut cells, mut slots) = (heapless::Vec::<_, 131_072>::new(), heapless::Vec::<_, 65536>::new());
        let mut arena = Arena { refs: &mut refs, nodes: &mut nodes, cells: &mut cells, slots: &mut slots };
        let mut out = vec![0xa5; needs.bytes];
        assert_eq!(into(&mesh, &config, &mut arena, &mut out), Ok(&expected[..]));
        // One byte short: the error says how many are enough, and nothing is written.
        let mut short = vec![0xa5; expected.len() - 1];
        let full = BuildError::Full { what: What::Out, needed: expected.len(), had: expected.len() - 1 };
        assert_eq!(into(&mesh, &config, &mut arena, &mut short), Err(full));
        assert!(short.iter().all(|&b| b == 0xa5));
        // One reference short, and nothing of the other parts: the error says which is full.
        let mut few = heapless::Vec::<_, 99>::new();
        let arena = &mut Arena { refs: &mut few, nodes: &mut nodes, cells: &mut cells, slots: &mut slots };
        let full = BuildError::Full { what: What::Refs, needed: needs.refs, had: 99 };
        assert_eq!(into(&mesh, &config, arena, &mut out), Err(full));
        let (mut none, mut no_words, mut empty) =
            (heapless::Vec::<_, 0>::new(), heapless::Vec::<_, 0>::new(), out.clone());
        let parts = [(What::Nodes, needs.nodes), (What::Cells, needs.cells), (What::Slots, needs.slots)];
        for (what, needed) in parts {
            let mut arena = Arena { refs: &mut refs, nodes: &mut nodes, cells: &mut cells, slots: &mut slots };
            match what {
                What::Nodes => arena.nodes = &mut none,
                What::Cells => arena.cells = &mut no_words,
                _ => arena.slots = &mut no_words,
            }
            let result = into(&mesh, &config, &mut arena, &mut empty).map(<[u8]>::len);
            let full = Err(BuildError::Full { what, needed, had: 0 });
            assert_eq!(result, if needed == 0 { Ok(expected.len()) } else { full }, "{config:?}");
        }
    }
}

/// Triangles of all sizes anywhere, some of them twice.
fn shards(n: u32) -> Soup {
    let mut next = 1u32;
    let mut random = || {
        next = next.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        f64::from(next >> 8) as f32 / 16_777_216.0
    };
    let mut soup = Soup::default();
    for i in 0..n {
        let size = 0.05 * random().powi(3);
        let center: [f32; 3] = std::array::from_fn(|_| random());
        for _ in 0..3 {
            soup.positions.push(center.map(|c| c + size * (random() - 0.5)));
        }
        let first = if i % 50 == 49 { 3 * (i - 7) } else { 3 * i };
        soup.triangles.push([first, first + 1, first + 2]);
    }
    soup
}

#[test]
fn any_number_of_threads_builds_the_same_bytes() {
    // So many that threads share the root's bins.
    let (many, some) = (shards(70_000), shards(12_000));
    for kind in [Kind::Bvh, Kind::Sphere, Kind::Wide] {
        for quality in [Quality::Fast, Quality::Default, Quality::High] {
            let soup = if quality == Quality::High { &some } else { &many };
            let config = Config::new(kind).quality(quality);
            let built = [1, 2, 5].map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
                pool.install(|| to_vec(&soup.mesh(), &config)).expect("builds")
            });
            assert!(built[0] == built[1] && built[0] == built[2], "{config:?}");
        }
    }
}

/// Memory that is lent, with room for fewer nodes than a thread of its own for each subtree would need: so one thread
/// builds, as without the feature.
#[test]
fn a_large_scene_in_lent_memory_by_one_thread_has_the_same_bytes() {
    const PRIMS: usize = 20_000;
    let soup = shards(PRIMS as u32);
    let build = move || {
        let (mut refs, mut nodes) = (heapless::Vec::<_, PRIMS>::new(), heapless::Vec::<_, 19_990>::new());
        let (mut cells, mut slots) = (heapless::Vec::<_, 80_000>::new(), heapless::Vec::<_, 0>::new());
        let mut out = vec![0; 4 << 20];
        for kind in [Kind::Bvh, Kind::Sphere, Kind::Wide] {
            for quality in [Quality::Fast, Quality::Default] {
                let config = Config::new(kind).quality(quality);
                let mut arena = Arena { refs: &mut refs, nodes: &mut nodes, cells: &mut cells, slots: &mut slots };
                let blob = into(&soup.mesh(), &config, &mut arena, &mut out).expect("room enough");
                assert!(blob == to_vec(&soup.mesh(), &config).expect("builds"), "{config:?}");
            }
        }
    };
    let stack = std::thread::Builder::new().stack_size(64 << 20);
    stack.spawn(build).expect("a thread").join().expect("the same bytes");
}

/// What `to_vec` asks for, beside the mesh: the references, the nodes, the plan and the blob, and nothing else. Not so by
/// `Quality::High`, whose blob of such loose triangles alone takes nearly 100 bytes each.
#[test]
fn a_build_by_default_or_faster_takes_at_most_200_bytes_a_triangle() {
    let soup = shards(50_000);
    for quality in [Quality::Fast, Quality::Default] {
        for kind in [Kind::Bvh, Kind::Sphere, Kind::Wide] {
            let config = Config::new(kind).quality(quality);
            let needs = Needs::new(&soup.mesh(), &config).expect("small enough");
            let blob = to_vec(&soup.mesh(), &config).expect("builds");
            let lent = 32 * needs.refs + 64 * needs.nodes + 4 * (needs.cells + needs.slots);
            let each = (lent + blob.len()) as f64 / 50_000.0;
            assert!(each <= 200.0, "{config:?}: {each} bytes a triangle");
        }
    }
}

#[test]
fn bad_meshes_are_refused_by_name() {
    let corner = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, f32::NAN, 0.0]];
    let config = Config::new(Kind::Bvh);
    let error = |mesh: &Mesh<'_>, config: &Config| to_vec(mesh, config).expect_err("a bad mesh");
    assert_eq!(error(&Mesh::new(&corner, &[[0, 1, 2]]), &config), BuildError::Primitive { prim: 0 });
    let index = BuildError::Index { triangle: 1, vertex: 3, vertices: 3 };
    assert_eq!(error(&Mesh::new(&corner, &[[0, 1, 0], [0, 1, 3]]), &config), index);
    let balls = [Sphere { center: [0.0; 3], radius: 1.0 }, Sphere { center: [0.0; 3], radius: -1.0 }];
    assert_eq!(error(&Mesh::new(&corner, &[[0, 1, 1]]).spheres(&balls), &config), BuildError::Primitive { prim: 2 });
    assert_eq!(error(&Mesh::default(), &config.leaf(16)), BuildError::Leaf { found: 16 });
    for (kind, width) in [(Kind::Wide, 3), (Kind::Wide, 16), (Kind::Bvh, 4), (Kind::List, 8)] {
        let refused = error(&Mesh::default(), &Config::new(kind).width(width));
        assert_eq!(refused, BuildError::Width { found: width });
        let said = format!("a width of {width}: 8 and 4 are possible, of the structure `wide` alone");
        assert_eq!(refused.to_string(), said);
    }
    let wide = Config::new(Kind::Wide);
    assert_eq!(
        to_vec(&Mesh::new(&corner[..2], &[[0, 1, 0]; 40]), &wide),
        to_vec(&Mesh::new(&corner[..2], &[[0, 1, 0]; 40]), &wide.width(8))
    );
    assert_eq!(error(&Mesh::default(), &config.local([f32::NAN, 0.0, 0.0])), BuildError::Local);
    let huge = [Sphere { center: [3e38, 0.0, 0.0], radius: 3e38 }];
    assert_eq!(error(&Mesh::default().spheres(&huge), &config), BuildError::Primitive { prim: 0 });
    // A scene from end to end of what is allowed has planes that are numbers; one step beyond is refused.
    let end = 126f32.exp2();
    let ends = [[-end; 3], [end; 3], [end, -end, 0.0]];
    for config in configs() {
        let blob = to_vec(&Mesh::new(&ends, &[[0, 1, 2]]), &config).expect("a scene of the greatest size");
        assert!(Scene::from_bytes(&Buffer::from(&blob[..])).is_ok(), "{config:?}");
        let beyond = [[-end; 3], [end; 3], [end.next_up(), -end, 0.0]];
        assert_eq!(error(&Mesh::new(&beyond, &[[0, 1, 2]]), &config), BuildError::Primitive { prim: 0 });
    }
}

#[test]
fn a_million_identical_triangles_in_a_tree_a_tenth_in_cells_and_coincident_centres_end() {
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let triangles = vec![[0, 1, 2]; 1_000_000];
    // Boxes of all sizes around one centre separate by nothing but size.
    let shells: Vec<_> = (1..5000).map(|i| Sphere { center: [0.0; 3], radius: i as f32 }).collect();
    let million = Mesh::new(&positions, &triangles);
    // What parts space lists each of them several times over, which takes that much longer.
    let fewer = Mesh::new(&positions, &triangles[..100_000]);
    // A resolution that the caller insists on would list each of them in every cell.
    assert_eq!(to_vec(&million, &Config::new(Kind::Grid).cells(37)), Err(BuildError::TooLarge));
    for config in configs().into_iter().filter(|c| c.cells == 0) {
        let mesh = if matches!(config.kind, Kind::List | Kind::Bvh | Kind::Sphere) { &million } else { &fewer };
        let blob = Buffer::from(&to_vec(mesh, &config).expect("builds")[..]);
        let scene = Scene::from_bytes(&blob).expect("a good blob");
        // Eight-wide, a level takes up to seven entries.
        let most = if config.kind == Kind::Wide { 60 } else { 20 };
        assert!(scene.limits().stack <= most, "{config:?}: {} entries", scene.limits().stack);
        if config.kind != Kind::List {
            let hit = scene.closest_hit(&Ray::new([0.2, 0.2, 1.0], [0.0, 0.0, -1.0])).expect("a hit");
            assert_eq!((hit.t, hit.prim), (1.0, 0));
        }
        let blob = Buffer::from(&to_vec(&Mesh::default().spheres(&shells), &config).expect("builds")[..]);
        let scene = Scene::from_bytes(&blob).expect("a good blob");
        assert_eq!(scene.closest_hit(&Ray::new([0.0; 3], [0.0, 1.0, 0.0])).map(|h| (h.t, h.prim)), Some((1.0, 0)));
    }
}

#[test]
fn a_staircase_that_halving_boxes_can_not_part_stays_within_the_stack() {
    // Each object half as far as the last: the middle of the box parts off one at a time, as far as f32 goes.
    let balls: Vec<_> = (0..3000)
        .map(|i| Sphere { center: [2.0f32.powi(-(i % 120)), 0.0, 0.0], radius: 1e-38 * (i + 1) as f32 })
        .collect();
    for config in configs() {
        let blob = Buffer::from(&to_vec(&Mesh::default().spheres(&balls), &config.leaf(1)).expect("builds")[..]);
        let scene = Scene::from_bytes(&blob).expect("a good blob");
        let most = if config.kind == Kind::Wide { flashray::wide::STACK } else { 60 };
        assert!(scene.limits().stack <= most, "{config:?}: {} entries", scene.limits().stack);
        if config.kind == Kind::Bvh && config.rule == flashray::build::Rule::Seed {
            assert!(scene.limits().stack >= 32, "{} levels: halving by count never set in", scene.limits().stack);
        }
    }
}

/// The golden blobs, and the mesh and configuration that made each: see tests/golden/README.md.
fn golden() -> Vec<(&'static str, Soup, Config)> {
    vec![
        ("list-empty", Soup::default(), Config::new(Kind::List)),
        ("bvh-empty", Soup::default(), Config::new(Kind::Bvh)),
        ("list-mixed-15", mixed(15, 4), Config::new(Kind::List)),
        ("bvh-mixed-100", mixed(100, 5), Config::new(Kind::Bvh)),
        ("bvh-seed-sphere-80", icosphere(1), Config::new(Kind::Bvh).rule(flashray::build::Rule::Seed)),
        ("grid-empty", Soup::default(), Config::new(Kind::Grid)),
        ("grid-mixed-100", mixed(100, 5), Config::new(Kind::Grid)),
        ("voxel-empty", Soup::default(), Config::new(Kind::Voxel)),
        ("voxel-mixed-100", mixed(100, 5), Config::new(Kind::Voxel).cells(12)),
        ("voxel-seed-mixed-100", mixed(100, 5), Config::new(Kind::Voxel).rule(flashray::build::Rule::Seed)),
        ("nested-empty", Soup::default(), Config::new(Kind::Nested)),
        ("nested-mixed-100", mixed(100, 5), Config::new(Kind::Nested)),
        ("octree-empty", Soup::default(), Config::new(Kind::Octree)),
        ("octree-mixed-100", mixed(100, 5), Config::new(Kind::Octree)),
        ("bsp-empty", Soup::default(), Config::new(Kind::Bsp)),
        ("bsp-mixed-100", mixed(100, 5), Config::new(Kind::Bsp)),
        ("sphere-empty", Soup::default(), Config::new(Kind::Sphere)),
        ("sphere-mixed-100", mixed(100, 5), Config::new(Kind::Sphere)),
        ("wide-empty", Soup::default(), Config::new(Kind::Wide)),
        ("wide-mixed-100", mixed(100, 5), Config::new(Kind::Wide)),
        ("wide-sphere-80", icosphere(1), Config::new(Kind::Wide)),
        ("wide4-mixed-100", mixed(100, 5), Config::new(Kind::Wide).width(4)),
        ("wide4-sphere-80", icosphere(1), Config::new(Kind::Wide).width(4)),
        ("bvh-local-sphere-80", icosphere(1), Config::new(Kind::Bvh).local([0.25, -0.5, 8.0])),
    ]
}

#[test]
fn golden_blobs_load_and_are_built_alike() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    for (name, soup, config) in golden() {
        let path = folder.join(format!("v2-{name}.fray"));
        let built = build(&soup, &config);
        if !path.exists() && std::env::var_os("FLASHRAY_GOLDEN").is_some_and(|v| v == "write") {
            fs::write(&path, &*built).expect("tests/golden can be written");
        }
        let kept = Buffer::from(&fs::read(&path).expect("the golden blob is there")[..]);
        assert!(*kept == *built, "{name}: the builder's bytes have changed");
        let (a, b) = (Scene::from_bytes(&kept).expect(name), Scene::from_bytes(&built).expect(name));
        let ray = Ray::new([3.0, 2.0, 9.0], [-0.3, -0.2, -1.0]);
        assert_eq!(bits(a.closest_hit(&ray)), bits(b.closest_hit(&ray)));
        // The version before has another header, and is read.
        let path = folder.join(format!("v1-{name}.fray"));
        let old = Buffer::from(&fs::read(&path).expect("the golden blob is there")[..]);
        assert_eq!((&old[4..8], &kept[4..8]), (&[1, 0, 0, 0][..], &[2, 0, 0, 0][..]));
        assert!(old.len() == kept.len() && old[16..72] == kept[16..72] && old[80..] == kept[80..], "{name}");
        let old = Scene::from_bytes(&old).expect(name);
        assert_eq!(bits(old.closest_hit(&ray)), bits(b.closest_hit(&ray)));
    }
}

//! Every structure against the list: `t`, `u`, `v` and `prim`, bit by bit.
use crate::common::meshes::{cube, icosphere, mixed, power, scaled};
use crate::common::rays::hostile;
use crate::common::{bits, build, configs, shared_mesh};
use crate::soup::Soup;
use crate::{mesh, spd};
use flashray::build::Config;
use flashray::walk::Isa;
use flashray::walk::mailbox::Last8;
use flashray::{Hit, Kind, Ray, Scene};

/// Compares all structures with the list on so many rays, of which at least a share of 1/20 must hit.
fn agree(name: &str, soup: &Soup, count: usize, seed: u64) {
    let blobs: Vec<_> = configs().iter().map(|c| build(soup, c)).collect();
    let scenes: Vec<_> = blobs.iter().map(|b| Scene::from_bytes(b).expect(name)).collect();
    let rays = hostile(&scenes, count, seed);
    let hits = std::thread::scope(|scope| {
        let workers: Vec<_> = rays
            .chunks(rays.len().div_ceil(2))
            .map(|rays| {
                let scenes = &scenes;
                scope.spawn(move || rays.iter().filter(|ray| same(name, scenes, ray)).count())
            })
            .collect();
        workers.into_iter().map(|w| w.join().expect("no panic")).sum::<usize>()
    });
    assert!(hits * 20 >= count, "{name}: only {hits} of {count} rays hit");
}

/// Whether the ray hits; panics unless all structures say the same.
fn same(name: &str, scenes: &[Scene<'_>], ray: &Ray) -> bool {
    let truth = scenes[0].closest_hit(ray);
    let others = scenes.iter().filter(|s| s.kind() == Kind::Wide).flat_map(|s| Isa::all().map(|isa| s.with_isa(isa)));
    for scene in scenes.iter().copied().chain(others) {
        let kind = scene.kind().name();
        let (hit, steps) = scene.closest_hit_counted(ray);
        assert_eq!(bits(hit), bits(truth), "{name}, {kind}: {ray:?}");
        assert!(steps.nodes + steps.prims <= scene.limits().steps, "{name}, {kind}: {steps:?}");
        let within = scene.closest_hit_within(ray, scene.limits().steps);
        assert_eq!(within.map(bits), Ok(bits(truth)), "{name}, {kind}: {ray:?}");
        assert_eq!(scene.any_hit(ray), truth.is_some(), "{name}, {kind}, any: {ray:?}");
        same_with_mailbox(name, &scene, ray, truth);
    }
    truth.is_some()
}

/// Panics if a mailbox changes an answer. Who lists no primitive twice takes none.
fn same_with_mailbox(name: &str, scene: &Scene<'_>, ray: &Ray, truth: Option<Hit>) {
    let kind = scene.kind();
    if matches!(kind, Kind::List | Kind::Bvh | Kind::Sphere) {
        return;
    }
    let closest = scene.closest_hit_mailed(ray, &mut Last8::default()).0;
    assert_eq!(bits(closest), bits(truth), "{name}, {kind:?}, mailbox: {ray:?}");
    let any = scene.any_hit_mailed(ray, &mut Last8::default()).0;
    assert_eq!(any, truth.is_some(), "{name}, {kind:?}, any, mailbox: {ray:?}");
}

#[test]
fn made_meshes() {
    agree("icosphere", &icosphere(3), 60_000, 1);
    agree("cube", &cube(12), 60_000, 2);
    for (i, exponent) in [-100, -60, 60, 100].into_iter().enumerate() {
        let scale = 2.0f32.powi(exponent);
        agree("scaled icosphere", &scaled(&icosphere(2), scale), 20_000, 3 + i as u64);
    }
    agree("denormal", &scaled(&icosphere(1), 1e-41), 20_000, 9);
}

#[test]
fn tests_are_counted_up_to_the_hit_that_ends_them() {
    // From inside a convex mesh a ray meets one triangle, and the list has come so far.
    let soup = icosphere(2);
    let list = build(&soup, &Config::new(Kind::List));
    let list = Scene::from_bytes(&list).expect("a good blob");
    for i in 0..100 {
        let ray = Ray::new([0.0; 3], [0.3 - 0.01 * i as f32, 0.7, 0.02 * i as f32 - 0.9]);
        let hit = list.closest_hit(&ray).expect("a way out");
        assert_eq!(list.any_hit_counted(&ray).1.prims, hit.prim + 1, "{ray:?}");
        assert_eq!(list.closest_hit_counted(&ray).1.prims, list.len());
    }
    // One cell is the list; voxels pay for it piece by piece.
    for soup in [soup, mixed(200, 1)] {
        let configs = [Config::new(Kind::List), Config::new(Kind::Grid).cells(1), Config::new(Kind::Voxel).cells(1)];
        let blobs = configs.map(|config| build(&soup, &config));
        let [list, grid, voxel] = [0, 1, 2].map(|i: usize| Scene::from_bytes(&blobs[i]).expect("a good blob"));
        for ray in hostile(&[list, grid], 2_000, 5) {
            let tests = list.any_hit_counted(&ray).1.prims;
            for scene in [grid, voxel] {
                let (found, steps) = scene.any_hit_counted(&ray);
                // A cell that is not met is not tested.
                assert!(steps.prims == tests || steps.nodes == 0 && !found, "{}: {ray:?}", scene.kind().name());
            }
        }
    }
}

#[test]
fn primitives_of_all_kinds_at_any_scale() {
    for (i, exponent) in [-100, 100].into_iter().enumerate() {
        agree("scaled mixed", &scaled(&mixed(100, 4), power(exponent)), 1_000, 13 + i as u64);
    }
    // Few rays: what pads a slab is larger than these scenes, so that a ray meets every cell.
    for (i, scale) in [1e-38, 1e-40, 1e-42].into_iter().enumerate() {
        agree("denormal mixed", &scaled(&mixed(40, 4), scale), 100, 17 + i as u64);
    }
}

#[test]
fn mixed_primitives() {
    for n in [1, 2, 3, 7, 8, 9, 15, 16, 17, 40, 200, 1000] {
        agree("mixed", &mixed(n, u64::from(n)), 24_000 / n.max(4) as usize + 12_000, u64::from(n));
    }
}

#[test]
fn soup_of_coincident_and_degenerate_triangles() {
    let mut soup = icosphere(1);
    let all = soup.triangles.clone();
    for i in 0..6 {
        soup.triangles.extend(all.iter().map(|&[a, b, c]| if i % 2 == 0 { [a, b, c] } else { [c, b, b] }));
    }
    agree("coincident", &soup, 40_000, 1);
}

#[test]
fn procedural_scenes() {
    for name in spd::NAMES {
        let soup = spd::scene(name).expect("a known scene").soup;
        agree(name, &soup, 6_000, 7);
    }
}

#[test]
fn real_meshes() {
    for (name, count) in
        [("suzanne", 30_000), ("spot", 12_000), ("cow", 12_000), ("teapot", 12_000), ("kitchen", 2_400)]
    {
        if let Some(path) = shared_mesh(&format!("{name}.obj")) {
            agree(name, &mesh::read(&path).expect(name), count, 11);
        }
    }
}

#[test]
fn a_local_origin_moves_the_scene_and_not_the_answers() {
    let soup = icosphere(3);
    // Whole numbers survive the shift, so the far scene is the near one exactly.
    let shift = 1024.0;
    let grid = |x: f32| (x * 256.0).round() / 256.0;
    let near = Soup { positions: soup.positions.iter().map(|p| p.map(grid)).collect(), ..soup };
    let far = Soup { positions: near.positions.iter().map(|p| p.map(|x| x + shift)).collect(), ..near.clone() };
    for kind in [Kind::List, Kind::Bvh] {
        let (a, b) = (build(&near, &Config::new(kind)), build(&far, &Config::new(kind).local([shift; 3])));
        let (a, b) = (Scene::from_bytes(&a).expect("near"), Scene::from_bytes(&b).expect("far"));
        let mut hits = 0;
        for ray in hostile(&[a], 12_000, 5) {
            let snapped = Ray { origin: ray.origin.map(grid), ..ray };
            let moved = Ray { origin: snapped.origin.map(|x| x + shift), ..ray };
            if moved.origin.map(|x| x - shift) == snapped.origin {
                let hit: Option<Hit> = a.closest_hit(&snapped);
                assert_eq!(bits(b.closest_hit(&moved)), bits(hit), "{ray:?}");
                hits += usize::from(hit.is_some());
            }
        }
        assert!(hits > 1000, "only {hits} rays hit");
    }
}

proptest::proptest! {
    // Small whole numbers make what random floats never do: shared vertices, flat boxes, rays in planes and along
    // edges.
    #[test]
    fn any_small_soup(
        corners in proptest::collection::vec(proptest::array::uniform3(-3i8..4), 3..24),
        faces in proptest::collection::vec(proptest::array::uniform3(0usize..24), 0..40),
        rays in proptest::collection::vec((proptest::array::uniform3(-6i8..7), proptest::array::uniform3(-3i8..4)), 1..40),
    ) {
        let single = |p: [i8; 3]| p.map(f32::from);
        let soup = Soup {
            positions: corners.iter().copied().map(single).collect(),
            triangles: faces.iter().map(|f| f.map(|i| (i % corners.len()) as u32)).collect(),
            ..Soup::default()
        };
        let blobs: Vec<_> = configs().iter().map(|c| build(&soup, c)).collect();
        let scenes: Vec<_> = blobs.iter().map(|b| Scene::from_bytes(b).expect("a good blob")).collect();
        for (origin, dir) in rays {
            same("soup", &scenes, &Ray::new(single(origin), single(dir)));
        }
    }
}

#[test]
fn many_rays_at_once_get_the_same_answers() {
    let soup = icosphere(3);
    let blob = build(&soup, &Config::new(Kind::Bvh));
    let scene = Scene::from_bytes(&blob).expect("a good blob");
    let rays = hostile(&[scene], 1001, 6);
    let (mut hits, mut any) = (vec![None; 1001], vec![false; 1001]);
    scene.closest_hits(&rays, &mut hits);
    scene.any_hits(&rays, &mut any);
    for ((ray, hit), any) in rays.iter().zip(&hits).zip(&any) {
        assert_eq!((bits(*hit), *any), (bits(scene.closest_hit(ray)), scene.any_hit(ray)));
    }
}

//! Many rays at once: the answers are those of one ray at a time, bit by bit, whatever the rays and however many.
use crate::common::meshes::{cube, icosphere, mixed, scaled};
use crate::common::rays::{Random, hostile};
use crate::common::{bits, build, configs};
use crate::soup::Soup;
use flashray::walk::{Isa, Steps};
use flashray::{Kind, Ray, Scene};

/// Compares closest and any hits, counted and not, on so many of the rays.
fn same(name: &str, scene: &Scene<'_>, rays: &[Ray]) -> usize {
    let truth: Vec<_> = rays.iter().map(|ray| scene.closest_hit(ray)).collect();
    for scene in Isa::all().map(|isa| scene.with_isa(isa)) {
        let kind = scene.kind();
        let (mut hits, mut any) = (vec![None; rays.len()], vec![false; rays.len()]);
        scene.closest_hits(rays, &mut hits);
        scene.any_hits(rays, &mut any);
        let (mut counted, mut listed, mut any_counted) = (hits.clone(), hits.clone(), any.clone());
        scene.closest_hits_counted(rays, &mut counted);
        scene.closest_hits_listed(rays, &mut listed);
        scene.any_hits_counted(rays, &mut any_counted);
        assert_eq!((&counted, &listed, &any_counted), (&hits, &hits, &any), "{name}, {kind:?}");
        for (i, ray) in rays.iter().enumerate() {
            assert_eq!(bits(hits[i]), bits(truth[i]), "{name}, {kind:?}, {:?}, {i} of {}: {ray:?}", scene, rays.len());
            assert_eq!(any[i], truth[i].is_some(), "{name}, {kind:?}, any, {i} of {}: {ray:?}", rays.len());
        }
    }
    truth.iter().flatten().count()
}

/// Rays whose origins are near to each other: so they make a group, whatever their directions.
fn near(scene: &Scene<'_>, count: usize, seed: u64) -> Vec<Ray> {
    let rays = hostile(&[*scene], count, seed);
    let mut random = Random::new(seed);
    let b = scene.bounds();
    let size = [0, 1, 2].map(|k| b.max[k] - b.min[k]);
    let most = size.into_iter().fold(0.0, f32::max);
    let mut all = Vec::new();
    for group in rays.chunks(64) {
        // From inside, from a corner, and from outside.
        let share = [random.unit(), random.unit() * 3.0 - 1.0, 0.0][random.below(3)];
        let from = [0, 1, 2].map(|k| b.min[k] + size[k] * share);
        let spread = [0.0, most * 0.05][random.below(2)];
        all.extend(group.iter().map(|ray| {
            let origin = from.map(|x| x + spread * random.unit());
            let to = [0, 1, 2].map(|k| ray.origin[k] + ray.dir[k] - origin[k]);
            match random.below(8) {
                // Through vertices and edges, mostly.
                0..4 => Ray { origin, dir: to, ..*ray },
                _ => Ray { origin, ..*ray },
            }
        }));
    }
    all
}

/// Rays of a camera, tile by tile; of a parallel one, some components are 0.
fn tiles(scene: &Scene<'_>, side: u32, parallel: bool) -> Vec<Ray> {
    let b = scene.bounds();
    let at = |k: usize, share: f32| b.min[k] + (b.max[k] - b.min[k]) * share;
    let far = b.min[2] - 2.0 * (b.max[2] - b.min[2]);
    let mut rays = Vec::new();
    for i in 0..side * side {
        let (tile, pixel) = (i / 64, i % 64);
        let (x, y) = (tile % (side / 8) * 8 + pixel % 8, tile / (side / 8) * 8 + pixel / 8);
        let last = (side - 1) as f32;
        let to = [at(0, x as f32 / last), at(1, y as f32 / last), b.min[2]];
        let from = if parallel { [to[0], to[1], far] } else { [at(0, 0.4), at(1, 0.6), far] };
        rays.push(Ray::new(from, [0, 1, 2].map(|k| to[k] - from[k])));
    }
    rays
}

fn all_rays(name: &str, soup: &Soup, count: usize) {
    let mut hits = 0;
    for (i, config) in configs().iter().enumerate() {
        let blob = build(soup, config);
        let scene = Scene::from_bytes(&blob).expect("a good blob");
        hits += same(name, &scene, &near(&scene, count, 1 + i as u64));
        hits += same(name, &scene, &tiles(&scene, 32, false));
        hits += same(name, &scene, &tiles(&scene, 32, true));
    }
    assert!(hits * 20 >= count * configs().len(), "{name}: only {hits} hits");
}

#[test]
fn groups_answer_as_one_ray_does() {
    all_rays("icosphere", &icosphere(3), 4_000);
    all_rays("cube", &cube(12), 4_000);
    all_rays("mixed", &mixed(300, 3), 4_000);
    all_rays("large", &scaled(&icosphere(2), 2.0f32.powi(100)), 1_000);
    all_rays("small", &scaled(&icosphere(2), 2.0f32.powi(-100)), 1_000);
    all_rays("denormal", &scaled(&icosphere(1), 1e-41), 200);
    all_rays("few", &mixed(5, 3), 500);
}

/// Triangles across the whole scene: a ray meets nearly every box.
fn sheets(n: u32) -> Soup {
    let mut random = Random::new(9);
    let mut soup = Soup::default();
    for i in 0..n {
        soup.positions.extend([(); 3].map(|()| [(); 3].map(|()| random.signed())));
        soup.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    soup
}

/// Rays that have nothing in common, also where more children wait than a stream has room for.
#[test]
fn rays_from_everywhere_answer_as_one_ray_does() {
    let mut deepest = 0;
    for (name, soup, count) in [("icosphere", icosphere(4), 6_000), ("sheets", sheets(4_000), 600)] {
        for config in configs().iter().filter(|config| config.kind == Kind::Wide) {
            let blob = build(&soup, config);
            let scene = Scene::from_bytes(&blob).expect("a good blob");
            deepest = deepest.max(scene.limits().stack);
            assert!(same(name, &scene, &hostile(&[scene], count, 3)) * 20 > count);
        }
    }
    // A stream's ray goes alone where fewer than eight of its 32 places are left.
    assert!(deepest > 24, "{deepest}");
}

#[test]
fn any_number_of_rays_of_any_sense_makes_groups() {
    let soup = icosphere(3);
    for config in configs() {
        let blob = build(&soup, &config);
        let scene = Scene::from_bytes(&blob).expect("a good blob");
        let mut rays = near(&scene, 200, 5);
        for (i, ray) in rays.iter_mut().enumerate() {
            match i % 11 {
                3 => ray.dir[i % 3] = f32::NAN,
                5 => ray.origin[i % 3] = f32::INFINITY,
                7 => (ray.t_min, ray.t_max) = (2.0, 1.0),
                9 => ray.dir = ray.dir.map(|d| d * 1e-36),
                _ => {}
            }
        }
        for n in [0, 1, 7, 8, 9, 63, 64, 65, 130] {
            same("numbers", &scene, &rays[..n]);
        }
        // None that makes sense, and none but tiny directions.
        same("NaN", &scene, &[Ray { origin: [f32::NAN; 3], ..rays[0] }; 70]);
        same("tiny", &scene, &[Ray::new([0.0; 3], [1e-40, -2e-40, 1e-41]); 70]);
        // Of two lengths the lesser counts.
        let (mut hits, mut any) = (vec![None; 100], vec![false; 100]);
        scene.closest_hits(&rays[..70], &mut hits);
        scene.any_hits(&rays[..70], &mut any);
        assert!(hits[70..].iter().all(Option::is_none) && !any[70..].contains(&true));
        let (mut few, mut few_any) = (vec![None; 70], vec![false; 70]);
        scene.closest_hits(&rays[..100], &mut few);
        scene.any_hits(&rays[..100], &mut few_any);
        assert_eq!((&few[..], &few_any[..]), (&hits[..70], &any[..70]));
    }
}

/// Camera rays fetch a node once for all that meet it, and that is what is counted.
#[test]
fn groups_fetch_fewer_nodes() {
    let soup = icosphere(4);
    for config in configs()
        .into_iter()
        .filter(|c| matches!(c.kind, Kind::Bvh | Kind::Wide | Kind::Octree | Kind::Bsp | Kind::Sphere))
    {
        let blob = build(&soup, &config);
        let scene = Scene::from_bytes(&blob).expect("a good blob");
        let rays = tiles(&scene, 128, false);
        let (mut hits, mut any) = (vec![None; rays.len()], vec![false; rays.len()]);
        let nodes = |steps: Steps| u64::from(steps.nodes);
        let one_by_one: u64 = rays.iter().map(|ray| nodes(scene.closest_hit_counted(ray).1)).sum();
        let together = nodes(scene.closest_hits_counted(&rays, &mut hits));
        assert!(0 < together && together * 2 < one_by_one, "{:?}: {together}, {one_by_one}", scene.kind());
        let one_by_one: u64 = rays.iter().map(|ray| nodes(scene.any_hit_counted(ray).1)).sum();
        let together = nodes(scene.any_hits_counted(&rays, &mut any));
        assert!(0 < together && together * 2 < one_by_one, "{:?}, any: {together}, {one_by_one}", scene.kind());
    }
}

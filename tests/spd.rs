//! The procedural scenes' published counts of primary hits and of rays, by blobs.
use crate::common::build;
use crate::spd::{NAMES, scene};
use crate::whitted::Rays;
use flashray::build::{Config, Rule};
use flashray::{Kind, Ray, Scene};

#[test]
fn primary_hits_are_the_published_ones() {
    for name in NAMES {
        let spd = scene(name).expect("a known scene");
        let anchor = spd.anchor.expect("the default size has one");
        let blob = build(&spd.soup, &Config::new(Kind::Bvh));
        let scene = Scene::from_bytes(&blob).expect("a good blob");
        let hits: Vec<f64> = spd
            .view
            .rays(513)
            .filter_map(|(origin, dir)| scene.closest_hit(&Ray::new(origin, dir)))
            .map(|h| f64::from(h.t))
            .collect();
        let mean = hits.iter().sum::<f64>() / hits.len() as f64;
        println!(
            "{name}: {} hits, mean t {mean:.9}; f64: {} hits ({:?} published), mean t {:.9}",
            hits.len(),
            anchor.hits_ours,
            anchor.hits_published,
            anchor.mean_t
        );
        assert!(hits.len().abs_diff(anchor.hits_ours as usize) <= 5, "{name}: {} hits", hits.len());
        assert!((mean / anchor.mean_t - 1.0).abs() < 5e-5, "{name}: mean t {mean}");
    }
}

/// Primitive tests and steps per ray of a coarse test view.
fn work(name: &str, config: &Config) -> (f64, f64) {
    let spd = scene(name).expect("a known scene");
    let blob = build(&spd.soup, config);
    let scene = Scene::from_bytes(&blob).expect("a good blob");
    let (mut tests, mut steps, mut rays) = (0.0, 0.0, 0.0);
    for (origin, dir) in spd.view.rays(129) {
        let (_, spent) = scene.closest_hit_counted(&Ray::new(origin, dir));
        (tests, steps, rays) = (tests + f64::from(spent.prims), steps + f64::from(spent.nodes), rays + 1.0);
    }
    let (tests, steps) = (tests / rays, steps / rays);
    println!("{name}, {} {:?}: {tests:.2} tests and {steps:.2} steps a ray", config.kind.name(), config.rule);
    (tests, steps)
}

#[test]
fn grids_in_cells_are_for_crowds() {
    // A tree in a wide plain: one cell of a uniform grid holds most of it (Havran's counts are 355 to 728 tests).
    for (name, gain) in [("tree", 20.0), ("balls", 5.0)] {
        let (tests, _) = work(name, &Config::new(Kind::Grid));
        for rule in [Rule::Sah, Rule::Seed] {
            let (fewer, steps) = work(name, &Config::new(Kind::Nested).rule(rule));
            assert!(fewer * gain < tests && steps < 40.0, "{name}, {rule:?}: {fewer} tests and {steps} steps a ray");
        }
    }
}

/// For each scene rays reflected and refracted by the README of the SPD, and all rays by Havran's thesis.
const PUBLISHED: [(&str, [Option<usize>; 2], usize); 8] = [
    ("balls", [Some(175_095), Some(0)], 1_402_297),
    ("gears", [Some(304_643), Some(207_564)], 2_845_519),
    ("lattice", [None, Some(0)], 1_687_153),
    ("mount", [Some(354_769), Some(354_769)], 1_334_642),
    ("rings", [Some(315_236), Some(0)], 1_653_384),
    ("teapot", [Some(225_248), Some(0)], 895_744),
    ("tetra", [Some(0), Some(0)], 309_431),
    ("tree", [Some(0), Some(0)], 1_373_492),
];

#[test]
fn secondary_rays_are_as_many_as_published() {
    for (name, spawned, all) in PUBLISHED {
        let spd = scene(name).expect("a known scene");
        let blob = build(&spd.soup, &Config::new(Kind::Bvh));
        let rays = Rays::new(&spd, &Scene::from_bytes(&blob).expect("a good blob"), 129);
        let share = rays.eye as f64 / (513.0 * 513.0);
        let ours = [rays.reflected, rays.refracted, rays.count()];
        println!("{name}: {ours:?} for {spawned:?} and {all}, times {share:.4}");
        for (ours, published) in ours.into_iter().zip([spawned[0], spawned[1], Some(all)]) {
            let wanted = published.map_or(ours as f64, |n| n as f64 * share);
            assert!((ours as f64 - wanted).abs() <= wanted * 0.05, "{name}: {ours} rays for {wanted:.0}");
        }
        assert_eq!(rays.closest.len(), rays.eye + rays.reflected + rays.refracted, "{name}");
    }
}

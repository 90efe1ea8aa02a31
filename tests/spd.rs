//! The procedural scenes' published primary-hit counts, by blobs.
use crate::common::build;
use crate::spd::{NAMES, scene};
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

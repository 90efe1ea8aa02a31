//! The procedural scenes' published primary-hit counts, by blobs.
use crate::common::build;
use crate::spd::{NAMES, scene};
use flashray::build::Config;
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

//! The high quality: better trees than the default's, and the same ones on any number of threads.
use crate::common::build;
use crate::common::meshes::{icosphere, mixed};
use crate::common::rays::Random;
use crate::soup::Soup;
use flashray::build::{Config, Quality, to_vec};
use flashray::{Aabb, Kind, Scene};

const KINDS: [Kind; 3] = [Kind::Bvh, Kind::Sphere, Kind::Wide];

/// Triangles of very unlike sizes: what a top-down split is worst at.
fn unlike(n: usize, seed: u64) -> Soup {
    let mut random = Random::new(seed);
    let mut soup = Soup::default();
    for i in 0..n {
        let size = 0.5f32.powi((i % 9) as i32);
        let at = [(); 3].map(|()| random.signed());
        let first = u32::try_from(soup.positions.len()).expect("few");
        for _ in 0..3 {
            soup.positions.push(at.map(|x| x + random.signed() * size));
        }
        soup.triangles.push([first, first + 1, first + 2]);
    }
    soup
}

#[test]
fn any_number_of_threads_makes_the_same_bytes() {
    // More nodes than a batch has, and one that is no multiple of it.
    for soup in [unlike(9000, 1), icosphere(5), mixed(3000, 2)] {
        for kind in KINDS {
            let config = Config::new(kind).quality(Quality::High);
            let on = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
                pool.install(|| to_vec(&soup.mesh(), &config).expect("a good mesh"))
            };
            let alone = on(1);
            assert!(on(2) == alone && on(5) == alone, "{kind:?}");
        }
    }
}

/// What a walk is expected to cost: half the area of all inner nodes' boxes, and of leaves times primitives.
fn expected(soup: &Soup, config: &Config) -> f64 {
    let blob = build(soup, config);
    let scene = Scene::from_bytes(&blob).expect("a good blob");
    let area = |b: &Aabb| {
        let [x, y, z] = [0, 1, 2].map(|k| f64::from(b.max[k]) - f64::from(b.min[k]));
        x * y + y * z + z * x
    };
    let mut sum = 0.0;
    scene.parts(|part| sum += area(&part.bounds) * part.listed.map_or(3.0, f64::from));
    sum / area(&scene.bounds())
}

#[test]
fn high_costs_less_than_default_and_default_less_than_fast() {
    let soup = unlike(20_000, 1);
    let cost = |quality| expected(&soup, &Config::new(Kind::Bvh).quality(quality));
    let (fast, default, high) = (cost(Quality::Fast), cost(Quality::Default), cost(Quality::High));
    assert!(high < 0.98 * default && default < 0.98 * fast, "{fast}, {default}, {high}");
}

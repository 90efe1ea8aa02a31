//! Many rays a call: the answers are those of one at a time, bit by bit.
#![allow(clippy::large_types_passed_by_value)] // scenes are meant to be copied
use crate::common::meshes::{cube, icosphere, mixed, scaled};
use crate::common::rays::{Random, hostile};
use crate::common::{bits, build};
use crate::soup::Soup;
use flashray::blob::Buffer;
use flashray::build::{Config, Rule};
use flashray::walk::{Isa, PacketSize};
use flashray::{Hit, Kind, Ray, Scene};

/// What no query answers.
const UNTOUCHED: Option<Hit> = Some(Hit { t: -7.0, u: 7.0, v: 7.0, prim: 7 });

/// Rays that are alike, 64 around each of some hostile ones; among some of them stand others.
fn bundles(scene: Scene<'_>, count: usize, seed: u64) -> Vec<Ray> {
    let mut random = Random::new(seed);
    let bases = hostile(&[scene], count, seed);
    let others = hostile(&[scene], count, seed + 1);
    let mut rays = vec![];
    for (i, base) in bases.iter().enumerate() {
        let mut near = |x: f32, by: f32| x * (1.0 + by * (random.unit() - 0.5));
        for j in 0..64 {
            // The same, from one point, in one direction, from here and there.
            let (turn, shift) = [(0.0, 0.0), (0.05, 0.0), (0.0, 0.02), (0.02, 0.02)][i % 4];
            let mut ray = *base;
            ray.origin = ray.origin.map(|x| near(x, shift));
            ray.dir = ray.dir.map(|x| near(x, turn));
            match (i % 5, j % 9) {
                (1, 4) => ray = others[(i + j) % count],
                (2, 4) => ray.t_max = ray.t_min,
                (3, 4) => ray.t_min = f32::NAN,
                (4, 4) => ray = Ray { dir: ray.dir.map(|x| -x), ..ray },
                (4, 5) => ray = ray.within(0.5, 1.0),
                (0, 5) => ray.origin[j % 3] = f32::INFINITY,
                // Two headings, each of enough rays for a group.
                (2, 0..4) => ray.dir[i % 3] *= -1.0,
                (3, 0..4) => ray.dir.rotate_left(1),
                _ => {}
            }
            rays.push(ray);
        }
    }
    rays
}

/// Panics unless every way to ask gives what `truth` says.
fn same(name: &str, scene: Scene<'_>, rays: &[Ray], truth: &[Option<Hit>]) {
    let ways = PacketSize::ALL.map(Some).into_iter().chain([None]);
    for (isa, way) in Isa::all().flat_map(|isa| ways.clone().map(move |way| (isa, way))) {
        let scene = scene.with_isa(isa);
        let (hits, any) = ask(scene, way, rays, rays.len());
        for (i, truth) in truth.iter().enumerate() {
            let ray = rays[i];
            assert_eq!(bits(hits[i]), bits(*truth), "{name}, {way:?}, {isa:?}, ray {i}: {ray:?}");
            assert_eq!(any[i], truth.is_some(), "{name}, {way:?}, {isa:?}, any, ray {i}: {ray:?}");
        }
    }
}

/// So many answers in packets or in groups.
fn ask(scene: Scene<'_>, way: Option<PacketSize>, rays: &[Ray], answers: usize) -> (Vec<Option<Hit>>, Vec<bool>) {
    let (mut hits, mut any) = (vec![UNTOUCHED; answers], vec![true; answers]);
    if let Some(of) = way {
        scene.closest_hits_in_packets(of, rays, &mut hits);
        scene.any_hits_in_packets(of, rays, &mut any);
    } else {
        scene.closest_hits(rays, &mut hits);
        scene.any_hits(rays, &mut any);
    }
    (hits, any)
}

fn agree(name: &str, soup: &Soup, count: usize, seed: u64) {
    let list = build(soup, &Config::new(Kind::List));
    let list = Scene::from_bytes(&list).expect(name);
    let mut rays = bundles(list, count, seed);
    rays.extend(hostile(&[list], count, seed));
    let truth: Vec<_> = rays.iter().map(|ray| list.closest_hit(ray)).collect();
    let hits = truth.iter().flatten().count();
    assert!(hits * 20 >= rays.len(), "{name}: only {hits} rays hit");
    let wide = Config::new(Kind::Wide);
    for config in [wide, wide.rule(Rule::Seed), wide.leaf(1), wide.width(4), wide.width(4).leaf(1)] {
        let blob = build(soup, &config);
        same(name, Scene::from_bytes(&blob).expect(name), &rays, &truth);
    }
}

#[test]
fn alike_or_not_they_get_the_answers_of_the_list() {
    agree("icosphere", &icosphere(3), 250, 1);
    agree("cube", &cube(12), 250, 2);
    agree("one leaf", &icosphere(0), 300, 3);
    agree("mixed", &mixed(200, 1), 100, 4);
    for (i, exponent) in [-100, -60, 60, 100].into_iter().enumerate() {
        agree("scaled", &scaled(&icosphere(2), 2.0f32.powi(exponent)), 100, 5 + i as u64);
    }
    agree("denormal", &scaled(&icosphere(1), 1e-41), 60, 9);
}

#[test]
fn of_coincident_triangles_the_first_answers() {
    let mut soup = icosphere(1);
    let all = soup.triangles.clone();
    for i in 0..6 {
        soup.triangles.extend(all.iter().map(|&[a, b, c]| if i % 2 == 0 { [a, b, c] } else { [c, b, b] }));
    }
    agree("coincident", &soup, 200, 1);
}

#[test]
fn any_number_of_rays_and_no_more_answers_than_rays() {
    for width in [8, 4] {
        any_number_with(&Config::new(Kind::Wide).width(width));
    }
}

fn any_number_with(config: &Config) {
    let blob = build(&icosphere(3), config);
    let scene = Scene::from_bytes(&blob).expect("a good blob");
    let rays = bundles(scene, 3, 3);
    for len in (0..=rays.len()).filter(|len| len % 64 < 20 || len % 7 == 0) {
        let way = [None, Some(PacketSize::Four), Some(PacketSize::Eight), Some(PacketSize::Sixteen)][len % 4];
        for (way, answers) in [(None, len), (way, len.saturating_sub(5)), (way, len + 9)] {
            let (hits, any) = ask(scene, way, &rays[..len], answers);
            for i in 0..answers {
                let truth = if i < len { scene.closest_hit(&rays[i]) } else { UNTOUCHED };
                assert_eq!((bits(hits[i]), any[i]), (bits(truth), truth.is_some()), "{i} of {len}");
            }
        }
    }
    let empty = build(&Soup::default(), config);
    same("empty", Scene::from_bytes(&empty).expect("a good blob"), &rays, &vec![None; rays.len()]);
}

#[test]
fn what_contradicts_itself_comes_to_an_end() {
    for width in [8, 4] {
        contradictions_with(&Config::new(Kind::Wide).width(width));
    }
}

fn contradictions_with(config: &Config) {
    let soup = icosphere(3);
    let good = build(&soup, config);
    let rays = bundles(Scene::from_bytes(&good).expect("a good blob"), 8, 3);
    let mut random = Random::new(1);
    for _ in 0..300 {
        let mut bad = Buffer::from(&good[..]);
        for _ in 0..20 {
            let (at, by) = (random.below(bad.len()), random.below(256));
            bad[at] = by as u8;
        }
        let Ok(scene) = Scene::trust(&bad) else { continue };
        for way in [None, Some(PacketSize::Eight)] {
            ask(scene, way, &rays, rays.len());
        }
    }
}

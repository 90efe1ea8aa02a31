//! Spheres: the margin of their tests, where a sphere and the boxes in it only just meet the ray, at every scale; and
//! every rule of theirs broken.
use crate::blobs::{Break, break_one_by_one, edit, header, load, seal};
use crate::common::meshes::{icosphere, mixed};
use crate::common::rays::Random;
use crate::common::{bits, build};
use crate::soup::Soup;
use flashray::blob::{Rule, Section};
use flashray::build::Config;
use flashray::bvh::Child;
use flashray::geom::Aabb;
use flashray::sphere::{self, encloses};
use flashray::{Cone, Cylinder, Kind, Ray, Scene, Sphere};

fn scaled(soup: &Soup, f: impl Fn(f32) -> f32) -> Soup {
    let point = |p: [f32; 3]| p.map(&f);
    let length = |r: f32| f(r) - f(0.0);
    Soup {
        positions: soup.positions.iter().map(|&p| point(p)).collect(),
        triangles: soup.triangles.clone(),
        spheres: soup.spheres.iter().map(|s| Sphere { center: point(s.center), radius: length(s.radius) }).collect(),
        boxes: soup.boxes.iter().map(|b| Aabb { min: point(b.min), max: point(b.max) }).collect(),
        cylinders: soup
            .cylinders
            .iter()
            .map(|c| Cylinder { base: point(c.base), top: point(c.top), radius: length(c.radius), ..*c })
            .collect(),
        cones: soup
            .cones
            .iter()
            .map(|c| Cone {
                base: point(c.base),
                top: point(c.top),
                base_radius: length(c.base_radius),
                top_radius: length(c.top_radius),
                ..*c
            })
            .collect(),
    }
}

/// A corner of the box of some primitive, moved by a few ulps or not at all.
fn corner(random: &mut Random, boxes: &[Aabb]) -> [f32; 3] {
    let b = boxes[random.below(boxes.len())];
    let ulps = random.below(5) as u32;
    [0, 1, 2].map(|k| {
        let x = if random.below(2) == 0 { b.min[k] } else { b.max[k] };
        (0..ulps).fold(x, |x, _| if random.below(2) == 0 { x.next_up() } else { x.next_down() })
    })
}

/// A ray through corners, from so many scenes away, with a direction of such a length.
fn ray(random: &mut Random, scene: &Scene<'_>, boxes: &[Aabb]) -> Ray {
    let b = scene.bounds();
    let half = [0, 1, 2].map(|k| (b.max[k] / 2.0 - b.min[k] / 2.0).max(1e-44));
    let away = [0.0, 1.0, 1.5, 30.0, 1e3, 1e6][random.below(6)];
    let target = corner(random, boxes);
    let from = match random.below(4) {
        0 => corner(random, boxes),
        1 => {
            let mut from = target;
            let k = random.below(3);
            from[k] += half[k] * away * 2.0;
            from
        }
        _ => [0, 1, 2].map(|k| target[k] + half[k] * away * random.signed()),
    };
    let dir = [0, 1, 2].map(|k| target[k] - from[k]);
    let size = dir.iter().fold(0.0f32, |a, d| a.max(d.abs()));
    let length = [size, 1.0, 1e-44, 1e-38, 1e-30, 1e30, 1e38, f32::MAX][random.below(8)];
    let dir = if size > 0.0 { dir.map(|d| d / size * length) } else { [0.0, length, 0.0] };
    let t = size / length;
    let ray = Ray::new(from, dir);
    match random.below(6) {
        0 => ray.within(t, t),
        1 => ray.within(t.next_down(), t.next_up()),
        2 => ray.within(f32::NEG_INFINITY, f32::INFINITY),
        3 => Ray { dir: dir.map(|d| -d), ..ray }.within(-2.0 * t, 0.0),
        _ => ray,
    }
}

#[test]
fn spheres_pass_over_no_hit_at_any_scale() {
    let (round, all) = (icosphere(2), mixed(150, 3));
    let scales: [f32; 10] = [1.0, 1e3, 1e-3, 1e-10, 1e-30, 1e-37, 3e-42, 1e10, 1e30, 2e36];
    let mut hits = 0;
    for (i, scale) in scales.into_iter().enumerate() {
        for (j, soup) in [&round, &all].into_iter().enumerate() {
            // Far from 0 the pad is mostly that of the origin's own size.
            for far in [0.0, if scale < 1e30 { 1000.0 } else { 2.0 }] {
                let soup = scaled(soup, |x| (x + far) * scale);
                let list = build(&soup, &Config::new(Kind::List));
                let list = Scene::from_bytes(&list).expect("a list");
                let boxes: Vec<_> = list.primitives().map(|(_, p)| p.bounds()).collect();
                let tree = build(&soup, &Config::new(Kind::Sphere).leaf(2));
                let tree = Scene::from_bytes(&tree).expect("a tree");
                let mut random = Random::new((i * 2 + j) as u64 + 40);
                for _ in 0..4000 {
                    let ray = ray(&mut random, &list, &boxes);
                    let truth = list.closest_hit(&ray);
                    assert_eq!(bits(tree.closest_hit(&ray)), bits(truth), "{scale}, {far}: {ray:?}");
                    assert_eq!(tree.any_hit(&ray), truth.is_some(), "{scale}, {far}: {ray:?}");
                    hits += usize::from(truth.is_some());
                }
            }
        }
    }
    assert!(hits > 40_000, "only {hits} rays hit");
}

#[test]
fn a_built_radius_is_the_least_that_the_check_accepts() {
    let unit = Aabb { min: [-1.0; 3], max: [1.0; 3] };
    let root3 = 3.0f32.sqrt();
    let radius = if f64::from(root3).powi(2) < 3.0 { root3.next_up() } else { root3 };
    assert!(encloses(&Sphere { center: [0.0; 3], radius }, &unit));
    assert!(!encloses(&Sphere { center: [0.0; 3], radius: radius.next_down() }, &unit));
    assert!(!encloses(&Sphere { center: [0.0; 3], radius: -radius }, &unit));
    assert!(!encloses(&Sphere { center: [0.0; 3], radius: f32::NAN }, &unit));
    let huge = Aabb { min: [-3e38; 3], max: [3e38; 3] };
    assert!(encloses(&Sphere { center: [0.0; 3], radius: f32::INFINITY }, &huge));
    assert!(!encloses(&Sphere { center: [0.0; 3], radius: f32::MAX }, &huge));
    let point = Aabb { min: [1e-44; 3], max: [1e-44; 3] };
    assert!(encloses(&Sphere { center: [1e-44; 3], radius: 0.0 }, &point));
}

/// A blob of 60 primitives of all kinds under spheres.
fn good_sphere() -> Vec<u8> {
    build(&mixed(60, 1), &Config::new(Kind::Sphere).leaf(3)).to_vec()
}

/// For each rule about spheres an edit that breaks it and no rule before it.
pub const BREAKS: &[(Rule, Break)] = &[
    (Rule::SphereBounds, |b| edit::<sphere::Node>(b, Section::SphereNodes, 0, |n| n.radii[0] = n.radii[0].next_down())),
    (Rule::SphereBounds, |b| edit::<sphere::Node>(b, Section::SphereNodes, 2, |n| n.radii[1] = n.radii[1].next_down())),
    (Rule::SphereBounds, |b| edit::<sphere::Node>(b, Section::SphereNodes, 2, |n| n.radii[1] *= -2.0)),
    (Rule::SphereBounds, |b| edit::<sphere::Node>(b, Section::SphereNodes, 1, |n| n.radii[0] = f32::NAN)),
    (Rule::SphereBounds, |b| edit::<sphere::Node>(b, Section::SphereNodes, 1, |n| n.centers[2][1] = f32::NAN)),
    (Rule::SphereBounds, |b| {
        edit::<sphere::Node>(b, Section::SphereNodes, 1, |n| (n.centers[0][1], n.radii[1]) = (1e3, 1e4));
    }),
    (Rule::NodeOrder, |b| edit::<sphere::Node>(b, Section::SphereNodes, 0, |n| n.child[1] = n.child[0])),
    (Rule::NodeOrder, |b| edit::<sphere::Node>(b, Section::SphereNodes, 0, |n| n.child[0] = Child::node(1 << 27))),
    (Rule::LeafOrder, |b| edit::<sphere::Node>(b, Section::SphereNodes, 0, |n| n.child[0] = Child::leaf(1, 3))),
    (Rule::StackTrue, |b| header(b, |h| h.stack += 1)),
    (Rule::StepsTrue, |b| header(b, |h| h.steps -= 1)),
];

#[test]
fn rules_about_spheres_are_broken_one_by_one() {
    break_one_by_one(&good_sphere(), BREAKS);
    // A larger radius than needed is no mistake.
    let mut bytes = good_sphere();
    edit::<sphere::Node>(&mut bytes, Section::SphereNodes, 0, |n| n.radii = [f32::INFINITY, 2.0 * n.radii[1]]);
    seal(&mut bytes);
    assert_eq!(load(&bytes), Ok(()));
}

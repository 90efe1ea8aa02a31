//! Rays against single primitives: nonsense, ends of intervals, ties, and analytic shapes against f64.
use crate::common::meshes::{icosphere, mixed, power, scaled};
use crate::common::rays::Random;
use crate::common::{bits, build, configs};
use crate::soup::Soup;
use flashray::geom::place::Place;
use flashray::walk::mailbox::Last8;
use flashray::{Aabb, Cone, Cylinder, Ray, Scene, Sphere, Steps};

fn one_triangle() -> Soup {
    Soup {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        ..Soup::default()
    }
}

/// Runs `test` on the scene in every structure.
fn each(soup: &Soup, test: impl Fn(&Scene<'_>)) {
    for config in configs() {
        let blob = build(soup, &config);
        test(&Scene::from_bytes(&blob).expect("a good blob"));
    }
}

#[test]
fn rays_that_make_no_sense_miss() {
    let soup = icosphere(1);
    let good = Ray::new([0.0, 0.0, 5.0], [0.01, 0.02, -1.0]);
    let mut nonsense = vec![
        Ray { dir: [0.0; 3], ..good },
        Ray { dir: [-0.0; 3], ..good },
        good.within(2.0, 1.0),
        good.within(f32::INFINITY, f32::NEG_INFINITY),
        good.within(f32::NAN, 9.0),
        good.within(0.0, f32::NAN),
        good.within(f32::NAN, f32::NAN),
    ];
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for k in 0..3 {
            let (mut a, mut b) = (good, good);
            (a.origin[k], b.dir[k]) = (bad, bad);
            nonsense.extend([a, b]);
        }
    }
    each(&soup, |scene| {
        assert!(scene.any_hit(&good) && scene.closest_hit(&good).is_some());
        for ray in &nonsense {
            misses_at_once(scene, ray);
        }
        // These make sense, but there is nothing so far away.
        for end in [f32::INFINITY, f32::NEG_INFINITY] {
            let ray = good.within(end, end);
            assert_eq!((scene.closest_hit(&ray), scene.any_hit(&ray)), (None, false), "{ray:?}");
        }
    });
}

/// No query takes a step for this ray, or needs fuel.
fn misses_at_once(scene: &Scene<'_>, ray: &Ray) {
    assert_eq!((scene.closest_hit(ray), scene.any_hit(ray)), (None, false), "{ray:?}");
    assert_eq!(scene.closest_hit_counted(ray), (None, Steps::default()), "{ray:?}");
    assert_eq!(scene.any_hit_counted(ray), (false, Steps::default()), "{ray:?}");
    assert_eq!(scene.closest_hit_mailed(ray, &mut Last8::default()), (None, Steps::default()), "{ray:?}");
    assert_eq!(scene.closest_hit_within(ray, 0), Ok(None), "{ray:?}");
}

#[test]
fn minus_zero_is_zero() {
    let soup = mixed(60, 5);
    each(&soup, |scene| {
        let mut random = Random::new(3);
        let mut hits = 0;
        for _ in 0..2000 {
            let mut ray = Ray::new(random.point([0.0; 3], [6.0; 3]), random.point([0.0; 3], [1.0; 3]));
            let k = random.below(3);
            ray.dir[k] = 0.0;
            ray.origin[(k + 1) % 3] = 0.0;
            let mut other = ray;
            other.dir[k] = -0.0;
            other.origin[(k + 1) % 3] = -0.0;
            let (a, b) = (scene.closest_hit(&ray), scene.closest_hit(&other));
            assert_eq!(bits(a), bits(b), "{ray:?}");
            hits += usize::from(a.is_some());
        }
        assert!(hits > 100, "only {hits} rays hit");
    });
}

#[test]
fn both_ends_of_the_interval_count_and_zero_has_no_sign() {
    each(&one_triangle(), |scene| {
        let ray = Ray::new([0.25, 0.25, 2.0], [0.0, 0.0, -1.0]);
        let hit = |ray: Ray| scene.closest_hit(&ray).map(|h| h.t);
        assert_eq!(hit(ray.within(2.0, 2.0)), Some(2.0));
        assert_eq!(hit(ray.within(2.000_001, 9.0)), None);
        assert_eq!(hit(ray.within(0.0, 1.999_999)), None);
        let on = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, -1.0]);
        assert_eq!(hit(on).map(f32::to_bits), Some(0));
        assert_eq!(hit(Ray::new([0.25, 0.25, -2.0], [0.0, 0.0, -1.0])), None);
        let behind = Ray::new([0.25, 0.25, -2.0], [0.0, 0.0, -0.5]).within(-9.0, 9.0);
        assert_eq!(hit(behind), Some(-4.0));
    });
}

#[test]
fn among_equal_distances_the_least_number_wins() {
    let mut soup = one_triangle();
    soup.triangles = vec![[0, 1, 2]; 40];
    soup.spheres = vec![Sphere { center: [0.25, 0.25, -1.0], radius: 1.0 }; 3];
    each(&soup, |scene| {
        let hit = scene.closest_hit(&Ray::new([0.25, 0.25, 3.0], [0.0, 0.0, -1.0])).expect("a hit");
        assert_eq!((hit.t, hit.prim), (3.0, 0));
    });
}

#[test]
fn triangles_without_area_are_never_hit() {
    let mut soup = one_triangle();
    soup.positions.extend([[0.5, 0.0, 0.0], [1e-44, 0.0, 0.0], [0.0, 1e-44, 0.0]]);
    // A point, a line with a corner twice, a line through three corners.
    soup.triangles = vec![[0, 0, 0], [0, 1, 1], [0, 3, 1], [1, 3, 0]];
    each(&soup, |scene| {
        let mut random = Random::new(9);
        for _ in 0..20_000 {
            let target = [random.unit(), 0.0, 0.0];
            let from = random.point([0.0; 3], [2.0; 3]);
            let dir = [0, 1, 2].map(|k| target[k] - from[k]);
            assert_eq!(scene.closest_hit(&Ray::new(from, dir).within(-10.0, 10.0)), None);
        }
    });
    // One of denormal size has an area, if a very small one.
    soup.positions[0] = [-1e-44, -1e-44, 0.0];
    soup.triangles = vec![[0, 4, 5]];
    each(&soup, |scene| assert!(scene.any_hit(&Ray::new([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]))));
}

#[test]
fn a_ray_enters_where_the_corners_run_counter_clockwise() {
    use flashray::geom::{Triangle, ray::Prepared};
    let t = Triangle { v: [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] };
    for turn in 0..3 {
        let turned = |v: [f32; 3]| [v[turn % 3], v[(turn + 1) % 3], v[(turn + 2) % 3]];
        let t = Triangle { v: t.v.map(turned) };
        for (from, enters) in [(1.0, true), (-1.0, false)] {
            let ray = Ray::new(turned([0.25, 0.25, from]), turned([0.1, -0.1, -from]));
            let ray = Prepared::new(&ray, &Place::new(&t.bounds(), [0.0; 3], 0.0)).expect("a good ray");
            assert_eq!(t.crossing(&ray, 9.0).map(|c| c.enters), Some(enters));
        }
    }
}

#[test]
fn extreme_directions_scale_t_and_nothing_else() {
    let soup = icosphere(2);
    each(&soup, |scene| {
        let mut random = Random::new(4);
        for _ in 0..2000 {
            let ray = Ray::new(random.point([0.0; 3], [3.0; 3]), random.point([0.0; 3], [1.0; 3]));
            let plain = scene.closest_hit(&ray);
            // Powers of two: not a bit may change but in the exponent of t.
            for exponent in [-140, -110, -90, 90, 120] {
                let factor = 2.0f32.powi(exponent);
                let other = scene.closest_hit(&Ray { dir: ray.dir.map(|d| d * factor), ..ray });
                let same =
                    |h: &flashray::Hit| (h.t.is_normal() && h.prim != u32::MAX).then_some((h.t * factor, h.prim));
                let expected = plain.map(|h| (h.t, h.prim));
                if expected.is_none_or(|(t, _)| (t / factor).is_normal()) {
                    assert_eq!(other.and_then(|h| same(&h)), expected, "{ray:?} times 2^{exponent}");
                }
            }
        }
    });
}

/// The two crossings of a line with a cone's endless side, by the plain quadratic in f64.
fn cone_f64(c: &Cone, ray: &Ray) -> Vec<f64> {
    let v = |a: [f32; 3]| a.map(f64::from);
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let minus = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let (o, d, base, axis) = (v(ray.origin), v(ray.dir), v(c.base), minus(v(c.top), v(c.base)));
    let (p, l2) = (minus(o, base), dot(axis, axis));
    let (ph, dh) = (dot(p, axis) / l2, dot(d, axis) / l2);
    let (r0, k) = (f64::from(c.base_radius), f64::from(c.top_radius) - f64::from(c.base_radius));
    let (r, s) = (r0 + k * ph, k * dh);
    let a = dot(d, d) - dh * dh * l2 - s * s;
    let b = dot(p, d) - ph * dh * l2 - r * s;
    let cc = dot(p, p) - ph * ph * l2 - r * r;
    let disc = b * b - a * cc;
    let mut roots: Vec<f64> = if disc < 0.0 { vec![] } else { vec![(-b - disc.sqrt()) / a, (-b + disc.sqrt()) / a] };
    roots.retain(|t| (0.0..=1.0).contains(&(ph + dh * t)));
    if c.caps == 1 {
        for (h, radius) in [(0.0, f64::from(c.base_radius)), (1.0, f64::from(c.top_radius))] {
            let t = (h - ph) / dh;
            let q = [0, 1, 2].map(|i| p[i] + t * d[i] - h * axis[i]);
            if dot(q, q) <= radius * radius {
                roots.push(t);
            }
        }
    }
    roots.retain(|&t| t >= 0.0);
    roots
}

/// Compares with f64; rays so close to a silhouette that f32 can not tell may differ, and there must be few.
fn compare(soup: &Soup, reference: impl Fn(&Ray) -> Vec<f64>) {
    let blob = build(soup, &configs()[0]);
    let scene = Scene::from_bytes(&blob).expect("a good blob");
    let (mut random, mut hits, mut differ) = (Random::new(8), 0, 0);
    for _ in 0..40_000 {
        let from = random.point([0.0; 3], [5.0; 3]);
        let to = random.point([0.0; 3], [1.5; 3]);
        let ray = Ray::new(from, [0, 1, 2].map(|k| to[k] - from[k]));
        let expected = reference(&ray).into_iter().fold(f64::INFINITY, f64::min);
        let found = scene.closest_hit(&ray).map_or(f64::INFINITY, |h| f64::from(h.t));
        hits += usize::from(found.is_finite());
        differ += usize::from(expected != found && !((expected - found).abs() < 2e-4 * expected));
    }
    assert!(hits > 4000, "only {hits} of 40000 rays hit");
    assert!(differ <= 8, "{differ} of 40000 rays differ from f64");
}

#[test]
fn cylinders_and_cones_are_those_of_f64() {
    let (base, top) = ([-0.6, -0.4, -0.5], [0.5, 0.3, 0.9]);
    for caps in [0, 1] {
        for (base_radius, top_radius) in [(0.6, 0.6), (0.8, 0.2), (0.0, 1.1), (0.9, 0.0), (0.05, 1.5)] {
            let cone = Cone { base, top, base_radius, top_radius, caps };
            compare(&Soup { cones: vec![cone], ..Soup::default() }, |ray| cone_f64(&cone, ray));
        }
        let cylinder = Cylinder { base, top, radius: 0.6, caps };
        compare(&Soup { cylinders: vec![cylinder], ..Soup::default() }, |ray| cone_f64(&cylinder.as_cone(), ray));
    }
}

#[test]
fn the_box_of_a_nearly_axis_parallel_cone_holds_it() {
    for exponent in 0..24 {
        let tilt = 2.0f32.powi(-exponent);
        for k in 0..3 {
            let mut top = [0.0; 3];
            (top[k], top[(k + 1) % 3]) = (1.0, tilt);
            let b = Cylinder::capped([0.0; 3], top, 1.0).as_cone().bounds();
            let sine = f64::from(tilt) / (1.0 + f64::from(tilt).powi(2)).sqrt();
            let reach = -f64::from(b.min[k]);
            assert!(reach >= sine && reach <= sine * 1.000_01, "tilt {tilt}: {reach} for {sine}");
        }
    }
}

#[test]
fn corners_of_any_size_on_one_line_have_no_area() {
    let mut random = Random::new(12);
    for _ in 0..2000 {
        let d = random.point([0.0; 3], [1.0; 3]);
        let at = |e: i32| d.map(|x| x * 2.0f32.powi(e));
        let corners = [at(-(random.below(40) as i32)), d, at(1 + random.below(8) as i32)];
        let soup = Soup { positions: corners.to_vec(), triangles: vec![[0, 1, 2]], ..Soup::default() };
        let blob = build(&soup, &configs()[0]);
        let scene = Scene::from_bytes(&blob).expect("a good blob");
        for _ in 0..20 {
            let (from, share) = (random.point([0.0; 3], [9.0; 3]), random.unit() * 4.0);
            let dir = [0, 1, 2].map(|k| d[k] * share - from[k]);
            assert_eq!(scene.closest_hit(&Ray::new(from, dir)), None, "{corners:?}");
        }
    }
}

#[test]
fn spheres_and_boxes_are_those_of_f64() {
    let sphere = Sphere { center: [0.3, -0.2, 0.1], radius: 1.2 };
    compare(&Soup { spheres: vec![sphere], ..Soup::default() }, |ray| {
        let f = [0, 1, 2].map(|k| f64::from(ray.origin[k]) - f64::from(sphere.center[k]));
        let d = ray.dir.map(f64::from);
        let sum = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let (a, b, c) = (sum(d, d), sum(f, d), sum(f, f) - f64::from(sphere.radius).powi(2));
        let disc = b * b - a * c;
        let roots = if disc < 0.0 { vec![] } else { vec![(-b - disc.sqrt()) / a, (-b + disc.sqrt()) / a] };
        roots.into_iter().filter(|&t| t >= 0.0).collect()
    });
    let wall = Aabb { min: [-0.9, -0.5, -1.0], max: [0.4, 0.8, 0.7] };
    compare(&Soup { boxes: vec![wall], ..Soup::default() }, |ray| {
        let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
        for k in 0..3 {
            let at = |plane: f32| (f64::from(plane) - f64::from(ray.origin[k])) / f64::from(ray.dir[k]);
            near = near.max(at(wall.min[k]).min(at(wall.max[k])));
            far = far.min(at(wall.min[k]).max(at(wall.max[k])));
        }
        [near, far].into_iter().filter(|&t| near <= far && t >= 0.0).collect()
    });
}

#[test]
fn curved_surfaces_work_at_any_scale() {
    // From 1e-42, where a radius has six bits, to 1e30.
    for exponent in [-139, -130, -127, -126, -100, -40, 0, 40, 100] {
        let s = power(exponent);
        let within = 1e-5 + 4.0 * (f32::from_bits(1) / s);
        let at = |p: [f32; 3]| p.map(|x| x * s);
        let soup = Soup {
            spheres: vec![Sphere { center: at([4.0, 0.0, 0.0]), radius: s }],
            cylinders: vec![Cylinder::capped(at([8.0, 0.0, -1.0]), at([8.0, 0.0, 1.0]), s)],
            cones: vec![Cone::open(at([12.0, 0.0, -2.0]), at([12.0, 0.0, 2.0]), 0.0, 2.0 * s)],
            boxes: vec![Aabb { min: at([15.0, -1.0, -1.0]), max: at([17.0, 1.0, 1.0]) }],
            ..scaled(&one_triangle(), s)
        };
        each(&soup, |scene| {
            // Along x through all of them: where each is entered, in units of the scale.
            let mut ray = Ray::new(at([-1.0, 0.125, 0.25]), at([1.0, 0.0, 0.0]));
            ray.origin[1] = 0.0;
            let mut expected = vec![4.0 - 0.968_245_8, 8.0 - 1.0, 12.0 - 1.125, 15.0];
            for t in expected.drain(..) {
                let hit = scene.closest_hit(&ray.within(t + 1.0 - 0.5, f32::INFINITY)).expect("a hit");
                assert!((hit.t - (t + 1.0)).abs() < within, "2^{exponent}: {} is not {}", hit.t, t + 1.0);
            }
        });
    }
}

//! Tests of the scenes; the decisive one is [`every_scene_shows_its_anchor`].
mod cast;

use super::frame::{Vec3, cross, dot, sub};
use super::gears::{TEETH, outline};
use super::polygon::gear_face;
use super::*;
use cast::{Exact, bounds, look, widen};

/// Triangles, spheres, cylinders, cones.
type Counts = [usize; 4];

impl Sink for Counts {
    fn corner(&mut self, _: Vec3) -> u32 {
        0
    }
    fn triangle(&mut self, _: [u32; 3]) {
        self[0] += 1;
    }
    fn sphere(&mut self, _: Vec3, _: f64) {
        self[1] += 1;
    }
    fn cylinder(&mut self, _: Vec3, _: Vec3, _: f64) {
        self[2] += 1;
    }
    fn cone(&mut self, _: Vec3, _: Vec3, _: [f64; 2]) {
        self[3] += 1;
    }
}

/// The formulas of the module's table.
fn expected(name: &str, size: u32) -> Counts {
    let s = size as usize;
    match name {
        "balls" => [2, (9_usize.pow(size + 1) - 1) / 8, 0, 0],
        "gears" => [572 * s.pow(3) + 2, 0, 0, 0],
        "lattice" => [0, (s + 1).pow(3), 3 * s * (s + 1).pow(2), 0],
        "mount" => [2 * 4_usize.pow(size), 4, 0, 0],
        "rings" => [2, 5 * s * (s + 1) * (2 * s + 1), 5 * s * (s + 1) * (2 * s + 1), 0],
        "teapot" => [66 * s * s - 8 * s, 0, 0, 0],
        "tetra" => [4_usize.pow(size), 0, 0, 0],
        "tree" => [2, (2 << s) - 1, 0, (2 << s) - 1],
        "shells" => [0, (180 << s) + 1, 0, 0],
        "jacks" => [0, 6 * (8_usize.pow(size) - 1) / 7, 3 * (8_usize.pow(size) - 1) / 7, 0],
        _ => [2 * ((32 << (s - 1)) - 1_usize).pow(2), 0, 0, 0],
    }
}

#[test]
fn counts_at_default_size_are_the_published_ones() {
    let published: [Counts; 11] = [
        [2, 7_381, 0, 0],
        // 9,345 polygons: the floor, and 64 gears of two faces and 144 sides.
        [64 * (2 * 142 + 144 * 2) + 2, 0, 0, 0],
        [0, 2_197, 6_084, 0],
        [8_192, 4, 0, 0],
        [2, 4_200, 4_200, 0],
        [9_120 + 2 * 144, 0, 0, 0],
        [4_096, 0, 0, 0],
        [2, 4_095, 0, 4_095],
        [0, 5_761, 0, 0],
        [0, 438, 219, 0],
        [7_938, 0, 0, 0],
    ];
    for (name, counts) in NAMES.into_iter().zip(published) {
        let soup = scene(name).unwrap().soup;
        let found = [&soup.triangles.len(), &soup.spheres.len(), &soup.cylinders.len()];
        assert_eq!(found.map(|&n| n)[..], counts[..3], "{name}");
        assert_eq!(soup.cones.len(), counts[3], "{name}");
        assert!(soup.cylinders.iter().all(|c| c.caps == 0) && soup.cones.iter().all(|c| c.caps == 0));
    }
}

#[test]
fn counts_follow_the_formulas() {
    for recipe in &RECIPES {
        for size in recipe.sizes[0]..=recipe.default {
            let mut counts = Counts::default();
            build(&format!("{}:{size}", recipe.name), &mut counts).unwrap();
            assert_eq!(counts, expected(recipe.name, size), "{}:{size}", recipe.name);
        }
    }
}

#[test]
fn greatest_sizes_are_the_greatest_that_fit() {
    const LIMIT: usize = 1 << 24;
    let total = |name, size| expected(name, size).iter().sum::<usize>();
    for Recipe { name, sizes: [_, greatest], .. } in &RECIPES {
        assert!(total(name, *greatest) <= LIMIT, "{name}");
        // The random numbers of mount end before.
        assert!(total(name, *greatest + 1) > LIMIT || *name == "mount", "{name}");
    }
}

#[test]
fn bounding_boxes() {
    let wanted: [(&str, [Vec3; 2]); 7] = [
        ("balls", [[-12.0, -12.0, -0.5], [12.0, 12.0, 0.8306]]),
        ("gears", [[-2.0, -2.0, 0.0], [2.0, 2.0, 1.0]]),
        ("mount", [[-1.1596, -1.0, -0.7030], [1.0, 1.1596, 1.3782]]),
        ("rings", [[-10.8389, 1.6536, -9.3389], [8.8389, 20.9050, 10.3389]]),
        ("lattice", [[-0.0208; 3], [1.0208; 3]]),
        ("tree", [[-50.0, -50.0, 0.0], [50.0, 50.0, 3.1375]]),
        ("teapot", [[-4.0, -4.0, 0.0], [4.0, 4.0, 3.15]]),
    ];
    for (name, wanted) in wanted {
        let found = bounds(&widen(&scene(name).unwrap().soup));
        let near = |(a, b): (&f64, &f64)| (a - b).abs() < 0.000_051;
        assert!(found.as_flattened().iter().zip(wanted.as_flattened()).all(near), "{name} {found:?}");
    }
}

/// The decisive check: every ray of the published view, on the unrounded scene and on the soup.
#[test]
fn every_scene_shows_its_anchor() {
    for Recipe { name, setting, default, anchor, .. } in &RECIPES {
        let view = setting(*default).0;
        let mut exact = Exact::default();
        build(name, &mut exact).unwrap();
        let rays = view.directions(513).map(|along| (view.from, along));
        let (hits, mean_t) = look(&mut exact, rays);
        println!("{name}: {hits} hits, mean t {mean_t:.9}");
        assert_eq!(hits, anchor.hits_ours, "{name}");
        assert!((mean_t - anchor.mean_t).abs() < 1e-9, "{name} {mean_t}");

        let rays = view.rays(513).map(|(from, along)| (from.map(f64::from), along.map(f64::from)));
        let (hits, mean_t) = look(&mut widen(&scene(name).unwrap().soup), rays);
        println!("{name}: {hits} hits, mean t {mean_t:.9} when rounded to f32");
        assert!(hits.abs_diff(anchor.hits_ours) <= 2, "{name} {hits}");
        // Worst is the lattice, whose eye looks along rows of balls.
        assert!((mean_t / anchor.mean_t - 1.0).abs() < 5e-5, "{name} {mean_t}");
    }
}

#[test]
fn rays_run_row_by_row_from_the_top_left() {
    let view = View { fov: 90.0, ..View::new([0.0, 0.0, 5.0], [0.0; 3], [0.0, 1.0, 0.0]) };
    let rays: Vec<_> = view.rays(3).collect();
    assert_eq!(rays.len(), 9);
    assert!(rays.iter().all(|&(from, _)| from == [0.0, 0.0, 5.0]));
    assert_eq!(rays[4].1, [0.0, 0.0, -1.0]);
    let third = 3_f32.sqrt().recip();
    for (ray, x, y) in [(0, -third, third), (2, third, third), (6, -third, -third)] {
        let (_, along) = rays[ray];
        let off = (along[0] - x).abs().max((along[1] - y).abs()).max((along[2] + third).abs());
        assert!(off < 1e-6, "{along:?}");
    }
}

#[test]
fn views_and_lights_are_usable() {
    for name in NAMES {
        let Spd { view, lights, size, anchor, .. } = scene(name).unwrap();
        assert!(!lights.is_empty() && anchor.is_some(), "{name}:{size}");
        assert!(view.rays(5).all(|(_, along)| along.iter().all(|x| x.is_finite())), "{name}");
    }
    assert_eq!(scene("balls:2").unwrap().anchor, None);
    assert_eq!(scene("balls:4").unwrap().anchor, scene("balls").unwrap().anchor);
}

/// Twice the signed area.
fn area([a, b, c]: [[f64; 2]; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

#[test]
fn gear_face_covers_the_outline_once() {
    let outline = outline([0.25, -0.5], 1.0, true);
    let face = gear_face(TEETH);
    assert_eq!(face.len(), outline.len() - 2);
    let triangles: Vec<_> = face.iter().map(|t| t.map(|i| outline[i as usize])).collect();
    assert!(triangles.iter().all(|&t| area(t) > 0.0));
    let covered: f64 = triangles.iter().map(|&t| area(t)).sum();
    let around = |i: usize| area([[0.0; 2], outline[i], outline[(i + 1) % outline.len()]]);
    let wanted: f64 = (0..outline.len()).map(around).sum();
    assert!((covered - wanted).abs() < 1e-12);

    // Points of a lattice that avoids the edges: inside means in one triangle, outside in none.
    for k in 0..101 * 101_u32 {
        let p = [f64::from(k % 101) * 0.0207 - 0.79, f64::from(k / 101) * 0.0207 - 1.54];
        let holds = |t: &[[f64; 2]; 3]| (0..3).all(|i| area([t[i], t[(i + 1) % 3], p]) > 0.0);
        let crossed = |i: usize| {
            let (a, b) = (outline[i], outline[(i + 1) % outline.len()]);
            (a[1] > p[1]) != (b[1] > p[1]) && (area([a, b, p]) > 0.0) == (b[1] > a[1])
        };
        let inside = (0..outline.len()).filter(|&i| crossed(i)).count() % 2;
        assert_eq!(triangles.iter().filter(|t| holds(t)).count(), inside, "{p:?}");
    }
}

/// Every edge of the triangles from `first` on is used once in each direction.
fn closed(soup: &Soup, first: usize) -> bool {
    let mut edges = std::collections::HashMap::new();
    for t in &soup.triangles[first..] {
        for i in 0..3 {
            let ends = [t[i], t[(i + 1) % 3]].map(|i| soup.positions[i as usize].map(f32::to_bits));
            *edges.entry(ends).or_insert(0) += 1;
        }
    }
    edges.iter().all(|(&[a, b], &uses)| uses == 1 && edges.get(&[b, a]) == Some(&1))
}

#[test]
fn gears_and_tetrahedra_are_closed() {
    // Behind the two triangles of the floor.
    assert!(closed(&scene("gears:1").unwrap().soup, 2));
    assert!(closed(&scene("gears:2").unwrap().soup, 2));
    assert!(closed(&scene("tetra:1").unwrap().soup, 0));
}

#[test]
fn tetrahedra_are_regular() {
    let soup = scene("tetra:3").unwrap().soup;
    for t in &soup.triangles {
        let [a, b, c] = t.map(|i| soup.positions[i as usize].map(f64::from));
        let edges = [sub(b, a), sub(c, b), sub(a, c)];
        // Face diagonals of a cube with edge 1/2.
        assert!(edges.iter().all(|&e| (dot(e, e) - 0.5).abs() < 1e-12));
        assert!(dot(cross(edges[0], edges[1]), cross(edges[0], edges[1])) > 0.0);
    }
}

#[test]
fn bad_specs_are_explained() {
    let error = |spec| scene(spec).err().unwrap();
    assert_eq!(
        error("ballz"),
        "spd:ballz: no such scene; the scenes are balls, gears, lattice, mount, rings, teapot, \
         tetra, tree, shells, jacks, sombrero"
    );
    assert!(error("").starts_with("spd:: no such scene"));
    assert!(error("Balls").starts_with("spd:Balls: no such scene"));
    assert_eq!(error("balls:99"), "spd:balls:99: size must be 0 to 7");
    assert_eq!(error("gears:0"), "spd:gears:0: size must be 1 to 30");
    for spec in ["tree:", "tree:x", "tree:-1", "tree:1:2", "tree:99999999999999", "tree:1.5"] {
        assert_eq!(error(spec), format!("spd:{spec}: size must be 0 to 22"));
    }
}

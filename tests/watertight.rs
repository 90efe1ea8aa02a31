//! Closed meshes, shot exactly through vertices and along edges: every ray crosses as often inwards as outwards.
use crate::common::meshes::{closed, cube, icosphere, scaled};
use crate::common::rays::Random;
use crate::common::{build, shared_mesh};
use crate::mesh;
use crate::soup::Soup;
use flashray::build::Config;
use flashray::geom::Triangle;
use flashray::geom::ray::Prepared;
use flashray::{Kind, Ray, Scene};

/// All crossings of a ray, by a walk over all boxes that it meets: triangles, and whether the ray enters there.
fn crossings(scene: &Scene<'_>, triangles: &[Triangle], ray: &Ray, found: &mut Vec<(u32, bool)>, todo: &mut Vec<u32>) {
    found.clear();
    todo.clear();
    let Some(ray) = Prepared::new(ray, &scene.bounds(), scene.local_origin()) else { return };
    let view = scene.bvh().expect("built as a bvh");
    todo.push(0);
    while let Some(node) = todo.pop() {
        let node = &view.nodes[node as usize];
        for side in 0..2 {
            let (near, far) = ray.slab(&node.bounds(side));
            let child = node.child[side];
            if near > far {
                continue;
            }
            if child.is_node() {
                todo.push(child.number());
            }
            for slot in child.number()..child.number() + child.len() {
                let crossing = triangles[slot as usize].crossing(&ray, f32::INFINITY);
                found.extend(crossing.map(|c| (slot, c.enters)));
            }
        }
    }
}

/// Shoots `count` lines made by `line`; on a convex mesh each must cross 0 or 2 times, once each way.
fn shoot(soup: &Soup, count: usize, convex: bool, line: impl Fn(&mut Random) -> Ray + Sync) {
    let blob = build(soup, &Config::new(Kind::Bvh).leaf(4));
    let scene = Scene::from_bytes(&blob).expect("a good blob");
    let mut triangles: Vec<_> = Vec::new();
    for (_, p) in scene.primitives() {
        let flashray::blob::prims::Primitive::Triangle(t) = p else { panic!("triangles only") };
        triangles.push(t);
    }
    let crossed = std::thread::scope(|scope| {
        let workers: Vec<_> = [1u64, 2]
            .map(|seed| {
                let (scene, triangles, line) = (&scene, &triangles, &line);
                scope.spawn(move || {
                    let (mut random, mut found, mut todo) = (Random::new(seed), Vec::new(), Vec::new());
                    let mut crossed = 0;
                    for _ in 0..count / 2 {
                        let ray = line(&mut random).within(f32::NEG_INFINITY, f32::INFINITY);
                        crossings(scene, triangles, &ray, &mut found, &mut todo);
                        crossed += usize::from(!found.is_empty());
                        let out = found.iter().filter(|c| !c.1).count();
                        assert!(found.len() == 2 * out, "{ray:?} crosses {found:?}");
                        if convex {
                            assert!(
                                matches!((found.len(), out), (0, 0) | (2, 1)),
                                "{ray:?} crosses {found:?}, {out} out"
                            );
                        }
                    }
                    crossed
                })
            })
            .into();
        workers.into_iter().map(|w| w.join().expect("no panic")).sum::<usize>()
    });
    // The rays are aimed at the mesh: a test that never hits would prove nothing.
    assert!(crossed * 4 > count, "only {crossed} of {count} lines cross at all");
}

/// A line through two points of the mesh's own: vertices, or points on edges.
fn through(soup: &Soup, random: &mut Random) -> Ray {
    let mut pick = || {
        let t = soup.triangles[random.below(soup.triangles.len())];
        let k = random.below(3);
        let (p, q) = (soup.positions[t[k] as usize], soup.positions[t[(k + 1) % 3] as usize]);
        if random.below(2) == 0 { p } else { [0, 1, 2].map(|i| p[i] / 2.0 + q[i] / 2.0) }
    };
    let (a, b) = (pick(), pick());
    let dir = [0, 1, 2].map(|k| b[k] - a[k]);
    // Start before the first of them, so that the shear does not begin in the vertex itself every time.
    let back = [0.0, 1.0, 2.0, 3.0][random.below(4)];
    Ray::new([0, 1, 2].map(|k| a[k] - back * dir[k]), dir)
}

#[test]
fn icosphere_through_vertices_and_edges() {
    let ball = icosphere(3);
    assert_eq!((ball.triangles.len(), ball.positions.len()), (1280, 642));
    shoot(&ball, 2_000_000, false, |r| through(&ball, r));
    // From outside at a vertex or an edge's middle: the sphere is convex, so it is crossed twice or not at all.
    shoot(&ball, 2_000_000, true, |r| {
        let from = [0; 3].map(|_| r.signed() * 4.0);
        let target = through(&ball, r);
        Ray::new(from, [0, 1, 2].map(|k| target.origin[k] + target.dir[k] - from[k]))
    });
}

#[test]
fn cube_grid_exactly_through_corners_and_along_edges() {
    // Whole numbers: the lines go through the vertices and along the edges without any rounding.
    let cube = cube(8);
    assert_eq!(cube.triangles.len(), 768);
    let whole = |r: &mut Random| [0; 3].map(|_| r.below(33) as f32 - 12.0);
    shoot(&cube, 3_000_000, true, |r| {
        let corner = cube.positions[r.below(cube.positions.len())];
        loop {
            let dir = [0; 3].map(|_| r.below(9) as f32 - 4.0);
            if dir != [0.0; 3] {
                return Ray::new([0, 1, 2].map(|k| corner[k] - 3.0 * dir[k]), dir);
            }
        }
    });
    shoot(&cube, 500_000, true, |r| {
        let (a, b) = (whole(r), cube.positions[r.below(cube.positions.len())]);
        let dir = [0, 1, 2].map(|k| b[k] - a[k]);
        Ray::new(a, if dir == [0.0; 3] { [1.0, 0.0, 0.0] } else { dir })
    });
}

#[test]
fn bunny_or_a_finer_sphere() {
    let soup = match shared_mesh("bunny.obj") {
        Some(path) => closed(mesh::read(&path).expect("the bunny is a good file")),
        None => icosphere(5),
    };
    shoot(&soup, 2_500_000, false, |r| through(&soup, r));
}

#[test]
fn any_scale() {
    // 1e-30 to 1e30 and into the denormals. Powers of two keep the whole numbers of the cube exact.
    for exponent in [-100, -90, -60, -30, 30, 60, 90, 100] {
        let scale = 2.0f32.powi(exponent);
        let cube = scaled(&cube(4), scale);
        shoot(&cube, 40_000, true, |r| {
            let corner = cube.positions[r.below(cube.positions.len())];
            let dir = [1.0, r.below(3) as f32 - 1.0, r.below(3) as f32 - 1.0];
            Ray::new([0, 1, 2].map(|k| corner[k] - 3.0 * scale * dir[k]), dir.map(|d| d * scale))
        });
        let ball = scaled(&icosphere(2), scale);
        shoot(&ball, 40_000, false, |r| through(&ball, r));
    }
    for scale in [1e-40, 1e-42] {
        let ball = scaled(&icosphere(1), scale);
        shoot(&ball, 40_000, false, |r| through(&ball, r));
    }
}

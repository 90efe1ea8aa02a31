//! Closed meshes, shot exactly through vertices and along edges: every ray crosses as often inwards as outwards.
//!
//! Exactly: by real numbers. All corners are first moved to whole multiples of a power of two, few enough that their
//! differences, eighths of those, and several of them on end are f32 values without any rounding. Every line carries
//! the vertex or the edge that it was made from, and that these lie on it is computed anew before it counts.
use crate::common::meshes::{closed, cube, icosphere, power, scaled, snapped};
use crate::common::rays::Random;
use crate::common::{build, shared_mesh};
use crate::mesh;
use crate::soup::Soup;
use flashray::build::Config;
use flashray::geom::Triangle;
use flashray::geom::place::Place;
use flashray::geom::ray::Prepared;
use flashray::{Kind, Ray, Scene};

/// All crossings of a ray, by a walk over all boxes that it meets: triangles, and whether the ray enters there.
fn crossings(scene: &Scene<'_>, triangles: &[Triangle], ray: &Ray, found: &mut Vec<(u32, bool)>, todo: &mut Vec<u32>) {
    found.clear();
    todo.clear();
    let Some(ray) = Prepared::new(ray, &Place::new(&scene.bounds(), scene.local_origin(), 0.0)) else { return };
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

/// A line, and what of the mesh lies on it: a vertex, twice, or both ends of an edge.
struct Line {
    ray: Ray,
    on: [[f32; 3]; 2],
}

impl Line {
    fn new(origin: [f32; 3], dir: [f32; 3], on: [[f32; 3]; 2]) -> Self {
        Self { ray: Ray::new(origin, dir).within(f32::NEG_INFINITY, f32::INFINITY), on }
    }

    /// How far a point lies from the line, as a vector whose length is in units of the direction's. Exact, for numbers
    /// of 25 bits: differences and products fit in f64.
    fn apart(&self, p: [f32; 3]) -> [f64; 3] {
        let d = self.ray.dir.map(f64::from);
        let q = [0, 1, 2].map(|k| f64::from(p[k]) - f64::from(self.ray.origin[k]));
        [q[1] * d[2] - q[2] * d[1], q[2] * d[0] - q[0] * d[2], q[0] * d[1] - q[1] * d[0]]
    }

    /// Whether this is a line, and exactly through what it says.
    fn is_exact(&self) -> bool {
        self.ray.dir != [0.0; 3] && self.on.iter().all(|&p| self.apart(p) == [0.0; 3])
    }

    /// Whether the line comes so close to a point.
    fn meets(&self, (center, radius): Ball) -> bool {
        let square = |v: [f64; 3]| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        square(self.apart(center)) < square(self.ray.dir.map(f64::from)) * f64::from(radius).powi(2)
    }
}

/// Centre and radius of a ball.
type Ball = ([f32; 3], f32);

/// Shoots `count` lines made by `line`: each must leave as often as it enters. Of a convex mesh a ball inside is given:
/// each line crosses it 0 or 2 times, once each way, and twice if it meets the ball.
fn shoot(soup: &Soup, count: usize, convex: Option<Ball>, line: impl Fn(&mut Random) -> Line + Sync) {
    let blob = build(soup, &Config::new(Kind::Bvh).leaf(4));
    let scene = Scene::from_bytes(&blob).expect("a good blob");
    let mut triangles: Vec<_> = Vec::new();
    for (_, p) in scene.primitives() {
        let flashray::blob::prims::Primitive::Triangle(t) = p else { panic!("triangles only") };
        triangles.push(t);
    }
    let worker = |seed: u64| {
        let (mut random, mut found, mut todo) = (Random::new(seed), Vec::new(), Vec::new());
        let mut crossed = 0;
        for _ in 0..count / 2 {
            let line = line(&mut random);
            assert!(line.is_exact(), "{:?} is not through {:?}", line.ray, line.on);
            crossings(&scene, &triangles, &line.ray, &mut found, &mut todo);
            crossed += usize::from(!found.is_empty());
            let out = found.iter().filter(|c| !c.1).count();
            assert!(found.len() == 2 * out, "{:?} crosses {found:?}", line.ray);
            if let Some(ball) = convex {
                let through = line.meets(ball);
                assert!(out == 1 || (out == 0 && !through), "{:?} crosses {found:?}, {out} out", line.ray);
            }
        }
        crossed
    };
    let crossed = std::thread::scope(|scope| {
        let workers = [1, 2].map(|seed| scope.spawn(move || worker(seed)));
        workers.map(|w| w.join().expect("no panic")).iter().sum::<usize>()
    });
    // A test that never hits would prove nothing; one along edges of what is convex need not.
    assert!(crossed * 8 > count, "only {crossed} of {count} lines cross at all");
}

/// An edge, in either direction.
fn edge(soup: &Soup, random: &mut Random) -> [[f32; 3]; 2] {
    let t = soup.triangles[random.below(soup.triangles.len())];
    let k = random.below(3);
    let [p, q] = [t[k], t[(k + 1) % 3]].map(|i| soup.positions[i as usize]);
    random.either([p, q], [q, p])
}

/// So many times the way from one point to another, from a third.
fn beyond(from: [f32; 3], times: f32, [p, q]: [[f32; 3]; 2]) -> [f32; 3] {
    [0, 1, 2].map(|k| from[k] + times * (q[k] - p[k]))
}

/// Through a vertex, and another or a point on an edge. It starts at the vertex or up to three times as far before it.
fn through(soup: &Soup, random: &mut Random) -> Line {
    loop {
        let ([a, _], side) = (edge(soup, random), edge(soup, random));
        let b = beyond(side[0], (random.below(16) as f32 - 8.0).max(0.0) / 8.0, side);
        if a != b {
            let back = -(random.below(4) as f32);
            return Line::new(beyond(a, back, [a, b]), beyond([0.0; 3], 1.0, [a, b]), [a; 2]);
        }
    }
}

/// Along an edge. Where it starts, on the edge or beyond, and how long its direction is are numbers of eighths of it.
fn along(soup: &Soup, random: &mut Random) -> Line {
    let on = edge(soup, random);
    let eighths = [random.below(33) as f32 - 16.0, random.below(8) as f32 + 1.0].map(|n| n / 8.0);
    Line::new(beyond(on[0], eighths[0], on), beyond([0.0; 3], eighths[1], on), on)
}

/// Half of the lines through vertices, half along edges.
fn either(soup: &Soup, random: &mut Random) -> Line {
    if random.below(2) == 0 { through(soup, random) } else { along(soup, random) }
}

/// Lines of each closed mesh.
const LINES: [usize; 3] = [4_000_000, 3_000_000, 3_000_000];
const _: () = assert!(LINES[0] + LINES[1] + LINES[2] == 10_000_000);

#[test]
fn icosphere_through_vertices_and_along_edges() {
    let ball = snapped(&icosphere(3), 17);
    assert_eq!((ball.triangles.len(), ball.positions.len()), (1280, 642));
    // Its faces are farther from the centre than this.
    let inside = Some(([0.0; 3], 0.99));
    shoot(&ball, LINES[0] / 4 * 3, inside, |r| either(&ball, r));
    // From anywhere around to a vertex.
    shoot(&ball, LINES[0] / 4, inside, |r| {
        let [a, _] = edge(&ball, r);
        let from = [0; 3].map(|_| (r.below(1 << 20) as f32 - 524_288.0) / 131_072.0);
        Line::new(from, beyond([0.0; 3], 1.0, [from, a]), [a; 2])
    });
}

#[test]
fn cube_grid_through_corners_and_along_edges() {
    // Whole numbers, small ones: most of these lines lie in faces, or meet several vertices.
    let cube = cube(8);
    assert_eq!(cube.triangles.len(), 768);
    let inside = Some(([4.0; 3], 3.99));
    shoot(&cube, LINES[1] / 3, inside, |r| either(&cube, r));
    shoot(&cube, LINES[1] / 3, inside, |r| {
        let [corner, _] = edge(&cube, r);
        loop {
            let dir = [0; 3].map(|_| r.below(9) as f32 - 4.0);
            if dir != [0.0; 3] {
                return Line::new(beyond(corner, -3.0, [[0.0; 3], dir]), dir, [corner; 2]);
            }
        }
    });
    shoot(&cube, LINES[1] / 3, inside, |r| {
        loop {
            let ([corner, _], from) = (edge(&cube, r), [0; 3].map(|_| r.below(33) as f32 - 12.0));
            if from != corner {
                return Line::new(from, beyond([0.0; 3], 1.0, [from, corner]), [corner; 2]);
            }
        }
    });
}

#[test]
fn bunny_or_a_finer_sphere() {
    let soup = match shared_mesh("bunny.obj") {
        Some(path) => closed(mesh::read(&path).expect("the bunny is a good file")),
        None => icosphere(5),
    };
    let soup = snapped(&soup, 17);
    shoot(&soup, LINES[2], None, |r| either(&soup, r));
}

#[test]
fn any_scale() {
    // 1e-30 to 1e30 and into the denormals, which are whole multiples of the least of them. Powers of two keep what is
    // exact exact.
    for exponent in [-100, -90, -60, -30, 30, 60, 90, 100] {
        let scale = power(exponent);
        let cube = scaled(&cube(4), scale);
        shoot(&cube, 40_000, Some(([2.0 * scale; 3], 1.99 * scale)), |r| either(&cube, r));
        let ball = scaled(&snapped(&icosphere(2), 17), scale);
        shoot(&ball, 40_000, Some(([0.0; 3], 0.95 * scale)), |r| either(&ball, r));
    }
    for exponent in [-132, -139] {
        let ball = scaled(&snapped(&icosphere(1), 7), power(exponent));
        shoot(&ball, 40_000, None, |r| either(&ball, r));
    }
}

//! The walk through cells against two oracles: every cell's slab interval, and exact whole-number geometry.
use crate::common::rays::Random;
use flashray::geom::lattice::Lattice;
use flashray::geom::ray::{Axis, Prepared};
use flashray::walk::dda::{Cursor, Dda};
use flashray::{Aabb, Ray};
use std::collections::BTreeMap;

/// Keeps the cell by steps alone, and notices one outside.
struct Place {
    at: [u32; 3],
    cells: ([u32; 3], [u32; 3]),
}

impl Place {
    fn check(&self) {
        let inside = (0..3).all(|k| self.at[k] >= self.cells.0[k] && self.at[k] < self.cells.1[k]);
        assert!(inside, "{:?} is outside of {:?}", self.at, self.cells);
    }
}

impl Cursor for Place {
    fn put(&mut self, cell: [u32; 3]) {
        self.at = cell;
        self.check();
    }

    fn step(&mut self, axis: Axis, down: bool) {
        let axis = axis.at();
        self.at[axis] = if down { self.at[axis].wrapping_sub(1) } else { self.at[axis] + 1 };
        self.check();
    }
}

/// The cells that a walk visits, in order.
fn visited(ray: &Prepared, lattice: &Lattice, cells: ([u32; 3], [u32; 3]), t_max: f32) -> Vec<[u32; 3]> {
    let mut place = Place { at: [0; 3], cells };
    let mut all = Vec::new();
    if let Some(mut way) = Dda::start(ray, lattice, cells, t_max, &mut place) {
        all.push(place.at);
        while way.advance(t_max, &mut place) {
            all.push(place.at);
        }
    }
    all
}

/// The entry of a cell whose slab interval, cut to the ray's, is not empty.
fn entry(ray: &Prepared, lattice: &Lattice, cell: [u32; 3], (t_min, t_max): (f32, f32)) -> Option<f32> {
    let (near, far) = ray.slab(&lattice.bounds(cell, cell.map(|i| i + 1)));
    let (near, far) = (near.max(t_min), far.min(t_max));
    (near <= far).then_some(near)
}

fn hostile(random: &mut Random, i: usize, b: &Aabb, lattice: &Lattice, n: [u32; 3]) -> Ray {
    let middle = [0, 1, 2].map(|k| b.min[k] / 2.0 + b.max[k] / 2.0);
    let half = [0, 1, 2].map(|k| b.max[k] / 2.0 - b.min[k] / 2.0);
    let corner = |random: &mut Random| Axis::ALL.map(|k| lattice.plane(k, random.below(n[k.at()] as usize + 1) as u32));
    let towards = |from: [f32; 3], to: [f32; 3]| Ray::new(from, [0, 1, 2].map(|k| to[k] - from[k]));
    let around = half.map(|h| h * 1.5);
    let from = random.point(middle, around);
    match i % 10 {
        0 => towards(corner(random), corner(random)),
        1 => towards(from, corner(random)),
        // Along the planes, in them and beside them, and along the lattice's lines.
        2 => {
            let (mut a, b) = (corner(random), corner(random));
            a[random.below(3)] = from[random.below(3)];
            let k = random.below(3);
            let mut ray = towards(a, b);
            ray.dir[k] = 0.0;
            ray
        }
        3 => {
            let mut dir = [0.0; 3];
            dir[random.below(3)] = random.signed();
            Ray::new(corner(random), dir)
        }
        // Through the diagonals of cells: three planes at once.
        4 => {
            let sign = |random: &mut Random| if random.below(2) == 0 { 1.0 } else { -1.0 };
            let dir = lattice.cell.map(|c| c * sign(random));
            let at = corner(random);
            Ray::new([0, 1, 2].map(|k| at[k] - dir[k] * 3.0), dir)
        }
        5 => {
            let far = [0, 1, 2].map(|k| middle[k] + (from[k] - middle[k]) * 1e6);
            towards(far, corner(random))
        }
        6 => towards(corner(random), from).within(-f32::INFINITY, f32::INFINITY),
        7 => towards(from, corner(random)).within(random.unit(), 1.0),
        8 => Ray { dir: towards(from, corner(random)).dir.map(|d| d * 1e-30), ..towards(from, middle) },
        _ => towards(from, random.point(middle, half)),
    }
}

#[test]
fn the_walk_visits_the_cells_whose_interval_is_not_empty_and_each_once() {
    let mut random = Random::new(7);
    let mut most = 0;
    for round in 0..600 {
        let scale = [1.0, 1e-6, 3e5, 1.0][round % 4];
        let at = random.point([0.0; 3], [if round % 3 == 0 { 100.0 } else { 0.5 } * scale; 3]);
        let b = Aabb { min: at, max: [0, 1, 2].map(|k| at[k] + (random.unit() + 0.01) * scale) };
        let n = [0, 1, 2].map(|_| 1 + random.below(9) as u32);
        let lattice = Lattice::over(&b, n);
        assert!(lattice.covers(&b, n), "{b:?} {n:?}");
        // All cells, or some.
        let first = if round % 2 == 0 { [0; 3] } else { n.map(|n| random.below(n as usize) as u32) };
        for i in 0..100 {
            let ray = hostile(&mut random, i, &b, &lattice, n);
            let t_max = if i % 3 == 0 { random.unit() * 2.0 } else { f32::INFINITY };
            let Some(ray) = Prepared::new(&ray, &b, [0.0; 3]) else { continue };
            let walked = visited(&ray, &lattice, (first, n), t_max);
            let mut expected = BTreeMap::new();
            for x in first[0]..n[0] {
                for y in first[1]..n[1] {
                    for z in first[2]..n[2] {
                        if let Some(t) = entry(&ray, &lattice, [x, y, z], (ray.t_min(), t_max)) {
                            expected.insert([x, y, z], t);
                        }
                    }
                }
            }
            let mut last = f32::NEG_INFINITY;
            for cell in &walked {
                let t = expected.remove(cell);
                assert!(t.is_some_and(|t| t >= last), "{cell:?}, entered at {t:?} after {last}: {ray:?} {lattice:?}");
                last = t.unwrap_or(last);
            }
            assert!(expected.is_empty(), "not visited: {expected:?}; visited: {walked:?}; {ray:?} {lattice:?}");
            most = most.max(walked.len());
        }
    }
    assert!(most > 20, "no ray met more than {most} cells");
}

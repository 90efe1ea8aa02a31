//! The walk through cells against two oracles: every cell's slab interval, and exact whole-number geometry.
use crate::common::rays::Random;
use flashray::geom::lattice::Lattice;
use flashray::geom::place;
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
    let from = random.point(middle, half.map(|h| h * 1.5));
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
            let Some(ray) = Prepared::new(&ray, &place::Place::new(&b, [0.0; 3], 0.0)) else { continue };
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

/// A ray whose numbers are whole, and small enough for `f32`.
#[derive(Clone, Copy, Debug)]
struct Whole {
    from: [i64; 3],
    dir: [i64; 3],
}

/// Numerator and positive denominator.
type Fraction = (i128, i128);

fn less(a: Fraction, b: Fraction) -> bool {
    a.0 * b.1 < b.0 * a.1
}

impl Whole {
    /// The fraction `(plane - from) / dir` of an axis, over a positive denominator.
    fn at(&self, k: usize, plane: i64) -> Fraction {
        ((i128::from(plane - self.from[k]) * i128::from(self.dir[k].signum())), i128::from(self.dir[k].abs()))
    }

    /// From where to where the line `t >= 0` is in the cells `0..n`, if that is more than a point.
    fn span(&self, n: i64) -> Option<(Fraction, Fraction)> {
        let (mut t, mut end) = ((0, 1), None);
        for k in 0..3 {
            if self.dir[k] == 0 {
                // In a plane between two cells the chord counts as the upper one's; the walk visits both.
                if self.from[k] < 0 || self.from[k] >= n {
                    return None;
                }
                continue;
            }
            let (a, b) = if self.dir[k] > 0 { (0, n) } else { (n, 0) };
            let (a, b) = (self.at(k, a), self.at(k, b));
            t = if less(t, a) { a } else { t };
            end = Some(end.map_or(b, |e| if less(b, e) { b } else { e }));
        }
        let end = end.expect("a direction");
        less(t, end).then_some((t, end))
    }
}

/// Calls `each` with every cell of `0..n` that the line `t >= 0` crosses, in order, and whether its chord is longer
/// than a thousandth of a cell. Planes are at whole numbers, so a crossing is a fraction, and fractions are compared by
/// cross multiplication.
fn exact(ray: &Whole, n: i64, mut each: impl FnMut([u32; 3], bool)) {
    let Some((mut t, end)) = ray.span(n) else { return };
    let Whole { from, dir } = *ray;
    // The cell just after `t`: floor of the place, and for a falling coordinate that is whole the cell below.
    let place = |k: usize| {
        let x = i128::from(from[k]) * t.1 + t.0 * i128::from(dir[k]);
        let whole = x.div_euclid(t.1);
        if dir[k] < 0 && whole * t.1 == x { whole - 1 } else { whole }
    };
    let mut cell = [0, 1, 2].map(|k| i64::try_from(place(k)).expect("small"));
    let square = dir.iter().map(|&d| i128::from(d) * i128::from(d)).sum::<i128>();
    while less(t, end) {
        let next = |k: usize| (dir[k] != 0).then(|| ray.at(k, cell[k] + i64::from(dir[k] > 0)));
        let mut least = end;
        for k in 0..3 {
            least = next(k).filter(|&x| less(x, least)).unwrap_or(least);
        }
        // (difference of fractions)^2 * |dir|^2 > 10^-6.
        let (num, den) = (least.0 * t.1 - t.0 * least.1, least.1 * t.1);
        each(cell.map(|i| u32::try_from(i).expect("inside")), num * num * square * 1_000_000 > den * den);
        let crossed = [0, 1, 2].map(|k| next(k).is_some_and(|x| !less(least, x)));
        for k in 0..3 {
            cell[k] += if crossed[k] { dir[k].signum() } else { 0 };
        }
        t = least;
    }
}

/// So many rays through `n` cells along each axis. Returns how many cells were visited, how many the line crosses, and
/// how many of those that it crosses for more than a thousandth of a cell.
fn against_whole_numbers(n: u32, rays: usize, random: &mut Random) -> [u64; 3] {
    let lattice = Lattice { min: [0.0; 3], cell: [1.0; 3] };
    let b = Aabb { min: [0.0; 3], max: [n as f32; 3] };
    let size = i64::from(n);
    let mut counts = [0; 3];
    for _ in 0..rays {
        let mut any = |low: i64, high: i64| low + random.below((high - low) as usize) as i64;
        let from = [0, 1, 2].map(|_| any(-size, 2 * size));
        let to = [0, 1, 2].map(|_| any(0, size));
        let mut dir = [0, 1, 2].map(|k| to[k] - from[k]);
        // Some along planes, and some along diagonals.
        match any(0, 16) {
            0 => dir[any(0, 3) as usize] = 0,
            1 => dir[any(0, 3) as usize] = dir[0],
            2 => dir = dir.map(i64::signum),
            _ => {}
        }
        if dir == [0; 3] {
            continue;
        }
        let whole = Whole { from, dir };
        let single = |v: [i64; 3]| v.map(|x| x as f32);
        let ray =
            Prepared::new(&Ray::new(single(from), single(dir)), &place::Place::new(&b, [0.0; 3], 0.0)).expect("a ray");
        let walked = visited(&ray, &lattice, ([0; 3], [n; 3]), f32::INFINITY);
        counts[0] += walked.len() as u64;
        let mut at = 0;
        exact(&whole, size, |cell, long| {
            counts[1] += 1;
            if long {
                counts[2] += 1;
                // Mostly the next; near an edge or a corner the order may differ.
                let near = walked.iter().skip(at).position(|c| *c == cell).map(|i| at + i);
                let found = near.or_else(|| walked.iter().position(|c| *c == cell));
                at = found.unwrap_or_else(|| panic!("{cell:?} of {n} is not visited: {whole:?}"));
            }
        });
    }
    counts
}

/// `FLASHRAY_RAYS` is the number of rays, of which each resolution gets a quarter.
#[test]
fn the_walk_visits_every_cell_that_whole_numbers_say_it_crosses() {
    let rays = std::env::var("FLASHRAY_RAYS").ok().and_then(|v| v.parse().ok()).unwrap_or(20_000);
    for (i, n) in [16, 64, 256, 1024].into_iter().enumerate() {
        let [visited, crossed, long] = against_whole_numbers(n, rays / 4, &mut Random::new(i as u64 + 1));
        println!("{n} cells: {} rays, {visited} visited, {crossed} crossed, {long} of them for long", rays / 4);
        assert!(long > 2 * rays as u64 && visited >= long);
    }
}

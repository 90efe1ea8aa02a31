//! Meshes that the tests make themselves.
use crate::soup::Soup;
use std::collections::HashMap;

/// An icosahedron, each face split in four `n` times, its corners on a sphere of radius 1.
pub fn icosphere(n: u32) -> Soup {
    let g = f64::midpoint(1.0, 5.0f64.sqrt());
    let mut points: Vec<[f64; 3]> = Vec::new();
    for (a, b) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
        points.extend([[0.0, a, b], [a, b, 0.0], [b, 0.0, a]]);
    }
    let mut faces = hull(&points);
    for _ in 0..n {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let (p, q) = (points[a as usize], points[b as usize]);
                points.push([p[0] + q[0], p[1] + q[1], p[2] + q[2]]);
                points.len() as u32 - 1
            })
        };
        let split = |&[a, b, c]: &[u32; 3]| {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
        };
        faces = faces.iter().flat_map(split).collect();
        for p in &mut points {
            let length = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
            *p = p.map(|x| x / length);
        }
    }
    let single = |p: &[f64; 3]| p.map(|x| x as f32);
    Soup { positions: points.iter().map(single).collect(), triangles: faces, ..Soup::default() }
}

/// The faces of the icosahedron: the triples of points at the least distance, turned outwards.
fn hull(points: &[[f64; 3]]) -> Vec<[u32; 3]> {
    let near = |a: usize, b: usize| {
        let d: f64 = (0..3).map(|k| (points[a][k] - points[b][k]).powi(2)).sum();
        (d - 4.0).abs() < 1e-9
    };
    let mut faces = Vec::new();
    for a in 0..points.len() {
        for b in a + 1..points.len() {
            for c in b + 1..points.len() {
                if near(a, b) && near(b, c) && near(c, a) {
                    let [p, q, r] = [points[a], points[b], points[c]];
                    let det = p[0] * (q[1] * r[2] - q[2] * r[1]) - p[1] * (q[0] * r[2] - q[2] * r[0])
                        + p[2] * (q[0] * r[1] - q[1] * r[0]);
                    faces.push(if det > 0.0 { [a, b, c] } else { [a, c, b] }.map(|i| i as u32));
                }
            }
        }
    }
    faces
}

/// The surface of the cube [0, n]^3 as unit squares, two triangles each, with all corners at whole numbers.
pub fn cube(n: u32) -> Soup {
    let mut soup = Soup::default();
    let mut index = HashMap::new();
    for axis in 0..3 {
        for side in [0, n] {
            for i in 0..n {
                for j in 0..n {
                    let mut corner = |di: u32, dj: u32| {
                        let mut p = [0; 3];
                        (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, i + di, j + dj);
                        *index.entry(p).or_insert_with(|| {
                            soup.positions.push(p.map(|x| x as f32));
                            soup.positions.len() as u32 - 1
                        })
                    };
                    let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                    let faces = if side == n { [[a, b, c], [c, d, a]] } else { [[a, c, b], [c, a, d]] };
                    soup.triangles.extend(faces);
                }
            }
        }
    }
    soup
}

/// The mesh with its holes filled by fans over their boundary loops: every edge then has as many faces to one side
/// as to the other.
pub fn closed(mut soup: Soup) -> Soup {
    let mut open: HashMap<(u32, u32), i32> = HashMap::new();
    for &[a, b, c] in &soup.triangles {
        for (p, q) in [(a, b), (b, c), (c, a)] {
            *open.entry((p, q)).or_default() += 1;
            *open.entry((q, p)).or_default() -= 1;
        }
    }
    // Every open directed edge goes into a fan around one vertex: what that adds along the spokes adds up to nothing,
    // because as many open edges leave a vertex as enter it.
    let mut edges: Vec<_> = open.into_iter().filter(|&(_, n)| n > 0).collect();
    edges.sort_unstable();
    let Some(&((hub, _), _)) = edges.first() else { return soup };
    for ((p, q), n) in edges {
        if p != hub && q != hub {
            soup.triangles.extend((0..n).map(|_| [q, p, hub]));
        }
    }
    soup
}

/// All kinds of primitives, some of them without area, some around others, from a few numbers.
pub fn mixed(n: u32, seed: u64) -> Soup {
    use flashray::{Aabb, Cone, Cylinder, Sphere};
    let mut random = super::rays::Random::new(seed);
    let mut soup = Soup::default();
    for i in 0..n {
        let at = [(); 3].map(|()| random.signed() * 4.0);
        let near = |random: &mut super::rays::Random| at.map(|x| x + random.signed());
        match i % 5 {
            0 => {
                let first = soup.positions.len() as u32;
                soup.positions.extend([at, near(&mut random), near(&mut random)]);
                soup.triangles.push(if i % 15 == 10 { [first; 3] } else { [first, first + 1, first + 2] });
            }
            1 => soup.spheres.push(Sphere { center: at, radius: random.unit() }),
            2 => {
                let size = [random.unit(), random.unit(), if i % 4 == 0 { 0.0 } else { random.unit() }];
                soup.boxes.push(Aabb { min: at, max: [0, 1, 2].map(|k| at[k] + size[k]) });
            }
            3 => soup.cylinders.push(Cylinder {
                base: at,
                top: near(&mut random),
                radius: random.unit() / 2.0,
                caps: i & 1,
            }),
            _ => {
                let (base_radius, top_radius) = (random.unit() / 2.0, if i % 3 == 0 { 0.0 } else { random.unit() });
                soup.cones.push(Cone { base: at, top: near(&mut random), base_radius, top_radius, caps: i >> 1 & 1 });
            }
        }
    }
    soup
}

/// A power of two, denormal ones too: those of f32 are made from their inverse, which overflows.
pub fn power(exponent: i32) -> f32 {
    2.0f64.powi(exponent) as f32
}

/// The same triangles, each corner moved to the nearest whole multiple of a power of two, of which the largest
/// coordinate has between `2^(bits - 1)` and `2^bits`.
pub fn snapped(soup: &Soup, bits: i32) -> Soup {
    let size = soup.positions.iter().flatten().fold(0.0f32, |a, x| a.max(x.abs()));
    let unit = power(size.log2().ceil() as i32 - bits);
    let snap = |p: &[f32; 3]| p.map(|x| (x / unit).round() * unit);
    Soup { positions: soup.positions.iter().map(snap).collect(), ..soup.clone() }
}

/// The same mesh, `scale` times as large.
pub fn scaled(soup: &Soup, scale: f32) -> Soup {
    let mut soup = soup.clone();
    let larger = |p: &mut [f32; 3]| *p = p.map(|x| x * scale);
    soup.positions.iter_mut().for_each(larger);
    for s in &mut soup.spheres {
        larger(&mut s.center);
        s.radius *= scale;
    }
    for b in &mut soup.boxes {
        [&mut b.min, &mut b.max].into_iter().for_each(larger);
    }
    for c in &mut soup.cylinders {
        [&mut c.base, &mut c.top].into_iter().for_each(larger);
        c.radius *= scale;
    }
    for c in &mut soup.cones {
        [&mut c.base, &mut c.top].into_iter().for_each(larger);
        c.base_radius *= scale;
        c.top_radius *= scale;
    }
    soup
}

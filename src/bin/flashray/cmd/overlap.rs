//! End-point overlap of a hierarchy.
//!
//! Aila, Karras and Laine, "On Quality Metrics of Bounding Volume Hierarchies", HPG 2013, section 3: the share of all
//! surface that lies inside a node's box without being below that node, times what a visit of the node costs, summed
//! over all nodes. A ray that ends on a surface has to visit all boxes around its end; this is what it visits there in
//! vain. Costs are those of the SAH cost beside it: 1 for an inner node, 1 for each primitive of a leaf.
//!
//! Exactly, this would take each primitive's surface clipped to each box that it meets. It is sampled instead: points
//! evenly spread over all surface, each taken down the tree.
use crate::camera::{Vec3, add_scaled, cross, dot, sub, unit};
use crate::random::Random;
use flashray::blob::prims::Primitive;
use flashray::{Aabb, Cone, Scene};
use rayon::prelude::*;

/// Points.
pub const POINTS: usize = 65_536;

/// A node or leaf, with the primitives below it, numbered as leaves hold them, and the place after what is below it.
struct Box {
    bounds: Aabb,
    level: u32,
    cost: f64,
    prims: (usize, usize),
    after: usize,
}

/// The end-point overlap of `bvh`, `sphere` (whose spheres count as the boxes around them) and `wide`.
pub fn end_points(scene: &Scene<'_>) -> f64 {
    let (boxes, prims) = (boxes(scene), scene.primitives().map(|(_, p)| p).collect::<Vec<_>>());
    let mut sums: Vec<f64> = prims.iter().map(area).collect();
    let mut total = 0.0;
    for sum in &mut sums {
        total += *sum;
        *sum = total;
    }
    if total <= 0.0 || !total.is_finite() {
        return 0.0;
    }
    let at = |i: usize| {
        let mut random = Random::new(i as u64 + 1);
        // One point in each of as many equal parts of the surface.
        let place = (i as f64 + f64::from(random.unit())) / POINTS as f64 * total;
        let prim = sums.partition_point(|&sum| sum <= place).min(prims.len() - 1);
        in_vain(&boxes, prim, point(&prims[prim], &mut random))
    };
    (0..POINTS).into_par_iter().map(at).collect::<Vec<f64>>().iter().sum::<f64>() / POINTS as f64
}

/// Every node and leaf, a node before what is below it.
fn boxes(scene: &Scene<'_>) -> Vec<Box> {
    let (mut boxes, mut next) = (Vec::<Box>::new(), 0);
    scene.parts(|part| {
        let listed = part.listed.unwrap_or(0) as usize;
        let cost = if part.listed.is_some() { listed as f64 } else { 1.0 };
        let after = boxes.len() + 1;
        boxes.push(Box { bounds: part.bounds, level: part.level, cost, prims: (next, next + listed), after });
        next += listed;
    });
    let mut open = Vec::<usize>::new();
    for i in 0..=boxes.len() {
        while let Some(&last) = open.last().filter(|&&last| boxes.get(i).is_none_or(|b| b.level <= boxes[last].level)) {
            let end = boxes[i - 1].prims.1;
            (boxes[last].after, boxes[last].prims.1) = (i, end);
            open.pop();
        }
        open.push(i);
    }
    boxes
}

/// What is visited at a point and has nothing to do with the primitive that the point is of.
fn in_vain(boxes: &[Box], prim: usize, point: Vec3) -> f64 {
    let (mut at, mut cost) = (0, 0.0);
    while let Some(b) = boxes.get(at) {
        let own = (b.prims.0..b.prims.1).contains(&prim);
        let inside = (0..3).all(|k| b.bounds.min[k] <= point[k] && point[k] <= b.bounds.max[k]);
        at = if own || inside { at + 1 } else { b.after };
        cost += if inside && !own { b.cost } else { 0.0 };
    }
    cost
}

/// The area of a primitive's surface.
fn area(primitive: &Primitive) -> f64 {
    match primitive {
        Primitive::Triangle(t) => {
            let normal = cross(sub(t.v[1], t.v[0]), sub(t.v[2], t.v[0])).map(f64::from);
            normal.iter().map(|x| x * x).sum::<f64>().sqrt() / 2.0
        }
        Primitive::Sphere(s) => 4.0 * std::f64::consts::PI * f64::from(s.radius) * f64::from(s.radius),
        Primitive::Box(b) => faces(b).iter().sum(),
        Primitive::Cylinder(c) => bands(&c.as_cone()).iter().sum(),
        Primitive::Cone(c) => bands(c).iter().sum(),
        _ => 0.0,
    }
}

/// Both faces square to each axis.
fn faces(b: &Aabb) -> [f64; 3] {
    let [x, y, z] = sub(b.max, b.min).map(f64::from);
    [2.0 * y * z, 2.0 * z * x, 2.0 * x * y]
}

/// The side and the two discs.
fn bands(c: &Cone) -> [f64; 3] {
    let axis = sub(c.top, c.base).map(f64::from);
    let (r, s) = (f64::from(c.base_radius), f64::from(c.top_radius));
    let slant = (axis.iter().map(|x| x * x).sum::<f64>() + (r - s) * (r - s)).sqrt();
    let disc = |r: f64| if c.caps == 0 { 0.0 } else { std::f64::consts::PI * r * r };
    [std::f64::consts::PI * (r + s) * slant, disc(r), disc(s)]
}

/// A point of a primitive's surface, each as likely as any other, and in its box though it was rounded.
fn point(primitive: &Primitive, random: &mut Random) -> Vec3 {
    let at = match primitive {
        Primitive::Triangle(t) => {
            let (u, v) = (random.unit(), random.unit());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            add_scaled(add_scaled(t.v[0], u, sub(t.v[1], t.v[0])), v, sub(t.v[2], t.v[0]))
        }
        Primitive::Sphere(s) => add_scaled(s.center, s.radius, super::rays::on_sphere(random)),
        Primitive::Box(b) => {
            let axis = pick(&faces(b), random);
            let mut at = [0, 1, 2].map(|k| b.min[k] + random.unit() * (b.max[k] - b.min[k]));
            at[axis] = random.either(b.min[axis], b.max[axis]);
            at
        }
        Primitive::Cylinder(c) => point_of_cone(&c.as_cone(), random),
        Primitive::Cone(c) => point_of_cone(c, random),
        _ => [0.0; 3],
    };
    let b = primitive.bounds();
    [0, 1, 2].map(|k| at[k].max(b.min[k]).min(b.max[k]))
}

fn point_of_cone(c: &Cone, random: &mut Random) -> Vec3 {
    let (r, s) = (c.base_radius, c.top_radius);
    let (height, radius) = match pick(&bands(c), random) {
        // Of a side that narrows, places as likely as their circles are long.
        0 => {
            let radius = (r * r + random.unit() * (s * s - r * r)).sqrt();
            (if r == s { random.unit() } else { (radius - r) / (s - r) }, radius)
        }
        1 => (0.0, r * random.unit().sqrt()),
        _ => (1.0, s * random.unit().sqrt()),
    };
    let axis = sub(c.top, c.base);
    let up = unit(axis);
    let away = loop {
        let any = super::rays::on_sphere(random);
        let away = add_scaled(any, -dot(any, up), up);
        if dot(away, away) > 1e-3 {
            break unit(away);
        }
    };
    add_scaled(add_scaled(c.base, height, axis), radius, away)
}

/// One of three, as likely as its weight says.
fn pick(weights: &[f64; 3], random: &mut Random) -> usize {
    let place = f64::from(random.unit()) * weights.iter().sum::<f64>();
    usize::from(place >= weights[0]) + usize::from(place >= weights[0] + weights[1])
}

//! A plain `f64` ray caster, independent of the library: the measure of the hit counts.
use super::super::frame::{Vec3, add, cross, dot, scale, sub};
use super::super::{Sink, Soup};

/// A primitive in `f64`.
#[derive(Clone, Copy)]
pub enum Shape {
    Triangle([Vec3; 3]),
    Sphere(Vec3, f64),
    /// Base, top, radius at each: cylinders as well as cones, both open.
    Cone(Vec3, Vec3, [f64; 2]),
}

/// An unrounded scene.
#[derive(Default)]
pub struct Exact {
    pub corners: Vec<Vec3>,
    pub shapes: Vec<Shape>,
}

impl Sink for Exact {
    fn corner(&mut self, point: Vec3) -> u32 {
        self.corners.push(point);
        u32::try_from(self.corners.len() - 1).unwrap()
    }
    fn triangle(&mut self, corners: [u32; 3]) {
        self.shapes.push(Shape::Triangle(corners.map(|i| self.corners[i as usize])));
    }
    fn sphere(&mut self, center: Vec3, radius: f64) {
        self.shapes.push(Shape::Sphere(center, radius));
    }
    fn cylinder(&mut self, base: Vec3, top: Vec3, radius: f64) {
        self.cone(base, top, [radius, radius]);
    }
    fn cone(&mut self, base: Vec3, top: Vec3, radii: [f64; 2]) {
        self.shapes.push(Shape::Cone(base, top, radii));
    }
}

/// A rounded scene as one in `f64`.
pub fn widen(soup: &Soup) -> Exact {
    let wide = |point: [f32; 3]| point.map(f64::from);
    let mut out = Exact::default();
    for &point in &soup.positions {
        out.corner(wide(point));
    }
    for &corners in &soup.triangles {
        out.triangle(corners);
    }
    for s in &soup.spheres {
        out.sphere(wide(s.center), s.radius.into());
    }
    for c in &soup.cylinders {
        out.cylinder(wide(c.base), wide(c.top), c.radius.into());
    }
    for c in &soup.cones {
        out.cone(wide(c.base), wide(c.top), [c.base_radius.into(), c.top_radius.into()]);
    }
    out
}

type Bounds = [Vec3; 2];

fn join(a: Bounds, b: Bounds) -> Bounds {
    let axes = [0, 1, 2];
    [axes.map(|k| a[0][k].min(b[0][k])), axes.map(|k| a[1][k].max(b[1][k]))]
}

impl Shape {
    pub fn bounds(&self) -> Bounds {
        let ball = |c: Vec3, r: f64| [c.map(|x| x - r), c.map(|x| x + r)];
        match *self {
            Self::Triangle([a, b, c]) => join(join([a, a], [b, b]), [c, c]),
            Self::Sphere(center, radius) => ball(center, radius),
            Self::Cone(base, top, [r, s]) => {
                // A disc reaches r sin(angle to its normal) along an axis.
                let axis = sub(top, base);
                let reach = axis.map(|x| (1.0 - x * x / dot(axis, axis)).max(0.0).sqrt());
                let disc = |c: Vec3, r: f64| [sub(c, scale(r, reach)), add(c, scale(r, reach))];
                join(disc(base, r), disc(top, s))
            }
        }
    }

    /// The least positive distance, in lengths of `along`.
    fn hit(&self, from: Vec3, along: Vec3) -> Option<f64> {
        match *self {
            Self::Triangle(corners) => triangle(corners, from, along),
            Self::Sphere(center, radius) => {
                let off = sub(from, center);
                let roots = roots(dot(along, along), dot(off, along), dot(off, off) - radius * radius)?;
                roots.into_iter().find(|&t| t > 0.0)
            }
            Self::Cone(base, top, radii) => cone([base, top], radii, from, along),
        }
    }
}

/// The two roots of `a t^2 + 2 b t + c`, the smaller first.
fn roots(a: f64, b: f64, c: f64) -> Option<[f64; 2]> {
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return None;
    }
    let q = -(b + discriminant.sqrt().copysign(b));
    let (t, u) = (q / a, c / q);
    Some([t.min(u), t.max(u)])
}

/// Either side counts, and so do the edges.
fn triangle([a, b, c]: [Vec3; 3], from: Vec3, along: Vec3) -> Option<f64> {
    let (ab, ac) = (sub(b, a), sub(c, a));
    let p = cross(along, ac);
    let determinant = dot(ab, p);
    let off = sub(from, a);
    let q = cross(off, ab);
    let (u, v) = (dot(off, p) / determinant, dot(along, q) / determinant);
    let t = dot(ac, q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
}

/// The lateral surface between the two circles.
fn cone([base, top]: Bounds, [r, s]: [f64; 2], from: Vec3, along: Vec3) -> Option<f64> {
    let axis = sub(top, base);
    let length = dot(axis, axis).sqrt();
    let axis = scale(1.0 / length, axis);
    let taper = (s - r) / length;
    let off = sub(from, base);
    // Height above the base and allowed radius, both linear in t.
    let (h0, h1) = (dot(off, axis), dot(along, axis));
    let (r0, r1) = (r + taper * h0, taper * h1);
    let roots = roots(
        dot(along, along) - h1 * h1 - r1 * r1,
        dot(off, along) - h0 * h1 - r0 * r1,
        dot(off, off) - h0 * h0 - r0 * r0,
    )?;
    roots.into_iter().find(|&t| t > 0.0 && (0.0..=length).contains(&(h0 + t * h1)))
}

/// A binary tree of boxes; the shapes are sorted so that each leaf is a range of them.
enum Tree<'a> {
    Leaf(Bounds, &'a [Shape]),
    Inner(Bounds, Box<[Tree<'a>; 2]>),
}

fn tree(shapes: &mut [Shape]) -> Tree<'_> {
    let bounds = shapes.iter().map(Shape::bounds).reduce(join).unwrap();
    if shapes.len() <= 4 {
        return Tree::Leaf(bounds, shapes);
    }
    let extent = sub(bounds[1], bounds[0]);
    let axis = (0..3).max_by(|&i, &j| extent[i].total_cmp(&extent[j])).unwrap();
    let middle = |shape: &Shape| shape.bounds().iter().map(|p| p[axis]).sum::<f64>();
    let half = shapes.len() / 2;
    shapes.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)));
    let (low, high) = shapes.split_at_mut(half);
    Tree::Inner(bounds, Box::new([tree(low), tree(high)]))
}

impl Tree<'_> {
    fn nearest(&self, from: Vec3, along: Vec3, mut best: f64) -> f64 {
        let (Self::Leaf(bounds, _) | Self::Inner(bounds, _)) = self;
        if !crosses(bounds, from, along, best) {
            return best;
        }
        match self {
            Self::Leaf(_, shapes) => shapes.iter().filter_map(|s| s.hit(from, along)).fold(best, f64::min),
            Self::Inner(_, children) => {
                for child in children.iter() {
                    best = child.nearest(from, along, best);
                }
                best
            }
        }
    }
}

/// Whether a ray meets a box, grown by far more than rounding can move it, before `best`.
fn crosses(bounds: &Bounds, from: Vec3, along: Vec3, best: f64) -> bool {
    const MARGIN: f64 = 1e-6;
    let (mut near, mut far) = (0.0_f64, best);
    for k in 0..3 {
        let at = |side: f64| (side - from[k]) / along[k];
        let (a, b) = (at(bounds[0][k] - MARGIN), at(bounds[1][k] + MARGIN));
        near = near.max(a.min(b));
        far = far.min(a.max(b));
    }
    near <= far
}

/// How many rays hit, and at what mean distance.
pub fn look(scene: &mut Exact, rays: impl Iterator<Item = (Vec3, Vec3)>) -> (u32, f64) {
    let tree = tree(&mut scene.shapes);
    let (mut hits, mut sum) = (0, 0.0);
    for (from, along) in rays {
        let t = tree.nearest(from, along, f64::INFINITY);
        if t < f64::INFINITY {
            hits += 1;
            sum += t;
        }
    }
    (hits, sum / f64::from(hits))
}

/// The box around a scene.
pub fn bounds(scene: &Exact) -> Bounds {
    scene.shapes.iter().map(Shape::bounds).reduce(join).unwrap()
}

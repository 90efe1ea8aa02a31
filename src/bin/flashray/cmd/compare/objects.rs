//! What the plane cuts of the primitives.
use super::slice::{Plane, Point, Rect, Window};
use flashray::blob::prims::Primitive;
use flashray::{Cone, Scene};
use std::f64::consts::TAU;
use std::fmt::Write as _;

/// Colours that objects take in turn.
pub const COLORS: usize = 8;
/// Most pieces drawn: beyond it the longest are.
const MOST: usize = 5000;
/// Flat faces that stand for a round side.
const FACES: u32 = 40;

/// A primitive's part in the plane.
enum Piece {
    Line(Point, Point),
    Circle(Point, f64),
    Rect(Rect),
}

/// All of them, with the caller's numbers.
pub struct Objects {
    pieces: Vec<(u32, Piece)>,
    pub left_out: usize,
}

impl Objects {
    /// What the plane cuts of a scene.
    pub fn new(scene: &Scene<'_>, plane: &Plane) -> Self {
        let mut pieces = Vec::new();
        for (id, primitive) in scene.primitives() {
            let mut put = |piece| pieces.push((id, piece));
            match primitive {
                Primitive::Triangle(t) => triangle(plane, t.v, &mut put),
                Primitive::Sphere(s) => {
                    let away = f64::from(s.center[plane.axis]) - f64::from(plane.at);
                    let square = f64::from(s.radius).powi(2) - away * away;
                    if square > 0.0 {
                        put(Piece::Circle(plane.flat(s.center), square.sqrt()));
                    }
                }
                Primitive::Box(b) => {
                    if let Some(rect) = plane.cut(&b) {
                        put(Piece::Rect(rect));
                    }
                }
                Primitive::Cylinder(c) => cone(plane, &c.as_cone(), &mut put),
                Primitive::Cone(c) => cone(plane, &c, &mut put),
                _ => {}
            }
        }
        pieces.sort_by(|a, b| b.1.size().total_cmp(&a.1.size()));
        let left_out = pieces.len().saturating_sub(MOST);
        pieces.truncate(MOST);
        Self { pieces, left_out }
    }

    /// Paths, one for each colour that occurs.
    pub fn paths(&self, window: &Window) -> Vec<(usize, String)> {
        let mut paths = vec![String::new(); COLORS];
        for (id, piece) in &self.pieces {
            // Neighbours get colours that are not.
            let color = (id.wrapping_mul(0x9e37_79b9) >> 29) as usize % COLORS;
            piece.draw(window, &mut paths[color]);
        }
        paths.into_iter().enumerate().filter(|(_, path)| !path.is_empty()).collect()
    }
}

impl Piece {
    fn size(&self) -> f64 {
        match self {
            Self::Line(a, b) => (a[0] - b[0]).hypot(a[1] - b[1]),
            Self::Circle(_, radius) => radius * 2.0,
            Self::Rect(r) => (r.max[0] - r.min[0]).hypot(r.max[1] - r.min[1]),
        }
    }

    fn draw(&self, window: &Window, path: &mut String) {
        // Writing to a string does not fail.
        let _ = match self {
            Self::Line(a, b) => {
                let ([x, y], [u, v]) = (window.place(*a), window.place(*b));
                write!(path, "M{x} {y}l{} {}", u - x, v - y)
            }
            Self::Circle(middle, radius) => {
                let ([x, y], r) = (window.place(*middle), window.length(*radius).max(1));
                write!(path, "M{} {y}a{r} {r} 0 1 0 {} 0a{r} {r} 0 1 0 {} 0z", x - r, 2 * r, -2 * r)
            }
            Self::Rect(rect) => {
                let [left, top, right, bottom] = window.corners(rect);
                write!(path, "M{left} {top}H{right}V{bottom}H{left}z")
            }
        };
    }
}

/// The segment in which the plane cuts a triangle. One with an edge in the plane counts if it lies below.
fn triangle(plane: &Plane, v: [[f32; 3]; 3], put: &mut impl FnMut(Piece)) {
    let above = v.map(|p| p[plane.axis] >= plane.at);
    let mut ends = [0, 1, 2].into_iter().filter(|&i| above[i] != above[(i + 1) % 3]).map(|i| {
        let (a, b) = (v[i], v[(i + 1) % 3]);
        let height = |p: [f32; 3]| f64::from(p[plane.axis]);
        let share = (f64::from(plane.at) - height(a)) / (height(b) - height(a));
        let (a, b) = (plane.flat(a), plane.flat(b));
        [0, 1].map(|k| a[k] + share * (b[k] - a[k]))
    });
    if let (Some(a), Some(b)) = (ends.next(), ends.next()) {
        put(Piece::Line(a, b));
    }
}

/// A cone as flat faces, each cut as a triangle is.
fn cone(plane: &Plane, c: &Cone, put: &mut impl FnMut(Piece)) {
    let wide = |p: [f32; 3]| p.map(f64::from);
    let (base, top) = (wide(c.base), wide(c.top));
    let axis = [0, 1, 2].map(|k| top[k] - base[k]);
    let length = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
    let radii = [f64::from(c.base_radius), f64::from(c.top_radius)];
    let reach = length + radii[0].max(radii[1]);
    if length <= 0.0 || (f64::from(plane.at) - base[plane.axis]).abs() > reach {
        return;
    }
    // Two directions square to the axis and to each other.
    let least = (0..3).min_by(|&i, &j| axis[i].abs().total_cmp(&axis[j].abs())).unwrap_or(0);
    let cross =
        |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let unit = |a: [f64; 3]| {
        let length = a.iter().map(|x| x * x).sum::<f64>().sqrt();
        a.map(|x| x / length)
    };
    let mut other = [0.0; 3];
    other[least] = 1.0;
    let first = unit(cross(axis, other));
    let second = unit(cross(axis, first));
    let point = |middle: [f64; 3], radius: f64, i: u32| {
        let (sine, cosine) = (TAU * f64::from(i % FACES) / f64::from(FACES)).sin_cos();
        [0, 1, 2].map(|k| (middle[k] + radius * (cosine * first[k] + sine * second[k])) as f32)
    };
    for i in 0..FACES {
        let low = [point(base, radii[0], i), point(base, radii[0], i + 1)];
        let high = [point(top, radii[1], i), point(top, radii[1], i + 1)];
        triangle(plane, [low[0], low[1], high[0]], put);
        triangle(plane, [high[0], low[1], high[1]], put);
        if c.caps != 0 {
            triangle(plane, [c.base, low[0], low[1]], put);
            triangle(plane, [c.top, high[0], high[1]], put);
        }
    }
}

//! The reference for answers that differ from the judge's: all triangles, in f64.
use crate::peer::{Ray, Tri};

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Where the ray meets the triangle (Moeller and Trumbore), edges included.
fn meet(r: &Ray, t: &Tri) -> Option<f64> {
    let (o, d) = (r.o.map(f64::from), r.d.map(f64::from));
    let [a, b, c] = t.map(|v| v.map(f64::from));
    let (e1, e2) = (sub(b, a), sub(c, a));
    let p = cross(d, e2);
    let det = dot(e1, p);
    if det == 0.0 {
        return None;
    }
    let s = sub(o, a);
    let q = cross(s, e1);
    let (u, v) = (dot(s, p) / det, dot(d, q) / det);
    let t = dot(e2, q) / det;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0 && t <= f64::from(r.tmax)).then_some(t)
}

/// The distance to the closest hit; infinite if there is none.
pub fn closest(tris: &[Tri], r: &Ray) -> f64 {
    tris.iter().filter_map(|t| meet(r, t)).fold(f64::INFINITY, f64::min)
}

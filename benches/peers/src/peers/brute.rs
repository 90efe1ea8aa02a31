//! The plain triangle test that candidate-iterator peers use, and the naive all-triangles loop.
use crate::clock;
use crate::peer::*;

/// Two-sided Moeller-Trumbore; keeps the nearer hit in `best` (0 <= t < best.t).
#[inline(always)]
pub fn tri(r: &Ray, t: &Tri, id: u32, best: &mut Hit) {
    let sub = |a: [f32; 3], b: [f32; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let cross =
        |a: [f32; 3], b: [f32; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let (e1, e2) = (sub(t[1], t[0]), sub(t[2], t[0]));
    let p = cross(r.d, e2);
    let det = dot(e1, p);
    if det == 0.0 {
        return;
    }
    let inv = 1.0 / det;
    let s = sub(r.o, t[0]);
    let u = dot(s, p) * inv;
    if !(0.0..=1.0).contains(&u) {
        return;
    }
    let q = cross(s, e1);
    let v = dot(r.d, q) * inv;
    if v < 0.0 || u + v > 1.0 {
        return;
    }
    let d = dot(e2, q) * inv;
    if d >= 0.0 && d < best.t {
        *best = Hit { t: d, prim: id };
    }
}

/// Rays per second of the naive loop over all triangles: (array of triangles with early outs, branch-free
/// structure-of-arrays loop that the compiler vectorizes).
pub fn rates(tris: &[Tri], rays: &[Ray]) -> (f64, f64) {
    let mut sum = 0.0f64;
    let t0 = clock::thread();
    for r in rays {
        let mut best = Hit { t: r.tmax, prim: u32::MAX };
        for (i, t) in tris.iter().enumerate() {
            tri(r, t, i as u32, &mut best);
        }
        sum += best.t.min(1e9) as f64;
    }
    let a = clock::thread() - t0;

    let n = tris.len();
    let col = |v: usize, k: usize| -> Vec<f32> {
        tris.iter().map(|t| if v == 0 { t[0][k] } else { t[v][k] - t[0][k] }).collect()
    };
    let c: Vec<Vec<f32>> = (0..9).map(|i| col(i / 3, i % 3)).collect();
    let c: [&[f32]; 9] = std::array::from_fn(|i| &c[i][..n]);
    let t0 = clock::thread();
    for r in rays {
        const L: usize = 16;
        let mut best = [r.tmax; L];
        let (d, o) = (r.d, r.o);
        for base in (0..n / L * L).step_by(L) {
            let g = |i: usize| -> [f32; L] { c[i][base..base + L].try_into().unwrap() };
            let (v, e1, e2) = ([g(0), g(1), g(2)], [g(3), g(4), g(5)], [g(6), g(7), g(8)]);
            for l in 0..L {
                let px = d[1] * e2[2][l] - d[2] * e2[1][l];
                let py = d[2] * e2[0][l] - d[0] * e2[2][l];
                let pz = d[0] * e2[1][l] - d[1] * e2[0][l];
                let inv = 1.0 / (e1[0][l] * px + e1[1][l] * py + e1[2][l] * pz);
                let (sx, sy, sz) = (o[0] - v[0][l], o[1] - v[1][l], o[2] - v[2][l]);
                let u = (sx * px + sy * py + sz * pz) * inv;
                let qx = sy * e1[2][l] - sz * e1[1][l];
                let qy = sz * e1[0][l] - sx * e1[2][l];
                let qz = sx * e1[1][l] - sy * e1[0][l];
                let w = (d[0] * qx + d[1] * qy + d[2] * qz) * inv;
                let t = (e2[0][l] * qx + e2[1][l] * qy + e2[2][l] * qz) * inv;
                let ok = (u >= 0.0) & (w >= 0.0) & (u + w <= 1.0) & (t >= 0.0) & (t < best[l]);
                best[l] = if ok { t } else { best[l] };
            }
        }
        let mut m = best.iter().fold(f32::INFINITY, |a, &b| a.min(b));
        let mut h = Hit { t: m, prim: u32::MAX };
        for i in n / L * L..n {
            tri(r, &tris[i], i as u32, &mut h);
        }
        m = m.min(h.t);
        sum -= m.min(1e9) as f64;
    }
    let b = clock::thread() - t0;
    if sum.abs() > 1e-2 * rays.len() as f64 {
        eprintln!("note: the two naive loops differ by {sum}");
    }
    (rays.len() as f64 / a, rays.len() as f64 / b)
}

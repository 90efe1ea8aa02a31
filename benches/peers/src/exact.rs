//! The reference for answers that differ from the judge's: all triangles, in f64, and how far f64 can be trusted.
//!
//! The corners and the ray are f32, so f64 is off by `2^-52` of them, not `2^-24`. A weight that is farther from 0 than its
//! own rounding can be has the right sign. What is nearer decides nothing: an answer that turns on it is undecided, and
//! counted as that.
use crate::peer::{Ray, Tri};

/// Half an ulp of 1.
const U: f64 = f64::EPSILON / 2.0;
/// Roundings along the longest way to a weight: a difference each for two corners (1 + 1), a product, the difference of
/// two, the product with the direction, two sums (5); doubled.
const WEIGHT: f64 = 14.0 * U;

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `d . (a x b)`, six times the signed volume of the direction and an edge as seen from the origin, and what it may be
/// wrong by.
fn weight(d: [f64; 3], a: [f64; 3], b: [f64; 3]) -> (f64, f64) {
    let part = |i: usize, j: usize| (a[i] * b[j] - a[j] * b[i], (a[i] * b[j]).abs() + (a[j] * b[i]).abs());
    let (x, y, z) = (part(1, 2), part(2, 0), part(0, 1));
    (dot(d, [x.0, y.0, z.0]), WEIGHT * dot(d.map(f64::abs), [x.1, y.1, z.1]))
}

/// What is known of a ray and a triangle, edges included.
enum Meet {
    No,
    /// At this distance, about, if at all.
    Perhaps(f64),
    Yes(f64),
}

fn meet(r: &Ray, t: &Tri) -> Meet {
    let (o, d) = (r.o.map(f64::from), r.d.map(f64::from));
    let [a, b, c] = t.map(|v| sub(v.map(f64::from), o));
    let weights = [weight(d, b, c), weight(d, c, a), weight(d, a, b)];
    let all = |s: f64| weights.iter().all(|&(w, off)| s * w >= off && w != 0.0);
    let may = |s: f64| weights.iter().all(|&(w, off)| s * w >= -off);
    if !may(1.0) && !may(-1.0) {
        return Meet::No;
    }
    // The distance is that of the point with these weights, along the axis on which the ray is steepest.
    let k = (0..3).max_by(|&i, &j| d[i].abs().total_cmp(&d[j].abs())).unwrap_or(0);
    let sum: f64 = weights.iter().map(|w| w.0).sum();
    let parts = [weights[0].0 * a[k], weights[1].0 * b[k], weights[2].0 * c[k]];
    let t = parts.iter().sum::<f64>() / sum / d[k];
    // Seen edge-on, or nearly so: where it is met can not be told either.
    let off_sum: f64 = weights.iter().map(|w| w.1).sum();
    let reach = [a, b, c].iter().fold(0.0_f64, |most, v| most.max(v[k].abs())) / d[k].abs();
    let off = 2.0 * reach * (off_sum / sum.abs() + 4.0 * U);
    if !(off <= 1e-6 * reach) {
        return Meet::Perhaps(if t.is_finite() { t.max(0.0) } else { 0.0 });
    }
    let tmax = f64::from(r.tmax);
    if t < -off || t > tmax + off {
        return Meet::No;
    }
    if (all(1.0) || all(-1.0)) && t >= off && t <= tmax - off { Meet::Yes(t) } else { Meet::Perhaps(t) }
}

/// How an answer stands to all triangles.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Verdict {
    Right,
    Undecided,
    Wrong,
}

/// Judges a distance, infinite for a miss, or with `any` whether there is one. `tol` is what the distance may differ by.
///
/// A closest hit is right if it is at a triangle that is surely met, and none nearer is even perhaps.
pub fn judge(tris: &[Tri], r: &Ray, t: f64, any: bool, tol: f64) -> Verdict {
    let (mut sure, mut perhaps) = (f64::INFINITY, vec![]);
    for tri in tris {
        match meet(r, tri) {
            Meet::No => {}
            Meet::Perhaps(t) => perhaps.push(t),
            Meet::Yes(t) => sure = sure.min(t),
        }
    }
    let same = |at: f64| t.is_finite() == at.is_finite() && (any || !t.is_finite() || (t - at).abs() <= tol);
    perhaps.retain(|&t| t < sure && !(any && sure.is_finite()));
    match (same(sure), perhaps.is_empty()) {
        (true, true) => Verdict::Right,
        (false, true) => Verdict::Wrong,
        (true, false) => Verdict::Undecided,
        (false, false) if perhaps.iter().any(|&t| same(t)) => Verdict::Undecided,
        (false, false) => Verdict::Wrong,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRI: Tri = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];

    fn ask(x: f32, y: f32, t: f64) -> Verdict {
        let ray = Ray { o: [x, y, 0.0], tmax: f32::INFINITY, d: [0.0, 0.0, 1.0], pad: 0 };
        judge(&[TRI], &ray, t, false, 1e-3)
    }

    #[test]
    fn what_f64_can_tell_is_told() {
        let step = f32::MIN_POSITIVE;
        for (x, hit) in [(step, true), (-step, false), (0.25, true), (-0.25, false)] {
            let (right, wrong) = if hit { (1.0, f64::INFINITY) } else { (f64::INFINITY, 1.0) };
            assert_eq!(ask(x, 0.5, right), Verdict::Right);
            assert_eq!(ask(x, 0.5, wrong), Verdict::Wrong);
        }
        assert_eq!(ask(0.25, 0.25, 1.1), Verdict::Wrong);
    }

    #[test]
    fn on_an_edge_both_answers_may_be() {
        for t in [1.0, f64::INFINITY] {
            assert_eq!(ask(0.0, 0.5, t), Verdict::Undecided);
        }
        assert_eq!(ask(0.0, 0.5, 0.5), Verdict::Wrong);
    }
}

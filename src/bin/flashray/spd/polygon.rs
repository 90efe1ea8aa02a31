//! Triangles of a gear's face, which is not convex.
//!
//! The face is cut along the circle that carries the roots of the teeth: every tooth is a convex
//! trapezoid, and what remains is a convex polygon inscribed in that circle. All triangles keep the
//! direction of the outline, and share its corners, so there are neither overlaps nor gaps.

/// Triangles of an outline with four corners per tooth: two at the tip, then two on the root circle.
///
/// The corners are numbered along the outline from 0, and n of them give n - 2 triangles.
pub fn gear_face(teeth: u32) -> Vec<[u32; 3]> {
    let count = 4 * teeth;
    let mut triangles = Vec::new();
    let mut hub = Vec::new();
    for first in (0..count).step_by(4) {
        let before = (first + count - 1) % count;
        triangles.push([before, first, first + 1]);
        triangles.push([before, first + 1, first + 2]);
        hub.extend([first + 2, first + 3]);
    }
    halve(&hub, &mut triangles);
    triangles
}

/// Triangles of a convex polygon by repeated halving, which gives fewer slivers than a fan.
fn halve(ring: &[u32], triangles: &mut Vec<[u32; 3]>) {
    let &[first, .., last] = ring else { return };
    let middle = ring.len() / 2;
    if ring.len() > 2 {
        triangles.push([first, ring[middle], last]);
        halve(&ring[..=middle], triangles);
        halve(&ring[middle..], triangles);
    }
}

//! `tree`: a binary tree of cones with balls at the joints. After Haines, SPD (CC0).
use super::frame::{Mat3, ORIGIN, Vec3, X, Z, about, add, compose, scale, turn};
use super::sink::floor;
use super::{Anchor, Recipe, Sink, View};

pub const RECIPE: Recipe = Recipe {
    name: "tree",
    default: 11,
    sizes: [0, 22],
    build,
    setting,
    anchor: Anchor { hits_ours: 169_911, hits_published: Some(169_907), mean_t: 10.052_031_512 },
};

fn setting(_: u32) -> (View, Vec<Vec3>) {
    let lights = vec![
        [-5.0, 5.0, 50.0],
        [30.0, -30.0, 30.0],
        [-40.0, -30.0, 20.0],
        [10.0, 30.0, 40.0],
        [-30.0, 40.0, 10.0],
        [50.0, 25.0, 20.0],
        [-10.0, -60.0, 30.0],
    ];
    (View::new([4.5, 0.4, 2.0], [0.0, 0.0, 1.5], Z), lights)
}

fn build(size: u32, out: &mut dyn Sink) {
    floor(out, 50.0, 0.0);
    // Tilt, turn and length of a twig against its branch.
    let twigs = [(40.0_f64, 90.0_f64, 0.65), (25.0, 230.0, 0.70)].map(|(tilt, turn, length)| {
        let placed = compose(&about(Z, turn.to_radians()), &about(X, tilt.to_radians()));
        placed.map(|row| scale(length, row))
    });
    branch(out, &twigs, size, Branch { foot: ORIGIN, frame: about(Z, 0.0), girth: 1.0 });
}

#[derive(Clone, Copy)]
struct Branch {
    foot: Vec3,
    /// Directions and length: the branch runs along the image of +Z.
    frame: Mat3,
    /// The radius against the trunk's; thins at another rate than the length.
    girth: f64,
}

fn branch(out: &mut dyn Sink, twigs: &[Mat3; 2], depth: u32, Branch { foot, frame, girth }: Branch) {
    let tip = add(foot, turn(&frame, Z));
    let [thick, thin] = [0.15 * girth, 0.1005 * girth];
    out.cone(foot, tip, [thick, thin]);
    out.sphere(tip, thin);
    if depth == 0 {
        return;
    }
    for twig in twigs {
        let next = Branch { foot: tip, frame: compose(&frame, twig), girth: 0.67 * girth };
        branch(out, twigs, depth - 1, next);
    }
}

//! A plane square to an axis, what of a structure it cuts, and where that is on paper.
use flashray::{Aabb, Kind, Scene};

/// A point in the plane, in scene units.
pub type Point = [f64; 2];

/// A box's part in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    pub min: Point,
    pub max: Point,
}

impl Rect {
    /// The least rectangle around two.
    pub fn join(&self, other: &Self) -> Self {
        let least = |k: usize| self.min[k].min(other.min[k]);
        let most = |k: usize| self.max[k].max(other.max[k]);
        Self { min: [least(0), least(1)], max: [most(0), most(1)] }
    }

    /// The same, with `air` more on every side.
    fn grown(&self, air: f64) -> Self {
        Self { min: self.min.map(|x| x - air), max: self.max.map(|x| x + air) }
    }

    /// The same, with so much at least that it does not round away: no side is then without length.
    fn visible(&self, air: f64) -> Self {
        let far = [self.min, self.max].as_flattened().iter().fold(0.0, |far: f64, x| far.max(x.abs()));
        self.grown(air.max(far * 1e-9).max(1e-300))
    }

    /// The longer side.
    pub fn size(&self) -> f64 {
        (self.max[0] - self.min[0]).max(self.max[1] - self.min[1])
    }
}

/// A plane square to an axis.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    pub axis: usize,
    /// Its coordinate on that axis.
    pub at: f32,
    /// The axes to the right and upwards on paper.
    pub across: [usize; 2],
    /// The scene's last coordinate on the axis: a plane there cuts what ends there.
    last: f32,
    /// The scene's box in the plane.
    pub bounds: Rect,
}

impl Plane {
    /// The plane that has `share` of the scene below it.
    pub fn new(axis: usize, share: f32, bounds: &Aabb) -> Self {
        let across = [[1, 2], [0, 2], [0, 1]][axis % 3];
        let (min, max) = (bounds.min[axis], bounds.max[axis]);
        let at = (min * (1.0 - share) + max * share).clamp(min, max);
        Self { axis, at, across, last: max, bounds: rect(bounds, across) }
    }

    /// How far from the scene's box the ray begins and ends.
    pub fn air(&self) -> f64 {
        self.bounds.size().max(f64::MIN_POSITIVE) * 0.035
    }

    /// The name of an axis.
    pub const fn name(axis: usize) -> &'static str {
        ["x", "y", "z"][axis % 3]
    }

    /// The box's part in the plane. Of two boxes that share a face there, the one above it is cut.
    pub fn cut(&self, b: &Aabb) -> Option<Rect> {
        let (min, max) = (b.min[self.axis], b.max[self.axis]);
        let cut = min <= self.at && (self.at < max || (self.at <= max && (min == max || self.at >= self.last)));
        cut.then(|| rect(b, self.across))
    }

    /// What the plane cuts of a node's or cell's box, or of the sphere in it.
    pub fn cut_part(&self, b: &Aabb, round: bool) -> Option<Rect> {
        if !round {
            return self.cut(b);
        }
        let half = |k: usize| (f64::from(b.max[k]) - f64::from(b.min[k])) / 2.0;
        let middle = |k: usize| f64::midpoint(f64::from(b.min[k]), f64::from(b.max[k]));
        let (radius, away) = (half(self.axis), middle(self.axis) - f64::from(self.at));
        let square = radius * radius - away * away;
        let point = self.across.map(middle);
        (square >= 0.0).then(|| Rect { min: point, max: point }.grown(square.sqrt()))
    }

    /// A point of space, seen along the axis.
    pub fn flat(&self, p: [f32; 3]) -> Point {
        self.across.map(|k| f64::from(p[k]))
    }

    /// A point of the plane in space.
    pub fn deep(&self, p: Point) -> [f32; 3] {
        let mut all = [self.at; 3];
        for (k, x) in self.across.into_iter().zip(p) {
            all[k] = x as f32;
        }
        all
    }
}

fn rect(b: &Aabb, across: [usize; 2]) -> Rect {
    let corner = |p: [f32; 3]| across.map(|k| f64::from(p[k]));
    Rect { min: corner(b.min), max: corner(b.max) }
}

/// Whether a structure's nodes are spheres. They are told by the boxes around them.
pub fn round(scene: &Scene<'_>) -> bool {
    scene.kind() == Kind::Sphere
}

/// A node or cell that the plane cuts.
pub struct Cell {
    pub rect: Rect,
    pub level: u32,
    /// Primitives listed; none for an inner node.
    pub listed: Option<u32>,
}

/// What the plane cuts of a structure, the largest `most` of it, and how many are left out.
pub fn cells(scene: &Scene<'_>, plane: &Plane, most: usize) -> (Vec<Cell>, usize) {
    let mut cells = Vec::new();
    scene.parts(|part| {
        // Sparse voxels keep nothing of what is empty.
        let kept = scene.kind() != Kind::Voxel || part.listed != Some(0);
        // The root of a tree of spheres is the scene's box.
        let round = round(scene) && part.level > 0;
        if let Some(rect) = plane.cut_part(&part.bounds, round).filter(|_| kept) {
            cells.push(Cell { rect, level: part.level, listed: part.listed });
        }
    });
    let (empty, mut cells): (Vec<_>, Vec<_>) = cells.into_iter().partition(|cell| cell.listed == Some(0));
    cells.sort_by(|a, b| b.rect.size().total_cmp(&a.rect.size()));
    let left_out = cells.len().saturating_sub(most);
    cells.truncate(most);
    // Empty cells have no fill, and their outlines melt into few lines: they cost little.
    cells.extend(empty);
    (cells, left_out)
}

/// Paper: tenths of a pixel, `y` downwards.
pub struct Window {
    rect: Rect,
    scale: f64,
    pub width: i32,
    pub height: i32,
}

/// Paper around the drawing.
pub const MARGIN: i32 = 150;
/// Paper above it, for the heading.
pub const TOP: i32 = 790;
/// Paper below it, for the legend.
pub const BOTTOM: i32 = 680;
const WIDEST: f64 = 7300.0;
const HIGHEST: f64 = 7300.0;

impl Window {
    /// Paper for the scene's box and the structure's cells, just as large as they.
    pub fn new(cells: &[Cell], plane: &Plane) -> Self {
        let all = cells.iter().fold(plane.bounds, |all, cell| all.join(&cell.rect));
        let all = all.visible(all.size() * 0.01);
        // The ray begins and ends beside the scene's box.
        let rect = all.join(&plane.bounds.visible(plane.air() * 1.3));
        let sides = [0, 1].map(|k| rect.max[k] - rect.min[k]);
        let scale = (WIDEST / sides[0]).min(HIGHEST / sides[1]);
        let height = (sides[1] * scale).min(HIGHEST) as i32;
        Self { rect, scale, width: WIDEST as i32 + 2 * MARGIN, height: height + TOP + BOTTOM }
    }

    /// A point on paper, in the middle of its width.
    pub fn place(&self, p: Point) -> [i32; 2] {
        let used = (self.rect.max[0] - self.rect.min[0]) * self.scale;
        let left = f64::from(MARGIN) + (WIDEST - used) / 2.0;
        let x = left + (p[0] - self.rect.min[0]) * self.scale;
        let y = f64::from(TOP) + (self.rect.max[1] - p[1]) * self.scale;
        [x, y].map(|x| x.round().clamp(-1e6, 1e6) as i32)
    }

    /// A length on paper.
    pub fn length(&self, x: f64) -> i32 {
        (x * self.scale).round().clamp(0.0, 1e6) as i32
    }

    /// Where the drawing ends and the legend begins.
    pub const fn bottom(&self) -> i32 {
        self.height - BOTTOM
    }

    /// The rectangle on paper: left, top, right, bottom.
    pub fn corners(&self, rect: &Rect) -> [i32; 4] {
        let ([left, bottom], [right, top]) = (self.place(rect.min), self.place(rect.max));
        [left, top, right, bottom]
    }
}

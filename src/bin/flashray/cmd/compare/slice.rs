//! A plane square to an axis, what of a structure it cuts, and where that is on paper.
use flashray::{Aabb, Scene};

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

    /// Whether `other` lies inside and is smaller.
    pub fn holds(&self, other: &Self) -> bool {
        let inside = |k: usize| self.min[k] <= other.min[k] && other.max[k] <= self.max[k];
        inside(0) && inside(1) && self != other
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
        if let Some(rect) = plane.cut(&part.bounds) {
            cells.push(Cell { rect, level: part.level, listed: part.listed });
        }
    });
    let (empty, mut cells): (Vec<_>, Vec<_>) = cells.into_iter().partition(|cell| cell.listed == Some(0));
    let size = |cell: &Cell| (cell.rect.max[0] - cell.rect.min[0]).max(cell.rect.max[1] - cell.rect.min[1]);
    cells.sort_by(|a, b| size(b).total_cmp(&size(a)));
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
pub const MARGIN: i32 = 200;
/// Paper above it, for the heading.
pub const TOP: i32 = 600;
/// Paper below it, for the legend.
pub const BOTTOM: i32 = 620;
const WIDEST: f64 = 7200.0;
const HIGHEST: f64 = 5400.0;

/// Paper for every structure's cut alike.
pub fn window(scenes: &[Scene<'_>], plane: &Plane) -> Window {
    let mut all = plane.bounds;
    for scene in scenes {
        scene.parts(|part| {
            if part.level <= 1 {
                all = plane.cut(&part.bounds).map_or(all, |rect| all.join(&rect));
            }
        });
    }
    let sides = [0, 1].map(|k| (all.max[k] - all.min[k]).max(f64::MIN_POSITIVE));
    // A little air, so that a ray is seen to come from outside.
    let air = sides[0].max(sides[1]) * 0.05;
    let rect = Rect { min: all.min.map(|x| x - air), max: all.max.map(|x| x + air) };
    let sides = [0, 1].map(|k| rect.max[k] - rect.min[k]);
    let scale = (WIDEST / sides[0]).min(HIGHEST / sides[1]);
    let height = (sides[1] * scale) as i32;
    Window { rect, scale, width: WIDEST as i32 + 2 * MARGIN, height: height + TOP + BOTTOM }
}

impl Window {
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

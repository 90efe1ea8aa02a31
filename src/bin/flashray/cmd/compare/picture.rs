//! A slice picture: objects, nodes and cells in a plane, and the way of one ray.
use super::objects::Objects;
use super::page::escaped;
use super::slice::{self, Cell, MARGIN, Plane, Window};
use super::trail::{Trail, Visit};
use flashray::{Ray, Scene};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Most nodes and non-empty cells drawn.
const MOST: usize = 6000;
/// Of more visits than this only every fifth, tenth or so is numbered.
const NUMBERS: usize = 40;
/// Levels that look different.
const LEVELS: u32 = 7;

/// Colours and widths, for light and dark.
const STYLE: &str = "<style>\
    .fs .bg{fill:#fff}.fs text{font:110px system-ui,sans-serif;fill:#1b1f24}\
    .fs .h{font-size:170px;font-weight:600}.fs .s{fill:#59636e}\
    .fs .e{fill:none;stroke:#2f6db5}.fs .f{fill:#2f6db5}\
    .fs .o{stroke-width:17;stroke-linecap:round;fill-opacity:.13}\
    .fs .v{fill:#ffc400;fill-opacity:.32;stroke:#b07d00;stroke-width:14}\
    .fs .r{fill:none;stroke:#d1242f;stroke-width:22}.fs .p{fill:#d1242f}.fs .w{stroke-dasharray:50 40;stroke-width:14}\
    .fs .k{stroke:#59636e;stroke-width:5}\
    .fs .n{font-size:105px;font-weight:700;text-anchor:middle;paint-order:stroke;stroke:#fff;stroke-width:34;\
    stroke-linejoin:round}.fs .i{fill:#0b4a99}\
    @media(prefers-color-scheme:dark){.fs .bg{fill:#14181d}.fs text{fill:#e6edf3}.fs .s{fill:#9aa4ae}\
    .fs .e{stroke:#6ea8ec}.fs .f{fill:#6ea8ec}.fs .v{stroke:#ffd84d}.fs .r{stroke:#ff6b6b}.fs .p{fill:#ff6b6b}\
    .fs .k{stroke:#9aa4ae}.fs .n{stroke:#14181d}.fs .i{fill:#8fc1ff}}\
    </style>";

/// Objects' colours: of middling brightness, so that they show on white and on black.
const PALETTE: [&str; super::objects::COLORS] =
    ["#c2410c", "#2e8b57", "#8e44ad", "#c0398b", "#12868f", "#9a7400", "#5468d4", "#4d8f00"];

/// A picture and what there is to say of it.
pub struct Picture {
    pub svg: String,
    pub structure: &'static str,
}

/// Draws a structure's slice.
pub fn draw(
    scene: &Scene<'_>,
    plane: &Plane,
    window: &Window,
    objects: &Objects,
    ray: &Ray,
    rule: &'static str,
) -> Picture {
    let (cells, left_out) = slice::cells(scene, plane, MOST);
    let trail = Trail::new(scene, plane, ray);
    let structure = scene.kind().name();
    let rule = match rule {
        "" => "",
        "seed" => ", textbook rule (seed)",
        _ => ", surface-area rule (sah)",
    };
    let caption = caption(scene, plane, &trail, left_out + objects.left_out);
    let (width, height) = (window.width, window.height);
    let title = format!("{structure}{rule}");
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"fs\" viewBox=\"0 0 {width} {height}\" width=\"{}\" \
         height=\"{}\" role=\"img\"><title>{}</title>{STYLE}<rect class=\"bg\" width=\"{width}\" height=\"{height}\"/>\n\
         <text class=\"h\" x=\"{MARGIN}\" y=\"260\">{}</text>\n",
        width / 10,
        height / 10,
        escaped(&title),
        escaped(&title),
    );
    for (i, line) in caption.iter().enumerate() {
        // Writing to a string does not fail, here and below.
        let _ = writeln!(svg, "<text class=\"s\" x=\"{MARGIN}\" y=\"{}\">{}</text>", 430 + i * 140, escaped(line));
    }
    svg += &fills(&cells, window);
    for visit in trail.visits.iter().filter(|visit| visit.leaf) {
        let [left, top, right, bottom] = window.corners(&visit.rect);
        let _ = writeln!(svg, "<path class=\"v\" d=\"M{left} {top}H{right}V{bottom}H{left}z\"/>");
    }
    svg += &outlines(&cells, window);
    for (color, path) in objects.paths(window) {
        let color = PALETTE[color];
        let _ = writeln!(svg, "<path class=\"o\" stroke=\"{color}\" fill=\"{color}\" d=\"{path}\"/>");
    }
    svg += &way(&trail, plane, window, ray);
    svg += &legend(window);
    Picture { svg: svg + "</svg>\n", structure }
}

fn caption(scene: &Scene<'_>, plane: &Plane, trail: &Trail, left_out: usize) -> Vec<String> {
    let plural = |n: usize, one: &str, many: &str| format!("{n} {}", if n == 1 { one } else { many });
    let visits = match trail.visits.len() {
        0 => "visits no node".to_owned(),
        1 => "visits 1 node or cell".to_owned(),
        n => match every(n) {
            1 => format!("visits {n} nodes or cells (numbered in order)"),
            every => format!("visits {n} nodes or cells (every {every}th numbered, in order)"),
        },
    };
    let tests = plural(trail.tests as usize, "primitive", "primitives");
    let hit = trail.hit.map_or_else(|| "no hit".to_owned(), |hit| format!("hits primitive {}", hit.prim));
    let thin = if left_out > 0 { format!("; the {left_out} smallest pieces are not drawn") } else { String::new() };
    let (axis, at) = (Plane::name(plane.axis), plane.at);
    vec![
        format!("{} primitives, cut at {axis} = {at:.4}{thin}", scene.len()),
        format!("the ray {visits}, tests {tests}, {hit}"),
    ]
}

/// A tint for cells and leaves that list something, darker where it is more.
fn fills(cells: &[Cell], window: &Window) -> String {
    let mut paths: BTreeMap<u32, String> = BTreeMap::new();
    for cell in cells {
        let listed = cell.listed.unwrap_or(0);
        if listed > 0 {
            let [left, top, right, bottom] = window.corners(&cell.rect);
            let path = paths.entry(listed.ilog2().min(4)).or_default();
            let _ = write!(path, "M{left} {top}H{right}V{bottom}H{left}z");
        }
    }
    let tint = |(shade, path): (u32, String)| {
        format!("<path class=\"f\" fill-opacity=\".{:02}\" d=\"{path}\"/>\n", 8 + 6 * shade)
    };
    paths.into_iter().map(tint).collect()
}

/// Where lines of one direction lie, and from where to where they run.
type Lines = BTreeMap<i32, Vec<[i32; 2]>>;

/// The outlines of each level, deep ones thinner; lines that lie end to end or on each other are one.
fn outlines(cells: &[Cell], window: &Window) -> String {
    let mut levels: BTreeMap<u32, [Lines; 2]> = BTreeMap::new();
    let mut counts = [0; LEVELS as usize + 1];
    for cell in cells {
        counts[cell.level.min(LEVELS) as usize] += 1;
        let [left, top, right, bottom] = window.corners(&cell.rect);
        let [level, upright] = levels.entry(cell.level.min(LEVELS)).or_default();
        for y in [top, bottom] {
            level.entry(y).or_default().push([left, right]);
        }
        for x in [left, right] {
            upright.entry(x).or_default().push([top, bottom]);
        }
    }
    let mut svg = String::new();
    for (level, [lines, upright]) in levels.into_iter().rev() {
        let (place, count) = (level as usize, counts[level as usize]);
        let thin =
            [(3000, 5), (800, 8), (150, 11)].into_iter().find(|&(n, _)| count > n).map_or(26, |(_, width)| width);
        let width = [26, 20, 16, 13, 11, 9, 7, 6][place].min(thin);
        let opacity = [100, 90, 80, 72, 65, 60, 55, 50][place];
        let mut path = String::new();
        for (y, runs) in lines {
            merged(runs).for_each(|[a, b]| _ = write!(path, "M{a} {y}H{b}"));
        }
        for (x, runs) in upright {
            merged(runs).for_each(|[a, b]| _ = write!(path, "M{x} {a}V{b}"));
        }
        let look = format!("stroke-width=\"{width}\" stroke-opacity=\"{:.2}\"", f64::from(opacity) / 100.0);
        let _ = writeln!(svg, "<path class=\"e\" {look} d=\"{path}\"/>");
    }
    svg
}

/// Runs joined where they touch.
fn merged(mut runs: Vec<[i32; 2]>) -> impl Iterator<Item = [i32; 2]> {
    runs.sort_unstable();
    let mut joined: Vec<[i32; 2]> = Vec::new();
    for run in runs {
        match joined.last_mut() {
            Some(last) if run[0] <= last[1] => last[1] = last[1].max(run[1]),
            _ => joined.push(run),
        }
    }
    joined.into_iter()
}

/// The ray to its hit, on from there dashed, and the numbers of what it visits.
fn way(trail: &Trail, plane: &Plane, window: &Window, ray: &Ray) -> String {
    let (from, along) = (plane.flat(ray.origin), plane.flat(ray.dir));
    let at = |t: f64| window.place([0, 1].map(|k| from[k] + t * along[k]));
    let stop = trail.hit.map_or(1.0, |hit| f64::from(hit.t));
    let ([x, y], [u, v], [a, b]) = (at(0.0), at(stop), at(1.0));
    let mut svg = format!(
        "<path class=\"r w\" d=\"M{u} {v}L{a} {b}\"/>\n<path class=\"r\" d=\"M{x} {y}L{u} {v}\"/>\
         <circle class=\"p\" cx=\"{x}\" cy=\"{y}\" r=\"40\"/>\n"
    );
    svg += &numbers(&trail.visits, window, &at);
    if trail.hit.is_some() {
        let _ = writeln!(
            svg,
            "<circle class=\"r\" cx=\"{u}\" cy=\"{v}\" r=\"75\"/><circle class=\"p\" cx=\"{u}\" cy=\"{v}\" r=\"32\"/>"
        );
    }
    svg
}

/// Which of so many visits are numbered.
fn every(visits: usize) -> usize {
    [1, 5, 10, 50, 100].into_iter().find(|every| visits / every <= NUMBERS).unwrap_or(1000)
}

/// Inner nodes are numbered above the ray where it enters them, others below it in their middle; a number that would
/// lie on another moves away from the ray.
fn numbers(visits: &[Visit], window: &Window, at: &impl Fn(f64) -> [i32; 2]) -> String {
    let (mut svg, mut leaders, mut taken) = (String::new(), String::new(), Vec::<[i32; 2]>::new());
    let every = every(visits.len());
    for (i, visit) in visits.iter().enumerate().filter(|(i, _)| *i == 0 || (i + 1) % every == 0) {
        let [near, far] = visit.span;
        let [x, y] = at(if visit.leaf { f64::midpoint(near, far) } else { near });
        let side = if visit.leaf { 1 } else { -1 };
        let free = |p: &[i32; 2]| taken.iter().all(|q| (p[0] - q[0]).abs() >= 150 || (p[1] - q[1]).abs() >= 112);
        let spots = (0..60).map(|k| [x, y + side * (115 + 112 * k)]);
        let inside = |p: &[i32; 2]| (slice::TOP + 60..window.bottom() - 20).contains(&p[1]);
        let Some(spot) = spots.filter(inside).find(free) else { continue };
        taken.push(spot);
        if (spot[1] - y).abs() > 120 {
            let _ = write!(leaders, "M{x} {y}V{}", spot[1]);
        }
        let class = if visit.leaf { "n" } else { "n i" };
        let _ = writeln!(svg, "<text class=\"{class}\" x=\"{}\" y=\"{}\">{}</text>", spot[0], spot[1] + 38, i + 1);
    }
    format!("<path class=\"k\" d=\"{leaders}\"/>\n{svg}")
}

/// What the marks mean.
fn legend(window: &Window) -> String {
    let lines = [
        "blue lines: boxes of nodes and cells, thinner the deeper; tinted boxes list primitives, darker where more",
        "coloured: primitives; red: a ray from its start (dot) to its hit (ring); yellow: where it looks for primitives",
        "numbers below the ray: leaves and cells in order of visit; blue ones above it: other nodes, where it enters them",
    ];
    let mut svg = String::new();
    for (i, line) in (0..).zip(lines) {
        let y = window.bottom() + 170 + i * 150;
        let _ = writeln!(svg, "<text class=\"s\" x=\"{MARGIN}\" y=\"{y}\">{line}</text>");
    }
    svg
}

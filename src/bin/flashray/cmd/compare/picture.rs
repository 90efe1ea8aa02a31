//! A slice picture: objects, nodes and cells in a plane, and the way of one ray.
use super::objects::Objects;
use super::page::escaped;
use super::slice::{self, Cell, MARGIN, Plane, Rect, Window};
use super::trail::{Trail, Visit};
use flashray::{Kind, Ray, Scene};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Most nodes and non-empty cells drawn.
const MOST: usize = 6000;
/// Of more numbers than this only every second, third or so is written.
const NUMBERS: usize = 40;
/// How far on paper visits lie apart that have numbers of their own.
const CLOSE: i32 = 130;
/// Levels that look different.
const LEVELS: u32 = 7;

/// Colours and widths, for light and dark.
const STYLE: &str = "<style>\
    .fs .bg{fill:#fff}.fs text{font:145px system-ui,sans-serif;fill:#1b1f24}\
    .fs .h{font-size:210px;font-weight:600}.fs .s{fill:#59636e}\
    .fs .e{fill:none;stroke:#2f6db5}.fs .f{fill:#2f6db5}.fs .b{fill:none;stroke:#8b949e;stroke-width:14}\
    .fs .o{stroke-width:26;stroke-linecap:round;fill-opacity:.13}\
    .fs .v{fill:#ffc400;fill-opacity:.6;stroke:#b07d00;stroke-width:18}.fs .q{fill-opacity:.1;stroke:#d29a00;stroke-width:28}\
    .fs .r{fill:none;stroke:#d1242f;stroke-width:26}.fs .p{fill:#d1242f}.fs .w{stroke-dasharray:50 40;stroke-width:16}\
    .fs .k{stroke:#59636e;stroke-width:7}\
    .fs .n{font-size:150px;font-weight:700;text-anchor:middle;paint-order:stroke;stroke:#fff;stroke-width:40;\
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

/// What a structure is, for those who never met it.
const PLAIN: [(Kind, &str); 9] = [
    (Kind::List, "No structure: every ray is tested against every primitive."),
    (Kind::Bvh, "A tree of boxes, each just around its primitives: boxes overlap, and leave gaps."),
    (Kind::Grid, "Space in equal cells. Each lists the primitives that reach into it."),
    (Kind::Voxel, "The cells of a fine grid, but only those that hold something are stored."),
    (Kind::Nested, "A grid of few cells; a crowded cell holds a grid of its own, and so on."),
    (Kind::Octree, "A cube in eight equal cubes, each crowded one again: every cut is in the middle."),
    (Kind::Bsp, "A box cut in two by a plane, each crowded part again: always two, side by side."),
    (Kind::Sphere, "A tree of spheres, each around its primitives: spheres overlap."),
    (Kind::Wide, "The tree of boxes with up to eight children a node, which are tested at once."),
];

/// Draws a structure's slice.
pub fn draw(scene: &Scene<'_>, plane: &Plane, objects: &Objects, ray: &Ray, rule: &'static str) -> Picture {
    let (cells, left_out) = slice::cells(scene, plane, MOST);
    let round = scene.kind() == Kind::Sphere;
    let window = Window::new(&cells, plane);
    let trail = Trail::new(scene, plane, ray);
    let structure = scene.kind().name();
    let title = title(structure, rule);
    let plain = PLAIN.iter().find(|(kind, _)| *kind == scene.kind()).map_or("", |(_, plain)| *plain);
    let mut svg = frame(&window, &title);
    svg += &(line("h", 270, &title) + &line("s", 500, plain) + &line("s", 670, &caption(scene, plane, &trail)));
    svg += &fills(&cells, round, &window);
    let searched = trail.visits.iter().flat_map(|visit| &visit.searched);
    let searched: String = searched.map(|rect| outline(rect, round, &window)).collect();
    // Writing to a string does not fail, here and below.
    let class = if round { "v q" } else { "v" };
    let _ = writeln!(svg, "<path class=\"{class}\" d=\"{searched}\"/>");
    let _ = writeln!(svg, "<path class=\"b\" d=\"{}\"/>", outline(&plane.bounds, false, &window));
    svg += &if round { circles(&cells, &window) } else { outlines(&cells, &window) };
    for (color, path) in objects.paths(&window) {
        let color = PALETTE[color];
        let _ = writeln!(svg, "<path class=\"o\" stroke=\"{color}\" fill=\"{color}\" d=\"{path}\"/>");
    }
    svg += &way(&trail, plane, &window, ray);
    svg += &legend(&window, left_out + objects.left_out);
    Picture { svg: svg + "</svg>\n", structure }
}

fn title(structure: &str, rule: &str) -> String {
    match rule {
        "" => structure.to_owned(),
        "seed" => format!("{structure}, textbook rule (seed)"),
        _ => format!("{structure}, surface-area rule (sah)"),
    }
}

/// The paper.
fn frame(window: &Window, title: &str) -> String {
    let (width, height, title) = (window.width, window.height, escaped(title));
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"fs\" viewBox=\"0 0 {width} {height}\" width=\"{}\" \
         height=\"{}\" role=\"img\"><title>{title}</title>{STYLE}<rect class=\"bg\" width=\"{width}\" \
         height=\"{height}\"/>\n",
        width / 10,
        height / 10,
    )
}

/// A line of text.
fn line(class: &str, y: i32, text: &str) -> String {
    format!("<text class=\"{class}\" x=\"{MARGIN}\" y=\"{y}\">{}</text>\n", escaped(text))
}

fn caption(scene: &Scene<'_>, plane: &Plane, trail: &Trail) -> String {
    let steps = trail.visits.len();
    let plural = if steps == 1 { "" } else { "s" };
    let hit = trail.hit.map_or_else(|| "hits nothing".to_owned(), |hit| format!("hits number {}", hit.prim));
    let (axis, all, tests) = (Plane::name(plane.axis), scene.len(), trail.tests);
    let plain = plane.at == 0.0 || (0.01..1e6).contains(&plane.at.abs());
    let at = if plain { format!("{:.3}", plane.at) } else { format!("{:.2e}", plane.at) };
    format!("Cut at {axis} = {at}. Of {all} primitives the ray tests {tests}, in {steps} step{plural}, and {hit}.")
}

/// The path around a rectangle, or of the circle in it.
fn outline(rect: &Rect, round: bool, window: &Window) -> String {
    let [left, top, right, bottom] = window.corners(rect);
    if round {
        let (r, y) = (((right - left) / 2).max(1), i32::midpoint(top, bottom));
        return format!("M{left} {y}a{r} {r} 0 1 0 {} 0a{r} {r} 0 1 0 {} 0z", 2 * r, -2 * r);
    }
    format!("M{left} {top}H{right}V{bottom}H{left}z")
}

/// A tint for cells and leaves that list something, darker where it is more.
fn fills(cells: &[Cell], round: bool, window: &Window) -> String {
    let mut paths: BTreeMap<u32, String> = BTreeMap::new();
    for cell in cells {
        let listed = cell.listed.unwrap_or(0);
        if listed > 0 {
            *paths.entry(listed.ilog2().min(4)).or_default() += &outline(&cell.rect, round && cell.level > 0, window);
        }
    }
    let tint = |(shade, path): (u32, String)| {
        format!("<path class=\"f\" fill-opacity=\".{:02}\" d=\"{path}\"/>\n", 8 + 6 * shade)
    };
    paths.into_iter().map(tint).collect()
}

/// How wide the lines of a level are, and how strong.
fn look(level: u32, count: usize) -> String {
    let place = level as usize;
    let thin = [(3000, 6), (800, 9), (150, 14)].into_iter().find(|&(n, _)| count > n).map_or(34, |(_, width)| width);
    let width = [34, 28, 22, 18, 15, 12, 10, 8][place].min(thin);
    format!("stroke-width=\"{width}\" stroke-opacity=\".{}\"", [99, 90, 80, 72, 65, 60, 55, 50][place])
}

/// The circles of each level, deep ones thinner.
fn circles(cells: &[Cell], window: &Window) -> String {
    let mut levels: BTreeMap<u32, (usize, String)> = BTreeMap::new();
    for cell in cells {
        let (count, path) = levels.entry(cell.level.min(LEVELS)).or_default();
        *count += 1;
        *path += &outline(&cell.rect, cell.level > 0, window);
    }
    let draw = |(level, (count, path))| format!("<path class=\"e\" {} d=\"{path}\"/>\n", look(level, count));
    levels.into_iter().rev().map(draw).collect()
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
        let mut path = String::new();
        for (y, runs) in lines {
            merged(runs).for_each(|[a, b]| _ = write!(path, "M{a} {y}H{b}"));
        }
        for (x, runs) in upright {
            merged(runs).for_each(|[a, b]| _ = write!(path, "M{x} {a}V{b}"));
        }
        let look = look(level, counts[level as usize]);
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
         <circle class=\"p\" cx=\"{x}\" cy=\"{y}\" r=\"55\"/>\n"
    );
    svg += &numbers(&trail.visits, window, &at);
    if trail.hit.is_some() {
        let _ = writeln!(
            svg,
            "<circle class=\"r\" cx=\"{u}\" cy=\"{v}\" r=\"100\"/><circle class=\"p\" cx=\"{u}\" cy=\"{v}\" r=\"45\"/>"
        );
    }
    svg
}

/// Visits with one number: from the first to the last, where on paper, and whether they look for primitives.
struct Group {
    first: usize,
    last: usize,
    at: [i32; 2],
    search: bool,
}

/// Visits in a row of one sort that begin close to each other share a number, such as 3-7.
fn groups(visits: &[Visit], at: &impl Fn(f64) -> [i32; 2]) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for (i, visit) in (1..).zip(visits) {
        let search = !visit.searched.is_empty();
        let [near, far] = visit.span;
        let at = at(if search { f64::midpoint(near, far) } else { near });
        match groups.last_mut() {
            Some(group) if group.search == search && (0..2).all(|k| (group.at[k] - at[k]).abs() < CLOSE) => {
                group.last = i;
            }
            _ => groups.push(Group { first: i, last: i, at, search }),
        }
    }
    groups
}

/// Nodes passed on the way down are numbered above the ray where it enters them, those in which it looks for primitives
/// below it in their middle; a number that would lie on another moves away from the ray.
fn numbers(visits: &[Visit], window: &Window, at: &impl Fn(f64) -> [i32; 2]) -> String {
    let (mut svg, mut leaders, mut taken) = (String::new(), String::new(), Vec::<([i32; 2], i32)>::new());
    let groups = groups(visits, at);
    for Group { first, last, at: [x, y], search } in groups.iter().step_by(groups.len().div_ceil(NUMBERS).max(1)) {
        let text = if first == last { first.to_string() } else { format!("{first}-{last}") };
        let wide = text.chars().fold(20, |wide, _| wide + 50);
        let side = if *search { 1 } else { -1 };
        let free = |p: &[i32; 2]| {
            taken.iter().all(|(q, width)| (p[0] - q[0]).abs() >= wide + width || (p[1] - q[1]).abs() >= 160)
        };
        let spots = (0..60).map(|k| [*x, y + side * (150 + 160 * k)]);
        let inside = |p: &[i32; 2]| (slice::TOP + 60..window.bottom() - 20).contains(&p[1]);
        let Some(spot) = spots.filter(inside).find(free) else { continue };
        taken.push((spot, wide));
        if (spot[1] - y).abs() > 160 {
            let _ = write!(leaders, "M{x} {y}V{}", spot[1]);
        }
        let class = if *search { "n" } else { "n i" };
        let _ = writeln!(svg, "<text class=\"{class}\" x=\"{}\" y=\"{}\">{text}</text>", spot[0], spot[1] + 54);
    }
    format!("<path class=\"k\" d=\"{leaders}\"/>\n{svg}")
}

/// What the marks mean.
fn legend(window: &Window, left_out: usize) -> String {
    let y = window.bottom() + 130;
    let mut svg = String::new();
    let marks = [
        ("<rect class=\"e\" stroke-width=\"22\" width=\"260\" height=\"130\"/>", "node or cell"),
        ("<rect class=\"f\" fill-opacity=\".26\" width=\"260\" height=\"130\"/>", "lists primitives"),
        ("<rect class=\"v\" width=\"260\" height=\"130\"/>", "looked into"),
        (
            "<path class=\"o\" stroke=\"#c2410c\" d=\"M0 110L130 20\"/><path class=\"o\" stroke=\"#12868f\" \
          d=\"M130 20L260 110\"/>",
            "primitives",
        ),
    ];
    for (x, (mark, text)) in [0, 1800, 3750, 5500].into_iter().zip(marks) {
        let x = MARGIN + x;
        let _ = writeln!(
            svg,
            "<g transform=\"translate({x} {y})\">{mark}</g><text class=\"s\" x=\"{}\" y=\"{}\">{text}</text>",
            x + 330,
            y + 115
        );
    }
    let marks = "Red: the ray, up to its hit (ring). Numbers: its steps in order, blue ones on the way down.";
    svg += &line("s", y + 330, marks);
    if left_out > 0 {
        svg += &line("s", y + 500, &format!("The {left_out} smallest pieces are not drawn."));
    }
    svg
}

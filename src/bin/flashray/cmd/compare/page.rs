//! The page: tables, plots and slice pictures in one file that needs no other.
use super::chart::Chart;
use super::picture::Picture;
use super::rays::{KINDS, SHADOW};
use super::table::{self, COSTS, Column, SIZES};
use serde_json::Value;
use std::fmt::Write as _;

const HEAD: &str = "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
    <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\
    <meta name=\"color-scheme\" content=\"light dark\">\n<style>\
    :root{--bg:#fff;--ink:#1b1f24;--soft:#59636e;--rule:#d5dae0;--c0:#2f6db5;--c1:#e08a00;--c2:#2f9e6e;--c3:#a64fb8}\
    @media(prefers-color-scheme:dark){:root{--bg:#14181d;--ink:#e6edf3;--soft:#9aa4ae;--rule:#353c45;--c0:#6ea8ec;\
    --c1:#f0a93a;--c2:#56c596;--c3:#cf86de}}\
    body{margin:2rem auto;padding:0 1rem;max-width:1100px;background:var(--bg);color:var(--ink);\
    font:15px/1.5 system-ui,sans-serif}\
    h1{font-size:1.6rem}h2{font-size:1.25rem;margin-top:2.2rem}p{max-width:75ch}.soft{color:var(--soft)}\
    .wide{overflow-x:auto}table{border-collapse:collapse;font-variant-numeric:tabular-nums}\
    th,td{padding:.2rem .7rem;text-align:right;border-bottom:1px solid var(--rule);white-space:nowrap}\
    th:first-child,td:first-child{text-align:left}\
    .pair{display:grid;grid-template-columns:repeat(auto-fill,minmax(460px,1fr));gap:1rem}\
    figure{margin:0}figure svg{width:100%;height:auto;border:1px solid var(--rule)}\
    .chart{display:block;width:100%;max-width:760px;height:auto;margin:1.2rem 0}.chart text{font:11px system-ui,sans-serif;\
    fill:var(--ink)}.chart .h{font-size:14px;font-weight:600}.chart .l{text-anchor:end}.chart .v{font-size:9px;\
    fill:var(--soft)}.c0{fill:var(--c0)}.c1{fill:var(--c1)}.c2{fill:var(--c2)}.c3{fill:var(--c3)}\
    </style>\n";

/// What a structure is, for those who never met it.
const PLAIN: [(&str, &str); 8] = [
    (
        "list",
        "Every ray is tested against every primitive. Nothing to build, nothing to get wrong: the truth that the others are held against.",
    ),
    (
        "bvh",
        "A tree of boxes around primitives. The set is parted, not space: each primitive is in one leaf, and boxes may overlap.",
    ),
    (
        "grid",
        "Space is cut into equal cells, each with a list of what has a part in it. The ray steps from cell to cell.",
    ),
    (
        "voxel",
        "The same cells, but only those that hold something are stored, in a hash table behind one bit for each cell.",
    ),
    ("nested", "A grid of few cells; a crowded cell holds another grid, and so on."),
    ("octree", "A cube is cut into eight equal cubes, and each crowded one again."),
    ("bsp", "A box is cut in two by a plane square to an axis, and each crowded half again: halves need not be equal."),
    (
        "sphere",
        "A tree like the bvh, with spheres around primitives instead of boxes; drawn are the boxes of the spheres.",
    ),
];

/// Text in which nothing is markup.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The page.
pub fn write(facts: &Value, pictures: &[(String, Picture)]) -> String {
    let rows = table::rows(facts);
    let scene = escaped(facts["scene"].as_str().unwrap_or(""));
    let mut page = format!(
        "{HEAD}<title>flashray compare {scene}</title></head><body>\n<h1>Structures compared on {scene}</h1>\n<p>{}</p>\n",
        escaped(&table::caption(facts))
    );
    for (title, columns) in [("What is built", &SIZES[..]), ("What rays cost", &COSTS[..])] {
        page += &html_table(title, rows, columns);
    }
    // Writing to a string does not fail, here and below.
    let _ = writeln!(page, "<p class=\"soft\">{}</p>\n<h2>Plots</h2>", escaped(table::LEGEND));
    for chart in charts(rows) {
        page += &chart.svg();
    }
    page += "<h2>Slices</h2>\n<p>Each picture shows the same plane through the scene and the same ray in it.</p>\n";
    let mut last = "";
    for (_, picture) in pictures {
        if picture.structure != last {
            page += if last.is_empty() { "" } else { "</div>\n" };
            last = picture.structure;
            let plain = PLAIN.iter().find(|(name, _)| *name == last).map_or("", |(_, plain)| *plain);
            let _ = writeln!(page, "<h2 id=\"{last}\">{last}</h2>\n<p>{plain}</p>\n<div class=\"pair\">");
        }
        let _ = writeln!(page, "<figure>{}</figure>", picture.svg);
    }
    page + "</div>\n</body></html>\n"
}

fn html_table(title: &str, rows: &[Value], columns: &[Column]) -> String {
    let heads: String = columns.iter().map(|column| ["<th>", column.0, "</th>"].concat()).collect();
    let mut html = format!("<h2>{title}</h2>\n<div class=\"wide\"><table>\n<tr><th>structure</th>{heads}</tr>\n");
    for row in rows {
        let cells: String = columns.iter().map(|column| ["<td>", &column.cell(row), "</td>"].concat()).collect();
        let _ = writeln!(html, "<tr><td>{}</td>{cells}</tr>", table::label(row));
    }
    html + "</table></div>\n"
}

/// Speed, bytes, steps and tests. The list's steps and tests would dwarf the others'.
fn charts(rows: &[Value]) -> [Chart<'static>; 4] {
    const CLOSEST: [&str; 3] = [KINDS[0], KINDS[1], KINDS[3]];
    const { assert!(SHADOW == 2) };
    let without_list: Vec<&Value> = rows.iter().filter(|row| row["kind"] != "list").collect();
    let pick = |rows: &[&Value], name: &str, keys: &[&str]| -> Vec<(String, Vec<Option<f64>>)> {
        rows.iter().map(|row| (table::label(row), keys.iter().map(|key| row[name][key].as_f64()).collect())).collect()
    };
    let bytes = |row: &Value| {
        let per = |key: &str| Some(row[key].as_f64()? / row["bytes"].as_f64()? * row["bytes_per_primitive"].as_f64()?);
        (table::label(row), vec![per("primitive_bytes"), per("node_bytes"), per("reference_bytes")])
    };
    let all: Vec<&Value> = rows.iter().collect();
    let chart = |title, series, rows, stacked, decimals| Chart { title, series, rows, stacked, decimals };
    [
        chart("Speed: millions of rays a second, one thread", &KINDS, pick(&all, "mrays_per_second", &KINDS), false, 2),
        chart(
            "Bytes per primitive",
            &["primitives", "nodes and cells", "lists"],
            rows.iter().map(bytes).collect(),
            true,
            1,
        ),
        chart(
            "Steps: nodes and cells visited per ray",
            &CLOSEST,
            pick(&without_list, "steps_per_ray", &CLOSEST),
            false,
            1,
        ),
        chart(
            "Tests of primitives per ray (the list: all of them)",
            &CLOSEST,
            pick(&without_list, "tests_per_ray", &CLOSEST),
            false,
            1,
        ),
    ]
}

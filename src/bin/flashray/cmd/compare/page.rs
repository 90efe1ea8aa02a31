//! The page: tables, plots and slice pictures in one file that needs no other.
use super::chart::Chart;
use super::picture::Picture;
use super::table::{self, TABLES};
use crate::columns::Column;
use crate::kinds::KINDS;
use serde_json::Value;
use std::fmt::Write as _;

const HEAD: &str = "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
    <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\
    <meta name=\"color-scheme\" content=\"light dark\">\n<style>\
    :root{--bg:#fff;--ink:#1b1f24;--soft:#59636e;--rule:#d5dae0;--band:#f5f7f9;--c0:#2f6db5;--c1:#e08a00;--c2:#2f9e6e;--c3:#a64fb8}\
    @media(prefers-color-scheme:dark){:root{--bg:#14181d;--ink:#e6edf3;--soft:#9aa4ae;--rule:#353c45;--band:#1a1f25;--c0:#6ea8ec;\
    --c1:#f0a93a;--c2:#56c596;--c3:#cf86de}}\
    body{margin:2rem auto;padding:0 1rem;max-width:1320px;background:var(--bg);color:var(--ink);\
    font:15px/1.5 system-ui,sans-serif}\
    h1{font-size:1.6rem}h2{font-size:1.25rem;margin-top:2.2rem}p{max-width:75ch}.soft{color:var(--soft)}\
    .wide{overflow-x:auto}table{border-collapse:collapse;font-variant-numeric:tabular-nums}\
    th,td{padding:.2rem .6rem;text-align:right;border-bottom:1px solid var(--rule);white-space:nowrap}\
    th:first-child,td:first-child{text-align:left}.g{color:var(--soft);font-weight:400}\
    tr .g{text-align:center;border-left:1.5rem solid var(--bg)}\
    tr:nth-child(even) td{background:var(--band)}\
    .pair{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(600px,100%),1fr));gap:1rem}\
    figure{margin:0}figure svg{width:100%;height:auto;border:1px solid var(--rule)}\
    .chart{display:block;width:100%;max-width:860px;height:auto;margin:1.2rem 0}.chart text{font:11px system-ui,sans-serif;\
    fill:var(--ink)}.chart .h{font-size:14px;font-weight:600}.chart .l{text-anchor:end}.chart .v{font-size:10px;\
    fill:var(--soft)}.chart .t{fill:var(--soft);text-anchor:middle}.chart .a{stroke:var(--rule)}.c0{fill:var(--c0)}.c1{fill:var(--c1)}.c2{fill:var(--c2)}.c3{fill:var(--c3)}\
    </style>\n";

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
    for (title, columns) in TABLES {
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
            let _ = writeln!(page, "<h3 id=\"{last}\">{last}</h3>\n<div class=\"pair\">");
        }
        let _ = writeln!(page, "<figure>{}</figure>", picture.svg);
    }
    page + "</div>\n</body></html>\n"
}

fn html_table(title: &str, rows: &[Value], columns: &[Column]) -> String {
    let mut groups = String::new();
    for group in crate::columns::groups(columns) {
        let _ = write!(groups, "<th class=\"g\" colspan=\"{}\">{}</th>", group.len(), group[0].0);
    }
    let heads: String = columns.iter().map(|column| ["<th>", column.1, "</th>"].concat()).collect();
    let mut html = format!(
        "<h2>{title}</h2>\n<div class=\"wide\"><table>\n<tr><th></th>{groups}</tr>\n\
         <tr><th>structure</th>{heads}</tr>\n"
    );
    for row in rows {
        let cells: String = columns.iter().map(|column| ["<td>", &column.cell(row), "</td>"].concat()).collect();
        let _ = writeln!(html, "<tr><td>{}</td>{cells}</tr>", table::label(row));
    }
    html + "</table></div>\n"
}

/// Speed, bytes, steps and tests. The list's steps and tests would dwarf the others'.
fn charts(rows: &[Value]) -> [Chart<'static>; 4] {
    let without_list: Vec<&Value> = rows.iter().filter(|row| row["kind"] != "list").collect();
    let pick = |rows: &[&Value], name: &str, keys: &[&str]| -> Vec<(String, Vec<Option<f64>>)> {
        rows.iter().map(|row| (table::label(row), keys.iter().map(|key| row[name][key].as_f64()).collect())).collect()
    };
    let bytes = |row: &Value| {
        let per = |key: &str| Some(row[key].as_f64()? / row["bytes"].as_f64()? * row["bytes_per_primitive"].as_f64()?);
        (table::label(row), vec![per("primitive_bytes"), per("node_bytes"), per("reference_bytes")])
    };
    let all: Vec<&Value> = rows.iter().collect();
    let chart = |title, unit, series, rows, stacked, decimals| Chart { title, unit, series, rows, stacked, decimals };
    let speed = pick(&all, "mrays_per_second", &KINDS);
    let bytes = rows.iter().map(bytes).collect();
    let steps = pick(&without_list, "steps_per_ray", &KINDS);
    let tests = pick(&without_list, "tests_per_ray", &KINDS);
    [
        chart("Speed (more is better)", "millions of rays a second, one by one, one thread", &KINDS, speed, false, 2),
        chart(
            "Size (less is better)",
            "bytes per primitive",
            &["primitives", "nodes and cells", "lists"],
            bytes,
            true,
            1,
        ),
        chart("Steps (less is better)", "nodes and cells visited per ray", &KINDS, steps, false, 1),
        chart("Tests (less is better; the list tests all)", "primitives tested per ray", &KINDS, tests, false, 1),
    ]
}

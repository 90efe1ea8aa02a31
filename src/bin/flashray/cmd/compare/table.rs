//! The tables, for the terminal and for the page.
use super::rays::KINDS;
use serde_json::Value;

/// A column: heading, decimals, factor and place.
pub struct Column(pub &'static str, usize, f64, &'static str);

/// What is built.
pub const SIZES: [Column; 10] = [
    Column("build ms", 2, 1e3, "/build_seconds"),
    Column("check ms", 2, 1e3, "/check_seconds"),
    Column("bytes", 0, 1.0, "/bytes"),
    Column("B/prim", 1, 1.0, "/bytes_per_primitive"),
    Column("node B", 0, 1.0, "/node_bytes"),
    Column("ref B", 0, 1.0, "/reference_bytes"),
    Column("refs/prim", 2, 1.0, "/references_per_primitive"),
    Column("nodes", 0, 1.0, "/nodes"),
    Column("leaves", 0, 1.0, "/leaves"),
    Column("depth", 0, 1.0, "/depth"),
];

/// What rays cost.
pub const COSTS: [Column; 9] = [
    Column("steps", 2, 1.0, "/steps_per_ray/all"),
    Column("tests", 2, 1.0, "/tests_per_ray/all"),
    Column("spared", 2, 1.0, "/spared_per_ray/all"),
    Column("camera", 4, 1.0, "/mrays_per_second/camera"),
    Column("diffuse", 4, 1.0, "/mrays_per_second/diffuse"),
    Column("shadow", 4, 1.0, "/mrays_per_second/shadow"),
    Column("chord", 4, 1.0, "/mrays_per_second/chord"),
    Column("x list", 1, 1.0, "/over_list/camera"),
    Column("wrong", 0, 1.0, "/wrong"),
];

impl Column {
    /// The cell of a row.
    pub fn cell(&self, row: &Value) -> String {
        let Self(_, decimals, factor, at) = *self;
        let number = row.pointer(at).and_then(Value::as_f64);
        number.map_or_else(|| "-".into(), |x| format!("{:.decimals$}", x * factor))
    }
}

/// Name and rule of a row.
pub fn label(row: &Value) -> String {
    let part = |key: &str| row[key].as_str().unwrap_or("").to_owned();
    (part("kind") + " " + &part("rule")).trim_end().to_owned()
}

/// The rows, in the order they were measured.
pub fn rows(facts: &Value) -> &[Value] {
    facts["structures"].as_array().map_or(&[], Vec::as_slice)
}

/// What was done, in a sentence or two.
pub fn caption(facts: &Value) -> String {
    let number = |at: &str| facts.pointer(at).and_then(Value::as_u64).unwrap_or(0);
    let rays: Vec<String> = KINDS.iter().map(|kind| format!("{} {kind}", number(&format!("/rays/{kind}")))).collect();
    let listed = number("/rays_compared_with_list");
    let all = number("/rays_compared");
    let compared = if listed == all {
        "Every answer was compared with the list's.".to_owned()
    } else {
        format!("Answers were compared with the list's for {listed} of {all} rays, and with the bvh's for all.")
    };
    let (prims, leaf, rays) = (number("/primitives"), number("/leaf"), rays.join(", "));
    format!("{prims} primitives, leaves of up to {leaf}; rays: {rays}. {compared}")
}

/// What the headings mean.
pub const LEGEND: &str = "node B: bytes of nodes and cells. ref B: bytes of the lists of primitives in cells; refs/prim: \
    how often a primitive is listed. steps, tests: nodes or cells visited and primitives tested per ray, over camera, \
    diffuse and chord rays; spared: tests of these that a mailbox of 8 saves. camera to chord: millions of rays a second \
    on one thread, medians; shadow rays ask for any hit. x list: camera rays, times the speed of the list.";

/// Both tables as text.
pub fn report(facts: &Value) -> String {
    let mut text = format!("{}: {}\n\n", facts["scene"].as_str().unwrap_or(""), caption(facts));
    text += &aligned(rows(facts), &SIZES);
    text.push('\n');
    text += &aligned(rows(facts), &COSTS);
    text.push('\n');
    text += &wrapped(LEGEND, 110);
    if let Some(page) = facts["page"].as_str() {
        text = text + "\n" + page;
    }
    text
}

/// Columns as wide as their widest cell, numbers to the right.
fn aligned(rows: &[Value], columns: &[Column]) -> String {
    let labels: Vec<String> = rows.iter().map(label).collect();
    let first = labels.iter().map(String::len).fold("structure".len(), usize::max);
    let mut lines = vec![format!("{:first$}", "structure")];
    lines.extend(labels.iter().map(|label| format!("{label:first$}")));
    for column in columns {
        let cells: Vec<String> =
            std::iter::once(column.0.to_owned()).chain(rows.iter().map(|row| column.cell(row))).collect();
        let width = cells.iter().map(String::len).max().unwrap_or(0);
        for (line, cell) in lines.iter_mut().zip(cells) {
            line.extend(["  ", &" ".repeat(width - cell.len()), &cell]);
        }
    }
    lines.join("\n") + "\n"
}

/// Text in lines of at most `width`.
fn wrapped(text: &str, width: usize) -> String {
    let (mut all, mut line) = (String::new(), 0);
    for word in text.split_whitespace() {
        if line > 0 && line + 1 + word.len() > width {
            all.push('\n');
            line = 0;
        } else if line > 0 {
            all.push(' ');
            line += 1;
        }
        all += word;
        line += word.len();
    }
    all
}

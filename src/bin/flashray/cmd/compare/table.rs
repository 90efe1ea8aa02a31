//! The tables, for the terminal and for the page.
use crate::columns::{Column, aligned, wrapped};
use crate::kinds::KINDS;
use serde_json::Value;

/// A title and columns.
pub type Table = (&'static str, &'static [Column]);

/// All tables.
pub const TABLES: [Table; 3] = [("What is built", &SIZES), ("Work per ray", &WORK), ("Speed on one thread", &SPEEDS)];

/// What is built.
const SIZES: [Column; 10] = [
    Column("time in ms", "build", 2, 1e3, "/build_seconds"),
    Column("time in ms", "check", 2, 1e3, "/check_seconds"),
    Column("bytes", "all", 0, 1.0, "/bytes"),
    Column("bytes", "nodes", 0, 1.0, "/node_bytes"),
    Column("bytes", "lists", 0, 1.0, "/reference_bytes"),
    Column("per primitive", "bytes", 1, 1.0, "/bytes_per_primitive"),
    Column("per primitive", "refs", 2, 1.0, "/references_per_primitive"),
    Column("shape", "nodes", 0, 1.0, "/nodes"),
    Column("shape", "leaves", 0, 1.0, "/leaves"),
    Column("shape", "depth", 0, 1.0, "/depth"),
];

/// What rays do.
const WORK: [Column; 13] = [
    Column("steps", "camera", 2, 1.0, "/steps_per_ray/camera"),
    Column("steps", "diffuse", 2, 1.0, "/steps_per_ray/diffuse"),
    Column("steps", "shadow", 2, 1.0, "/steps_per_ray/shadow"),
    Column("steps", "chord", 2, 1.0, "/steps_per_ray/chord"),
    Column("tests", "camera", 2, 1.0, "/tests_per_ray/camera"),
    Column("tests", "diffuse", 2, 1.0, "/tests_per_ray/diffuse"),
    Column("tests", "shadow", 2, 1.0, "/tests_per_ray/shadow"),
    Column("tests", "chord", 2, 1.0, "/tests_per_ray/chord"),
    Column("spared", "camera", 2, 1.0, "/spared_per_ray/camera"),
    Column("spared", "diffuse", 2, 1.0, "/spared_per_ray/diffuse"),
    Column("spared", "shadow", 2, 1.0, "/spared_per_ray/shadow"),
    Column("spared", "chord", 2, 1.0, "/spared_per_ray/chord"),
    Column("answers", "wrong", 0, 1.0, "/wrong"),
];

/// How fast they are.
const SPEEDS: [Column; 12] = [
    Column("Mrays/s one by one", "camera", 3, 1.0, "/mrays_per_second/camera"),
    Column("Mrays/s one by one", "diffuse", 3, 1.0, "/mrays_per_second/diffuse"),
    Column("Mrays/s one by one", "shadow", 3, 1.0, "/mrays_per_second/shadow"),
    Column("Mrays/s one by one", "chord", 3, 1.0, "/mrays_per_second/chord"),
    Column("Mrays/s in groups", "camera", 3, 1.0, "/mrays_per_second_in_groups/camera"),
    Column("Mrays/s in groups", "diffuse", 3, 1.0, "/mrays_per_second_in_groups/diffuse"),
    Column("Mrays/s in groups", "shadow", 3, 1.0, "/mrays_per_second_in_groups/shadow"),
    Column("Mrays/s in groups", "chord", 3, 1.0, "/mrays_per_second_in_groups/chord"),
    Column("times the list", "camera", 1, 1.0, "/over_list/camera"),
    Column("times the list", "diffuse", 1, 1.0, "/over_list/diffuse"),
    Column("times the list", "shadow", 1, 1.0, "/over_list/shadow"),
    Column("times the list", "chord", 1, 1.0, "/over_list/chord"),
];

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
    format!("{prims} primitives; leaf limit {leaf}; rays: {rays}. {compared}")
}

/// What the headings mean.
pub const LEGEND: &str = "\
    bytes: nodes are nodes and cells, lists say which primitives are in which cell, all is the whole blob. refs: how \
    often a primitive is listed. leaf limit: most primitives of a leaf in bvh and sphere; octree and bsp cut what \
    has more by the textbook's rule, where that helps; the others have no such limit. steps: nodes or cells that a \
    ray visits; tests: primitives that it is tested against; spared: those of the tests that a mailbox of 8 avoids, \
    since the ray met the primitive in a cell before. Camera rays start at a camera, diffuse and shadow rays where \
    those hit, chords run between points on a sphere around all. Shadow rays ask for any hit, so they stop at the \
    first they find; the others ask for the closest. Mrays/s: millions of rays a second without a mailbox, medians, \
    caches warm; groups are of 64 rays a call. times the list: one by one.";

/// The tables as text.
pub fn report(facts: &Value) -> String {
    let mut text = wrapped(&format!("{}: {}", facts["scene"].as_str().unwrap_or(""), caption(facts)), 110);
    let labels: Vec<String> = rows(facts).iter().map(label).collect();
    for (title, columns) in TABLES {
        text = text + "\n\n" + title + "\n" + &aligned("structure", &labels, rows(facts), columns);
    }
    text = text + "\n\n" + &wrapped(LEGEND, 110);
    if let Some(page) = facts["page"].as_str() {
        text = text + "\n\nThe page is " + page;
    }
    text
}

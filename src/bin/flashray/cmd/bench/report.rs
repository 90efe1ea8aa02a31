//! What was measured, as JSON and as tables.
use super::super::trace::Mode;
use super::measure::Rounds;
use super::{Built, Way};
use crate::columns::{Column, aligned, wrapped};
use crate::kinds::{KINDS, Rays, SHADOW};
use clap::ValueEnum;
use flashray::{Ray, Scene};
use serde_json::{Value, json};

const SPEEDS: [Column; 13] = [
    Column("camera", "median", 2, 1.0, "/mrays_per_second/camera/median"),
    Column("camera", "from", 2, 1.0, "/mrays_per_second/camera/lower_quartile"),
    Column("camera", "to", 2, 1.0, "/mrays_per_second/camera/upper_quartile"),
    Column("diffuse", "median", 2, 1.0, "/mrays_per_second/diffuse/median"),
    Column("diffuse", "from", 2, 1.0, "/mrays_per_second/diffuse/lower_quartile"),
    Column("diffuse", "to", 2, 1.0, "/mrays_per_second/diffuse/upper_quartile"),
    Column("shadow", "median", 2, 1.0, "/mrays_per_second/shadow/median"),
    Column("shadow", "from", 2, 1.0, "/mrays_per_second/shadow/lower_quartile"),
    Column("shadow", "to", 2, 1.0, "/mrays_per_second/shadow/upper_quartile"),
    Column("chord", "median", 2, 1.0, "/mrays_per_second/chord/median"),
    Column("chord", "from", 2, 1.0, "/mrays_per_second/chord/lower_quartile"),
    Column("chord", "to", 2, 1.0, "/mrays_per_second/chord/upper_quartile"),
    Column("a miss", "ns", 1, 1.0, "/miss_nanoseconds/median"),
];

const WORK: [Column; 10] = [
    Column("built", "bytes/prim", 1, 1.0, "/bytes_per_primitive"),
    Column("built", "seconds", 3, 1.0, "/build_seconds"),
    Column("nodes visited", "camera", 2, 1.0, "/nodes_per_ray/camera"),
    Column("nodes visited", "diffuse", 2, 1.0, "/nodes_per_ray/diffuse"),
    Column("nodes visited", "shadow", 2, 1.0, "/nodes_per_ray/shadow"),
    Column("nodes visited", "chord", 2, 1.0, "/nodes_per_ray/chord"),
    Column("primitives tested", "camera", 2, 1.0, "/tests_per_ray/camera"),
    Column("primitives tested", "diffuse", 2, 1.0, "/tests_per_ray/diffuse"),
    Column("primitives tested", "shadow", 2, 1.0, "/tests_per_ray/shadow"),
    Column("primitives tested", "chord", 2, 1.0, "/tests_per_ray/chord"),
];

const GROUPED: [Column; 8] = [
    Column("nodes visited", "camera", 2, 1.0, "/nodes_per_ray_in_groups/camera"),
    Column("nodes visited", "diffuse", 2, 1.0, "/nodes_per_ray_in_groups/diffuse"),
    Column("nodes visited", "shadow", 2, 1.0, "/nodes_per_ray_in_groups/shadow"),
    Column("nodes visited", "chord", 2, 1.0, "/nodes_per_ray_in_groups/chord"),
    Column("primitives tested", "camera", 2, 1.0, "/tests_per_ray_in_groups/camera"),
    Column("primitives tested", "diffuse", 2, 1.0, "/tests_per_ray_in_groups/diffuse"),
    Column("primitives tested", "shadow", 2, 1.0, "/tests_per_ray_in_groups/shadow"),
    Column("primitives tested", "chord", 2, 1.0, "/tests_per_ray_in_groups/chord"),
];

/// Rays that are handed over at a time.
const GROUP: usize = 64;

const LEGEND: &str = "\
    Mrays/s: millions of rays a second on one thread, caches warm; the median of the rounds, and the quartiles around \
    it. In a round all rows take turns. Modes: single asks ray by ray, the others hand over 1024 rays at a time. Camera \
    rays (primary) come in squares of 8 by 8 pixels; diffuse and shadow rays start where those hit, in their order; \
    chords (random) run between points on a sphere around all. Shadow rays ask for any hit, the others for the \
    closest. a miss: a ray that does not come near the scene's box. Nodes visited and primitives tested are those of \
    single rays; in groups, those that 64 rays fetch together, over the number of rays.";

/// A mode as the command line has it.
pub fn name(mode: Mode) -> String {
    mode.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

/// What is known of a structure: its size, and what rays do in it, one by one and in groups.
pub fn structure(built: &Built, scene: &Scene<'_>, rays: &Rays) -> Value {
    let bytes = built.blob.len();
    let mut facts = json!({
        "kind": built.name, "bytes": bytes, "build_seconds": built.seconds,
        "bytes_per_primitive": bytes as f64 / f64::from(scene.len().max(1)),
    });
    for (i, (kind, rays)) in KINDS.iter().zip(&rays.kinds).enumerate() {
        let steps =
            |ray: &Ray| if i == SHADOW { scene.any_hit_counted(ray).1 } else { scene.closest_hit_counted(ray).1 };
        let add = |sum: [u64; 2], ray| {
            let steps = steps(ray);
            [sum[0] + u64::from(steps.nodes), sum[1] + u64::from(steps.prims)]
        };
        let [nodes, tests] = rays.iter().fold([0; 2], add);
        let [group_nodes, group_tests] = rays.chunks(GROUP).fold([0; 2], |sum, rays| grouped(scene, rays, i, sum));
        for (name, sum) in [
            ("nodes_per_ray", nodes),
            ("tests_per_ray", tests),
            ("nodes_per_ray_in_groups", group_nodes),
            ("tests_per_ray_in_groups", group_tests),
        ] {
            facts[name][kind] = json!((!rays.is_empty()).then(|| sum as f64 / rays.len() as f64));
        }
    }
    facts
}

/// Adds the nodes and tests of a group of rays of a kind.
fn grouped(scene: &Scene<'_>, rays: &[Ray], kind: usize, sum: [u64; 2]) -> [u64; 2] {
    let (mut hits, mut any) = ([None; GROUP], [false; GROUP]);
    let steps = if kind == SHADOW {
        scene.any_hits_counted(rays, &mut any)
    } else {
        scene.closest_hits_counted(rays, &mut hits)
    };
    [sum[0] + u64::from(steps.nodes), sum[1] + u64::from(steps.prims)]
}

/// How fast a way is.
pub fn way(way: &Way<'_>, times: Rounds) -> Value {
    let mut facts = json!({ "kind": way.structure, "lanes": way.lanes, "mode": name(way.mode) });
    for (kind, times) in KINDS.iter().zip(times.kinds) {
        facts["mrays_per_second"][kind] = spread(times.iter().map(|ns| 1e3 / ns.max(1e-6)).collect());
    }
    facts["miss_nanoseconds"] = spread(times.away);
    facts
}

/// Median and quartiles, or null where there is nothing.
fn spread(mut numbers: Vec<f64>) -> Value {
    if numbers.is_empty() {
        return Value::Null;
    }
    let median = super::super::median(&mut numbers);
    let n = numbers.len();
    json!({ "median": median, "lower_quartile": numbers[n / 4], "upper_quartile": numbers[n - 1 - n / 4] })
}

/// The tables.
pub fn text(facts: &Value) -> String {
    let mut text = String::new();
    for file in list(&facts["files"]) {
        let label = |row: &Value, keys: &[&str]| {
            let parts: Vec<&str> = keys.iter().map(|key| row[key].as_str().unwrap_or("-")).collect();
            parts.join(" ")
        };
        let (ways, structures) = (list(&file["ways"]), list(&file["structures"]));
        let names: Vec<String> = ways.iter().map(|row| label(row, &["kind", "lanes", "mode"])).collect();
        let kinds: Vec<String> = structures.iter().map(|row| label(row, &["kind"])).collect();
        text = text + &caption(file, facts, names.len()) + "\n\nMrays/s\n";
        text = text + &aligned("structure lanes mode", &names, ways, &SPEEDS) + "\n\nWork per ray\n";
        text = text + &aligned("structure", &kinds, structures, &WORK) + "\n\nWork per ray in groups\n";
        text = text + &aligned("structure", &kinds, structures, &GROUPED) + "\n\n";
    }
    text + &wrapped(LEGEND, 110)
}

/// What was done.
fn caption(file: &Value, facts: &Value, ways: usize) -> String {
    let counts: Vec<String> = KINDS.iter().map(|kind| format!("{} {kind}", file["rays"][kind])).collect();
    let (name, prims, rays) = (file["file"].as_str().unwrap_or(""), &file["primitives"], counts.join(", "));
    let (rounds, all) = (&facts["rounds"], "Every answer of every row was the same, bit for bit.");
    wrapped(&format!("{name}: {prims} primitives; rays: {rays}; {ways} rows, {rounds} rounds. {all}"), 110)
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

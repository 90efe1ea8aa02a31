//! Tables and JSON.
use crate::rays::SETS;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write;

#[derive(Clone, Copy, Default)]
pub struct Bad {
    /// Hit on one side, miss on the other.
    pub miss: usize,
    /// Both hit, but the distances differ by more than 1e-3 of the scene's diagonal.
    pub t: usize,
    /// Of those, how many the f64 reference gives as this peer does, and not as the judge does. Only ours are asked.
    pub upheld: usize,
    /// And how many lie so close to an edge that f64 can not tell, either.
    pub undecided: usize,
}

impl Bad {
    /// Answers that are wrong, as far as is known.
    fn wrong(self) -> usize {
        self.miss + self.t - self.upheld - self.undecided
    }
}

#[derive(Clone, Copy)]
pub struct Cell {
    pub mrays: f64,
    pub ratio: f64,
    pub ratio_lo: f64,
    pub ratio_hi: f64,
    pub bad: Bad,
    pub checked: usize,
}

pub struct Row {
    pub peer: String,
    pub build_ms: f64,
    pub bytes_per_tri: Option<f64>,
    /// Nanoseconds per closest-hit ray that misses the scene's bounding box.
    pub miss_ns: f64,
    pub cells: [Option<Cell>; 4],
}

pub struct SetInfo {
    pub name: String,
    pub rays: usize,
    pub hits: usize,
}

pub struct SceneResult {
    pub scene: String,
    pub triangles: usize,
    pub sets: Vec<SetInfo>,
    pub rows: Vec<Row>,
}

pub fn table(r: &SceneResult) -> String {
    let mut s = String::new();
    writeln!(s, "### {} - {} triangles", r.scene, r.triangles).unwrap();
    let l: Vec<String> = r
        .sets
        .iter()
        .map(|x| format!("{} {} rays, {:.1}% hit", x.name, x.rays, 100.0 * x.hits as f64 / x.rays.max(1) as f64))
        .collect();
    writeln!(s, "{}", l.join("; ")).unwrap();
    write!(s, "{:24} {:>9} {:>6} {:>7} ", "peer", "build ms", "B/tri", "miss ns").unwrap();
    for n in SETS {
        write!(s, "| {:>7} {:>6} {:>7} ", n, "ratio", "wrong").unwrap();
    }
    writeln!(s).unwrap();
    for row in &r.rows {
        let b = row.bytes_per_tri.map_or("?".into(), |b| format!("{b:.0}"));
        write!(s, "{:24} {:>9.1} {:>6} {:>7.1} ", row.peer, row.build_ms, b, row.miss_ns).unwrap();
        for c in &row.cells {
            match c {
                Some(c) => write!(s, "| {:>7.2} {:>6.2} {:>7} ", c.mrays, c.ratio, wrong(c, r, row)).unwrap(),
                None => write!(s, "| {:>7} {:>6} {:>7} ", "-", "-", "-").unwrap(),
            }
        }
        writeln!(s).unwrap();
    }
    writeln!(s, "(miss ns: per ray that misses the bounding box; Mrays/s: median over rounds; ratio: to the first row in the same\nround, median; wrong: rays whose hit/miss or distance differs from the robust row, '~' = the set was only checked in part; of ours without\nthose in which all triangles in f64 do not side with that row)").unwrap();
    s += &disputes(r);
    s.push('\n');
    s
}

fn wrong(c: &Cell, r: &SceneResult, row: &Row) -> String {
    let set = row.cells.iter().position(|x| x.as_ref().is_some_and(|x| std::ptr::eq(x, c))).unwrap_or(0);
    let part = c.checked + 256 < r.sets[set].rays;
    format!("{}{}", if part { "~" } else { "" }, c.bad.wrong())
}

/// What became of the rays on which a peer of ours and the judge differ.
fn disputes(r: &SceneResult) -> String {
    let mut s = String::new();
    for row in r.rows.iter().filter(|row| row.peer.starts_with("flashray")) {
        let bad: Vec<Bad> = row.cells.iter().flatten().map(|c| c.bad).collect();
        let sum = |f: fn(&Bad) -> usize| bad.iter().map(f).sum::<usize>();
        let (all, upheld, undecided) = (sum(|b| b.miss + b.t), sum(|b| b.upheld), sum(|b| b.undecided));
        let wrong = all - upheld - undecided;
        writeln!(s, "{}: differs from the robust row in {all} rays; all triangles in f64 side with it in {upheld}, against it in {wrong}, and can not tell in {undecided}", row.peer).unwrap();
    }
    s
}

/// Geometric means of the ratios over all scenes, and the fastest peer of every column.
pub fn summary(all: &[SceneResult]) -> String {
    let mut s = String::new();
    let mut names: Vec<&str> = vec![];
    for r in all.iter().flat_map(|r| &r.rows) {
        if !names.contains(&r.peer.as_str()) {
            names.push(&r.peer);
        }
    }
    writeln!(s, "### geometric mean of the ratios over {} scenes (in brackets: scenes, if not all)", all.len())
        .unwrap();
    write!(s, "{:24}", "peer").unwrap();
    for n in SETS {
        write!(s, " {n:>11}").unwrap();
    }
    writeln!(s, " {:>11} {:>11}", "wrong/1e6", "B/tri").unwrap();
    for n in &names {
        let rows: Vec<&Row> = all.iter().flat_map(|r| &r.rows).filter(|r| r.peer == *n).collect();
        write!(s, "{n:24}").unwrap();
        for k in 0..4 {
            let v: Vec<f64> =
                rows.iter().filter_map(|r| r.cells[k].map(|c| c.ratio)).filter(|x| x.is_finite()).collect();
            if v.is_empty() {
                write!(s, " {:>11}", "-").unwrap();
                continue;
            }
            let g = (v.iter().map(|x| x.ln()).sum::<f64>() / v.len() as f64).exp();
            let few = if v.len() < all.len() { format!("({})", v.len()) } else { String::new() };
            write!(s, " {:>11}", format!("{few}{g:.2}")).unwrap();
        }
        let (bad, n) = rows
            .iter()
            .flat_map(|r| r.cells.iter().flatten())
            .fold((0, 0), |a, c| (a.0 + c.bad.wrong(), a.1 + c.checked));
        let b: Vec<f64> = rows.iter().filter_map(|r| r.bytes_per_tri).collect();
        let bt = if b.is_empty() { "?".into() } else { format!("{:.0}", b.iter().sum::<f64>() / b.len() as f64) };
        writeln!(s, " {:>11.2} {bt:>11}", bad as f64 * 1e6 / n.max(1) as f64).unwrap();
    }
    writeln!(s, "\n### fastest per scene and ray set (single-ray calls | anything)").unwrap();
    for r in all {
        write!(s, "{:18}", r.scene).unwrap();
        for k in 0..4 {
            let top = |f: &dyn Fn(&str) -> bool| {
                r.rows
                    .iter()
                    .filter(|x| f(&x.peer))
                    .filter_map(|x| x.cells[k].map(|c| (c.mrays, x.peer.clone())))
                    .filter(|x| x.0.is_finite())
                    .max_by(|a, b| a.0.total_cmp(&b.0))
            };
            let single = |n: &str| !["-p8", "-p16", "stream", "packet"].iter().any(|x| n.contains(x));
            let f = |x: Option<(f64, String)>| x.map_or("-".into(), |(m, n)| format!("{n} {m:.2}"));
            write!(s, "  {}: {} | {}", SETS[k], f(top(&single)), f(top(&|_| true))).unwrap();
        }
        writeln!(s).unwrap();
    }
    s
}

pub fn to_json(
    all: &[SceneResult],
    info: &BTreeMap<String, String>,
    naive: Option<Value>,
    reference: &str,
    judge: &str,
) -> Value {
    let num = |x: f64| if x.is_finite() { json!((x * 1e4).round() / 1e4) } else { Value::Null };
    let scenes: Vec<Value> = all
        .iter()
        .map(|r| {
            let rows: Vec<Value> = r
                .rows
                .iter()
                .map(|w| {
                    let mut sets = serde_json::Map::new();
                    for (k, c) in w.cells.iter().enumerate() {
                        if let Some(c) = c {
                            sets.insert(
                                SETS[k].into(),
                                json!({"mrays": num(c.mrays), "ratio": num(c.ratio), "ratio_quartiles": [num(c.ratio_lo), num(c.ratio_hi)],
                                       "wrong_hit_miss": c.bad.miss, "wrong_distance": c.bad.t, "upheld": c.bad.upheld, "undecided": c.bad.undecided, "checked": c.checked}),
                            );
                        }
                    }
                    json!({"peer": w.peer, "build_ms": num(w.build_ms), "bytes_per_triangle": w.bytes_per_tri.map(num), "miss_ns": num(w.miss_ns), "sets": sets})
                })
                .collect();
            let sets: Vec<Value> = r.sets.iter().map(|x| json!({"name": x.name, "rays": x.rays, "hits": x.hits})).collect();
            json!({"scene": r.scene, "triangles": r.triangles, "ray_sets": sets, "peers": rows})
        })
        .collect();
    json!({"reference": reference, "judge": judge, "threads": 1, "peers": info, "scenes": scenes, "naive": naive})
}

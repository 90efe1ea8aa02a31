//! The tables of a page, out of the JSON of one or more runs.
use crate::rays::SETS;
use serde_json::Value;
use std::fmt::Write as _;

const BEGIN: &str = "<!-- peers -->";
const END: &str = "<!-- end of peers -->";

/// All scenes of some runs.
struct Runs {
    scenes: Vec<Value>,
    reference: String,
    judge: String,
    /// What the reference is.
    info: String,
}

/// Puts the tables between the two marks of the page.
pub fn fill(page: &str, runs: &[String]) {
    let old = std::fs::read_to_string(page).unwrap_or_else(|e| panic!("{page}: {e}"));
    let (head, rest) = old.split_once(BEGIN).unwrap_or_else(|| panic!("{page}: no {BEGIN}"));
    let (_, tail) = rest.split_once(END).unwrap_or_else(|| panic!("{page}: no {END}"));
    let text = Runs::read(runs).text();
    std::fs::write(page, format!("{head}{BEGIN}\n{text}{END}{tail}")).unwrap_or_else(|e| panic!("{page}: {e}"));
}

/// The geometric mean, if there is anything.
fn mean(numbers: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, n) = numbers.filter(|x| *x > 0.0).fold((0.0, 0), |(sum, n), x| (sum + x.ln(), n + 1));
    (n > 0).then(|| (sum / f64::from(n)).exp())
}

/// A peer of a scene.
fn row<'a>(scene: &'a Value, peer: &str) -> Option<&'a Value> {
    scene["peers"].as_array()?.iter().find(|row| row["peer"] == peer)
}

fn ratio(scene: &Value, peer: &str, set: &str) -> Option<f64> {
    row(scene, peer)?["sets"][set]["ratio"].as_f64()
}

impl Runs {
    fn read(paths: &[String]) -> Self {
        let read = |path: &String| -> Value {
            let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{path}: {e}"));
            serde_json::from_str(&text).unwrap_or_else(|e| panic!("{path}: {e}"))
        };
        let runs: Vec<Value> = paths.iter().map(read).collect();
        let text = |key: &str| runs.first().and_then(|run| run[key].as_str()).unwrap_or("").to_owned();
        let (reference, judge) = (text("reference"), text("judge"));
        assert!(runs.iter().all(|run| run["reference"] == reference.as_str()), "runs with different references");
        let info = runs.first().and_then(|run| run["peers"][&reference].as_str()).unwrap_or("").to_owned();
        let scenes = runs.iter().flat_map(|run| run["scenes"].as_array().cloned().unwrap_or_default()).collect();
        Self { scenes, reference, judge, info }
    }

    /// Every peer, in the order of the first scene that has it.
    fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = vec![];
        for peer in self.scenes.iter().filter_map(|scene| scene["peers"].as_array()).flatten() {
            let name = peer["peer"].as_str().unwrap_or("").to_owned();
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }

    fn text(&self) -> String {
        let names: Vec<String> = self.scenes.iter().filter_map(|s| s["scene"].as_str()).map(str::to_owned).collect();
        let cpu = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let cpu = cpu.lines().find(|l| l.starts_with("model name")).and_then(|l| l.split(": ").nth(1)).unwrap_or("?");
        let tunables = std::env::var("GLIBC_TUNABLES").unwrap_or_default();
        let pages = if tunables.contains("malloc.hugetlb=1") { " The memory of all is in huge pages." } else { "" };
        let mut s = String::new();
        let version: String = self.info.split_whitespace().take(2).collect::<Vec<_>>().join(" ");
        let _ = writeln!(
            s,
            "Ratios of speed to `{}` ({version}, one ray a call) on one core of an `{cpu}`: geometric means over {} scenes \
             ({}), each the median of rounds in which all take turns on the same rays. Ours is built with the default \
             flags, the others for this very machine.{pages}\n",
            self.reference,
            names.len(),
            names.join(", ")
        );
        let _ = writeln!(
            s,
            "| | {} | bytes per triangle | build, ns per triangle | a miss, ns | wrong per million |",
            SETS.join(" | ")
        );
        let _ = writeln!(s, "|---|{}---|---|---|---|", "---|".repeat(SETS.len()));
        for name in self.names() {
            self.line(&mut s, &format!("`{name}`"), &[name]);
        }
        let obvhs: Vec<String> = self.names().into_iter().filter(|name| name.starts_with("obvhs")).collect();
        if !obvhs.is_empty() {
            self.line(&mut s, "obvhs, the best of its rows", &obvhs);
        }
        let _ = writeln!(
            s,
            "\nWrong: hit or miss, or the distance by more than a thousandth of the scene, is not as by `{}`; of our rows only \
             where all triangles in f64 side with it.\n",
            self.judge
        );
        self.scene_table(&mut s, "flashray-wide");
        self.scene_table(&mut s, "flashray-wide-group");
        s
    }

    /// A line of one peer, or of the best of several.
    fn line(&self, s: &mut String, title: &str, names: &[String]) {
        let best = |scene: &Value, set: &str| names.iter().filter_map(|n| ratio(scene, n, set)).fold(0.0, f64::max);
        let cells = SETS.map(|set| mean(self.scenes.iter().map(|scene| best(scene, set))));
        let cell = |x: Option<f64>, digits: usize| x.map_or("-".into(), |x| format!("{x:.digits$}"));
        let rows: Vec<(&Value, f64)> = self
            .scenes
            .iter()
            .flat_map(|scene| names.iter().map(move |name| (scene, name)))
            .filter_map(|(scene, name)| Some((row(scene, name)?, scene["triangles"].as_f64()?)))
            .collect();
        let of = |key: &'static str| rows.iter().filter_map(move |(row, _)| row[key].as_f64());
        let one = names.len() == 1;
        let bytes = mean(of("bytes_per_triangle")).filter(|_| one);
        let build = mean(rows.iter().filter_map(|(row, n)| Some(row["build_ms"].as_f64()? * 1e6 / n))).filter(|_| one);
        let miss = mean(of("miss_ns")).filter(|_| one);
        let sets = rows.iter().filter_map(|(row, _)| row["sets"].as_object()).flat_map(|sets| sets.values());
        let (wrong, checked) = sets.fold((0.0, 0.0), |(wrong, checked), set| {
            let part = |key: &str| set[key].as_f64().unwrap_or(0.0);
            (
                wrong + part("wrong_hit_miss") + part("wrong_distance") - part("upheld") - part("undecided"),
                checked + part("checked"),
            )
        });
        let wrong = (one && checked > 0.0).then(|| wrong / checked * 1e6);
        let ratios: Vec<String> = cells.iter().map(|x| cell(*x, 2)).collect();
        let (ratios, bytes, build) = (ratios.join(" | "), cell(bytes, 0), cell(build, 0));
        let _ = writeln!(s, "| {title} | {ratios} | {bytes} | {build} | {} | {} |", cell(miss, 1), cell(wrong, 1));
    }

    /// Each scene, in ratio to the judge: the class of answer that we give.
    fn scene_table(&self, s: &mut String, name: &str) {
        if !self.names().iter().any(|peer| peer == name) {
            return;
        }
        let _ = writeln!(s, "| `{name}` over `{}` | {} |", self.judge, SETS.join(" | "));
        let _ = writeln!(s, "|---|{}", "---|".repeat(SETS.len()));
        for scene in &self.scenes {
            let over = |set: &str| Some(ratio(scene, name, set)? / ratio(scene, &self.judge, set)?);
            let cells = SETS.map(|set| over(set).map_or("-".into(), |x| format!("{x:.2}")));
            let _ = writeln!(s, "| {} | {} |", scene["scene"].as_str().unwrap_or("?"), cells.join(" | "));
        }
        s.push('\n');
    }
}

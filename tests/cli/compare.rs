//! The comparison, on small scenes.
use super::Folder;
use flashray::blob::KINDS;
use serde_json::Value;
use std::collections::BTreeSet;

/// Every structure and rule that must be there, as rows and files are called.
fn expected() -> Vec<(String, Option<&'static str>)> {
    let rules = |name: &str| if name == "list" { vec![None] } else { vec![Some("seed"), Some("sah")] };
    KINDS.iter().flat_map(|(_, name)| rules(name).into_iter().map(|rule| ((*name).to_owned(), rule))).collect()
}

fn positive(row: &Value, at: &str) {
    assert!(row.pointer(at).and_then(Value::as_f64).is_some_and(|x| x > 0.0), "{at}: {row}");
}

/// Every structure is in the answer, with all its numbers, and equal to the list.
fn assert_whole(facts: &Value, scene: &str, primitives: u64) {
    assert_eq!((&facts["scene"], &facts["primitives"]), (&scene.into(), &primitives.into()));
    let rows = facts["structures"].as_array().expect("an array");
    let found: Vec<_> =
        rows.iter().map(|row| (row["kind"].as_str().unwrap_or("?").to_owned(), row["rule"].as_str())).collect();
    assert_eq!(found, expected());
    for row in rows {
        assert_eq!(row["wrong"], 0, "{row}");
        for at in ["/build_seconds", "/bytes", "/bytes_per_primitive", "/references_per_primitive", "/leaves"] {
            positive(row, at);
        }
        let parts: u64 =
            ["primitive_bytes", "node_bytes", "reference_bytes"].iter().filter_map(|k| row[k].as_u64()).sum();
        let sections: u64 = row["sections"].as_object().expect("sections").values().filter_map(Value::as_u64).sum();
        assert!(parts == sections && parts < row["bytes"].as_u64().unwrap_or(0), "{row}");
        // Who parts space says what lies where.
        let lists = !matches!(row["kind"].as_str(), Some("list" | "bvh" | "sphere" | "wide"));
        assert_eq!(row["reference_bytes"].as_u64().is_some_and(|n| n > 0), lists, "{row}");
        for kind in ["camera", "diffuse", "shadow", "chord"] {
            positive(row, &format!("/mrays_per_second/{kind}"));
            positive(row, &format!("/mrays_per_second_in_groups/{kind}"));
            positive(row, &format!("/over_list/{kind}"));
            for count in ["steps_per_ray", "tests_per_ray", "spared_per_ray"] {
                assert!(row[count][kind].is_f64(), "{count} {kind}: {row}");
            }
        }
    }
    let list = &rows[0];
    assert_eq!(
        (&list["tests_per_ray"]["all"], &list["steps_per_ray"]["all"]),
        (&(primitives as f64).into(), &0.0.into())
    );
    // A shadow ray in the list stops at the first hit, so it needs no more tests than there are primitives.
    assert!(list["tests_per_ray"]["shadow"].as_f64().is_some_and(|tests| 1.0 <= tests && tests <= primitives as f64));
    assert_eq!(list["steps_per_ray"]["shadow"], 0.0);
    assert_eq!(list["over_list"]["camera"], 1.0);
}

#[test]
fn every_structure_is_compared_and_equals_the_list() {
    let folder = Folder::with_cube("compare");
    let before = folder.snapshot();
    let facts = folder.json("compare cube.obj --rays 400 --rounds 1 --json");
    assert_whole(&facts, "cube.obj", 12);
    assert_eq!((&facts["page"], &facts["rounds"]), (&Value::Null, &1.into()));
    assert_eq!((&facts["rays"]["camera"], &facts["rays"]["shadow"]), (&400.into(), &400.into()));
    assert_eq!((&facts["rays_compared"], &facts["rays_compared_with_list"]), (&1600.into(), &1600.into()));
    // Every kind of primitive.
    assert_whole(&folder.json("compare spd:tree:2 --rays 300 --rounds 2 --leaf 2 --json"), "spd:tree:2", 16);
    assert_whole(&folder.json("compare spd:lattice:1 --rays 16 --rounds 1 --json"), "spd:lattice:1", 20);
    folder.assert_is(&before, "compare without a folder");
}

#[test]
fn the_table_names_every_structure() {
    let folder = Folder::with_cube("compare-table");
    let table = folder.ok("compare cube.obj --rays 100 --rounds 1");
    for (name, rule) in expected() {
        let label = format!("{name} {}", rule.unwrap_or("")).trim_end().to_owned();
        let rows: Vec<&str> = table.lines().filter(|line| line.starts_with(&format!("{label} "))).collect();
        assert!(rows.len() == 3 && rows[1].ends_with(" 0"), "{label}: {table}");
    }
    for title in ["What is built", "Work per ray", "Speed on one thread"] {
        let lines = table.lines().skip_while(|line| *line != title).skip(1).take_while(|line| !line.is_empty());
        let widths: Vec<usize> = lines.map(str::len).collect();
        assert_eq!(widths.len(), expected().len() + 2, "{title}: {table}");
        assert!(widths.iter().all(|&width| width == widths[0] && width < 140), "{title}: {table}");
    }
    assert!(table.lines().all(|line| line.len() < 140), "{table}");
}

#[test]
fn the_page_and_the_pictures_are_written_whole() {
    let folder = Folder::with_cube("compare-page");
    for (scene, options) in
        [("cube.obj", ""), ("spd:tree:2", "--slice x --at 0.6"), ("spd:balls:1", "--slice y --at 1")]
    {
        let facts = folder.json(&format!("compare {scene} -o deep/er --rays 64 --rounds 1 --json {options}"));
        assert_eq!(facts["page"], "deep/er/index.html");
        let page = super::text(&folder.get("deep/er/index.html"));
        let outside = page.replace("http://www.w3.org/2000/svg", "");
        for word in ["http:", "https:", "src=", "href=", "<script", "url(", "@import"] {
            assert!(!outside.contains(word), "{word} in the page of {scene}");
        }
        assert!(page.starts_with("<!doctype html>") && page.ends_with("</html>\n") && page.contains(scene));
        assert!(page.contains("prefers-color-scheme:dark") && page.len() < 3_000_000);
        let mut names = BTreeSet::from(["index.html".to_owned()]);
        for (name, rule) in expected() {
            let file = rule.map_or(format!("{name}.svg"), |rule| format!("{name}-{rule}.svg"));
            let svg = super::text(&folder.get(&format!("deep/er/{file}")));
            assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"), "{file} of {scene}");
            for tag in ["svg", "text", "title", "style"] {
                let (opened, closed) = (format!("<{tag}"), format!("</{tag}>"));
                assert_eq!(svg.matches(&opened).count(), svg.matches(&closed).count(), "{tag} in {file} of {scene}");
            }
            assert!(!svg.contains("NaN") && !svg.contains("inf "), "{file} of {scene}");
            // What it is, what the ray does, and what the marks mean.
            let said = ["Cut at ", " the ray tests ", "node or cell", "looked into", "Numbers: "];
            assert!(said.iter().all(|text| svg.contains(text)), "{file} of {scene}");
            let (first, none) = (svg.contains(">1<") || svg.contains(">1-"), svg.contains(", in 0 steps"));
            assert!(first != none && (none || name != "list"), "a first step in {file} of {scene}");
            assert!(name != "sphere" || svg.contains("0 1 0"), "spheres are circles: {file} of {scene}");
            assert!(page.contains(svg.trim_end()), "{file} is not in the page of {scene}");
            names.insert(file);
        }
        let found = std::fs::read_dir(folder.path("deep/er")).expect("a folder");
        let found: BTreeSet<String> =
            found.map(|e| e.expect("an entry").file_name().to_string_lossy().into()).collect();
        assert_eq!(found, names);
    }
}

#[test]
fn the_page_has_tables_and_plots_with_axes() {
    let folder = Folder::with_cube("compare-plots");
    folder.ok("compare cube.obj -o page --rays 64 --rounds 1");
    let page = super::text(&folder.get("page/index.html"));
    assert_eq!(page.matches("<table>").count(), 3);
    assert_eq!(page.matches("class=\"chart\"").count(), 4);
    for unit in
        ["millions of rays a second", "bytes per primitive", "nodes and cells visited per ray", "primitives tested"]
    {
        assert!(page.contains(&format!(">{unit}")), "no axis tells of {unit}");
    }
}

#[test]
fn pictures_are_as_large_as_what_is_in_them() {
    let folder = Folder::new("compare-crop");
    folder.ok("compare spd:teapot:2 --slice y -o page --rays 64 --rounds 1");
    let sides = |file: &str| -> [f64; 2] {
        let svg = super::text(&folder.get(&format!("page/{file}.svg")));
        ["width", "height"].map(|side| {
            let number = svg.split(&format!(" {side}=\"")).nth(1).and_then(|rest| rest.split('"').next());
            number.and_then(|n| n.parse().ok()).expect("a number")
        })
    };
    let ([wide, low], [same, high]) = (sides("bvh-sah"), sides("octree-seed"));
    // The teapot is flat; an octree's cube is as high as it is wide.
    assert!(low < wide * 0.7 && wide == same && high > wide, "{low} {wide} {same} {high}");
}

#[test]
fn scenes_of_any_scale_are_drawn() {
    let folder = Folder::new("compare-scale");
    for (name, scale) in [("tiny", "1e-30"), ("huge", "1e30"), ("flat", "0")] {
        let corner = |x: &str, y: &str| format!("v {x} {y} {}\n", if name == "flat" { "0" } else { y });
        let corners = corner("0", "0") + &corner(scale, "0") + &corner("1e-30", scale);
        folder.put(&format!("{name}.obj"), corners + "f 1 2 3\n");
    }
    // A point away from 0: no ray meets it, and all counts are 0.
    folder.put("point.obj", "v 1 2 3\nf 1 1 1\n");
    for name in ["tiny", "huge", "flat", "point"] {
        folder.ok(&format!("compare {name}.obj -o {name} --rays 64 --rounds 1"));
        // All the pictures are in the page, and the plots.
        let page = super::text(&folder.get(&format!("{name}/index.html")));
        assert!(!page.contains("NaN") && !page.contains("inf"), "{name}: {page}");
        let longest = page.split(|c: char| !c.is_ascii_digit()).map(str::len).max();
        assert!(longest < Some(20), "{name}: a number of {longest:?} digits");
    }
}

#[test]
fn what_can_not_be_compared_is_said_in_a_line() {
    let folder = Folder::with_cube("compare-bad");
    folder.put("bad.obj", "v 1 2\n");
    folder.fails("compare nosuch.obj", &["flashray: nosuch.obj: no such file"]);
    folder.fails("compare bad.obj", &["flashray: bad.obj: "]);
    folder.put("empty.obj", "");
    folder.fails("compare empty.obj", &["flashray: empty.obj: "]);
    // No folder is made for what can not be read.
    folder.fails("compare nosuch.obj -o page", &["flashray: nosuch.obj: no such file"]);
    folder.fails("compare bad.obj -o page", &["flashray: bad.obj: "]);
    folder.fails("compare empty.obj -o page", &["flashray: empty.obj: "]);
    assert!(!folder.path("page").exists());
    folder.fails("compare spd:nosuch", &["flashray: spd:nosuch: no such scene"]);
    folder.fails("compare spd:balls:99", &["flashray: spd:balls:99: size must be"]);
    folder.fails("compare cube.obj --rays 16 --rounds 1 -o cube.obj", &["flashray: cube.obj: is not a folder"]);
    folder.fails("compare cube.obj --rays 16 --rounds 1 -o cube.fray/deep", &["flashray: cube.fray/deep: "]);
    std::fs::create_dir_all(folder.path("taken/index.html")).expect("a folder");
    folder.fails("compare cube.obj --rays 16 --rounds 1 -o taken", &["taken/index.html: is a directory"]);
    assert_eq!(std::fs::read_dir(folder.path("taken")).expect("a folder").count(), 1, "nothing else is written");
}

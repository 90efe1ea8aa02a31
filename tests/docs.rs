//! What the documents say is what the code does.
use flashray::blob::{Entry, Header, KINDS, Rule, Section};
use flashray::bvh::Node;
use std::fs;
use std::mem::offset_of;
use std::path::Path;

fn read(path: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).expect(path)
}

/// The cells of every table row.
fn rows(text: &str) -> Vec<Vec<&str>> {
    text.lines()
        .filter(|l| l.trim_start_matches("//!").trim().starts_with('|'))
        .map(|l| l.trim_start_matches("//!").trim().trim_matches('|').split('|').map(str::trim).collect())
        .collect()
}

#[test]
fn the_format_s_rules_are_the_code_s() {
    let text = read("docs/format.md");
    let rows = rows(&text);
    for rule in Rule::ALL {
        let row = vec![rule.number().to_string(), rule.text().to_string()];
        assert!(rows.iter().any(|r| *r == row), "rule {} is not in docs/format.md as `{}`", row[0], row[1]);
    }
    let last = rows.iter().filter(|r| r.len() == 2 && r[0].parse::<u8>().is_ok()).count();
    assert_eq!(last, Rule::ALL.len(), "docs/format.md has rules that the code lacks");
}

#[test]
fn the_format_s_tables_are_the_code_s() {
    let text = read("docs/format.md");
    let rows = rows(&text);
    let has = |offset: usize, size: usize, field: &str| {
        let field = format!("`{field}`");
        let found = rows
            .iter()
            .any(|r| r.len() == 4 && r[2] == field && r[0] == offset.to_string() && r[1] == size.to_string());
        assert!(found, "{field} at {offset}, {size} bytes, is not in docs/format.md");
    };
    has(offset_of!(Header, magic), 4, "magic");
    has(offset_of!(Header, version), 4, "version");
    has(offset_of!(Header, length), 4, "length");
    has(offset_of!(Header, checksum), 4, "checksum");
    has(offset_of!(Header, kind), 4, "kind");
    has(offset_of!(Header, prims), 4, "prims");
    has(offset_of!(Header, stack), 4, "stack");
    has(offset_of!(Header, steps), 4, "steps");
    has(offset_of!(Header, bounds), 24, "bounds");
    has(offset_of!(Header, local), 12, "local");
    has(offset_of!(Header, sections), 4, "sections");
    has(offset_of!(Header, longest), 4, "longest");
    has(offset_of!(Header, reserved), 4, "reserved");
    has(offset_of!(Node, planes), 48, "planes");
    has(offset_of!(Node, child), 8, "child");
    has(offset_of!(Node, reserved), 8, "reserved");
}

#[test]
fn the_format_s_sections_and_kinds_are_the_code_s() {
    let text = read("docs/format.md");
    let rows = rows(&text);
    assert!(text.contains(&format!("## Section table: {} bytes an entry", size_of::<Entry>())));
    let sizes = [
        (Section::Triangles, size_of::<flashray::Triangle>()),
        (Section::Spheres, size_of::<flashray::Sphere>()),
        (Section::Boxes, size_of::<flashray::Aabb>()),
        (Section::Cylinders, size_of::<flashray::Cylinder>()),
        (Section::Cones, size_of::<flashray::Cone>()),
        (Section::Refs, 4),
        (Section::Ids, 4),
        (Section::Blocks, size_of::<flashray::blob::block::Block>()),
        (Section::BvhNodes, size_of::<Node>()),
        (Section::GridShape, size_of::<flashray::grid::Shape>()),
        (Section::CellStarts, 4),
        (Section::CellLists, 4),
        (Section::VoxelTable, size_of::<flashray::voxel::Table>()),
        (Section::VoxelBits, 4),
        (Section::VoxelIndex, 4),
        (Section::VoxelStarts, 4),
        (Section::VoxelLists, 4),
        (Section::NestedGrids, size_of::<flashray::nested::Grid>()),
        (Section::NestedCells, 4),
        (Section::OctreeNodes, size_of::<flashray::octree::Node>()),
        (Section::BspNodes, size_of::<flashray::bsp::Node>()),
        (Section::SphereNodes, size_of::<flashray::sphere::Node>()),
        (Section::WideNodes, size_of::<flashray::wide::Node>()),
        (Section::Wide4Nodes, size_of::<flashray::wide::Node<4>>()),
    ];
    assert_eq!(sizes.map(|(s, _)| s), Section::LISTED);
    for (section, size) in sizes {
        let cells = [section.number().to_string(), section.name().into(), size.to_string()];
        assert!(rows.iter().any(|r| r.len() == 4 && r[..3] == cells), "{cells:?} is not in docs/format.md");
    }
    for &(kind, name) in KINDS {
        assert!(text.contains(&format!("{} {name}", kind.number())), "kind {name} is not in docs/format.md");
        assert_eq!(kind.name(), name);
    }
}

#[test]
fn tables_in_the_source_are_those_of_the_format() {
    let text = read("docs/format.md");
    let format = rows(&text);
    for path in [
        "src/blob/header.rs",
        "src/bvh/mod.rs",
        "src/grid/mod.rs",
        "src/voxel/mod.rs",
        "src/nested/mod.rs",
        "src/octree/mod.rs",
        "src/bsp/mod.rs",
        "src/sphere/mod.rs",
        "src/wide/mod.rs",
    ] {
        let source = read(path);
        let table: Vec<_> = rows(&source).into_iter().filter(|r| r.len() == 4 && r[0].parse::<u32>().is_ok()).collect();
        assert!(table.len() >= 2, "{path} has its table");
        for row in table {
            assert!(format.contains(&row), "{path}: {row:?} is not in docs/format.md");
        }
    }
}

#[test]
fn the_readme_s_example_is_the_quickstart_s_and_its_commands_exist() {
    let readme = read("README.md");
    let quickstart = read("examples/quickstart.rs");
    let example = readme.split("```rust").nth(1).and_then(|rest| rest.split("```").next()).expect("an example");
    let code = |text: &str| -> Vec<String> {
        let lines = text.lines().map(str::trim).filter(|l| !l.is_empty() && !l.starts_with("//"));
        lines.map(str::to_owned).collect()
    };
    let (example, quickstart) = (code(example), code(&quickstart));
    assert_eq!(example, quickstart, "the README's example is not examples/quickstart.rs");
    let ci = read(".ci/run");
    assert!(readme.contains("cargo test --features cli"), "the README names the test command");
    assert!(ci.contains("cargo test --locked --features cli"), "CI runs the README's test command");
}

#[test]
fn every_structure_is_explained_with_pictures() {
    let text = read("docs/structures.md");
    for &(_, name) in KINDS {
        assert!(text.contains(&format!("\n## {name}\n")), "docs/structures.md does not explain {name}");
        let files = if name == "list" {
            vec!["list.svg".into()]
        } else {
            vec![format!("{name}-seed.svg"), format!("{name}-sah.svg")]
        };
        for file in files {
            assert!(text.contains(&format!("(img/slices/{file})")), "docs/structures.md does not show {file}");
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/img/slices").join(&file);
            let bytes = fs::metadata(path)
                .unwrap_or_else(|_| panic!("no docs/img/slices/{file}: run benches/structures.sh"))
                .len();
            assert!(bytes < 60_000, "{file} has {bytes} bytes");
        }
    }
}

//! The demonstration, with few rays.
use super::Folder;
use crate::spd;
use flashray::Scene;
use flashray::blob::Buffer;
use std::collections::BTreeSet;

#[test]
fn the_demo_shows_every_scene_and_finds_no_wrong_answer() {
    let folder = Folder::new("demo");
    let facts = folder.json("demo -o deep/er --rays 400 --json");
    assert_eq!(facts["picture"], "deep/er/contact-sheet.png");
    let scenes = facts["scenes"].as_array().expect("an array");
    assert_eq!(scenes.len(), spd::NAMES.len());
    let mut expected = BTreeSet::from(["contact-sheet.png".to_string()]);
    for (name, facts) in spd::NAMES.iter().zip(scenes) {
        assert!(facts["scene"].as_str().is_some_and(|s| s.starts_with(name)), "{facts}");
        assert_eq!(facts["wrong"], 0, "{facts}");
        assert_eq!(facts["rays"], 400, "{facts}");
        let file = format!("{name}.fray");
        let bytes = Buffer::from(&folder.get(&format!("deep/er/{file}"))[..]);
        let scene = Scene::from_bytes(&bytes).expect("a good blob");
        assert_eq!((&facts["primitives"], &facts["bytes"]), (&scene.len().into(), &bytes.len().into()));
        for number in ["bytes_per_primitive", "nodes", "depth", "sah_cost", "build_seconds", "mrays_per_second"] {
            assert!(facts[number].as_f64().is_some_and(|x| x > 0.0), "{name}: {number}: {facts}");
        }
        expected.insert(file);
    }
    let found = std::fs::read_dir(folder.path("deep/er")).expect("a folder");
    let found: BTreeSet<String> = found.map(|e| e.expect("an entry").file_name().to_string_lossy().into()).collect();
    assert_eq!(found, expected);
    let png = folder.get("deep/er/contact-sheet.png");
    let reader = png::Decoder::new(std::io::Cursor::new(&png[..])).read_info().expect("a PNG header");
    // Four tiles of 320 a row with gaps of 6, and three rows.
    assert_eq!((reader.info().width, reader.info().height), (4 * 326 + 6, 3 * 326 + 6));
}

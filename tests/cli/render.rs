//! Pictures: what they show depends on what was asked.
use super::Folder;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Width, height and pixels of a PNG file.
struct Picture(u32, u32, Vec<[u8; 3]>);

impl Picture {
    fn decode(bytes: &[u8]) -> Self {
        assert_eq!(bytes[..8], *b"\x89PNG\r\n\x1a\n");
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().expect("a PNG header");
        let mut pixels = vec![0; reader.output_buffer_size().expect("a picture of some size")];
        let frame = reader.next_frame(&mut pixels).expect("a PNG picture");
        assert_eq!((frame.color_type, frame.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
        Self(frame.width, frame.height, pixels.as_chunks().0.to_vec())
    }

    fn colors(&self) -> BTreeSet<[u8; 3]> {
        self.2.iter().copied().collect()
    }

    fn at(&self, x: u32, y: u32) -> [u8; 3] {
        self.2[(y * self.0 + x) as usize]
    }
}

/// Renders and decodes.
fn render(folder: &Folder, options: &str) -> Picture {
    let said = folder.ok(&format!("render cube.fray -o cube.png {options}"));
    assert!(said.starts_with("cube.png: "), "{said}");
    Picture::decode(&folder.get("cube.png"))
}

/// The cube's front, straight on, 33 pixels wide and high, one sample each.
const FRONT: &str = "--shade ids --size 33x33 --samples 1 --from 0,0,5 --at 0,0,0";

#[test]
fn sizes_are_as_asked() {
    let folder = Folder::with_cube("render-size");
    for (size, expected) in [("40x30", (40, 30)), ("1x1", (1, 1)), ("7x64", (7, 64))] {
        let picture = render(&folder, &format!("--size {size}"));
        assert_eq!((picture.0, picture.1, picture.2.len() as u32), (expected.0, expected.1, expected.0 * expected.1));
    }
    let picture = render(&folder, "--samples 1");
    assert_eq!((picture.0, picture.1), (1024, 768));
}

#[test]
fn shades_differ_and_repeat() {
    let folder = Folder::with_cube("render-shades");
    let pictures = ["normals", "depth", "ids", "heat"].map(|shade| {
        render(&folder, &format!("--size 40x30 --shade {shade}"));
        let first = folder.get("cube.png");
        render(&folder, &format!("--size 40x30 --shade {shade}"));
        assert!(first == folder.get("cube.png"), "{shade}: two pictures differ");
        assert!(Picture::decode(&first).colors().len() > 2, "{shade}: next to nothing to see");
        first
    });
    assert_eq!(pictures.iter().collect::<BTreeSet<_>>().len(), 4);
    render(&folder, "--size 40x30");
    assert!(folder.get("cube.png") == pictures[0], "normals is the default");
    let rough = render(&folder, "--size 40x30 --samples 1");
    assert!(rough.2 != Picture::decode(&pictures[0]).2, "--samples changes nothing");
}

#[test]
fn the_front_of_the_cube_is_where_it_should_be() {
    let folder = Folder::with_cube("render-front");
    let picture = render(&folder, FRONT);
    let (sky, lower, upper) = (picture.at(0, 0), picture.at(20, 18), picture.at(12, 14));
    assert_eq!(picture.colors(), BTreeSet::from([sky, lower, upper]), "two triangles and the sky");
    assert!(sky != lower && lower != upper && sky != upper);
    // At 4 from the eye, 45 degrees are 2 * 4 * tan(22.5) = 3.31 wide, and the cube is 2: 20 pixels of 33.
    let row = (0..33).filter(|x| picture.at(*x, 16) != sky).count();
    let column = (0..33).filter(|y| picture.at(16, *y) != sky).count();
    assert!((19..=21).contains(&row) && (19..=21).contains(&column), "{row} x {column} pixels");
}

#[test]
fn every_camera_option_counts() {
    let folder = Folder::with_cube("render-camera");
    let front = render(&folder, FRONT);
    let sky = front.at(0, 0);
    let seen = |p: &Picture| p.2.iter().filter(|c| **c != sky).count();
    assert!(seen(&render(&folder, &format!("{FRONT} --fov 90"))) < seen(&front) / 2);
    assert!(seen(&render(&folder, &FRONT.replace("0,0,5", "0,0,9"))) < seen(&front) / 2);
    assert_eq!(seen(&render(&folder, &FRONT.replace("--at 0,0,0", "--at 0,0,9"))), 0, "looks away");
    // Turned by a quarter, the diagonal of the front runs the other way.
    let turned = render(&folder, &format!("{FRONT} --up -1,0,0"));
    assert_eq!((turned.at(12, 18), turned.at(20, 14)), (turned.at(12, 17), turned.at(20, 15)));
    assert!(turned.2 != front.2 && turned.colors() == front.colors());
    let behind = render(&folder, &FRONT.replace("0,0,5", "-0.0,0,-5"));
    assert!(behind.colors().is_disjoint(&(&front.colors() - &BTreeSet::from([sky]))), "the back has its own triangles");
}

#[test]
fn a_scene_without_primitives_is_all_sky() {
    let folder = Folder::with_cube("render-empty");
    for kind in ["bvh", "list"] {
        let golden = format!("tests/golden/v2-{kind}-empty.fray");
        fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join(golden), folder.path("cube.fray")).expect("a golden blob");
        for shade in ["normals", "depth", "ids", "heat"] {
            let picture = render(&folder, &format!("--size 16x12 --shade {shade}"));
            assert_eq!((picture.0, picture.1), (16, 12));
            // The sky behind lit surfaces is a dark gradient, the others have one colour.
            let dark = picture.2.iter().flatten().all(|channel| *channel <= 150);
            let plain = shade == "normals" || picture.colors().len() == 1;
            assert!(dark && plain, "{kind} {shade}: {:?}", picture.colors());
        }
    }
}

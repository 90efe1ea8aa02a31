//! From a mesh to a hit in twenty lines: the README's example.
use flashray::build::{Config, Mesh, to_vec};
use flashray::{Hit, Kind, Ray, Scene};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Offline: a tetrahedron becomes a blob, which could be written to a file or into firmware.
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let blob = to_vec(&Mesh::new(&positions, &triangles), &Config::new(Kind::Bvh))?;

    // On the device: check once, then ask. No heap, no panic, whatever the bytes are.
    let scene = Scene::from_bytes(&blob)?;
    let ray = Ray::new([0.1, 0.2, -1.0], [0.0, 0.0, 1.0]);
    if let Some(Hit { t, prim, .. }) = scene.closest_hit(&ray) {
        assert_eq!((t, prim), (1.0, 0));
    }
    assert!(!scene.any_hit(&Ray::new([2.0, 2.0, -1.0], [0.0, 0.0, 1.0])));
    Ok(())
}

//! The four kinds of rays that structures are compared with.
use super::super::rays::on_sphere;
use crate::camera::{Camera, Vec3, add_scaled, dot, sub, unit};
use crate::normal::normal_at;
use crate::random::Random;
use crate::soup::Soup;
use crate::spd::{self, View};
use crate::{Failure, mesh};
use flashray::blob::prims::Primitive;
use flashray::{Aabb, Ray, Scene};
use std::path::Path;

/// The kinds, in the order of every table. Shadow rays ask for any hit, the others for the closest.
pub const KINDS: [&str; 4] = ["camera", "diffuse", "shadow", "chord"];
/// The place of shadow rays among them.
pub const SHADOW: usize = 2;

/// What is compared: a mesh file or a procedural scene.
pub struct Input {
    pub soup: Soup,
    view: Option<View>,
    lights: Vec<Vec3>,
}

impl Input {
    /// What `IN` names.
    pub fn read(input: &str) -> Result<Self, Failure> {
        let Some(spec) = input.strip_prefix("spd:") else {
            return Ok(Self { soup: mesh::read(Path::new(input))?, view: None, lights: Vec::new() });
        };
        let spd = spd::scene(spec)?;
        let lights = spd.lights.iter().map(|light| light.map(|x| x as f32)).collect();
        Ok(Self { soup: spd.soup, view: Some(spd.view), lights })
    }
}

/// Rays of every kind, about as many of each.
pub struct Rays {
    pub kinds: [Vec<Ray>; 4],
}

impl Rays {
    /// Camera rays through a square screen, up to `count`; from where they hit, as many bounces distributed as the
    /// cosine to the surface, and as many rays to the lights in turn; and chords between points on a sphere around all.
    /// The same rays everywhere.
    pub fn new(input: &Input, scene: &Scene<'_>, count: usize) -> Self {
        let bounds = scene.bounds();
        let camera = camera_rays(input, &bounds, count);
        let surface = surface(scene, &camera, size(&bounds) * 1e-4);
        let lights = if input.lights.is_empty() { default_lights(&bounds) } else { input.lights.clone() };
        let mut random = Random::new(1);
        // As many rays as asked for from however many hits, in the order of the screen.
        let from = |i: usize| surface[i * surface.len() / count];
        let wanted = if surface.is_empty() { 0 } else { count };
        let diffuse = (0..wanted).map(|i| {
            let (point, normal) = from(i);
            let bounce = add_scaled(normal, 1.0, on_sphere(&mut random));
            Ray::new(point, if dot(bounce, bounce) > 1e-6 { unit(bounce) } else { normal })
        });
        let diffuse = diffuse.collect();
        // Up to the light and no farther: `t` counts in units of the whole way.
        let shadow =
            (0..wanted).map(|i| Ray::new(from(i).0, sub(lights[i % lights.len()], from(i).0)).within(0.0, 1.0));
        let shadow = shadow.collect();
        let radius = size(&bounds) * 0.9;
        let mut around = || add_scaled(middle(&bounds), radius, on_sphere(&mut random));
        let chord = (0..count).map(|_| {
            let from = around();
            Ray::new(from, sub(around(), from))
        });
        let chord = chord.collect();
        Self { kinds: [camera, diffuse, shadow, chord] }
    }
}

/// The scene's own view, or one that frames it.
fn camera_rays(input: &Input, bounds: &Aabb, count: usize) -> Vec<Ray> {
    let side = (count as f64).sqrt().max(2.0) as u32;
    if let Some(view) = &input.view {
        return view.rays(side).map(|(origin, dir)| Ray::new(origin, dir)).collect();
    }
    let camera = Camera::frame(bounds, [0.0, 1.0, 0.0], 45.0, 1.0);
    let at = |i: u32| (i as f32 + 0.5) / side as f32 * 2.0 - 1.0;
    (0..side * side).map(|i| camera.ray(at(i % side), -at(i / side))).collect()
}

/// Where rays hit, lifted off the surface towards whence they came, and the surface's direction there.
fn surface(scene: &Scene<'_>, rays: &[Ray], lift: f32) -> Vec<(Vec3, Vec3)> {
    let mut prims: Vec<Option<Primitive>> = vec![None; scene.len() as usize];
    for (id, primitive) in scene.primitives() {
        prims[id as usize] = Some(primitive);
    }
    let lifted = |ray: &Ray| {
        let hit = scene.closest_hit(ray)?;
        let point = add_scaled(ray.origin, hit.t, ray.dir);
        let normal = normal_at(prims[hit.prim as usize].as_ref()?, point);
        let normal = if dot(normal, ray.dir) > 0.0 { normal.map(|x| -x) } else { normal };
        Some((add_scaled(point, lift, normal), normal))
    };
    rays.iter().filter_map(lifted).collect()
}

/// For meshes, which bring none: one above the left shoulder, one to the right.
fn default_lights(bounds: &Aabb) -> Vec<Vec3> {
    let far = size(bounds) * 2.0;
    [[-0.6, 1.0, 0.9], [1.0, 0.4, 0.5]].map(|dir| add_scaled(middle(bounds), far, unit(dir))).to_vec()
}

fn middle(bounds: &Aabb) -> Vec3 {
    [0, 1, 2].map(|k| bounds.min[k] / 2.0 + bounds.max[k] / 2.0)
}

/// The longest side.
fn size(bounds: &Aabb) -> f32 {
    [0, 1, 2].map(|k| bounds.max[k] - bounds.min[k]).iter().fold(f32::MIN_POSITIVE, |a, &b| a.max(b))
}

//! The four kinds of rays that structures are compared and measured with.
use crate::camera::{Camera, Vec3, add_scaled, dot, sub, unit};
use crate::cmd::rays::on_sphere;
use crate::normal::normal_at;
use crate::random::Random;
use crate::soup::Soup;
use crate::spd::{self, View};
use crate::{Failure, mesh};
use flashray::blob::prims::Primitive;
use flashray::geom::place::longest_side;
use flashray::{Aabb, Ray, Scene};
use std::path::Path;

/// The kinds, in the order of every table. Shadow rays ask for any hit, the others for the closest.
pub const KINDS: [&str; 4] = ["camera", "diffuse", "shadow", "chord"];
/// The place of shadow rays among them.
pub const SHADOW: usize = 2;

/// A mesh file or a procedural scene.
pub struct Input {
    pub soup: Soup,
    pub stage: Stage,
}

/// What a scene says of camera and lights: meshes and blobs say nothing.
#[derive(Default)]
pub struct Stage {
    view: Option<View>,
    lights: Vec<Vec3>,
}

impl Input {
    /// What `IN` names.
    pub fn read(input: &str) -> Result<Self, Failure> {
        let Some(spec) = input.strip_prefix("spd:") else {
            return Ok(Self { soup: mesh::read(Path::new(input))?, stage: Stage::default() });
        };
        let spd = spd::scene(spec)?;
        let lights = spd.lights.iter().map(|light| light.map(|x| x as f32)).collect();
        Ok(Self { soup: spd.soup, stage: Stage { view: Some(spd.view), lights } })
    }
}

/// The order of camera rays, which those that start at their hits follow.
#[derive(Clone, Copy)]
pub enum Order {
    /// As the screen is read.
    Rows,
    /// In squares of 8 by 8, and in these of 4 by 4 and 2 by 2: any group of 64, 16 or 4 that starts at a multiple of
    /// as many is a square of pixels.
    Squares,
}

/// Rays of every kind, about as many of each.
pub struct Rays {
    pub kinds: [Vec<Ray>; 4],
}

impl Rays {
    /// Camera rays through a square screen, up to `count`; from where they hit, as many bounces distributed as the
    /// cosine to the surface, and as many rays to the lights in turn; and chords between points on a sphere around all.
    /// The same rays everywhere.
    pub fn new(stage: &Stage, scene: &Scene<'_>, count: usize, order: Order) -> Self {
        let bounds = bounds(scene);
        let camera = camera_rays(stage, &bounds, count, order);
        let surface = surface(scene, &camera, size(&bounds) * 1e-4);
        let lights = if stage.lights.is_empty() { default_lights(&bounds) } else { stage.lights.clone() };
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

/// Rays from a camera outside that look away from the scene: none comes near its box.
pub fn away(scene: &Scene<'_>, count: usize) -> Vec<Ray> {
    let rays = camera_rays(&Stage::default(), &bounds(scene), count, Order::Rows);
    rays.iter().map(|ray| Ray { dir: ray.dir.map(|x| -x), ..*ray }).collect()
}

/// The scene's own view, or one that frames it.
fn camera_rays(stage: &Stage, bounds: &Aabb, count: usize, order: Order) -> Vec<Ray> {
    let side = (count as f64).sqrt().max(2.0) as u32;
    let side = if let Order::Squares = order { (side / 8 * 8).max(8) } else { side };
    let rays: Vec<Ray> = if let Some(view) = &stage.view {
        view.rays(side).map(|(origin, dir)| Ray::new(origin, dir)).collect()
    } else {
        let camera = Camera::frame(bounds, [0.0, 1.0, 0.0], 45.0, 1.0);
        let at = |i: u32| (i as f32 + 0.5) / side as f32 * 2.0 - 1.0;
        (0..side * side).map(|i| camera.ray(at(i % side), -at(i / side))).collect()
    };
    match order {
        Order::Rows => rays,
        Order::Squares => (0..side * side).map(|i| rays[pixel(i, side)]).collect(),
    }
}

/// The pixel, counted as the screen is read, of the `i`th ray in the order of squares.
fn pixel(i: u32, side: u32) -> usize {
    let (square, k) = (i / 64, i % 64);
    let squares = side / 8;
    let x = square % squares * 8 + (k >> 4 & 1) * 4 + (k >> 2 & 1) * 2 + (k & 1);
    let y = square / squares * 8 + (k >> 5 & 1) * 4 + (k >> 3 & 1) * 2 + (k >> 1 & 1);
    (y * side + x) as usize
}

/// The scene's box where the caller has it.
fn bounds(scene: &Scene<'_>) -> Aabb {
    let (b, local) = (scene.bounds(), scene.local_origin());
    Aabb { min: add_scaled(b.min, 1.0, local), max: add_scaled(b.max, 1.0, local) }
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
        let normal = normal_at(prims[hit.prim as usize].as_ref()?, sub(point, scene.local_origin()));
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

/// The longest side; of a point a little.
fn size(bounds: &Aabb) -> f32 {
    longest_side(bounds).max(f32::MIN_POSITIVE)
}

//! The rays of a classical ray tracer on the SPD scenes (Whitted, CACM 23(6), 1980), after the testing procedures in
//! the README of the SPD's version 3.12, points 6 to 10.
//!
//! Rays through the pixel corners have depth 1 and rays of depth 5 spawn none. Every hit sends one ray to each light
//! that the surface faces. A hit on a mirror or on glass spawns a reflected ray, a hit on glass a refracted one too, by
//! Snell's law, unless reflection is total. No ray is left out for being dim.
use crate::camera::{Vec3, add_scaled, dot, sub, unit};
use crate::normal::normal_at;
use crate::spd::Spd;
use flashray::blob::prims::Primitive;
use flashray::{Hit, Ray, Scene};

/// Rays of this depth spawn none.
const DEPTH: u32 = 5;

/// Rays with what they meet.
#[derive(Default)]
pub struct Rays {
    /// From the eye.
    pub eye: usize,
    /// From mirrors and glass.
    pub reflected: usize,
    /// Through glass.
    pub refracted: usize,
    /// All of these, with the closest hit.
    pub closest: Vec<(Ray, Option<Hit>)>,
    /// Rays to lights, with whether something is in the way.
    pub shadow: Vec<(Ray, bool)>,
}

impl Rays {
    /// The rays of `side` x `side` points of the scene's own view; `scene` finds their ways.
    pub fn new(spd: &Spd, scene: &Scene<'_>, side: u32) -> Self {
        let mut prims = vec![None; scene.len() as usize];
        for (id, primitive) in scene.primitives() {
            prims[id as usize] = Some(primitive);
        }
        let lights = spd.lights.iter().map(|light| light.map(|x| x as f32)).collect();
        let world = World { spd, scene, prims, lights };
        let mut rays = Self::default();
        for (origin, dir) in spd.view.rays(side) {
            rays.eye += 1;
            rays.follow(&world, Ray::new(origin, dir), 1);
        }
        rays
    }

    /// How many there are of all kinds.
    pub fn count(&self) -> usize {
        self.closest.len() + self.shadow.len()
    }

    fn follow(&mut self, world: &World<'_>, ray: Ray, depth: u32) {
        let hit = world.scene.closest_hit(&ray);
        self.closest.push((ray, hit));
        let Some((hit, primitive)) = hit.and_then(|hit| Some((hit, world.prims[hit.prim as usize]?))) else { return };
        let point = add_scaled(ray.origin, hit.t, ray.dir);
        // Off the surface by some roundings of the numbers that the point is computed from.
        let lift = point.iter().fold(hit.t, |most, x| most.max(x.abs())) * 1e-5;
        let outward = normal_at(&primitive, point);
        let leaves = dot(outward, ray.dir) > 0.0;
        let facing = if leaves { outward.map(|x| -x) } else { outward };
        let surface = surface(world.spd, hit.prim, &primitive);
        // Glass has an inner side, which no light is seen from; the others are seen from both sides. (With glass seen
        // from both sides too, the shadow rays of gears and mount are those of the SPD's README, and 4 to 6 % more in
        // all than the study's.)
        let lit = if surface.glass.is_some() { outward } else { facing };
        for &light in &world.lights {
            if dot(lit, sub(light, point)) > 0.0 {
                let from = add_scaled(point, lift, lit);
                // Up to the light and no farther: `t` counts in units of the whole way.
                let ray = Ray::new(from, sub(light, from)).within(0.0, 1.0);
                self.shadow.push((ray, world.scene.any_hit(&ray)));
            }
        }
        if depth == DEPTH {
            return;
        }
        if surface.mirror || surface.glass.is_some() {
            self.reflected += 1;
            let dir = unit(add_scaled(ray.dir, -2.0 * dot(facing, ray.dir), facing));
            self.follow(world, Ray::new(add_scaled(point, lift, facing), dir), depth + 1);
        }
        let ratio = surface.glass.map(|index| if leaves { index } else { 1.0 / index });
        if let Some(dir) = ratio.and_then(|ratio| refract(ray.dir, facing, ratio)) {
            self.refracted += 1;
            self.follow(world, Ray::new(add_scaled(point, -lift, facing), dir), depth + 1);
        }
    }
}

struct World<'a> {
    spd: &'a Spd,
    scene: &'a Scene<'a>,
    /// Every primitive, by the caller's number.
    prims: Vec<Option<Primitive>>,
    lights: Vec<Vec3>,
}

/// What a hit spawns.
#[derive(Default)]
struct Surface {
    mirror: bool,
    /// The index of refraction.
    glass: Option<f32>,
}

/// The surfaces as the SPD's generators have them: a mirror is what has a specular share Ks, glass what transmits.
fn surface(spd: &Spd, id: u32, primitive: &Primitive) -> Surface {
    let mirror = Surface { mirror: true, glass: None };
    let glass = |index| Surface { mirror: false, glass: Some(index) };
    match (spd.name, primitive) {
        ("teapot", _) | ("balls" | "lattice" | "rings", Primitive::Sphere(_)) | ("rings", Primitive::Cylinder(_)) => {
            mirror
        }
        ("mount", Primitive::Sphere(_)) => glass(1.5),
        // The ground, then gears of 572 triangles each, in rows, layer by layer.
        ("gears", _) => match (id.checked_sub(2).map(|i| i / 572), spd.size) {
            (None, _) => mirror,
            (Some(gear), n) if (gear % n * 4 + gear / n % n * 2 + gear / n / n) % 5 == 0 => glass(1.1),
            _ => Surface::default(),
        },
        _ => Surface::default(),
    }
}

/// The direction behind a surface by Snell's law, where `ratio` is the index before by that behind it and `facing` the
/// surface's direction on the side before it. None if all is reflected.
fn refract(dir: Vec3, facing: Vec3, ratio: f32) -> Option<Vec3> {
    let along = -dot(facing, dir);
    let rest = 1.0 - ratio * ratio * (1.0 - along * along);
    (rest >= 0.0).then(|| unit(add_scaled(dir.map(|x| x * ratio), ratio * along - rest.sqrt(), facing)))
}

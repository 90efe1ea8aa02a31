//! `flashray render`.
use crate::camera::{Camera, Vec3, add_scaled, dot, sub, unit};
use crate::normal::normal_at;
use crate::{Failure, args, file};
use clap::ValueEnum;
use flashray::blob::prims::Primitive;
use flashray::{Hit, Ray, Scene};
use rayon::prelude::*;
use std::path::PathBuf;
use std::time::Instant;

#[derive(clap::Args)]
pub struct Args {
    /// The blob
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The picture to write
    #[arg(short, long, value_name = "PIC.png")]
    output: PathBuf,
    /// What the colours mean
    #[arg(long, value_enum, default_value = "normals")]
    shade: Shade,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "1024x768")]
    size: (u32, u32),
    /// Samples along each side of a pixel
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=8))]
    samples: u32,
    /// The eye; by default the camera frames the scene
    #[arg(long, value_name = "X,Y,Z", value_parser = args::triple, allow_hyphen_values = true)]
    from: Option<[f32; 3]>,
    /// The point looked at; by default the middle of the scene
    #[arg(long, value_name = "X,Y,Z", value_parser = args::triple, allow_hyphen_values = true)]
    at: Option<[f32; 3]>,
    /// The direction that points upwards
    #[arg(long, value_name = "X,Y,Z", value_parser = args::triple, default_value = "0,1,0", allow_hyphen_values = true)]
    up: [f32; 3],
    /// Angle between the upper and the lower edge, in degrees
    #[arg(long, default_value_t = 45.0, value_parser = fov)]
    fov: f32,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Shade {
    /// Colour from the surface's direction, a light at the eye, and one that casts shadows
    Normals,
    /// White is near, black is far
    Depth,
    /// A colour for each primitive
    Ids,
    /// Nodes visited by the ray: black none, then blue, green, yellow, red for the most
    Heat,
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let parts = text.split_once('x').and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    let fits = |&(w, h): &(u32, u32)| (1..=16384).contains(&w) && (1..=16384).contains(&h);
    parts.filter(fits).ok_or(format!("`{text}` is not a size such as 1024x768, with sides from 1 to 16384"))
}

fn fov(text: &str) -> Result<f32, String> {
    let angle = text.parse().ok().filter(|a| (0.001..179.0).contains(a));
    angle.ok_or(format!("`{text}` is not an angle from 0.001 to 179 degrees"))
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let bytes = file::read(&args.file)?;
    let scene = file::scene(&args.file, &bytes)?;
    let start = Instant::now();
    let bar = super::progress("rendering", u64::from(args.size.1));
    let picture = render(&scene, &camera(args, &scene), args.shade, args.size, args.samples, None, &bar);
    bar.finish_and_clear();
    let png = picture.png().map_err(|e| format!("{}: {e}", args.output.display()))?;
    file::write(&args.output, &png)?;
    let ((w, h), seconds) = (args.size, start.elapsed().as_secs_f64());
    file::say(&format!("{}: {w} x {h}, {seconds:.2} s", args.output.display()))
}

fn camera(args: &Args, scene: &Scene<'_>) -> Camera {
    let (bounds, local) = (scene.bounds(), scene.local_origin());
    let bounds = flashray::Aabb { min: add_scaled(bounds.min, 1.0, local), max: add_scaled(bounds.max, 1.0, local) };
    let aspect = args.size.0 as f32 / args.size.1 as f32;
    let framed = Camera::frame(&bounds, args.up, args.fov, aspect);
    if args.from.is_none() && args.at.is_none() {
        return framed;
    }
    let middle = [0, 1, 2].map(|k| bounds.min[k] / 2.0 + bounds.max[k] / 2.0);
    Camera::look(args.from.unwrap_or(framed.from), args.at.unwrap_or(middle), args.up, args.fov, aspect)
}

/// Rows of RGB pixels.
pub struct Picture {
    pub width: u32,
    pub height: u32,
    pub pixels: Vec<u8>,
}

impl Picture {
    /// The picture as a PNG file.
    pub fn png(&self) -> Result<Vec<u8>, png::EncodingError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.pixels)?;
        writer.finish()?;
        Ok(bytes)
    }
}

/// Renders on all cores. `light` is the direction towards the light that casts shadows, if not the usual one.
pub fn render(
    scene: &Scene<'_>,
    camera: &Camera,
    shade: Shade,
    (width, height): (u32, u32),
    samples: u32,
    light: Option<Vec3>,
    bar: &indicatif::ProgressBar,
) -> Picture {
    let mut shader = Shader::new(scene, camera, shade);
    shader.light = light.map_or(shader.light, unit);
    let mut pixels = vec![0; width as usize * height as usize * 3];
    pixels.par_chunks_mut(width as usize * 3).enumerate().for_each(|(row, line)| {
        for (column, pixel) in line.chunks_exact_mut(3).enumerate() {
            let mut sum = [0.0; 3];
            for sample in 0..samples * samples {
                let (i, j) = (sample % samples, sample / samples);
                let along = |p: usize, s: u32| p as f32 + (s as f32 + 0.5) / samples as f32;
                let x = along(column, i) / width as f32 * 2.0 - 1.0;
                let y = 1.0 - along(row, j) / height as f32 * 2.0;
                sum = add_scaled(sum, 1.0, shader.color(&camera.ray(x, y)));
            }
            let byte = |c: f32| ((c / (samples * samples) as f32).clamp(0.0, 1.0) * 255.0).round() as u8;
            pixel.copy_from_slice(&sum.map(byte));
        }
        bar.inc(1);
    });
    Picture { width, height, pixels }
}

struct Shader<'s, 'a> {
    scene: &'s Scene<'a>,
    shade: Shade,
    /// Every primitive, by the caller's number.
    prims: Vec<Option<Primitive>>,
    /// Towards the light that casts shadows.
    light: Vec3,
    /// Distances between which depth is shown.
    depth: [f32; 2],
    /// The size of the scene, by which shadow rays are lifted off the surface.
    size: f32,
    /// The most nodes seen in a coarse first pass.
    heat: f32,
}

impl<'s, 'a> Shader<'s, 'a> {
    fn new(scene: &'s Scene<'a>, camera: &Camera, shade: Shade) -> Self {
        let mut prims = vec![None; scene.len() as usize];
        for (id, primitive) in scene.primitives() {
            if let Some(place) = prims.get_mut(id as usize) {
                *place = Some(primitive);
            }
        }
        let bounds = scene.bounds();
        let size = [0, 1, 2].map(|k| bounds.max[k] - bounds.min[k]).iter().fold(0.0f32, |a, &b| a.max(b));
        let light = unit(add_scaled(
            add_scaled(sub([0.0; 3], camera.ray(0.0, 0.0).dir), 1.0, camera.up()),
            -0.7,
            camera.right(),
        ));
        let (mut depth, mut heat) = ([f32::INFINITY, 0.0f32], 1.0f32);
        for i in 0..64 * 64 {
            let ray = camera.ray((i % 64) as f32 / 31.5 - 1.0, (i / 64) as f32 / 31.5 - 1.0);
            let (hit, steps) = scene.closest_hit_counted(&ray);
            heat = heat.max(steps.nodes as f32);
            if let Some(hit) = hit {
                depth = [depth[0].min(hit.t), depth[1].max(hit.t)];
            }
        }
        Self { scene, shade, prims, light, depth, size, heat }
    }

    fn color(&self, ray: &Ray) -> Vec3 {
        if self.shade == Shade::Heat {
            return heat(self.scene.closest_hit_counted(ray).1.nodes as f32 / self.heat);
        }
        let Some(hit) = self.scene.closest_hit(ray) else {
            let up = 0.5 + 0.5 * ray.dir[1];
            return if self.shade == Shade::Normals {
                [0.10 + 0.06 * up, 0.11 + 0.07 * up, 0.14 + 0.09 * up]
            } else {
                [0.0; 3]
            };
        };
        match self.shade {
            Shade::Depth => [1.0 - 0.85 * (hit.t - self.depth[0]) / (self.depth[1] - self.depth[0]).max(1e-30); 3],
            Shade::Ids => color_of(hit.prim),
            Shade::Normals | Shade::Heat => self.lit(ray, &hit),
        }
    }

    fn lit(&self, ray: &Ray, hit: &Hit) -> Vec3 {
        let point = add_scaled(ray.origin, hit.t, ray.dir);
        let local = sub(point, self.scene.local_origin());
        let primitive = self.prims.get(hit.prim as usize).copied().flatten();
        let normal = primitive.map_or([0.0; 3], |p| normal_at(&p, local));
        let facing = dot(normal, ray.dir);
        let normal = if facing > 0.0 { normal.map(|x| -x) } else { normal };
        let towards = dot(normal, self.light);
        let lifted = add_scaled(point, self.size * 1e-4, normal);
        let dark = towards <= 0.0 || self.scene.any_hit(&Ray::new(lifted, self.light));
        let brightness = 0.18 + 0.37 * facing.abs() + if dark { 0.0 } else { 0.5 * towards };
        normal.map(|x| (0.62 + 0.38 * x) * brightness)
    }
}

/// A bright colour for a number, far from those of its neighbours.
fn color_of(id: u32) -> Vec3 {
    let mixed = id.wrapping_add(1).wrapping_mul(0x9e37_79b9);
    let mixed = mixed ^ (mixed >> 15);
    [0, 8, 16].map(|shift| 0.25 + 0.75 * ((mixed >> shift & 255) as f32 / 255.0))
}

/// Black, blue, green, yellow, red.
fn heat(share: f32) -> Vec3 {
    const STOPS: [Vec3; 5] = [[0.0, 0.0, 0.02], [0.1, 0.2, 0.9], [0.1, 0.8, 0.3], [1.0, 0.9, 0.1], [0.95, 0.1, 0.05]];
    let x = share.clamp(0.0, 1.0) * 4.0;
    let at = (x as usize).min(3);
    add_scaled(STOPS[at], x - at as f32, sub(STOPS[at + 1], STOPS[at]))
}

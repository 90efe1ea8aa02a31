//! Hostile rays: raw bit patterns, and rays aimed at where the tests of a ray are decided by a last bit.
use arbitrary::{Arbitrary, Result, Unstructured};
use flashray::blob::prims::Primitive;
use flashray::{Ray, Scene};

/// A number with a taste for the edges of f32. Takes 1, 2 or 5 bytes.
#[derive(Clone, Copy, Debug)]
pub struct Number(pub f32);

impl<'a> Arbitrary<'a> for Number {
    fn arbitrary(u: &mut Unstructured<'a>) -> Result<Self> {
        let tag = u.arbitrary::<u8>()?;
        let x = match tag & 15 {
            0 => 0.0,
            1 => 1.0,
            2 => f32::from(u.arbitrary::<i8>()?),
            3 => f32::from(u.arbitrary::<i8>()?) / 16.0,
            4 | 5 => f32::from_bits(u.arbitrary()?),
            6 => f32::NAN,
            7 => f32::INFINITY,
            8 => f32::from_bits(u.arbitrary::<u32>()? & 0x807f_ffff),
            9 => f32::MAX,
            10 => f32::MIN_POSITIVE,
            11 => unit(u.arbitrary()?),
            12 => unit(u.arbitrary()?) * 1e30,
            13 => unit(u.arbitrary()?) * 1e-30,
            14 => 16_777_216.0 + f32::from(u.arbitrary::<i8>()?),
            _ => f32::from(u.arbitrary::<i8>()?).exp2(),
        };
        Ok(Self(if tag & 128 == 0 { x } else { -x }))
    }
}

impl Number {
    /// The number, or 0 if it is not one.
    pub fn finite(self) -> f32 {
        if self.0.is_finite() { self.0 } else { 0.0 }
    }
}

/// From -1 to 1, with all bits of the significand in use.
fn unit(bits: u32) -> f32 {
    (f64::from(bits) / f64::from(u32::MAX) * 2.0 - 1.0) as f32
}

/// A ray relative to a scene that is not known yet.
#[derive(Arbitrary, Clone, Debug)]
pub struct Spec {
    /// Which way the origin (low 3 bits) and direction (next 3 bits) come about, and whether the interval is odd.
    mode: u8,
    /// The primitive that it has to do with.
    target: u8,
    /// Which vertices and edges of that.
    feature: [u8; 2],
    origin: [Number; 3],
    dir: [Number; 3],
    interval: Interval,
}

/// A ray's interval. Zero bytes mean everything ahead.
#[derive(Clone, Copy, Debug)]
struct Interval([f32; 2]);

impl<'a> Arbitrary<'a> for Interval {
    fn arbitrary(u: &mut Unstructured<'a>) -> Result<Self> {
        let mut number = || Ok(u.arbitrary::<Number>()?.0);
        Ok(Self(match number()? {
            0.0 => [0.0, f32::INFINITY],
            1.0 => [f32::NEG_INFINITY, f32::INFINITY],
            2.0 => [number()?; 2],
            least => [least, number()?],
        }))
    }
}

/// `n` rays from the front of the data.
pub fn specs(u: &mut Unstructured<'_>, n: usize) -> Result<Vec<Spec>> {
    (0..n).map(|_| u.arbitrary()).collect()
}

type Point = [f32; 3];

fn each(f: impl FnMut(usize) -> f32) -> Point {
    [0, 1, 2].map(f)
}

/// A point of a primitive that its test has trouble with; for even `which` a vertex of a triangle.
fn feature(primitive: &Primitive, which: u8) -> Point {
    let (k, s) = (usize::from(which / 2) % 3, if which & 1 == 0 { 1.0 } else { -1.0 });
    let off = |p: Point, r: f32| each(|i| if i == k { p[i] + s * r } else { p[i] });
    match primitive {
        Primitive::Triangle(p) if which & 1 == 0 => p.v[k],
        Primitive::Triangle(p) => each(|i| (p.v[k][i] + p.v[(k + 1) % 3][i]) * 0.5),
        Primitive::Sphere(p) => off(p.center, p.radius),
        Primitive::Box(p) => each(|i| if which >> i & 1 == 0 { p.min[i] } else { p.max[i] }),
        Primitive::Cylinder(p) => off(if which & 8 == 0 { p.base } else { p.top }, p.radius),
        Primitive::Cone(p) => off(if which & 8 == 0 { p.base } else { p.top }, p.base_radius),
        _ => [0.0; 3],
    }
}

fn center(primitive: &Primitive) -> Point {
    match primitive {
        Primitive::Triangle(p) => each(|i| (p.v[0][i] + p.v[1][i] + p.v[2][i]) / 3.0),
        Primitive::Sphere(p) => p.center,
        Primitive::Box(p) => each(|i| (p.min[i] + p.max[i]) * 0.5),
        Primitive::Cylinder(p) => each(|i| (p.base[i] + p.top[i]) * 0.5),
        Primitive::Cone(p) => each(|i| (p.base[i] + p.top[i]) * 0.5),
        _ => [0.0; 3],
    }
}

impl Spec {
    /// The ray, aimed at `scene`.
    pub fn ray(&self, scene: &Scene<'_>) -> Ray {
        let count = scene.len().max(1);
        let target = scene.primitives().nth((u32::from(self.target) % count) as usize).map(|(_, p)| p);
        let origin = self.origin(scene, target.as_ref());
        let dir = self.direction(scene, target.as_ref(), origin);
        let local = scene.local_origin();
        let [t_min, t_max] = self.interval.0;
        Ray::new(each(|k| origin[k] + local[k]), dir).within(t_min, t_max)
    }

    /// In blob coordinates.
    fn origin(&self, scene: &Scene<'_>, target: Option<&Primitive>) -> Point {
        let (b, n) = (scene.bounds(), self.origin.map(|n| n.0));
        match self.mode & 7 {
            // Outside, off the corner of the scene, moved by shares of its size.
            0 | 1 => each(|k| b.max[k] + (b.max[k] - b.min[k]) * (0.5 + n[k])),
            2 => each(|k| b.min[k] + (b.max[k] - b.min[k]) * n[k]),
            3 => target.map_or(n, |p| feature(p, self.feature[0])),
            4 => target.map_or(n, |p| {
                let c = center(p);
                each(|k| c[k] + n[k])
            }),
            5 => each(|k| if self.feature[0] >> k & 1 == 0 { b.min[k] } else { b.max[k] }),
            // Straight before a feature, so that an axis-parallel direction meets it in the last bit.
            6 => target.map_or(n, |p| {
                let at = feature(p, self.feature[1]);
                each(|k| if usize::from(self.feature[0] % 3) == k { at[k] + n[k] } else { at[k] })
            }),
            _ => n,
        }
    }

    fn direction(&self, scene: &Scene<'_>, target: Option<&Primitive>, from: Point) -> Point {
        let n = self.dir.map(|n| n.0);
        let to = |p: Point| {
            // The length is the unit of t: any will do, and 0 means that of the difference.
            let length = if n[0] == 0.0 { 1.0 } else { n[0] };
            each(|k| (p[k] - from[k]) * length)
        };
        let [f, g] = self.feature;
        match (self.mode >> 3 & 7, target) {
            (0, Some(p)) => to(center(p)),
            (1 | 2, Some(p)) => to(feature(p, g)),
            (3, Some(p)) => {
                let (a, b) = (feature(p, g), feature(p, g.wrapping_add(2)));
                each(|k| b[k] - a[k])
            }
            (4, _) => each(|k| if usize::from(f % 3) == k { if f & 128 == 0 { 1.0 } else { -1.0 } } else { -0.0 }),
            (5, _) => each(|k| if f >> k & 1 == 0 { n[k] } else { 0.0 }),
            (6, _) => to(each(|k| if g >> k & 1 == 0 { scene.bounds().min[k] } else { scene.bounds().max[k] })),
            _ => n,
        }
    }
}

//! Mesh files and procedural scenes, all as triangle soups.
use crate::peer::Tri;
use crate::rng::Rng;
use std::path::Path;

pub struct Scene {
    pub name: String,
    pub tris: Vec<Tri>,
    pub lo: [f32; 3],
    pub hi: [f32; 3],
    /// Eye, target and vertical field of view (degrees), if not the default 3/4 view.
    pub camera: Option<([f32; 3], [f32; 3], f32)>,
}

impl Scene {
    pub fn new(name: &str, tris: Vec<Tri>) -> Scene {
        let (mut lo, mut hi) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for v in tris.iter().flatten() {
            for k in 0..3 {
                lo[k] = lo[k].min(v[k]);
                hi[k] = hi[k].max(v[k]);
            }
        }
        Scene { name: name.into(), tris, lo, hi, camera: None }
    }
    pub fn center(&self) -> [f32; 3] {
        std::array::from_fn(|k| 0.5 * (self.lo[k] + self.hi[k]))
    }
    pub fn diag(&self) -> f32 {
        (0..3).map(|k| (self.hi[k] - self.lo[k]).powi(2)).sum::<f32>().sqrt()
    }
}

/// `path` or `path@ex,ey,ez,tx,ty,tz,fov` (a camera inside the scene).
pub fn load(arg: &str) -> Scene {
    let (path, cam) = match arg.rsplit_once('@') {
        Some((p, c)) => (p, Some(c)),
        None => (arg, None),
    };
    let p = Path::new(path);
    let stem = p.file_stem().unwrap().to_string_lossy().to_string();
    let tris = match p.extension().and_then(|e| e.to_str()) {
        Some("ply") => load_ply(p),
        _ => load_obj(p),
    };
    let mut s = Scene::new(&stem, tris);
    if let Some(c) = cam {
        let f: Vec<f32> = c.split(',').map(|x| x.parse().expect("camera number")).collect();
        assert!(f.len() == 7, "camera needs ex,ey,ez,tx,ty,tz,fov");
        s.camera = Some(([f[0], f[1], f[2]], [f[3], f[4], f[5]], f[6]));
        s.name += "-inside";
    }
    s
}

fn load_obj(p: &Path) -> Vec<Tri> {
    let opt = tobj::LoadOptions { triangulate: true, single_index: false, ignore_points: true, ignore_lines: true };
    let (models, _) = tobj::load_obj(p, &opt).unwrap_or_else(|e| panic!("{}: {e}", p.display()));
    let mut out = vec![];
    for m in models {
        let v = |i: u32| -> [f32; 3] { std::array::from_fn(|k| m.mesh.positions[i as usize * 3 + k]) };
        out.extend(m.mesh.indices.chunks_exact(3).map(|t| [v(t[0]), v(t[1]), v(t[2])]));
    }
    out
}

fn load_ply(p: &Path) -> Vec<Tri> {
    use ply_rs::{parser::Parser, ply::*};
    let mut f = std::io::BufReader::new(std::fs::File::open(p).unwrap_or_else(|e| panic!("{}: {e}", p.display())));
    let ply = Parser::<DefaultElement>::new().read_ply(&mut f).expect("ply");
    let num = |x: &Property| match *x {
        Property::Float(v) => v,
        Property::Double(v) => v as f32,
        Property::Int(v) => v as f32,
        _ => panic!("vertex property type"),
    };
    let verts: Vec<[f32; 3]> =
        ply.payload["vertex"].iter().map(|e| [num(&e["x"]), num(&e["y"]), num(&e["z"])]).collect();
    let mut out = vec![];
    for e in &ply.payload["face"] {
        let l = e.get("vertex_indices").or_else(|| e.get("vertex_index")).expect("vertex_indices");
        let ix: Vec<usize> = match l {
            Property::ListInt(v) => v.iter().map(|&i| i as usize).collect(),
            Property::ListUInt(v) => v.iter().map(|&i| i as usize).collect(),
            Property::ListUShort(v) => v.iter().map(|&i| i as usize).collect(),
            Property::ListUChar(v) => v.iter().map(|&i| i as usize).collect(),
            _ => panic!("face list type"),
        };
        for k in 1..ix.len().saturating_sub(1) {
            out.push([verts[ix[0]], verts[ix[k]], verts[ix[k + 1]]]);
        }
    }
    out
}

fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|k| a[k] - b[k])
}
fn norm(a: [f32; 3]) -> [f32; 3] {
    let l = (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt();
    a.map(|x| x / l)
}
fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn icosphere(levels: u32) -> Vec<Tri> {
    let p = (1.0 + 5f32.sqrt()) / 2.0;
    let v: Vec<[f32; 3]> = [
        [-1., p, 0.],
        [1., p, 0.],
        [-1., -p, 0.],
        [1., -p, 0.],
        [0., -1., p],
        [0., 1., p],
        [0., -1., -p],
        [0., 1., -p],
        [p, 0., -1.],
        [p, 0., 1.],
        [-p, 0., -1.],
        [-p, 0., 1.],
    ]
    .into_iter()
    .map(norm)
    .collect();
    let f = [
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    let mut t: Vec<Tri> = f.iter().map(|i| [v[i[0]], v[i[1]], v[i[2]]]).collect();
    for _ in 0..levels {
        t = t
            .iter()
            .flat_map(|&[a, b, c]| {
                let m = |x: [f32; 3], y: [f32; 3]| norm(std::array::from_fn(|k| 0.5 * (x[k] + y[k])));
                let (ab, bc, ca) = (m(a, b), m(b, c), m(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    t
}

/// Sphere flake: 9 children of a third of the size on every sphere, each sphere a tessellated icosphere, plus a floor.
pub fn flake(depth: u32, levels: u32) -> Scene {
    let ball = icosphere(levels);
    let mut out = vec![];
    let mut todo = vec![([0f32; 3], 1f32, [0f32, 1., 0.], 0u32)];
    while let Some((c, r, up, d)) = todo.pop() {
        out.extend(ball.iter().map(|t| t.map(|v| std::array::from_fn(|k| c[k] + r * v[k]))));
        if d == depth {
            continue;
        }
        let side = norm(cross(up, if up[0].abs() < 0.8 { [1., 0., 0.] } else { [0., 0., 1.] }));
        let fwd = cross(side, up);
        for i in 0..9 {
            // six around the equator (slightly lifted), three near the pole
            let (el, az) =
                if i < 6 { (0.1f32, i as f32 * 1.0471976) } else { (0.95, (i - 6) as f32 * 2.0943952 + 0.5) };
            let dir: [f32; 3] =
                std::array::from_fn(|k| el.cos() * (az.cos() * side[k] + az.sin() * fwd[k]) + el.sin() * up[k]);
            let q = std::array::from_fn(|k| c[k] + dir[k] * r * (1.0 + 1.0 / 3.0));
            todo.push((q, r / 3.0, norm(dir), d + 1));
        }
    }
    let f = 3.0;
    out.push([[-f, -1.0, -f], [f, -1.0, -f], [f, -1.0, f]]);
    out.push([[-f, -1.0, -f], [f, -1.0, f], [-f, -1.0, f]]);
    Scene::new("flake", out)
}

/// Small random triangles in a unit cube.
pub fn soup(n: usize) -> Scene {
    let mut r = Rng::new(0x5eed_0001);
    let e = 0.7 / (n as f32).cbrt();
    let tris = (0..n)
        .map(|_| {
            let c: [f32; 3] = std::array::from_fn(|_| r.unit());
            std::array::from_fn(|_| std::array::from_fn(|k| c[k] + e * (2.0 * r.unit() - 1.0)))
        })
        .collect();
    Scene::new("soup", tris)
}

/// Bumpy height field, 2*n*n triangles.
pub fn terrain(n: usize) -> Scene {
    let h = |x: f32, z: f32| -> f32 {
        let (mut s, mut a, mut f) = (0.0, 0.06f32, 2.3f32);
        for i in 0..7 {
            let p = i as f32 * 1.7;
            s += a * ((x * f + p).sin() * (z * f * 1.1 - p).cos() + 0.5 * ((x + z) * f * 0.8 + 2.0 * p).sin());
            a *= 0.52;
            f *= 2.07;
        }
        s
    };
    let v = |i: usize, j: usize| {
        let (x, z) = (2.0 * i as f32 / n as f32 - 1.0, 2.0 * j as f32 / n as f32 - 1.0);
        [x, h(x * 4.0, z * 4.0), z]
    };
    let mut out = Vec::with_capacity(2 * n * n);
    for j in 0..n {
        for i in 0..n {
            let (a, b, c, d) = (v(i, j), v(i + 1, j), v(i + 1, j + 1), v(i, j + 1));
            out.push([a, b, c]);
            out.push([a, c, d]);
        }
    }
    Scene::new("terrain", out)
}

pub fn face_normal(t: &Tri) -> [f32; 3] {
    let n = cross(sub(t[1], t[0]), sub(t[2], t[0]));
    let l = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
    if l > 0.0 { n.map(|x| x / l) } else { [0.0, 1.0, 0.0] }
}

//! Which way a surface faces.
use crate::camera::{Vec3, add_scaled, cross, dot, sub, unit};
use flashray::Cone;
use flashray::blob::prims::Primitive;

/// The unit direction that the surface faces at a point of it.
pub fn normal_at(primitive: &Primitive, p: Vec3) -> Vec3 {
    match primitive {
        Primitive::Triangle(t) => {
            let (a, b) = (unit(sub(t.v[1], t.v[0])), unit(sub(t.v[2], t.v[0])));
            unit(cross(a, b))
        }
        Primitive::Sphere(s) => unit(sub(p, s.center)),
        Primitive::Box(b) => {
            let reach = |k: usize| ((p[k] - b.min[k]) / (b.max[k] - b.min[k]).max(f32::MIN_POSITIVE)) * 2.0 - 1.0;
            let at = [0, 1, 2].map(reach);
            let most = at.iter().fold(0.0f32, |a, b| a.max(b.abs()));
            unit(at.map(|x| if x.abs() == most { x } else { 0.0 }))
        }
        Primitive::Cylinder(c) => cone_normal(&c.as_cone(), p),
        Primitive::Cone(c) => cone_normal(c, p),
        _ => [0.0; 3],
    }
}

fn cone_normal(c: &Cone, p: Vec3) -> Vec3 {
    let axis = sub(c.top, c.base);
    let length = dot(axis, axis).sqrt();
    let up = unit(axis);
    let height = dot(sub(p, c.base), up) / length.max(f32::MIN_POSITIVE);
    let away = add_scaled(sub(p, c.base), -height * length, up);
    let radius = dot(away, away).sqrt();
    let side = c.base_radius + (c.top_radius - c.base_radius) * height;
    if c.caps != 0 && radius < side * 0.999 {
        return if height < 0.5 { up.map(|x| -x) } else { up };
    }
    unit(add_scaled(unit(away), (c.base_radius - c.top_radius) / length.max(f32::MIN_POSITIVE), up))
}

//! Primitives: vertices, and the way in which they make triangles.
use serde_json::Value;

use super::super::sink::{Sink, narrow};
use super::transform::Transform;
use super::{Reader, json};

/// How the vertices of a primitive make triangles.
#[derive(Clone, Copy)]
enum Mode {
    Triangles,
    Strip,
    Fan,
}

impl Mode {
    /// The mode of a primitive; none for points and lines.
    fn of(primitive: &Value) -> Result<Option<Self>, String> {
        match json::number(primitive, "mode")?.unwrap_or(4) {
            0..4 => Ok(None),
            4 => Ok(Some(Self::Triangles)),
            5 => Ok(Some(Self::Strip)),
            6 => Ok(Some(Self::Fan)),
            mode => Err(format!("mode {mode} is not one of glTF")),
        }
    }

    /// Refuses a number of corners that does not make whole triangles.
    fn check(self, corners: usize) -> Result<(), String> {
        match self {
            Self::Triangles if !corners.is_multiple_of(3) => Err(format!("{corners} corners are not a multiple of 3")),
            Self::Strip | Self::Fan if (1..3).contains(&corners) => {
                Err(format!("{corners} corners are too few for a triangle"))
            }
            _ => Ok(()),
        }
    }

    /// Calls `add` with each triangle of `corners`.
    fn each(self, corners: &[u32], mut add: impl FnMut([u32; 3]) -> Result<(), String>) -> Result<(), String> {
        match self {
            Self::Triangles => {
                let (triangles, _) = corners.as_chunks();
                triangles.iter().try_for_each(|triangle| add(*triangle))
            }
            // Every second triangle of a strip is turned, so that all face the same way.
            Self::Strip => corners
                .array_windows()
                .enumerate()
                .try_for_each(|(number, &[a, b, c])| add(if number.is_multiple_of(2) { [a, b, c] } else { [a, c, b] })),
            Self::Fan => {
                let Some((first, rest)) = corners.split_first() else {
                    return Ok(());
                };
                rest.array_windows().try_for_each(|&[b, c]| add([*first, b, c]))
            }
        }
    }
}

impl Reader<'_> {
    /// Reads a primitive, with the vertices that its triangles use.
    pub(super) fn primitive(&mut self, primitive: &Value, world: &Transform) -> Result<(), String> {
        let Some(mode) = Mode::of(primitive)? else {
            return Ok(());
        };
        let attributes = primitive.get("attributes").ok_or("attributes are missing")?;
        let accessor = json::index(attributes, "POSITION")?.ok_or("it has no POSITION")?;
        self.load_positions(accessor)?;
        let vertices = self.recent.as_ref().map_or(0, |(_, positions)| positions.len());
        let corners = match json::index(primitive, "indices")? {
            Some(indices) => self.indices(indices, vertices)?,
            None => (0..u32::try_from(vertices).map_err(|_| "too many vertices")?).collect(),
        };
        mode.check(corners.len())?;
        let positions = self.recent.as_ref().map(|(_, positions)| positions.as_slice());
        append(&mut self.sink, positions.unwrap_or_default(), &corners, mode, world)
    }
}

/// Adds the triangles of `corners` to `sink`.
///
/// Only with the vertices in use: many primitives may share one large accessor, and a small file
/// must not become a large mesh.
fn append(
    sink: &mut Sink,
    positions: &[[f64; 3]],
    corners: &[u32],
    mode: Mode,
    world: &Transform,
) -> Result<(), String> {
    let mut used = corners.to_vec();
    used.sort_unstable();
    used.dedup();
    let base = u32::try_from(sink.vertices()).map_err(|_| "too many vertices")?;
    for vertex in &used {
        let position = usize::try_from(*vertex).ok().and_then(|vertex| positions.get(vertex));
        let position = world.apply(*position.ok_or("a vertex is out of range")?);
        let [Some(x), Some(y), Some(z)] = position.map(narrow) else {
            return Err(format!("vertex {vertex} is not a finite f32 where its node puts it"));
        };
        sink.vertex([x, y, z])?;
    }
    // All are in `used`. If that is every number up to some end, places and numbers are the same.
    let is_dense = used.last().is_none_or(|last| usize::try_from(*last).is_ok_and(|last| last < used.len()));
    let place = |corner: u32| {
        let place = if is_dense { corner } else { place_of(&used, corner) };
        base.saturating_add(place)
    };
    mode.each(corners, |triangle| sink.triangle(triangle.map(place)))
}

/// The place of `corner` in the sorted list `used`.
fn place_of(used: &[u32], corner: u32) -> u32 {
    u32::try_from(used.partition_point(|vertex| *vertex < corner)).unwrap_or(u32::MAX)
}

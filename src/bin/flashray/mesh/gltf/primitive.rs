//! Primitives: vertices, and the way in which they make triangles.
use gltf::accessor::sparse::Sparse;
use gltf::accessor::{DataType, Dimensions, Item, Iter};
use gltf::buffer::View;
use gltf::mesh::Mode;
use gltf::{Accessor, Primitive, Semantic};

use super::super::fan;
use super::transform::Transform;
use crate::soup::Soup;

/// How much work a primitive is: at least the number of its triangles.
pub fn size(primitive: &Primitive) -> usize {
    let positions = primitive.get(&Semantic::Positions);
    // A sparse accessor is read from its start on.
    let sparse = positions.as_ref().filter(|positions| positions.sparse().is_some()).map_or(0, Accessor::count);
    let corners = primitive.indices().or(positions).map_or(0, |accessor| accessor.count());
    let triangles = if primitive.mode() == Mode::Triangles { corners / 3 } else { corners };
    triangles.saturating_add(sparse).saturating_add(1)
}

/// Adds the triangles of a primitive to `soup`, with the vertices that they use.
pub fn read(primitive: &Primitive, world: &Transform, buffers: &[Vec<u8>], soup: &mut Soup) -> Result<(), String> {
    if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        return Ok(());
    }
    let positions = primitive.get(&Semantic::Positions).ok_or("it has no POSITION")?;
    let named = |why| format!("accessor {}: {why}", positions.index());
    check(&positions, Dimensions::Vec3, buffers).map_err(named)?;
    let corners = corners(primitive, positions.count(), buffers)?;
    // Only the vertices in use: many primitives may share one large accessor, and a small file must not become a large
    // mesh.
    let mut used = corners.clone();
    used.sort_unstable();
    used.dedup();
    let base = soup.positions.len();
    for (vertex, position) in used.iter().zip(points(&positions, &used, buffers).map_err(named)?) {
        let position = world.apply(position).map(narrow);
        if position.iter().any(|value| !value.is_finite()) {
            return Err(format!("vertex {vertex} is not a finite f32 where its node puts it"));
        }
        soup.positions.push(position);
    }
    let place = |corner: u32| u32::try_from(base + used.partition_point(|vertex| *vertex < corner));
    let corners: Result<Vec<u32>, _> = corners.into_iter().map(place).collect();
    extend(&mut soup.triangles, primitive.mode(), &corners.map_err(|_| "too many vertices")?)
}

/// Adds the triangles that `corners` make.
fn extend(triangles: &mut Vec<[u32; 3]>, mode: Mode, corners: &[u32]) -> Result<(), String> {
    let count = corners.len();
    match mode {
        Mode::Triangles if !count.is_multiple_of(3) => {
            return Err(format!("{count} corners are not a multiple of 3"));
        }
        Mode::Triangles => triangles.extend(corners.as_chunks().0),
        _ if count < 3 => return Err(format!("{count} corners are too few for a triangle")),
        Mode::TriangleFan => triangles.extend(fan(corners)),
        // Every second triangle of a strip is turned, so that all face the same way.
        _ => triangles.extend(
            corners
                .array_windows()
                .enumerate()
                .map(|(number, &[a, b, c])| if number.is_multiple_of(2) { [a, b, c] } else { [a, c, b] }),
        ),
    }
    Ok(())
}

/// The numbers of a primitive's corners, all below `vertices`.
fn corners(primitive: &Primitive, vertices: usize, buffers: &[Vec<u8>]) -> Result<Vec<u32>, String> {
    let Some(accessor) = primitive.indices() else {
        return Ok((0..u32::try_from(vertices).map_err(|_| "too many vertices")?).collect());
    };
    let named = |why: String| format!("accessor {}: {why}", accessor.index());
    check(&accessor, Dimensions::Scalar, buffers).map_err(named)?;
    if !matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::U32) {
        return Err(named("its componentType is not one of indices".into()));
    }
    let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(Vec::as_slice));
    let corners: Vec<u32> = reader.read_indices().ok_or("it has no indices")?.into_u32().collect();
    let is_wrong = |index: &u32| usize::try_from(*index).map_or(true, |index| index >= vertices);
    match corners.iter().find(|index| is_wrong(index)) {
        Some(index) => {
            Err(named(format!("vertex index {index} is out of range (the primitive has {vertices} vertices)")))
        }
        None => Ok(corners),
    }
}

/// The positions with the numbers `used`, which ascend.
fn points(accessor: &Accessor, used: &[u32], buffers: &[Vec<u8>]) -> Result<Vec<[f64; 3]>, String> {
    let scale = |greatest: f64| accessor.normalized().then_some(greatest);
    let found = match accessor.data_type() {
        DataType::I8 => pick::<i8>(accessor, used, buffers, scale(127.0)),
        DataType::U8 => pick::<u8>(accessor, used, buffers, scale(255.0)),
        DataType::I16 => pick::<i16>(accessor, used, buffers, scale(32_767.0)),
        DataType::U16 => pick::<u16>(accessor, used, buffers, scale(65_535.0)),
        DataType::F32 => pick::<f32>(accessor, used, buffers, None),
        DataType::U32 => return Err("its componentType is not one of positions".into()),
    };
    found.ok_or_else(|| "its elements cannot be read".into())
}

/// [`points`] of numbers of the type `T`, divided by `scale` if they are normalized.
fn pick<T>(accessor: &Accessor, used: &[u32], buffers: &[Vec<u8>], scale: Option<f64>) -> Option<Vec<[f64; 3]>>
where
    T: Item + Copy + Into<f64>,
{
    let mut items = Iter::<[T; 3]>::new(accessor.clone(), |buffer| buffers.get(buffer.index()).map(Vec::as_slice))?;
    let mut next = 0;
    let point = |index: &u32| {
        let item = items.nth(usize::try_from(*index - next).ok()?)?;
        next = index + 1;
        // The least value of a signed type is a little below -1.
        let value = |value: T| scale.map_or(value.into(), |scale| (value.into() / scale).max(-1.0));
        Some(item.map(value))
    };
    used.iter().map(point).collect()
}

/// Refuses an accessor that the crate would misread: in a release build its arithmetic wraps around.
fn check(accessor: &Accessor, shape: Dimensions, buffers: &[Vec<u8>]) -> Result<(), String> {
    let (count, size) = (accessor.count(), accessor.size());
    if accessor.dimensions() != shape {
        return Err(format!("its type is not {shape:?}"));
    }
    match accessor.view() {
        Some(view) => check_view(&view, accessor.offset(), count, size, buffers)?,
        None if count > buffers.iter().map(Vec::len).sum() => {
            return Err(format!("{count} elements without a bufferView are more than the file has bytes"));
        }
        None => {}
    }
    let Some(sparse) = accessor.sparse() else { return Ok(()) };
    let (indices, values) = (sparse.indices(), sparse.values());
    check_view(&values.view(), values.offset(), sparse.count(), size, buffers)?;
    check_view(&indices.view(), indices.offset(), sparse.count(), indices.index_type().size(), buffers)?;
    check_sparse(&sparse, count, buffers)
}

/// Refuses `count` elements of `size` bytes that are not all inside `view`, and a view that is not inside its buffer.
fn check_view(view: &View, offset: usize, count: usize, size: usize, buffers: &[Vec<u8>]) -> Result<(), String> {
    let stride = view.stride().unwrap_or(size);
    let have = buffers.get(view.buffer().index()).map_or(0, Vec::len);
    let is_inside = view.offset().checked_add(view.length()).is_some_and(|end| end <= have);
    let last = count.checked_sub(1).and_then(|before| before.checked_mul(stride)?.checked_add(offset));
    let end = last.and_then(|last| last.checked_add(size));
    if stride < size || !is_inside || end.is_none_or(|end| end > view.length()) {
        let index = view.index();
        return Err(format!(
            "{count} elements of {size} bytes from byte {offset} on are not inside bufferView {index}"
        ));
    }
    Ok(())
}

/// Refuses sparse indices that the crate would pass over: those that do not ascend, or are not below `count`.
fn check_sparse(sparse: &Sparse, count: usize, buffers: &[Vec<u8>]) -> Result<(), String> {
    let (indices, view) = (sparse.indices(), sparse.indices().view());
    let bytes =
        buffers.get(view.buffer().index()).and_then(|bytes| bytes.get(view.offset()..)?.get(indices.offset()..));
    let size = indices.index_type().size();
    let items = bytes.unwrap_or_default().chunks(view.stride().unwrap_or(size)).filter_map(|item| item.get(..size));
    let mut least = 0;
    for item in items.take(sparse.count()) {
        let index = item.iter().rev().fold(0, |index, byte| index << 8 | usize::from(*byte));
        if index < least || index >= count {
            return Err(format!("sparse index {index} is out of order, or out of range ({count} elements)"));
        }
        least = index + 1;
    }
    Ok(())
}

/// A coordinate rounded to `f32`, infinite if it is too large.
fn narrow(value: f64) -> f32 {
    #[expect(clippy::cast_possible_truncation, reason = "rounding to nearest is what is wanted")]
    let value = value as f32;
    value
}

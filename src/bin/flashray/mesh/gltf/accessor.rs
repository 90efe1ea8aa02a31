//! Accessors: typed elements in buffer views.
use serde_json::Value;

use super::Reader;
use super::buffer::Buffers;
use super::json;

/// The type of a component.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    /// The component type with this number in glTF.
    fn numbered(number: u64) -> Result<Self, String> {
        Ok(match number {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return Err(format!("componentType {number} is not one of glTF")),
        })
    }

    /// Its bytes.
    const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// Its value in the first of `bytes`; `f64` holds those of every type.
    fn value(self, bytes: &[u8]) -> Option<f64> {
        Some(match self {
            Self::I8 => i8::from_le_bytes(*bytes.first_chunk()?).into(),
            Self::U8 => u8::from_le_bytes(*bytes.first_chunk()?).into(),
            Self::I16 => i16::from_le_bytes(*bytes.first_chunk()?).into(),
            Self::U16 => u16::from_le_bytes(*bytes.first_chunk()?).into(),
            Self::U32 => u32::from_le_bytes(*bytes.first_chunk()?).into(),
            Self::F32 => f32::from_le_bytes(*bytes.first_chunk()?).into(),
        })
    }

    /// The three values that `bytes` starts with.
    fn position(self, bytes: &[u8], is_normalized: bool) -> [f64; 3] {
        let mut position = [0.0; 3];
        for (slot, bytes) in position.iter_mut().zip(bytes.chunks_exact(self.size())) {
            let value = self.value(bytes).unwrap_or(f64::NAN);
            // The least value of a signed type is a little below -1.
            *slot = if is_normalized { (value / self.scale()).max(-1.0) } else { value };
        }
        position
    }

    /// What a normalized value is divided by.
    const fn scale(self) -> f64 {
        match self {
            Self::I8 => 127.0,
            Self::U8 => 255.0,
            Self::I16 => 32_767.0,
            Self::U16 => 65_535.0,
            Self::U32 | Self::F32 => 1.0,
        }
    }

    /// An index, if this is one of the three types of indices.
    fn index(self, bytes: &[u8]) -> Option<u32> {
        match self {
            Self::U8 => bytes.first().copied().map(u32::from),
            Self::U16 => bytes.first_chunk().copied().map(u16::from_le_bytes).map(u32::from),
            Self::U32 => bytes.first_chunk().copied().map(u32::from_le_bytes),
            _ => None,
        }
    }
}

/// Elements at equal distances, all inside their buffer view.
struct Elements<'a> {
    bytes: &'a [u8],
    size: usize,
    stride: usize,
    count: usize,
}

impl<'a> Elements<'a> {
    /// The `count` elements of `size` bytes that `place` (an accessor or a part of one) refers to.
    fn new(buffers: &'a Buffers, place: &Value, size: usize, count: usize) -> Result<Self, String> {
        let view = json::index(place, "bufferView")?.ok_or("bufferView is missing")?;
        let (bytes, stride) = buffers.view(view)?;
        let start = json::number(place, "byteOffset")?.unwrap_or(0);
        let stride = stride.map_or(Ok(size), usize::try_from).map_err(|_| "byteStride is too large")?;
        if stride < size {
            return Err(format!("a byteStride of {stride} for elements of {size} bytes"));
        }
        let wide = |value: usize| u128::try_from(value).unwrap_or(u128::MAX);
        let span = match count.checked_sub(1) {
            None => 0,
            Some(before) => wide(before).saturating_mul(wide(stride)).saturating_add(wide(size)),
        };
        let end = span.saturating_add(u128::from(start));
        if end > wide(bytes.len()) {
            let have = bytes.len();
            return Err(format!("{count} elements need {end} bytes, bufferView {view} has {have}"));
        }
        let bytes = usize::try_from(start).ok().and_then(|start| bytes.get(start..));
        Ok(Self { bytes: bytes.unwrap_or_default(), size, stride, count })
    }

    /// The bytes of each element, in order.
    fn iter(&self) -> impl Iterator<Item = &'a [u8]> {
        // The last element may end before a whole stride does.
        self.bytes.chunks(self.stride).take(self.count).filter_map(|chunk| chunk.get(..self.size))
    }
}

/// What an accessor states about its elements.
struct Layout<'a> {
    accessor: &'a Value,
    component: Component,
    count: usize,
}

impl<'a> Layout<'a> {
    /// The layout of an accessor whose elements are of the type `shape`.
    fn new(root: &'a Value, index: usize, shape: &str) -> Result<Self, String> {
        let accessor = json::item(root, "accessors", index)?;
        if accessor.get("type").and_then(Value::as_str) != Some(shape) {
            return Err(format!("accessor {index}: its type is not {shape}"));
        }
        let parts = || {
            let component = Component::numbered(json::needed(accessor, "componentType")?)?;
            let count = json::index(accessor, "count")?.ok_or("count is missing")?;
            Ok(Self { accessor, component, count })
        };
        parts().map_err(|why: String| format!("accessor {index}: {why}"))
    }
}

impl Reader<'_> {
    /// Reads the positions in an accessor into [`Self::recent`].
    pub(super) fn load_positions(&mut self, index: usize) -> Result<(), String> {
        if self.recent.as_ref().is_none_or(|(recent, _)| *recent != index) {
            let layout = Layout::new(self.root, index, "VEC3")?;
            let found = self.positions(&layout).map_err(|why| format!("accessor {index}: {why}"))?;
            self.recent = Some((index, found));
        }
        Ok(())
    }

    /// The positions of an accessor, all finite.
    fn positions(&self, layout: &Layout) -> Result<Vec<[f64; 3]>, String> {
        let Layout { accessor, component, .. } = *layout;
        if component == Component::U32 {
            return Err("its componentType is not one of positions".into());
        }
        let is_normalized = accessor.get("normalized").and_then(Value::as_bool) == Some(true);
        let decode = |bytes: &[u8]| component.position(bytes, is_normalized);
        let mut positions = self.stored_positions(layout, decode)?;
        if let Some(sparse) = accessor.get("sparse") {
            let size = 3 * component.size();
            self.replace(sparse, size, decode, &mut positions).map_err(|why| format!("sparse: {why}"))?;
        }
        let is_broken = |position: &[f64; 3]| position.iter().any(|value| !value.is_finite());
        match positions.iter().position(is_broken) {
            Some(vertex) => Err(format!("vertex {vertex} is not finite")),
            None => Ok(positions),
        }
    }

    /// The positions in the buffer view of an accessor; zeros if a sparse one has none.
    fn stored_positions(&self, layout: &Layout, decode: impl Fn(&[u8]) -> [f64; 3]) -> Result<Vec<[f64; 3]>, String> {
        let Layout { accessor, component, count } = *layout;
        if accessor.get("bufferView").is_some() {
            let elements = Elements::new(&self.buffers, accessor, 3 * component.size(), count)?;
            return Ok(elements.iter().map(decode).collect());
        }
        if accessor.get("sparse").is_none() {
            return Err("has no bufferView (is the mesh compressed?)".into());
        }
        if count > self.size {
            let size = self.size;
            return Err(format!("{count} elements without a bufferView, in a file of {size} bytes"));
        }
        Ok(vec![[0.0; 3]; count])
    }

    /// Replaces the elements that a sparse accessor lists.
    fn replace(
        &self,
        sparse: &Value,
        size: usize,
        decode: impl Fn(&[u8]) -> [f64; 3],
        positions: &mut [[f64; 3]],
    ) -> Result<(), String> {
        let count = json::index(sparse, "count")?.ok_or("count is missing")?;
        let indices = sparse.get("indices").ok_or("indices are missing")?;
        let values = sparse.get("values").ok_or("values are missing")?;
        let component = Component::numbered(json::needed(indices, "componentType")?)?;
        let values = Elements::new(&self.buffers, values, size, count)?;
        let places = Elements::new(&self.buffers, indices, component.size(), count)?;
        let length = positions.len();
        for (place, value) in places.iter().zip(values.iter()) {
            let place = component.index(place).ok_or("its indices are not of an unsigned type")?;
            let slot = usize::try_from(place).ok().and_then(|place| positions.get_mut(place));
            *slot.ok_or_else(|| format!("index {place} is out of range ({length} elements)"))? = decode(value);
        }
        Ok(())
    }

    /// The indices in an accessor, all below `vertices`.
    pub(super) fn indices(&self, index: usize, vertices: usize) -> Result<Vec<u32>, String> {
        let layout = Layout::new(self.root, index, "SCALAR")?;
        let Layout { accessor, component, count } = layout;
        let read = || {
            if accessor.get("sparse").is_some() {
                return Err("sparse indices are not supported".into());
            }
            let elements = Elements::new(&self.buffers, accessor, component.size(), count)?;
            let mut indices = Vec::with_capacity(elements.count);
            for (number, bytes) in elements.iter().enumerate() {
                let value = component.index(bytes).ok_or("its componentType is not one of indices")?;
                if usize::try_from(value).map_or(true, |value| value >= vertices) {
                    return Err(format!(
                        "element {number}: vertex index {value} is out of range (the primitive has \
                         {vertices} vertices)"
                    ));
                }
                indices.push(value);
            }
            Ok(indices)
        };
        read().map_err(|why: String| format!("accessor {index}: {why}"))
    }
}

//! Where the readers put vertices and triangles, with the limits that all formats share.
use crate::soup::Soup;

/// The greatest number of triangles in one mesh: numbers of primitives have 28 bits.
pub const MAX_TRIANGLES: usize = (1 << 28) - 1;

/// A [`Soup`] in the making.
pub struct Sink {
    soup: Soup,
    limit: usize,
}

impl Sink {
    /// An empty mesh.
    pub fn new() -> Self {
        Self::with_limit(MAX_TRIANGLES)
    }

    /// An empty mesh that takes at most `limit` triangles.
    fn with_limit(limit: usize) -> Self {
        Self { soup: Soup::default(), limit }
    }

    /// The number of vertices so far.
    pub fn vertices(&self) -> usize {
        self.soup.positions.len()
    }

    /// Adds a vertex and returns its index. The caller has checked that it is finite.
    pub fn vertex(&mut self, position: [f32; 3]) -> Result<u32, String> {
        let index = u32::try_from(self.soup.positions.len()).map_err(|_| format!("more than {} vertices", u32::MAX))?;
        self.soup.positions.push(position);
        Ok(index)
    }

    /// Adds a triangle. The caller has checked the indices, or will before it calls [`Self::finish`].
    pub fn triangle(&mut self, corners: [u32; 3]) -> Result<(), String> {
        if self.soup.triangles.len() >= self.limit {
            return Err(format!("more than {} triangles, the most a mesh may have", self.limit));
        }
        self.soup.triangles.push(corners);
        Ok(())
    }

    /// The finished mesh.
    pub fn finish(self) -> Soup {
        self.soup
    }
}

/// A polygon that becomes a fan of triangles from its first corner while its corners arrive.
#[derive(Default)]
pub struct Fan {
    first: u32,
    last: u32,
    corners: u64,
}

impl Fan {
    /// Adds the next corner, and with it a triangle from the third corner on.
    pub fn corner(&mut self, index: u32, sink: &mut Sink) -> Result<(), String> {
        match self.corners {
            0 => self.first = index,
            1 => {}
            _ => sink.triangle([self.first, self.last, index])?,
        }
        self.last = index;
        self.corners += 1;
        Ok(())
    }

    /// Ends the polygon: fewer than three corners are an error.
    pub fn finish(self) -> Result<(), String> {
        if self.corners < 3 {
            return Err(format!("a face needs at least 3 corners, this one has {}", self.corners));
        }
        Ok(())
    }
}

/// A coordinate rounded to `f32`; none if it is not finite there.
pub fn narrow(value: f64) -> Option<f32> {
    #[expect(clippy::cast_possible_truncation, reason = "rounding to nearest is what is wanted")]
    let value = value as f32;
    value.is_finite().then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fan_starts_at_its_first_corner() {
        let (mut sink, mut fan) = (Sink::new(), Fan::default());
        for index in [7, 3, 5, 9] {
            fan.corner(index, &mut sink).unwrap();
        }
        fan.finish().unwrap();
        assert_eq!(sink.finish().triangles, [[7, 3, 5], [7, 5, 9]]);
    }

    #[test]
    fn the_triangle_limit_holds() {
        let mut sink = Sink::with_limit(2);
        sink.triangle([0; 3]).unwrap();
        sink.triangle([0; 3]).unwrap();
        let error = sink.triangle([0; 3]).unwrap_err();
        assert_eq!(error, "more than 2 triangles, the most a mesh may have");
        assert_eq!(MAX_TRIANGLES, 268_435_455);
    }

    #[test]
    fn narrowing_refuses_what_overflows() {
        assert_eq!(narrow(0.1), Some(0.1));
        assert_eq!(narrow(1e39), None);
        assert_eq!(narrow(f64::NAN), None);
    }
}

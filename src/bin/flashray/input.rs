//! The inputs of `build`: files and procedural scenes.
use crate::soup::Soup;
use crate::{Failure, mesh, spd};
use std::path::Path;

/// What `IN` names: a mesh file, or `spd:NAME[:SIZE]`.
pub fn read(input: &str) -> Result<Soup, Failure> {
    match input.strip_prefix("spd:") {
        Some(spec) => Ok(spd::scene(spec)?.soup),
        None => mesh::read(Path::new(input)),
    }
}

/// All inputs as one scene, each kind's primitives in the order of the inputs.
pub fn read_all(inputs: &[String]) -> Result<Soup, Failure> {
    let mut all = Soup::default();
    for input in inputs {
        all.append(read(input)?).map_err(|why| format!("{input}: {why}"))?;
    }
    Ok(all)
}

impl Soup {
    fn append(&mut self, other: Self) -> Result<(), Failure> {
        let shift = u32::try_from(self.positions.len()).ok();
        let last = u32::try_from(self.positions.len() + other.positions.len()).ok();
        let (Some(shift), Some(_)) = (shift, last) else {
            return Err("more than 2^32 vertices in all".into());
        };
        self.positions.extend(other.positions);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + shift)));
        self.spheres.extend(other.spheres);
        self.boxes.extend(other.boxes);
        self.cylinders.extend(other.cylinders);
        self.cones.extend(other.cones);
        Ok(())
    }
}

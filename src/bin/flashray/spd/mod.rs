//! The eleven procedural scenes behind `spd:NAME[:SIZE]`.
//!
//! The scenes are those of Eric Haines, *Standard Procedural Databases* (CC0), the usual yardstick
//! for ray tracing structures since 1987. The code here is our own; the definitions were compared
//! with the output of the original generators, and each scene's [`Anchor`] holds the hit count that
//! fixes it. What a size may be, so that at most 2^24 primitives come out:
//!
//! | scene | default | sizes | triangles | other primitives |
//! |---|---|---|---|---|
//! | balls | 4 | 0 to 7 | 2 | (9^(S+1) - 1) / 8 spheres |
//! | gears | 4 | 1 to 30 | 572 S^3 + 2, of 146 S^3 + 1 polygons | |
//! | lattice | 12 | 1 to 160 | | (S+1)^3 spheres, 3 S (S+1)^2 cylinders |
//! | mount | 6 | 0 to 7 | 2 4^S | 4 spheres |
//! | rings | 7 | 1 to 93 | 2 | 5 S (S+1) (2S+1) cylinders, as many spheres |
//! | teapot | 12 | 1 to 504 | 66 S^2 - 8 S | |
//! | tetra | 6 | 1 to 12 | 4^S | |
//! | tree | 11 | 0 to 22 | 2 | 2^(S+1) - 1 cones, as many spheres |
//! | shells | 5 | 0 to 16 | | 180 2^S + 1 spheres |
//! | jacks | 3 | 1 to 7 | | 6 (8^S - 1) / 7 spheres, half as many cylinders |
//! | sombrero | 2 | 1 to 7 | 2 (32 2^(S-1) - 1)^2 | |
//!
//! (The random numbers of mount are defined for sizes up to 7 only.) Cylinders and cones are open.
//! A scene is computed in `f64`, with the sines and logarithms of `libm` so that every host gets the
//! same bits, and rounded once to `f32` where it enters the [`Soup`].
mod balls;
mod frame;
mod gears;
mod jacks;
mod lattice;
mod mount;
mod polygon;
mod rings;
mod shells;
mod sink;
mod sombrero;
mod teapot;
#[cfg(test)]
mod tests;
mod tetra;
mod tree;
mod view;

use crate::soup::Soup;
pub use sink::Sink;
pub use view::View;

/// A generated scene with what is needed to look at it.
pub struct Spd {
    /// Its name, one of [`NAMES`].
    pub name: &'static str,
    /// The size it was generated for.
    pub size: u32,
    /// The primitives.
    pub soup: Soup,
    /// The view the published counts were measured with.
    pub view: View,
    /// Point lights, for shadow rays.
    pub lights: Vec<[f64; 3]>,
    /// What the test view must show; known for the default size.
    pub anchor: Option<Anchor>,
}

/// What 513 x 513 rays of the test view find at the default size, all in `f64`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchor {
    /// Rays that hit something, by brute force over the unrounded scene.
    pub hits_ours: u32,
    /// The count Havran published, where there is one; it differs by a few rays at silhouettes.
    pub hits_published: Option<u32>,
    /// Mean distance of the hits along unit directions.
    pub mean_t: f64,
}

/// How one scene is made; each scene's file holds its own.
struct Recipe {
    name: &'static str,
    /// The published size.
    default: u32,
    /// Least and greatest size.
    sizes: [u32; 2],
    /// Sends the primitives for a size.
    build: fn(u32, &mut dyn Sink),
    /// View and lights for a size.
    setting: fn(u32) -> (View, Vec<[f64; 3]>),
    /// For the default size.
    anchor: Anchor,
}

/// In the order of the published tables.
const RECIPES: [Recipe; 11] = [
    balls::RECIPE,
    gears::RECIPE,
    lattice::RECIPE,
    mount::RECIPE,
    rings::RECIPE,
    teapot::RECIPE,
    tetra::RECIPE,
    tree::RECIPE,
    shells::RECIPE,
    jacks::RECIPE,
    sombrero::RECIPE,
];

/// The names of the scenes.
pub const NAMES: [&str; 11] = {
    let mut names = [""; 11];
    let mut i = 0;
    while i < names.len() {
        names[i] = RECIPES[i].name;
        i += 1;
    }
    names
};

/// Generates a scene; `spec` is what follows `spd:` on the command line: `balls` or `balls:2`.
///
/// # Errors
/// One line that says what is wrong with `spec`.
pub fn scene(spec: &str) -> Result<Spd, String> {
    let mut soup = Soup::default();
    let (recipe, size) = build(spec, &mut soup)?;
    let (view, lights) = (recipe.setting)(size);
    let anchor = (size == recipe.default).then_some(recipe.anchor);
    Ok(Spd { name: recipe.name, size, soup, view, lights, anchor })
}

/// Sends the primitives of the scene `spec` to `out`, unrounded.
fn build(spec: &str, out: &mut dyn Sink) -> Result<(&'static Recipe, u32), String> {
    let (recipe, size) = parse(spec)?;
    (recipe.build)(size, out);
    Ok((recipe, size))
}

/// Splits `NAME[:SIZE]` and checks both.
fn parse(spec: &str) -> Result<(&'static Recipe, u32), String> {
    let (name, size) = match spec.split_once(':') {
        Some((name, size)) => (name, Some(size)),
        None => (spec, None),
    };
    let Some(recipe) = RECIPES.iter().find(|recipe| recipe.name == name) else {
        let names = NAMES.join(", ");
        return Err(format!("spd:{name}: no such scene; the scenes are {names}"));
    };
    let Some(size) = size else {
        return Ok((recipe, recipe.default));
    };
    let [least, greatest] = recipe.sizes;
    match size.parse() {
        Ok(size) if (least..=greatest).contains(&size) => Ok((recipe, size)),
        _ => Err(format!("spd:{spec}: size must be {least} to {greatest}")),
    }
}

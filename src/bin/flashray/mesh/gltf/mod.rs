//! glTF 2.0 and its binary form GLB: the triangles of a scene with the transforms of its nodes, read by the crate gltf.
//!
//! The crate reads the JSON, the chunks of GLB and the elements of accessors. It panics on indices and sizes that make
//! no sense, so its own validation comes first, all under the guard, and what it would misread without a panic is
//! checked here. The bytes of buffers, the transforms in `f64` and the triangles of strips and fans are ours too.
//!
//! Materials, skins, morph targets and animations are skipped: a mesh is read as its vertices are stored. Points and
//! lines are skipped. A fan of triangles starts each of them at its first corner, as the polygons of the other formats
//! do.
mod buffer;
mod primitive;
mod transform;

use std::collections::HashSet;
use std::path::Path;

use gltf::json::validation::{Error as Fault, Validate};
use gltf::json::{self, Root};
use gltf::{Document, Gltf, Mesh, Node};

use super::guard::guarded;
use super::text::{self, quote};
use super::{MAX_TRIANGLES, too_many};
use crate::soup::Soup;
use transform::Transform;

/// Reads a `.gltf` file; its buffers are in it, or in files in `folder`.
pub fn read(data: &[u8], folder: &Path) -> Result<Soup, String> {
    guarded(|| {
        let Gltf { document, blob } =
            Gltf::from_slice_without_validation(text::without_mark(data)).map_err(|error| match error {
                gltf::Error::Deserialize(error) => format!("JSON: {error}"),
                error => error.to_string(),
            })?;
        check_root(document.as_json())?;
        let buffers = buffer::load(&document, blob, folder)?;
        let instances = instances(&document)?;
        check_size(&document, &instances)?;
        let mut soup = Soup::default();
        for instance in &instances {
            instance.read(&buffers, &mut soup)?;
        }
        Ok::<_, String>(soup)
    })
}

/// Reads a `.glb` file; its buffers are in it, or in files in `folder`.
pub fn read_binary(data: &[u8], folder: &Path) -> Result<Soup, String> {
    if !data.starts_with(b"glTF") {
        return Err("not a binary glTF file: it does not start with \"glTF\"".into());
    }
    // Bytes after the stated length do not belong to the model, but the crate takes them for a chunk.
    let stated = data.get(8..12).and_then(<[u8]>::first_chunk).copied().map(u32::from_le_bytes);
    let Some(stated) = stated else {
        return Err(format!("cut short: a binary glTF header has 12 bytes, the file has {}", data.len()));
    };
    let model = usize::try_from(stated).ok().and_then(|length| data.get(..length));
    let Some(model) = model else {
        return Err(format!("cut short: its header says {stated} bytes, the file has {}", data.len()));
    };
    read(model, folder)
}

/// Refuses versions and required extensions that are not known, and what the crate finds wrong.
fn check_root(root: &Root) -> Result<(), String> {
    let version = &root.asset.version;
    if version != "2" && !version.starts_with("2.") {
        return Err(format!("glTF version {} is not 2.0", quote(version.as_bytes())));
    }
    // The extensions of materials, textures and lights leave the geometry alone.
    let looks = ["KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_lights_"];
    let is_known = |name: &str| name == "KHR_mesh_quantization" || looks.iter().any(|start| name.starts_with(start));
    if let Some(name) = root.extensions_required.iter().find(|name| !is_known(name)) {
        let packed = name.contains("draco") || name.contains("meshopt");
        let advice = if packed { "; save the model without compression" } else { "" };
        return Err(format!("requires the extension {}, which is not supported{advice}", quote(name.as_bytes())));
    }
    let mut first = None;
    let outcome = guarded(|| {
        root.validate(root, json::Path::new, &mut |path: &dyn Fn() -> json::Path, fault: Fault| {
            if first.is_none() {
                first = Some(format!("{}: {fault}", path())).filter(|fault| matters(fault));
            }
        });
        Ok::<_, String>(())
    });
    // After some faults the validation itself panics: the fault says more.
    first.map_or(outcome, Err)
}

/// True for a fault of the geometry; but many writers leave out the bounds of positions, which nobody needs, and the
/// crate does not know attributes of names that start with `_`.
fn matters(fault: &str) -> bool {
    let parts = ["accessors", "bufferViews", "buffers", "meshes", "nodes", "scene"];
    let spared = [".min: ", ".max: ", "<invalid semantic name>"];
    parts.iter().any(|part| fault.starts_with(part)) && !spared.iter().any(|part| fault.contains(part))
}

/// A mesh in the scene.
struct Instance<'a> {
    /// The node that it belongs to; none if the file has no nodes.
    node: Option<usize>,
    mesh: Mesh<'a>,
    world: Transform,
}

impl Instance<'_> {
    /// Adds the triangles of the mesh to `soup`.
    fn read(&self, buffers: &[Vec<u8>], soup: &mut Soup) -> Result<(), String> {
        for (number, primitive) in self.mesh.primitives().enumerate() {
            guarded(|| primitive::read(&primitive, &self.world, buffers, soup)).map_err(|why| {
                let node = self.node.map(|node| format!("node {node}: ")).unwrap_or_default();
                format!("{node}mesh {}, primitive {number}: {why}", self.mesh.index())
            })?;
        }
        Ok(())
    }
}

/// Refuses a scene with too many triangles before any of them is made: a small file may repeat a mesh very often.
fn check_size(document: &Document, instances: &[Instance]) -> Result<(), String> {
    let sizes: Vec<usize> = document
        .meshes()
        .map(|mesh| mesh.primitives().map(|primitive| primitive::size(&primitive)).fold(0, usize::saturating_add))
        .collect();
    let all = instances.iter().filter_map(|instance| sizes.get(instance.mesh.index()).copied());
    if all.fold(0, usize::saturating_add) > MAX_TRIANGLES { Err(too_many()) } else { Ok(()) }
}

/// All meshes of the scene, that of each node before those of its children.
fn instances(document: &Document) -> Result<Vec<Instance<'_>>, String> {
    if document.nodes().len() == 0 {
        let alone = |mesh| Instance { node: None, mesh, world: Transform::IDENTITY };
        return Ok(document.meshes().map(alone).collect());
    }
    let mut seen = HashSet::new();
    let mut waiting: Vec<_> = roots(document).into_iter().map(|node| (node, Transform::IDENTITY)).collect();
    waiting.retain(|(node, _)| seen.insert(node.index()));
    waiting.reverse();
    let mut found = Vec::new();
    // A stack of our own: a deep chain of nodes must not end the call stack.
    while let Some((node, parent)) = waiting.pop() {
        let index = node.index();
        let local = Transform::of_node(&node.transform()).map_err(|why| format!("node {index}: {why}"))?;
        let world = parent.of_child(&local);
        let mut children = Vec::new();
        for child in node.children() {
            // Also what keeps a cycle from going on for ever.
            if !seen.insert(child.index()) {
                return Err(format!("node {index}: its child {} belongs to another node or is a root", child.index()));
            }
            children.push((child, world.clone()));
        }
        waiting.extend(children.into_iter().rev());
        if let Some(mesh) = node.mesh() {
            found.push(Instance { node: Some(index), mesh, world });
        }
    }
    Ok(found)
}

/// The nodes to start from: those of the default scene, or of all scenes if none is the default, or all that are no
/// other node's child if there are no scenes.
fn roots(document: &Document) -> Vec<Node<'_>> {
    if let Some(scene) = document.default_scene() {
        return scene.nodes().collect();
    }
    if document.scenes().len() > 0 {
        return document.scenes().flat_map(|scene| scene.nodes()).collect();
    }
    let children: HashSet<usize> =
        document.nodes().flat_map(|node| node.children()).map(|child| child.index()).collect();
    document.nodes().filter(|node| !children.contains(&node.index())).collect()
}

#[cfg(test)]
mod tests;

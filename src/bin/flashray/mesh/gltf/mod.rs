//! glTF 2.0 and its binary form GLB: the triangles of a scene with the transforms of its nodes.
//!
//! Our own reader over `serde_json` rather than the crate gltf, because that crate panics on
//! hostile files, in its validation too, and a release build cannot contain a panic. Every range is
//! computed in checked 64-bit arithmetic and compared with the bytes that are there.
//!
//! Materials, skins, morph targets and animations are skipped: a mesh is read as its vertices are
//! stored. Points and lines are skipped. A fan of triangles starts each of them at its first
//! corner, as the polygons of the other formats do.
mod accessor;
mod buffer;
mod glb;
mod json;
mod primitive;
mod transform;

use std::collections::HashSet;
use std::path::Path;

use serde_json::Value;

use super::sink::Sink;
use super::text;
use crate::soup::Soup;
use buffer::Buffers;
use transform::Transform;

/// Reads a `.gltf` file; its buffers are in it, or in files in `folder`.
pub fn read(data: &[u8], folder: &Path) -> Result<Soup, String> {
    document(text::without_mark(data), None, folder, data.len())
}

/// Reads a `.glb` file.
pub fn read_binary(data: &[u8], folder: &Path) -> Result<Soup, String> {
    let (json, chunk) = glb::split(data)?;
    document(json, chunk, folder, data.len())
}

/// Reads the JSON of either form; `size` is the length of the file.
fn document(json: &[u8], chunk: Option<&[u8]>, folder: &Path, size: usize) -> Result<Soup, String> {
    let root: Value = serde_json::from_slice(json).map_err(|error| format!("JSON: {error}"))?;
    check_version(&root)?;
    check_extensions(&root)?;
    let buffers = Buffers::new(&root, chunk, folder)?;
    let mut reader = Reader { root: &root, buffers, size, sink: Sink::new(), recent: None };
    reader.scene()?;
    Ok(reader.sink.finish())
}

/// Refuses other versions: version 1 has another structure.
fn check_version(root: &Value) -> Result<(), String> {
    let version = root.get("asset").and_then(|asset| asset.get("version")).and_then(Value::as_str);
    match version {
        Some(version) if version == "2" || version.starts_with("2.") => Ok(()),
        Some(version) => Err(format!("glTF version {} is not 2.0", text::quote(version.as_bytes()))),
        None => Err("not a glTF file: the JSON has no asset.version".into()),
    }
}

/// Refuses files that cannot be understood without an extension that changes the geometry.
fn check_extensions(root: &Value) -> Result<(), String> {
    for name in json::list(root, "extensionsRequired")? {
        let name = name.as_str().ok_or("extensionsRequired holds something else than names")?;
        // Those of materials, textures and lights leave the geometry alone.
        let looks = ["KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "KHR_lights_"];
        if name == "KHR_mesh_quantization" || looks.iter().any(|start| name.starts_with(start)) {
            continue;
        }
        let name = text::quote(name.as_bytes());
        let packed = name.contains("draco") || name.contains("meshopt");
        let advice = if packed { "; save the model without compression" } else { "" };
        return Err(format!("requires the extension {name}, which is not supported{advice}"));
    }
    Ok(())
}

/// The state while the scene is walked.
struct Reader<'a> {
    root: &'a Value,
    buffers: Buffers<'a>,
    /// The length of the file: no accessor without bytes of its own may have more elements.
    size: usize,
    sink: Sink,
    /// The positions read last, with their accessor: primitives often share them.
    recent: Option<(usize, Vec<[f64; 3]>)>,
}

impl Reader<'_> {
    /// Reads all nodes of the scene, each before its children.
    fn scene(&mut self) -> Result<(), String> {
        if json::list(self.root, "nodes")?.is_empty() {
            let meshes = json::list(self.root, "meshes")?.len();
            return (0..meshes).try_for_each(|mesh| self.mesh(mesh, &Transform::IDENTITY));
        }
        let mut seen = HashSet::new();
        let mut waiting = Vec::new();
        for root in self.roots()? {
            if seen.insert(root) {
                waiting.push((root, Transform::IDENTITY));
            }
        }
        waiting.reverse();
        // A stack of our own: a deep chain of nodes must not end the call stack.
        while let Some((index, parent)) = waiting.pop() {
            let node = json::item(self.root, "nodes", index)?;
            let children = self.node(index, node, &parent, &mut seen)?;
            waiting.extend(children.into_iter().rev());
        }
        Ok(())
    }

    /// The nodes to start from: those of the default scene, or of all scenes if none is the
    /// default, or all that are no other node's child if there are no scenes.
    fn roots(&self) -> Result<Vec<usize>, String> {
        if let Some(scene) = json::index(self.root, "scene")? {
            return json::indices(json::item(self.root, "scenes", scene)?, "nodes");
        }
        let scenes = json::list(self.root, "scenes")?;
        let mut found = Vec::new();
        for scene in scenes {
            found.extend(json::indices(scene, "nodes")?);
        }
        if scenes.is_empty() {
            let nodes = json::list(self.root, "nodes")?;
            let mut children = HashSet::new();
            for node in nodes {
                children.extend(json::indices(node, "children")?);
            }
            found.extend((0..nodes.len()).filter(|node| !children.contains(node)));
        }
        Ok(found)
    }

    /// Reads the mesh of a node, and returns its children with their transform.
    fn node(
        &mut self,
        index: usize,
        node: &Value,
        parent: &Transform,
        seen: &mut HashSet<usize>,
    ) -> Result<Vec<(usize, Transform)>, String> {
        let named = |why| format!("node {index}: {why}");
        let world = parent.of_child(&Transform::of_node(node).map_err(named)?);
        if let Some(mesh) = json::index(node, "mesh").map_err(named)? {
            self.mesh(mesh, &world).map_err(named)?;
        }
        let mut children = Vec::new();
        for child in json::indices(node, "children").map_err(named)? {
            // Also what keeps a cycle from going on for ever.
            if !seen.insert(child) {
                return Err(named(format!("its child {child} belongs to another node or is a root")));
            }
            children.push((child, world.clone()));
        }
        Ok(children)
    }

    /// Reads a mesh.
    fn mesh(&mut self, index: usize, world: &Transform) -> Result<(), String> {
        let mesh = json::item(self.root, "meshes", index)?;
        let primitives = json::list(mesh, "primitives").map_err(|why| format!("mesh {index}: {why}"))?;
        for (number, primitive) in primitives.iter().enumerate() {
            self.primitive(primitive, world).map_err(|why| format!("mesh {index}, primitive {number}: {why}"))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;

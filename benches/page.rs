//! The tables in docs/structures.md.
use std::fs;
use std::path::Path;

/// The page, from the repository's root.
pub const PAGE: &str = "docs/structures.md";

/// Puts a text between the page's two marks of a name.
pub fn put(name: &str, new: &str) -> Result<(), String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(PAGE);
    let failure = |e: std::io::Error| format!("{PAGE}: {e}");
    let old = fs::read_to_string(&path).map_err(failure)?;
    let marks = [format!("<!-- {name} -->\n"), format!("<!-- end of {name} -->")];
    let (Some(begin), Some(end)) = (old.find(&marks[0]), old.find(&marks[1])) else {
        return Err(format!("{PAGE}: no marks {}", marks.concat()));
    };
    fs::write(&path, [&old[..begin + marks[0].len()], new, &old[end..]].concat()).map_err(failure)
}

//! `flashray emit`.
use crate::{Failure, file};
use clap::ValueEnum;
use flashray::Scene;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub struct Args {
    /// The blob
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The language
    #[arg(long = "as", value_enum, value_name = "LANG")]
    language: Language,
    /// The source file to write; a C array also gets a header beside it, with the ending .h
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// The name of the static or array; by default SCENE in Rust, scene in C
    #[arg(long, value_parser = identifier)]
    name: Option<String>,
    /// The linker section to put it in, for example .xip
    #[arg(long, value_parser = section)]
    section: Option<String>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Language {
    Rust,
    C,
}

fn identifier(text: &str) -> Result<String, String> {
    let fits = text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    let starts = text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    if fits && starts { Ok(text.into()) } else { Err(format!("`{text}` is not a name of letters, digits and _")) }
}

fn section(text: &str) -> Result<String, String> {
    let fits = !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || "._-$".contains(c));
    if fits { Ok(text.into()) } else { Err(format!("`{text}` is not the name of a section")) }
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let bytes = file::read(&args.file)?;
    let scene = file::scene(&args.file, &bytes)?;
    let limits = scene.limits();
    let facts = format!(
        "{}, {} primitives, {} bytes; worst case stack {} entries, {} steps.",
        scene.kind().name(),
        scene.len(),
        bytes.len(),
        limits.stack,
        limits.steps
    );
    match args.language {
        Language::Rust => file::write(&args.output, rust(args, &bytes, &facts).as_bytes())?,
        Language::C => {
            let header = args.output.with_extension("h");
            if header == args.output {
                return Err(format!("{}: the array needs a file of its own, ending in .c", header.display()));
            }
            let (declaration, array) = (c_header(args, &bytes, &scene, &facts), c_array(args, &bytes, &header));
            file::write_all(&[(&header, declaration.as_bytes()), (&args.output, array.as_bytes())])?;
        }
    }
    file::say(&format!("{}: {} bytes", args.output.display(), bytes.len()))
}

/// A module with an aligned static: the bytes as one literal, which compiles fast at any size.
fn rust(args: &Args, bytes: &[u8], facts: &str) -> String {
    let name = args.name.as_deref().unwrap_or("SCENE");
    let mut text = String::with_capacity(bytes.len() * 4 + bytes.len() / 8 + 1024);
    text.push_str("// Made by `flashray emit`. Do not edit.\n\n");
    text.push_str("/// Bytes at a multiple of 64, the alignment at which a blob is fastest.\n");
    text.push_str("#[repr(C, align(64))]\npub struct Aligned<const N: usize>(pub [u8; N]);\n\n");
    let _ = writeln!(text, "/// {facts}\n///\n/// Load it with `flashray::Scene::from_bytes(&{name}.0)`.");
    if let Some(section) = &args.section {
        let _ = writeln!(text, "#[unsafe(link_section = \"{section}\")]");
    }
    let _ = write!(text, "pub static {name}: Aligned<{}> = Aligned(*b\"", bytes.len());
    for line in bytes.chunks(32) {
        text.push_str("\\\n    ");
        for byte in line {
            let _ = write!(text, "\\x{byte:02x}");
        }
    }
    text.push_str("\");\n");
    text
}

fn c_name(args: &Args) -> &str {
    args.name.as_deref().unwrap_or("scene")
}

fn c_header(args: &Args, bytes: &[u8], scene: &Scene<'_>, facts: &str) -> String {
    let (name, limits) = (c_name(args), scene.limits());
    let guard = name.to_ascii_uppercase();
    format!(
        "/* Made by `flashray emit`. Do not edit. */\n#ifndef {guard}_H\n#define {guard}_H\n\n#include <stdint.h>\n\n\
         /* {facts} */\n#define {guard}_BYTES {}u\n#define {guard}_STACK {}u\n#define {guard}_STEPS {}u\n\n\
         #ifdef __cplusplus\nextern \"C\" {{\n#endif\n\n\
         /* The blob, as words so that it is aligned; its first {guard}_BYTES bytes count. Little-endian targets only. */\n\
         extern const uint32_t {name}[{}];\n\n#ifdef __cplusplus\n}}\n#endif\n\n#endif\n",
        bytes.len(),
        limits.stack,
        limits.steps,
        bytes.len().div_ceil(4)
    )
}

fn c_array(args: &Args, bytes: &[u8], header: &Path) -> String {
    let name = c_name(args);
    let header = header.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let section = args.section.as_ref().map_or_else(String::new, |s| format!(", section(\"{s}\")"));
    let mut text = String::with_capacity(bytes.len() * 3 + 1024);
    let _ = write!(
        text,
        "/* Made by `flashray emit`. Do not edit. */\n#include \"{header}\"\n\n\
         #if defined(__GNUC__)\n__attribute__((aligned(64){section}))\n#endif\n\
         const uint32_t {name}[{}] = {{",
        bytes.len().div_ceil(4)
    );
    for (i, word) in bytes.chunks(4).enumerate() {
        let value = word.iter().rev().fold(0u32, |v, &b| v << 8 | u32::from(b));
        let _ = write!(text, "{}0x{value:08x},", if i % 8 == 0 { "\n    " } else { " " });
    }
    text.push_str("\n};\n");
    text
}

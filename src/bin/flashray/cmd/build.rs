//! `flashray build`.
use crate::{Failure, args, file, input};
use clap::ValueEnum;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use flashray::Kind;
use flashray::blob::KINDS;
use flashray::build::{Config, MOST_CELLS, Quality, Rule, to_vec};
use std::path::PathBuf;
use std::time::Instant;

#[derive(clap::Args)]
pub struct Args {
    /// OBJ, PLY, STL, glTF or GLB files, or spd:NAME[:SIZE]; several become one scene
    #[arg(required = true, value_name = "IN")]
    inputs: Vec<String>,
    /// The blob to write
    #[arg(short, long, value_name = "OUT.fray")]
    output: PathBuf,
    /// The acceleration structure
    #[arg(long, value_parser = structures(), default_value = "bvh")]
    structure: Kind,
    /// How it splits: the textbook's rule, or the surface-area heuristic
    #[arg(long, value_enum, default_value = "sah")]
    rule: Split,
    /// How much time --rule sah may take for bvh, sphere and wide: for the same answers, and faster rays
    #[arg(long, value_enum, default_value = "default")]
    quality: Effort,
    /// Most primitives of a leaf of bvh and sphere; octree and bsp cut what has more by --rule seed, where that helps, and
    /// octree looks farther ahead by --rule sah. The others have no such limit
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=15))]
    leaf: u32,
    /// Most children of a node of wide: nodes of four are half as long. 8 if not given; no other structure has a width
    #[arg(long, value_parser = PossibleValuesParser::new(["4", "8"]).map(|width| if width == "4" { 4u32 } else { 8 }))]
    width: Option<u32>,
    /// Cells along the longest side of a grid; 0 leaves it to the rule
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u32).range(..=i64::from(MOST_CELLS)))]
    cells: u32,
    /// Most primitives of a cell of nested grids that gets no grid; 0 leaves it to the rule
    #[arg(long, value_name = "PRIMITIVES", default_value_t = 0)]
    threshold: u32,
    /// Store coordinates relative to this point: for scenes far from 0
    #[arg(long, value_name = "X,Y,Z", value_parser = args::triple, default_value = "0,0,0", allow_hyphen_values = true)]
    local: [f32; 3],
    /// Print one JSON object instead of a sentence
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum Split {
    Seed,
    Sah,
}

#[derive(Clone, Copy, ValueEnum)]
pub enum Effort {
    Fast,
    Default,
    High,
}

impl Effort {
    pub fn quality(self) -> Quality {
        match self {
            Self::Fast => Quality::Fast,
            Self::Default => Quality::Default,
            Self::High => Quality::High,
        }
    }
}

impl Args {
    fn config(&self) -> Config {
        let rule = match self.rule {
            Split::Seed => Rule::Seed,
            Split::Sah => Rule::Sah,
        };
        let config = Config::new(self.structure).rule(rule).leaf(self.leaf).local(self.local);
        let config = config.width(self.width.unwrap_or(0));
        config.cells(self.cells).threshold(self.threshold).quality(self.quality.quality())
    }
}

/// Structures by their names.
pub fn structures() -> impl TypedValueParser<Value = Kind> {
    let kind = |name: &str| KINDS.iter().find(|(_, known)| *known == name).map_or(Kind::List, |(kind, _)| *kind);
    PossibleValuesParser::new(KINDS.iter().map(|(_, name)| *name)).map(move |name| kind(&name))
}

/// The same, and `wide4` for nodes of four.
pub fn structures_and_widths() -> impl TypedValueParser<Value = (&'static str, Config)> {
    let all = || {
        let plain = KINDS.iter().map(|&(kind, name)| (name, Config::new(kind)));
        plain.chain([("wide4", Config::new(Kind::Wide).width(4))])
    };
    let find = move |name: &str| all().find(|(known, _)| *known == name).unwrap_or(("list", Config::new(Kind::List)));
    PossibleValuesParser::new(all().map(|(name, _)| name)).map(move |name| find(&name))
}

pub fn run(args: &Args) -> Result<(), Failure> {
    if args.width.is_some() && args.structure != Kind::Wide {
        args::usage("--width is for --structure wide");
    }
    let spinner = super::spinner("reading");
    let soup = input::read_all(&args.inputs)?;
    spinner.set_message("building");
    let start = Instant::now();
    let config = args.config();
    let blob = to_vec(&soup.mesh(), &config).map_err(|e| format!("{}: {e}", args.inputs.join(" ")))?;
    let seconds = start.elapsed().as_secs_f64();
    spinner.finish_and_clear();
    file::write(&args.output, &blob)?;
    let prims = soup.mesh().len().unwrap_or(0);
    if args.json {
        let facts = serde_json::json!({
            "kind": config.kind.name(), "bytes": blob.len(), "primitives": prims, "seconds": seconds,
        });
        file::say(&facts.to_string())
    } else {
        let (kind, bytes, path) = (config.kind.name(), blob.len(), args.output.display());
        file::say(&format!("{path}: {kind}, {prims} primitives, {bytes} bytes, built in {seconds:.3} s"))
    }
}

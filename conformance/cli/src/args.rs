//! What arguments mean, and the groups of arguments that verbs share.

use crate::cache::kept_worlds;
use crate::limits::check_state;
use crate::size::{Size, Sizes};
use anyhow::{Context, Result, ensure};
use clap::builder::{
    MapValueParser, OsStringValueParser, PossibleValuesParser, TypedValueParser, ValueParserFactory,
};
use saarcor_kit::vm::config::{HASHES, POLICIES};
use saarcor_model::host::{Edges, Kernel};
use saarcor_model::time::standard::{self as numbers, CHIP_CACHE_WAYS};
use saarcor_model::time::{ChipConfig, PciConfig, UNIT_NAMES, Version};
use saarcor_model::vm::{Bytes, CacheConfig, Geometry, Hash, Policy, Unit};
use saarcor_scenes::kdbuild::{BuildOptions, SplitRule};
use saarcor_studies::error::ParseError;
use saarcor_studies::names::{BUSES, EDGES, KERNELS, Names, ORDERS, PACKETS, TREES, VERSIONS, WAYS, name_of};
use saarcor_studies::standard;
use saarcor_studies::sweep::AXES;
use saarcor_studies::trace::{PacketOrder, PacketSize, TraceOptions};
use saarcor_studies::world::{World, WorldOptions};
use std::borrow::Cow;
use std::ffi::OsString;
use std::fmt;
use std::ops::Range;
use std::path::PathBuf;
use std::str::FromStr;

/// An argument that is one of `choices`.
pub fn choice<T: Copy + Send + Sync>(choices: Names<T>) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(choices.iter().map(|(name, _)| *name)).map(move |given| {
        let chosen = choices.iter().find(|(name, _)| *name == given);
        chosen.expect("the parser lets only these names pass").1
    })
}

/// Frames of a path, half open: `A..B`, `A..`, `..B` or `..`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRange {
    begin: Option<usize>,
    end: Option<usize>,
}

impl FromStr for FrameRange {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        let right = || ParseError::new("write A..B for the frames from A on and before B");
        let (begin, end) = text.split_once("..").ok_or_else(right)?;
        let bound = |bound: &str| match bound {
            "" => Ok(None),
            number if number.bytes().all(|digit| digit.is_ascii_digit()) => {
                number.parse().map(Some).map_err(|_| ParseError::new("too large a frame"))
            }
            _ => Err(right()),
        };
        let (begin, end) = (bound(begin)?, bound(end)?);
        match end {
            Some(end) if end <= begin.unwrap_or(0) => {
                Err(ParseError::new("no frames: B itself is not among the frames of A..B"))
            }
            _ => Ok(Self { begin, end }),
        }
    }
}

impl FrameRange {
    /// The last frame that a path must have for this range.
    #[must_use]
    pub fn last(self) -> Option<usize> {
        self.end.map(|end| end - 1).or(self.begin)
    }

    /// These frames of the world's path, which has the last of them.
    #[must_use]
    pub fn of(self, world: &World) -> Range<usize> {
        self.begin.unwrap_or(0)..self.end.unwrap_or(world.path.len())
    }
}

/// Pixels a row and rows: `1024x768`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resolution {
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// Most pixels a row and most rows.
const MAX_SIDE: u32 = 16384;

impl FromStr for Resolution {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        let side = |text: &str| text.parse().ok().filter(|side| (1..=MAX_SIDE).contains(side));
        let sides = text.split_once('x').and_then(|(width, height)| side(width).zip(side(height)));
        let (width, height) = sides.ok_or_else(|| {
            ParseError::new(format!("write WIDTHxHEIGHT, such as 1024x768, of 1 to {MAX_SIDE} pixels"))
        })?;
        Ok(Self { width, height })
    }
}

impl fmt::Display for Resolution {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

/// The name of a scene: a built-in one's, or the path of a file, which may be no text.
#[derive(Clone, Debug)]
pub struct SceneName(OsString);

impl ValueParserFactory for SceneName {
    type Parser = MapValueParser<OsStringValueParser, fn(OsString) -> Self>;

    fn value_parser() -> Self::Parser {
        OsStringValueParser::new().map(Self)
    }
}

impl From<&str> for SceneName {
    fn from(name: &str) -> Self {
        Self(name.into())
    }
}

impl SceneName {
    /// The scene as it is made ready unless something else is asked for.
    ///
    /// # Errors
    /// If the environment says wrongly how much is kept.
    pub fn world(&self) -> Result<WorldOptions> {
        Ok(WorldOptions {
            file: self.0.to_str().is_none().then(|| PathBuf::from(&self.0)),
            kept: kept_worlds()?,
            ..WorldOptions::new(&self.text())
        })
    }

    /// The name as a path.
    #[must_use]
    pub fn path(&self) -> PathBuf {
        PathBuf::from(&self.0)
    }

    /// The name as text; what is none is replaced.
    #[must_use]
    pub fn text(&self) -> Cow<'_, str> {
        self.0.to_string_lossy()
    }
}

impl fmt::Display for SceneName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text())
    }
}

/// Which scene, and how it is made ready for the chip.
#[derive(Clone, Debug, clap::Args)]
pub struct SceneArgs {
    /// A built-in scene ('saarcor scenes' lists them) or the path of an OBJ file
    #[arg(value_name = "SCENE")]
    pub scene: SceneName,
    /// Takes only the first N lights
    #[arg(long, value_name = "N")]
    lights: Option<usize>,
    /// Leaves textures and bump maps away, and reads no image
    #[arg(long)]
    no_textures: bool,
    /// Refuses scene files that are not as their formats say, instead of a warning
    #[arg(long)]
    strict: bool,
    /// Reads textures and bump maps at full resolution, however far away
    #[arg(long)]
    no_mip_maps: bool,
    /// How the kd-tree is built: surface area heuristic, or spatial median as in 2003
    #[arg(long, value_parser = choice(TREES), default_value = name_of(TREES, &SplitRule::SurfaceArea))]
    tree: SplitRule,
    /// Triangle test [default: moller-trumbore; where answers are judged, adaptive]
    #[arg(long, value_parser = choice(KERNELS))]
    pub kernel: Option<Kernel>,
    /// Whose an edge or a vertex is that several triangles have: each one's, or one's alone, so that a ray through a
    /// closed surface hits it once
    #[arg(long, value_parser = choice(EDGES), default_value = name_of(EDGES, &Edges::Shared))]
    pub edges: Edges,
}

impl SceneArgs {
    /// What to make ready, with a path that has `last_frame`.
    ///
    /// # Errors
    /// Those of [`SceneName::world`].
    pub fn options(&self, last_frame: Option<usize>) -> Result<WorldOptions> {
        Ok(WorldOptions {
            lights: self.lights,
            no_textures: self.no_textures,
            strict: self.strict,
            no_mip_maps: self.no_mip_maps,
            tree: BuildOptions { rule: self.tree, ..BuildOptions::default() },
            kernel: self.kernel.unwrap_or_default(),
            edges: self.edges,
            last_frame,
            ..self.scene.world()?
        })
    }
}

/// Sizes of the virtual memory.
#[derive(Clone, Debug, clap::Args)]
pub struct GeometryArgs {
    /// Size of a line
    #[arg(long, value_name = "SIZE", default_value_t = Size(standard::LINE))]
    line: Size,
    /// Lines a set
    #[arg(long, value_parser = choice(WAYS), default_value = name_of(WAYS, &standard::WAYS))]
    ways: u32,
}

impl GeometryArgs {
    /// The cache of these sizes that `memory` makes.
    ///
    /// # Errors
    /// If the sizes do not make a cache.
    pub fn geometry(&self, memory: Size) -> Result<Geometry> {
        Ok(Geometry::new(memory.0, self.line.0, self.ways)?)
    }
}

/// The virtual memory.
#[derive(Clone, Debug, clap::Args)]
pub struct CacheArgs {
    /// On-board memory [default: the paper's for a built-in scene, else 8MiB]
    #[arg(long, value_name = "SIZE")]
    memory: Option<Size>,
    #[command(flatten)]
    geometry: GeometryArgs,
    /// How a line's set is found
    #[arg(long, value_parser = choice(HASHES), default_value = name_of(HASHES, &Hash::default()))]
    hash: Hash,
    /// Which line of a full set gives way
    #[arg(long, value_parser = choice(POLICIES), default_value = name_of(POLICIES, &standard::POLICY))]
    policy: Policy,
}

impl CacheArgs {
    /// The virtual memory for a scene.
    ///
    /// # Errors
    /// If the sizes do not make a cache, or one that takes too much memory to simulate.
    pub fn config(&self, scene: &str) -> Result<CacheConfig> {
        let geometry = self.geometry.geometry(self.memory.unwrap_or(Size(standard::memory(scene))))?;
        let config = CacheConfig { geometry, hash: self.hash, policy: self.policy };
        check_state(config, Bytes(0))?;
        Ok(config)
    }
}

/// The virtual memories of a walk: one, or all that some sizes, hashes and policies make.
#[derive(Clone, Debug, clap::Args)]
pub struct CachesArgs {
    /// Plays all virtual memories at once that these sizes make, such as --memory 1MiB..=64MiB --ways 1,4 (powers of two);
    /// and hashes and policies, such as --policy lru,fifo
    #[arg(long)]
    pub all: bool,
    /// On-board memory [default: the paper's for a built-in scene, else 8MiB; of all: 1MiB..=64MiB]
    #[arg(long, value_name = "SIZE")]
    memory: Option<Sizes>,
    /// Size of a line [default: 128; of all: 64,128,256]
    #[arg(long, value_name = "SIZE")]
    line: Option<Sizes>,
    /// Lines a set: 1, 2, 4, 8 or 16 [default: 4; of all: 1..=16]
    #[arg(long, value_name = "N")]
    ways: Option<Sizes>,
    /// How a line's set is found
    #[arg(long, value_delimiter = ',', value_parser = choice(HASHES), default_value = name_of(HASHES, &Hash::default()))]
    hash: Vec<Hash>,
    /// Which line of a full set gives way
    #[arg(long, value_delimiter = ',', value_parser = choice(POLICIES), default_value = name_of(POLICIES, &standard::POLICY))]
    policy: Vec<Policy>,
}

impl CachesArgs {
    /// The virtual memories for a scene: the policy changes last, then the hash, the line, the ways, and the memory first.
    ///
    /// # Errors
    /// If some sizes do not make a cache, or there are several values without `--all`.
    pub fn configs(&self, scene: &str) -> Result<Vec<CacheConfig>> {
        let standard = |one: Size, all: &str| match self.all {
            true => all.parse().expect("sizes"),
            false => Sizes(vec![one]),
        };
        let of = |given: &Option<Sizes>, one, all| given.clone().unwrap_or_else(|| standard(one, all)).0;
        let memories = of(&self.memory, Size(standard::memory(scene)), "1MiB..=64MiB");
        let lines = of(&self.line, Size(standard::LINE), "64,128,256");
        let ways = of(&self.ways, Size(Bytes(standard::WAYS.into())), "1..=16");
        let counts = [
            ("memory", memories.len()),
            ("line", lines.len()),
            ("ways", ways.len()),
            ("hash", self.hash.len()),
            ("policy", self.policy.len()),
        ];
        for (name, count) in counts {
            ensure!(self.all || count == 1, "--{name}: {count} values; one without --all");
        }
        let mut configs = Vec::new();
        for &policy in &self.policy {
            for &hash in &self.hash {
                for &Size(line) in &lines {
                    for &Size(Bytes(ways)) in &ways {
                        for &Size(memory) in &memories {
                            let geometry =
                                Geometry::new(memory, line, u32::try_from(ways).unwrap_or(u32::MAX))?;
                            configs.push(CacheConfig { geometry, hash, policy });
                        }
                    }
                }
            }
        }
        Ok(configs)
    }
}

/// The virtual memory in words.
#[must_use]
pub fn describe(config: &CacheConfig) -> String {
    let CacheConfig { geometry, hash, policy } = config;
    format!(
        "virtual memory: {}, {} ways, lines of {}, hash {}, {}; metadata {} KiB",
        Size(geometry.memory()),
        geometry.ways(),
        Size(geometry.line()),
        name_of(HASHES, hash),
        name_of(POLICIES, policy),
        geometry.metadata().0 as f64 / 1024.0
    )
}

/// A size for one type of unit: `list=64KiB`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnitSize {
    unit: usize,
    size: Size,
}

impl FromStr for UnitSize {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        let right = || ParseError::new(format!("write UNIT=SIZE with a unit of {}", UNIT_NAMES.join(", ")));
        let (unit, size) = text.split_once('=').ok_or_else(right)?;
        let unit = UNIT_NAMES.iter().position(|name| *name == unit).ok_or_else(right)?;
        Ok(Self { unit, size: size.parse()? })
    }
}

/// The chip around the virtual memory.
#[derive(Clone, Debug, clap::Args)]
pub struct ChipArgs {
    /// Version of the virtual memory: none, metadata on the chip, or in the on-board memory
    #[arg(long, value_parser = choice(VERSIONS), default_value = name_of(VERSIONS, &Version::A))]
    variant: Version,
    /// In which order packets are handed out: row by row, or near ones together
    #[arg(long, value_parser = choice(ORDERS), default_value = name_of(ORDERS, &PacketOrder::default()))]
    pub order: PacketOrder,
    /// Bus to the host: MHz x bits
    #[arg(long, value_parser = choice(BUSES), default_value = name_of(BUSES, &PciConfig::BITS_32_AT_33_MHZ))]
    pci: PciConfig,
    /// Ray tracing pipelines
    #[arg(long, value_name = "N", default_value_t = numbers::PIPELINES)]
    pipelines: u32,
    /// Threads a pipeline: packets in flight
    #[arg(long, value_name = "N", default_value_t = numbers::THREADS)]
    threads_per_rtp: u32,
    /// Size of the metadata cache of version b
    #[arg(long, value_name = "SIZE", default_value_t = Size(Bytes(numbers::METADATA_CACHE_BYTES.into())))]
    metadata_cache: Size,
    /// Bytes of metadata that are read and written back together
    #[arg(long, value_name = "SIZE", default_value_t = Size(Bytes(numbers::GRANULE.into())))]
    granule: Size,
    /// Banks of the on-board memory
    #[arg(long, value_name = "N", default_value_t = numbers::BANKS)]
    banks: u32,
    /// Size of a first-level cache, such as intersection=576KiB [default: the paper's]
    #[arg(long, value_name = "UNIT=SIZE")]
    l1: Vec<UnitSize>,
    /// Line of a first-level cache, such as traversal=64 [default: one item; 64 for shading]
    #[arg(long, value_name = "UNIT=SIZE")]
    l1_line: Vec<UnitSize>,
    /// Look-ups a cycle of each first-level cache
    #[arg(long, value_name = "N", default_value_t = numbers::FIRST_LEVEL_PORTS)]
    l1_ports: u32,
    /// Lines that can be in flight to each first-level cache at a time
    #[arg(long, value_name = "N", default_value_t = numbers::FIRST_LEVEL_MSHRS)]
    mshrs: u32,
}

impl ChipArgs {
    /// The chip for a scene, with the virtual memory `cache`. Whether it can be is for
    /// [`ChipConfig::check`] to say.
    ///
    /// # Errors
    /// If a size is none of its cache.
    pub fn config(&self, scene: &str, cache: CacheConfig) -> Result<ChipConfig> {
        let mut config = ChipConfig::standard(self.variant, cache);
        config.pci = self.pci;
        config.sdram.banks = self.banks;
        config.pipelines = self.pipelines;
        config.threads = self.threads_per_rtp;
        let narrow = |what: &str, Size(Bytes(bytes)): Size| {
            u32::try_from(bytes).map_err(|_| anyhow::anyhow!("{what} of {bytes} bytes: at most 4294967295"))
        };
        config.metadata_cache.bytes = narrow("metadata cache", self.metadata_cache)?;
        config.metadata_cache.granule = narrow("granule", self.granule)?;
        let mut sizes: [Bytes; 4] = std::array::from_fn(|unit| Bytes(config.l1_bytes(unit)));
        sizes[Unit::Intersection as usize] = standard::triangle_cache(scene);
        self.l1.iter().for_each(|given| sizes[given.unit] = given.size.0);
        for given in &self.l1_line {
            config.l1[given.unit].line = narrow("line of a first-level cache", given.size)?;
        }
        for ((l1, Bytes(bytes)), name) in config.l1.iter_mut().zip(sizes).zip(UNIT_NAMES) {
            (l1.ports, l1.mshrs) = (self.l1_ports, self.mshrs);
            let set = u64::from(l1.line) * CHIP_CACHE_WAYS as u64;
            let sets = bytes.checked_div(set).filter(|sets| sets * set == bytes && sets.is_power_of_two());
            l1.sets = sets.and_then(|sets| u32::try_from(sets).ok()).with_context(|| {
                format!(
                    "{name} cache of {} in lines of {}: it must be a power of two of sets of {CHIP_CACHE_WAYS} lines",
                    Size(Bytes(bytes)),
                    l1.line
                )
            })?;
        }
        Ok(config)
    }
}

/// The value of this name.
fn named<T: Copy>(names: Names<T>, name: &str) -> Result<T, ParseError> {
    let found = names.iter().find(|(known, _)| *known == name).map(|(_, value)| *value);
    found.ok_or_else(|| {
        let names: Vec<_> = names.iter().map(|(name, _)| *name).collect();
        ParseError::new(format!("write one of {}", names.join(", ")))
    })
}

/// Gives one of the [`AXES`] a value.
///
/// # Errors
/// What would be right, where it is none.
pub fn vary(axis: &str, value: &str, cache: &mut CacheArgs, chip: &mut ChipArgs) -> Result<(), ParseError> {
    match axis {
        "line" => cache.geometry.line = value.parse()?,
        "ways" => cache.geometry.ways = named(WAYS, value)?,
        "hash" => cache.hash = named(HASHES, value)?,
        "memory" => cache.memory = Some(value.parse()?),
        "policy" => cache.policy = named(POLICIES, value)?,
        "pci" => chip.pci = named(BUSES, value)?,
        "banks" => chip.banks = value.parse().map_err(|_| ParseError::new("write a number of banks"))?,
        "threads" => {
            let right = |_| ParseError::new("write a number of threads a pipeline");
            chip.threads_per_rtp = value.parse().map_err(right)?;
        }
        "metadata-cache" => chip.metadata_cache = value.parse()?,
        "granule" => chip.granule = value.parse()?,
        "triangle-cache" => {
            chip.l1.push(UnitSize { unit: Unit::Intersection as usize, size: value.parse()? });
        }
        "shading-line" => {
            chip.l1_line.push(UnitSize { unit: Unit::Shading as usize, size: value.parse()? });
        }
        "variant" => chip.variant = named(VERSIONS, value)?,
        _ => {
            let known: Vec<_> = AXES.iter().map(|(name, _)| *name).collect();
            return Err(ParseError::new(format!("no such axis; write one of {}", known.join(", "))));
        }
    }
    Ok(())
}

/// How frames are traced.
#[derive(Clone, Debug, clap::Args)]
pub struct TraceArgs {
    /// Size of the picture in pixels
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value_t = Resolution {
        width: standard::RESOLUTION.0, height: standard::RESOLUTION.1
    })]
    resolution: Resolution,
    /// Rays a packet
    #[arg(long, value_parser = choice(PACKETS), default_value = name_of(PACKETS, &PacketSize::Rays64))]
    packet: PacketSize,
    /// Reflections and refractions that may follow one another
    #[arg(long, value_name = "N", default_value_t = standard::MAX_BOUNCES,
          value_parser = clap::value_parser!(u32).range(0..=16))]
    bounces: u32,
}

impl TraceArgs {
    /// How frames are traced.
    #[must_use]
    pub fn options(&self) -> TraceOptions {
        let Resolution { width, height } = self.resolution;
        TraceOptions { resolution: (width, height), packet: self.packet, max_bounces: self.bounces }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_half_open() {
        let range = |begin, end| Ok(FrameRange { begin, end });
        assert_eq!("3..5".parse(), range(Some(3), Some(5)));
        assert_eq!("3..".parse(), range(Some(3), None));
        assert_eq!("..5".parse(), range(None, Some(5)));
        assert_eq!("..".parse(), range(None, None));
        for text in
            ["", "3", "5..3", "3..3", "..0", "-1..2", "3...5", "3..=5", "a..b", "0..99999999999999999999"]
        {
            assert!(text.parse::<FrameRange>().is_err(), "{text}");
        }
    }

    #[test]
    fn resolutions_are_bounded() {
        assert_eq!("640x480".parse(), Ok(Resolution { width: 640, height: 480 }));
        for text in ["", "640", "0x480", "640x", "640x480x3", "99999x1", "-1x1", "640X480"] {
            assert!(text.parse::<Resolution>().is_err(), "{text}");
        }
    }
}

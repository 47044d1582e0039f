//! A scene made ready for the chip: loaded or generated, its kd-tree built, laid out in host
//! memory.

mod image;
pub mod kept;
mod mapped;

pub use image::Image;

use crate::error::StudyError;
use crate::monitor::Monitor;
use crate::names::nearest;
use kept::KeptWorlds;
use saarcor_model::host::{Camera, Edges, Features, HostImage, KdTree, Kernel, LayoutError, Node, Scene};
use saarcor_scenes::kdbuild::{self, BuildOptions};
use saarcor_scenes::{LoadOptions, Loaded, builtin, load_obj};
use std::path::{Path, PathBuf};
use std::time::{Instant, SystemTime};

/// What to make ready, and how.
#[derive(Clone, Debug)]
pub struct WorldOptions {
    /// A built-in name or the path of an OBJ file.
    pub scene: String,
    /// The path of the OBJ file, where it is no text and `scene` only shows it.
    pub file: Option<PathBuf>,
    /// Take only this many of the scene's lights, the first ones.
    pub lights: Option<usize>,
    /// Leave textures and bump maps away, as the paper does where a scene's name ends in `nt`.
    pub no_textures: bool,
    /// Refuse an OBJ file and what it names where they are not as their formats say, instead of a
    /// warning.
    pub strict: bool,
    /// Store textures and bump maps at full resolution alone.
    pub no_mip_maps: bool,
    /// How the kd-tree is built.
    pub tree: BuildOptions,
    /// The triangle test that the image is laid out for.
    pub kernel: Kernel,
    /// Whose edges and vertices are that several triangles have.
    pub edges: Edges,
    /// The last frame that will be asked for: a path without it is refused before the kd-tree is
    /// built.
    pub last_frame: Option<usize>,
    /// Where worlds are kept from run to run, if they are.
    pub kept: Option<KeptWorlds>,
}

impl WorldOptions {
    /// The scene with all its lights, a tree by the surface area heuristic and the chip's usual
    /// triangle test.
    #[must_use]
    pub fn new(scene: &str) -> Self {
        Self {
            scene: scene.to_owned(),
            file: None,
            lights: None,
            no_textures: false,
            strict: false,
            no_mip_maps: false,
            tree: BuildOptions::default(),
            kernel: Kernel::default(),
            edges: Edges::default(),
            last_frame: None,
            kept: None,
        }
    }
}

/// A scene in host memory, with facts about its triangles, its tree and its preparation.
#[derive(Clone, Debug)]
pub struct World {
    /// As the user named it.
    pub name: String,
    /// The camera path.
    pub path: Vec<Camera>,
    /// What the scene needs of the chip.
    pub features: Features,
    /// Triangles of the scene.
    pub triangles: usize,
    /// Of these, triangles without area, which no image holds.
    pub degenerate: usize,
    /// The bytes in host memory.
    pub image: Image,
    /// Facts about the kd-tree.
    pub tree: TreeFacts,
    /// What was assumed of files that are not as their formats say, a line a kind; said to the monitor.
    pub warnings: Vec<String>,
    /// The files that the scene depends on; of some there may be none.
    pub files: Vec<PathBuf>,
    /// Seconds that it took to load or generate the scene, to build its tree, to lay it out. A kept world
    /// is loaded as it is.
    pub seconds: [f64; 3],
}

/// Facts about a kd-tree.
#[derive(Clone, Copy, Debug)]
pub struct TreeFacts {
    /// All nodes.
    pub nodes: usize,
    /// Leaves among them.
    pub leaves: usize,
    /// Entries of all lists.
    pub refs: usize,
}

impl World {
    /// Makes a scene ready. Reports its stages to `monitor`.
    ///
    /// # Errors
    /// If there is no such scene, it cannot be read, or it does not fit the chip.
    pub fn open(options: &WorldOptions, monitor: &dyn Monitor) -> Result<Self, StudyError> {
        Self::find_or_make(options, monitor).map(|(world, _)| world)
    }

    /// [`World::open`], laid out anew for the triangle test that `choose` names when it has seen the
    /// world with the test of `options`.
    ///
    /// # Errors
    /// As there, and those of `choose`.
    pub fn open_choosing(
        options: &WorldOptions,
        monitor: &dyn Monitor,
        choose: impl FnOnce(&Self) -> Result<Kernel, StudyError>,
    ) -> Result<Self, StudyError> {
        let started = SystemTime::now();
        let (world, made_of) = Self::find_or_make(options, monitor)?;
        let kernel = choose(&world)?;
        if kernel == options.kernel {
            return Ok(world);
        }
        let options = WorldOptions { kernel, ..options.clone() };
        let Some((scene, tree)) = made_of else { return Self::open(&options, monitor) };
        let world = Self { image: lay_out(&scene, &tree, &options, monitor)?, ..world };
        world.keep(&options, started, monitor);
        Ok(world)
    }

    /// The world, and its scene and tree unless it was kept.
    fn find_or_make(
        options: &WorldOptions,
        monitor: &dyn Monitor,
    ) -> Result<(Self, Option<(Scene, KdTree)>), StudyError> {
        let (now, started) = (SystemTime::now(), Instant::now());
        let find =
            |kept: &KeptWorlds| monitor.during(&format!("{}: scene", options.scene), |_| kept.find(options));
        if let Some(world) = options.kept.as_ref().and_then(find) {
            check_frames(options, &world.path)?;
            world.warnings.iter().for_each(|line| monitor.warn(line));
            let mut world = Self { seconds: [started.elapsed().as_secs_f64(), 0.0, 0.0], ..world };
            world.image.registers.edges = options.edges;
            return Ok((world, None));
        }
        let (world, scene, tree) = Self::make(options, monitor)?;
        world.keep(options, now, monitor);
        Ok((world, Some((scene, tree))))
    }

    /// Keeps the world, which was made of `options` since `started`, where they say so.
    fn keep(&self, options: &WorldOptions, started: SystemTime, monitor: &dyn Monitor) {
        if let Some(kept) = &options.kept {
            monitor.during(&format!("{}: keeping it", self.name), |_| kept.keep(options, started, self));
        }
    }

    /// The world, made anew, with the scene itself: its triangles in their own order.
    ///
    /// # Errors
    /// As for [`World::open`].
    pub fn open_with_scene(
        options: &WorldOptions,
        monitor: &dyn Monitor,
    ) -> Result<(Self, Scene), StudyError> {
        Self::make(options, monitor).map(|(world, scene, _)| (world, scene))
    }

    /// A new world, with its scene and its tree.
    fn make(options: &WorldOptions, monitor: &dyn Monitor) -> Result<(Self, Scene, KdTree), StudyError> {
        let started = Instant::now();
        let Loaded { scene, files, warnings } =
            monitor.during(&format!("{}: scene", options.scene), |_| load(options))?;
        let loaded = started.elapsed().as_secs_f64();
        check_frames(options, &scene.path)?;
        let started = Instant::now();
        let tree = monitor.during(&format!("{}: kd-tree", options.scene), |report| {
            kdbuild::build(&scene.triangles, &options.tree, report)
        });
        let built = started.elapsed().as_secs_f64();
        let started = Instant::now();
        let image = lay_out(&scene, &tree, options, monitor)?;
        let world = Self {
            seconds: [loaded, built, started.elapsed().as_secs_f64()],
            warnings: warnings.iter().map(ToString::to_string).collect(),
            files,
            ..Self::of(&options.scene, &scene, &tree, image)
        };
        world.warnings.iter().for_each(|line| monitor.warn(line));
        Ok((world, scene, tree))
    }

    /// The world of no scene.
    pub(crate) fn blank(options: &WorldOptions) -> Result<Self, LayoutError> {
        let scene = Scene::default();
        let tree = kdbuild::build(&scene.triangles, &options.tree, &|_| ());
        let image = HostImage::build(&scene, &tree, options.kernel)?;
        Ok(Self::of(&options.scene, &scene, &tree, image.into()))
    }

    fn of(name: &str, scene: &Scene, tree: &KdTree, image: Image) -> Self {
        let leaves = tree.nodes.iter().filter(|node| matches!(node, Node::Leaf { .. })).count();
        Self {
            name: name.to_owned(),
            features: image.registers.features,
            triangles: scene.triangles.len(),
            degenerate: scene.triangles.iter().filter(|triangle| triangle.is_degenerate()).count(),
            tree: TreeFacts { nodes: tree.nodes.len(), leaves, refs: tree.refs.len() },
            path: scene.path.clone(),
            image,
            warnings: Vec::new(),
            files: Vec::new(),
            seconds: [0.0; 3],
        }
    }
}

/// The scene in host memory.
fn lay_out(
    scene: &Scene,
    tree: &KdTree,
    options: &WorldOptions,
    monitor: &dyn Monitor,
) -> Result<Image, StudyError> {
    monitor
        .during(&format!("{}: host image", options.scene), |_| HostImage::build(scene, tree, options.kernel))
        .map(|mut image| {
            image.registers.edges = options.edges;
            image.into()
        })
        .map_err(|source| StudyError::Image { scene: options.scene.clone(), source })
}

fn check_frames(options: &WorldOptions, path: &[Camera]) -> Result<(), StudyError> {
    let frames = path.len();
    if let Some(frame) = options.last_frame.filter(|&frame| frame >= frames) {
        return Err(StudyError::NoSuchFrame { scene: options.scene.clone(), frame, frames });
    }
    Ok(())
}

/// Loads the OBJ file or generates the built-in scene that `options` names. What was assumed of its files
/// is said to `monitor`.
///
/// # Errors
/// If there is no such scene or file, or it is no scene.
pub fn open_scene(options: &WorldOptions, monitor: &dyn Monitor) -> Result<Scene, StudyError> {
    let Loaded { scene, warnings, .. } = load(options)?;
    warnings.iter().for_each(|warning| monitor.warn(&warning.to_string()));
    Ok(scene)
}

/// The scene, the files that it depends on, and what was assumed of them.
fn load(options: &WorldOptions) -> Result<Loaded, StudyError> {
    let &WorldOptions { scene: ref name, no_textures, strict, .. } = options;
    let mut loaded = match builtin::builtin(name) {
        Some(scene) => Loaded { scene, files: Vec::new(), warnings: Vec::new() },
        None if options.file.is_some() || looks_like_a_path(name) => {
            let file = options.file.as_deref().unwrap_or(Path::new(name));
            load_obj(file, LoadOptions { no_textures, strict })?
        }
        None => {
            return Err(StudyError::UnknownScene { name: name.clone(), suggestion: suggestion(name) });
        }
    };
    let scene = &mut loaded.scene;
    if let Some(lights) = options.lights {
        let found = scene.lights.len();
        if lights > found {
            return Err(StudyError::TooFewLights { scene: name.clone(), lights, found });
        }
        scene.lights.truncate(lights);
    }
    if no_textures {
        scene.textures.clear();
        for material in &mut scene.materials {
            (material.texture, material.bump) = (None, None);
        }
    }
    scene.mip_maps = !options.no_mip_maps;
    Ok(loaded)
}

/// Whether a scene's name is meant as a file: it has a folder or an extension, or exists.
pub(crate) fn looks_like_a_path(name: &str) -> bool {
    let path = Path::new(name);
    path.components().count() > 1 || path.extension().is_some() || path.exists()
}

/// Says what could have been meant by a name that is no scene's.
fn suggestion(name: &str) -> String {
    match nearest(name, builtin::TABLE_1) {
        Some(known) => {
            format!("did you mean '{known}'? ('saarcor scenes' lists all; a file is named with its .obj)")
        }
        None => "'saarcor scenes' lists the built-in ones; a file is named with its .obj".to_owned(),
    }
}

//! A scene made ready for the chip: loaded or generated, its kd-tree built, laid out in host
//! memory.

use crate::kept_trees::KeptTrees;
use crate::names::nearest;
use crate::progress::Progress;
use anyhow::{Context, Result, bail};
use saarcor_model::image::HostImage;
use saarcor_model::intersection::Kernel;
use saarcor_model::kdtree::{KdTree, Node};
use saarcor_model::scene::{Camera, Features, Scene};
use saarcor_scenes::builtin;
use saarcor_scenes::kdbuild::{self, BuildOptions};
use std::path::Path;
use std::time::Instant;

/// What to make ready, and how.
#[derive(Clone, Debug)]
pub struct WorldOptions {
    /// A built-in name or the path of an OBJ file.
    pub scene: String,
    /// Take only this many of the scene's lights, the first ones.
    pub lights: Option<usize>,
    /// Leave textures and bump maps away, as the paper does where a scene's name ends in `nt`.
    pub no_textures: bool,
    /// Store textures and bump maps at full resolution alone.
    pub no_mip_maps: bool,
    /// How the kd-tree is built.
    pub tree: BuildOptions,
    /// The triangle test that the image is laid out for.
    pub kernel: Kernel,
    /// The last frame that will be asked for: a path without it is refused before the kd-tree is
    /// built.
    pub last_frame: Option<usize>,
    /// Where kd-trees are kept from run to run, if they are.
    pub kept_trees: Option<KeptTrees>,
}

impl WorldOptions {
    /// The scene with all its lights, a tree by the surface area heuristic and the chip's usual
    /// triangle test.
    #[must_use]
    pub fn new(scene: &str) -> Self {
        Self {
            scene: scene.to_owned(),
            lights: None,
            no_textures: false,
            no_mip_maps: false,
            tree: BuildOptions::default(),
            kernel: Kernel::default(),
            last_frame: None,
            kept_trees: None,
        }
    }
}

/// A scene in host memory, and what was learned on the way there.
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
    pub image: HostImage,
    /// Facts about the kd-tree.
    pub tree: TreeFacts,
    /// Seconds that it took to load or generate the scene, to build or find its tree, to lay it out.
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
    /// Makes a scene ready. Says on `progress` what it does.
    ///
    /// # Errors
    /// If there is no such scene, it cannot be read, or it does not fit the chip.
    pub fn open(options: &WorldOptions, progress: &Progress) -> Result<Self> {
        Self::open_with_tree(options, progress).map(|(world, ..)| world)
    }

    /// [`World::open`], with the scene itself: its triangles in their own order.
    ///
    /// # Errors
    /// As there.
    pub fn open_with_scene(options: &WorldOptions, progress: &Progress) -> Result<(Self, Scene)> {
        Self::open_with_tree(options, progress).map(|(world, scene, _)| (world, scene))
    }

    /// [`World::open`], laid out anew for the triangle test that `choose` names when it has seen the
    /// world with the test of `options`.
    ///
    /// # Errors
    /// As there, and those of `choose`.
    pub fn open_choosing(
        options: &WorldOptions,
        progress: &Progress,
        choose: impl FnOnce(&Self) -> Result<Kernel>,
    ) -> Result<Self> {
        let (mut world, scene, tree) = Self::open_with_tree(options, progress)?;
        let kernel = choose(&world)?;
        if kernel != options.kernel {
            world.image = lay_out(&scene, &tree, &WorldOptions { kernel, ..options.clone() }, progress)?;
        }
        Ok(world)
    }

    fn open_with_tree(options: &WorldOptions, progress: &Progress) -> Result<(Self, Scene, KdTree)> {
        let started = Instant::now();
        let scene = progress.during(&format!("{}: scene", options.scene), |_| open_scene(options))?;
        let loaded = started.elapsed().as_secs_f64();
        let frames = scene.path.len();
        if let Some(frame) = options.last_frame.filter(|&frame| frame >= frames) {
            bail!(
                "frame {frame}: the path of {} has the frames 0 to {}",
                options.scene,
                frames.saturating_sub(1)
            );
        }
        let started = Instant::now();
        let tree = progress.during(&format!("{}: kd-tree", options.scene), |report| {
            let build = || kdbuild::build(&scene.triangles, &options.tree, report);
            match &options.kept_trees {
                Some(kept) => kept.tree(&scene.triangles, &options.tree, build),
                None => build(),
            }
        });
        let built = started.elapsed().as_secs_f64();
        let started = Instant::now();
        let image = lay_out(&scene, &tree, options, progress)?;
        let leaves = tree.nodes.iter().filter(|node| matches!(node, Node::Leaf { .. })).count();
        let world = Self {
            name: options.scene.clone(),
            features: image.registers.features,
            triangles: scene.triangles.len(),
            degenerate: scene.triangles.iter().filter(|triangle| triangle.is_degenerate()).count(),
            tree: TreeFacts { nodes: tree.nodes.len(), leaves, refs: tree.refs.len() },
            path: scene.path.clone(),
            image,
            seconds: [loaded, built, started.elapsed().as_secs_f64()],
        };
        Ok((world, scene, tree))
    }
}

/// The scene in host memory.
fn lay_out(scene: &Scene, tree: &KdTree, options: &WorldOptions, progress: &Progress) -> Result<HostImage> {
    progress
        .during(&format!("{}: host image", options.scene), |_| HostImage::build(scene, tree, options.kernel))
        .with_context(|| format!("scene {}", options.scene))
}

/// Loads the OBJ file or generates the built-in scene that `options` names.
///
/// # Errors
/// If there is no such scene or file, or it is no scene.
pub fn open_scene(options: &WorldOptions) -> Result<Scene> {
    let name = &options.scene;
    let mut scene = match builtin::builtin(name) {
        Some(scene) => scene,
        None if looks_like_a_path(name) => saarcor_scenes::load_obj(Path::new(name))?,
        None => bail!("unknown scene '{name}': {}", suggestion(name)),
    };
    if let Some(lights) = options.lights {
        let found = scene.lights.len();
        if lights > found {
            bail!("--lights {lights}: {name} has {found} lights");
        }
        scene.lights.truncate(lights);
    }
    if options.no_textures {
        scene.images.clear();
        for material in &mut scene.materials {
            (material.texture, material.bump) = (None, None);
        }
    }
    scene.mip_maps = !options.no_mip_maps;
    Ok(scene)
}

/// Whether a scene's name is meant as a file: it has a folder or an extension, or exists.
fn looks_like_a_path(name: &str) -> bool {
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

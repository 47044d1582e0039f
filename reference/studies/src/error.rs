//! What can go wrong in a study.

use saarcor_model::host::LayoutError;
use saarcor_model::time::ConfigError;
use saarcor_model::vm::GeometryError;
use saarcor_oracles::embree::EmbreeError;
use saarcor_scenes::SceneError;
use std::borrow::Cow;

/// Why a study gives no rows.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// No built-in scene has the name, and it names no file.
    #[error("unknown scene '{name}': {suggestion}")]
    UnknownScene {
        /// As the user wrote it.
        name: String,
        /// The scene that the user may have meant.
        suggestion: String,
    },
    /// The files of a scene are wrong.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A scene does not fit host memory.
    #[error("scene {scene}")]
    Image {
        /// The scene.
        scene: String,
        /// Why it does not fit.
        source: LayoutError,
    },
    /// A path does not have the frame.
    #[error("frame {frame}: the path of {scene} has the frames 0 to {}", frames.saturating_sub(1))]
    NoSuchFrame {
        /// The scene.
        scene: String,
        /// The frame that was asked for.
        frame: usize,
        /// Frames of the path.
        frames: usize,
    },
    /// A scene has fewer lights than were asked for.
    #[error("--lights {lights}: {scene} has {found} lights")]
    TooFewLights {
        /// The scene.
        scene: String,
        /// Lights that were asked for.
        lights: usize,
        /// Lights that there are.
        found: usize,
    },
    /// A scene without a camera path has no primary rays.
    #[error("{scene}: has no camera path, and so no rays of its own")]
    NoPath {
        /// The scene.
        scene: String,
    },
    /// No triangle test of the chip stays inside a budget of errors.
    #[error(
        "{scene}: no triangle test of the chip stays inside this budget; 'saarcor accuracy --scene --budget' shows \
         their errors"
    )]
    OverBudget {
        /// The scene.
        scene: String,
    },
    /// The sizes make no virtual memory.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// The numbers make no chip.
    #[error(transparent)]
    Chip(#[from] ConfigError),
    /// A sample is too small for an interval.
    #[error("sample of {sample}: {why}")]
    SmallSample {
        /// The part of the frames that was asked for.
        sample: String,
        /// Why it is too small, and the smallest that is enough.
        why: String,
    },
    /// A line of a file of cases is no case.
    #[error("line {line}: no case as 'accuracy --out' writes")]
    BadRecord {
        /// The line, counted from 1.
        line: usize,
        /// What is wrong with it.
        source: serde_json::Error,
    },
    /// A file of cases has none.
    #[error("no case: write a line of JSON a case, as 'accuracy --out' does")]
    NoRecords,
    /// A line of a file of rays is no ray.
    #[error("{file}:{line}: {why}")]
    BadRay {
        /// The file.
        file: String,
        /// The line, counted from 1.
        line: usize,
        /// What is wrong with it, and what would be right.
        why: String,
    },
    /// Embree is not there, or does not run.
    #[error(transparent)]
    Embree(#[from] EmbreeError),
}

/// A text is not a value of the type that was asked for. Displays as what would be right.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ParseError(Cow<'static, str>);

impl ParseError {
    /// An error that says what would be right.
    #[must_use]
    pub fn new(right: impl Into<Cow<'static, str>>) -> Self {
        Self(right.into())
    }
}

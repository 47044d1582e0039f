use saarcor_studies::StudyError;
use std::path::PathBuf;

/// A setting as it is written.
const SETTING: &str = "\"granule=16 B,banks=8\"";

/// Why a reproduction cannot be computed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReproductionError {
    /// The folder with the real scenes lacks one.
    #[error("--scenes {}: holds no {scene}/{scene}.obj", folder.display())]
    NoRealScene {
        /// The folder.
        folder: PathBuf,
        /// The scene.
        scene: &'static str,
    },
    /// The path of a scene is no Unicode text.
    #[error("{}: is no text", .0.display())]
    NotText(PathBuf),
    /// A setting names what no Assumed number has.
    #[error("{0}: name values of Assumed numbers, such as {example}", example = SETTING)]
    NoSetting(String),
    /// A sample draws no row.
    #[error("--sample {sample}: draws none of the {all} rows; take a larger part")]
    NoRows {
        /// The part.
        sample: String,
        /// All rows.
        all: usize,
    },
    /// What was measured cannot be kept.
    #[error("what was measured cannot be kept: {0}")]
    Keep(#[from] std::io::Error),
    /// A study failed.
    #[error(transparent)]
    Study(#[from] StudyError),
}

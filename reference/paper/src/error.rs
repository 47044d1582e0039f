use saarcor_studies::StudyError;
use std::path::PathBuf;

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
    /// A study failed.
    #[error(transparent)]
    Study(#[from] StudyError),
}

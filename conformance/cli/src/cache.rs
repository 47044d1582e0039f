//! Where scenes are kept from run to run, as the user says.

use crate::output::temporaries;
use crate::size::Size;
use anyhow::{Context as _, Result};
use saarcor_model::vm::Bytes;
use saarcor_studies::world::kept::{KeptWorlds, USUAL_LIMIT};
use std::path::PathBuf;

/// Names the folder; where it is empty, nothing is kept.
pub const FOLDER: &str = "SAARCOR_CACHE";

/// Says how much is kept at most: a [`Size`].
pub const LIMIT: &str = "SAARCOR_CACHE_LIMIT";

/// The user's kept scenes: in the folder that [`FOLDER`] names, else in `saarcor` in the folder for what can be made again
/// (XDG Base Directory Specification). None if the user wants none.
///
/// # Errors
/// If [`LIMIT`] is no size.
pub fn kept_worlds() -> Result<Option<KeptWorlds>> {
    let folder = std::env::var_os(FOLDER).map(PathBuf::from).or_else(|| {
        let set = |name| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
        let caches = set("XDG_CACHE_HOME").or_else(|| Some(set("HOME")?.join(".cache")))?;
        Some(caches.join("saarcor"))
    });
    let Some(folder) = folder.filter(|folder| !folder.as_os_str().is_empty()) else { return Ok(None) };
    let limit = match std::env::var_os(LIMIT) {
        None => USUAL_LIMIT,
        Some(limit) => {
            let limit = limit.to_string_lossy();
            let Size(Bytes(limit)) = limit.parse().with_context(|| format!("{LIMIT}={limit}"))?;
            limit
        }
    };
    // Where signals cannot be waited for, one may leave a file.
    let _ = temporaries::watch(&folder);
    Ok(Some(KeptWorlds::new(folder).with_limit(limit)))
}

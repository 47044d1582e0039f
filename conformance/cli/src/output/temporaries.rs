//! Temporary files and folders, none of which is left: neither at the end of this process, nor where a signal ends it.

use crate::signals;
use saarcor_scenes::temporary_prefix;
use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError, RwLock, RwLockReadGuard};
use tempfile::{Builder, NamedTempFile, TempDir};

/// A file that is removed unless it is given a name.
pub type Temporary = NamedTempFile;

/// The folders that may hold temporary files of this process.
static FOLDERS: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Held for reading while a temporary file is made or gets its name, and for writing once this process is to end.
static AT_WORK: RwLock<()> = RwLock::new(());

/// Keeps a signal from ending this process until the guard is dropped; for good where one came before.
pub fn lock() -> RwLockReadGuard<'static, ()> {
    AT_WORK.read().unwrap_or_else(PoisonError::into_inner)
}

/// Has what is in `folder` under a name with [`temporary_prefix`] removed where a signal ends this process.
///
/// # Errors
/// If signals cannot be waited for.
pub fn watch(folder: &Path) -> io::Result<()> {
    let folder = std::path::absolute(folder)?;
    let mut folders = FOLDERS.lock().unwrap_or_else(PoisonError::into_inner);
    if folders.is_empty() {
        signals::before_end(remove_all)?;
    }
    folders.insert(folder);
    Ok(())
}

/// A temporary file in a folder, with the permissions of an ordinary new file; the user's mask applies.
///
/// # Errors
/// If there can be none.
pub fn file_in(folder: &Path) -> io::Result<Temporary> {
    use std::os::unix::fs::PermissionsExt as _;
    watch(folder)?;
    let _made = lock();
    Builder::new()
        .prefix(&temporary_prefix())
        .permissions(fs::Permissions::from_mode(0o666))
        .tempfile_in(folder)
}

/// A temporary folder in a folder.
///
/// # Errors
/// If there can be none.
pub fn folder_in(folder: &Path) -> io::Result<TempDir> {
    watch(folder)?;
    let _made = lock();
    Builder::new().prefix(&temporary_prefix()).tempdir_in(folder)
}

fn remove_all() {
    // Nothing is made any more.
    std::mem::forget(AT_WORK.write());
    let folders = FOLDERS.lock().unwrap_or_else(PoisonError::into_inner);
    for entry in folders.iter().filter_map(|folder| fs::read_dir(folder).ok()).flatten().flatten() {
        if entry.file_name().as_encoded_bytes().starts_with(temporary_prefix().as_bytes()) {
            let path = entry.path();
            // What cannot be removed stays.
            let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
        }
    }
}

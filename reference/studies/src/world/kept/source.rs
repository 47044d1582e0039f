//! Files that a kept world is made of, and whether they are as they were: by size and times, and where only the times differ,
//! by a checksum of their content.

use std::fs::{self, File, Metadata};
use std::io::{self, BufRead, BufReader, ErrorKind};
use std::path::PathBuf;
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use xxhash_rust::xxh3::Xxh3;

/// What a file's content was.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Stamp {
    /// How long it was.
    pub bytes: u64,
    /// Since when it was so. None where that was too short a time: a change behind the checksum could have the same times.
    pub times: Option<Times>,
    /// Checksum of all bytes (XXH3, 128 bits).
    pub checksum: u128,
}

/// When a file's content and its status were changed last, in nanoseconds since 1970. The second cannot be set as one likes,
/// as the first is where a file is copied with its time.
pub(super) type Times = [u64; 2];

/// Times of files are as coarse as this (FAT).
pub(super) const COARSE: Duration = Duration::from_secs(2);

/// The times of a file; none where files have no times.
fn times(file: &Metadata) -> Option<Times> {
    let modified = since_1970(file.modified().ok()?);
    #[cfg(unix)]
    let changed = {
        use std::os::unix::fs::MetadataExt as _;
        let changed = Duration::new(file.ctime().unsigned_abs(), file.ctime_nsec() as u32);
        since_1970(UNIX_EPOCH + changed)
    };
    #[cfg(not(unix))]
    let changed = modified;
    Some([modified, changed])
}

/// A time as in [`Times`].
fn since_1970(time: SystemTime) -> u64 {
    time.duration_since(UNIX_EPOCH).map_or(0, |time| u64::try_from(time.as_nanos()).unwrap_or(u64::MAX))
}

impl Stamp {
    /// Of a file that nobody changes, with this checksum.
    pub fn of_unchanging(file: &Metadata, checksum: u128) -> Self {
        Self { bytes: file.len(), times: times(file), checksum }
    }

    /// Of a file as it is `now`. It is read piece by piece: to have memory for all of it would take longer than the checksum.
    fn of(file: File, now: SystemTime) -> io::Result<Self> {
        let before = file.metadata()?;
        if !before.is_file() {
            return Err(io::Error::other("no file that can be read again"));
        }
        let mut file = BufReader::with_capacity(1 << 16, file);
        let (mut checksum, mut bytes) = (Xxh3::new(), 0);
        loop {
            let piece = file.fill_buf()?;
            if piece.is_empty() {
                break;
            }
            checksum.update(piece);
            let read = piece.len();
            bytes += read as u64;
            file.consume(read);
        }
        let after = file.get_ref().metadata()?;
        if bytes != before.len() || times(&before) != times(&after) {
            return Err(io::Error::other("written meanwhile"));
        }
        let is_old = |changed: &u64| Duration::from_nanos(since_1970(now).saturating_sub(*changed)) >= COARSE;
        let times = times(&before).filter(|times| times.iter().all(is_old));
        Ok(Self { bytes, times, checksum: checksum.digest128() })
    }

    /// Whether the file is as it was, as far as its size and times tell.
    pub fn compare(&self, file: &Metadata) -> Compared {
        if file.len() != self.bytes {
            Compared::Different
        } else if self.times.is_some() && self.times == times(file) {
            Compared::Same
        } else {
            Compared::Perhaps
        }
    }
}

/// What size and times tell of a file.
pub(super) enum Compared {
    /// It is as it was.
    Same,
    /// Its content has to be read.
    Perhaps,
    /// It is another one.
    Different,
}

/// A file that a world depends on.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Source {
    pub path: PathBuf,
    /// None where there is no such file.
    pub stamp: Option<Stamp>,
}

impl Source {
    /// What a world was made of that was begun at this time.
    ///
    /// # Errors
    /// If it cannot be read, or may be another one by now.
    pub fn before(time: SystemTime, path: PathBuf) -> io::Result<Self> {
        let source = Self::now(path)?;
        let since = |times: Times| times.into_iter().any(|changed| changed >= since_1970(time));
        match fs::metadata(&source.path) {
            Ok(file) if times(&file).is_none_or(since) => Err(io::Error::other("written meanwhile")),
            _ => Ok(source),
        }
    }

    /// As it is.
    fn now(path: PathBuf) -> io::Result<Self> {
        let stamp = match File::open(&path) {
            Err(error) if error.kind() == ErrorKind::NotFound => None,
            file => Some(Stamp::of(file?, SystemTime::now())?),
        };
        Ok(Self { path, stamp })
    }

    /// The same with the times of the file, if its content is as it was.
    pub fn unchanged(&self) -> Option<Self> {
        let compared = match (&self.stamp, fs::metadata(&self.path)) {
            (Some(stamp), Ok(file)) => stamp.compare(&file),
            (None, Err(error)) if error.kind() == ErrorKind::NotFound => Compared::Same,
            _ => Compared::Different,
        };
        match compared {
            Compared::Same => Some(self.clone()),
            Compared::Different => None,
            Compared::Perhaps => {
                let now = Self::now(self.path.clone()).ok()?;
                let checksum = |source: &Self| source.stamp.map(|stamp| stamp.checksum);
                (checksum(&now) == checksum(self)).then_some(now)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times that a change in the same moment could have too tell nothing.
    #[test]
    fn new_times_are_not_trusted() {
        let file = tempfile::NamedTempFile::new().expect("a file");
        fs::write(file.path(), "text").expect("written");
        let found = fs::metadata(file.path()).expect("a file");
        let last = times(&found).expect("times").into_iter().max().expect("two times");
        let after = |time: Duration| {
            let now = UNIX_EPOCH + Duration::from_nanos(last) + time;
            Stamp::of(File::open(file.path()).expect("a file"), now).expect("read").times
        };
        assert_eq!(after(Duration::ZERO), None);
        assert_eq!(after(COARSE - Duration::from_nanos(1)), None);
        assert_eq!(after(COARSE), times(&found));
    }
}

//! An implementation as a shared library, with the calls of `saarcor.h`.
//!
//! A library may crash or hang like any other implementation, and has one cache. So the kit does not
//! load it where it judges: a process of its own does, and [`serve`]s one conversation.

// The one place of the kit that needs it: what a library's functions do with what they are given is
// for the library to keep, and no compiler can check it. What is called here follows saarcor.h.
#![allow(unsafe_code, reason = "calls of another language have no other form")]

use crate::error::Error;
use crate::implementation::Implementation;
use crate::kind::Kind;
use crate::vm::Vm;
use crate::vm::cache::{Access, Cache, CacheAdapter, Outcome};
use crate::vm::config::KEYS;
use crate::vm::request::Observes;
use libloading::Library;
use saarcor_model::vm::{CacheConfig, CardAddr, Hash, HostAddr, Policy};
use std::io::{BufRead as _, BufReader, Read, Write};
use std::path::Path;

/// `SAARCOR_VM_VERSION`.
const VERSION: u32 = 1;

/// What fails where a stream does.
const STREAM: &str = "the conversation over standard input and output";

/// `SAARCOR_NOTHING_EVICTED`.
const NOTHING_EVICTED: u64 = u64::MAX;

/// `saarcor_config`.
#[repr(C)]
struct Config {
    line: u32,
    lines: u32,
    ways: u32,
    hash: u32,
    policy: u32,
}

/// `saarcor_access`.
#[repr(C)]
#[derive(Default)]
struct LibraryAccess {
    card: u64,
    evicted: u64,
    hit: u32,
}

/// The functions of `saarcor.h`.
#[derive(Clone, Copy)]
struct Calls {
    version: unsafe extern "C" fn() -> u32,
    observes: unsafe extern "C" fn() -> u32,
    configure: unsafe extern "C" fn(*const Config) -> u32,
    write: unsafe extern "C" fn(u32, *const u8, u64),
    read: unsafe extern "C" fn(u32, *mut u8, u32, *mut LibraryAccess),
    invalidate: unsafe extern "C" fn(u32, u64),
    flush: unsafe extern "C" fn(),
}

impl Calls {
    fn of(library: &Library) -> Result<Self, libloading::Error> {
        // SAFETY: saarcor.h declares these functions with these types.
        unsafe {
            Ok(Self {
                version: *library.get(b"saarcor_vm_version\0")?,
                observes: *library.get(b"saarcor_vm_observes\0")?,
                configure: *library.get(b"saarcor_vm_configure\0")?,
                write: *library.get(b"saarcor_vm_write\0")?,
                read: *library.get(b"saarcor_vm_read\0")?,
                invalidate: *library.get(b"saarcor_vm_invalidate\0")?,
                flush: *library.get(b"saarcor_vm_flush\0")?,
            })
        }
    }
}

/// The library's one cache, once it is configured. Its functions are called by one thread at a time,
/// as they change it, and only while the library is loaded: [`serve`] sees to both.
struct LibraryCache(Calls);

impl Cache for LibraryCache {
    fn write(&mut self, host: HostAddr, bytes: &[u8]) {
        // SAFETY: pointer and length are those of a slice.
        unsafe { (self.0.write)(host.0, bytes.as_ptr(), bytes.len() as u64) }
    }

    fn read(&mut self, host: HostAddr, bytes: &mut [u8]) -> Access {
        let mut answered = LibraryAccess::default();
        // SAFETY: pointer and length are those of a slice of at most a line, which can be written to.
        unsafe { (self.0.read)(host.0, bytes.as_mut_ptr(), bytes.len() as u32, &raw mut answered) };
        let evicted = Some(answered.evicted).filter(|&evicted| evicted != NOTHING_EVICTED);
        let outcome = match answered.hit {
            0 => Outcome::Miss(evicted.map(|evicted| HostAddr(address(evicted)))),
            _ => Outcome::Hit,
        };
        Access { card: CardAddr(address(answered.card)), outcome }
    }

    fn invalidate(&mut self, host: HostAddr, len: u64) {
        // SAFETY: takes numbers.
        unsafe { (self.0.invalidate)(host.0, len) }
    }

    fn flush(&mut self) {
        // SAFETY: takes nothing.
        unsafe { (self.0.flush)() }
    }
}

/// An address that a library returns. One of more than 32 bits becomes the greatest, and so stays wrong.
fn address(returned: u64) -> u32 {
    u32::try_from(returned).unwrap_or(u32::MAX)
}

fn configured(calls: Calls, config: &CacheConfig) -> Result<Box<dyn Cache>, Error> {
    let CacheConfig { geometry, hash, policy } = config;
    let hash = match hash {
        Hash::Low => 0,
        Hash::AddUpper => 1,
        Hash::AddUpperAll => 2,
    };
    let policy = match policy {
        Policy::Lru => 0,
        Policy::Fifo => 1,
        Policy::Plru => 2,
    };
    let (line, lines, ways) = (geometry.line().0 as u32, geometry.lines() as u32, geometry.ways());
    let config = Config { line, lines, ways, hash, policy };
    // SAFETY: the pointer is that of a configuration, which outlives the call.
    let unsupported = unsafe { (calls.configure)(&raw const config) };
    match unsupported {
        0 => Ok(Box::new(LibraryCache(calls))),
        key => {
            let name = KEYS.get(key as usize - 1).map_or(key.to_string(), |key| (*key).to_owned());
            Err(Error::Unsupported(name))
        }
    }
}

/// Loads a library and holds one conversation of `saarcor-vm` with it over streams. For a process of
/// its own, which does nothing else: nobody else may have loaded the library.
///
/// # Errors
/// Where the file is no such library, or a stream fails.
pub fn serve(path: &Path, input: impl Read, mut output: impl Write) -> Result<(), Error> {
    let shown = path.display();
    // SAFETY: to load a library runs what it begins with, which is as trustworthy as a command line
    // that is run.
    let library = unsafe { Library::new(path) };
    let what = format!("{shown}: cannot be loaded");
    let library = library.map_err(|source| Error::Library { what, source })?;
    let what = format!("{shown}: lacks a function of saarcor.h");
    let calls = Calls::of(&library).map_err(|source| Error::Library { what, source })?;
    // SAFETY: take nothing, and the library is loaded.
    let (version, observed) = unsafe { ((calls.version)(), (calls.observes)()) };
    if version != VERSION {
        // As a program of another version does: the scoreboard says what is right.
        let mut hello = String::new();
        BufReader::new(input).read_line(&mut hello).map_err(Error::system(STREAM))?;
        return writeln!(output, "{} {version}", Vm.name()).map_err(Error::system(STREAM));
    }
    let seen = |bit: u32| observed & bit != 0;
    let observes = Observes { data: seen(1), hit: seen(2), card: seen(4), evict: seen(8) };
    let make = move |kind: &dyn Kind, text: &str| {
        if kind.name() != Vm.name() {
            return Err(Error::Unsupported(kind.name().to_owned()));
        }
        if observed > 15 {
            return Err(Error::Unsupported(format!("observes of {observed:x}")));
        }
        let mut adapter = CacheAdapter::new(text, &move |config: &CacheConfig| configured(calls, config))?;
        adapter.observes = observes;
        Ok(Box::new(adapter) as Box<dyn Implementation>)
    };
    crate::server::serve(&make, input, output).map_err(Error::system(STREAM))
}

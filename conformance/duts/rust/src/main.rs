//! The cache as a filter over standard input and output, as other languages have it.

use saarcor_kit::kind::Kind;
use saarcor_kit::serve::{Served, Unsupported, serve};
use saarcor_kit::vm::cache::CacheServed;
use std::io::{stdin, stdout};

fn main() -> std::io::Result<()> {
    let make = |_: &dyn Kind, config: &str| -> Result<Box<dyn Served>, Unsupported> {
        Ok(Box::new(CacheServed::new(config, &my_cache::make)?))
    };
    serve(&make, stdin().lock(), stdout().lock())
}

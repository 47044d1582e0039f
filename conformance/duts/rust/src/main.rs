//! The cache as a filter over standard input and output, as other languages have it.

use saarcor_kit::error::Error;
use saarcor_kit::implementation::Implementation;
use saarcor_kit::kind::Kind;
use saarcor_kit::server::serve;
use saarcor_kit::vm::cache::CacheAdapter;
use std::io::{stdin, stdout};

fn main() -> std::io::Result<()> {
    let make = |_: &dyn Kind, config: &str| -> Result<Box<dyn Implementation>, Error> {
        Ok(Box::new(CacheAdapter::new(config, &my_cache::make)?))
    };
    serve(&make, stdin().lock(), stdout().lock())
}

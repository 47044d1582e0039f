//! The `saarcor` command line: see [`saarcor_conformance::cli`].

fn main() -> std::process::ExitCode {
    saarcor_conformance::cli::run(std::env::args_os())
}

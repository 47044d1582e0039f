//! The `saarcor` command line: see [`saarcor_cli::cli`].

fn main() -> std::process::ExitCode {
    saarcor_cli::cli::run(std::env::args_os())
}

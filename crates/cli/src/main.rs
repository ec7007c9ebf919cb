//! The program `truepose`.

use std::process::ExitCode;
use truepose_cli::Extensions;

fn main() -> ExitCode {
    truepose_cli::run(Extensions::builtin())
}

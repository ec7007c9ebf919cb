//! The program `truepose` with an effect and a solver of one's own.

mod descent;
mod encoder_gain;

use descent::Descent;
use encoder_gain::EncoderGain;
use std::process::ExitCode;
use truepose_cli::Extensions;

fn main() -> ExitCode {
    let extensions =
        Extensions::builtin().with_effect::<EncoderGain>().with_solver("acme/descent", || Box::new(Descent));
    truepose_cli::run(extensions)
}

#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod calibrate;
mod encoder_gain;
mod scara;

pub use calibrate::{Measurement, calibrate, rms};
pub use encoder_gain::EncoderGain;
pub use scara::{Arm, nominal};

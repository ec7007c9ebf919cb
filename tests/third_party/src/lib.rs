#![doc = include_str!("../README.md")]

mod encoder_gain;
mod hypothesis;

pub use encoder_gain::EncoderGain;
pub use hypothesis::EncoderGains;

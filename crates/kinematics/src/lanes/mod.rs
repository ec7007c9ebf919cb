//! Many postures at once, number by number: the arithmetic of one processor register of them.
//!
//! A [`Lane`] holds the same number of as many postures as fit into a register; a [`LanePose`] is a pose of twelve of them. What is
//! written here once is compiled for each width, and [`pulp`] takes the widest that the processor has when the program runs.
//! Lanes never mix: what a posture gets does not depend on its neighbours. Products and sums may be fused where the processor can,
//! so that the last digit may differ from that of [`crate::Posture`] and between processors, and between runs never.

mod number;
mod pose;

pub use number::{Lane, sin_cos_of};
pub use pose::LanePose;

//! Many postures at once, number by number: the arithmetic of one processor register of them.
//!
//! A [`Lane`] holds the same number of as many postures as fit into a register; a [`LanePose`] is a pose of twelve of them. What is
//! written here once is compiled for each width, and [`pulp`] takes the widest that the processor has when the program runs.
//! Lanes never mix: what a posture gets does not depend on its neighbours. Products and sums may be fused where the processor can,
//! so that the last digit may differ from that of [`crate::Posture`] and between processors, and between runs never.

mod number;
mod pose;

use pulp::Arch;

pub use number::{Lane, sin_cos_of};
pub use pose::LanePose;

/// Every level of registers that this processor has, from numbers alone to the widest.
pub fn levels() -> Vec<Arch> {
    #[cfg(target_arch = "x86_64")]
    {
        use pulp::x86::{V3, V4};
        let some = [V3::try_new().map(Arch::V3), V4::try_new().map(Arch::V4)];
        std::iter::once(Arch::Scalar).chain(some.into_iter().flatten()).collect()
    }
    #[cfg(not(target_arch = "x86_64"))]
    vec![Arch::Scalar, Arch::new()]
}

//! What does not matter to a robot changes no finding: relations between a set of files and another one of the same robot.
//!
//! [`relations`] change files as users change them (units, names, orders, columns, frames …); [`found`] is what a discovery makes of them.
//! The tests hold the relations on small simulated robots; `cargo xtask metamorphic` measures them on a folder of cases.

pub mod case;
pub mod found;
pub mod relations;
pub mod rigid;

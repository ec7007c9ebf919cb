#![doc = include_str!("../README.md")]

mod advice;
mod error;
mod fleet;
mod installation;
mod monitor;
mod noise_law;
mod prediction;
mod rows;
mod sister;
mod tails;
mod transfer;

pub use advice::{Advised, TransferPoses, transfer_poses};
pub use error::UpkeepError;
pub use fleet::{Fleet, fleet};
pub use installation::Installation;
pub use monitor::{
    Change, CheckPoses, Coefficient, Detectable, Look, MonitorOptions, Part, check_poses, level, monitor,
};
pub use sister::{Sister, sister};
pub use transfer::{ArmFits, Band, Transfer, TransferOptions, transfer};

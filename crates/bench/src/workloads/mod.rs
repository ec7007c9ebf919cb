//! The workloads, one file each.

mod paper;

use crate::workload::Workload;

/// In the order in which they run.
pub const ALL: &[Workload] = &[paper::W1];

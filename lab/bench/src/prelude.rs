//! What most workloads use.

pub use crate::robots::{dataset, robot, rows_of};
pub use crate::table::Table;
pub use crate::workload::{Answer, Declared, Failure, Outcome, Way, Workload};
pub use crate::{say, say_machine};
pub use std::cell::RefCell;
pub use std::path::Path;
pub use std::rc::Rc;
pub use truepose_errormodel::effects::{Geometric, JointCompliance};
pub use truepose_errormodel::{AnyEffect, Dataset, ErrorModel, FittedModel, Schema};
pub use truepose_kinematics::nalgebra::DMatrix;
pub use truepose_kinematics::{Chain, Conditions, JointId};
pub use truepose_micro::clock;
pub use truepose_solvers::PivotedQr;

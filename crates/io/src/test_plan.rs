//! The poses of an acceptance in the order in which they are measured: the file of `truepose plan --for iso9283`.

use crate::IoError;
use crate::commanded::commanded;
use crate::poses::{controller_values, si_unit};
use crate::table::TableWriter;
use std::path::Path;
use truepose_kinematics::{Chain, Payload, Pose, rotation_log};

/// One pose of one cycle.
#[derive(Debug, Clone, PartialEq)]
pub struct TestPoseRow {
    /// Number of the pose, from 1.
    pub pose: usize,
    /// Number of the cycle, from 1.
    pub cycle: usize,
    /// Variables of the movable joints, rad or m; written as the controller's values.
    pub joints: Vec<f64>,
    /// Commanded position and orientation of the tool, m, base frame.
    pub command: Pose,
}

/// Writes the columns of measurements, in m, rad and kg: measured positions are empty, to be filled in.
///
/// # Errors
/// When the file cannot be written.
pub fn write_test_plan(
    path: impl AsRef<Path>,
    chain: &Chain,
    load: Option<&Payload>,
    rows: &[TestPoseRow],
) -> Result<(), IoError> {
    let mut header: Vec<String> = ["visit", "cycle[1]", "pose[1]"].map(String::from).into();
    let own = commanded(chain);
    header.extend(own.iter().map(|&k| {
        let joint = chain.joint(chain.movable()[k]);
        format!("{}[{}]", joint.name, si_unit(joint.kind).word)
    }));
    if load.is_some() {
        header.extend(["payload[kg]", "cx[m]", "cy[m]", "cz[m]"].map(String::from));
    }
    let commands = ["command_x[m]", "command_y[m]", "command_z[m]"];
    let turned = ["command_rx[rad]", "command_ry[rad]", "command_rz[rad]"];
    header.extend(commands.into_iter().chain(turned).map(String::from));
    header.extend(["x[m]", "y[m]", "z[m]"].map(String::from));
    let mut table = TableWriter::create(path.as_ref(), &header)?;
    for (visit, row) in (1..).zip(rows) {
        table.integer(visit);
        table.integer(row.cycle as i64);
        table.integer(row.pose as i64);
        let values = controller_values(chain, &row.joints);
        own.iter().for_each(|&k| table.number(values.get(k).copied().unwrap_or(f64::NAN)));
        if let Some(load) = load {
            table.number(load.mass);
            load.com.iter().for_each(|&c| table.number(c));
        }
        row.command.translation.iter().for_each(|&v| table.number(v));
        rotation_log(&row.command.rotation).iter().for_each(|&v| table.number(v));
        (0..3).for_each(|_| table.number(f64::NAN));
        table.end_row()?;
    }
    table.finish()
}

//! The table as text: a list of parameters, or rows in the form of a table of axes.

use super::super::axes_csv::AxisConvention;
use super::super::cell::cell;
use super::{ParameterTable, PartKind};
use std::fmt::Write;
use truepose_kinematics::{Chain, JointKind, Pose};

impl ParameterTable {
    /// The corrected robot: the same geometry, as origins of its joints.
    pub fn corrected_robot(&self) -> &Chain {
        &self.chain
    }

    /// Rows of Denavit and Hartenberg as CSV, in m and rad, on the branch of the description: the form of
    /// [`AxisTable::to_csv`](crate::AxisTable::to_csv), with base and tool as they are described. None where the robot is described in another
    /// convention.
    pub fn to_axes_csv(&self, convention: AxisConvention, statement: &[String]) -> Option<String> {
        let mut out = String::new();
        for line in statement {
            let _ = writeln!(out, "# {line}");
        }
        let product = match convention {
            AxisConvention::Dh => "Rz(theta + q) Tz(d) Tx(a) Rx(alpha) Ry(beta)",
            AxisConvention::Mdh => "Rx(alpha) Tx(a) Ry(beta) Rz(theta + q) Tz(d)",
        };
        let _ = writeln!(out, "# T = base · {product} of each joint · tool; a prismatic joint adds q to d");
        let _ = writeln!(out, "# base and tool: x y z, then roll, pitch, yaw about the fixed axes x, y, z");
        let _ = writeln!(
            out,
            "row,type,theta[rad],d[m],a[m],alpha[rad],beta[rad],x[m],y[m],z[m],roll[rad],pitch[rad],yaw[rad]"
        );
        if self.chain.joints().len() != self.chain.movable().len() {
            return None;
        }
        for part in &self.parts {
            let numbers: Vec<f64> = part.parameters.iter().map(|parameter| parameter.calibrated).collect();
            let joined =
                |numbers: &[f64]| numbers.iter().map(|v| format!("{v:?}")).collect::<Vec<_>>().join(",");
            match (part.kind, convention) {
                (PartKind::Base | PartKind::Tool, _) => {
                    let _ = writeln!(out, "{},,,,,,,{}", part.name, joined(&numbers));
                }
                (PartKind::Dh(joint), AxisConvention::Dh) | (PartKind::Mdh(joint), AxisConvention::Mdh) => {
                    let slides = self.chain.joint(joint).kind == JointKind::Prismatic;
                    let kind = if slides { "prismatic" } else { "revolute" };
                    let mut numbers = numbers;
                    numbers.resize(5, 0.0);
                    let _ = writeln!(out, "{},{kind},{},,,,,,", cell(&part.name), joined(&numbers));
                }
                (PartKind::Target, _) => {}
                _ => return None,
            }
        }
        Some(out)
    }
}

impl super::ParameterPart {
    /// The part as a pose: of base, tool and origins; none of rows and targets.
    pub fn pose(&self) -> Option<Pose> {
        let at = |k: usize| self.parameters.get(k).map(|parameter| parameter.calibrated);
        let [x, y, z, roll, pitch, yaw] = [at(0)?, at(1)?, at(2)?, at(3)?, at(4)?, at(5)?];
        matches!(self.kind, PartKind::Base | PartKind::Tool | PartKind::Origin(_))
            .then(|| Pose::from_xyz_rpy([x, y, z], [roll, pitch, yaw]))
    }
}

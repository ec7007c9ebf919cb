//! A table of axes as CSV: one row a joint, a pose for base and tool.
//!
//! ```text
//! dh    T = base · Π [ Rz(θ + q) Tz(d) Tx(a) Rx(α) Ry(β) ] · tool          Tz(d + q) for a slide
//! mdh   T = base · Π [ Rx(α) Tx(a) Ry(β)  Rz(θ + q) Tz(d) ] · tool
//! ```
//!
//! β is Hayati's parameter, beside which d is zero; it is zero between axes that are not nearly parallel. The mdh
//! rows are the dh rows cut in front of each axis instead of behind it.

use super::cell::cell;
use super::table::{AxisLink, AxisRow, AxisTable};
use std::fmt::Write;
use truepose_kinematics::{Chain, JointKind, Pose};

/// Where a row of the table is cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AxisConvention {
    /// Behind the next axis: Denavit and Hartenberg.
    Dh,
    /// In front of it: Craig's modified form.
    Mdh,
}

impl AxisTable {
    /// The table as CSV, in m and rad, with digits that read back to the same numbers; `like` names the joints and
    /// `statement` goes into comments at the front.
    pub fn to_csv(&self, convention: AxisConvention, like: &Chain, statement: &[String]) -> String {
        let mut out = String::new();
        // Writing to a String cannot fail.
        let _ = self.write(convention, like, statement, &mut out);
        out
    }

    fn write(
        &self,
        convention: AxisConvention,
        like: &Chain,
        statement: &[String],
        out: &mut String,
    ) -> std::fmt::Result {
        let product = match convention {
            AxisConvention::Dh => "Rz(theta + q) Tz(d) Tx(a) Rx(alpha) Ry(beta)",
            AxisConvention::Mdh => "Rx(alpha) Tx(a) Ry(beta) Rz(theta + q) Tz(d)",
        };
        for line in statement {
            writeln!(out, "# {line}")?;
        }
        writeln!(out, "# T = base · {product} of each joint · tool; a prismatic joint adds q to d")?;
        writeln!(out, "# base and tool: x y z, then roll, pitch, yaw about the fixed axes x, y, z")?;
        writeln!(
            out,
            "row,type,theta[rad],d[m],a[m],alpha[rad],beta[rad],x[m],y[m],z[m],roll[rad],pitch[rad],yaw[rad]"
        )?;
        placed("base", &self.base, out)?;
        let mut before = [0.0; 5];
        for row in &self.rows {
            let joint = like.joint(row.joint);
            let kind = if joint.kind == JointKind::Prismatic { "prismatic" } else { "revolute" };
            let own = numbers(row);
            let [theta, d, ..] = own;
            let [_, _, a, alpha, beta] = if convention == AxisConvention::Dh { own } else { before };
            writeln!(out, "{},{kind},{theta:?},{d:?},{a:?},{alpha:?},{beta:?},,,,,,", cell(&joint.name))?;
            before = own;
        }
        // The last row has no link behind it, so that nothing is lost in front of the tool.
        placed("tool", &self.tool, out)
    }
}

/// θ, d, a, α, β of the link behind a joint.
fn numbers(row: &AxisRow) -> [f64; 5] {
    match row.link {
        None => [0.0; 5],
        Some(AxisLink::Common { theta, d, a, alpha }) => [theta, d, a, alpha, 0.0],
        Some(AxisLink::Hayati { theta, a, alpha, beta }) => [theta, 0.0, a, alpha, beta],
    }
}

fn placed(row: &str, pose: &Pose, out: &mut String) -> std::fmt::Result {
    let [x, y, z] = pose.translation.into();
    let [roll, pitch, yaw] = pose.rpy();
    writeln!(out, "{row},,,,,,,{x:?},{y:?},{z:?},{roll:?},{pitch:?},{yaw:?}")
}

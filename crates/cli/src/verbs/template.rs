//! The description of a robot that is not in the library, to be filled in.

use std::fmt::Write;

const HEAD: &str = "\
# Fill in the four parameters of each joint, and delete what does not apply.
name = \"robot\"

[units]
length = \"mm\"
angle = \"deg\"

# `dh`: distal (classic) Denavit-Hartenberg, Rz(theta + q) Tz(d) Tx(a) Rx(alpha).
# Where the data sheet has modified (proximal, Craig) parameters, write `mdh` for `dh` in every joint:
# Rx(alpha) Tx(a) Rz(theta + q) Tz(d).
# theta is the offset of the joint's zero; d and a are in mm, theta and alpha in degrees.
# A linear axis has `type = \"prismatic\"`, and its travel is added to d.
";

const TAIL: &str = "
# Where the robot stands in the measurement frame. Found from the data, without a first guess; if you know it, give
# xyz and rpy here and remove `known`.
[base]
known = false

# From the flange to the point that is measured. Found from the data as well.
[tool]
known = false

# Several reflectors on one tool: one [[targets]] each, named in the column `target` of the measurements.
# [[targets]]
# name = \"P1\"
# known = false

# Columns of your table that have other names: ours = \"yours\".
# [columns]
# j1 = \"A1 [deg]\"
# x = \"X [mm]\"
";

/// A description with this many revolute joints. Every joint has its row and its limits; all parameters are zero.
pub fn robot(rows: u16) -> String {
    let mut text = String::from(HEAD);
    for k in 1..=rows {
        let _ = write!(
            text,
            "\n[[joints]]\nname = \"j{k}\"\n# limits = [-180, 180]\ndh = {{ theta = 0, d = 0, a = 0, alpha = 0 }}\n"
        );
    }
    text + TAIL
}

//! What the robot as described leaves, and where its flange is: to be held against the pendant before anything is fitted.

use truepose_errormodel::Dataset;
use truepose_identify::{
    Cause, Misread, Misreading, NominalResidual, Suspicion, misreadings, nominal_residual,
};
use truepose_kinematics::{Chain, Placed, Placement, Pose};
use truepose_report::significant;

/// A nominal robot that leaves more than this share of its length is not the one that was measured, or written in another convention.
const LOUD: f64 = 0.01;
/// A residual beyond this share of its length is no error of a robot.
const NO_ROBOT: f64 = 0.25;
/// Below this share positions fit, and mistakes of orientations or of the tool are looked for; as in the search for them.
const NEGLIGIBLE: f64 = 2e-3;
/// Of orientations, rad: ten times what installed robots leave. A mistake that explains it is named.
const TURNED: f64 = 0.02;
/// Of orientations, rad, where no mistake explains it: what the zeros of six joints that are off by 2° each do not reach.
const CONVENTION: f64 = 0.1;

/// What is known before a fit.
#[derive(Debug)]
pub struct Nominal {
    /// What it leaves of the rows; none without rows.
    pub residual: Option<NominalResidual>,
    /// Mistakes of the description that explain it.
    pub misread: Vec<Misread>,
    /// A mistake of the table explains it all, and has its own warning.
    explained: bool,
    /// Flange in the robot's base, with all values of the controller at zero.
    pub zeros: Pose,
    /// The same at the first row, with its line.
    pub first: Option<(u64, Pose)>,
}

impl Nominal {
    /// Of a robot and measurements; `suspected` are mistakes of the table that were found otherwise.
    pub fn of(chain: &Chain, data: Option<&Dataset>, suspected: &[Suspicion]) -> Nominal {
        let bare = chain.clone().with_base(Placed::default()).and_then(|c| c.with_tool(Placed::default()));
        let bare = bare.unwrap_or_else(|_| chain.clone());
        let mut zeros = vec![0.0; chain.movable().len()];
        bare.joints_from_controller(&mut zeros);
        let zeros = bare.forward(&zeros);
        // Rows of no file have no lines.
        let first = data.and_then(|data| {
            let joints: Option<Vec<f64>> = data.joints.iter().map(|column| column.first().copied()).collect();
            Some((*data.line.first()?, bare.forward(&joints?)))
        });
        let residual = data.and_then(|data| nominal_residual(chain, data).ok().flatten());
        let good = LOUD * chain.characteristic_length();
        let rows = |cause: &Cause| {
            matches!(cause, Cause::StrayRows { .. } | Cause::SwappedLabels { .. } | Cause::InSomeRows { .. })
        };
        let off = residual.as_ref().is_some_and(|found| found.share() > NEGLIGIBLE);
        // Where a mistake of the table explains it, or a few rows, the description is not suspected.
        let mut others = suspected.iter().filter(|s| s.cause != Cause::BaseElsewhere && s.after < good);
        let explained = others.any(|s| off || !rows(&s.cause));
        let misread = match (&residual, data) {
            (Some(residual), Some(data)) if !explained => misreadings(chain, data, residual),
            _ => Vec::new(),
        };
        Nominal { residual, misread, explained, zeros, first }
    }

    /// Warnings: the description or the conventions do not fit, and the likely cause.
    pub fn warnings(&self, chain: &Chain) -> Vec<String> {
        let Some(found) = &self.residual else { return Vec::new() };
        let mut list = Vec::new();
        if self.explained {
            return list;
        }
        if found.share() > LOUD {
            list.push(format!(
                "the robot description or the conventions do not fit the data: with the best base and tool, {} mm RMS are left, {} % of \
                 the arm's length of {} m{}",
                significant(1e3 * found.position_rms, 3),
                significant(1e2 * found.share(), 2),
                significant(found.length, 3),
                if self.misread.is_empty() {
                    "; hold the flange poses of `truepose check` against the pendant, and the parameters against the data sheet"
                } else {
                    ""
                }
            ));
        } else if let Some(turned) = found
            .orientation_rms
            .filter(|&turned| turned > if self.misread.is_empty() { CONVENTION } else { TURNED })
        {
            list.push(format!(
                "the measured orientations do not fit the robot: {} mrad RMS are left with the best tool, while positions fit{}",
                significant(1e3 * turned, 3),
                if self.misread.is_empty() { "; check their convention (--orientation)" } else { "" }
            ));
        }
        for one in &self.misread {
            let (unit, scale) = match one.what {
                Misreading::Angles { .. }
                | Misreading::OtherAngles { .. }
                | Misreading::RotationVector
                | Misreading::InverseOrientation
                | Misreading::ScalarLast => ("mrad", 1e3),
                _ => ("mm", 1e3),
            };
            list.push(format!(
                "{}; undoing that leaves {} {unit} instead of {} {unit}",
                words(&one.what, chain),
                significant(scale * one.after, 3),
                significant(scale * one.before, 3)
            ));
        }
        list
    }

    /// Whether the robot as described leaves much, and one mistake in the description or in a convention explains it; or so much that no robot errs by it.
    pub fn misread_throughout(&self) -> bool {
        let share = self.residual.as_ref().map_or(0.0, NominalResidual::share);
        !self.explained && (share > LOUD && !self.misread.is_empty() || share > NO_ROBOT)
    }

    /// For the terminal.
    pub fn text(&self) -> String {
        let mut text = String::from("\nnominal robot\n");
        text += &format!(" flange at all zeros: {}\n", place(&self.zeros));
        if let Some((line, pose)) = &self.first {
            text += &format!(" flange in line {line}:   {}\n", place(pose));
        }
        if let Some(found) = &self.residual {
            let turned = found
                .orientation_rms
                .map_or_else(String::new, |rms| format!(", {} mrad", significant(1e3 * rms, 3)));
            text += &format!(
                " left with the best base and tool: {} mm{turned} RMS ({} % of the arm's length of {} m)\n",
                significant(1e3 * found.position_rms, 3),
                significant(1e2 * found.share(), 2),
                significant(found.length, 3)
            );
        }
        text
    }

    /// For other programs.
    pub fn json(&self, chain: &Chain) -> serde_json::Value {
        let pose = |pose: &Pose| {
            let t = pose.translation * 1e3;
            serde_json::json!({"xyz_mm": [t.x, t.y, t.z], "rpy_deg": pose.rpy().map(f64::to_degrees)})
        };
        serde_json::json!({
            "flange_at_zeros": pose(&self.zeros),
            "flange_at_first_row": self.first.as_ref().map(|(_, first)| pose(first)),
            "position_rms_mm": self.residual.as_ref().map(|r| 1e3 * r.position_rms),
            "orientation_rms_mrad": self.residual.as_ref().and_then(|r| r.orientation_rms).map(|rms| 1e3 * rms),
            "share_of_length": self.residual.as_ref().map(NominalResidual::share),
            "likely": self.misread.iter().map(|m| words(&m.what, chain)).collect::<Vec<_>>(),
        })
    }
}

fn place(pose: &Pose) -> String {
    let (t, r) = (pose.translation * 1e3, pose.rpy().map(f64::to_degrees));
    let mm = |v: f64| format!("{:.2}", if v.abs() < 5e-3 { 0.0 } else { v });
    let deg = |v: f64| format!("{:.3}", if v.abs() < 5e-4 { 0.0 } else { v });
    format!("xyz {} {} {} mm, rpy {} {} {} °", mm(t.x), mm(t.y), mm(t.z), deg(r[0]), deg(r[1]), deg(r[2]))
}

/// The mistake in words.
fn words(what: &Misreading, chain: &Chain) -> String {
    let joint = |k: usize| chain.joints().get(k).map_or("?", |joint| joint.name.as_str());
    let moving = |k: usize| chain.movable().get(k).map_or("?", |&id| chain.joint(id).name.as_str());
    match what {
        Misreading::MdhForDh => "the parameters under `mdh` seem to be standard DH parameters (`dh`)".into(),
        Misreading::DhForMdh => "the parameters under `dh` seem to be modified DH parameters (`mdh`)".into(),
        Misreading::AngleUnit { factor } if *factor < 1.0 => {
            "alpha and theta seem to be degrees that are read as rad: set `angle = \"deg\"` in [units]".into()
        }
        Misreading::AngleUnit { .. } => {
            "alpha and theta seem to be radians that are read as deg: set `angle = \"rad\"` in [units]".into()
        }
        Misreading::Sign { joint: Some(k), parameter } => {
            format!("`{parameter}` of {} seems to have the opposite sign", joint(*k))
        }
        Misreading::Sign { joint: None, parameter } => {
            format!("`{parameter}` seems to have the opposite sign in all joints")
        }
        Misreading::Coupling { joint, driver, sign } => {
            let (joint, driver) = (moving(*joint), moving(*driver));
            let (sign, contains) = if *sign > 0.0 { ("+", "less") } else { ("−", "plus") };
            format!(
                "{joint} seems to be coupled to {driver} (as J3 to J2 on FANUC robots and parallelograms): its column contains the angle \
                 {contains} that of {driver}; use {joint} {sign} {driver}"
            )
        }
        Misreading::Length { joint: k, parameter, change } => {
            let now =
                chain.joints().get(*k).and_then(|joint| length(&joint.placement, parameter)).unwrap_or(0.0);
            format!(
                "`{parameter}` of {} seems to be {} mm, not {} mm",
                joint(*k),
                significant(1e3 * (now + change), 4),
                significant(1e3 * now, 4)
            )
        }
        Misreading::Angles { convention } => {
            format!(
                "orientations seem to be angles that are read as a rotation vector: try `--orientation {convention}`"
            )
        }
        Misreading::OtherAngles { convention } => {
            format!("orientations seem to be angles of another convention: try `--orientation {convention}`")
        }
        Misreading::RotationVector => {
            "orientations seem to be rotation vectors that are read as angles: try `--orientation rotation_vector`".into()
        }
        Misreading::InversePoses => {
            "positions and orientations seem to be inverse: the measurement frame seen from the tool".into()
        }
        Misreading::ToolTurned { axis, angle } => {
            let (axis, angle) = (["x", "y", "z"][*axis], significant(angle.to_degrees(), 3));
            format!("[tool] seems to be turned on the flange: about the flange's {axis} by {angle}°")
        }
        Misreading::ToolSign { axis } => {
            format!("{} of [tool] seems to have the opposite sign", ["x", "y", "z"][*axis])
        }
        Misreading::ToolElsewhere => {
            "the tool is not where [tool] declares it; with `known = false` it is found from the data".into()
        }
        Misreading::InverseOrientation => {
            "orientations seem to be inverse: those of the measurement frame seen from the tool".into()
        }
        Misreading::ScalarLast => {
            "quaternions seem to have their scalar last: rename the columns to qx qy qz qw".into()
        }
        _ => "the description seems to be in another convention".into(),
    }
}

fn length(placement: &Placement, parameter: &str) -> Option<f64> {
    match (placement, parameter) {
        (Placement::Dh { a, .. } | Placement::Mdh { a, .. }, "a") => Some(*a),
        (Placement::Dh { d, .. } | Placement::Mdh { d, .. }, "d") => Some(*d),
        (Placement::Origin { pose, .. }, "x") => Some(pose.translation.x),
        (Placement::Origin { pose, .. }, "y") => Some(pose.translation.y),
        (Placement::Origin { pose, .. }, "z") => Some(pose.translation.z),
        _ => None,
    }
}

//! The parameters of a fitted robot as it is described.

use crate::error::WorkflowError;
use std::path::Path;
use truepose_compensate::{ExportOptions, Parameter, ParameterTable, PartKind, parameter_table};
use truepose_errormodel::effects::Geometric;
use truepose_errormodel::{Effect, FittedModel, Sample};
use truepose_io::{
    ExportUnits, FrameParent, NamedFrame, ParameterRow, Quantity, RobotDetails, Unit, WholeFile,
    parameters_file,
};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Chain, Placement, Pose};
use truepose_report::{OffsetApart, ParameterSummary, ParametersSummary};

/// Half width of a 95 % interval, in standard uncertainties.
const COVERAGE: f64 = 1.959_964;
/// Where a fit has the units of its robot file.
const UNITS: &str = "units";

/// Where a fit has the named frames of its robot file.
const FRAMES: &str = "frames";

/// Records units and frames of a robot in a fit.
pub fn record_details(fitted: &mut FittedModel, RobotDetails { units, frames, .. }: &RobotDetails) {
    let words = serde_json::json!({"length": units.length.word, "angle": units.angle.word});
    fitted.provenance.insert(UNITS.into(), words);
    if !frames.is_empty() {
        let one = |frame: &NamedFrame| {
            let xyz: [f64; 3] = frame.pose.translation.into();
            let inside =
                INSIDE.iter().find(|(_, inside)| *inside == frame.inside).map_or("base", |word| word.0);
            serde_json::json!({"name": frame.name, "in": inside, "xyz_m": xyz, "quaternion": frame.pose.quaternion()})
        };
        fitted.provenance.insert(FRAMES.into(), frames.iter().map(one).collect::<Vec<_>>().into());
    }
}

const INSIDE: [(&str, FrameParent); 3] =
    [("base", FrameParent::Base), ("measurement", FrameParent::Measurement), ("flange", FrameParent::Flange)];

/// The named frames of the robot's file, as the fit has them.
pub fn recorded_frames(fitted: &FittedModel) -> Vec<NamedFrame> {
    let one = |value: &serde_json::Value| {
        let numbers = |key: &str| -> Option<Vec<f64>> {
            value.get(key)?.as_array()?.iter().map(serde_json::Value::as_f64).collect()
        };
        let xyz: [f64; 3] = numbers("xyz_m")?.try_into().ok()?;
        let turn: [f64; 4] = numbers("quaternion")?.try_into().ok()?;
        let word = value.get("in")?.as_str()?;
        let inside = INSIDE.iter().find(|(name, _)| *name == word)?.1;
        let pose = Pose::new(Pose::rotation_from_quaternion(turn), Vector3::from(xyz));
        Some(NamedFrame { name: value.get("name")?.as_str()?.into(), inside, pose })
    };
    let list = fitted.provenance.get(FRAMES).and_then(serde_json::Value::as_array);
    list.into_iter().flatten().filter_map(one).collect()
}

/// The units of the robot's file, as the fit has them; without any, mm and degrees.
pub fn recorded_units(fitted: &FittedModel) -> ExportUnits {
    let recorded = |key: &str, quantity: Quantity| {
        let word = fitted.provenance.get(UNITS)?.get(key)?.as_str()?;
        Unit::named(word).filter(|unit| unit.quantity == quantity).copied()
    };
    let metric = |word: &str, quantity: Quantity| *Unit::named(word).unwrap_or_else(|| quantity.si());
    ExportUnits {
        length: recorded("length", Quantity::Length).unwrap_or_else(|| metric("mm", Quantity::Length)),
        angle: recorded("angle", Quantity::Angle).unwrap_or_else(|| metric("deg", Quantity::Angle)),
    }
}

/// The parameters of a fit, or why there are none.
pub fn parameters(fitted: &FittedModel) -> ParametersSummary {
    match parameter_table(fitted, &ExportOptions::default()) {
        Ok(exported) => {
            let summary = parameters_of(fitted, &exported.value, &exported.left_out);
            ParametersSummary { zero_offsets_apart: apart(fitted, &summary), ..summary }
        }
        Err(error) => ParametersSummary { absent: Some(error.to_string()), ..ParametersSummary::default() },
    }
}

/// Where base, tool and targets that were found are; nothing where the fit has no table.
pub(crate) fn places(fitted: &FittedModel, found: &[String]) -> Vec<ParameterSummary> {
    let table = parameter_table(fitted, &ExportOptions::default());
    table.map(|table| parameters_of(fitted, &table.value, &table.left_out).found(found)).unwrap_or_default()
}

/// A table in the units of the robot's file.
pub fn parameters_of(
    fitted: &FittedModel,
    table: &ParameterTable,
    left_out: &[&'static str],
) -> ParametersSummary {
    let units = recorded_units(fitted);
    let of = |unit: &str| if unit == "m" { units.length } else { units.angle };
    let one = |part: &str, parameter: &Parameter, remark: &str| {
        let unit = of(parameter.unit);
        let estimated = parameter.standard_uncertainty > 0.0;
        ParameterSummary {
            part: part.into(),
            parameter: parameter.name.into(),
            unit: unit.word.into(),
            // No minus before a zero.
            nominal: parameter.nominal.map(|value| unit.from_si(value) + 0.0),
            delta: parameter.nominal.map(|value| unit.from_si(parameter.calibrated - value) + 0.0),
            calibrated: unit.from_si(parameter.calibrated),
            half_width_95: estimated.then(|| unit.from_si(COVERAGE * parameter.standard_uncertainty)),
            remark: if estimated { String::new() } else { remark.into() },
        }
    };
    let parameters = table.parts.iter().flat_map(|part| {
        let name =
            if part.kind == PartKind::Target { format!("target {}", part.name) } else { part.name.clone() };
        part.parameters.iter().map(move |parameter| one(&name, parameter, "kept")).collect::<Vec<_>>()
    });
    let parameters = parameters.collect();
    let chain: &Chain = fitted.chain();
    let degrees = Unit::named("deg").unwrap_or_else(|| Quantity::Angle.si());
    let millimetres = Unit::named("mm").unwrap_or_else(|| Quantity::Length.si());
    let offset = |offset: &truepose_compensate::JointOffset| {
        let joint = chain.joint(offset.joint);
        let unit = if joint.unit() == "m" { millimetres } else { degrees };
        let estimated = offset.standard_uncertainty > 0.0;
        let mut remark = match offset.part_of {
            Some(part) => format!("not distinguishable: part of {part}"),
            None if estimated => String::new(),
            None => "kept".into(),
        };
        if let Some(own) = offset.of_variable {
            let drivers = chain.couplings().iter().filter(|coupling| coupling.joint == offset.joint);
            let drivers: Vec<&str> =
                drivers.map(|coupling| chain.joint(coupling.driver).name.as_str()).collect();
            let between = if remark.is_empty() { "" } else { "; " };
            let own = unit.from_si(own) + 0.0;
            remark += &format!(
                "{between}coupled to {}: the joint itself is off by {own:.4} {}",
                drivers.join(", "),
                unit.word
            );
        }
        ParameterSummary {
            part: joint.name.clone(),
            parameter: "zero_offset".into(),
            unit: unit.word.into(),
            nominal: Some(0.0),
            // No minus before a zero.
            delta: Some(unit.from_si(offset.offset) + 0.0),
            calibrated: unit.from_si(offset.offset) + 0.0,
            half_width_95: estimated.then(|| unit.from_si(COVERAGE * offset.standard_uncertainty)),
            remark,
        }
    };
    ParametersSummary {
        absent: None,
        left_out: left_out.iter().map(ToString::to_string).collect(),
        by_origins: table.parts.iter().any(|part| match part.kind {
            PartKind::Origin(joint) => !matches!(chain.joint(joint).placement, Placement::Origin { .. }),
            _ => false,
        }),
        parameters,
        joint_zero_offsets: table.offsets.iter().map(offset).collect(),
        zero_offsets_apart: Vec::new(),
    }
}

/// Effective zero offsets as the zeros of the constants and the mean of all other effects; nothing where the model has constants alone.
fn apart(fitted: &FittedModel, whole: &ParametersSummary) -> Vec<OffsetApart> {
    let of = |constant: bool| {
        let mut fitted = fitted.clone().only(|family| (family == Geometric::FAMILY) == constant);
        fitted.fallback = None;
        // A part of the model is held against that part, and not against what was measured.
        let mut rows = fitted.domain.sample.rows().clone();
        rows.position.fill([f64::NAN; 3]);
        fitted.domain.sample = Sample::of(&rows).for_model(fitted.model());
        let table = parameter_table(&fitted, &ExportOptions::default()).ok()?;
        Some(parameters_of(&fitted, &table.value, &table.left_out).joint_zero_offsets)
    };
    if whole.left_out.is_empty() {
        return Vec::new();
    }
    let Some((own, rest)) = of(true).zip(of(false)) else { return Vec::new() };
    let known = whole.joint_zero_offsets.iter().zip(own).zip(rest);
    let estimated = known.filter(|((effective, _), _)| effective.half_width_95.is_some());
    let one =
        |((effective, own), rest): ((&ParameterSummary, ParameterSummary), ParameterSummary)| OffsetApart {
            joint: effective.part.clone(),
            unit: effective.unit.clone(),
            effective: effective.calibrated,
            own: own.calibrated,
            own_half_width_95: own.half_width_95,
            difference: effective.calibrated - own.calibrated,
            difference_half_width_95: rest.half_width_95,
        };
    estimated.map(one).collect()
}

/// The CSV file of the parameters, zero offsets last.
///
/// # Errors
/// When there is no table, or the file cannot be written.
pub fn parameters_csv(path: &Path, summary: &ParametersSummary) -> Result<WholeFile, WorkflowError> {
    if let Some(why) = &summary.absent {
        return Err(WorkflowError::option("parameters", why.clone()));
    }
    let row = |of: &ParameterSummary| ParameterRow {
        part: of.part.clone(),
        parameter: of.parameter.clone(),
        unit: of.unit.clone(),
        nominal: of.nominal.unwrap_or(f64::NAN),
        delta: of.delta.unwrap_or(f64::NAN),
        calibrated: of.calibrated,
        interval_95: of.half_width_95.unwrap_or(f64::NAN),
        remark: of.remark.clone(),
    };
    let rows: Vec<ParameterRow> =
        summary.parameters.iter().chain(&summary.joint_zero_offsets).map(row).collect();
    Ok(parameters_file(path, &rows)?)
}

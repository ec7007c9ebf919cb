//! The whole assessment: measured rows in, characteristics and remarks out.

use crate::attained::{Alignment, Attained, TestPose, attained};
use crate::budget::Budget;
use crate::characteristics::Characteristics;
use crate::compliance::{compliance, force};
use crate::error::AcceptanceError;
use crate::model_budget::budget;
use crate::path::{PathFigures, path_figures};
use crate::remark::Remark;
use crate::scatter::Scatter;
use nalgebra::Vector3;
use std::collections::BTreeMap;
use truepose_errormodel::{Dataset, FittedModel};
use truepose_kinematics::{Chain, Conditions, Pose, rotation_vector};

/// How to assess.
#[derive(Debug, Clone, PartialEq)]
pub struct AssessmentOptions {
    /// Where the frames of instrument and robot come from; none: as described, or a best fit where the base is to be found.
    pub alignment: Option<Alignment>,
    /// Standard uncertainty (k = 1) of the instrument that the readings of one pose share, each axis, m.
    pub common: f64,
    /// The rows are points of a path (the channel `cycle` numbers its repeats), not poses.
    pub path: bool,
}

impl Default for AssessmentOptions {
    fn default() -> Self {
        AssessmentOptions { alignment: None, common: 0.0, path: false }
    }
}

/// Characteristics before and after.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Assessment {
    /// Attained against commanded.
    pub before: Characteristics,
    /// The same without the displacement that the model predicts; none without a fit.
    pub after: Option<Characteristics>,
    /// Of a position that the calibrated robot attains once; none without a fit, or for a path.
    pub budget: Option<Budget>,
    /// The frames that were used.
    pub alignment: Alignment,
    /// Standard uncertainty that the readings of one pose share, m.
    pub common: f64,
    /// What a reader has to know.
    pub remarks: Vec<Remark>,
}

/// Assesses measured rows: against commanded poses (the nominal robot at the joint values of the data, or the channels `command_x` …), and
/// with the displacement that a fit predicts taken off.
///
/// # Errors
/// When nothing was repeated, commanded poses are not known, or the data does not fit the robot.
pub fn assess(
    chain: &Chain,
    fitted: Option<&FittedModel>,
    data: &Dataset,
    options: &AssessmentOptions,
) -> Result<Assessment, AcceptanceError> {
    if !(options.common.is_finite() && options.common >= 0.0) {
        let (option, value, expected) = ("the instrument's uncertainty", options.common, "0 or more");
        return Err(AcceptanceError::Option { option, value, expected });
    }
    let chain = fitted.map_or(chain, FittedModel::chain);
    data.validate(chain)?;
    let columns = command_columns(data)?;
    let found = fitted.is_some() || chain.base().known;
    let usual = if found { Alignment::Described } else { Alignment::BestFit };
    let alignment = options.alignment.unwrap_or(usual);
    if fitted.is_none() {
        known(chain, data, columns.is_some(), alignment)?;
    }
    let nominal: Vec<Pose> = (0..data.len()).map(|row| at(chain, data, row)).collect();
    let to_base = chain.base().pose.inverse();
    let mut commanded: Vec<Pose> = nominal.iter().map(|pose| to_base * *pose).collect();
    if let Some(columns) = &columns {
        for (pose, given) in commanded.iter_mut().zip(columns) {
            *pose = Pose::new(given.1.unwrap_or(pose.rotation), given.0);
        }
    }
    let displaced = fitted.map(|fitted| displacements(fitted, data, &nominal)).transpose()?;
    if options.path {
        return of_path(chain, data, &commanded, displaced.as_deref(), alignment, options);
    }
    let state = |displaced: Option<&[Pose]>| -> Result<(Attained, Characteristics), AcceptanceError> {
        let attained = attained(data, chain, &commanded, displaced, alignment)?;
        let forces: Vec<Vec<Vector3<f64>>> =
            attained.poses.iter().map(|pose| vec![of_load(chain, pose); pose.cycles.len()]).collect();
        let yields = compliance(&attained.poses, &forces);
        let characteristics = Characteristics::of(&attained, options.common, yields);
        Ok((attained, characteristics))
    };
    let (poses, before) = state(None)?;
    let after = displaced.as_deref().map(|all| state(Some(all))).transpose()?;
    let budget = match (fitted, &after) {
        (Some(fitted), Some((left, _))) => Some(budget(fitted, data, &left.poses, options.common)?),
        _ => None,
    };
    let after = after.map(|found| found.1);
    let remarks = remarks(data, &poses, &before, alignment, options.common);
    Ok(Assessment { before, after, budget, alignment, common: options.common, remarks })
}

/// Commands need a base, tool and target that are described.
fn known(chain: &Chain, data: &Dataset, columns: bool, alignment: Alignment) -> Result<(), AcceptanceError> {
    let open = |what: String| Err(AcceptanceError::Commanded { what });
    if columns {
        return Ok(());
    }
    if !chain.base().known && alignment == Alignment::Described {
        return open("the base".into());
    }
    if !chain.tools_known() {
        return open("the tool".into());
    }
    for target in data.target.iter().flatten() {
        let target = &chain.targets()[target.0];
        if !target.known {
            return open(format!("target `{}`", target.name));
        }
    }
    Ok(())
}

/// The nominal robot in a row: position of the target, orientation of the tool, measurement frame.
fn at(chain: &Chain, data: &Dataset, row: usize) -> Pose {
    let joints: Vec<f64> = data.joints.iter().map(|column| column[row]).collect();
    let tool = chain.forward(&joints);
    let point = data.target[row].map_or(tool.translation, |t| tool.apply(&chain.targets()[t.0].position));
    Pose::new(tool.rotation, point)
}

/// Displacement of the target and rotation of the tool from the nominal robot that the model predicts.
fn displacements(
    fitted: &FittedModel,
    data: &Dataset,
    nominal: &[Pose],
) -> Result<Vec<Pose>, AcceptanceError> {
    let inputs = data.derived_for(fitted.model())?;
    let mut predictor = fitted.bind(&inputs.schema)?;
    let mut conditions = Conditions::default();
    let one = |(row, nominal): (usize, &Pose)| {
        inputs.conditions_into(row, &mut conditions);
        let real = predictor.predict(&conditions, inputs.target[row]);
        Pose::new(real.rotation * nominal.rotation.transpose(), real.translation - nominal.translation)
    };
    Ok(nominal.iter().enumerate().map(one).collect())
}

fn of_load(chain: &Chain, pose: &TestPose) -> Vector3<f64> {
    force(chain, &pose.load, &pose.commanded.rotation)
}

type Commanded = (Vector3<f64>, Option<nalgebra::Matrix3<f64>>);

/// Channels `command_x`, `command_y`, `command_z` (lengths) and `command_rx` … (rotation vector), base frame.
fn command_columns(data: &Dataset) -> Result<Option<Vec<Commanded>>, AcceptanceError> {
    let three =
        |names: [&str; 3], need: &'static str| -> Result<Option<Vec<Vector3<f64>>>, AcceptanceError> {
            let found = names.map(|name| data.schema.channel(name));
            let Some(have) = found.iter().position(Option::is_some) else { return Ok(None) };
            let mut columns = Vec::new();
            for (place, name) in found.iter().zip(names) {
                let Some(k) = *place else {
                    let (have, lacks) = (names[have].into(), name.into());
                    return Err(AcceptanceError::CommandColumns { have, lacks });
                };
                let unit = &data.schema.channels[k].unit;
                let factor = factor(unit, need == "a length").ok_or_else(|| {
                    AcceptanceError::CommandUnit { column: name.into(), unit: unit.clone(), need }
                })?;
                columns.push((&data.channels[k], factor));
            }
            let row = |row: usize| Vector3::from_fn(|k, _| columns[k].0[row] * columns[k].1);
            Ok(Some((0..data.len()).map(row).collect()))
        };
    let Some(positions) = three(["command_x", "command_y", "command_z"], "a length")? else {
        return Ok(None);
    };
    let turned = three(["command_rx", "command_ry", "command_rz"], "an angle")?;
    let one = |(row, position): (usize, Vector3<f64>)| {
        (position, turned.as_ref().map(|all| rotation_vector(&all[row])))
    };
    Ok(Some(positions.into_iter().enumerate().map(one).collect()))
}

/// SI units per unit of a channel.
fn factor(unit: &str, length: bool) -> Option<f64> {
    match (unit, length) {
        ("m", true) | ("rad", false) => Some(1.0),
        ("mm", true) | ("mrad", false) => Some(1e-3),
        ("um", true) => Some(1e-6),
        ("in", true) => Some(0.0254),
        ("deg", false) => Some(1f64.to_radians()),
        _ => None,
    }
}

/// AT and RT; the commanded path is that of the first cycle.
fn of_path(
    chain: &Chain,
    data: &Dataset,
    commanded: &[Pose],
    displaced: Option<&[Pose]>,
    alignment: Alignment,
    options: &AssessmentOptions,
) -> Result<Assessment, AcceptanceError> {
    let wrong = |reason| AcceptanceError::Path { reason };
    let number = data
        .schema
        .channel("cycle")
        .ok_or(wrong("the data has no column `cycle`, which numbers the repeats of the path"))?;
    let mut cycles: BTreeMap<i64, Vec<usize>> = BTreeMap::new();
    let whole = |row: &usize| data.position[*row].iter().all(|v| !v.is_nan());
    for row in (0..data.len()).filter(whole) {
        cycles.entry(data.channels[number][row].round() as i64).or_default().push(row);
    }
    if data.schema.time {
        cycles.values_mut().for_each(|rows| rows.sort_by(|&a, &b| data.time[a].total_cmp(&data.time[b])));
    }
    let first = cycles.values().next().cloned().unwrap_or_default();
    let path: Vec<Vector3<f64>> = first.iter().map(|&row| commanded[row].translation).collect();
    let to_base = chain.base().pose.inverse();
    let state = |displaced: Option<&[Pose]>| -> Result<Characteristics, AcceptanceError> {
        let at = |row: usize| {
            let moved = displaced.map_or_else(Vector3::zeros, |all| all[row].translation);
            to_base.apply(&(data.measured_position(row) - moved))
        };
        let motion = match alignment {
            Alignment::Described => None,
            Alignment::BestFit => {
                let pairs: Vec<_> =
                    cycles.values().flatten().map(|&row| (at(row), commanded[row].translation)).collect();
                Some(crate::best_fit::best_fit(&pairs)?)
            }
        };
        let place = |row: &usize| motion.map_or_else(|| at(*row), |motion| motion.apply(&at(*row)));
        let attained: Vec<Vec<Vector3<f64>>> =
            cycles.values().map(|rows| rows.iter().map(place).collect()).collect();
        let path: PathFigures = path_figures(&path, &attained, options.common)?;
        let none = Vec::new;
        let poses = Vec::new();
        Ok(Characteristics { poses, distances: none(), compliance: Vec::new(), path: Some(path), motion })
    };
    let before = state(None)?;
    let after = displaced.map(|all| state(Some(all))).transpose()?;
    let mut remarks = Vec::new();
    if cycles.len() < 10 {
        remarks.push(Remark::FewPathCycles { cycles: cycles.len() });
    }
    if alignment == Alignment::BestFit {
        remarks.push(Remark::BestFit { poses: path.len() });
    }
    stated(data, options.common, &mut remarks);
    Ok(Assessment { before, after, budget: None, alignment, common: options.common, remarks })
}

/// What of the conditions is not stated.
fn stated(data: &Dataset, common: f64, remarks: &mut Vec<Remark>) {
    if !data.schema.load {
        remarks.push(Remark::LoadNotStated);
    }
    if ["speed", "velocity"].iter().all(|name| data.schema.channel(name).is_none()) {
        remarks.push(Remark::SpeedNotStated);
    }
    if common <= 0.0 {
        remarks.push(Remark::NoCommonUncertainty);
    }
}

/// Places that say something about a workspace: with 59 random poses that conform, 95 % of all do, with 95 % confidence (Wilks 1941).
const PLACES: usize = 59;

fn remarks(
    data: &Dataset,
    attained: &Attained,
    before: &Characteristics,
    alignment: Alignment,
    common: f64,
) -> Vec<Remark> {
    let mut remarks = Vec::new();
    let poses = &attained.poses;
    let fewest = before.poses.iter().map(|pose| pose.pose.cycles).min().unwrap_or(0);
    if fewest < 30 {
        remarks.push(Remark::FewCycles { fewest });
    }
    if poses.len() != 5 {
        remarks.push(Remark::NotFivePoses { poses: poses.len() });
    }
    if poses.len() < PLACES {
        remarks.push(Remark::FewPlaces { poses: poses.len() });
    }
    stated(data, common, &mut remarks);
    if poses.iter().any(|pose| pose.load != poses[0].load) {
        remarks.push(Remark::SeveralLoads);
    }
    if alignment == Alignment::BestFit {
        remarks.push(Remark::BestFit { poses: poses.len() });
    }
    remarks.extend(
        poses
            .iter()
            .filter(|pose| pose.directions > 1)
            .map(|pose| Remark::Directions { pose: pose.name.clone(), directions: pose.directions }),
    );
    let expanded = poses.iter().filter_map(|pose| pose.stated_sd).fold(common, f64::max) * 2.0;
    let smallest = before
        .poses
        .iter()
        .flat_map(|pose| [("AP", pose.pose.ap.value), ("RP", pose.pose.rp.value)])
        .min_by(|a, b| a.1.total_cmp(&b.1));
    // The standard's limit: a quarter of the characteristic.
    if let Some((symbol, figure)) = smallest.filter(|(_, figure)| expanded > 0.25 * figure) {
        remarks.push(Remark::Instrument { expanded, figure, symbol });
    }
    let dependent = poses.iter().filter_map(|pose| {
        let positions = pose.deviations(pose.main_direction());
        // One-sided 0.1 % of an independent series; of several poses the largest is shown.
        let limit = 3.09 / (positions.len() as f64).sqrt();
        Some((pose, lag_one(&positions)?)).filter(|(_, r)| *r > limit)
    });
    if let Some((pose, correlation)) = dependent.max_by(|a, b| a.1.total_cmp(&b.1)) {
        remarks.push(Remark::Dependent { pose: pose.name.clone(), correlation });
    }
    if attained.partial > 0 {
        remarks.push(Remark::PartlyMeasured { rows: attained.partial });
    }
    if attained.once > 0 {
        remarks.push(Remark::MeasuredOnce { poses: attained.once });
    }
    remarks
}

/// Correlation of a cycle with the next one, of all axes together.
fn lag_one(positions: &[Vector3<f64>]) -> Option<f64> {
    if positions.len() < 8 {
        return None;
    }
    let mean = Scatter::of(positions).mean;
    let square: f64 = positions.iter().map(|p| (p - mean).norm_squared()).sum();
    let product: f64 = positions.windows(2).map(|pair| (pair[0] - mean).dot(&(pair[1] - mean))).sum();
    (square > 0.0).then(|| product / square)
}

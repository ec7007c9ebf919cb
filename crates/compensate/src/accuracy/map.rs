//! Accuracy over the workspace, before and after compensation.
//!
//! ```text
//! before   |f_real(q_nominal) − x|, and r_95 of it     the robot commanded by its nominal description
//! after    r_95 at the compensated command
//! ```
//!
//! On a grid of positions q_nominal is the nominal inverse kinematics; on a grid of joints x is where the nominal
//! robot is, and the band is taken there.

use super::prediction_interval::{correction_helps, radius_95, radius_95_about};
use crate::command::{Status, Target, Values};
use crate::{CompensateError, Compensator, CompensatorOptions};
use nalgebra::{DMatrix, Matrix3, Vector3};
use truepose_errormodel::{Beyond, Coverage, ErrorModel, FittedModel, Schema};
use truepose_kinematics::{Conditions, TargetId};

/// Where the map has its nodes.
#[derive(Debug, Clone, PartialEq)]
pub enum MapGrid {
    /// So many values of every joint over its limits (a turn and a metre either way where it has none).
    Joints {
        /// Values of each joint.
        points: usize,
    },
    /// Positions in a box of the measurement frame.
    Positions {
        /// Lower corner, m.
        lower: Vector3<f64>,
        /// Upper corner, m.
        upper: Vector3<f64>,
        /// Values of x, y and z.
        points: [usize; 3],
        /// Orientation of the tool; none leaves it to the search.
        orientation: Option<Matrix3<f64>>,
    },
}

/// What is mapped.
#[derive(Debug, Clone, PartialEq)]
pub struct MapOptions {
    /// The nodes.
    pub grid: MapGrid,
    /// Load, time, approach and channels (in the order of the fit's); joints are not read.
    pub conditions: Conditions,
    /// Which point; none is the tool's origin.
    pub target: Option<TargetId>,
}

impl Default for MapOptions {
    fn default() -> Self {
        MapOptions { grid: MapGrid::Joints { points: 5 }, conditions: Conditions::default(), target: None }
    }
}

/// Most nodes of a map.
const MOST_NODES: usize = 2_000_000;

impl MapOptions {
    /// Checks that the grid makes sense for a robot of so many joints.
    ///
    /// # Errors
    /// [`CompensateError::Option`] for a grid without nodes, or with too many.
    pub fn validate(&self, joints: usize) -> Result<(), CompensateError> {
        let nodes = match &self.grid {
            MapGrid::Joints { points } => (*points as f64).powi(joints as i32),
            MapGrid::Positions { points, lower, upper, .. } => {
                if !lower.iter().chain(upper).all(|v| v.is_finite()) {
                    let need = "a box of finite numbers";
                    return Err(CompensateError::Option { option: "grid", value: f64::NAN, need });
                }
                points.iter().map(|&p| p as f64).product()
            }
        };
        if nodes < 1.0 || nodes > MOST_NODES as f64 {
            return Err(CompensateError::Option {
                option: "grid",
                value: nodes,
                need: "1 to 2 000 000 nodes: take fewer points a joint, or a box",
            });
        }
        Ok(())
    }
}

/// One node.
#[derive(Debug, Clone, PartialEq)]
pub struct MapNode {
    /// Where the point is to be, m, measurement frame.
    pub position: Vector3<f64>,
    /// The command there; for a grid of joints the nominal one.
    pub joints: Values,
    /// Whether it can be reached; nodes that are not `ok` have no figures (NaN).
    pub status: Status,
    /// Distance by which the uncompensated robot misses, m.
    pub before: f64,
    /// With 95 % the uncompensated robot misses by no more, m.
    pub before_95: f64,
    /// With 95 % the compensated robot misses by no more, m.
    pub after_95: f64,
    /// What of the place lies beyond the data of the fit, and by how much.
    pub beyond: Vec<(Beyond, f64)>,
    /// Whether the correction is expected to bring the robot nearer than the nominal command ([`correction_helps`]).
    pub helps: bool,
}

impl MapNode {
    /// Whether the node is outside of the range of the data of the fit.
    pub fn extrapolates(&self) -> bool {
        !self.beyond.is_empty()
    }
}

/// The map.
#[derive(Debug, Clone, PartialEq)]
pub struct AccuracyMap {
    /// In the order of the grid, the last coordinate fastest.
    pub nodes: Vec<MapNode>,
}

impl AccuracyMap {
    /// Root of the mean square of the error before, m.
    pub fn before_rms(&self) -> f64 {
        let (sum, count) = self.reached().fold((0.0, 0.0), |(s, n), node| (s + node.before.powi(2), n + 1.0));
        (sum / f64::max(count, 1.0)).sqrt()
    }

    /// Largest error before, m.
    pub fn before_max(&self) -> f64 {
        self.reached().map(|node| node.before).fold(0.0, f64::max)
    }

    /// Root of the mean square of the band before, m.
    pub fn before_95_rms(&self) -> f64 {
        let (sum, count) =
            self.reached().fold((0.0, 0.0), |(s, n), node| (s + node.before_95.powi(2), n + 1.0));
        (sum / f64::max(count, 1.0)).sqrt()
    }

    /// Largest band before, m.
    pub fn before_95_max(&self) -> f64 {
        self.reached().map(|node| node.before_95).fold(0.0, f64::max)
    }

    /// Root of the mean square of the band after, m.
    pub fn after_95_rms(&self) -> f64 {
        let (sum, count) =
            self.reached().fold((0.0, 0.0), |(s, n), node| (s + node.after_95.powi(2), n + 1.0));
        (sum / f64::max(count, 1.0)).sqrt()
    }

    /// Largest band after, m.
    pub fn after_95_max(&self) -> f64 {
        self.reached().map(|node| node.after_95).fold(0.0, f64::max)
    }

    /// Fraction of the nodes that can be reached.
    pub fn reachable(&self) -> f64 {
        self.reached().count() as f64 / f64::max(self.nodes.len() as f64, 1.0)
    }

    /// The places that can be reached and lie within the data of the fit.
    pub fn within(&self) -> AccuracyMap {
        AccuracyMap { nodes: self.reached().filter(|node| !node.extrapolates()).cloned().collect() }
    }

    fn reached(&self) -> impl Iterator<Item = &MapNode> {
        self.nodes.iter().filter(|node| node.status == Status::Ok)
    }
}

/// Maps a fitted model's accuracy.
///
/// # Errors
/// When the options make no sense, or the conditions do not fit the model.
pub fn accuracy_map(fitted: &FittedModel, options: &MapOptions) -> Result<AccuracyMap, CompensateError> {
    let chain = fitted.chain();
    let n = chain.movable().len();
    options.validate(n)?;
    if options.target.is_some_and(|t| t.0 >= chain.targets().len()) {
        let what = "target";
        return Err(CompensateError::Conditions { what, have: chain.targets().len(), need: 1 });
    }
    let (schema, mut conditions) = everything(fitted, &options.conditions)?;
    let mut coverage = Coverage::new(fitted, &schema)?;
    let noise = Matrix3::identity() * fitted.noise.position_sd.powi(2);
    let mut nodes = Vec::new();
    match &options.grid {
        MapGrid::Joints { points } => {
            let ranges: Vec<(f64, f64)> = chain
                .movable()
                .iter()
                .map(|&joint| {
                    let widest = if chain.joint(joint).unit() == "m" { 1.0 } else { std::f64::consts::PI };
                    let (lower, upper) = chain.joint(joint).limits.unwrap_or((-widest, widest));
                    (lower.max(-1e3), upper.min(1e3))
                })
                .collect();
            for index in 0..points.pow(n as u32) {
                let mut rest = index;
                for (k, &(lower, upper)) in ranges.iter().enumerate().rev() {
                    conditions.joints[k] = lower + (upper - lower) * share(rest % points, *points);
                    rest /= points;
                }
                let found = coverage.judge(&conditions, options.target);
                let nominal = coverage.nominal(&conditions, options.target).translation;
                let displacement = found.pose.translation - nominal;
                nodes.push(MapNode {
                    position: nominal,
                    joints: Values::of(&conditions.joints),
                    status: Status::Ok,
                    before: displacement.norm(),
                    before_95: radius_95_about(&displacement, &(found.covariance + noise)),
                    after_95: radius_95(&(found.covariance + noise)),
                    beyond: found.beyond,
                    helps: correction_helps(&displacement, &found.covariance),
                });
            }
        }
        MapGrid::Positions { lower, upper, points, orientation } => {
            let ideal_model = ErrorModel::new(chain.clone(), Vec::new())?;
            let ideal = FittedModel::new(ideal_model, Vec::new(), DMatrix::zeros(0, 0))?;
            let search = CompensatorOptions { position_tolerance: 1e-8, ..CompensatorOptions::default() };
            let mut nominal = Compensator::bind(&ideal, &schema, search.clone())?;
            let mut exact = Compensator::bind(fitted, &schema, search)?;
            let mut seed: Option<Values> = None;
            for index in 0..points.iter().product() {
                let [_, ny, nz] = *points;
                let at = [index / (ny * nz), index / nz % ny, index % nz];
                let position =
                    Vector3::from_fn(|k, _| lower[k] + (upper[k] - lower[k]) * share(at[k], points[k]));
                let wanted = Target { position, orientation: *orientation, target: options.target };
                let first = nominal.command(&wanted, &conditions, seed.as_deref());
                let command = exact.command(&wanted, &conditions, Some(&first.joints));
                let mut node = MapNode {
                    position,
                    joints: command.joints,
                    status: command.status,
                    before: f64::NAN,
                    before_95: f64::NAN,
                    after_95: f64::NAN,
                    beyond: Vec::new(),
                    helps: true,
                };
                if command.status == Status::Ok {
                    conditions.joints.copy_from_slice(&first.joints);
                    let uncorrected = coverage.judge(&conditions, options.target);
                    let missed = uncorrected.pose.translation - position;
                    conditions.joints.copy_from_slice(&command.joints);
                    let found = coverage.judge(&conditions, options.target);
                    let nominal = coverage.nominal(&conditions, options.target).translation;
                    node.before = missed.norm();
                    node.before_95 = radius_95_about(&missed, &(uncorrected.covariance + noise));
                    node.after_95 = radius_95(&(found.covariance + noise));
                    node.helps = correction_helps(&(found.pose.translation - nominal), &found.covariance);
                    node.beyond = found.beyond;
                    seed = Some(command.joints);
                }
                nodes.push(node);
            }
        }
    }
    Ok(AccuracyMap { nodes })
}

/// A schema with every signal, and conditions that fit it and the robot.
pub(crate) fn everything(
    fitted: &FittedModel,
    given: &Conditions,
) -> Result<(Schema, Conditions), CompensateError> {
    let n = fitted.chain().movable().len();
    let schema = Schema { channels: fitted.channels.clone(), time: true, load: true, approach: true };
    let mut conditions = given.clone();
    conditions.joints.clear();
    conditions.joints.resize(n, 0.0);
    if conditions.approach.is_empty() {
        conditions.approach = vec![0.0; n];
    }
    let lists = [
        ("directions of approach", conditions.approach.len(), n),
        ("channels", conditions.channels.len(), schema.channels.len()),
    ];
    for (what, have, need) in lists {
        if have != need {
            return Err(CompensateError::Conditions { what, have, need });
        }
    }
    Ok((schema, conditions))
}

/// The k-th of so many places from 0 to 1; the middle when there is one.
fn share(k: usize, of: usize) -> f64 {
    if of < 2 { 0.5 } else { k as f64 / (of - 1) as f64 }
}

//! What is expected of a command.

use rayon::prelude::*;
use truepose_compensate::{
    Command, CommandRequest, CompensateError, Compensator, CompensatorOptions, Status, Target,
    correction_helps, radius_95,
};
use truepose_errormodel::{Beyond, Coverage, ErrorModel, FittedModel, Schema};
use truepose_io::Poses;
use truepose_kinematics::nalgebra::{DMatrix, Matrix3, Vector3};
use truepose_kinematics::{Conditions, ToolId};

/// Poses that one thread takes at a time.
pub const CHUNK: usize = 2048;
/// A tool centre point nearer than this to the origin of the tool is the same point, m.
const SAME_POINT: f64 = 1e-9;

/// How commands are sought.
#[derive(Debug, Clone, Default)]
pub struct CommandOptions {
    /// Poses are in the axes of this other tool ([`relative_to`](super::relative_to)).
    pub relative_to: Option<ToolId>,
    /// The point whose accuracy is expected is at this place from the tool's origin, m, in its axes.
    pub lever: Option<Vector3<f64>>,
    /// Joints that stay where the poses have them, by their places among the moving joints.
    pub hold: Vec<usize>,
}

/// The expected accuracy of a command.
#[derive(Debug, Clone)]
pub struct Expected {
    /// Distance from the desired position within which the requested point lies with 95 % probability, m; infinite where the data of the
    /// fit does not determine where that point is.
    pub within_95: f64,
    /// Distance of the nominal robot from there under this command, m.
    pub correction: f64,
    /// Whether the command is the model's; else it is the nominal robot's.
    pub corrected: bool,
    /// Inputs beyond the data of the fit, and by how much.
    pub beyond: Vec<(Beyond, f64)>,
}

/// Compares every command with the data of the fit and with the nominal command, which replaces it where it is expected to be
/// more accurate.
pub(super) fn expected(
    fitted: &FittedModel,
    poses: &Poses,
    commands: &mut [Command],
    options: &CommandOptions,
) -> Result<Vec<Expected>, CompensateError> {
    let lever = options.lever.filter(|lever| lever.norm() > SAME_POINT);
    let inputs = poses.rows.derived_for(fitted.model())?;
    let coverage = Coverage::new(fitted, &inputs.schema)?;
    let nothing = ErrorModel::new(fitted.chain().clone(), Vec::new())?;
    let ideal = FittedModel::new(nothing, Vec::new(), DMatrix::zeros(0, 0))?;
    let nominals =
        for_tools(&ideal, &inputs.schema, &CommandOptions { relative_to: None, ..options.clone() })?;
    let noise = Matrix3::identity() * fitted.noise.position_sd.powi(2);
    let parts: Vec<Vec<Expected>> = commands
        .par_chunks_mut(CHUNK)
        .enumerate()
        .map(|(part, commands)| {
            let (mut coverage, mut nominals) = (coverage.clone(), nominals.clone());
            let mut conditions = Conditions::default();
            let one = |(k, command): (usize, &mut Command)| {
                let row = part * CHUNK + k;
                inputs.conditions_into(row, &mut conditions);
                conditions.joints.clear();
                conditions.joints.extend_from_slice(&command.joints);
                let target = poses.rows.target[row];
                let at = coverage.judge(&conditions, target);
                let meant = coverage.nominal(&conditions, target).translation;
                let displacement = at.pose.translation - meant;
                let known = match lever {
                    None => fitted.determines(target),
                    Some(_) => fitted.determines_orientation(),
                };
                let within_95 = match lever {
                    _ if !known => f64::INFINITY,
                    None => radius_95(&(at.covariance + noise)),
                    Some(lever) => {
                        let around = turned(&(at.pose.rotation * lever), fitted.noise.orientation_sd);
                        radius_95(&(coverage.covariance_at(&conditions, &lever) + noise + around))
                    }
                };
                let mut expected = Expected {
                    within_95,
                    correction: (meant - poses.rows.measured_position(row)).norm(),
                    corrected: true,
                    beyond: at.beyond,
                };
                if command.status == Status::Ok && !correction_helps(&displacement, &at.covariance) {
                    let requested = wanted(poses, &conditions, row).target;
                    let nominal = &mut nominals[inputs.tool(row).0];
                    let other = nominal.command(&requested, &conditions, Some(&command.joints));
                    if other.status == Status::Ok {
                        command.joints = other.joints;
                        // At most the displacement that is not corrected is added.
                        expected.within_95 += displacement.norm();
                        expected.corrected = false;
                        conditions.joints.clear();
                        conditions.joints.extend_from_slice(&other.joints);
                        expected.beyond = coverage.judge(&conditions, target).beyond;
                        let there = coverage.judge(&conditions, target).pose.translation;
                        command.position_error = (there - requested.position).norm();
                    }
                }
                expected
            };
            commands.iter_mut().enumerate().map(one).collect()
        })
        .collect();
    Ok(parts.into_iter().flatten().collect())
}

/// Covariance, m², of a point at this lever, m, whose orientation scatters by so much about each axis, rad.
fn turned(lever: &Vector3<f64>, sd: f64) -> Matrix3<f64> {
    let cross = lever.cross_matrix();
    cross * cross.transpose() * sd.powi(2)
}

/// The request of one row.
pub(super) fn wanted<'a>(poses: &Poses, conditions: &'a Conditions, row: usize) -> CommandRequest<'a> {
    let mut target = Target::at(poses.rows.measured_position(row)).of(poses.rows.target[row]);
    target.orientation = poses.rows.measured_rotation(row);
    CommandRequest { target, conditions, seed: poses.seeded.then_some(conditions.joints.as_slice()) }
}

/// A compensator for each tool of the robot.
pub(super) fn for_tools<'m>(
    fitted: &'m FittedModel,
    schema: &Schema,
    options: &CommandOptions,
) -> Result<Vec<Compensator<'m>>, CompensateError> {
    let tool = |k| CompensatorOptions {
        tool: ToolId(k),
        // None of its own poses is in its own axes.
        relative_to: options.relative_to.filter(|other| other.0 != k),
        hold: options.hold.clone(),
        ..CompensatorOptions::default()
    };
    (0..fitted.chain().tools().len()).map(|k| Compensator::bind(fitted, schema, tool(k))).collect()
}

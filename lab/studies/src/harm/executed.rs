//! Closed-loop verification: the plant executes the commands of `compensate`; its distance from the desired positions.
//!
//! A desired pose is where the nominal robot, base, tool and targets fitted, is at a fresh configuration: nominal inverse
//! kinematics commands that configuration. Judged are poses that every model has a command for.

use super::record::{Figure, Record};
use super::robots::Robot;
use crate::prelude::*;

/// Fits of one robot, as far as there are any.
#[derive(Default)]
pub struct Fits {
    pub nominal: Option<FittedModel>,
    pub constants: Option<FittedModel>,
    pub discover: Option<FittedModel>,
}

/// Drives the plant with each fit's commands.
pub fn execute(robot: &Robot, fits: &Fits, record: &mut Record) {
    let Some(nominal) = &fits.nominal else { return };
    let Some(wanted) = record.attempt("compensate", || wanted(robot, nominal)) else { return };
    let mut reached = vec![true; wanted.len()];
    let mut ends: Vec<(Figure, Vec<Vector3<f64>>)> = Vec::new();
    let as_requested =
        (0..wanted.len()).map(|k| Some(robot.truth.conditions(robot.requested()[k]).joints)).collect();
    let mut all: Vec<(Figure, Commands)> = vec![(Figure::DriveNominal, as_requested)];
    for (figure, fitted) in
        [(Figure::DriveConstants, &fits.constants), (Figure::DriveDiscover, &fits.discover)]
    {
        let Some(fitted) = fitted else { continue };
        if let Some(found) = record.attempt("compensate", || commands(robot, fitted, &wanted)) {
            all.push((figure, found));
        }
    }
    for (figure, commands) in all {
        commands.iter().zip(&mut reached).for_each(|(command, reached)| *reached &= command.is_some());
        let joints = commands.into_iter().enumerate().map(|(k, command)| {
            // A pose without a command is passed over: the robot goes where it was measured.
            command.unwrap_or_else(|| robot.truth.conditions(robot.requested()[k]).joints)
        });
        if let Some(found) = record.attempt("plant", || robot.ends(joints.collect())) {
            ends.push((figure, found));
        }
    }
    let count = reached.iter().filter(|reached| **reached).count();
    record.set(Figure::Executed, count as f64);
    for (figure, ends) in ends {
        let square = |k: usize| (ends[k] - wanted[k].position).norm_squared();
        let sum: f64 = (0..wanted.len()).filter(|&k| reached[k]).map(square).sum();
        record.set(figure, 1e3 * (sum / count as f64).sqrt());
    }
}

/// One for each desired pose; none where there is no command for it.
type Commands = Vec<Option<Vec<f64>>>;

/// Where the nominal robot is at each fresh configuration.
fn wanted(robot: &Robot, nominal: &FittedModel) -> Outcome<Vec<Goal>> {
    let inputs = robot.truth.derived_for(nominal.model())?;
    let mut predictor = nominal.bind(&inputs.schema)?;
    // With fewer joints than six not every orientation can be had.
    let turned = nominal.chain().movable().len() >= 6;
    let one = |row: usize| {
        let pose = predictor.predict(&inputs.conditions(row), robot.executed);
        let at = Goal::at(pose.translation).of(robot.executed);
        if turned { at.turned(pose.rotation) } else { at }
    };
    Ok(robot.requested().into_iter().map(one).collect())
}

/// The commands of `compensate` to these poses, searched from the nominal ones.
fn commands(robot: &Robot, fitted: &FittedModel, wanted: &[Goal]) -> Outcome<Commands> {
    let inputs = robot.truth.derived_for(fitted.model())?;
    let mut compensator = Compensator::bind(fitted, &inputs.schema, CompensatorOptions::default())?;
    let mut one = |(row, wanted): (usize, &Goal)| {
        let conditions = inputs.conditions(row);
        let command = compensator.command(wanted, &conditions, Some(&conditions.joints));
        (command.status == Status::Ok).then(|| command.joints.to_vec())
    };
    Ok(robot.requested().into_iter().zip(wanted).map(&mut one).collect())
}

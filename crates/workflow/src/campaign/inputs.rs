//! What a fit is made from, as it is read.

use super::Undeclared;
use crate::error::WorkflowError;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use truepose_errormodel::effects::Geometric;
use truepose_errormodel::{AnyEffect, Dataset, EffectRegistry, SessionRules, Surroundings};
use truepose_io::{
    CsvInfo, MeasurementsOptions, RobotDetails, RobotOptions, read_details, read_measurements, read_model,
    read_robot, robot_columns, robot_sessions, robot_surroundings,
};
use truepose_kinematics::Chain;

/// The files of a fit, and how they are read.
#[derive(Debug, Clone, Default)]
pub struct InputFiles {
    /// Description of the robot (.toml, .urdf or .yaml).
    pub robot: PathBuf,
    /// First and last link of a URDF; none: its root, its only leaf.
    pub links: RobotOptions,
    /// Whether base and tool of a URDF are those of the measurements.
    pub known: [bool; 2],
    /// Measurements (CSV; Parquet and Excel with the features of `truepose-io`).
    pub data: PathBuf,
    /// Declared model; none: constant errors of every frame and target.
    pub model: Option<PathBuf>,
    /// How the measurements are read, beside what the description of the robot states of its columns.
    pub reading: MeasurementsOptions,
    /// Whether measured orientations are not used.
    pub positions_only: bool,
}

/// What a fit is made from.
#[derive(Debug, Clone)]
pub struct Inputs {
    /// The robot.
    pub chain: Chain,
    /// Units, frames and the head of certificates of its description, and whether it states gravity.
    pub details: RobotDetails,
    /// What sessions share, and landmarks.
    pub beside: (SessionRules, Surroundings),
    /// What its description leaves open.
    pub undeclared: Undeclared,
    /// The declared effects.
    pub effects: Vec<Box<dyn AnyEffect>>,
    /// The rows.
    pub data: Arc<Dataset>,
    /// What the table has besides.
    pub info: Arc<CsvInfo>,
}

impl InputFiles {
    /// The robot, and warnings about its description.
    ///
    /// # Errors
    /// When the file cannot be read, or is wrong.
    pub fn chain(&self) -> Result<(Chain, Vec<String>), WorkflowError> {
        let (chain, warnings) = read_robot(&self.robot, &self.links)?;
        Ok((chain, warnings.iter().map(ToString::to_string).collect()))
    }

    /// The declared effects, of this robot.
    ///
    /// # Errors
    /// When the file cannot be read, or is wrong.
    pub fn effects(
        &self,
        chain: &Chain,
        registry: &EffectRegistry,
    ) -> Result<Vec<Box<dyn AnyEffect>>, WorkflowError> {
        Ok(match &self.model {
            Some(model) => read_model(model, chain, registry)?,
            None => vec![Box::new(Geometric::default())],
        })
    }

    /// How the measurements are read, with what the description of the robot states of its columns.
    ///
    /// # Errors
    /// When the description cannot be read.
    pub fn reading(&self) -> Result<MeasurementsOptions, WorkflowError> {
        let columns = robot_columns(&self.robot)?.with(&self.reading.columns);
        Ok(MeasurementsOptions { columns, ..self.reading.clone() })
    }

    /// Everything, and warnings about it; effects are those of `registry`.
    ///
    /// # Errors
    /// When a file cannot be read, or is wrong: with its name, line and column.
    pub fn read(&self, registry: &EffectRegistry) -> Result<(Inputs, Vec<String>), WorkflowError> {
        let robot: &Path = &self.robot;
        let (chain, mut warnings) = self.chain()?;
        let effects = self.effects(&chain, registry)?;
        let (mut data, info, found) = read_measurements(&self.data, &chain, &self.reading()?)?;
        warnings.extend(found.iter().map(ToString::to_string));
        if self.positions_only {
            data.orientation.fill(None);
        }
        let undeclared = Undeclared::of(robot, self.known)?;
        // Tables of a description that nothing of the data needs are not read.
        let rules = if info.sessions.len() < 2 { SessionRules::default() } else { robot_sessions(robot)? };
        let surroundings = match info.landmarks.is_empty() {
            true => Surroundings::default(),
            false => robot_surroundings(robot)?,
        };
        let (details, beside) = (read_details(robot)?, (rules, surroundings));
        let (data, info) = (Arc::new(data), Arc::new(info));
        Ok((Inputs { chain, details, beside, undeclared, effects, data, info }, warnings))
    }
}

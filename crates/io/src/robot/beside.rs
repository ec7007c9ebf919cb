//! What a robot file says beside the robot, for who reads tables: names of columns, sessions, landmarks.

use super::toml_form::units_of;
use super::{RobotDetails, columns, details, sessions, surroundings};
use crate::text::Text;
use crate::toml_tree::Document;
use crate::{ColumnMap, IoError};
use std::path::Path;
use truepose_errormodel::{SessionRules, Surroundings};

/// What `[columns]` of a description says about tables of measurements.
pub(super) fn column_map(path: &Path) -> Result<ColumnMap, IoError> {
    let text = Text::read(path)?;
    let document = Document::parse(&text)?;
    columns::read(&document.root("the robot"))
}

/// What `[sessions]` of a description says about several installations.
pub(super) fn session_rules(path: &Path) -> Result<SessionRules, IoError> {
    let text = Text::read(path)?;
    let document = Document::parse(&text)?;
    sessions::read(&document.root("the robot"))
}

/// What a description says about the surroundings.
pub(super) fn surroundings_of(path: &Path) -> Result<Surroundings, IoError> {
    let text = Text::read(path)?;
    let document = Document::parse(&text)?;
    let root = document.root("the robot");
    let (length, angle) = units_of(&root)?;
    surroundings::read(&root, length, angle)
}

/// What a description says beside the robot.
#[derive(Debug, Clone)]
pub struct RobotBeside {
    /// Which columns of tables of measurements are which.
    pub columns: ColumnMap,
    /// Units, frames and the head of certificates.
    pub details: RobotDetails,
    /// What each session of a campaign has of its own.
    pub sessions: SessionRules,
    /// Landmarks and distances between them.
    pub surroundings: Surroundings,
}

/// All of it of the text of a description, whose file stands in messages.
pub(super) fn of_text(text: &Text) -> Result<RobotBeside, IoError> {
    let document = Document::parse(text)?;
    let root = document.root("the robot");
    let (length, angle) = units_of(&root)?;
    Ok(RobotBeside {
        columns: columns::read(&root)?,
        details: details::of(&root)?,
        sessions: sessions::read(&root)?,
        surroundings: surroundings::read(&root, length, angle)?,
    })
}

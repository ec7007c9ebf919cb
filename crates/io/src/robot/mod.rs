//! Robot descriptions: TOML and URDF in, TOML out.

mod beside;
mod cameras;
mod columns;
mod couplings;
mod details;
mod kinematics_yaml;
mod mimics;
pub(crate) mod names;
mod sessions;
mod surroundings;
mod targets;
mod toml_form;
mod tree;
mod turns;
mod urdf;
mod urdf_corrected;
mod urdf_form;
mod urdf_mimics;
mod urdf_path;
mod urdf_text;
mod write;
mod yaml_tree;

pub use beside::RobotBeside;
pub use details::{Certificate, FrameParent, NamedFrame, RobotDetails, read_details};
pub use kinematics_yaml::read_kinematics;
pub use urdf_corrected::{UrdfCorrection, corrected_urdf};
pub use urdf_form::robot_urdf;
pub use write::robot_toml;

use crate::text::Text;
use crate::{ColumnMap, IoError, Warning};
use std::path::{Path, PathBuf};
use truepose_errormodel::{SessionRules, Surroundings};
use truepose_kinematics::Chain;

/// No robot has more joints, fixed ones included.
const MOST_JOINTS: usize = 256;

/// No tool carries more targets.
const MOST_TARGETS: usize = 4096;

/// Which part of a URDF is the robot.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RobotOptions {
    /// The link at the robot's base; none: the root of the URDF.
    pub base: Option<String>,
    /// The link at the robot's tip; none: the only leaf.
    pub tip: Option<String>,
}

/// Files that reading this description opens: itself, and the URDF or kinematics file that a TOML names. What cannot be read is left to [`read_robot`],
/// and what is no regular file is not opened: it can be read once.
pub fn robot_files(path: impl AsRef<Path>) -> Vec<PathBuf> {
    let path = path.as_ref();
    let toml = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) && path.is_file();
    let beside = if toml { toml_form::urdf_file(path) } else { None };
    std::iter::once(path.to_path_buf()).chain(beside).collect()
}

/// Reads a robot description, `.toml`, `.urdf`, or a kinematics file of a ROS description, `.yaml`.
///
/// # Errors
/// When the file cannot be read, is not of its kind, or does not describe a serial robot.
pub fn read_robot(path: impl AsRef<Path>, options: &RobotOptions) -> Result<(Chain, Vec<Warning>), IoError> {
    let path = path.as_ref();
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    let mut warnings = Vec::new();
    let chain = match ending.as_deref() {
        Some("toml") => toml_form::read(path, options, &mut warnings)?,
        Some("urdf") => {
            let arm = urdf::read(path, options, &mut warnings)?;
            let whole = Chain::new(arm.name, arm.joints).and_then(|chain| chain.with_mimics(arm.mimics));
            whole.map_err(|error| IoError::file(path, error.to_string()))?
        }
        Some("yaml" | "yml") => kinematics_yaml::read_chain(path)?,
        Some("xacro") => {
            return Err(IoError::file(
                path,
                "is a xacro; expand it to a .urdf first (`xacro in.xacro > out.urdf`)",
            ));
        }
        _ => return Err(IoError::file(path, "a robot description ends in .toml, .urdf or .yaml")),
    };
    Ok((chain, warnings))
}

/// Reads the text of a TOML description. `name` stands in messages where the name of a file would; a `urdf` is looked for in its folder.
///
/// # Errors
/// As [`read_robot`].
pub fn robot_from_text(
    name: impl Into<PathBuf>,
    text: impl Into<String>,
    options: &RobotOptions,
) -> Result<(Chain, Vec<Warning>), IoError> {
    let mut warnings = Vec::new();
    let text = Text { file: name.into(), text: text.into() };
    Ok((toml_form::of(&text, options, &mut warnings)?, warnings))
}

/// Which columns of tables of measurements are which, as `[columns]` of a robot description says; nothing where it says nothing.
///
/// # Errors
/// When the description cannot be read, or its `[columns]` does not make sense.
pub fn robot_columns(path: impl AsRef<Path>) -> Result<ColumnMap, IoError> {
    let path = path.as_ref();
    let toml = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) && path.is_file();
    if toml { beside::column_map(path) } else { Ok(ColumnMap::default()) }
}

/// What the text of a TOML description says beside the robot. `name` stands in messages where the name of a file would.
///
/// # Errors
/// When the text is no TOML, or one of these does not make sense.
pub fn robot_beside(name: impl Into<PathBuf>, text: impl Into<String>) -> Result<RobotBeside, IoError> {
    beside::of_text(&Text { file: name.into(), text: text.into() })
}

/// What each session of a campaign has of its own, as `[sessions]` of a robot description says; the base where it says nothing.
///
/// # Errors
/// When the description cannot be read, or its `[sessions]` does not make sense.
pub fn robot_sessions(path: impl AsRef<Path>) -> Result<SessionRules, IoError> {
    let path = path.as_ref();
    let toml = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) && path.is_file();
    if toml { beside::session_rules(path) } else { Ok(SessionRules::default()) }
}

/// Landmarks and distances between them, as `[[landmarks]]` and `[[distances]]` of a robot description say; none where it says nothing.
///
/// # Errors
/// When the description cannot be read, or one of these does not make sense.
pub fn robot_surroundings(path: impl AsRef<Path>) -> Result<Surroundings, IoError> {
    let path = path.as_ref();
    let toml = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) && path.is_file();
    if toml { beside::surroundings_of(path) } else { Ok(Surroundings::default()) }
}

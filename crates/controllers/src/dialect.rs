//! The languages that are read.

use crate::{ControllerError, Orientation};
use std::path::Path;
use truepose_kinematics::Pose;
use truepose_kinematics::nalgebra::Vector3;

/// A robot language.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dialect {
    /// KUKA Robot Language, `.src` and `.dat`.
    Krl,
    /// ABB RAPID, `.mod`.
    Rapid,
    /// FANUC TP as text, `.ls`.
    Fanuc,
    /// Universal Robots' script, `.script`.
    UrScript,
    /// Yaskawa INFORM, `.jbi`.
    Inform,
    /// Stäubli VAL3 data, `.dtx`.
    Val3,
}

impl Dialect {
    /// All of them.
    pub const ALL: [Dialect; 6] =
        [Dialect::Krl, Dialect::Rapid, Dialect::Fanuc, Dialect::UrScript, Dialect::Inform, Dialect::Val3];

    /// The word of an option.
    pub fn word(self) -> &'static str {
        match self {
            Dialect::Krl => "krl",
            Dialect::Rapid => "rapid",
            Dialect::Fanuc => "fanuc",
            Dialect::UrScript => "urscript",
            Dialect::Inform => "inform",
            Dialect::Val3 => "val3",
        }
    }

    /// The language of a file by the ending of its name.
    ///
    /// # Errors
    /// When no ending is known, or is that of a file that is not read.
    pub fn of_file(path: &Path) -> Result<Dialect, ControllerError> {
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        Ok(match ending.as_str() {
            "src" | "dat" | "sub" => Dialect::Krl,
            "mod" | "modx" | "prg" | "sys" | "sysx" => Dialect::Rapid,
            "ls" => Dialect::Fanuc,
            "script" | "urscript" => Dialect::UrScript,
            "jbi" => Dialect::Inform,
            "dtx" => Dialect::Val3,
            "urp" => return Err(ControllerError::NotAProgram(URP.into())),
            "tp" => {
                return Err(ControllerError::NotAProgram(
                    "a .tp is binary; save the program as text (.ls) and name that".into(),
                ));
            }
            _ => {
                let words: Vec<&str> = Dialect::ALL.iter().map(|dialect| dialect.word()).collect();
                return Err(ControllerError::NotAProgram(format!(
                    "the ending of its name (`{ending}`) is that of no robot language that is read (.src .dat .mod .ls .script .jbi \
                     .dtx); name it with --language {}",
                    words.join("|")
                )));
            }
        })
    }

    /// How it writes an orientation.
    pub fn orientation(self) -> Orientation {
        match self {
            Dialect::Krl => Orientation::Abc,
            Dialect::Rapid => Orientation::Quaternion,
            Dialect::Fanuc | Dialect::Inform => Orientation::Wpr,
            Dialect::UrScript => Orientation::RotationVector,
            Dialect::Val3 => Orientation::MovingXyz,
        }
    }

    /// Its unit of length, m.
    pub fn length(self) -> f64 {
        if self == Dialect::UrScript { 1.0 } else { 1e-3 }
    }

    /// Its unit of angle of a joint, rad; INFORM's pulses have none.
    pub fn angle(self) -> f64 {
        if self == Dialect::UrScript { 1.0 } else { 1f64.to_radians() }
    }

    /// The pose of numbers in its form; none where they are no orientation.
    pub(crate) fn pose(self, numbers: &[f64]) -> Option<Pose> {
        let (place, turn) = numbers.split_at_checked(3)?;
        if numbers.iter().any(|value| value.abs() > MOST) {
            return None;
        }
        let rotation = self.orientation().read(turn)?;
        Some(Pose::new(rotation, Vector3::new(place[0], place[1], place[2]) * self.length()))
    }
}

/// Numbers above this are none of a robot: a thousand kilometres in mm, or degrees that no longer tell where they point.
const MOST: f64 = 1e9;

/// Why a file of PolyScope is not read.
pub(crate) const URP: &str = "a .urp is compressed XML with waypoints, variables and program tree in a form of PolyScope's own, and is not read; \
                   read is the script that PolyScope writes beside it (.script): name that, or move the waypoints to one";

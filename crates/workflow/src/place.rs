//! Frames and tools as people write them.

use crate::text::{position, three};
use truepose_kinematics::Pose;

/// A frame: a name, or a pose.
#[derive(Debug, Clone, PartialEq)]
pub enum Place {
    /// By its name.
    Named(String),
    /// In another frame, m.
    At(Pose),
}

impl Place {
    /// `base`, `fixture`, `900mm,0mm,50mm,0,0,90` (roll, pitch, yaw in degrees).
    ///
    /// # Errors
    /// When there are commas, and not six values.
    pub fn parse(text: &str) -> Result<Place, String> {
        if !text.contains(',') {
            return match text.trim() {
                "" => Err("a frame needs a name".into()),
                name => Ok(Place::Named(name.into())),
            };
        }
        let parts: Vec<&str> = text.split(',').collect();
        let [_, _, _, _, _, _] = parts[..] else {
            return Err(format!("six values are needed, x,y,z,roll,pitch,yaw, not {}", parts.len()));
        };
        let (xyz, rpy) = (parts[..3].join(","), parts[3..].join(","));
        let rpy = three(&rpy)?.map(f64::to_radians);
        Ok(Place::At(Pose::from_xyz_rpy(position(&xyz)?, rpy)))
    }
}

/// A frame or tool: its place, and the name in a program that it is the value of.
#[derive(Debug, Clone, PartialEq)]
pub struct GivenPlace {
    /// `UF1` of `UF1=…`.
    pub name: Option<String>,
    /// Where it is.
    pub place: Place,
}

impl GivenPlace {
    /// `base`, `900mm,0mm,50mm,0,0,90`, `UF1=900mm,0mm,50mm,0,0,90`.
    ///
    /// # Errors
    /// As [`Place::parse`].
    pub fn parse(text: &str) -> Result<GivenPlace, String> {
        match text.split_once('=') {
            Some((name, place)) if !name.trim().is_empty() => {
                Ok(GivenPlace { name: Some(name.trim().into()), place: Place::parse(place)? })
            }
            _ => Ok(GivenPlace { name: None, place: Place::parse(text)? }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_names_or_poses() {
        assert_eq!(Place::parse("fixture"), Ok(Place::Named("fixture".into())));
        let Ok(Place::At(pose)) =
            Place::parse("900mm, 0mm,5cm,0,0,90").or_else(|_| Place::parse("900mm,0mm,0.05m,0,0,90"))
        else {
            panic!("a pose")
        };
        assert!((pose.translation.x - 0.9).abs() < 1e-15 && (pose.rotation[(1, 0)] - 1.0).abs() < 1e-15);
        for bad in ["", "1,2,3", "1mm,2mm,3mm,0,0", "1,2,3,4,5,6", "1mm,2mm,3mm,0,0,x"] {
            assert!(Place::parse(bad).is_err(), "{bad}");
        }
    }
}

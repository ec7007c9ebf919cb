//! One installation of several.

use truepose_kinematics::Pose;

/// One installation of several that a fit knows.
#[derive(Debug, Clone, PartialEq)]
pub struct Installed {
    /// Its name in the data.
    pub name: String,
    /// X_k: measurement frame of the first session ← that of this one, as it was placed; what is left of it are coefficients.
    pub frame: Pose,
}

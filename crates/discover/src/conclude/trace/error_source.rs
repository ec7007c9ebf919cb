//! Whose error an effect is.

use crate::error::DiscoverError;
use nalgebra::{DVector, Vector3};
use truepose_errormodel::{Dataset, Emission, Equilibrium, ErrorJacobian, ErrorModel};
use truepose_identify::Fit;
use truepose_kinematics::{Axis, Chain, JointKind, JointMotion, Site};

/// Whose error it is.
pub(super) enum ErrorSource {
    Motion(JointMotion),
    Site(Site),
}

impl ErrorSource {
    /// How the position moves with a unit of the error, and the error per unit of each coefficient.
    pub fn read(
        &self,
        jacobian: &ErrorJacobian<'_>,
        emission: &Emission,
        columns: &std::ops::Range<usize>,
    ) -> (Vector3<f64>, DVector<f64>) {
        let mut shape = DVector::zeros(columns.len());
        let mut moved = Vector3::zeros();
        match self {
            ErrorSource::Site(site) => {
                moved = jacobian.position(*site);
                for entry in emission.entries() {
                    if columns.contains(&entry.column) && entry.site == *site {
                        shape[entry.column - columns.start] += entry.value;
                    }
                }
            }
            ErrorSource::Motion(motion) => {
                let first = first_axis(motion);
                for k in 0..3 {
                    moved +=
                        motion.axis[k] * jacobian.position(Site::Frame(motion.frame, Axis::ALL[first + k]));
                }
                for entry in emission.entries().iter().filter(|e| columns.contains(&e.column)) {
                    if let Site::Frame(frame, axis) = entry.site
                        && frame == motion.frame
                        && axis.index() >= first
                        && axis.index() < first + 3
                    {
                        shape[entry.column - columns.start] +=
                            entry.value * motion.axis[axis.index() - first];
                    }
                }
            }
        }
        (moved, shape)
    }

    pub fn words(&self, chain: &Chain) -> String {
        match self {
            ErrorSource::Site(site) => chain.site_word(*site),
            ErrorSource::Motion(motion) => {
                let how = if motion.kind == JointKind::Prismatic { "along" } else { "about" };
                format!("{} {how} its axis", chain.joint(motion.joint).name)
            }
        }
    }

    pub fn unit(&self) -> &'static str {
        let turning = match self {
            ErrorSource::Motion(motion) => motion.kind != JointKind::Prismatic,
            ErrorSource::Site(Site::Frame(_, axis)) => axis.index() >= 3,
            ErrorSource::Site(Site::Target(..)) => false,
        };
        if turning { "rad" } else { "m" }
    }
}

fn first_axis(motion: &JointMotion) -> usize {
    if motion.kind == JointKind::Prismatic { 0 } else { 3 }
}

/// The own motion of the joint of that name, if there is one; else the site whose error moves the target most.
pub(super) fn error_source(
    fit: &Fit,
    data: &Dataset,
    own_motion: Option<&str>,
    columns: std::ops::Range<usize>,
) -> Result<Option<ErrorSource>, DiscoverError> {
    /// Rows that are asked.
    const ASKED: usize = 300;
    let model: &ErrorModel = fit.fitted.model();
    let chain = model.chain();
    let motion =
        own_motion.and_then(|name| chain.joint_named(name)).and_then(|joint| chain.joint_motion(joint));
    if let Some(motion) = motion {
        return Ok(Some(ErrorSource::Motion(motion)));
    }
    let data = &*data.derived_for(model)?;
    let bound = model.bind(&data.schema)?;
    let mut rest = Equilibrium::new(model);
    let mut energy = vec![0.0; chain.site_count()];
    for row in (0..data.len()).step_by(data.len().div_ceil(ASKED).max(1)) {
        rest.settle(&bound, &data.conditions(row), fit.fitted.coefficients());
        let jacobian = ErrorJacobian::new(chain, rest.real(), rest.errors(), data.aim(row));
        let mut sites = vec![0.0; chain.site_count()];
        for entry in rest.emission().entries().iter().filter(|e| columns.contains(&e.column)) {
            sites[chain.site_index(entry.site)] += entry.value * fit.fitted.coefficients()[entry.column];
        }
        for (k, error) in sites.iter().enumerate().filter(|(_, e)| e.abs() > 0.0) {
            energy[k] += error * error * jacobian.position(chain.site_at(k)).norm_squared();
        }
    }
    let best = (0..energy.len()).max_by(|&a, &b| energy[a].total_cmp(&energy[b]));
    Ok(best.filter(|&k| energy[k] > 0.0).map(|k| ErrorSource::Site(chain.site_at(k))))
}

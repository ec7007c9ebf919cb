//! What an effect is set against.

use crate::conclude::trace::error_source::ErrorSource;
use crate::conclude::trace::point::TracePoint;
use crate::hypotheses::driver::Driver;
use truepose_errormodel::Dataset;
use truepose_kinematics::{Chain, FrameId, JointId, Site};

/// A driver that the data has.
pub(super) enum Abscissa {
    /// By its coordinate.
    Joint(usize),
    JointLoad(JointId),
    /// The component of the wrench at a frame that goes with the effect.
    Wrench(FrameId),
    Channel(usize),
    Time,
    Pose,
}

/// The first of these drivers that the data has; without one the time, or else the pose measurement.
pub(super) fn abscissa(chain: &Chain, data: &Dataset, drivers: &[Driver], own: &ErrorSource) -> Abscissa {
    let when = if data.has_clock() { Abscissa::Time } else { Abscissa::Pose };
    let known = |driver: &Driver| {
        Some(match driver {
            Driver::Joint(name) => Abscissa::Joint(chain.coordinate(chain.joint_named(name)?)?),
            Driver::JointLoad(name) => Abscissa::JointLoad(chain.joint_named(name)?),
            Driver::Wrench => match own {
                ErrorSource::Site(Site::Frame(frame, _)) => Abscissa::Wrench(*frame),
                _ => return None,
            },
            Driver::Channel(name) => Abscissa::Channel(data.schema.channel(name)?),
            Driver::Time if data.has_clock() => Abscissa::Time,
            Driver::Time if data.by_order => Abscissa::Pose,
            Driver::Pose => Abscissa::Pose,
            Driver::Time | Driver::Approach(_) => return None,
        })
    };
    drivers.iter().find_map(known).unwrap_or(when)
}

/// The component of the wrench that goes most with what the model says.
pub(super) fn strongest(points: &[TracePoint], wrenches: &[[f64; 6]]) -> usize {
    let n = points.len().max(1) as f64;
    let mean = points.iter().map(|p| p.fitted).sum::<f64>() / n;
    let together = |k: usize| -> f64 {
        let middle = wrenches.iter().map(|w| w[k]).sum::<f64>() / n;
        let (mut both, mut square) = (0.0, 0.0);
        for (point, wrench) in points.iter().zip(wrenches) {
            both += (point.fitted - mean) * (wrench[k] - middle);
            square += (wrench[k] - middle).powi(2);
        }
        if square > 0.0 { both * both / square } else { 0.0 }
    };
    (0..6).max_by(|&a, &b| together(a).total_cmp(&together(b))).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_component_that_goes_with_the_effect_is_chosen() {
        let wave = |k: usize| (0.7 * k as f64).sin();
        let points: Vec<TracePoint> = (0..40)
            .map(|row| TracePoint {
                row,
                driver: 0.0,
                before: 0.0,
                after: 0.0,
                fitted: 3.0 + wave(row),
                sd: 0.0,
                lever: 1.0,
                class: 0,
            })
            .collect();
        let wrenches: Vec<[f64; 6]> =
            (0..40).map(|k| [9.0, (1.9 * k as f64).cos(), k as f64, 0.0, -50.0 * wave(k), 2.0]).collect();
        assert_eq!(strongest(&points, &wrenches), 4);
    }
}

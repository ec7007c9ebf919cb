//! Plants that tests and studies share, each described by a TOML file beside this one.
//!
//! The files are [`PlantOptions`] and good starting points for one's own: sizes are those of real machines of the
//! kind, what they leave open (phases, curves, the scatter of stiffnesses) comes from the seed.

mod gantry;
mod treatment;

pub use gantry::gantry;
pub use treatment::treatment_point;

use crate::{Plant, PlantDescription, PlantOptions, SimulateError};
use truepose_kinematics::{Chain, samples};

/// The paper's patient positioning system; see [`crate::Campaign::paper_set_a`] for its campaigns.
///
/// # Errors
/// None in practice: the description is a constant, held by this crate's tests.
pub fn pps_plant(seed: u64) -> Result<Plant, SimulateError> {
    made(&samples::pps(), include_str!("pps.toml"), seed)
}

/// A heavy 6R arm with elastic joints and links.
///
/// # Errors
/// None in practice, as above.
pub fn heavy_plant(seed: u64) -> Result<Plant, SimulateError> {
    made(&samples::heavy(), include_str!("heavy.toml"), seed)
}

/// A UR10 with strain wave gears.
///
/// # Errors
/// None in practice, as above.
pub fn ur10_plant(seed: u64) -> Result<Plant, SimulateError> {
    made(&samples::ur10(), include_str!("ur10.toml"), seed)
}

/// A gantry with three linear axes and a rotary head.
///
/// # Errors
/// None in practice, as above.
pub fn gantry_plant(seed: u64) -> Result<Plant, SimulateError> {
    made(&gantry()?, include_str!("gantry.toml"), seed)
}

/// A SCARA with backlash.
///
/// # Errors
/// None in practice, as above.
pub fn scara_plant(seed: u64) -> Result<Plant, SimulateError> {
    made(&samples::scara(), include_str!("scara.toml"), seed)
}

/// A 7R arm, measured with its orientation.
///
/// # Errors
/// None in practice, as above.
pub fn seven_plant(seed: u64) -> Result<Plant, SimulateError> {
    made(&samples::seven(), include_str!("seven.toml"), seed)
}

fn made(chain: &Chain, text: &str, seed: u64) -> Result<Plant, SimulateError> {
    let description = PlantDescription::from_toml(text)?;
    let PlantDescription { errors, shop, instrument, repeatability, .. } = description;
    Plant::random(chain, &PlantOptions { errors, shop, instrument, repeatability }, seed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Campaign, TREATMENT_POINT, payload_at_treatment_point};
    use nalgebra::Vector3;
    use truepose_kinematics::{Conditions, Load};

    fn treatment_error(plant: &Plant, joints: &[f64], load: Load) -> Vector3<f64> {
        let at = Conditions::at(plant.chain(), joints).with_load(load);
        let seen: Vec<Vector3<f64>> = (0..3)
            .map(|k| plant.true_position(&at, Some(truepose_kinematics::TargetId(k))).expect("a position"))
            .collect();
        let nominal = Plant::perfect(plant.chain()).expect("a plant").true_pose(&at).expect("a pose");
        let point = Vector3::from(TREATMENT_POINT);
        treatment_point(plant.chain(), &seen).expect("a point") - nominal.apply(&point)
    }

    #[test]
    fn the_couch_errs_by_millimetres_as_the_papers_did() {
        // Before calibration on the order of 10 mm, 6–8 mm of it elastic: by physics, over twenty machines.
        let (mut worst, mut elastic) = (Vec::new(), Vec::new());
        for seed in 0..20 {
            let plant = pps_plant(seed).expect("a plant");
            let set = Campaign::paper_set_a(plant.chain()).expect("set a");
            let errors = set.visits.iter().map(|v| treatment_error(&plant, &v.joints, v.load).norm());
            worst.push(errors.fold(0.0, f64::max));
            let home = [0.0; 6];
            let rigid = {
                let mut truth = plant.truth().clone();
                truth.foundation = crate::physics::foundation::Foundation::default();
                for joint in &mut truth.joints {
                    joint.stiffness = crate::physics::joint_stiffness::JointStiffness::default();
                    joint.beam = None;
                }
                plant.clone().with_truth(truth).expect("a plant")
            };
            let loaded = payload_at_treatment_point(154.0);
            elastic.push(
                (treatment_error(&plant, &home, loaded) - treatment_error(&rigid, &home, loaded)).norm(),
            );
        }
        worst.sort_by(f64::total_cmp);
        elastic.sort_by(f64::total_cmp);
        assert!(worst[0] > 5e-3 && worst[19] < 12e-3, "{worst:?}");
        assert!(elastic[10] > 6e-3 && elastic[10] < 8e-3, "{elastic:?}");
    }

    #[test]
    fn the_deflection_of_the_couch_is_nearly_proportional() {
        // The paper fits a line to 0…300 lb within 0.1 mm.
        let plant = pps_plant(3).expect("a plant");
        let sag: Vec<f64> = Campaign::paper_linearity()
            .visits
            .iter()
            .map(|visit| treatment_error(&plant, &visit.joints, visit.load).y)
            .collect();
        let line = |k: usize| sag[0] + (sag[12] - sag[0]) * k as f64 / 12.0;
        let off = (0..13).map(|k| (sag[k] - line(k)).abs()).fold(0.0, f64::max);
        assert!(off < 1e-4 && off > 1e-7, "{off}");
    }

    #[test]
    fn noise_alone_has_the_radius_that_is_known() {
        // Largest of 56 treatment points from three targets, 0.05 mm shared and 0.04 mm not: 0.184 mm in the median.
        let mut radii: Vec<f64> = (0..40)
            .map(|seed| {
                let plant = pps_plant(seed).expect("a plant");
                let mut half = Campaign::paper_set_a(plant.chain()).expect("set a").shuffled(seed);
                half.visits.truncate(56);
                let seen = plant.observe(&half, seed).expect("data");
                let point =
                    |positions: &[Vector3<f64>]| treatment_point(plant.chain(), positions).expect("a point");
                let radius = |visit: usize| {
                    let rows = 3 * visit..3 * visit + 3;
                    let measured: Vec<_> = rows.clone().map(|row| seen.data.measured_position(row)).collect();
                    (point(&measured) - point(&seen.true_positions[rows])).norm()
                };
                (0..56).map(radius).fold(0.0, f64::max)
            })
            .collect();
        radii.sort_by(f64::total_cmp);
        let median = (radii[19] + radii[20]) / 2.0;
        // The median of 40 is known to about 4 µm.
        assert!((median - 0.184e-3).abs() < 12e-6, "{median}");
    }

    #[test]
    fn every_plant_stands_and_errs_by_a_plausible_amount() {
        let plants = [pps_plant, heavy_plant, ur10_plant, gantry_plant, scara_plant, seven_plant];
        for make in plants {
            let plant = make(1).expect("a plant");
            let perfect = Plant::perfect(plant.chain()).expect("a plant");
            let campaign = Campaign::random(plant.chain(), 40, 1).expect("a campaign");
            let mut largest: f64 = 0.0;
            for visit in &campaign.visits {
                let at = Conditions::at(plant.chain(), &visit.joints);
                let (a, b) = (plant.true_pose(&at).expect("a pose"), perfect.true_pose(&at).expect("a pose"));
                largest = largest.max((a.translation - b.translation).norm());
            }
            assert!((2e-4..2e-2).contains(&largest), "{}: {largest}", plant.chain().name());
        }
    }
}

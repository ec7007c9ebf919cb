//! A campaign, carried out: what was written down, and what was really there.

mod observed;
mod position;
mod sheet;

use crate::stream::Stream;
use crate::{Campaign, Plant, SimulateError, Task};
use nalgebra::Vector3;
use sheet::{Dwell, Sheet};
use truepose_errormodel::Dataset;
use truepose_kinematics::Pose;

/// What was written down, beside what was really there.
#[derive(Debug, Clone, PartialEq)]
pub struct Observation {
    /// The data that the identification is given.
    pub data: Dataset,
    /// True tool pose of each row, without repeatability, noise and outliers.
    pub true_poses: Vec<Pose>,
    /// True position of each row's target, likewise, m.
    pub true_positions: Vec<Vector3<f64>>,
    /// Rows that are outliers.
    pub outliers: Vec<usize>,
    /// Rows whose declared payload is wrong.
    pub wrong_payloads: Vec<usize>,
    /// Pose measurements that are displaced as a whole.
    pub bad_poses: Vec<usize>,
    /// Rows that name another landmark, point or target than what was observed.
    pub misnamed: Vec<usize>,
}

impl Observation {
    /// The same rows with the true position and the true orientation of each, whatever was measured in it.
    pub fn truth(&self) -> Dataset {
        let mut data = self.data.clone();
        data.set_landmarks(None);
        data.set_points(None);
        data.set_kinds(None, [None, None, None]);
        data.position = self.true_positions.iter().map(|&at| at.into()).collect();
        data.orientation = self.true_poses.iter().map(|pose| Some(position::quaternion(pose))).collect();
        data.position_sd = vec![[f64::NAN; 3]; data.len()];
        data.orientation_sd = vec![[f64::NAN; 3]; data.len()];
        data
    }
}

impl Plant {
    /// The data of a campaign. The same seed gives the same bytes.
    ///
    /// # Errors
    /// Those of [`Plant::true_pose`], [`SimulateError::NoVisits`], those of the channels' curves, and of what the robot does not reach.
    pub fn measure(&self, campaign: &Campaign, seed: u64) -> Result<Dataset, SimulateError> {
        Ok(self.observe(campaign, seed)?.data)
    }

    /// The data of a campaign, with the truth beside it. Landmarks are numbered as in [`crate::Cell::names`].
    ///
    /// # Errors
    /// Those of [`Plant::measure`].
    pub fn observe(&self, campaign: &Campaign, seed: u64) -> Result<Observation, SimulateError> {
        if campaign.visits.is_empty() {
            return Err(SimulateError::NoVisits);
        }
        let moments = self.moments(campaign, seed)?;
        let campaign = &*self.reaching(campaign, &moments, seed)?;
        let wound_up = self.path_errors(campaign)?;
        let mut sheet = Sheet::new(self, campaign, seed);
        for (index, (visit, approach)) in campaign.visits.iter().zip(campaign.approaches()).enumerate() {
            let before = &campaign.visits[index.saturating_sub(1)].joints;
            let log = self.disturbances.log;
            let dwell = Dwell {
                index,
                load: visit.load,
                conditions: self.conditions(visit, &moments[index], (&approach, &wound_up[index])),
                moment: &moments[index],
                logged: log.map_or_else(|| visit.joints.clone(), |log| log.recorded(before, &visit.joints)),
            };
            match visit.task {
                Task::Positions => self.positions(campaign, &dwell, &mut sheet)?,
                Task::Observed { thing, target } => self.observations((thing, target), &dwell, &mut sheet)?,
            }
        }
        let mut seen = sheet.finish(&self.cell)?;
        seen.bad_poses = (0..moments.len()).filter(|&pose| moments[pose].displaced).collect();
        let mut of_channels = Stream::Channels.of(seed);
        let further = seen.data.channels.split_off(0);
        for plan in &campaign.channels {
            let values = plan.values(&self.shop, &seen.data.time, &mut of_channels)?;
            seen.data.channels.push(values);
        }
        seen.data.channels.extend(further);
        Ok(seen)
    }
}

#[cfg(test)]
mod tests {
    use crate::{Blunders, Campaign, ChannelPlan, Instrument, Plant, Repeatability};
    use nalgebra::Vector3;
    use truepose_errormodel::Dataset;
    use truepose_kinematics::samples;

    fn noisy() -> Plant {
        let mut plant = Plant::perfect(&samples::heavy()).expect("a plant");
        plant.instrument =
            Instrument { sd: 4e-5, orientation_sd: Some(2e-5), states_sd: true, ..Instrument::default() };
        plant.repeatability = Repeatability { sd: 5e-5, rotation_sd: 0.0 };
        plant
    }

    #[test]
    fn the_data_fit_the_robot_and_the_seed_decides() {
        let plant = noisy();
        let campaign = Campaign::random(plant.chain(), 12, 1)
            .expect("a campaign")
            .with_channels(vec![ChannelPlan::Air { name: "temperature".into(), sd: 0.1 }]);
        let data = plant.measure(&campaign, 5).expect("data");
        data.validate(plant.chain()).expect("columns that fit");
        assert_eq!(data.len(), 36);
        let bytes = |data: &Dataset| -> Vec<u64> {
            data.position
                .iter()
                .flatten()
                .chain(data.channels.iter().flatten())
                .map(|v| v.to_bits())
                .collect()
        };
        assert_eq!(bytes(&data), bytes(&plant.measure(&campaign, 5).expect("data")));
        assert_ne!(bytes(&data), bytes(&plant.measure(&campaign, 6).expect("data")));
    }

    #[test]
    fn a_kind_of_noise_leaves_the_others_as_they_were() {
        let campaign = Campaign::random(&samples::heavy(), 12, 1).expect("a campaign");
        let quiet = noisy().observe(&campaign, 5).expect("data");
        let mut plant = noisy();
        plant.blunders = Blunders { outlier_share: 0.2, outlier_size: 0.01, ..Blunders::default() };
        let loud = plant.observe(&campaign, 5).expect("data");
        assert!(!loud.outliers.is_empty());
        for row in 0..quiet.data.len() {
            let step = quiet.data.measured_position(row) - loud.data.measured_position(row);
            let size = step.norm();
            assert_eq!(loud.outliers.contains(&row), (0.004..0.016).contains(&size), "{size}");
            assert!(loud.outliers.contains(&row) || size < 1e-15);
        }
    }

    #[test]
    fn repeatability_is_shared_by_a_visits_targets_and_noise_is_not() {
        let plant = noisy();
        let home = [0.1, -0.5, 0.4, 0.0, 0.5, 0.0];
        let seen = plant.observe(&Campaign::returns(&home, 3000, 2), 9).expect("data");
        let error: Vec<Vector3<f64>> =
            (0..seen.data.len()).map(|r| seen.data.measured_position(r) - seen.true_positions[r]).collect();
        let mean = |f: &dyn Fn(usize) -> f64| (0..3000).map(f).sum::<f64>() / 3000.0;
        // Variance σ_r² + σ_t² an axis; covariance of two targets of one visit σ_r². 3 % is what 9000 draws give.
        let variance = mean(&|v| error[3 * v].norm_squared() / 3.0);
        let shared = mean(&|v| error[3 * v].dot(&error[3 * v + 1]) / 3.0);
        assert!((variance / (25e-10 + 16e-10) - 1.0).abs() < 0.06, "{variance}");
        assert!((shared / 25e-10 - 1.0).abs() < 0.08, "{shared}");
    }

    #[test]
    fn a_mislabelled_payload_is_declared_and_not_carried() {
        let chain = samples::heavy();
        let mut truth = crate::Truth::of(&chain);
        truth.joints[1].stiffness = crate::physics::joint_stiffness::JointStiffness::drive(2e6);
        let mut plant = Plant::new(&chain, truth).expect("a plant");
        let campaign = Campaign::of(vec![vec![0.0; 6]]).with_each_payload(&[20.0, 50.0], [0.0; 3]);
        let right = plant.observe(&campaign, 1).expect("data");
        plant.blunders.mislabelled = vec![(50.0, 20.0)];
        let wrong = plant.observe(&campaign, 1).expect("data");
        assert_eq!(wrong.wrong_payloads, [3, 4, 5]);
        assert_eq!(wrong.data.load, right.data.load);
        assert!((wrong.true_positions[3] - right.true_positions[0]).norm() < 1e-15);
        assert!((right.true_positions[3] - right.true_positions[0]).norm() > 1e-5);
    }

    #[test]
    fn an_axis_that_is_not_seen_is_not_written() {
        let mut plant = noisy();
        plant.instrument.axes = [true, false, true];
        let data = plant.measure(&Campaign::of(vec![vec![0.0; 6]]), 1).expect("data");
        assert_eq!(data.seen(0).position, [true, false, true]);
        assert!(plant.measure(&Campaign::of(Vec::new()), 1).is_err());
    }
}

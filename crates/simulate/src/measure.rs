//! A campaign, carried out: what the instrument wrote down, and what was really there.

use crate::rigid::{Rigid, to_pose};
use crate::{Campaign, Plant, SimulateError};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use truepose_errormodel::{Dataset, Schema};
use truepose_kinematics::{Conditions, Load, Payload, Pose, TargetId};

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
}

/// Streams of random numbers: a kind of noise that is switched on leaves the others as they were.
enum Stream {
    Visit = 1,
    Instrument,
    Orientation,
    Outliers,
    Payloads,
    Channels,
    Joints,
    Wander,
    Station,
    BadPoses,
    Flicker,
}

impl Plant {
    /// The data of a campaign. The same seed gives the same bytes.
    ///
    /// # Errors
    /// Those of [`Plant::true_pose`], [`SimulateError::NoVisits`], and those of the channels' curves.
    pub fn measure(&self, campaign: &Campaign, seed: u64) -> Result<Dataset, SimulateError> {
        Ok(self.observe(campaign, seed)?.data)
    }

    /// The data of a campaign, with the truth beside it.
    ///
    /// # Errors
    /// Those of [`Plant::measure`].
    pub fn observe(&self, campaign: &Campaign, seed: u64) -> Result<Observation, SimulateError> {
        if campaign.visits.is_empty() {
            return Err(SimulateError::NoVisits);
        }
        let stream = |which: Stream| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(which as u64);
            rng
        };
        let (mut of_visit, mut of_row) = (stream(Stream::Visit), stream(Stream::Instrument));
        let (mut of_orientation, mut of_outlier) = (stream(Stream::Orientation), stream(Stream::Outliers));
        let mut of_payload = stream(Stream::Payloads);
        let (mut of_joint, mut of_flicker) = (stream(Stream::Joints), stream(Stream::Flicker));
        let (disturbed, poses) = (&self.disturbances, campaign.visits.len());
        disturbed.fits(self.chain().movable().len(), poses)?;
        let wander = disturbed.wander.map(|wander| wander.path(poses, &mut stream(Stream::Wander)));
        let station = disturbed
            .station
            .map(|motion| motion.path(self.instrument.station, poses, &mut stream(Stream::Station)));
        let displaced = disturbed.displaced_poses(poses, &mut stream(Stream::BadPoses));
        let (times, wound_up) = (campaign.times(), self.path_errors(campaign)?);
        let mut seen = Observation {
            data: self.empty_data(campaign),
            true_poses: Vec::new(),
            true_positions: Vec::new(),
            outliers: Vec::new(),
            wrong_payloads: Vec::new(),
            bad_poses: (0..poses).filter(|&pose| displaced[pose].is_some()).collect(),
        };
        let targets = self.measured_targets(campaign);
        for (index, (visit, approach)) in campaign.visits.iter().zip(campaign.approaches()).enumerate() {
            let carried = self.really_carried(visit.load, times[index], &mut of_payload);
            let before = &campaign.visits[index.saturating_sub(1)].joints;
            let logged =
                disturbed.log.map_or_else(|| visit.joints.clone(), |log| log.recorded(before, &visit.joints));
            let shared = three(&mut of_visit) * self.repeatability.sd;
            let turned = three(&mut of_visit) * self.repeatability.rotation_sd;
            let off_joints = disturbed.joints(&mut of_joint);
            let away = wander.as_ref().map_or(Vector3::zeros(), |path| path[index])
                + displaced[index].unwrap_or_default();
            for (k, &target) in targets.iter().enumerate() {
                let row = seen.data.len();
                let time = times[index] + campaign.row_s * k as f64;
                let conditions = Conditions {
                    joints: visit.joints.iter().zip(&wound_up[index]).map(|(q, off)| q + off).collect(),
                    tool: truepose_kinematics::ToolId::FIRST,
                    load: carried,
                    time,
                    approach: approach.clone(),
                    channels: Vec::new(),
                };
                let tool = self.equilibrium(&conditions)?.tool;
                let point = (tool * Point3::from(self.true_target(target)?)).coords;
                let reached = self.reached(&conditions, &off_joints, &tool)?;
                let at = (reached * Point3::from(self.true_target(target)?)).coords;
                let off = shared + away + turned.cross(&(at - reached.translation.vector));
                let mut seen_at = station.as_ref().map_or(at + off, |path| path.seen(index, &(at + off)));
                if let Some(beam) = &disturbed.beam {
                    let facing = reached.rotation * Vector3::z();
                    seen_at += beam.displacement(&self.instrument.station, &(at + off), &self.up(), &facing);
                }
                let mut measured = seen_at + self.instrument.error(&point, &mut of_row);
                if of_outlier.random::<f64>() < self.blunders.outlier_share {
                    let size = self.blunders.outlier_size * (0.5 + of_outlier.random::<f64>());
                    measured += three(&mut of_outlier).normalize() * size;
                    seen.outliers.push(row);
                }
                if carried != visit.load {
                    seen.wrong_payloads.push(row);
                }
                self.write_position(&mut seen.data, &measured);
                let stand = station.as_ref().map(|path| path.rotation(index));
                self.write_orientation(&mut seen.data, &reached, (&turned, stand), &mut of_orientation);
                let data = &mut seen.data;
                for (column, q) in data.joints.iter_mut().zip(&logged) {
                    column.push(disturbed.recorded(*q, &mut of_flicker));
                }
                for (column, side) in data.approach.iter_mut().zip(&approach) {
                    column.push(*side);
                }
                data.target.push(target);
                data.visit.push(index);
                data.load.push(visit.load);
                data.time.push(time);
                seen.true_poses.push(to_pose(&tool));
                seen.true_positions.push(point);
            }
        }
        let mut of_channels = stream(Stream::Channels);
        for plan in &campaign.channels {
            let values = plan.values(&self.shop, &seen.data.time, &mut of_channels)?;
            seen.data.channels.push(values);
        }
        Ok(seen)
    }

    /// The tool where the joints end with these deviations: `there` without any.
    fn reached(&self, conditions: &Conditions, off: &[f64], there: &Rigid) -> Result<Rigid, SimulateError> {
        if off.is_empty() {
            return Ok(*there);
        }
        let joints = conditions.joints.iter().zip(off).map(|(q, off)| q + off).collect();
        Ok(self.equilibrium(&Conditions { joints, ..conditions.clone() })?.tool)
    }

    fn empty_data(&self, campaign: &Campaign) -> Dataset {
        let movable = self.chain().movable().len();
        Dataset {
            schema: Schema {
                channels: campaign.channels.iter().map(|plan| plan.channel()).collect(),
                time: true,
                load: campaign.visits.iter().any(|visit| visit.load != Load::None),
                approach: true,
            },
            joints: vec![Vec::new(); movable],
            approach: vec![Vec::new(); movable],
            ..Dataset::default()
        }
    }

    fn measured_targets(&self, campaign: &Campaign) -> Vec<Option<TargetId>> {
        let declared = self.chain().targets().len();
        match (campaign.targets.is_empty(), declared) {
            (false, _) => campaign.targets.clone(),
            (true, 0) => vec![None],
            (true, count) => (0..count).map(|k| Some(TargetId(k))).collect(),
        }
    }

    /// The true load of the tool when this is declared.
    fn really_carried(&self, declared: Load, time: f64, rng: &mut ChaCha8Rng) -> Load {
        let chance = rng.random::<f64>();
        let Load::Payload(payload) = declared else { return declared };
        let labels = &self.blunders.mislabelled;
        let mass = match labels.iter().find(|(label, _)| (label - payload.mass).abs() < 1e-9) {
            Some((_, real)) => *real,
            None if payload.mass > 0.0 && chance < self.blunders.wrong_payload_share => {
                payload.mass * self.blunders.wrong_payload_factor
            }
            None => payload.mass,
        };
        let stretch = self.blunders.wrong_stretch.filter(|([from, until], label, _)| {
            (*from..*until).contains(&time) && (label - payload.mass).abs() < 1e-9
        });
        let mass = stretch.map_or(mass, |(_, _, factor)| factor * mass);
        Load::Payload(Payload { mass, ..payload })
    }

    fn write_position(&self, data: &mut Dataset, measured: &Vector3<f64>) {
        let seen = |k: usize, value: f64| if self.instrument.axes[k] { value } else { f64::NAN };
        data.position.push(std::array::from_fn(|k| seen(k, measured[k])));
        let covariance = self.instrument.covariance(measured);
        let (stated, factor) = (self.instrument.states_sd, self.disturbances.stated_factor);
        data.position_sd.push(std::array::from_fn(|k| {
            if stated { seen(k, factor * covariance[(k, k)].sqrt()) } else { f64::NAN }
        }));
    }

    fn write_orientation(
        &self,
        data: &mut Dataset,
        tool: &Rigid,
        (turned, stand): (&Vector3<f64>, Option<UnitQuaternion<f64>>),
        rng: &mut ChaCha8Rng,
    ) {
        let Some(sd) = self.instrument.orientation_sd else {
            data.orientation.push(None);
            data.orientation_sd.push([f64::NAN; 3]);
            return;
        };
        let noise = Vector3::from_fn(|_, _| self.instrument.unit(rng)) * sd;
        let turned = UnitQuaternion::from_scaled_axis(noise + turned) * tool.rotation;
        let measured = stand.map_or(turned, |stand| stand * turned);
        let [x, y, z, w]: [f64; 4] = measured.into_inner().coords.into();
        let sign = if w < 0.0 { -1.0 } else { 1.0 };
        data.orientation.push(Some([w, x, y, z].map(|v| v * sign)));
        let stated = self.disturbances.stated_factor * sd;
        data.orientation_sd.push([if self.instrument.states_sd { stated } else { f64::NAN }; 3]);
    }
}

fn three(rng: &mut impl Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| StandardNormal.sample(rng))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Blunders, ChannelPlan, Instrument, Repeatability};
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

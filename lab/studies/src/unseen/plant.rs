//! A described robot, built and measured, with the truth beside it.
//!
//! The noise of a row is taken from replicates of the campaign with other noise; bad poses, outliers and a moving station
//! are no noise.

use super::cause::Cause;
use super::description::{Description, Order};
use super::hidden::{Hidden, Piece};
use super::robots::{Robot, robot};
use super::stream::{Key, Part};
use crate::prelude::*;
use truepose_errormodel::{Dwell, DwellTolerance, approach_from_order, visits_from_rows};
use truepose_simulate::{Blunders, Wander};

/// Fresh configurations at which a result is compared with the plant.
const FRESH: usize = 150;
/// Replicates from which the noise of a row is taken.
const REPLICATES: u64 = 12;
const VISIT_S: f64 = 60.0;
/// Least and largest displacement of a bad pose, m.
const BAD: [f64; 2] = [5e-4, 2e-3];

/// A robot, measured.
pub struct Made {
    pub robot: Robot,
    pub declared: Vec<Box<dyn AnyEffect>>,
    /// The record as the program reads it.
    pub data: Dataset,
    pub seen: Observation,
    pub hidden: Option<Hidden>,
    /// 3-D RMS of the noise of one row, m.
    pub floor: f64,
    /// What the declared model cannot absorb, over the noise.
    pub size: f64,
    /// Fresh configurations over the same time, with true positions.
    pub truth: Dataset,
    /// The same as the instrument shows them: with what it adds, without noise.
    pub shown: Dataset,
    /// The same noise and campaign without the cause, bad poses and outliers.
    pub clean: Dataset,
    /// The fresh configurations of the robot without the cause.
    pub clean_truth: Dataset,
    /// What is declared where nothing is hidden.
    pub clean_declared: Vec<Box<dyn AnyEffect>>,
    /// Of several causes at once: each, and what the declared model cannot absorb of it alone, over the noise; the largest first.
    pub pieces: Vec<(Piece, f64)>,
    /// The robot without noise, its fresh configurations, and the seed with which they are measured.
    pub quiet: Plant,
    pub fresh: Campaign,
    pub fresh_seed: u64,
}

/// A robot before its cause is known.
pub struct Ground<'a> {
    pub what: &'a Description,
    pub key: Key,
    pub robot: Robot,
    pub loads: Vec<f64>,
    pub campaign: Campaign,
}

/// Builds and measures the robot of a key.
pub fn make(what: &Description, key: Key) -> Outcome<Made> {
    let robot = robot(what.make, what.targets, &mut key.draw(Part::Robot))?;
    let postures = Campaign::halton(&robot.chain, 40)?.visits.into_iter();
    let conditions = postures.map(|visit| Conditions::at(&robot.chain, &visit.joints));
    let loads = largest_loads(&robot.chain, conditions)?;
    let mut ground = Ground { what, key, robot, loads, campaign: Campaign::of(Vec::new()) };
    ground.campaign = ground.campaign(what.poses, what.repeats, Part::Campaign)?;
    ground.campaign.visit_s = VISIT_S;
    let null = ground.plant(None, true)?;
    let floor = ground.floor(&null)?;
    let cause = ground.cause(floor)?;
    let one = cause.as_ref().map(|cause| (&cause.hidden, cause.size));
    let plant = ground.plant(one, true)?;
    let noise = key.seed(Part::Noise);
    let seen = plant.observe(&ground.campaign, noise)?;
    let clean = ground.plant(None, false)?.observe(&ground.campaign, noise)?;
    let fresh = ground.clocked(ground.campaign(FRESH, 0, Part::Fresh)?);
    let shown = |plant: &Plant| plant.observe(&fresh, key.seed(Part::Fresh));
    let exact = |plant: Plant| -> Outcome<Dataset> {
        let mut seen = shown(&plant)?;
        seen.data.position = seen.true_positions.iter().map(|p| (*p).into()).collect();
        seen.data.orientation.fill(None);
        Ok(ground.read(&seen.data))
    };
    let (truth, clean_truth) = (exact(ground.quiet(one)?)?, exact(ground.quiet(None)?)?);
    let mut shown = shown(&ground.quiet(one)?)?.data;
    shown.orientation.fill(None);
    let pieces = cause.as_ref().map_or(Ok(Vec::new()), |cause| ground.pieces(cause, floor))?;
    Ok(Made {
        pieces,
        quiet: ground.quiet(one)?,
        fresh: fresh.clone(),
        fresh_seed: key.seed(Part::Fresh),
        declared: ground.declared(cause.as_ref().map(|cause| &cause.hidden)),
        data: ground.read(&seen.data),
        clean: ground.read(&clean.data),
        truth,
        shown: ground.read(&shown),
        clean_truth,
        clean_declared: ground.declared(None),
        robot: if what.weights { ground.robot } else { ground.robot.without_weights()? },
        seen,
        size: cause.as_ref().map_or(0.0, |cause| cause.reached),
        hidden: cause.map(|cause| cause.hidden),
        floor,
    })
}

impl Ground<'_> {
    /// Poses in their order, with their loads and channels.
    pub fn campaign(&self, poses: usize, repeats: usize, part: Part) -> Outcome<Campaign> {
        let (chain, seed) = (&self.robot.chain, self.key.seed(part));
        let mut campaign = match self.what.order {
            Order::JointByJoint => {
                let rounds = (poses / (5 * chain.movable().len())).max(2);
                Campaign::joint_by_joint(chain, poses, rounds, seed)?
            }
            _ => Campaign::random(chain, poses, seed)?,
        };
        if self.what.loads {
            let heavy = self.robot.payload;
            let com = [0.02 * self.robot.reach, -0.01 * self.robot.reach, 0.08 * self.robot.reach];
            let masses = [0.0, 0.5 * heavy, heavy];
            campaign = campaign.with_some_payload(&masses, com, 0.01 * self.robot.reach, seed ^ 1);
        }
        if self.what.order == Order::Snake {
            let parts = (poses as f64).sqrt().round() as usize;
            campaign = campaign.as_snake(0, 1, parts)?;
        }
        let mut again = campaign.clone();
        // Repeats come at the end, every so many poses of the campaign.
        let step = (poses / repeats.max(1)).max(1);
        again.visits = campaign.visits.iter().step_by(step).take(repeats).cloned().collect();
        campaign = campaign.then(again);
        let mut channels = Vec::new();
        if self.what.columns.temperature {
            channels.push(ChannelPlan::Air { name: "temperature".into(), sd: 0.05 });
        }
        let mut campaign = campaign.with_channels(channels);
        if let Some(cause) = self.what.cause {
            cause.equip(&mut campaign, VISIT_S);
        }
        Ok(campaign)
    }

    /// Over the time of the campaign that is measured.
    pub fn clocked(&self, mut campaign: Campaign) -> Campaign {
        let paused: f64 = campaign.pauses.iter().map(|(_, seconds)| seconds).sum();
        campaign.visit_s = (self.campaign.duration_s() - paused) / campaign.visits.len().max(2) as f64;
        campaign
    }

    fn options(&self) -> PlantOptions {
        let (what, reach) = (self.what, self.robot.reach);
        let mut draw = self.key.draw(Part::Plant);
        let geometric = flaws::Geometric {
            position_mm: reach * draw.logarithmic(0.1, 0.5),
            angle_mrad: draw.logarithmic(0.1, 0.6),
            target_mm: 0.05,
            ..flaws::Geometric::default()
        };
        let softness = what.cause.map_or(1.0, Cause::softness);
        // Drives that turn by 0.05 to 0.4 mrad under their largest load, times the softness.
        let largest = self.loads.iter().copied().fold(1e-3, f64::max);
        let movable = self.robot.chain.movable().iter().zip(&self.loads);
        let compliances: Vec<_> = movable
            .map(|(&joint, load)| {
                let angle = 1e-3 * softness * draw.logarithmic(0.05, 0.4);
                spring(name_of(&self.robot.chain, joint), load.max(0.05 * largest) / angle)
            })
            .collect();
        let repeatability = if what.joint_noise || what.memory > 0.0 { 0.0 } else { what.noise_um[1] };
        let station = [draw.between(2.0, 4.0), draw.between(-2.0, 2.0), draw.between(0.0, 1.5)];
        // A tracker measures in its own frame.
        let station = if what.cause.is_some_and(Cause::is_beam) { [0.0; 3] } else { station };
        let thermal = what.cause.is_some_and(Cause::is_thermal);
        PlantOptions {
            errors: Flaws {
                geometric: Some(geometric),
                joint_compliance: if what.compliance { compliances } else { Vec::new() },
                ..Flaws::default()
            },
            shop: ShopDay {
                start_c: 20.0,
                rise_k: if thermal { 4.0 } else { 2.0 },
                wander_k: if thermal { 2.0 } else { 0.7 },
                hours: self.campaign.duration_s() / 3600.0 + 0.05,
            },
            instrument: InstrumentSize {
                station_mm: station.map(|v| 1e3 * v),
                sd_um: what.noise_um[0],
                transverse_um_per_m: 2.0,
                orientation_urad: what.orientation.then_some(60.0),
                freedom: what.heavy_tails.then_some(5.0),
                states_sd: what.stated.is_some(),
                ..InstrumentSize::default()
            },
            repeatability: RepeatabilitySize { sd_um: repeatability, rotation_urad: 0.0 },
        }
    }

    /// The plant with a cause of some size; with what went wrong in the record, or without.
    fn plant(&self, hidden: Option<(&Hidden, f64)>, spoiled: bool) -> Outcome<Plant> {
        let what = self.what;
        let mut options = self.options();
        if let Some((hidden, size)) = hidden {
            if let Some(joint) = hidden.undeclared() {
                let name = name_of(&self.robot.chain, joint);
                options.errors.joint_compliance.retain(|one| one.joint != name);
            }
            hidden.options(&mut options, size);
        }
        if spoiled && what.outliers > 0.0 {
            let size_mm = 0.02 * (what.noise_um[0] + what.noise_um[1]);
            options.errors.outliers = Some(flaws::Outliers { share: what.outliers, size_mm });
        }
        let mut plant = Plant::random(&self.robot.chain, &options, self.key.seed(Part::Plant))?;
        let repeatability = 1e-6 * what.noise_um[1];
        let disturbances = &mut plant.disturbances;
        disturbances.stated_factor = what.stated.unwrap_or(1.0);
        disturbances.flicker = what.flicker_deg.to_radians();
        if what.memory > 0.0 {
            disturbances.wander = Some(Wander::even(what.memory, repeatability));
        }
        if what.joint_noise {
            // Shared evenly by the joints, at a lever of the robot's reach.
            let count = self.robot.chain.movable().len() as f64;
            let sd = |joint: &JointId| {
                let lever = if slides(&self.robot.chain, *joint) { 1.0 } else { self.robot.reach };
                2.0 * repeatability / count.sqrt() / lever
            };
            disturbances.joint_sd = self.robot.chain.movable().iter().map(sd).collect();
        }
        if spoiled {
            disturbances.bad_poses = what.bad_poses;
            disturbances.bad_size = BAD;
        }
        if let Some((hidden, size)) = hidden {
            hidden.amend(&mut plant, size)?;
        }
        Ok(plant)
    }

    /// The same robot, measured without noise.
    pub fn quiet(&self, hidden: Option<(&Hidden, f64)>) -> Outcome<Plant> {
        let mut plant = noise_free(&self.plant(hidden, false)?);
        plant.instrument.orientation_sd = None;
        let (station, beam) = (plant.disturbances.station, plant.disturbances.beam);
        plant.disturbances = Disturbances { station, beam, ..Default::default() };
        Ok(plant)
    }

    /// 3-D RMS of the noise of one row, m.
    fn floor(&self, null: &Plant) -> Outcome<f64> {
        let mut plant = null.clone();
        plant.disturbances.bad_poses = 0;
        plant.blunders = Blunders::default();
        let (mut sum, mut count) = (0.0, 0);
        for k in 0..REPLICATES {
            let seen = plant.observe(&self.campaign, self.key.seed(Part::Replicates) ^ k)?;
            for (row, truth) in seen.true_positions.iter().enumerate() {
                sum += (seen.data.measured_position(row) - truth).norm_squared();
                count += 1;
            }
        }
        Ok((sum / f64::from(count.max(1))).sqrt())
    }

    pub fn declared(&self, hidden: Option<&Hidden>) -> Vec<Box<dyn AnyEffect>> {
        let mut effects = constant_errors();
        if self.what.compliance {
            let left_out = hidden.and_then(Hidden::undeclared);
            let joints = self.robot.chain.movable().iter().copied().filter(|joint| Some(*joint) != left_out);
            effects.push(Box::new(JointCompliance { joints: Some(joints.collect()), ..Default::default() }));
        }
        effects
    }

    /// A record as a reader has it: columns that are missing are derived or empty.
    fn read(&self, data: &Dataset) -> Dataset {
        let (mut data, columns) = (data.clone(), self.what.columns);
        data.dwell = Dwell::of(&self.robot.chain, DwellTolerance::default());
        if !columns.visit {
            data.visit = visits_from_rows(&data);
        }
        if !columns.approach {
            data.approach = approach_from_order(&data);
        }
        if !columns.time {
            data.schema.time = false;
            data.time.fill(0.0);
        }
        data
    }
}

/// 3-D RMS error of a fit at configurations with known positions, m.
pub fn fresh_error(truth: &Dataset, fitted: &FittedModel) -> Outcome<f64> {
    Ok(Residuals::of(fitted, truth)?.positions().rms)
}

#[cfg(test)]
mod tests {
    use super::super::description::Kind;
    use super::*;

    fn of(kind: Kind, cell: &str, number: u64) -> (Description, Made) {
        let key = kind.key(Half::Tuning, number);
        let what = Description::of(kind, cell, key);
        let made = make(&what, key).expect("a robot");
        (what, made)
    }

    #[test]
    fn a_cause_has_its_size_and_a_null_leaves_nothing() {
        for number in 0..4 {
            let (what, made) = of(Kind::Power, "25", number);
            assert!((made.size / what.size).ln().abs() < 0.03, "{number}: {}", made.size);
            assert_eq!(made.seen.data.visit.last().map(|v| v + 1), Some(25 + what.repeats));
        }
        let (_, null) = of(Kind::Null, "", 2);
        // Without a beam the instrument shows what is there.
        let apart =
            |row: usize| (null.shown.measured_position(row) - null.truth.measured_position(row)).norm();
        assert!((0..null.truth.len()).all(|row| apart(row) < 1e-12));
        // A dense fit of the clean record predicts the truth far below the noise of a row.
        let options = FitOptions { prior: PriorStrength::VarianceGroups, ..FitOptions::default() };
        let fitted = fitted(&null.robot.chain, &null.declared, &null.clean, &options).expect("a fit").fitted;
        assert!(fresh_error(&null.truth, &fitted).expect("an error") < 2.0 * null.floor);
    }

    #[test]
    fn the_same_key_measures_the_same_bytes() {
        let bytes = |made: &Made| -> Vec<u64> {
            made.data
                .position
                .iter()
                .flatten()
                .chain(made.truth.position.iter().flatten())
                .map(|v| v.to_bits())
                .collect()
        };
        let (first, again) = (of(Kind::Bad, "2", 1).1, of(Kind::Bad, "2", 1).1);
        assert_eq!(bytes(&first), bytes(&again));
        assert_eq!(first.seen.bad_poses.len(), 2);
        // The clean record has the same noise without what went wrong.
        let differing = (0..first.data.len()).filter(|&row| {
            (first.data.measured_position(row) - first.clean.measured_position(row)).norm() > 1e-12
        });
        let poses: std::collections::BTreeSet<usize> =
            differing.map(|row| first.seen.data.visit[row]).collect();
        assert_eq!(poses.into_iter().collect::<Vec<_>>(), first.seen.bad_poses);
    }

    #[test]
    fn columns_that_are_missing_are_missing() {
        let (what, made) = of(Kind::Flicker, "", 1);
        assert!(!what.columns.visit && what.flicker_deg > 0.0);
        let off = |row: usize| made.data.joints[0][row] - made.data.joints[0][0];
        assert!(off(1).abs() > 0.0 && off(1).abs() < 2.0 * 1e-4f64.to_radians());
        let kind = Kind::Columns;
        let timeless = (0..20)
            .map(|number| Description::of(kind, "", kind.key(Half::Tuning, number)))
            .position(|what| !what.columns.time)
            .expect("one without time");
        let (_, made) = of(kind, "", timeless as u64);
        assert!(!made.data.schema.time && made.data.time.iter().all(|t| *t == 0.0));
    }
}

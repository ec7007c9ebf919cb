//! The robots of the study: plants of three kinds, an instrument and joints that do not repeat exactly.

use crate::prelude::*;

/// Standard deviations of an axis: what the robot does differently each time, and the instrument; µm.
const REPEATABILITY: f64 = 20.0;
const INSTRUMENT: f64 = 10.0;

/// 3-D RMS of a measured row about the truth, m.
pub fn noise() -> f64 {
    3f64.sqrt() * 1e-6 * REPEATABILITY.hypot(INSTRUMENT)
}

/// A robot without errors, and the seed of those that it gets.
#[derive(Clone)]
pub struct Robot {
    pub seed: u64,
    pub word: &'static str,
    pub chain: Chain,
}

impl Robot {
    /// Number `number` of a half of the seeds, with so many of its three targets.
    pub fn of(number: u64, locked: bool, targets: usize) -> Outcome<Self> {
        let (word, chain) = match number % 3 {
            0 => ("ur10", samples::ur10()),
            1 => ("heavy", samples::heavy()),
            _ => ("7R", samples::seven()),
        };
        let seed = 2 * number + u64::from(locked);
        Ok(Robot { seed, word, chain: with_targets(chain, targets)? })
    }

    /// The arm as it is: constant errors at all frames, two soft joints, and `more`.
    pub fn plant(&self, chain: &Chain, more: Flaws) -> Outcome<Plant> {
        let geometric = flaws::Geometric {
            position_mm: 0.4,
            angle_mrad: 0.4,
            target_mm: 0.1,
            ..flaws::Geometric::default()
        };
        let turning = chain.movable().iter().filter(|&&joint| chain.joint(joint).kind == JointKind::Revolute);
        let soft = turning.skip(1).take(2).map(|&joint| flaws::JointCompliance {
            joint: chain.joint(joint).name.clone(),
            ..flaws::JointCompliance::default()
        });
        let options = PlantOptions {
            errors: Flaws { geometric: Some(geometric), joint_compliance: soft.collect(), ..more },
            instrument: InstrumentSize { sd_um: INSTRUMENT, ..InstrumentSize::default() },
            repeatability: RepeatabilitySize { sd_um: REPEATABILITY, ..RepeatabilitySize::default() },
            ..PlantOptions::default()
        };
        Ok(Plant::random(chain, &options, self.seed)?)
    }

    /// What a campaign number of random poses measures.
    pub fn observed(&self, plant: &Plant, poses: usize, campaign: u64) -> Outcome<Observation> {
        let seed = self.seed + (campaign << 32);
        let poses = Campaign::random(plant.chain(), poses, seed)?.shuffled(seed);
        Ok(plant.observe(&poses, seed)?)
    }
}

/// The declared model, fitted.
pub fn identified(chain: &Chain, data: &Dataset) -> Outcome<Fit> {
    fitted(chain, &elastic_errors(), data, &FitOptions::default())
}

/// RMS distance of predictions to where the targets really are, m.
pub fn error(fitted: &FittedModel, seen: &Observation) -> Outcome<f64> {
    let mut predictor = fitted.bind(&seen.data.schema)?;
    let off = |row: usize| {
        let pose = predictor.predict(&seen.data.conditions(row), seen.data.target[row]);
        (pose.translation - seen.true_positions[row]).norm_squared()
    };
    Ok(((0..seen.data.len()).map(off).sum::<f64>() / seen.data.len() as f64).sqrt())
}

fn with_targets(chain: Chain, count: usize) -> Outcome<Chain> {
    let at = [[0.12, 0.03, 0.05], [-0.08, 0.11, 0.02], [-0.05, -0.1, 0.14]];
    let targets = (1..).zip(at.into_iter().take(count)).map(|(k, p)| target(format!("T{k}"), p.into()));
    Ok(chain.with_targets(targets.collect())?)
}

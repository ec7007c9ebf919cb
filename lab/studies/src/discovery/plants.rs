//! A plant with one hidden cause, of a size that is a multiple of the detectable one.
//!
//! ```text
//! λ = min over the declared model of  Σ |whitened (noise-free data of the flawed plant − model)|²       over the training rows
//! λ = 30 m²                                                                                 m: the multiple
//! ```
//!
//! λ is the noncentrality that the declared model leaves: what any test could see of the cause. At 30 a single
//! unknown among the thousands that are tested is found about four times in five. Outliers are no effect: each is m √30
//! standard deviations of one coordinate long.

use super::hidden_effects::{Hidden, HiddenEffect, word_of};
use super::robots::{self, Robot, Undeclared};
use crate::prelude::*;
use rand::seq::IndexedRandom;
use truepose_identify::hold_out;
use truepose_simulate::physics::guideway::GuidewayProfile;

/// Noncentrality at which a cause is detectable.
pub const DETECTABLE: f64 = 30.0;
/// Share of the configurations that the loop locks away, and the seed of the draw.
pub const HOLDOUT: (f64, u64) = (0.2, 0);
/// Places that are tried before there is none at which a cause can be as large.
const PLACES: u64 = 60;

/// A cause of more than this many times its usual size is no cause that a machine would have.
const LARGEST: f64 = 4.0;

/// A plant, measured.
pub struct Made {
    pub robot: String,
    pub heavy: bool,
    pub chain: Chain,
    pub declared: Vec<Box<dyn AnyEffect>>,
    pub plant: Plant,
    pub seen: Observation,
    /// What is hidden, and λ as it was reached by one cause.
    pub hidden: Vec<(HiddenEffect, Hidden)>,
    pub lambda: f64,
}

/// Causes of which several may be hidden in one plant: all that the declared model is the same for.
const TOGETHER: [HiddenEffect; 11] = {
    use HiddenEffect::*;
    [
        LinkCompliance,
        BaseCompliance,
        LoadNonlinearity,
        Eccentric,
        Mesh,
        BacklashApproach,
        Coupling,
        Guideway,
        Thermal,
        Drift,
        Shift,
    ]
};

/// Everything of a plant but the size of what is hidden.
struct Ground<'a> {
    robot: &'a Robot,
    chain: Chain,
    campaign: Campaign,
    heavy: bool,
    hours: f64,
    seed: u64,
}

/// Draws a plant; without a cause it is a null.
pub fn make(cause: Option<HiddenEffect>, multiple: f64, seed: u64) -> Outcome<Made> {
    let number = cause.map_or(0, |cause| 1 + cause as u64);
    let kinds = robots::all()?;
    for place in 0..PLACES {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(number << 32 | place);
        let drawn = rng.random_range(0..kinds.len());
        // Nulls go through the robots in turn, every third round with heavy tails.
        let robot = &kinds[if cause.is_none() { seed as usize % kinds.len() } else { drawn }];
        let heavy = cause.is_none() && (seed / kinds.len() as u64).is_multiple_of(3);
        let ground = Ground::new(robot, heavy, seed, &mut rng)?;
        let hidden = match cause {
            None => None,
            Some(cause) => {
                let loads = ground.loads()?;
                let duration = ground.campaign.duration_s();
                match cause.draw(&ground.chain, (&robot.payloads, &loads), duration, &mut rng) {
                    None => continue,
                    hidden => hidden,
                }
            }
        };
        if let Some((size, lambda)) = ground.size(cause, hidden.as_ref(), multiple)? {
            let one: Vec<(&Hidden, f64)> = hidden.iter().map(|hidden| (hidden, size)).collect();
            let plant = ground.plant(&one)?;
            return ground.measured(plant, cause.into_iter().zip(hidden).collect(), lambda);
        }
    }
    Err(format!("no place where {} can be that large", word_of(cause)).into())
}

/// Draws a plant with two or three causes, each as large as it would be alone.
pub fn several(multiple: f64, seed: u64) -> Outcome<Made> {
    let kinds = robots::all()?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(u64::MAX);
    let robot = &kinds[seed as usize % kinds.len()];
    let ground = Ground::new(robot, false, seed, &mut rng)?;
    let (loads, duration) = (ground.loads()?, ground.campaign.duration_s());
    let wanted = rng.random_range(2..=3);
    let mut found: Vec<(HiddenEffect, Hidden, f64)> = Vec::new();
    for _ in 0..PLACES {
        if found.len() == wanted {
            break;
        }
        let cause = *TOGETHER.choose(&mut rng).unwrap_or(&HiddenEffect::Shift);
        let known = found.iter().any(|(other, ..)| *other == cause);
        let drawn = cause.draw(&ground.chain, (&robot.payloads, &loads), duration, &mut rng);
        let Some(hidden) = drawn.filter(|_| !known) else { continue };
        if let Some((size, _)) = ground.size(Some(cause), Some(&hidden), multiple)? {
            found.push((cause, hidden, size));
        }
    }
    if found.len() < wanted {
        return Err("no places for several causes".into());
    }
    let all: Vec<(&Hidden, f64)> = found.iter().map(|(_, hidden, size)| (hidden, *size)).collect();
    let plant = ground.plant(&all)?;
    ground.measured(plant, found.into_iter().map(|(cause, hidden, _)| (cause, hidden)).collect(), f64::NAN)
}

impl<'a> Ground<'a> {
    fn new(robot: &'a Robot, heavy: bool, seed: u64, rng: &mut ChaCha8Rng) -> Outcome<Self> {
        let visits = *[90, 120, 160].choose(rng).unwrap_or(&120);
        let chain = robot.chain()?;
        let campaign = robot.campaign(&chain, visits, seed)?;
        let hours = campaign.duration_s() / 3600.0 + 0.02;
        Ok(Ground { robot, chain, campaign, heavy, hours, seed })
    }

    fn undeclared(&self, hidden: Option<&Hidden>) -> Undeclared {
        hidden.map(|hidden| hidden.undeclared.clone()).unwrap_or_default()
    }

    /// With everything that is hidden, each of its size.
    fn plant(&self, hidden: &[(&Hidden, f64)]) -> Outcome<Plant> {
        let undeclared = self.undeclared(hidden.first().map(|(hidden, _)| *hidden));
        let mut options = self.robot.options(&self.chain, &undeclared, self.heavy, self.hours);
        for (hidden, size) in hidden {
            (hidden.install)(&mut options.errors, *size);
        }
        let plant = Plant::random(&self.chain, &options, self.seed)?;
        let wandering = hidden.iter().find_map(|(hidden, size)| Some((hidden.wobbles?, *size)));
        let Some((joint, size)) = wandering else { return Ok(plant) };
        let mut truth = plant.truth().clone();
        truth.joints[joint.index()].guideway = Some(self.wobble(joint, 1e-4 * size)?);
        Ok(plant.with_truth(truth)?)
    }

    /// The wandering of a turn's axis: sideways and in direction, m and rad.
    fn wobble(&self, joint: JointId, size: f64) -> Outcome<GuidewayProfile> {
        let described = self.chain.joint(joint);
        let axis = match described.placement {
            Placement::Origin { axis, .. } => axis.into_inner(),
            _ => Vector3::z(),
        };
        let (lower, upper) = described.limits.unwrap_or((-std::f64::consts::PI, std::f64::consts::PI));
        let across = |k: usize| if axis[k % 3].abs() > 0.5 { 0.0 } else { size };
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed ^ 0x77);
        let (size, period) = (std::array::from_fn(across), (upper - lower) / 7.0);
        Ok(GuidewayProfile::draw((lower, upper), period, size, &mut rng)?)
    }

    /// The largest load of each movable joint of the robot as described, N·m or N.
    fn loads(&self) -> Outcome<Vec<f64>> {
        let visits = self.campaign.visits.iter().take(60);
        let at = |visit: &Visit| Conditions::at(&self.chain, &visit.joints).with_load(visit.load);
        largest_loads(&self.chain, visits.map(at))
    }

    /// Standard deviations as they are, on the average.
    fn noise(&self, plant: &Plant, data: &Dataset) -> NoiseModel {
        let mean = |row: usize| plant.instrument.covariance(&data.measured_position(row)).trace() / 3.0;
        let square = (0..data.len()).map(mean).sum::<f64>() / data.len().max(1) as f64;
        NoiseModel {
            position_sd: square.sqrt(),
            visit_sd: plant.repeatability.sd,
            orientation_sd: plant.instrument.orientation_sd.unwrap_or(3e-4),
        }
    }

    /// λ of a size.
    fn lambda(&self, hidden: Option<&Hidden>, size: f64) -> Outcome<f64> {
        let one: Vec<(&Hidden, f64)> = hidden.into_iter().map(|hidden| (hidden, size)).collect();
        let real = self.plant(&one)?;
        let data = noise_free(&real).measure(&self.campaign, self.seed)?;
        let data = data.select(&hold_out(&data, HOLDOUT.0, HOLDOUT.1)?.0);
        let declared = self.undeclared(hidden).effects(&self.chain);
        let options = FitOptions {
            noise: NoiseSource::Fixed(self.noise(&real, &data)),
            // As good as none, but for directions that nothing excites.
            prior: PriorStrength::Fixed(1e3),
            max_iterations: 30,
            ..FitOptions::default()
        };
        Ok(fitted(&self.chain, &declared, &data, &options)?.chi_square)
    }

    /// The size with the required λ, and its λ; none where there is no such size.
    fn size(
        &self,
        cause: Option<HiddenEffect>,
        hidden: Option<&Hidden>,
        multiple: f64,
    ) -> Outcome<Option<(f64, f64)>> {
        let goal = DETECTABLE * multiple * multiple;
        let Some(cause) = cause else { return Ok(Some((0.0, self.lambda(None, 0.0)?))) };
        if cause == HiddenEffect::Outliers {
            let sd = self.robot.noise[0].hypot(self.robot.noise[1]);
            return Ok(Some((1e-3 * sd * goal.sqrt(), goal)));
        }
        let (mut size, mut before): (f64, Option<(f64, f64)>) = (0.1, None);
        for _ in 0..12 {
            // A plant that cannot carry its load is too soft.
            let Ok(lambda) = self.lambda(hidden, size) else {
                size *= 0.1;
                continue;
            };
            if lambda.is_nan() || lambda < 1e-9 {
                return Ok(None);
            }
            if (lambda / goal).ln().abs() < 0.05 {
                return Ok((size < LARGEST).then_some((size, lambda)));
            }
            let slope = before.map_or(2.0, |(s, l)| ((lambda / l).ln() / (size / s).ln()).clamp(0.7, 5.0));
            before = Some((size, lambda));
            size *= (goal / lambda).powf(1.0 / slope).clamp(1e-3, 1e3);
            if size > 10.0 * LARGEST {
                return Ok(None);
            }
        }
        Ok(None)
    }

    /// The campaign as it was measured. A plant that has outliers shows one at least where the loop may look.
    fn seen(&self, plant: &Plant) -> Outcome<Observation> {
        let wanted = plant.blunders.outlier_share > 0.0;
        for again in 0..PLACES {
            let seen = plant.observe(&self.campaign, self.seed + 17 + 1_000_003 * again)?;
            let (training, _) = hold_out(&seen.data, HOLDOUT.0, HOLDOUT.1)?;
            if !wanted || seen.outliers.iter().any(|row| training.contains(row)) {
                return Ok(seen);
            }
        }
        Err("no draw of the noise has an outlier in the training rows".into())
    }

    fn measured(self, plant: Plant, hidden: Vec<(HiddenEffect, Hidden)>, lambda: f64) -> Outcome<Made> {
        let seen = self.seen(&plant)?;
        let declared = self.undeclared(hidden.first().map(|(_, hidden)| hidden)).effects(&self.chain);
        Ok(Made {
            robot: self.robot.name.clone(),
            heavy: self.heavy,
            chain: self.chain,
            declared,
            plant,
            seen,
            hidden,
            lambda,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cause_is_as_large_as_was_asked_for() {
        for (cause, seed) in [(HiddenEffect::Shift, 1), (HiddenEffect::JointCompliance, 2)] {
            let made = make(Some(cause), 2.0, seed).expect("a plant");
            // λ = 30 · 2², reached within five per cent.
            assert!((made.lambda / 120.0).ln().abs() < 0.05, "{}: {}", cause.word(), made.lambda);
            assert!(made.hidden.len() == 1 && !made.seen.data.is_empty());
        }
    }

    #[test]
    fn the_declared_model_takes_in_all_that_a_null_has() {
        for seed in [1, 3, 5] {
            let null = make(None, 0.0, seed).expect("a plant");
            // A sixth of what is detectable: micrometres, of second order in the errors.
            assert!(null.lambda < 5.0, "{}: {}", null.robot, null.lambda);
        }
    }
}

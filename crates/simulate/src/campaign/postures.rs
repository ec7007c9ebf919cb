//! Where the robot is sent: within its limits, on a grid, along one axis, home again and again.

use super::Campaign;
use crate::SimulateError;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use truepose_kinematics::{Chain, JointId, JointKind};

impl Campaign {
    /// A Latin hypercube: each joint visits each of `count` equal parts of its range once.
    ///
    /// # Errors
    /// [`SimulateError::NoLimits`] for a slide without limits (a turn without limits has ±π).
    pub fn random(chain: &Chain, count: usize, seed: u64) -> Result<Self, SimulateError> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut postures = vec![Vec::new(); count];
        for (lower, upper) in limits(chain)? {
            let mut parts: Vec<usize> = (0..count).collect();
            parts.shuffle(&mut rng);
            for (posture, part) in postures.iter_mut().zip(parts) {
                let u = (part as f64 + rng.random::<f64>()) / count as f64;
                posture.push(lower + u * (upper - lower));
            }
        }
        Ok(Campaign::of(variables(chain, postures)))
    }

    /// Halton's sequence in the bases 2, 3, 5, …: evenly spread, without a seed, and longer ones contain shorter ones.
    ///
    /// # Errors
    /// [`SimulateError::NoLimits`] for a slide without limits.
    pub fn halton(chain: &Chain, count: usize) -> Result<Self, SimulateError> {
        let limits = limits(chain)?;
        let bases = primes(limits.len());
        let posture = |k: usize| {
            limits
                .iter()
                .zip(&bases)
                .map(move |((lower, upper), &base)| lower + radical_inverse(k, base) * (upper - lower))
        };
        Ok(Campaign::of(variables(chain, (1..=count).map(|k| posture(k).collect()).collect())))
    }

    /// All combinations of `points` values of each joint, evenly between its limits, ends included; the last
    /// joint runs fastest.
    ///
    /// # Errors
    /// [`SimulateError::NoLimits`] for a slide without limits, [`SimulateError::Size`] for fewer than two points.
    pub fn grid(chain: &Chain, points: usize) -> Result<Self, SimulateError> {
        if points < 2 {
            let value = points as f64;
            return Err(SimulateError::Size { what: "points of a grid", value, need: "two or more" });
        }
        let mut postures = vec![Vec::new()];
        for (lower, upper) in limits(chain)? {
            let value = |k: usize| lower + (upper - lower) * k as f64 / (points - 1) as f64;
            postures = postures
                .iter()
                .flat_map(|before: &Vec<f64>| {
                    (0..points).map(|k| before.iter().copied().chain([value(k)]).collect())
                })
                .collect();
        }
        Ok(Campaign::of(variables(chain, postures)))
    }

    /// One joint alone goes through `values` while the others stay at `home` (movable joints, rad or m).
    ///
    /// # Errors
    /// [`SimulateError::Unknown`] for a joint that the robot lacks or that does not move.
    pub fn sweep(
        chain: &Chain,
        home: &[f64],
        joint: &str,
        values: impl IntoIterator<Item = f64>,
    ) -> Result<Self, SimulateError> {
        let coordinate = chain.joint_named(joint).and_then(|j| chain.coordinate(j));
        let Some(coordinate) = coordinate else {
            let known = chain.movable().iter().map(|&j| chain.joint(j).name.clone()).collect();
            return Err(SimulateError::Unknown { what: "movable joint", name: joint.into(), known });
        };
        let posture = |value| {
            let mut joints = home.to_vec();
            joints[coordinate] = value;
            joints
        };
        Ok(Campaign::of(values.into_iter().map(posture).collect()))
    }

    /// `count` returns to `home`, each joint coming from either side at random.
    pub fn returns(home: &[f64], count: usize, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut campaign = Campaign::of(vec![home.to_vec(); count]);
        for visit in &mut campaign.visits {
            let side = |_| if rng.random::<bool>() { 1.0 } else { -1.0 };
            visit.approach = Some((0..home.len()).map(side).collect());
        }
        campaign
    }

    /// The middle of each joint's range, rad or m.
    ///
    /// # Errors
    /// [`SimulateError::NoLimits`] for a slide without limits.
    pub fn middle(chain: &Chain) -> Result<Vec<f64>, SimulateError> {
        let mut middle: Vec<f64> =
            limits(chain)?.into_iter().map(|(lower, upper)| (lower + upper) / 2.0).collect();
        chain.joints_from_controller(&mut middle);
        Ok(middle)
    }
}

/// Controller's values as the joints' variables.
pub(crate) fn variables(chain: &Chain, mut postures: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    postures.iter_mut().for_each(|posture| chain.joints_from_controller(posture));
    postures
}

/// Lower and upper limit of the controller's value of each movable joint; a turn without limits has ±π.
pub(crate) fn limits(chain: &Chain) -> Result<Vec<(f64, f64)>, SimulateError> {
    let range = |&id: &JointId| {
        let joint = chain.joint(id);
        match (chain.controller_limits(id), joint.kind) {
            (Some((lower, upper)), _) if lower.is_finite() && upper.is_finite() => Ok((lower, upper)),
            (_, JointKind::Revolute) => Ok((-std::f64::consts::PI, std::f64::consts::PI)),
            _ => Err(SimulateError::NoLimits { joint: joint.name.clone() }),
        }
    };
    chain.movable().iter().map(range).collect()
}

fn primes(count: usize) -> Vec<usize> {
    let mut found: Vec<usize> = Vec::new();
    let mut candidate = 2;
    while found.len() < count {
        if found.iter().all(|p| candidate % p != 0) {
            found.push(candidate);
        }
        candidate += 1;
    }
    found
}

/// The digits of k in this base, mirrored at the point.
fn radical_inverse(mut k: usize, base: usize) -> f64 {
    let (mut value, mut weight) = (0.0, 1.0 / base as f64);
    while k > 0 {
        value += (k % base) as f64 * weight;
        k /= base;
        weight /= base as f64;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::samples;

    #[test]
    fn a_latin_hypercube_visits_each_part_once() {
        let chain = samples::heavy();
        let campaign = Campaign::random(&chain, 50, 1).expect("a campaign");
        for joint in 0..6 {
            let mut parts: Vec<usize> =
                campaign.visits.iter().map(|v| ((v.joints[joint] + 2.0) / 4.0 * 50.0) as usize).collect();
            parts.sort_unstable();
            assert_eq!(parts, (0..50).collect::<Vec<_>>());
        }
        assert_ne!(campaign, Campaign::random(&chain, 50, 2).expect("a campaign"));
    }

    #[test]
    fn halton_is_known() {
        let values: Vec<f64> = (1..=5).map(|k| radical_inverse(k, 2)).collect();
        assert_eq!(values, [0.5, 0.25, 0.75, 0.125, 0.625]);
        assert_eq!(primes(5), [2, 3, 5, 7, 11]);
    }

    #[test]
    fn a_grid_has_its_corners() {
        let chain = samples::scara();
        let campaign = Campaign::grid(&chain, 3).expect("a campaign");
        assert_eq!(campaign.visits.len(), 81);
        assert_eq!(campaign.visits[0].joints[2].to_bits(), 0f64.to_bits());
        assert!((campaign.visits[80].joints[1] - 2.5).abs() < 1e-15);
    }

    #[test]
    fn a_sweep_moves_one_joint() {
        let chain = samples::ur10();
        let campaign = Campaign::sweep(&chain, &[0.1; 6], "j3", [0.5, 0.6]).expect("a campaign");
        assert_eq!(campaign.visits[1].joints, [0.1, 0.1, 0.6, 0.1, 0.1, 0.1]);
        assert!(matches!(
            Campaign::sweep(&chain, &[0.1; 6], "j9", [0.5]),
            Err(SimulateError::Unknown { .. })
        ));
    }
}

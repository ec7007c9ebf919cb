//! Loads and order: what is done to a set of postures before it is measured.

use super::{Campaign, Visit};
use nalgebra::Vector3;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use truepose_kinematics::{Load, Payload};

impl Campaign {
    /// These visits, then the other campaign's; targets, clock and channels are this one's.
    pub fn then(mut self, other: Campaign) -> Self {
        self.visits.extend(other.visits);
        self
    }

    /// All visits with the first payload (kg, centre of gravity in the tool frame, m), then all with the second, …
    pub fn with_each_payload(self, masses: &[f64], com: [f64; 3]) -> Self {
        let loaded = masses.iter().flat_map(|&mass| {
            let load = payload(mass, com);
            self.visits.iter().map(move |visit| Visit { load, ..visit.clone() })
        });
        Campaign { visits: loaded.collect(), ..self.clone() }
    }

    /// Each visit with one of these payloads, taken in turn, at a centre of gravity that is drawn for each visit:
    /// `com` ± up to `spread` in each direction, m.
    pub fn with_some_payload(mut self, masses: &[f64], com: [f64; 3], spread: f64, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for (k, visit) in self.visits.iter_mut().enumerate() {
            let centre = com.map(|c| c + spread * (2.0 * rng.random::<f64>() - 1.0));
            visit.load =
                masses.get(k % masses.len().max(1)).map_or(Load::None, |&mass| payload(mass, centre));
        }
        self
    }

    /// The whole campaign, `times` times.
    pub fn repeated(mut self, times: usize) -> Self {
        let once = self.visits.clone();
        self.visits = (0..times).flat_map(|_| once.iter().cloned()).collect();
        self
    }

    /// In random order.
    pub fn shuffled(mut self, seed: u64) -> Self {
        self.visits.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
        self
    }

    /// Direction in which each joint last moved before each visit: as given, or from the order (before the first
    /// move it is 0; a joint that stays keeps the direction of its last move).
    pub(crate) fn approaches(&self) -> Vec<Vec<f64>> {
        let mut last = self.visits.first().map_or_else(Vec::new, |visit| vec![0.0; visit.joints.len()]);
        let mut all: Vec<Vec<f64>> = Vec::with_capacity(self.visits.len());
        for (k, visit) in self.visits.iter().enumerate() {
            if let Some(given) = &visit.approach {
                last.clone_from(given);
            } else if k > 0 {
                for (j, side) in last.iter_mut().enumerate() {
                    let step = visit.joints[j] - self.visits[k - 1].joints[j];
                    if step.abs() > 1e-9 {
                        *side = step.signum();
                    }
                }
            }
            all.push(last.clone());
        }
        all
    }
}

/// A payload of no mass is one, so that a declared 0 kg stays declared.
fn payload(mass: f64, com: [f64; 3]) -> Load {
    Load::Payload(Payload { mass, com: Vector3::from(com) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn approach_follows_the_order() {
        let mut campaign = Campaign::of(vec![vec![0.0, 0.0], vec![1.0, 0.0], vec![0.5, 2.0], vec![0.5, 1.0]]);
        assert_eq!(
            campaign.approaches(),
            [[0.0, 0.0], [1.0, 0.0], [-1.0, 1.0], [-1.0, -1.0]].map(|a| a.to_vec())
        );
        campaign.visits[1].approach = Some(vec![-1.0, 1.0]);
        assert_eq!(campaign.approaches()[1], [-1.0, 1.0]);
    }

    #[test]
    fn payloads_multiply_and_shuffling_keeps_the_set() {
        let campaign = Campaign::of(vec![vec![0.0], vec![1.0], vec![2.0]]);
        let loaded = campaign.with_each_payload(&[0.0, 5.0], [0.0; 3]).repeated(2);
        assert_eq!(loaded.visits.len(), 12);
        let heavy = |c: &Campaign| {
            c.visits.iter().filter(|v| matches!(v.load, Load::Payload(p) if p.mass > 1.0)).count()
        };
        let shuffled = loaded.clone().shuffled(3);
        assert_eq!((heavy(&loaded), heavy(&shuffled)), (6, 6));
        assert_ne!(loaded, shuffled);
        assert_eq!(shuffled, loaded.shuffled(3));
    }
}

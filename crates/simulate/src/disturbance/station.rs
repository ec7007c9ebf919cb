//! An instrument whose stand moves: it drifts slowly, and is bumped now and then.
//!
//! ```text
//! y = s + R(ω_k)(p − s) + t_k        (t, ω)_k: a random walk over the poses, and steps at random poses
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | s | the instrument's station | m | measurement |
//! | t, ω | translation and rotation vector of the stand | m, rad | measurement |
//!
//! After n poses the walk has the standard deviation `drift` (`turn`) an axis. Source: Muralikrishnan, Phillips and Sawyer,
//! *Laser trackers for large-scale dimensional metrology: a review* (2016), section 5 (stability of the stand).

use super::wander::normal;
use nalgebra::{Point3, Translation3, UnitQuaternion, Vector3};
use rand::{Rng, RngExt};

/// How much the stand of the instrument moves.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StationMotion {
    /// Standard deviation of the walk at the end of the campaign, m an axis.
    pub drift: f64,
    /// The same of its rotation, rad an axis.
    pub turn: f64,
    /// How often it is bumped.
    pub steps: usize,
    /// Standard deviation of a bump, m an axis.
    pub step: f64,
    /// The same of its rotation, rad an axis.
    pub step_turn: f64,
}

/// Where the stand is at each pose.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct StationPath {
    station: Vector3<f64>,
    at: Vec<(Vector3<f64>, Vector3<f64>)>,
}

impl StationMotion {
    /// The way of the stand over these poses.
    pub(crate) fn path(&self, station: Vector3<f64>, poses: usize, rng: &mut impl Rng) -> StationPath {
        let scale = (poses.max(1) as f64).sqrt().recip();
        let three = |size: f64, rng: &mut _| Vector3::from_fn(|_, _| size * normal(rng));
        let (mut moved, mut turned) = (Vector3::zeros(), Vector3::zeros());
        let mut at = Vec::with_capacity(poses);
        for _ in 0..poses {
            moved += three(self.drift * scale, rng);
            turned += three(self.turn * scale, rng);
            at.push((moved, turned));
        }
        for _ in 0..self.steps {
            let from = rng.random_range(0..poses.max(1));
            let (moved, turned) = (three(self.step, rng), three(self.step_turn, rng));
            for place in at.iter_mut().skip(from) {
                place.0 += moved;
                place.1 += turned;
            }
        }
        StationPath { station, at }
    }
}

impl StationPath {
    /// Rotation of the stand at a pose.
    pub fn rotation(&self, pose: usize) -> UnitQuaternion<f64> {
        UnitQuaternion::from_scaled_axis(self.at[pose].1)
    }

    /// Where a point appears to be, m.
    pub fn seen(&self, pose: usize, point: &Vector3<f64>) -> Vector3<f64> {
        let about = Translation3::from(self.station + self.at[pose].0) * self.rotation(pose);
        (about * Point3::from(point - self.station)).coords
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn the_stand_moves_everything_as_one_body() {
        let motion = StationMotion { drift: 5e-5, turn: 2e-5, steps: 1, step: 1e-4, step_turn: 1e-5 };
        let station = Vector3::new(3.0, 1.0, 0.5);
        let path = motion.path(station, 50, &mut ChaCha8Rng::seed_from_u64(4));
        let (a, b) = (Vector3::new(0.2, 0.4, 1.0), Vector3::new(-0.7, 0.1, 0.3));
        for pose in [0, 20, 49] {
            let (p, q) = (path.seen(pose, &a), path.seen(pose, &b));
            assert!(((p - q).norm() - (a - b).norm()).abs() < 1e-14);
        }
        assert!((path.seen(49, &a) - a).norm() > 1e-6);
    }

    #[test]
    fn the_walk_reaches_its_deviation_and_a_bump_stays() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let walk = StationMotion { drift: 1e-4, ..StationMotion::default() };
        let ends = (0..4000).map(|_| walk.path(Vector3::zeros(), 30, &mut rng).at[29].0.norm_squared());
        let sd = (ends.sum::<f64>() / 12_000.0).sqrt();
        assert!((sd / 1e-4 - 1.0).abs() < 0.03, "{sd}");
        let bump = StationMotion { steps: 1, step: 1e-3, ..StationMotion::default() };
        let path = bump.path(Vector3::zeros(), 40, &mut rng);
        let different: Vec<usize> = (1..40).filter(|&k| path.at[k] != path.at[k - 1]).collect();
        assert!(different.len() <= 1, "{different:?}");
        assert!(path.at[39].0.norm() > 0.0);
    }
}

//! Directions: across one another, and about a middle.

use nalgebra::{Unit, Vector3};
use rand::{Rng, RngExt};
use std::f64::consts::TAU;

/// Whether two directions are within an angle, rad.
pub(super) fn within(a: &Vector3<f64>, b: &Vector3<f64>, most: f64) -> bool {
    a.angle(b) <= most
}

/// A unit vector within an angle of another, evenly over the cap of the sphere.
pub(super) fn around(about: &Vector3<f64>, most: f64, rng: &mut impl Rng) -> Vector3<f64> {
    let about = Unit::new_normalize(*about);
    let height = 1.0 - rng.random::<f64>() * (1.0 - most.cos());
    let (turn, side) = (TAU * rng.random::<f64>(), (1.0 - height * height).max(0.0).sqrt());
    let [first, second] = across(&about);
    about.into_inner() * height + (first * turn.cos() + second * turn.sin()) * side
}

/// Two unit vectors across a third.
pub(super) fn across(normal: &Unit<Vector3<f64>>) -> [Vector3<f64>; 2] {
    let first = Vector3::ith(normal.iamin(), 1.0).cross(normal).normalize();
    [first, normal.cross(&first)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn directions_fill_their_cap_evenly() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let about = Vector3::new(0.3, -0.2, 0.8);
        let all: Vec<Vector3<f64>> = (0..4000).map(|_| around(&about, 1.0, &mut rng)).collect();
        assert!(all.iter().all(|u| (u.norm() - 1.0).abs() < 1e-12 && within(u, &about, 1.0 + 1e-9)));
        // Heights are uniform between cos 1 and 1, so that half of them are above the middle: 50 % ± 3 deviations of 4000 draws.
        let middle = (1.0 + 1f64.cos()) / 2.0;
        let above = all.iter().filter(|u| u.dot(&about.normalize()) > middle).count();
        assert!((above as f64 / 4000.0 - 0.5).abs() < 0.024, "{above}");
    }
}

//! Where a point of the robot is brought to for an observation.

use super::camera::Camera;
use super::direction::around;
use super::thing::{Thing, What};
use crate::flaws::normal;
use nalgebra::{Isometry3, Point3, Vector3};
use rand::{Rng, RngExt};
use std::f64::consts::FRAC_PI_2;

/// A point of the tool, and where it is brought to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Aim {
    /// m, measurement frame.
    pub at: Vector3<f64>,
    /// m, tool axes; none: the target of the row.
    pub of: Option<Vector3<f64>>,
}

/// Part of an image, about its middle, in which a camera on the robot puts the middle of the points.
const MIDDLE: f64 = 0.5;

impl Thing {
    /// Where the robot goes for one observation at this time; none: anywhere. What scatters where things touch is in it. `up` is against gravity.
    pub(crate) fn aim(&self, time: f64, up: &Vector3<f64>, rng: &mut impl Rng) -> Option<Aim> {
        let touch = |at| Some(Aim { at, of: None });
        match self.what_at(time) {
            What::Socket(at) => touch(at + Vector3::from_fn(|_, _| self.sd * normal(rng))),
            What::Plate(plate) => {
                let [u, v] = plate.size.map(|size| size * (rng.random::<f64>() - 0.5));
                touch(plate.surface([u, v]) + plate.normal.into_inner() * (self.sd * normal(rng)))
            }
            What::Ball(ball) => {
                let (about, most) = ball.facing.unwrap_or((*up, FRAC_PI_2));
                let direction = around(&about, most, rng);
                touch(ball.centre + direction * (ball.radius + self.sd * normal(rng)))
            }
            What::Gauge(gauge) => gauge.travel.and_then(|travel| {
                let off = travel * (rng.random::<f64>() - 0.5);
                touch(gauge.zero + gauge.direction.into_inner() * off)
            }),
            What::Camera(camera) if camera.carried => Some(look(&camera, rng)),
            What::Camera(_) | What::Wire(_) | What::Series(_) => None,
        }
    }

    /// Whether an observation with the tool and the targets here is one to keep.
    pub(crate) fn keeps(&self, time: f64, tool: &Isometry3<f64>, targets: &[Vector3<f64>]) -> bool {
        match self.what_at(time) {
            What::Camera(camera) if camera.carried => camera.keeps(tool),
            what => targets.iter().any(|at| what.reading(at).is_some()),
        }
    }
}

/// What is in front of a camera on the robot comes to the middle of the points.
fn look(camera: &Camera, rng: &mut impl Rng) -> Aim {
    let [near, far] = camera.range;
    let depth = near + (far - near) * rng.random::<f64>();
    let [fx, fy, cx, cy] = camera.intrinsics;
    let mut beside = |size: f64, focal: f64, centre: f64| {
        (size * (0.5 + MIDDLE * (rng.random::<f64>() - 0.5)) - centre) / focal
    };
    let ahead = Point3::new(beside(camera.size[0], fx, cx), beside(camera.size[1], fy, cy), 1.0) * depth;
    Aim { at: camera.middle(), of: Some((camera.place * ahead).coords) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::{Ball, Plate};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn what_is_touched_scatters_across_its_surface_alone() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let centre = Vector3::new(0.4, 0.1, 0.2);
        let ball = Ball { centre, radius: 0.02, facing: None };
        let plate = Plate { middle: centre, normal: Vector3::z_axis(), size: [0.4, 0.2], bow: 0.0 };
        let thing = |what| Thing { number: 0, what, sd: 1e-4, targets: vec![None], moves: None };
        let mut aimed = |what: What| -> Vec<Vector3<f64>> {
            let thing = thing(what);
            (0..500).map(|_| thing.aim(0.0, &Vector3::z(), &mut rng).expect("an aim").at - centre).collect()
        };
        let deviation = |off: &[f64]| (off.iter().map(|v| v * v).sum::<f64>() / off.len() as f64).sqrt();
        let on_ball = aimed(What::Ball(ball));
        assert!(on_ball.iter().all(|at| at.z > -1e-3));
        // 10 % is three deviations of a standard deviation of 500.
        let off: Vec<f64> = on_ball.iter().map(|at| at.norm() - 0.02).collect();
        assert!((deviation(&off) / 1e-4 - 1.0).abs() < 0.1);
        let on_plate = aimed(What::Plate(plate));
        assert!(on_plate.iter().all(|at| at.x.abs().min(at.y.abs()) <= 0.1 && at.norm() < 0.23));
        let off: Vec<f64> = on_plate.iter().map(|at| at.z).collect();
        assert!((deviation(&off) / 1e-4 - 1.0).abs() < 0.1);
    }
}

//! The campaigns of the paper on its patient positioning system (joints d1 d2 d3 theta roll pitch).
//!
//! | set | what | visits |
//! | --- | --- | --- |
//! | a) | the 8 corners of the 50 × 50 × 40 cm treatment volume at the isocentre, θ = −90…90° by 30°, 0 and 154 lb | 112 |
//! | b) | each axis alone from home: d1 by 50 mm (45), d2 by 20 mm (28), d3 by 25 mm (59), θ by 5° (37), 0 and 154 lb | 338 |
//! | returns | home again and again | 270 |
//! | linearity | 0–300 lb by 25 lb at home | 13 |
//!
//! The isocentre is where the treatment point is at home. Its corners follow from the slides alone, since they carry
//! the turn: with p the corner in the tool frame at home and a the point of the turn's axis,
//! `d = isocentre − a − R_y(θ)(p − a)`. Source: the paper, "Experimental results"; the counts by axis are a
//! reconstruction from its totals.

use super::Campaign;
use crate::SimulateError;
use nalgebra::{UnitQuaternion, Vector3};
use truepose_kinematics::{Chain, Load, Payload};

/// The nominal treatment point in the tool frame, m.
pub const TREATMENT_POINT: [f64; 3] = [0.0, 0.09, -0.84];

/// One pound, kg.
pub const POUND: f64 = 0.453_592_37;

/// The load of a patient of this weight (lb) at the treatment point.
pub fn payload_at_treatment_point(pounds: f64) -> Load {
    Load::Payload(Payload { mass: pounds * POUND, com: Vector3::from(TREATMENT_POINT) })
}

impl Campaign {
    /// Set a): 56 configurations, first empty, then with 154 lb.
    ///
    /// # Errors
    /// [`SimulateError::Shape`] for a robot without six movable joints.
    pub fn paper_set_a(chain: &Chain) -> Result<Self, SimulateError> {
        six_joints(chain)?;
        let centre = Vector3::from(TREATMENT_POINT);
        let mut postures = Vec::new();
        for step in -3..=3 {
            let theta = f64::from(step) * 30f64.to_radians();
            let turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), theta);
            for corner in 0..8 {
                let side = |bit: i32, half: f64| if corner >> bit & 1 == 0 { -half } else { half };
                let point = centre + Vector3::new(side(0, 0.25), side(1, 0.20), side(2, 0.25));
                let d = centre - turn * point;
                postures.push(vec![d.x, d.y, d.z, theta, 0.0, 0.0]);
            }
        }
        Ok(empty_and_loaded(Campaign::of(postures)))
    }

    /// Set b): 169 configurations, first empty, then with 154 lb.
    ///
    /// # Errors
    /// [`SimulateError::Shape`] for a robot without six movable joints.
    pub fn paper_set_b(chain: &Chain) -> Result<Self, SimulateError> {
        six_joints(chain)?;
        let mut postures = Vec::new();
        let degrees = 5f64.to_radians();
        let axes = [
            (0, -1.1, 0.05, 45),
            (1, -0.27, 0.02, 28),
            (2, -1.16, 0.025, 59),
            (3, -18.0 * degrees, degrees, 37),
        ];
        for (joint, first, step, count) in axes {
            for k in 0..count {
                let mut joints = vec![0.0; 6];
                joints[joint] = first + step * f64::from(k);
                postures.push(joints);
            }
        }
        Ok(empty_and_loaded(Campaign::of(postures)))
    }

    /// 270 returns to home.
    pub fn paper_returns(seed: u64) -> Self {
        Campaign::returns(&[0.0; 6], 270, seed)
    }

    /// 0 to 300 lb in steps of 25 lb at home.
    pub fn paper_linearity() -> Self {
        let mut campaign = Campaign::of(vec![vec![0.0; 6]; 13]);
        for (k, visit) in campaign.visits.iter_mut().enumerate() {
            visit.load = payload_at_treatment_point(25.0 * k as f64);
        }
        campaign
    }
}

fn empty_and_loaded(campaign: Campaign) -> Campaign {
    campaign.with_each_payload(&[0.0, 154.0 * POUND], TREATMENT_POINT)
}

fn six_joints(chain: &Chain) -> Result<(), SimulateError> {
    match chain.movable().len() {
        6 => Ok(()),
        have => Err(SimulateError::Shape { what: "movable joints", have, need: 6 }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Plant;
    use truepose_kinematics::{Conditions, samples};

    #[test]
    fn the_sets_have_the_papers_sizes_and_keep_the_limits() {
        let chain = samples::pps();
        let a = Campaign::paper_set_a(&chain).expect("set a");
        let b = Campaign::paper_set_b(&chain).expect("set b");
        assert_eq!((a.visits.len(), b.visits.len()), (112, 338));
        assert_eq!(Campaign::paper_returns(1).visits.len(), 270);
        for visit in a.visits.iter().chain(&b.visits) {
            for (&id, q) in chain.movable().iter().zip(&visit.joints) {
                let (lower, upper) = chain.joint(id).limits.expect("limits");
                assert!((lower - 1e-9..=upper + 1e-9).contains(q), "{} at {q}", chain.joint(id).name);
            }
        }
        let last = Campaign::paper_linearity().visits[12].load;
        assert!(matches!(last, Load::Payload(p) if (p.mass - 136.0777).abs() < 1e-3));
    }

    #[test]
    fn set_a_brings_its_corners_to_the_isocentre() {
        let chain = samples::pps();
        let plant = Plant::perfect(&chain).expect("a plant");
        let centre = Vector3::from(TREATMENT_POINT);
        for visit in &Campaign::paper_set_a(&chain).expect("set a").visits {
            let pose = plant.true_pose(&Conditions::at(&chain, &visit.joints)).expect("a pose");
            let corner = pose.rotation.transpose() * (centre - pose.translation) - centre;
            let off = corner.abs() - Vector3::new(0.25, 0.20, 0.25);
            assert!(off.norm() < 1e-12, "{corner}");
        }
    }
}

//! A six-axis arm with all the usual causes at once.
//!
//! | part | plant | right names |
//! | --- | --- | --- |
//! | gears, every joint | an eccentric disc, its second harmonic, teeth that are no sine and swell once a turn | transmission, its joint |
//! | friction, every joint | Dahl or Maxwell slip: the path decides | backlash, its joint |
//! | hardening, loaded joints | τ = k θ (1 + (θ/θ_h)²) where the declared model has a constant compliance | joint_compliance or load_nonlinearity, its joint |
//! | masses | every link off by 10 % (σ) | joint_compliance, load_nonlinearity or payload |
//! | drift | the base, over the campaign, with housings and castings | drift, thermal or shift |
//!
//! The noise is that of the joints. All parts but masses and hardening have one scale, so that together they have the wanted size.

use super::hidden::Hidden;
use crate::prelude::*;
use std::f64::consts::TAU;
use truepose_simulate::physics::presliding::Presliding;
use truepose_simulate::physics::warming::WarmUp;

/// Numbers of poses.
pub const POSES: [usize; 3] = [150, 300, 1000];
/// What all of it leaves of the declared model, over the noise of a row.
pub const SIZES: [f64; 2] = [4.0, 12.0];

/// What there is one of for each joint, or for the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Share {
    Gears,
    Friction,
    Hardening,
    Masses,
    Drift,
}

/// One of the causes.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    pub share: Share,
    /// Place and name of the joint; none of the robot's.
    pub joint: Option<(usize, String)>,
}

impl Piece {
    /// Whether this is a right name for it.
    pub fn is_named(&self, family: &str, joint: Option<&str>) -> bool {
        let families: &[&str] = match self.share {
            Share::Gears => &["transmission"],
            Share::Friction => &["backlash"],
            Share::Hardening => &["joint_compliance", "load_nonlinearity"],
            Share::Masses => &["joint_compliance", "load_nonlinearity", "payload"],
            Share::Drift => &["drift", "thermal", "shift"],
        };
        let here = self.joint.as_ref().is_none_or(|(_, name)| joint == Some(name.as_str()));
        families.contains(&family) && here
    }
}

/// All parts, of the robot's joints with their largest loads.
pub fn pieces(chain: &Chain, loads: &[f64]) -> Vec<Piece> {
    let largest = loads.iter().copied().fold(0.0, f64::max);
    let mut pieces = Vec::new();
    for (k, &joint) in chain.movable().iter().enumerate() {
        let loaded = loads[k] > 0.1 * largest;
        let shares = [Share::Gears, Share::Friction, Share::Hardening];
        let of_joint = |share| Piece { share, joint: Some((joint.index(), name_of(chain, joint))) };
        pieces.extend(shares[..if loaded { 3 } else { 2 }].iter().copied().map(of_joint));
    }
    pieces.extend([Share::Masses, Share::Drift].map(|share| Piece { share, joint: None }));
    pieces
}

impl Hidden {
    /// Errors of all parts, or of the one that is there alone.
    pub fn amend_everything(&self, truth: &mut Truth, size: f64) -> Outcome {
        for (number, piece) in self.pieces.iter().enumerate() {
            // Every part has its own numbers, whichever others there are.
            let mut draw = Draw::of(self.u[0].to_bits() ^ number as u64, 0);
            if self.only.is_none_or(|only| only == number) {
                self.amend_piece(piece, truth, 1e-4 * size, &mut draw)?;
            }
        }
        Ok(())
    }

    fn amend_piece(&self, piece: &Piece, truth: &mut Truth, angle: f64, draw: &mut Draw) -> Outcome {
        let Some((place, _)) = piece.joint else {
            if piece.share == Share::Drift {
                let warm = WarmUp {
                    power: 1.0,
                    housing_s: self.duration * draw.between(0.05, 0.2),
                    casting_s: self.duration * draw.between(0.5, 2.0),
                    near: draw.between(0.2, 0.6),
                    cycle_s: f64::INFINITY,
                    working: 1.0,
                };
                let half = 0.5 * angle;
                let part = |k: usize| half * draw.normal() * if k < 3 { self.reach } else { 0.5 };
                let mover = Mover::Base([0, 1, 2, 3, 4, 5].map(part));
                truth.changes.push(Change { mover, amount: Amount::Curve(warm.rise(1.05 * self.duration)?) });
            }
            return Ok(());
        };
        let (joint, own) = (&mut truth.joints[place], self.joints.iter().find(|joint| joint.place == place));
        match piece.share {
            Share::Gears => {
                let own = angle * draw.logarithmic(0.2, 1.0);
                let second = TransmissionError::Mesh {
                    amplitude: own * draw.between(0.2, 0.7),
                    cycles: 2.0,
                    phase: draw.between(0.0, TAU),
                    sharpness: 0.3,
                    lean: 0.1,
                    runout: 0.0,
                    runout_phase: 0.0,
                };
                let teeth = draw.between(8.0, 120.0).round();
                joint.transmission.extend([
                    TransmissionError::Eccentric { ratio: own, phase: draw.between(0.0, TAU) },
                    second,
                    TransmissionError::mesh(own * draw.between(0.1, 0.4), teeth, draw.between(0.0, TAU)),
                ]);
            }
            Share::Friction => {
                let amplitude = angle * draw.logarithmic(0.1, 0.6);
                let [lower, upper] = own.map_or([-3.0, 3.0], |own| own.travel);
                let width = (upper - lower) * draw.logarithmic(0.003, 0.04);
                joint.presliding = Some(if draw.chance(0.5) {
                    Presliding::Dahl { amplitude, width }
                } else {
                    let widths = [0.3, 1.0, 4.0].map(|part| part * width).to_vec();
                    Presliding::MaxwellSlip { amplitude, widths, parts: vec![0.5, 0.3, 0.2] }
                });
            }
            Share::Hardening => {
                // Where its load would be twice the linear one: near its largest deflection.
                let deflection = own.map_or(0.0, |own| own.load) / joint.stiffness.drive;
                if deflection > 0.0 {
                    joint.stiffness.hardens_at = deflection * draw.between(0.4, 1.5);
                }
            }
            Share::Masses | Share::Drift => {}
        }
        Ok(())
    }
}

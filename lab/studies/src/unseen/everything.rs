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
use super::pieces::{Piece, Share};
use super::stream::Draw;
use std::error::Error;
use truepose_simulate::Truth;
use truepose_simulate::physics::changes::{Amount, Change, Mover};
use truepose_simulate::physics::presliding::Presliding;
use truepose_simulate::physics::transmission::TransmissionError;
use truepose_simulate::physics::warming::WarmUp;

/// Numbers of poses.
pub const POSES: [usize; 3] = [150, 300, 1000];
/// What all of it leaves of the declared model, over the noise of a row.
pub const SIZES: [f64; 2] = [4.0, 12.0];

impl Hidden {
    /// Errors of all parts, or of the one that is asked for.
    pub fn amend_everything(&self, truth: &mut Truth, size: f64) -> Result<(), Box<dyn Error>> {
        for (number, piece) in self.pieces.iter().enumerate() {
            // Every part has its own numbers, whichever others there are.
            let mut draw = Draw::of(self.u[0].to_bits() ^ number as u64, 0);
            if self.only.is_none_or(|only| only == number) {
                self.amend_piece(piece, truth, 1e-4 * size, &mut draw)?;
            }
        }
        Ok(())
    }

    /// Whether link masses are off.
    pub fn masses_are_off(&self) -> bool {
        let is = |number: &usize| self.pieces[*number].share == Share::Masses;
        self.only.as_ref().map_or(!self.pieces.is_empty(), is)
    }

    fn amend_piece(
        &self,
        piece: &Piece,
        truth: &mut Truth,
        angle: f64,
        draw: &mut Draw,
    ) -> Result<(), Box<dyn Error>> {
        let turn = std::f64::consts::TAU;
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
                let mut part = |k: usize| half * draw.normal() * if k < 3 { self.reach } else { 0.5 };
                let mover = Mover::Base([0, 1, 2, 3, 4, 5].map(&mut part));
                truth.changes.push(Change { mover, amount: Amount::Curve(warm.rise(1.05 * self.duration)?) });
            }
            return Ok(());
        };
        let joint = &mut truth.joints[place];
        match piece.share {
            Share::Gears => {
                let own = angle * draw.logarithmic(0.2, 1.0);
                let second = TransmissionError::Mesh {
                    amplitude: own * draw.between(0.2, 0.7),
                    cycles: 2.0,
                    phase: draw.between(0.0, turn),
                    sharpness: 0.3,
                    lean: 0.1,
                    runout: 0.0,
                    runout_phase: 0.0,
                };
                let teeth = draw.between(8.0, 120.0).round();
                joint.transmission.extend([
                    TransmissionError::Eccentric { ratio: own, phase: draw.between(0.0, turn) },
                    second,
                    TransmissionError::mesh(own * draw.between(0.1, 0.4), teeth, draw.between(0.0, turn)),
                ]);
            }
            Share::Friction => {
                let amplitude = angle * draw.logarithmic(0.1, 0.6);
                let [lower, upper] = self.travel(place);
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
                let load =
                    self.loads.iter().find(|(joint, _)| *joint == place).map_or(0.0, |(_, load)| *load);
                let deflection = load / joint.stiffness.drive;
                if deflection > 0.0 {
                    joint.stiffness.hardens_at = deflection * draw.between(0.4, 1.5);
                }
            }
            Share::Masses | Share::Drift => {}
        }
        Ok(())
    }

    fn travel(&self, place: usize) -> [f64; 2] {
        self.travels.iter().find(|(joint, _)| *joint == place).map_or([-3.0, 3.0], |(_, travel)| *travel)
    }
}

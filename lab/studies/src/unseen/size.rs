//! The size of a cause: what the declared model cannot absorb of it.
//!
//! The model is fitted to a dense noise-free campaign (`REFERENCE` poses, in the same order and time); the 3-D RMS of what
//! remains is a multiple of the 3-D RMS of one row's noise. So it does not depend on how many poses are measured.

use super::hidden::{Hidden, Piece};
use super::plant::Ground;
use super::stream::Part;
use crate::prelude::*;

/// Poses of the dense campaign.
const REFERENCE: usize = 200;
/// Draws of a place for a cause before there is none at which it can be as large.
const PLACES: usize = 12;
/// A cause of more than this many times its usual size is none that a machine would have.
const LARGEST: f64 = 60.0;

/// A cause with its size.
pub struct SizedCause {
    pub hidden: Hidden,
    /// Multiple of its usual size.
    pub size: f64,
    /// What the declared model cannot absorb of it, over the noise of a row.
    pub reached: f64,
}

impl Ground<'_> {
    /// The cause with the wanted size.
    pub fn cause(&self, floor: f64) -> Outcome<Option<SizedCause>> {
        let Some(cause) = self.what.cause else { return Ok(None) };
        let mut draw = self.key.draw(Part::Cause);
        let reference = self.clocked(self.campaign(REFERENCE, 0, Part::Reference)?);
        for _ in 0..PLACES {
            let duration = self.campaign.duration_s();
            let Some(hidden) = Hidden::draw(cause, &self.robot, &self.loads, duration, &mut draw) else {
                continue;
            };
            if cause.has_a_size_of_its_own() {
                let nothing = self.left(&hidden, None, &reference)?;
                let left = self.left(&hidden, Some(1.0), &reference)?;
                return Ok(Some(SizedCause { hidden, size: 1.0, reached: without(left, nothing) / floor }));
            }
            if let Some((size, left)) = self.size(&hidden, &reference, floor)? {
                return Ok(Some(SizedCause { hidden, size, reached: left / floor }));
            }
        }
        Err(format!("no place where {} can be that large", cause.word()).into())
    }

    /// Each of several causes at once with what the declared model cannot absorb of it alone, over the noise; the largest first.
    pub fn pieces(&self, cause: &SizedCause, floor: f64) -> Outcome<Vec<(Piece, f64)>> {
        let reference = self.clocked(self.campaign(REFERENCE, 0, Part::Reference)?);
        let nothing = self.left(&cause.hidden, None, &reference)?;
        let one = |(number, piece): (usize, &Piece)| -> Outcome<(Piece, f64)> {
            let hidden = Hidden { only: Some(number), ..cause.hidden.clone() };
            let left = self.left(&hidden, Some(cause.size), &reference)?;
            Ok((piece.clone(), without(left, nothing) / floor))
        };
        let mut pieces = cause.hidden.pieces.iter().enumerate().map(one).collect::<Result<Vec<_>, _>>()?;
        pieces.sort_by(|a, b| b.1.total_cmp(&a.1));
        Ok(pieces)
    }

    fn size(&self, hidden: &Hidden, reference: &Campaign, floor: f64) -> Outcome<Option<(f64, f64)>> {
        let goal = self.what.size * floor;
        let nothing = self.left(hidden, None, reference)?;
        let (mut size, mut before): (f64, Option<(f64, f64)>) = (1.0, None);
        for _ in 0..10 {
            // A plant that cannot carry its load is too compliant.
            let Ok(left) = self.left(hidden, Some(size), reference) else {
                size *= 0.2;
                continue;
            };
            // What the declared model leaves of the robot without the cause is no part of it.
            let left = without(left, nothing);
            if left < 1e-10 {
                return Ok(None);
            }
            if (left / goal).ln().abs() < 0.03 {
                return Ok((size < LARGEST).then_some((size, left)));
            }
            let slope = before
                .filter(|(s, _)| (size / s).ln().abs() > 1e-6)
                .map_or(1.0, |(s, l): (f64, f64)| ((left / l).ln() / (size / s).ln()).clamp(0.4, 3.0));
            before = Some((size, left));
            size *= (goal / left).powf(1.0 / slope).clamp(1e-2, 1e2);
            if size > 4.0 * LARGEST {
                return Ok(None);
            }
        }
        Ok(None)
    }

    /// What the declared model leaves of a noise-free campaign, 3-D RMS, m.
    fn left(&self, hidden: &Hidden, size: Option<f64>, reference: &Campaign) -> Outcome<f64> {
        let plant = self.quiet(size.map(|size| (hidden, size)))?;
        let data = plant.measure(reference, self.key.seed(Part::Reference))?;
        let options = FitOptions {
            noise: NoiseSource::Fixed(NoiseModel { position_sd: 1e-5, visit_sd: 0.0, orientation_sd: 1e-4 }),
            // As good as none, but for directions that nothing excites.
            prior: PriorStrength::Fixed(1e3),
            max_iterations: 20,
            ..FitOptions::default()
        };
        let found = fitted(&self.robot.chain, &self.declared(Some(hidden)), &data, &options)?;
        Ok(Residuals::of(&found.fitted, &data)?.positions().rms)
    }
}

/// What is left without a part of it that is independent.
pub(super) fn without(all: f64, part: f64) -> f64 {
    (all * all - part * part).max(0.0).sqrt()
}

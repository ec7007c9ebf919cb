//! What the distinct values of a joint can tell of a function of that joint.
//!
//! A joint of a grid stands at few values. A function of it is known there and nowhere else: L values determine L numbers, of which the rest of
//! the model takes at least one, and between two neighbouring values anything may be. Folds leave out poses and never a whole value, so that
//! no cross-validation notices. The limits are those of sampling: a wave has to have two samples to a cycle (Shannon 1949), and a series
//! fewer coefficients than there are values.

use truepose_errormodel::Dataset;
use truepose_kinematics::{Chain, JointId};

/// Distinct values below which no period is searched: any of so few is explained by some period. Convention.
const FEWEST_FOR_PERIODS: usize = 12;
/// Coefficients of a cubic curve beside one for each piece.
const OF_A_CUBIC: usize = 3;
/// Values by which those have to outnumber the coefficients of a series or curve: the mean, and three by which it is tested.
const SPARE: usize = 4;
/// Ratio of the largest to the smallest step up to which values are equally spaced. Convention.
const EQUAL: f64 = 1.5;

/// The distinct values of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Levels {
    /// How many there are; those closer than the tolerance of a repeated configuration are one.
    pub count: usize,
    /// The step from one to the next, rad or m, where they are equally spaced.
    pub step: Option<f64>,
}

impl Levels {
    pub(crate) fn of(chain: &Chain, data: &Dataset, joint: JointId) -> Self {
        let Some(column) = chain.coordinate(joint) else { return Levels { count: 0, step: None } };
        Levels::among(data.joints[column].clone(), data.dwell.repeat_tolerance(column))
    }

    fn among(mut values: Vec<f64>, same: f64) -> Self {
        values.sort_by(f64::total_cmp);
        values.dedup_by(|next, first| *next - *first <= same);
        let steps = || values.windows(2).map(|pair| pair[1] - pair[0]);
        let [least, most] = steps().fold([f64::INFINITY, 0.0], |[a, b], step| [a.min(step), b.max(step)]);
        let step = (values.len() > 2 && most <= EQUAL * least)
            .then(|| (values[values.len() - 1] - values[0]) / (values.len() - 1) as f64);
        Levels { count: values.len(), step }
    }

    /// The shortest period that can be told from longer ones, rad or m; infinite where none can.
    pub fn shortest_period(&self) -> f64 {
        match self.step {
            _ if self.count < FEWEST_FOR_PERIODS => f64::INFINITY,
            Some(step) => 2.0 * step,
            None => 0.0,
        }
    }

    /// Whether they determine a function of the joint with so many coefficients.
    pub fn determine(&self, coefficients: usize) -> bool {
        self.count >= coefficients + SPARE
    }

    /// Whether they determine a series of so many harmonics of a turn.
    pub fn determine_harmonics(&self, harmonics: &[u32]) -> bool {
        let highest = harmonics.iter().max().map_or(0, |h| *h as usize);
        self.determine(2 * harmonics.len()) && self.count > 2 * highest
    }

    /// Whether they determine a cubic curve of so many pieces.
    pub fn determine_curve(&self, pieces: usize) -> bool {
        self.determine(pieces + OF_A_CUBIC)
    }

    /// How many it takes to look for a period, or for a curve of the joint itself.
    pub fn wanted(&self) -> usize {
        FEWEST_FOR_PERIODS
    }

    /// Whether a periodic error or a curve of the joint itself can be looked for.
    pub fn are_enough(&self) -> bool {
        self.count >= FEWEST_FOR_PERIODS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_values_tell_no_period_and_equal_steps_none_below_two_of_them() {
        let of = |values: Vec<f64>| Levels::among(values, 1e-4);
        let four = of((0..40).map(|k| f64::from(k % 4)).collect());
        assert_eq!(four.count, 4);
        assert!(four.shortest_period().is_infinite() && !four.determine_curve(1));
        assert!(!four.determine_harmonics(&[1]));
        let grid = of((0..60).map(|k| 0.1 * f64::from(k % 20)).collect());
        assert!((grid.shortest_period() - 0.2).abs() < 1e-9);
        assert!(grid.determine_curve(8) && grid.determine_harmonics(&[1, 2, 3, 4]));
        // Steps of all sizes: no two periods look alike.
        let free = of((0..60).map(|k| (0.618 * f64::from(k)).fract()).collect());
        assert_eq!((free.count, free.shortest_period()), (60, 0.0));
        // Encoders flicker: what is closer than the tolerance is one value.
        assert_eq!(of(vec![0.0, 5e-5, 1.0, 1.00005, 2.0]).count, 3);
    }
}

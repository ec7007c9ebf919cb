//! Configurations of a robot: a measurement campaign, and other configurations of the same region.

use crate::prelude::*;

/// How a campaign goes through the joint space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum Style {
    /// Anywhere within the limits.
    Random,
    /// From one posture, one joint after the other.
    Swept,
    /// A twentieth to an eighth of each joint's range: weak.
    Small,
    /// Some points of an even grid, in order.
    Grid,
}

/// In turn: three in five go through the whole range without order.
pub const STYLES: [Style; 5] = [Style::Random, Style::Swept, Style::Small, Style::Grid, Style::Random];

/// A region of the joint space, with the way through it.
pub struct Region {
    style: Style,
    /// Middle and half width of each joint, rad or m.
    box_of: Vec<(f64, f64)>,
    limits: Vec<(f64, f64)>,
    levels: usize,
}

impl Region {
    pub fn of(style: Style, chain: &Chain, draw: &mut Draw) -> Self {
        let limits: Vec<(f64, f64)> =
            chain.movable().iter().map(|&joint| chain.joint(joint).limits.unwrap_or((-3.0, 3.0))).collect();
        // Shares of the range: of a random campaign, of a sweep's other joints, of a small region.
        let share = match style {
            Style::Small => draw.logarithmic(0.05, 0.125),
            _ => draw.between(0.5, 0.95),
        };
        let box_of = limits
            .iter()
            .map(|&(lower, upper)| {
                let half = 0.5 * share * (upper - lower);
                (draw.between(lower + half, upper - half), half)
            })
            .collect();
        Region { style, box_of, limits, levels: 3 + draw.below(2) }
    }

    /// What is measured, in its order.
    pub fn measured(&self, count: usize, draw: &mut Draw) -> Vec<Vec<f64>> {
        let n = self.box_of.len();
        match self.style {
            Style::Swept => (0..count)
                .map(|k| {
                    let (joint, within) = (k * n / count, (k * n % count) as f64 / count as f64);
                    let mut posture = self.middle();
                    posture[joint] += self.box_of[joint].1 * (2.0 * within - 1.0);
                    posture
                })
                .collect(),
            Style::Grid => {
                let mut points: Vec<Vec<usize>> =
                    (0..count).map(|_| (0..n).map(|_| draw.below(self.levels)).collect()).collect();
                points.sort();
                let value = |(j, &level): (usize, &usize)| {
                    let (middle, half) = self.box_of[j];
                    middle + half * (2.0 * level as f64 / (self.levels - 1) as f64 - 1.0)
                };
                points.iter().map(|point| point.iter().enumerate().map(value).collect()).collect()
            }
            _ => (0..count).map(|_| self.anywhere(draw)).collect(),
        }
    }

    /// Configurations of the same region that were not measured: on the sweeps of a swept one, in the box of any other.
    pub fn fresh(&self, count: usize, draw: &mut Draw) -> Vec<Vec<f64>> {
        (0..count)
            .map(|k| {
                let anywhere = self.anywhere(draw);
                if self.style != Style::Swept {
                    return anywhere;
                }
                let mut posture = self.middle();
                let joint = k % posture.len();
                posture[joint] = anywhere[joint];
                posture
            })
            .collect()
    }

    /// A configuration far from all others: in a corner of the limits, as far from the region's middle as can be.
    pub fn far(&self, draw: &mut Draw) -> Vec<f64> {
        self.limits
            .iter()
            .zip(&self.box_of)
            .map(|(&(lower, upper), &(middle, _))| {
                let corner = if upper - middle > middle - lower { upper } else { lower };
                middle + (corner - middle) * draw.between(0.85, 1.0)
            })
            .collect()
    }

    fn middle(&self) -> Vec<f64> {
        self.box_of.iter().map(|&(middle, _)| middle).collect()
    }

    fn anywhere(&self, draw: &mut Draw) -> Vec<f64> {
        self.box_of.iter().map(|&(middle, half)| middle + half * draw.between(-1.0, 1.0)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::robots::Stream;
    use super::*;

    #[test]
    fn what_is_fresh_lies_where_was_measured() {
        let chain = samples::heavy();
        for style in STYLES {
            let mut draw = Stream::Visits.draw(3);
            let region = Region::of(style, &chain, &mut draw);
            let measured = region.measured(200, &mut draw);
            assert_eq!(measured.len(), 200);
            let far = region.far(&mut draw);
            for joint in 0..6 {
                let values = || measured.iter().map(|q| q[joint]);
                let (low, high) = (values().fold(f64::MAX, f64::min), values().fold(f64::MIN, f64::max));
                // Two hundred even draws leave a hundredth of their range at either end more often than not.
                let margin = 0.05 * (high - low);
                for q in region.fresh(50, &mut draw) {
                    assert!(
                        (low - margin..=high + margin).contains(&q[joint]),
                        "{style:?} {low} {high} {q:?}"
                    );
                }
                assert!(chain.movable().len() == 6 && (-2.0..=2.0).contains(&far[joint]));
            }
        }
    }

    #[test]
    fn a_sweep_moves_one_joint_and_a_grid_keeps_its_order() {
        let chain = samples::heavy();
        let mut draw = Stream::Visits.draw(4);
        let swept = Region::of(Style::Swept, &chain, &mut draw).measured(60, &mut draw);
        let moves = |pair: &[Vec<f64>]| (0..6).filter(|&j| (pair[1][j] - pair[0][j]).abs() > 1e-12).count();
        assert!(swept.windows(2).all(|pair| moves(pair) <= 2));
        let grid = Region::of(Style::Grid, &chain, &mut draw).measured(60, &mut draw);
        assert!(grid.windows(2).all(|pair| pair[0] <= pair[1]));
    }
}

//! A chart of a value over two inputs: cells, each as strong as the value is large.

use super::axes::{Plot, frame};
use super::escape;
use crate::significant;
use std::fmt::Write;

/// Cells along each input, so that one holds six rows on average.
pub(crate) fn cells_for(rows: usize) -> usize {
    ((rows as f64 / 6.0).sqrt() as usize).clamp(4, 12)
}

/// A value for each cell of a plane, row by row from below; none where nothing was measured.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Chart {
    /// Range of the input across and of the input upwards.
    pub x: [f64; 2],
    /// The same upwards.
    pub y: [f64; 2],
    /// Cells along each input.
    pub along: usize,
    /// `along` × `along` values.
    pub values: Vec<Option<f64>>,
}

impl Chart {
    /// Root of the mean square of `value` in each cell; what is not finite is left out.
    pub(crate) fn rms(x: &[f64], y: &[f64], value: &[f64], along: usize) -> Self {
        let (range_x, range_y) = (range(x), range(y));
        let mut sums = vec![(0.0, 0usize); along * along];
        for ((&x, &y), &v) in x.iter().zip(y).zip(value) {
            if let (Some(column), Some(row), true) =
                (cell(x, range_x, along), cell(y, range_y, along), v.is_finite())
            {
                let at = &mut sums[row * along + column];
                *at = (at.0 + v * v, at.1 + 1);
            }
        }
        let values = sums.iter().map(|(sum, n)| (*n > 0).then(|| (sum / *n as f64).sqrt())).collect();
        Chart { x: range_x, y: range_y, along, values }
    }

    /// The largest value.
    pub(crate) fn most(&self) -> f64 {
        self.values.iter().flatten().copied().fold(0.0, f64::max)
    }
}

/// Which cell a value falls into.
pub(crate) fn cell(value: f64, [low, high]: [f64; 2], along: usize) -> Option<usize> {
    if !value.is_finite() || high <= low {
        return None;
    }
    Some((((value - low) / (high - low) * along as f64) as usize).min(along - 1))
}

/// Smallest and largest of what is finite.
pub(crate) fn range(values: &[f64]) -> [f64; 2] {
    let finite = || values.iter().copied().filter(|v| v.is_finite());
    [finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max)]
}

/// The chart with its axes; strongest is `most`, in this colour class.
pub(crate) fn chart(
    about: &str,
    title: &str,
    names: [&str; 2],
    of: &Chart,
    most: f64,
    class: &str,
) -> String {
    const WIDTH: f64 = 360.0;
    const HEIGHT: f64 = 320.0;
    let mut plot = Plot::new(WIDTH, HEIGHT, of.x, of.y).axes(title, names[0], names[1]);
    let step = |[low, high]: [f64; 2], k: usize| low + (high - low) * k as f64 / of.along as f64;
    for (k, value) in of.values.iter().enumerate() {
        let Some(value) = value else { continue };
        let (row, column) = (k / of.along, k % of.along);
        let corners = [[step(of.x, column), step(of.y, row)], [step(of.x, column + 1), step(of.y, row + 1)]];
        plot.cell(
            class,
            corners,
            (value / most.max(f64::MIN_POSITIVE)).clamp(0.05, 1.0),
            &format!("{} mm", significant(*value, 3)),
        );
    }
    let mut body = plot.panel([0.0, 0.0]);
    for k in 0..5 {
        let x = 58.0 + 16.0 * f64::from(k);
        let fraction = f64::from(k + 1) / 5.0;
        let _ = write!(
            body,
            "<rect class=\"{class}\" x=\"{x}\" y=\"{}\" width=\"16\" height=\"10\" opacity=\"{fraction:.2}\"/>",
            HEIGHT + 4.0
        );
    }
    let _ = write!(
        body,
        "<text class=\"soft\" x=\"146\" y=\"{}\">up to {} mm</text>",
        HEIGHT + 13.0,
        escape(&significant(most, 3))
    );
    frame(WIDTH, HEIGHT + 22.0, about, &body)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_hold_the_root_mean_square_of_what_falls_into_them() {
        let x = [0.0, 0.1, 12.0, 5.0];
        let y = [0.0, 0.1, 12.0, f64::NAN];
        let chart = Chart::rms(&x, &y, &[3.0, 4.0, 2.0, 9.0], 12);
        assert_eq!(chart.values[0], Some((12.5f64).sqrt()));
        assert_eq!(chart.values[12 * 12 - 1], Some(2.0));
        assert_eq!(chart.values.iter().flatten().count(), 2);
        assert!((chart.most() - 12.5f64.sqrt()).abs() < 1e-12);
    }
}

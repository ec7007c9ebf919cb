//! By how much one clock is late against another: the shift at which the speeds of joints and position correlate most.
//!
//! Moving or not counts, rather than how fast: how much faster a point is than the joints changes from posture to posture. So each speed v
//! is v / (v + v₀), with v₀ a tenth of its 90 % quantile, less its mean.

use super::streams::{Streams, median_step};

/// Largest lag that is looked for, s.
const MOST: f64 = 2.0;
/// Grid of the speeds, s, at the finest: a lag is found to a small part of it.
const FINEST: f64 = 4e-3;
/// Over how long a speed is taken, s: derivatives of what scatters correlate with nothing.
const WIDTH: f64 = 0.05;
/// Grid points without which nothing is known.
const FEWEST: usize = 16;
/// Part of the 90 % quantile of a speed from which on the robot moves.
const SLOW: f64 = 0.1;

/// The lag of the positions behind the joints, s, and the correlation there; both 0 of too few samples.
pub(super) fn lag(streams: &Streams<'_>) -> (f64, f64) {
    let (tq, tp) = (streams.joint_times, streams.position_times);
    if tq.len() < 4 || tp.len() < 4 {
        return (0.0, 0.0);
    }
    let step = median_step(tq).min(median_step(tp)).max(FINEST);
    let (begin, end) = (tq[0].max(tp[0]), tq[tq.len() - 1].min(tp[tp.len() - 1]));
    let count = ((end - begin) / step) as usize;
    if count < FEWEST {
        return (0.0, 0.0);
    }
    let grid: Vec<f64> = (0..count).map(|k| begin + step * k as f64).collect();
    let width = ((WIDTH / step).round() as usize).max(1);
    let of_positions: Vec<Vec<f64>> =
        (0..3).map(|axis| streams.positions.iter().map(|p| p[axis]).collect()).collect();
    let a = speed(&grid, width, tq, streams.joints);
    let b = speed(&grid, width, tp, &of_positions);
    let square = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>();
    let scale = (square(&a) * square(&b)).sqrt();
    if a.is_empty() || scale <= 0.0 {
        return (0.0, 0.0);
    }
    let most = (a.len() / 2).min((MOST / step).round() as usize) as isize;
    let at = |shift: isize| {
        let (x, y) = match shift >= 0 {
            true => (&a[..a.len() - shift as usize], &b[shift as usize..]),
            false => (&a[-shift as usize..], &b[..b.len() - (-shift) as usize]),
        };
        x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>() / scale
    };
    let values: Vec<f64> = (-most..=most).map(at).collect();
    let best = (0..values.len()).max_by(|&i, &j| values[i].total_cmp(&values[j])).unwrap_or(0);
    let mut shift = best as f64 - most as f64;
    if best > 0 && best + 1 < values.len() {
        let (left, middle, right) = (values[best - 1], values[best], values[best + 1]);
        let bend = left - 2.0 * middle + right;
        if bend < 0.0 {
            shift += 0.5 * (left - right) / bend;
        }
    }
    (shift * step, values[best])
}

/// How much columns move over so many grid points, between 0 and 1, less the mean.
fn speed(grid: &[f64], width: usize, times: &[f64], columns: &[Vec<f64>]) -> Vec<f64> {
    if grid.len() <= width {
        return Vec::new();
    }
    let mut squares = vec![0.0; grid.len() - width];
    for column in columns {
        let even = interpolated(grid, times, column);
        for (k, square) in squares.iter_mut().enumerate() {
            *square += (even[k + width] - even[k]).powi(2);
        }
    }
    let mut moved: Vec<f64> = squares.into_iter().map(f64::sqrt).collect();
    let mut sorted = moved.clone();
    let nine = (0.9 * (sorted.len() - 1) as f64) as usize;
    let slow = SLOW * *sorted.select_nth_unstable_by(nine, f64::total_cmp).1;
    if slow > 0.0 {
        moved.iter_mut().for_each(|v| *v /= *v + slow);
    }
    let mean = moved.iter().sum::<f64>() / moved.len() as f64;
    moved.iter_mut().for_each(|v| *v -= mean);
    moved
}

/// A column at the times of the grid, which ascend as its own do.
fn interpolated(grid: &[f64], times: &[f64], column: &[f64]) -> Vec<f64> {
    let mut k = 0;
    let one = |&t: &f64| {
        while k + 2 < times.len() && times[k + 1] <= t {
            k += 1;
        }
        let span = times[k + 1] - times[k];
        let part = if span > 0.0 { ((t - times[k]) / span).clamp(0.0, 1.0) } else { 0.0 };
        column[k] + part * (column[k + 1] - column[k])
    };
    grid.iter().map(one).collect()
}

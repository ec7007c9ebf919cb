//! The least standard deviation that measured positions can have.
//!
//! A position that was rounded to a step h has a standard deviation of h/√12 at the least, whatever its residuals are: rows that are alike to the
//! last digit of the file do not scatter by nothing. What a few residuals happen to leave is therefore bounded from below.
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | h | step of the numbers: the largest power of ten of a metre or an inch that all of them are multiples of | m |
//! | s | standard deviation that the instrument states, 0 where it states none | m |
//! | ρ | repeatability, shared by a visit | m |
//!
//! ```text
//! s² + τ² ≥ max(h²/12, (ρ/1000)²)
//! ```
//!
//! The second bound is one of arithmetic: whitening takes ρ out of a visit by the difference of two numbers that are (ρ/σ)² as large as what
//! is left. No instrument is a thousand times as good as the robot repeats.

use truepose_errormodel::Dataset;

/// Numbers that are looked at.
const LOOKED_AT: usize = 256;
/// Of which so many have to differ before their digits are counted: a grid of round numbers in a text book is not rounded.
const FEWEST: usize = 30;
/// Share of ρ.
const OF_REPEATABILITY: f64 = 1e-3;

/// The step of the measured positions, m; zero where they have more digits than a nanometre, or are too few to say.
pub(crate) fn position_step(data: &Dataset) -> f64 {
    let stride = data.len().div_ceil(LOOKED_AT / 3).max(1);
    let numbers: Vec<f64> = (0..data.len())
        .step_by(stride)
        .filter(|&row| data.ray(row).is_none() && data.meets(row).is_none())
        .flat_map(|row| data.position[row])
        .filter(|v| v.is_finite() && v.abs() > 0.0)
        .collect();
    let mut different: Vec<u64> = numbers.iter().map(|v| v.to_bits()).collect();
    different.sort_unstable();
    different.dedup();
    if different.len() < FEWEST {
        return 0.0;
    }
    let mut step = 0.0;
    for unit in [1.0, 25.4e-3] {
        for digits in 3..=9 {
            let candidate = unit * 10f64.powi(-digits);
            let multiple = |v: &f64| {
                let times = v / candidate;
                (times - times.round()).abs() < 1e-3_f64.max(8.0 * f64::EPSILON * times.abs())
            };
            if numbers.iter().all(multiple) {
                step = f64::max(step, candidate);
                break;
            }
        }
    }
    step
}

/// The least τ, m.
pub(crate) fn least_sd(data: &Dataset, visit_sd: f64) -> f64 {
    let bound = f64::max(position_step(data) / 12f64.sqrt(), OF_REPEATABILITY * visit_sd);
    if bound <= 0.0 {
        return 0.0;
    }
    let stated = data
        .position_sd
        .iter()
        .flatten()
        .map(|&sd| if sd.is_nan() { 0.0 } else { sd })
        .fold(f64::INFINITY, f64::min);
    let stated = if stated.is_finite() { stated } else { 0.0 };
    (bound * bound - stated * stated).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn data(step: f64) -> Dataset {
        let value = |k: u64| {
            let raw = (k.wrapping_mul(2654435761) % 1_000_003) as f64 * 1.371_234_567_891e-6 - 0.4;
            if step > 0.0 { (raw / step).round() * step } else { raw }
        };
        let position: Vec<[f64; 3]> =
            (0..60).map(|row| [3 * row, 3 * row + 1, 3 * row + 2].map(value)).collect();
        Dataset {
            visit: (0..60).collect(),
            position_sd: vec![[f64::NAN; 3]; 60],
            orientation: vec![None; 60],
            orientation_sd: vec![[f64::NAN; 3]; 60],
            target: vec![None; 60],
            load: vec![truepose_kinematics::Load::None; 60],
            time: vec![0.0; 60],
            position,
            ..Dataset::default()
        }
    }

    #[test]
    fn the_step_of_the_numbers_is_found() {
        for step in [1e-3, 1e-4, 1e-6, 1e-8, 25.4e-6, 25.4e-7] {
            let found = position_step(&data(step));
            assert!((found / step - 1.0).abs() < 1e-9, "{step} {found}");
        }
        assert_eq!(position_step(&data(0.0)).to_bits(), 0.0f64.to_bits());
        assert_eq!(position_step(&data(1e-3).select(&[0, 1, 2])).to_bits(), 0.0f64.to_bits());
    }

    #[test]
    fn no_position_is_better_than_its_last_digit_unless_the_instrument_states_more() {
        let mut data = data(1e-6);
        assert!((least_sd(&data, 0.0) - 1e-6 / 12f64.sqrt()).abs() < 1e-12);
        assert!((least_sd(&data, 5e-3) - 5e-6).abs() < 1e-12);
        data.position_sd = vec![[2e-6; 3]; 60];
        assert!(least_sd(&data, 0.0).abs() < 1e-15);
    }
}

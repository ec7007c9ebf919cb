//! Pure error: how far pose measurements of one configuration scatter, whatever the model.
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | r_vt | residual of target t in pose measurement v, the mean of its rows there | m |
//! | z_vt = √(p/(p+1)) (r_vt − r̄_t) | contrast with the mean of the p earlier pose measurements of the group | m |
//! | k, n | targets of one contrast, contrasts | 1 |
//! | s_v = Σ_t z_vt / √k | what the rows of a pose measurement share | m |
//! | Σ | covariance of all 3k numbers of a contrast | m² |
//! | c² | relative variance of the noise variance between configurations | 1 |
//!
//! ```text
//! RMS² = Σ |z|² / Σ k + 3 τ² (1 − 1/rows)              of one row; the second term where a target was measured several times in one dwell
//! ν₁   = (tr Σ)² / tr Σ²,     tr Σ² ≈ mean_{i≠j} (z_i·z_j)²                 degrees of freedom of one contrast
//! ν    = 2 / (2/(n ν₁) + c²/groups)                                         of the RMS
//! ```
//!
//! Contrasts are independent and have the variance of one pose measurement. Their numbers are not independent: the targets of a pose measurement
//! share the robot's repeatability, and neither an instrument nor a robot scatters alike along all axes. ν₁ is the number of independent
//! numbers that a contrast is worth (Satterthwaite 1946); the mean of products of different contrasts estimates tr Σ² without bias. The
//! residuals of a model are used, not positions: what the model predicts to differ between repeats (time, temperature, backlash, joint values
//! that are not quite the same) is subtracted (Christensen 1989).
//!
//! A pose measurement that lies far from the median of its group is a gross error, and is left out ([`crate::gross_repeats`]): three bad rows among fifty
//! repeats would otherwise make the limit many times too large, and any model adequate.
//!
//! What repeats contain depends on how they were made: rows of one dwell contain the noise of a row alone; dwells at the same configuration
//! contain the repeatability of the robot as well. Only the latter are used here; [`within_dwell`] has the former, a lower bound.

use crate::Residuals;
use crate::gross_repeats::without_gross;
use crate::numbers::{ByAim, Numbers, count, square};
use crate::residuals::measured;
use nalgebra::Vector3;

use truepose_errormodel::{Dataset, Visits};

/// c²: relative variance of the noise variance between configurations. Of a robot that repeats in joint space the variance at the tool is
/// σ² tr J Jᵀ, and the squared lever arms vary by a third between poses of a campaign (convention; with the noise of the instrument, less).
const BETWEEN_CONFIGURATIONS: f64 = 0.1;

/// Contrasts from which products of pairs are taken: enough for tr Σ² to a hundredth.
const MOST_PRODUCTS: usize = 400;

/// Contrasts' worth of the assumption that the numbers of a contrast are independent within a target, all targets alike.
const ASSUMED: f64 = 5.0;

/// Variance of one axis with its degrees of freedom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stratum {
    /// m².
    pub variance: f64,
    /// Effective degrees of freedom.
    pub freedom: f64,
    /// Independent numbers in three axes, 1 to 3.
    pub axes: f64,
}

/// Scatter of repeated pose measurements.
#[derive(Debug, Clone, PartialEq)]
pub struct PureError {
    /// Configurations (or neighbourhoods) that were measured more than once.
    pub groups: usize,
    /// Independent differences between pose measurements.
    pub contrasts: usize,
    /// RMS of one row about its expectation over the components that were measured, m.
    pub rms: f64,
    /// Effective degrees of freedom of its square.
    pub freedom: f64,
    /// Whether all pose measurements of a group came with the same directions of approach.
    pub one_sided: bool,
    /// Of what a pose measurement's rows share, scaled to the variance of √k times their mean.
    pub(crate) between: Stratum,
    /// Of the deviations from that; none where fewer than two targets were measured.
    pub(crate) within: Option<Stratum>,
}

/// Difference of a pose measurement from the earlier ones of its group, target by target.
struct Contrast {
    /// NaN in components that were not measured.
    parts: Vec<Vector3<f64>>,
    /// Σ (1 − 1/rows) over its parts.
    averaged: f64,
}

impl PureError {
    /// Of groups of pose measurements (by their number in `data`); `None` where no group has two with a target in common, or they agree to
    /// the last digit.
    pub fn of(residuals: &Residuals, data: &Dataset, groups: &[Vec<usize>]) -> Option<Self> {
        let visits = Visits::of(data);
        let numbers = Numbers::new(residuals, data);
        let groups = without_gross(&numbers, &visits, groups);
        let (mut contrasts, mut used, mut one_sided) = (Vec::new(), 0, true);
        for group in groups.iter().filter(|group| group.len() > 1) {
            let before = contrasts.len();
            contrasts.extend(of_group(&numbers, &visits, group));
            if contrasts.len() > before {
                used += 1;
                let first = visits.rows[group[0]][0];
                let alike = |row: usize| data.approach.iter().all(|s| (s[row] - s[first]).abs() < 0.5);
                one_sided &= group.iter().flat_map(|&visit| &visits.rows[visit]).all(|&row| alike(row));
            }
        }
        let parts: usize = contrasts.iter().map(|c| c.parts.len()).sum();
        let squares: f64 = contrasts.iter().flat_map(|c| &c.parts).map(square).sum();
        if parts == 0 || squares <= 0.0 {
            return None;
        }
        let averaged: f64 = contrasts.iter().map(|c| c.averaged).sum();
        let dwell = within_dwell(residuals, data).map_or(0.0, |(rms, _)| rms * rms);
        let all: Vec<Vec<Vector3<f64>>> = contrasts.iter().map(|c| c.parts.clone()).collect();
        let counted = |all: &[Vec<Vector3<f64>>]| all.iter().flatten().map(count).sum::<usize>() as f64;
        // One of whole positions.
        let rows = parts as f64 * Numbers::per_row(data) / counted(&all);
        let of_row = (rows * squares + averaged * dwell) / parts as f64;
        let shared: Vec<Vec<Vector3<f64>>> = all.iter().map(|parts| vec![mean_part(parts)]).collect();
        // A mean takes one number from each component.
        let several =
            |parts: &&Vec<Vector3<f64>>| parts.iter().map(count).sum::<usize>() > count(&mean_part(parts));
        let apart: Vec<Vec<Vector3<f64>>> =
            all.iter().filter(several).map(|parts| deviations(parts)).collect();
        let means: usize = all.iter().filter(several).map(|parts| count(&mean_part(parts))).sum();
        let each = counted(&all) / parts as f64;
        let independent = |vectors: &[Vec<Vector3<f64>>]| independent(vectors, each);
        let stratum = |vectors: &[Vec<Vector3<f64>>], numbers: f64| {
            let squares: f64 = vectors.iter().flatten().map(square).sum();
            let each = independent(vectors);
            Stratum {
                variance: squares / numbers,
                freedom: with_heterogeneity(vectors.len() as f64 * each, used),
                axes: 3.0 * (each * vectors.len() as f64 / numbers).min(1.0),
            }
        };
        let left = counted(&apart) - means as f64;
        let within = (left > 0.0).then(|| stratum(&apart, left)).filter(|s| s.variance > 0.0);
        Some(PureError {
            groups: used,
            contrasts: contrasts.len(),
            rms: of_row.sqrt(),
            freedom: with_heterogeneity(contrasts.len() as f64 * independent(&all), used),
            one_sided,
            between: stratum(&shared, counted(&shared)),
            within,
        })
    }
}

/// Poses, each measured twice, whose pure error has so many degrees of freedom: three a pose, less what noise may differ between poses.
pub fn repeats_for(freedom: f64) -> usize {
    ((2.0 / 3.0 + BETWEEN_CONFIGURATIONS) * 0.5 * freedom).ceil() as usize
}

/// RMS of the rows of one target in one dwell about their mean over the components that were measured, m, and its degrees of freedom: the
/// noise of a row alone. `None` where no target was measured twice in a dwell.
pub fn within_dwell(residuals: &Residuals, data: &Dataset) -> Option<(f64, usize)> {
    let numbers = Numbers::new(residuals, data);
    let (mut squares, mut freedom) = (0.0, 0);
    for rows in &Visits::of(data).rows {
        let mut of_target: ByAim<Vec<Vector3<f64>>> = ByAim::new();
        for &row in rows {
            if let Some(value) = numbers.of(row) {
                numbers.entry(&mut of_target, row).push(value);
            }
        }
        for values in of_target.values().flatten().map(|alike| &alike.of) {
            let mean = values.iter().sum::<Vector3<f64>>() / values.len() as f64;
            squares += values.iter().map(|v| square(&(v - mean))).sum::<f64>();
            freedom += count(&mean) * (values.len() - 1);
        }
    }
    (freedom > 0 && squares > 0.0)
        .then(|| ((Numbers::per_row(data) * squares / freedom as f64).sqrt(), freedom))
}

fn of_group(numbers: &Numbers<'_>, visits: &Visits, group: &[usize]) -> Vec<Contrast> {
    /// (rows or pose measurements, their sum or mean) of what was measured.
    type Known = ByAim<(f64, Vector3<f64>)>;
    let mut known = Known::new();
    let mut contrasts = Vec::new();
    for &visit in group {
        // The first row and (rows, sum) of each.
        let mut here: ByAim<(usize, f64, Vector3<f64>)> = ByAim::new();
        for (&row, value) in visits.rows[visit].iter().filter_map(|row| Some((row, numbers.of(*row)?))) {
            let own = numbers.entry(&mut here, row);
            *own = (if own.1 > 0.0 { own.0 } else { row }, own.1 + 1.0, own.2 + value);
        }
        let mut contrast = Contrast { parts: Vec::new(), averaged: 0.0 };
        for (row, rows, sum) in here.into_values().flatten().map(|alike| alike.of) {
            let value = sum / rows;
            let (count, mean) = numbers.entry(&mut known, row);
            if *count > 0.0 {
                contrast.parts.push((value - *mean) * (*count / (*count + 1.0)).sqrt());
                contrast.averaged += 1.0 - 1.0 / rows;
            }
            *mean += (value - *mean) / (*count + 1.0);
            *count += 1.0;
        }
        if !contrast.parts.is_empty() {
            contrasts.push(contrast);
        }
    }
    contrasts
}

/// Sum and count of each component over the parts in which it was measured.
fn sums(parts: &[Vector3<f64>]) -> (Vector3<f64>, Vector3<f64>) {
    let seen = |part: &Vector3<f64>| part.map(|v| if v.is_nan() { 0.0 } else { 1.0 });
    (parts.iter().map(measured).sum(), parts.iter().map(seen).sum())
}

/// Σ_t z_t / √k; NaN in components that no part has.
fn mean_part(parts: &[Vector3<f64>]) -> Vector3<f64> {
    let (sum, k) = sums(parts);
    sum.component_div(&k.map(f64::sqrt))
}

fn deviations(parts: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let (sum, k) = sums(parts);
    let mean = sum.component_div(&k);
    parts.iter().map(|part| part - mean).collect()
}

/// ν₁, the independent numbers of one contrast, between one and all of them; of few contrasts nearer to those of one part, `each`.
fn independent(contrasts: &[Vec<Vector3<f64>>], each: f64) -> f64 {
    let n = contrasts.len();
    let longest = contrasts.iter().map(Vec::len).max().unwrap_or(1);
    let trace = contrasts.iter().flatten().map(square).sum::<f64>() / n.max(1) as f64;
    let few = &contrasts[..n.min(MOST_PRODUCTS)];
    let (mut products, mut pairs) = (0.0, 0.0);
    for (i, a) in few.iter().enumerate() {
        for b in &few[..i] {
            products += a.iter().zip(b).map(|(a, b)| measured(a).dot(&measured(b))).sum::<f64>().powi(2);
            pairs += 1.0;
        }
    }
    let weight = few.len() as f64;
    let squares = if pairs > 0.0 { products / pairs } else { 0.0 };
    // tr Σ² in units of (tr Σ)².
    let relative =
        (weight * squares / (trace * trace).max(f64::MIN_POSITIVE) + ASSUMED / each) / (weight + ASSUMED);
    (1.0 / relative).clamp(1.0, (each * longest as f64).max(1.0))
}

fn with_heterogeneity(freedom: f64, groups: usize) -> f64 {
    2.0 / (2.0 / freedom + BETWEEN_CONFIGURATIONS / groups.max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::repeat_groups::{exact_repeats, near_repeats};
    use truepose_kinematics::{Load, TargetId};

    /// A reproducible standard normal number: a sum of twelve uniform ones.
    fn normals(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        move || {
            let mut sum = -6.0;
            for _ in 0..12 {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                sum += (state >> 11) as f64 / (1u64 << 53) as f64;
            }
            sum
        }
    }

    /// Poses of one joint, each `times` over in turn, with `rows` rows of each of `targets` targets: noise of a row and of a dwell.
    fn measured(
        (poses, times, targets, rows): (usize, usize, usize, usize),
        [tau, rho]: [f64; 2],
        seed: u64,
    ) -> (Dataset, Residuals) {
        let mut normal = normals(seed);
        let (mut data, mut residuals) = (Dataset::default(), Residuals::default());
        data.joints.push(Vec::new());
        for visit in 0..poses * times {
            let shared = Vector3::from_fn(|_, _| rho * normal());
            // What a model lacks: much, and the same at every repeat.
            let missing = Vector3::repeat(1e-3 * ((visit % poses) as f64).sin());
            for row in 0..targets * rows {
                data.joints[0].push((visit % poses) as f64);
                data.visit.push(visit);
                data.target.push(Some(TargetId(row % targets)));
                data.load.push(Load::None);
                data.position.push([0.0; 3]);
                data.orientation.push(None);
                residuals.position.push(missing + shared + Vector3::from_fn(|_, _| tau * normal()));
                residuals.orientation.push(None);
            }
        }
        (data, residuals)
    }

    #[test]
    fn the_pure_error_is_that_of_one_row_and_its_interval_contains_it() {
        use statrs::distribution::{ChiSquared, ContinuousCDF};
        let noise: [f64; 2] = [2e-5, 3e-5];
        let all: &[usize] = &[0, 1, 2];
        // Three targets share the repeatability of the robot; of two rows of one target the noise of a row is averaged.
        for (layout, seen) in [
            ((20, 2, 1, 1), [all; 3]),
            ((12, 2, 3, 1), [all; 3]),
            ((1, 20, 3, 1), [all; 3]),
            ((15, 2, 1, 2), [all; 3]),
            ((40, 2, 1, 1), [&[0]; 3]),
            ((20, 2, 3, 1), [&[0, 1], &[0, 1], &[0, 1]]),
            ((40, 2, 3, 1), [&[0], &[1], &[2]]),
        ] {
            let per_row = seen.iter().map(|seen| seen.len()).sum::<usize>() as f64 / 3.0;
            let truth = f64::sqrt(per_row * (noise[0] * noise[0] + noise[1] * noise[1]));
            let (mut inside, mut mean) = (0, 0.0);
            let trials = 200;
            for trial in 0..trials {
                let (mut data, mut residuals) = measured(layout, noise, trial);
                for row in 0..data.len() {
                    let seen = seen[data.target[row].unwrap().0];
                    for axis in (0..3).filter(|axis| !seen.contains(axis)) {
                        data.position[row][axis] = f64::NAN;
                        residuals.position[row][axis] = f64::NAN;
                    }
                }
                let pure = PureError::of(&residuals, &data, &exact_repeats(&data)).unwrap();
                let end = |share: f64| {
                    pure.rms
                        * (pure.freedom / ChiSquared::new(pure.freedom).unwrap().inverse_cdf(share)).sqrt()
                };
                inside += usize::from(end(0.975) <= truth && truth <= end(0.025));
                mean += (pure.rms / truth).powi(2) / trials as f64;
            }
            assert!((mean - 1.0).abs() < 0.06, "{layout:?} {seen:?}: {mean}");
            // 95 % less two and a half standard deviations of 200 trials; more where poses might have differed.
            assert!(inside >= 182, "{layout:?} {seen:?}: {inside} of {trials}");
        }
    }

    #[test]
    fn gross_errors_among_repeats_do_not_make_the_limit_larger() {
        let noise: [f64; 2] = [2e-5, 3e-5];
        for layout in [(5, 4, 1, 1), (12, 2, 3, 1)] {
            let (data, residuals) = measured(layout, noise, 3);
            let of = |residuals: &Residuals| PureError::of(residuals, &data, &exact_repeats(&data)).unwrap();
            let clean = of(&residuals);
            let mut bad = residuals.clone();
            for row in [1, 7] {
                bad.position[row] += Vector3::new(3e-3, 0.0, -2e-3);
            }
            let found = of(&bad);
            assert!((found.rms / clean.rms - 1.0).abs() < 0.35, "{} {}", found.rms, clean.rms);
            assert!(found.freedom < clean.freedom);
        }
    }

    #[test]
    fn rows_of_one_dwell_are_no_repeats_of_a_pose() {
        let (data, residuals) = measured((10, 1, 1, 3), [2e-5, 3e-5], 1);
        assert_eq!(exact_repeats(&data), Vec::<Vec<usize>>::new());
        assert_eq!(PureError::of(&residuals, &data, &exact_repeats(&data)), None);
        let (rms, freedom) = within_dwell(&residuals, &data).unwrap();
        assert_eq!(freedom, 60);
        assert!((rms / (3f64.sqrt() * 2e-5) - 1.0).abs() < 0.3, "{rms}");
    }

    #[test]
    fn a_pose_that_follows_its_neighbour_was_not_approached_anew() {
        let (mut data, _) = measured((6, 1, 1, 1), [1e-5, 0.0], 1);
        // A slow sweep, then a pose far away, then back.
        data.joints[0] = vec![0.0, 1e-4, 2e-4, 3e-4, 1.0, 1e-4];
        assert_eq!(near_repeats(&data, &[5e-4]), [vec![0, 5]]);
        assert_eq!(near_repeats(&data, &[5e-5]), [vec![1, 5]]);
    }
}

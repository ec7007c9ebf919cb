//! Standard deviations from the residuals of a fit: variance components by moments.
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | σ² = s² + τ², d = 1/σ, u = r/σ | of the rows of one visit, an axis at a time | |
//! | v | d; of numbers along directions the v_k of noise.rs, s that of the first of a visit | |
//! | f_w, f_b, f_o | [`Freedom`]: what the fit left within visits, between them, and of orientations | 1 |
//! | τ | within a visit, on top of what the instrument states | m |
//! | ρ | shared by a visit | m |
//! | ω | of orientations, on top of what the instrument states | rad |
//!
//! ```text
//! within     Σ |u|² − Σ (v·u)²/|v|²            = f_w    → τ
//! between    Σ (v·u)²/|v|² / (1 + ρ²|v|²)      = f_b    → ρ, τ known
//! turns      Σ r² / (s² + ω²)                  = f_o    → ω
//! ```
//!
//! Each left side falls and has one root, found by bisection. They are the equations of restricted maximum likelihood where deviations within
//! a visit are alike (Searle, Casella and McCulloch 1992, ch. 6). Where visits share nothing, ρ = 0, or have one row each, τ is that of
//! both together; so it is where fewer than six degrees of freedom are within visits. No τ is below what the digits of the file
//! allow (resolution.rs).

use crate::noise::{directions, rays_of};
use crate::resolution::least_sd;
use crate::{Freedom, NoiseModel, Residuals};
use nalgebra::Vector3;
use std::collections::HashMap;
use truepose_errormodel::{Dataset, Visits};

/// Degrees of freedom within visits below which nothing is estimated from them: two differences in space. One pair of rows that happen to be
/// alike says nothing about an instrument; the variances are pooled then.
const LEAST_WITHIN: f64 = 6.0;

/// Noise that explains these residuals; no deviation is below what the digits of the data allow (resolution.rs).
pub fn estimate_noise(
    data: &Dataset,
    visits: &Visits,
    residuals: &Residuals,
    freedom: &Freedom,
) -> NoiseModel {
    let axes = Axes::of(data, visits, residuals);
    let (mut position_sd, mut visit_sd) = (0.0, 0.0);
    if freedom.within >= LEAST_WITHIN {
        position_sd = within(&axes, freedom.within);
        visit_sd = shared(&axes, position_sd, freedom.between);
    }
    let turns: Vec<(f64, f64)> = residuals
        .orientation
        .iter()
        .enumerate()
        .filter_map(|(row, r)| r.map(|r| (row, r)))
        .flat_map(|(row, r)| (0..3).map(move |k| (row, k, r[k])))
        .map(|(row, k, r)| (r, stated(data.orientation_sd[row][k])))
        .collect();
    let default = NoiseModel::default();
    let positions =
        Stratum { values: &axes.values, freedom: freedom.positions(), usual: default.position_sd };
    let turns = Stratum { values: &turns, freedom: freedom.turns, usual: default.orientation_sd };
    if visit_sd <= 0.0 {
        position_sd = positions.beside(&turns);
    }
    position_sd = position_sd.max(least_sd(data, visit_sd));
    NoiseModel {
        position_sd: if axes.values.is_empty() { default.position_sd } else { position_sd },
        visit_sd,
        orientation_sd: turns.beside(&positions),
    }
}

/// Numbers of one unit.
struct Stratum<'a> {
    /// (r, s).
    values: &'a [(f64, f64)],
    freedom: f64,
    /// What a usual instrument has, m or rad.
    usual: f64,
}

impl Stratum<'_> {
    /// τ of these numbers, of which the others have another. Where hardly any degree of freedom is left, residuals contain next to nothing: the model
    /// follows them, and the fit would end at a τ of zero with intervals of zero. With fewer than [`FEW`] degrees of freedom up to one more
    /// number counts that is as large as the usual τ, times the factor that all numbers have in common; with fewer than [`FEW_IN_ALL`] that
    /// factor is held towards one in the same way. Stated standard deviations need none of it.
    fn beside(&self, others: &Stratum<'_>) -> f64 {
        /// Degrees of freedom of one unit from which on they alone decide.
        const FEW: f64 = 12.0;
        /// The same of all numbers.
        const FEW_IN_ALL: f64 = 6.0;
        if self.values.is_empty() {
            return self.usual;
        }
        let weight = |freedom: f64, few: f64| (1.0 - freedom / few).max(0.0);
        let is_stated = self.values.iter().all(|(_, s)| *s > 0.0);
        let all = self.freedom + if others.values.is_empty() { 0.0 } else { others.freedom };
        let (own, common) = (weight(self.freedom, FEW), weight(all, FEW_IN_ALL));
        let alone = others.values.is_empty();
        if is_stated || (common <= 0.0 && (own <= 0.0 || alone)) {
            return excess(self.values, self.freedom);
        }
        let scaled = |stratum: &Stratum<'_>| -> Vec<(f64, f64)> {
            stratum.values.iter().map(|(r, s)| (r / stratum.usual, s / stratum.usual)).collect()
        };
        let every = [scaled(self), scaled(others), vec![(common.sqrt(), 0.0)]].concat();
        let usual = self.usual * excess(&every, all + common);
        if alone {
            return usual;
        }
        excess(&[self.values, &[(own.sqrt() * usual, 0.0)]].concat(), self.freedom + own)
    }
}

fn stated(sd: f64) -> f64 {
    if sd.is_nan() { 0.0 } else { sd }
}

/// What is left of the rows of each visit, an axis at a time, as (r, s).
#[derive(Default)]
struct Axes {
    values: Vec<(f64, f64)>,
    /// Where the rows of a visit and axis end: behind the last are those of `turned`.
    ends: Vec<usize>,
    /// Of visits with numbers along directions, which have no place among those.
    turned: Vec<Turned>,
}

/// Numbers of a visit along directions, for s² + τ² = 1.
struct Turned {
    /// Stated standard deviation.
    stated: f64,
    /// |u|² − Σ (v·u)²/|v|².
    within: f64,
    /// v·u and |v|² of each direction.
    between: Vec<(f64, f64)>,
}

impl Axes {
    fn of(data: &Dataset, visits: &Visits, residuals: &Residuals) -> Self {
        let (mut axes, mut apart) = (Axes::default(), Vec::new());
        for (rows, axis) in visits.rows.iter().flat_map(|rows| (0..3).map(move |axis| (rows, axis))) {
            let first = axes.values.len();
            let number =
                |row: usize| data.number(row, &residuals.position[row], axis).filter(|r| r.is_finite());
            for &row in rows {
                axes.values.extend(number(row).map(|r| (r, stated(data.position_sd[row][axis]))));
            }
            let own = &axes.values[first..];
            let rays = rays_of(data, axis, rows.iter().copied().filter(|&row| number(row).is_some()));
            if own.len() > 1 && !rays.is_empty() {
                axes.turned.push(Turned::of(own, &rays));
                apart.extend(axes.values.drain(first..));
                continue;
            }
            if axes.ends.last().copied().unwrap_or(0) < axes.values.len() {
                axes.ends.push(axes.values.len());
            }
        }
        axes.values.append(&mut apart);
        axes
    }

    fn each(&self) -> impl Iterator<Item = &[(f64, f64)]> {
        let mut begin = 0;
        self.ends.iter().map(move |&end| &self.values[std::mem::replace(&mut begin, end)..end])
    }
}

impl Turned {
    fn of(own: &[(f64, f64)], rays: &[Vector3<f64>]) -> Self {
        let directions = directions(&vec![1.0; own.len()], rays);
        let between: Vec<(f64, f64)> = directions
            .iter()
            .map(|v| {
                v.iter()
                    .zip(own)
                    .fold((0.0, 0.0), |(along, squares), (v, (r, _))| (along + v * r, squares + v * v))
            })
            .collect();
        let taken: f64 = between.iter().map(|(along, squares)| along * along / squares).sum();
        let all: f64 = own.iter().map(|(r, _)| r * r).sum();
        Turned { stated: own[0].1, within: (all - taken).max(0.0), between }
    }
}

/// The sum of what has the same second number, in order of first appearance: of a million rows most share what is stated, and a
/// bisection asks sixty times.
fn pooled(values: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    let mut places = HashMap::new();
    let mut sums: Vec<(f64, f64)> = Vec::new();
    for (value, shared) in values {
        let place = *places.entry(shared.to_bits()).or_insert(sums.len());
        match sums.get_mut(place) {
            Some((sum, _)) => *sum += value,
            None => sums.push((value, shared)),
        }
    }
    sums
}

/// |u|² − (d·u)²/|d|², (d·u)²/|d|² and |d|² of one visit's (r, s).
fn parted(members: &[(f64, f64)], tau: f64) -> (f64, f64, f64) {
    let (mut squares, mut along, mut weight) = (0.0, 0.0, 0.0);
    for &(r, s) in members {
        let w = 1.0 / (s * s + tau * tau).max(1e-24);
        squares += r * r * w;
        along += r * w;
        weight += w;
    }
    let mean = along * along / weight;
    ((squares - mean).max(0.0), mean, weight)
}

/// Beyond the root: what alone would explain all of it.
fn largest<'a>(values: impl Iterator<Item = &'a (f64, f64)>, freedom: f64) -> f64 {
    (values.map(|v| v.0 * v.0).sum::<f64>() / freedom.max(f64::MIN_POSITIVE)).sqrt()
}

/// The τ at which the whitened squares within visits add up.
fn within(axes: &Axes, freedom: f64) -> f64 {
    let (alike, mixed): (Vec<_>, Vec<_>) = axes
        .each()
        .filter(|members| members.len() > 1)
        .partition(|members| members.iter().all(|(_, s)| s.to_bits() == members[0].1.to_bits()));
    // Whose rows all state the same: Σr² − (Σr)²/n, over s² + τ².
    let spread = |members: &[(f64, f64)]| {
        let (sum, squares) =
            members.iter().fold((0.0, 0.0), |(sum, squares), (r, _)| (sum + r, squares + r * r));
        (squares - sum * sum / members.len() as f64).max(0.0)
    };
    let turned = axes.turned.iter().map(|turned| (turned.within, turned.stated));
    let alike = pooled(alike.into_iter().map(|members| (spread(members), members[0].1)).chain(turned));
    bisect(largest(axes.values.iter(), freedom), |tau| {
        let of_alike = alike.iter().map(|(squares, s)| squares / (s * s + tau * tau).max(1e-24)).sum::<f64>();
        of_alike + mixed.iter().map(|members| parted(members, tau).0).sum::<f64>() - freedom
    })
}

/// The τ at which Σ r²/(s² + τ²) is `freedom`; zero when s alone explains them.
fn excess(values: &[(f64, f64)], freedom: f64) -> f64 {
    let squares = pooled(values.iter().map(|(r, s)| (r * r, *s)));
    let sum = |tau: f64| -> f64 {
        squares.iter().map(|(squares, s)| squares / (s * s + tau * tau).max(f64::MIN_POSITIVE)).sum()
    };
    bisect(largest(values.iter(), freedom), |tau| sum(tau) - freedom)
}

/// The ρ at which the whitened squares of the visits' means add up.
fn shared(axes: &Axes, tau: f64, freedom: f64) -> f64 {
    let means = axes.each().map(|members| {
        let (_, mean, weight) = parted(members, tau);
        (mean, weight)
    });
    let turned = axes.turned.iter().flat_map(|turned| {
        let precision = 1.0 / (turned.stated.powi(2) + tau * tau).max(1e-24);
        turned
            .between
            .iter()
            .map(move |(along, squares)| (along * along / squares * precision, squares * precision))
    });
    let means = pooled(means.chain(turned));
    let sum =
        |rho: f64| -> f64 { means.iter().map(|(mean, weight)| mean / (1.0 + rho * rho * weight)).sum() };
    // A mean is no larger than what it is the mean of, and is weighed by no more than 1/ρ².
    let upper = (means.iter().map(|(mean, weight)| mean / weight).sum::<f64>()
        / freedom.max(f64::MIN_POSITIVE))
    .sqrt();
    bisect(upper, |rho| sum(rho) - freedom)
}

/// Root of a falling function on [0, upper]; zero when it is not positive at zero.
fn bisect(upper: f64, excess: impl Fn(f64) -> f64) -> f64 {
    if upper.is_nan() || upper <= 0.0 || excess(0.0) <= 0.0 {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, upper);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if excess(middle) > 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_what_was_put_in() {
        // A fixed, well mixed sequence of unit normals by the sum of twelve uniforms.
        let mut state = 12345u64;
        let mut normal = || {
            let mut sum = -6.0;
            for _ in 0..12 {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                sum += (state >> 11) as f64 / (1u64 << 53) as f64;
            }
            sum
        };
        let (visits, each) = (2000, 3);
        let mut data = Dataset::default();
        let mut residuals = Residuals::default();
        for visit in 0..visits {
            let common = Vector3::new(normal(), normal(), normal()) * 5e-5;
            for _ in 0..each {
                data.visit.push(visit);
                data.position_sd.push([3e-5; 3]);
                data.orientation_sd.push([f64::NAN; 3]);
                data.orientation.push(None);
                data.position.push([0.0; 3]);
                let own = Vector3::new(normal(), normal(), normal()) * 4e-5;
                residuals.position.push(common + own);
                residuals.orientation.push(None);
            }
        }
        let noise =
            estimate_noise(&data, &Visits::of(&data), &residuals, &Freedom::all(&data, &Visits::of(&data)));
        let tau = (4e-5f64.powi(2) - 3e-5f64.powi(2)).sqrt();
        assert!((noise.position_sd / tau - 1.0).abs() < 0.04, "{noise:?}");
        assert!((noise.visit_sd / 5e-5 - 1.0).abs() < 0.03, "{noise:?}");
    }

    /// Of visits that state one deviation, of visits that state several, and of single rows, against the equations as they stand.
    #[test]
    fn rows_that_state_the_same_are_pooled_and_nothing_else_changes() {
        let mut axes = Axes::default();
        let value = |k: usize| ((k as f64 * 0.618_034).fract() - 0.5) * 3e-4;
        for visit in 0..400 {
            let stated = |k: usize| match visit % 4 {
                0 => 2e-5,
                1 => 1e-5 * (1 + k) as f64,
                2 => 3e-5,
                _ => 1e-7 * visit as f64,
            };
            axes.values.extend((0..1 + visit % 5).map(|k| (value(7 * visit + k), stated(k))));
            axes.ends.push(axes.values.len());
        }
        let whole = |tau: f64| axes.each().filter(|m| m.len() > 1).map(|m| parted(m, tau).0).sum::<f64>();
        let tau = within(&axes, 700.0);
        assert!(tau > 1e-5 && (whole(tau) / 700.0 - 1.0).abs() < 1e-9, "{tau} {}", whole(tau));
        let rho = shared(&axes, 0.2 * tau, 350.0);
        let means = axes.each().map(|m| parted(m, 0.2 * tau));
        let sum: f64 = means.map(|(_, mean, weight)| mean / (1.0 + rho * rho * weight)).sum();
        assert!(rho > 1e-5 && (sum / 350.0 - 1.0).abs() < 1e-9, "{rho} {sum}");
        let omega = excess(&axes.values, 1100.0);
        let sum: f64 = axes.values.iter().map(|(r, s)| r * r / (s * s + omega * omega)).sum();
        assert!(omega > 1e-5 && (sum / 1100.0 - 1.0).abs() < 1e-9, "{omega} {sum}");
    }

    #[test]
    fn residuals_that_hardly_have_a_degree_of_freedom_do_not_make_a_noise_of_zero() {
        let (positions, turns) = ([(1e-9, 0.0); 24], [(2e-4, 0.0); 24]);
        let of = |positions: &[(f64, f64)], stated: f64, freedom: [f64; 2]| {
            let positions: Vec<_> = positions.iter().map(|(r, _)| (*r, stated)).collect();
            let each = [(&positions[..], freedom[0], 1e-4), (&turns[..], freedom[1], 3e-4)];
            let [a, b] = each.map(|(values, freedom, usual)| Stratum { values, freedom, usual });
            [a.beside(&b), b.beside(&a)]
        };
        // Positions that are followed get what orientations leave, in the usual proportion.
        let [position, turn] = of(&positions, 0.0, [0.5, 20.0]);
        assert!(position > 4e-5 && position < 1e-4 && turn > 2e-4 && turn < 3e-4, "{position} {turn}");
        // Where all numbers are followed it is what usual instruments have.
        let alone = Stratum { values: &positions, freedom: 0.5, usual: 1e-4 };
        let nothing = Stratum { values: &[], freedom: 0.0, usual: 3e-4 };
        assert!((alone.beside(&nothing) / 1e-4 - 1.0).abs() < 0.5);
        // With degrees of freedom, or with stated deviations, they alone decide.
        assert!(of(&positions, 0.0, [20.0, 20.0])[0] < 2e-9);
        assert!(of(&positions, 1e-5, [0.5, 20.0])[0] < 1e-12);
    }

    /// Visits of single rows with deviation 5e-5, and so many pairs of rows that are the same to the bit.
    fn with_copies(pairs: usize) -> (Dataset, NoiseModel) {
        let (mut data, mut residuals) = (Dataset::default(), Residuals::default());
        let mut put = |data: &mut Dataset, visit: usize| {
            let value = |axis: usize| ((visit * 3 + axis) as f64 * 0.618_034).fract() - 0.5;
            let r = Vector3::new(value(0), value(1), value(2)) * 5e-5 * 12f64.sqrt();
            data.visit.push(visit);
            data.position_sd.push([f64::NAN; 3]);
            data.orientation_sd.push([f64::NAN; 3]);
            data.orientation.push(None);
            data.position.push([0, 1, 2].map(|k| ((0.7 + 0.01 * visit as f64 + r[k]) * 1e6).round() * 1e-6));
            residuals.position.push(r);
            residuals.orientation.push(None);
        };
        for visit in 0..60 {
            (0..if visit < pairs { 2 } else { 1 }).for_each(|_| put(&mut data, visit));
        }
        let visits = Visits::of(&data);
        let noise = estimate_noise(&data, &visits, &residuals, &Freedom::all(&data, &visits));
        (data, noise)
    }

    #[test]
    fn rows_that_are_alike_do_not_make_an_instrument_without_noise() {
        let (_, one) = with_copies(1);
        assert!((one.position_sd / 5e-5 - 1.0).abs() < 0.1 && one.visit_sd <= 0.0, "{one:?}");
        let (_, many) = with_copies(20);
        assert!((many.position_sd / (1e-6 / 12f64.sqrt()) - 1.0).abs() < 1e-9, "{many:?}");
        assert!((many.visit_sd / 5e-5 - 1.0).abs() < 0.1, "{many:?}");
    }
}

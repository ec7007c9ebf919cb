//! How time grows with rows and with unknowns: the paper's robot, its polynomial, one linear identification with everything that belongs to it
//! (structure, noise, covariance), process CPU.
//!
//! ```text
//! log t ≈ a + n log x   over the upper half of what was measured
//! ```
//!
//! Rows come from memory in blocks, again and again beyond the first quarter of a million, as from a file that is larger than memory; reading
//! is not timed.

use crate::prelude::*;
mod figure;
mod rows;

use rows::Blocks;
use truepose_errormodel::effects::{Polynomial, WrenchComponent};
use truepose_identify::{FitOptions, PriorStrength, StreamedOptions, fit, identify_streamed};
use truepose_kinematics::{Axis, samples};
use truepose_micro::points;

/// One measured series.
pub struct Series {
    /// Of what.
    pub name: &'static str,
    /// (size, seconds).
    pub points: Vec<(f64, f64)>,
}

/// Rows of a run.
const ROWS: [usize; 9] = [1_000, 3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000, 3_000_000, 10_000_000];
/// Unknowns that are aimed at, and the points over which they are fitted.
const UNKNOWNS: [usize; 9] = [20, 35, 60, 100, 170, 300, 500, 700, 1000];
const POINTS: usize = 5_000;

/// Measures both, prints them, and draws the figure.
pub fn run(figure: &Path) -> Outcome {
    let load = clock::load();
    let chain = samples::pps();
    let options = FitOptions { refine: false, prior: PriorStrength::None, ..FitOptions::default() };
    let solver = PivotedQr::default();

    let effects = effects(3, 1, 6);
    let mut by_rows = Series { name: "rows", points: Vec::new() };
    let mut source = Blocks::new(&chain);
    for rows in ROWS {
        source.rows = rows;
        let streamed = StreamedOptions { fit: options.clone(), folds: 0 };
        let (cpu, _, found) =
            clock::timed(|| identify_streamed::<Blocks>(&chain, &effects, &mut source, &solver, &streamed));
        let rank = found?.fit.reduction.rank();
        by_rows.take(rows, cpu, &format!("{rank} grouped errors"));
    }

    let data = points(&chain, 0, POINTS);
    let mut by_unknowns = Series { name: "unknowns", points: Vec::new() };
    for aim in UNKNOWNS {
        let model = nearest(&chain, aim)?;
        let unknowns = model.columns().len();
        let (cpu, _, found) = clock::timed(|| fit(&model, &data, &solver, &options));
        by_unknowns.take(unknowns, cpu, &format!("{} grouped errors", found?.reduction.rank()));
    }
    for series in [&by_rows, &by_unknowns] {
        say(&format!("time grows with {} to the power of {:.2}", series.name, series.exponent()));
    }
    if let Some(folder) = figure.parent() {
        std::fs::create_dir_all(folder)?;
    }
    figure::draw(figure, &by_rows, &by_unknowns)?;
    say_machine("one thread", load);
    say(&format!("written to {}", figure.display()));
    Ok(())
}

impl Series {
    fn take(&mut self, size: usize, seconds: f64, more: &str) {
        say(&format!("{size:>9} {}: {seconds:.4} s, {more}", self.name));
        self.points.push((size as f64, seconds));
    }

    /// The slope of the logarithms over the upper half.
    pub fn exponent(&self) -> f64 {
        let logs: Vec<(f64, f64)> = self.upper().iter().map(|(x, t)| (x.ln(), t.ln())).collect();
        let n = logs.len() as f64;
        let (mx, mt) = logs.iter().fold((0.0, 0.0), |(a, b), (x, t)| (a + x / n, b + t / n));
        let (across, square) =
            logs.iter().fold((0.0, 0.0), |(a, s), (x, t)| (a + (x - mx) * (t - mt), s + (x - mx) * (x - mx)));
        across / square
    }

    /// What the exponent is fitted to.
    pub fn upper(&self) -> &[(f64, f64)] {
        &self.points[self.points.len() / 2..]
    }
}

/// The polynomial of this degree in so many wrench components, of the first so many components of every error.
fn effects(degree: u32, wrench: usize, components: usize) -> Vec<Box<dyn AnyEffect>> {
    let all = [WrenchComponent::Fy, WrenchComponent::Mx, WrenchComponent::Fz];
    let mut polynomial = Polynomial::of(degree, all[..wrench].to_vec());
    polynomial.small = vec![JointId(5), JointId(6)];
    polynomial.components = Some(Axis::ALL[..components].to_vec());
    vec![Box::new(polynomial)]
}

/// The polynomial whose number of columns is nearest to this one.
fn nearest(chain: &Chain, aim: usize) -> Outcome<ErrorModel> {
    let mut best: Option<ErrorModel> = None;
    for components in [1, 2, 3, 6] {
        for wrench in 0..=3 {
            for degree in 1..=5 {
                let model = ErrorModel::new(chain.clone(), effects(degree, wrench, components))?;
                let off = |model: &ErrorModel| model.columns().len().abs_diff(aim);
                if best.as_ref().is_none_or(|best| off(&model) < off(best)) {
                    best = Some(model);
                }
            }
        }
    }
    best.ok_or_else(|| "there is no model".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponent_is_that_of_a_power() {
        let points = (0..8).map(|k| (10f64.powi(k), 3e-7 * 10f64.powi(k).powf(1.7))).collect();
        let series = Series { name: "rows", points };
        assert!((series.exponent() - 1.7).abs() < 1e-12);
    }

    #[test]
    fn models_of_all_sizes_are_there() {
        for aim in UNKNOWNS {
            let have = nearest(&samples::pps(), aim).unwrap().columns().len();
            assert!(have.abs_diff(aim) <= aim / 5, "{aim} {have}");
        }
    }
}

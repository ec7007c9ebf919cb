//! One robot: the statements of the program, compared with the plant.
//!
//! One line a robot.

use super::plants::{Extra, Made, make};
use crate::prelude::*;
use std::collections::BTreeSet;
use truepose_compensate::{Target, predicted_error};
use truepose_errormodel::configurations;
use truepose_identify::{Folds, Method, Split, cross_validate, fit_again, repeats};
use truepose_report::{SpecificationSummary, largest_error_by_pose};

/// Configurations at which predictions and commands are compared with the plant.
const FRESH: usize = 24;
/// Configurations that stand for all poses, of every so many robots without an extra.
const POPULATION: usize = 4000;
const EVERY: u64 = 3;

/// The statements that are compared with the truth, in the order of the table.
pub const WHAT: [&str; 21] = [
    "constant errors, lengths",
    "constant errors, angles",
    "joint compliances",
    "gap",
    "ratio",
    "size of instant",
    "size of lag",
    "size of settling",
    "size of flank",
    "period",
    "instant",
    "lag",
    "settling",
    "flank",
    "prediction, model",
    "prediction, measured",
    "command, model",
    "command, measured",
    "tolerance",
    "share at least",
    "share at most",
];

/// The robot of a seed.
pub fn run(seed: u64) -> Record {
    let begun = Instant::now();
    let mut record = Record { seed, lack_of_fit: f64::NAN, story: Record::ENDED.into(), ..Record::default() };
    match judged(seed, &mut record) {
        Ok(()) => {}
        Err(error) => record.story = error.to_string().replace([',', '\n'], ";"),
    }
    record.seconds = begun.elapsed().as_secs_f64();
    record
}

fn judged(seed: u64, record: &mut Record) -> Outcome {
    let made = make(seed)?;
    record.robot.clone_from(&made.robot);
    record.extra = made.extra.word();
    let solver = PivotedQr::default();
    let found = fit(&made.model, &made.data, &solver, &FitOptions::default())?;
    record.visits = made.campaign.visits.len();
    record.kappa = found.prior.kappa;
    parameters(&made, &found, record)?;
    // A mesh has more harmonics than are declared.
    if made.extra != Extra::Period
        && let Some(lack) = repeats(&found, &made.data).and_then(|repeats| repeats.lack_of_fit)
    {
        record.lack_of_fit = lack.p_value;
    }
    bands(&made, &found, record)?;
    // Shape parameters are not fitted again fold by fold.
    if made.extra == Extra::None && (seed / 10).is_multiple_of(EVERY) {
        tolerances(&made, &found, record)?;
    }
    Ok(())
}

/// Coefficients with which the reduced model is the plant: its fit to what would be seen without noise. A grouped error stands for
/// others to first order only, and where some of them weigh tenfold (the tool's turn against targets at a hand's breadth) that is not
/// enough to say what it should be.
fn truths(made: &Made, found: &Fit) -> Outcome<Vec<f64>> {
    let mut data = noise_free(&made.plant).measure(&made.campaign, 0)?;
    data.position_sd.clone_from(&made.data.position_sd);
    data.orientation_sd.clone_from(&made.data.orientation_sd);
    data.channels.clone_from(&made.data.channels);
    coefficients_of_plant(found.fitted.model(), found, &data, found.noise)
}

/// Coefficients and shape parameters, whose intervals `identify` and `discover` print.
fn parameters(made: &Made, found: &Fit, record: &mut Record) -> Outcome {
    let model = found.fitted.model();
    let half = found.half_widths();
    let declared = made.model.effects().len();
    let truths = truths(made, found)?;
    for group in &found.reduction.groups {
        let effect = (0..declared).find(|&k| model.columns_of(k).contains(&group.column));
        // Of a spring or a gap that stands for itself the plant's own number.
        let alone = effect != Some(0) && group.members.is_empty();
        let truth = if alone { made.coefficients[group.column] } else { truths[group.column] };
        if truth.is_nan() {
            continue;
        }
        let off = (found.fitted.coefficients()[group.column] - truth).abs();
        let what = match effect {
            Some(0) if model.columns()[group.column].unit == "m" => WHAT[0].to_owned(),
            Some(0) => WHAT[1].to_owned(),
            Some(1) => WHAT[2].to_owned(),
            _ if made.shape.is_some() => format!("size of {}", made.extra.word()),
            _ => made.extra.word().to_owned(),
        };
        record.count(&what, off <= half[group.column]);
        if alone && made.shape.is_some() && !matches!(effect, Some(0 | 1)) {
            let (value, half) = (found.fitted.coefficients()[group.column], half[group.column]);
            let [low, high] = [value - half, value + half];
            record.story += &format!(" size {value:e} [{low:e} {high:e}] truth {truth:e}");
        }
    }
    if let (Some(truth), Some(shape)) = (made.shape, found.shapes.first()) {
        let [low, high] = shape.interval;
        record.story += &format!(" {} {:e} [{low:e} {high:e}] truth {truth:e}", shape.name, shape.value);
        // What is left open says so, and is no interval.
        if !shape.open() {
            let [lower, upper] = shape.interval;
            record.count(&made.extra.word(), (lower..=upper).contains(&truth));
        }
    }
    Ok(())
}

/// Bands of `compensate --report` and `map`, and the covariance of predictions, at configurations that took no part.
fn bands(made: &Made, found: &Fit, record: &mut Record) -> Outcome {
    let (fitted, chain) = (&found.fitted, made.model.chain());
    let mut campaign = made.fresh(FRESH, record.seed + 1_000_000)?;
    let step = campaign.visits.len().div_ceil(FRESH);
    let seen = made.plant.observe(&campaign, record.seed + 2_000_000)?;
    let inputs = seen.data.derived_for(fitted.model())?;
    let mut predictor = fitted.bind(&inputs.schema)?;
    let mut compensator = Compensator::bind(fitted, &inputs.schema, CompensatorOptions::default())?;
    // The first target of each visit.
    let mut commands: Vec<Option<(Vector3<f64>, Conditions)>> = vec![None; campaign.visits.len()];
    for row in (0..inputs.len()).filter(|&row| inputs.visit[row].is_multiple_of(step)) {
        let conditions = inputs.conditions(row);
        let target = inputs.target[row];
        let band = predicted_error(fitted, &mut predictor, &conditions, target);
        let predicted = predictor.predict(&conditions, target).translation;
        let off = |point: Vector3<f64>| (point - predicted).norm();
        record.count(WHAT[14], off(seen.true_positions[row]) <= band.model_95);
        record.count(WHAT[15], off(seen.data.measured_position(row)) <= band.measured_95);
        let visit = inputs.visit[row];
        if row > 0 && inputs.visit[row - 1] == visit {
            continue;
        }
        let nominal = predictor.nominal(&conditions, target);
        let mut wanted = Target::at(nominal.translation).of(target);
        if chain.movable().len() >= 6 {
            wanted = wanted.turned(nominal.rotation);
        }
        let command = compensator.command(&wanted, &conditions, Some(&conditions.joints));
        if command.status == Status::Ok {
            let mut commanded = conditions;
            commanded.joints = command.joints.to_vec();
            campaign.visits[visit].joints.clone_from(&commanded.joints);
            commands[visit] = Some((nominal.translation, commanded));
        }
    }
    // Commands change no side of approach.
    for row in 0..seen.data.len() {
        campaign.visits[seen.data.visit[row]].approach = Some(seen.data.conditions(row).approach);
    }
    let executed = made.plant.observe(&campaign, record.seed + 3_000_000)?;
    for row in 0..executed.data.len() {
        let visit = executed.data.visit[row];
        if row > 0 && executed.data.visit[row - 1] == visit {
            continue;
        }
        let Some((wanted, commanded)) = &commands[visit] else { continue };
        let band = predicted_error(fitted, &mut predictor, commanded, executed.data.target[row]);
        record.count(WHAT[16], (executed.true_positions[row] - wanted).norm() <= band.model_95);
        record.count(WHAT[17], (executed.data.measured_position(row) - wanted).norm() <= band.measured_95);
    }
    Ok(())
}

/// What `--spec` states of all poses, from cross-validated ones.
fn tolerances(made: &Made, found: &Fit, record: &mut Record) -> Outcome {
    let folds = Folds::new(&made.data, &Split::Random { folds: 5, seed: 0 })?;
    let held = cross_validate(found, &made.data, &folds, &PivotedQr::default(), Method::Auto)?;
    let limit = 1.3 * found.noise.floor(typical(&made.data));
    // A pose that was measured twice has two chances to be outside, and those that stand for all poses are measured once.
    let mut met = BTreeSet::new();
    let configuration = configurations(&made.data);
    let once: BTreeSet<usize> =
        (0..configuration.len()).filter(|&visit| met.insert(configuration[visit])).collect();
    let rows: Vec<usize> = (0..made.data.len()).filter(|&row| once.contains(&made.data.visit[row])).collect();
    let position = rows.iter().map(|&row| held.residuals.position[row]).collect();
    let orientation = rows.iter().map(|&row| held.residuals.orientation[row]).collect();
    let seen = Residuals { position, orientation };
    let stated = SpecificationSummary::new(limit, &largest_error_by_pose(&made.data, &rows, &seen));
    let all =
        made.plant.measure(&made.fresh(POPULATION, record.seed + 4_000_000)?, record.seed + 5_000_000)?;
    let rows: Vec<usize> = (0..all.len()).collect();
    let worst = |fit: &Fit| -> Outcome<Vec<f64>> {
        Ok(largest_error_by_pose(&all, &rows, &Residuals::of(&fit.fitted, &all)?))
    };
    let share =
        |worst: &[f64], limit: f64| worst.iter().filter(|v| **v <= limit).count() as f64 / worst.len() as f64;
    let published = worst(found)?;
    if let Some(mm) = stated.tolerance_mm {
        record.count(WHAT[18], share(&published, 1e-3 * mm) >= 0.95);
    }
    record.count(WHAT[19], stated.share_at_least <= share(&published, limit));
    // The fits that were judged saw four fifths of the data; the one of all of it is better, and more poses may be inside.
    let mut judged = 0.0;
    for fold in 0..folds.count {
        let visits = &made.data.visit;
        let rest: Vec<usize> =
            (0..made.data.len()).filter(|&row| folds.of_visit[visits[row]] != fold).collect();
        let other =
            fit_again(found, &made.data.select(&rest), &PivotedQr::default(), &FitOptions::default())?;
        judged += share(&worst(&other)?, limit) / folds.count as f64;
    }
    record.count(WHAT[20], stated.share_at_most >= judged);
    Ok(())
}

/// What the instrument states, in the middle.
fn typical(data: &Dataset) -> f64 {
    upper_median(data.position_sd.iter().flatten().copied())
}

/// Of so many intervals, how many hold the truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Count {
    pub held: usize,
    pub of: usize,
}

/// What became of one robot.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Record {
    pub seed: u64,
    pub robot: String,
    pub extra: String,
    pub visits: usize,
    /// Width of the prior that the data chose.
    #[serde(with = "number")]
    pub kappa: f64,
    /// p of the lack-of-fit test; NaN without one.
    #[serde(with = "number")]
    pub lack_of_fit: f64,
    pub seconds: f64,
    /// By statement.
    pub counts: BTreeMap<String, Count>,
    /// [`Record::ENDED`] with the shape that was found and its truth, or why not.
    pub story: String,
}

impl Record {
    pub const ENDED: &str = "ended";

    pub fn ended(&self) -> bool {
        self.story.starts_with(Record::ENDED)
    }

    /// One more interval.
    pub fn count(&mut self, what: &str, held: bool) {
        let count = self.counts.entry(what.to_owned()).or_default();
        count.of += 1;
        count.held += usize::from(held);
    }
}

//! One robot through `discover`, and what its report says compared with the truth.
//!
//! Of several causes at once: whether the largest are named, and where the true robot ends when it is commanded by the model.

use super::cause::Cause;
use super::description::{Description, Kind};
use super::plant::{Made, fresh_error, make};
use super::record::Record;
use super::size::without;
use super::stream::Key;
use crate::prelude::*;
use truepose_discover::{Diagnosis, DiscoverOptions, diagnose};
use truepose_report::{AlternativeSummary, DiscoverySettings, DiscoverySummary, FindingSummary};

/// Probability above which a name is confident.
const CONFIDENT: f64 = 0.9;
/// A model that predicts worse than the declared one by more than this does harm.
const HARM: f64 = 1.05;

/// A robot to come.
#[derive(Debug, Clone, PartialEq)]
pub struct Task {
    pub kind: Kind,
    pub cell: String,
    pub key: Key,
}

impl Task {
    pub fn of(kind: Kind, cell: &str, half: Half, number: u64) -> Self {
        Task { kind, cell: cell.to_owned(), key: kind.key_in(cell, half, number) }
    }

    /// What is hidden, where anything is.
    pub fn cause(&self) -> Option<Cause> {
        Description::of(self.kind, &self.cell, self.key).cause
    }

    /// What to type for it alone.
    pub fn words(&self) -> String {
        let cell = if self.cell.is_empty() { "-" } else { &self.cell };
        format!("{} \"{cell}\" {}", self.kind.word(), self.key.number)
    }

    /// One line of the table. A refusal and a panic are results as well.
    pub fn run(&self) -> Record {
        let begun = Instant::now();
        let mut record = Record::new(self.key, self.kind, &self.cell);
        let what = Description::of(self.kind, &self.cell, self.key);
        describe(&what, &mut record);
        let ended = caught(|| self.judge(&what, &mut record)).map_or_else(|words| words, |()| "yes".into());
        record.set("ended", ended);
        record.set("seconds", format!("{:.2}", begun.elapsed().as_secs_f64()));
        record
    }

    fn judge(&self, what: &Description, record: &mut Record) -> Outcome {
        let made = make(what, self.key).map_err(|error| format!("no plant: {error}"))?;
        record.set("size", made.size);
        record.set("rows", made.data.len());
        record.set("floor_mm", 1e3 * made.floor);
        let (reported, diagnosis) = look(&made, &made.data)?;
        names(&made, &reported, record)?;
        against_truth(&made, &reported, &diagnosis, record)?;
        if !made.pieces.is_empty() {
            judge_execution(&made, &reported, &diagnosis.fit.fitted, record)?;
        }
        if what.bad_poses > 0 {
            bad_poses(&made, &reported, &diagnosis, record)?;
        }
        Ok(())
    }

    /// The report itself, as text.
    pub fn report(&self) -> Outcome<String> {
        let what = Description::of(self.kind, &self.cell, self.key);
        let made = make(&what, self.key)?;
        let diagnosis = diagnosed(&made, &made.data)?;
        let hidden = made.hidden.as_ref().map_or("nothing hidden".into(), |hidden| {
            format!("{} {} at {:.2} times the noise", hidden.cause.word(), hidden.place(), made.size)
        });
        Ok(format!("{what:#?}\n{hidden}, noise {:.4} mm\n{}", 1e3 * made.floor, summary(&diagnosis)))
    }
}

fn diagnosed(made: &Made, data: &Dataset) -> Outcome<Diagnosis> {
    let options = DiscoverOptions::default();
    Ok(diagnose(&made.robot.chain, &made.declared, data, &PivotedQr::default(), &options, &|_| ())?)
}

fn summary(diagnosis: &Diagnosis) -> DiscoverySummary {
    let options = DiscoverOptions::default();
    let settings = DiscoverySettings {
        seed: options.seed,
        holdout: options.holdout,
        rotations: options.rotations,
        alpha: options.alpha,
    };
    DiscoverySummary::new(diagnosis, settings)
}

fn look(made: &Made, data: &Dataset) -> Outcome<(DiscoverySummary, Diagnosis)> {
    let diagnosis = diagnosed(made, data)?;
    Ok((summary(&diagnosis), diagnosis))
}

/// Whether a finding is a cause, with or without a name; excluded rows are none.
fn is_cause(effect: &&FindingSummary) -> bool {
    effect.family != "outlier"
}

/// The word of a variant in a report.
fn word<T: Serialize>(variant: T) -> Outcome<String> {
    Ok(serde_json::to_value(variant)?.as_str().unwrap_or_default().to_owned())
}

fn describe(what: &Description, record: &mut Record) {
    record.set("make", what.make.word());
    record.set("cause", what.cause.map_or("none".into(), |cause| cause.word()));
    record.set_some("inside", what.cause.and_then(Cause::inside));
    record.set("poses", what.poses);
    record.set("targets", what.targets);
    record.set("repeats", what.repeats);
    record.set("order", what.order.word());
    record.set("memory", what.memory);
    record.set_some("stated", what.stated);
    record.set("bad", what.bad_poses);
}

/// Findings, names and their probabilities.
fn names(made: &Made, reported: &DiscoverySummary, record: &mut Record) -> Outcome {
    let right = |family: &str, joint: &Option<String>| {
        made.hidden.as_ref().is_some_and(|hidden| hidden.is_named(family, joint.as_deref()))
    };
    let is_right = |effect: &FindingSummary| right(&effect.family, &effect.place.joint);
    let is_other = |other: &AlternativeSummary| right(&other.family, &other.place.joint);
    let listed = |effect: &FindingSummary| effect.alternatives.iter().any(is_other);
    let causes: Vec<&FindingSummary> = reported.effects.iter().filter(is_cause).collect();
    let first = causes.first();
    record.set("findings", causes.len());
    record.set("outliers", reported.effects.len() - causes.len());
    record.set("found", causes.iter().any(|effect| is_right(effect)));
    record.set("first", first.map_or("none", |first| first.family.as_str()));
    record.set("first_right", first.is_some_and(|first| is_right(first)));
    record.set("listed", first.is_some_and(|first| is_right(first) || listed(first)));
    let named = || causes.iter().filter(|effect| effect.family != "unmodelled");
    let confident = |effect: &&&FindingSummary| effect.name_probability > CONFIDENT;
    record.set("confident_wrong", named().filter(confident).any(|e| !is_right(e) && !listed(e)));
    // One event for each name of a finding, and one for `none of these`.
    let mut events = Vec::new();
    for effect in named() {
        let others = effect.alternatives.iter().filter(|other| other.family != "unmodelled");
        let others = others.map(|other| (is_other(other), other.probability));
        let mut any = false;
        for (hit, probability) in std::iter::once((is_right(effect), effect.name_probability)).chain(others) {
            any |= hit;
            events.push(format!("{probability:.4}:{}", u8::from(hit)));
        }
        events.push(format!("{:.4}:{}", effect.unnamed_probability, u8::from(!any)));
    }
    record.set("names", events.join("|"));
    record.set("alarm", !causes.is_empty() || reported.unexplained.significant);
    record.set("significant", reported.unexplained.significant);
    record.set("verdict", word(reported.verdict)?);
    // Of the first screen: that of the first finding, or of the last screen where nothing is found.
    let p = first.map_or(reported.unexplained.p_value, |first| first.p_value);
    record.set_some("p_first", p.is_finite().then_some(p));
    record.set_some("autocorrelation", reported.dependence.as_ref().map(|d| d.autocorrelation));
    let words = |e: &FindingSummary| format!("{} {}", e.family, e.place.joint.as_deref().unwrap_or(""));
    let words: Vec<String> = reported.effects.iter().map(words).collect();
    let truth = made.hidden.as_ref().map_or(String::new(), |hidden| hidden.place());
    record.set("words", format!("truth {truth}: {}", words.join("; ")));
    Ok(())
}

/// Repeatability limit, verdict, intervals and predictions compared with the plant.
fn against_truth(
    made: &Made,
    reported: &DiscoverySummary,
    diagnosis: &Diagnosis,
    record: &mut Record,
) -> Outcome {
    if made.hidden.as_ref().is_some_and(|hidden| hidden.cause.is_instrument()) {
        // Fresh positions, repeats and held-out rows of a moving instrument are not in the frame of the truth.
        return Ok(());
    }
    let floor_mm = 1e3 * made.floor;
    let inside = |ci: [f64; 2], truth: f64| (ci[0]..=ci[1]).contains(&truth);
    let limit = &reported.noise_floor;
    record.set("floor_source", word(limit.source)?);
    record.set_some("floor_ratio", limit.rms_mm.map(|mm| mm / floor_mm));
    record.set_some("floor_covered", limit.ci95_mm.map(|ci| inside(ci, floor_mm)));
    let options = DiscoverOptions::default().fit;
    // Fresh positions are those of the robot: without what the instrument adds.
    let beam = made.hidden.as_ref().is_some_and(|hidden| hidden.cause.is_beam());
    let found = diagnosis.fit.fitted.clone();
    let after = fresh_error(&made.truth, &if beam { found.of_robot() } else { found })?;
    let declared = fitted(&made.robot.chain, &made.declared, &made.data, &options)?;
    let declared = fresh_error(&made.truth, &declared.fitted)?;
    // The error of estimation alone: the declared model on the same noise, with nothing hidden.
    let alone = match (&made.hidden, made.seen.bad_poses.len() + made.seen.outliers.len()) {
        (None, 0) => declared,
        _ => nothing_hidden(made)?,
    };
    record.set("fresh_mm", 1e3 * after);
    record.set("fresh_ratio", after / alone.max(1e-12));
    // Of a held-out row, with its noise: over that of the robot without the cause, whose model has nothing more to estimate.
    record.set("held_ratio", after.hypot(made.floor) / alone.hypot(made.floor));
    if let Some(oracle) = oracle(made)? {
        record.set("oracle_ratio", after.hypot(made.floor) / oracle.hypot(made.floor));
    }
    record.set("declared_ratio", declared / alone.max(1e-12));
    record.set("harm", after > HARM * declared);
    record.set("left", without(after, alone) / made.floor);
    let noise = noise_of(&made.seen, &diagnosis.holdout_rows);
    record.set("ratio", diagnosis.after.holdout.positions().rms / noise.max(1e-12));
    // A held-out row has the error of the model, that of the instrument's beam included, and its own noise.
    let mut expected = [0.0; 2];
    for (expected, fit) in expected.iter_mut().zip([&diagnosis.declared, &diagnosis.fit]) {
        *expected = 1e3 * fresh_error(&made.shown, &fit.fitted)?.hypot(made.floor);
    }
    for (column, ci, truth) in [
        ("before_covered", reported.before.holdout_used().ci95_mm, expected[0]),
        ("after_covered", reported.after.holdout_used().ci95_mm, expected[1]),
        ("gain_covered", reported.gain.as_ref().map(|gain| gain.ci95_mm), expected[0] - expected[1]),
    ] {
        record.set_some(column, ci.map(|ci| inside(ci, truth)));
    }
    Ok(())
}

/// Fresh error of the declared model of the robot with nothing hidden, fitted to its record with the same noise, m.
fn nothing_hidden(made: &Made) -> Outcome<f64> {
    let options = DiscoverOptions::default().fit;
    let found = fitted(&made.robot.chain, &made.clean_declared, &made.clean, &options)?;
    fresh_error(&made.clean_truth, &found.fitted)
}

/// Fresh error of the model with the right effect declared, fitted to the same record, m; none where there is no such effect.
fn oracle(made: &Made) -> Outcome<Option<f64>> {
    let chain = &made.robot.chain;
    let Some(right) = made.hidden.as_ref().and_then(|hidden| hidden.right(chain)) else { return Ok(None) };
    let declared: Vec<_> = made.declared.iter().cloned().chain([right]).collect();
    let model = ErrorModel::new(chain.clone(), declared)?;
    let data = made.data.derived_for(&model)?;
    let fitted = fit(&model, &data, &PivotedQr::default(), &DiscoverOptions::default().fit)?.fitted;
    Ok(Some(fresh_error(&made.truth, &fitted.of_robot())?))
}

/// Whether poses that were displaced as a whole are reported, and what they change.
fn bad_poses(
    made: &Made,
    reported: &DiscoverySummary,
    diagnosis: &Diagnosis,
    record: &mut Record,
) -> Outcome {
    let outliers = || reported.effects.iter().filter(|effect| !is_cause(effect));
    let rows_of = |pose: usize| -> Vec<usize> {
        (0..made.data.len()).filter(|&row| made.seen.data.visit[row] == pose).map(|row| row + 1).collect()
    };
    let listed = |row: &usize| outliers().any(|effect| effect.rows.contains(row));
    let bad = &made.seen.bad_poses;
    let whole = bad.iter().filter(|&&pose| rows_of(pose).iter().all(listed)).count();
    let partly = bad.iter().filter(|&&pose| rows_of(pose).iter().any(listed)).count();
    let bad_rows: Vec<usize> = bad.iter().flat_map(|&pose| rows_of(pose)).collect();
    let others = outliers().flat_map(|effect| &effect.rows).filter(|row| !bad_rows.contains(row)).count();
    // A suspect is told as well, as a row that no fit uses.
    let suspect = |row: &usize| diagnosis.suspects.contains(&(row - 1));
    let known = bad.iter().filter(|&&pose| rows_of(pose).iter().all(|r| listed(r) || suspect(r)));
    record.set("bad_known", known.count());
    // Of the noise of one row along one axis: what the noise, if it were known, would let be seen.
    let moved = |row: usize| (made.data.measured_position(row) - made.clean.measured_position(row)).norm();
    let least = bad_rows.iter().map(|row| moved(row - 1)).fold(f64::INFINITY, f64::min);
    record.set("bad_least", least / (made.floor / 3f64.sqrt()));
    record.set("bad_reported", whole);
    record.set("bad_partly", partly);
    record.set("other_reported", others);
    let (without, clean) = look(made, &made.clean)?;
    if let (Some(with), Some(without)) = (reported.noise_floor.rms_mm, without.noise_floor.rms_mm) {
        record.set("bad_floor_ratio", with / without);
    }
    let error = fresh_error(&made.truth, &diagnosis.fit.fitted)?;
    record.set("bad_fresh_ratio", error / fresh_error(&made.truth, &clean.fit.fitted)?.max(1e-12));
    Ok(())
}

/// How many of the largest causes have to be named.
const LARGEST: usize = 2;

/// Fills the record's columns.
fn judge_execution(
    made: &Made,
    reported: &DiscoverySummary,
    fitted: &FittedModel,
    record: &mut Record,
) -> Outcome {
    let named = |piece: &super::hidden::Piece| {
        let mut causes = reported.effects.iter().filter(is_cause);
        causes.any(|effect| piece.is_named(&effect.family, effect.place.joint.as_deref()))
    };
    let words: Vec<String> = made
        .pieces
        .iter()
        .map(|(piece, size)| {
            let joint = piece.joint.as_ref().map_or("", |(_, name)| name.as_str());
            let found = if named(piece) { "named" } else { "not named" };
            format!("{:?} {joint} {size:.2} {found}", piece.share)
        })
        .collect();
    record.set("found", made.pieces.iter().take(LARGEST).all(|(piece, _)| named(piece)));
    record.set("words", format!("{} | {}", words.join("; "), record.text("words")));
    let (before, after, refused) = executed(made, fitted)?;
    record.set("executed_before", before.hypot(made.floor) / made.floor);
    record.set("executed", after.hypot(made.floor) / made.floor);
    record.set("executed_refused", refused);
    Ok(())
}

/// 3-D RMS distance of the true robot, without noise, from where the nominal one would be at fresh configurations, m: commanded so, and
/// by the model; and how many commands the model refuses.
fn executed(made: &Made, fitted: &FittedModel) -> Outcome<(f64, f64, usize)> {
    let chain = fitted.chain();
    let data = made.truth.derived_for(fitted.model())?;
    let mut compensator = Compensator::bind(fitted, &data.schema, CompensatorOptions::default())?;
    let mut fresh = made.fresh.clone();
    let (mut rows, mut wanted) = (Vec::new(), Vec::new());
    for row in 0..data.len() {
        let visit = data.visit[row];
        if rows.last().is_some_and(|&last: &usize| data.visit[last] == visit) {
            continue;
        }
        let conditions = data.conditions(row);
        let (position, goal) = nominal_goal(chain, &conditions, data.target[row]);
        let command = compensator.command(&goal, &conditions, Some(&conditions.joints));
        if command.status == Status::Ok {
            fresh.visits[visit].joints = command.joints.to_vec();
            rows.push(row);
            wanted.push(position);
        }
    }
    let refused = fresh.visits.len() - rows.len();
    let seen = made.quiet.observe(&fresh, made.fresh_seed)?;
    let of = |at: &dyn Fn(usize) -> Vector3<f64>| {
        let square = |(&row, wanted): (&usize, &Vector3<f64>)| (at(row) - wanted).norm_squared();
        (rows.iter().zip(&wanted).map(square).sum::<f64>() / rows.len().max(1) as f64).sqrt()
    };
    let before = of(&|row| made.truth.measured_position(row));
    Ok((before, of(&|row| seen.true_positions[row]), refused))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_found_and_named_on_robots_that_they_have_not_seen() {
        // Every sixth row: the study has them all, and a search takes half a minute here. A linkage needs two neighbouring joints of short
        // travel, which few robots have.
        let rows = Cause::with_word().iter().filter(|cause| **cause != Cause::FourBar).step_by(6);
        let rows: Vec<&Cause> = rows.collect();
        let wrong = |cause: &&Cause| {
            let run = |number| Task::of(Kind::Words, &cause.word(), Half::Tuning, number).run();
            let record = (0..20).map(run).find(|record| !record.text("ended").starts_with("no plant"));
            let Some(record) = record else { return Some(format!("{}: no robot", cause.word())) };
            let beside = record.number("oracle_ratio").unwrap_or(1.0);
            let good = record.yes("listed") == Some(true) && beside < 1.5;
            (!good).then(|| format!("{} {beside}", record.text("words")))
        };
        let wrong: Vec<String> = rows.par_iter().filter_map(wrong).collect();
        assert!(wrong.is_empty(), "{wrong:#?}");
    }
}

//! What seems wrong with measurements, or with the description of the robot, before anything is fitted.

use super::nominal::Nominal;
use std::path::Path;
use truepose_errormodel::{Dataset, Moving};
use truepose_identify::{Cause, Suspicion, suspicions};
use truepose_kinematics::{Chain, JointKind};
use truepose_report::{DataCheck, significant, suspicion_text};

/// What seems wrong, in words, and which rows a fit does better without.
#[derive(Debug)]
pub struct Mistakes {
    /// Each with the name of the file.
    pub words: Vec<String>,
    /// Rows (from 0, ascending) in which one mistake is known.
    mistaken: Vec<usize>,
    /// Whether one mistake about all rows explains them.
    whole: bool,
    /// The robot as it is described, with the data.
    pub nominal: Nominal,
}

impl Mistakes {
    /// Of a robot and its measurements.
    pub fn of(chain: &Chain, data: &Dataset, file: &Path) -> Self {
        if let Some(words) = moving(chain, data, file) {
            // Nothing else is known of rows that were measured on the way.
            let nominal = Nominal::of(chain, Some(data), &[]);
            return Mistakes { words: vec![words], mistaken: Vec::new(), whole: true, nominal };
        }
        let found = suspicions(chain, data);
        let nominal = Nominal::of(chain, Some(data), &found);
        let one = |found: &Suspicion| suspicion_text(chain, found, &data.line);
        let words = found.iter().map(one).chain(nominal.warnings(chain));
        let words = words.map(|words| format!("{}: {words}", file.display())).collect();
        let mut mistaken: Vec<usize> =
            found.iter().flat_map(|found| in_rows(&found.cause)).copied().collect();
        mistaken.sort_unstable();
        mistaken.dedup();
        let single = |cause: &Cause| {
            matches!(cause, Cause::StrayRows { .. } | Cause::BaseElsewhere) || !in_rows(cause).is_empty()
        };
        let whole = found.iter().any(|found| !single(&found.cause)) || nominal.misread_throughout();
        Mistakes { words, mistaken, whole, nominal }
    }

    /// The data without the rows in which one mistake is known, and what is stated before every result.
    pub fn set_aside(&self, data: &Dataset) -> (Option<Dataset>, DataCheck) {
        let (rest, check) = (self.mistaken.is_empty(), self.check());
        if rest {
            return (None, check);
        }
        let kept: Vec<usize> =
            (0..data.len()).filter(|row| self.mistaken.binary_search(row).is_err()).collect();
        let rows_left_out = self.mistaken.iter().map(|row| row + 1).collect();
        (Some(data.select(&kept)), DataCheck { rows_left_out, ..check })
    }

    /// What is stated before every result of all rows.
    pub fn check(&self) -> DataCheck {
        DataCheck { suspected: self.words.clone(), rows_left_out: Vec::new(), in_doubt: self.whole }
    }
}

/// What is stated of a log in which the robot moves.
fn moving(chain: &Chain, data: &Dataset, file: &Path) -> Option<String> {
    let found = Moving::of(data)?;
    let speed = found.speed.map_or_else(String::new, |(speed, joint)| {
        let joint = chain.joint(chain.movable()[joint]);
        let (speed, unit) = match joint.kind {
            JointKind::Prismatic => (1e3 * speed, "mm/s"),
            _ => (speed.to_degrees(), "°/s"),
        };
        format!(" at {} {unit} ({}, median)", significant(speed, 2), joint.name)
    });
    let rate =
        found.rate.map_or_else(String::new, |rate| format!(", {} rows per second", significant(rate, 3)));
    let file = file.display();
    let advice = match found.rate {
        Some(_) => format!(
            "`truepose dwell {file} --robot ROBOT --out FILE` finds the dwells in it, and the lag between the clocks of joints and \
             instrument"
        ),
        None => format!(
            "log the time of each row (column `time[s]`), for `truepose dwell {file} --robot ROBOT --out FILE` to find the dwells"
        ),
    };
    Some(format!(
        "{file}: the robot moves{speed} in {} of {}{rate}: a fit needs rows that were measured in dwells. {advice}",
        found.rows,
        truepose_report::count(data.len(), "row")
    ))
}

/// The rows of a mistake that was made in some rows.
fn in_rows(cause: &Cause) -> &[usize] {
    match cause {
        Cause::SwappedLabels { rows, .. } | Cause::InSomeRows { rows, .. } => rows,
        _ => &[],
    }
}

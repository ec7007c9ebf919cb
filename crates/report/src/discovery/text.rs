//! A discovery as text for a terminal: verdict, error budget, each finding.

use super::effects::ONLY_JOINTLY;
use super::{DiscoverySummary, FindingSummary};
use crate::document::{Block, Document, Only};
use crate::wording::heading;
use crate::wording::p_text;
use crate::{SpecificationLines, count, significant};
use std::fmt;
use truepose_discover::{Family, HeldOut};

/// Width of the longest bar of the error budget.
const BAR: f64 = 34.0;

/// Rejected candidates and untestable hypotheses that are listed.
const LISTED: usize = 6;

/// The line of a budget that leaves excluded rows out.
pub(crate) const WITHOUT_EXCLUDED: &str = "without the excluded rows";

impl fmt::Display for DiscoverySummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", heading(&self.robot, self.rows, self.visits))?;
        write!(f, "{}", self.data_check)?;
        if let Some(observers) = &self.observers {
            writeln!(f, "\n{}", observers.sentence().trim_end())?;
        }
        write!(f, "\n{}\n{}", self.judgement(), self.evidence())?;
        let used = self.before.holdout_used();
        writeln!(
            f,
            "\n{} {} ({}), mm\n",
            match &self.partial_rows {
                None => "RMS of the 3-D position error",
                Some(_) => "RMS of the position error over the measured components",
            },
            self.held_out_rows(),
            count(used.count, "row")
        )?;
        self.error_budget(f)?;
        write!(f, "{}", self.observations())?;
        for (number, effect) in (1..).zip(&self.effects) {
            writeln!(f, "\n{number}. {}", effect.name())?;
            effect.details(f)?;
        }
        self.not_added(f)
    }
}

impl DiscoverySummary {
    /// The verdict with the figures that decide it.
    pub(crate) fn judgement(&self) -> Document {
        let mut document = Document::default();
        document.verdict(self.adequacy());
        document.sentences([self.answer(), self.result()]);
        document.sentences(&self.assumed);
        document.sentences(self.partial_rows.as_ref().map(crate::PartialRows::sentence));
        document.sentences(self.beside());
        document.sentence(&self.noise_floor.sentence());
        SpecificationLines::show(self.specification.as_ref(), &mut document);
        document.sentence(&self.termination());
        document.sentences(self.dependence.as_ref().and_then(|found| found.sentence()));
        document.sentences(self.joint_repeatability.as_ref().map(|joints| joints.sentence()));
        document
    }

    /// Nested cross-validation, the residual of the declared model, and whether the poses are too few.
    pub(crate) fn evidence(&self) -> Document {
        let mut document = Document::default();
        if let Some(nested) = &self.nested {
            document.sentence(&self.nested_sentence().unwrap_or_default());
            for (number, (found, after)) in (1..).zip(nested.found.iter().zip(&nested.after_by_fold)) {
                let names = if found.is_empty() { "no finding".into() } else { found.join(", ") };
                let rms = significant(after.rms_mm, 3);
                document.push(Only::Both, Block::Item(format!("fold {number}, {rms} mm: {names}")));
            }
            document.push(Only::Both, Block::Gap);
        }
        document.sentence(&self.residual());
        document.sentences(self.too_few_poses.map(|few| few.sentence()));
        document
    }

    /// What each kind of observation, each landmark and each session leaves.
    pub(crate) fn observations(&self) -> Document {
        let mut document = Document::default();
        if let Some(kinds) = &self.kinds {
            kinds.show(" (the effects were chosen with these rows)", &mut document);
        }
        if let Some(landmarks) = &self.landmarks {
            document.push(Only::Both, Block::Gap);
            document.sentence(&format!("{} The effects were chosen with these rows.", landmarks.sentences()));
            landmarks.show(&mut document);
        }
        crate::sessions::show(&self.sessions, &mut document);
        document
    }

    fn not_added(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.refused.is_empty() && self.not_testable.is_empty() {
            return Ok(());
        }
        writeln!(f)?;
        for refused in self.refused.iter().take(LISTED) {
            writeln!(f, "not added: {} ({})", refused.name(), refused.reason)?;
        }
        if !self.not_testable.is_empty() {
            let names: Vec<String> = self.not_testable.iter().take(LISTED).map(|u| u.name()).collect();
            let more = self.not_testable.len() - names.len();
            let rest = if more > 0 { format!(" and {more} more") } else { String::new() };
            writeln!(f, "not testable with this data: {}{rest}", names.join(", "))?;
            let first = self.not_testable.iter().find(|u| !u.advice.is_empty());
            if let Some(first) = first {
                writeln!(f, "   {}: {}", first.name(), first.advice)?;
            }
        }
        Ok(())
    }

    fn error_budget(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Of all held-out rows, as the figures of the effects are; without the excluded ones in a line that says so.
        let mut lines = vec![("declared model".to_owned(), self.before.holdout.rms_mm)];
        let effects: Vec<_> = self.effects.iter().filter(|e| e.family != Family::Outlier.word()).collect();
        let nested = self.held_out == HeldOut::NestedFolds;
        for (k, effect) in effects.iter().enumerate() {
            let last = k + 1 == effects.len() && !nested;
            let after = if last { self.after.holdout.rms_mm } else { effect.holdout_rms_mm.after };
            lines.push((format!("+ {}", effect.name()), after));
        }
        if nested && !effects.is_empty() {
            lines.push(("search in nested folds".to_owned(), self.after.holdout.rms_mm));
        }
        if let Some(without) = self.after.holdout_without_outliers {
            lines.push((WITHOUT_EXCLUDED.to_owned(), without.rms_mm));
        }
        if let Some(limit) = self.noise_floor_mm {
            lines.push((self.noise_floor.name().to_owned(), limit));
        }
        let width = lines.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
        let most = lines.iter().map(|(_, v)| *v).fold(f64::MIN_POSITIVE, f64::max);
        for (name, value) in &lines {
            let length = (BAR * value / most).round().max(if *value > 0.0 { 1.0 } else { 0.0 }) as usize;
            let pad = width - name.chars().count();
            writeln!(
                f,
                "  {name}{}  {:>7}  {}",
                " ".repeat(pad),
                significant(*value, 3),
                "█".repeat(length)
            )?;
        }
        Ok(())
    }
}

impl FindingSummary {
    fn details(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "   {}", self.meaning)?;
        for parameter in self.parameters.iter().take(4) {
            let (value, unit) = crate::parameter_text(parameter);
            writeln!(f, "   {} = {value} {unit}", parameter.name)?;
        }
        if self.parameters.len() > 4 {
            writeln!(f, "   and {} more coefficients", self.parameters.len() - 4)?;
        }
        if self.only_jointly {
            writeln!(f, "   {ONLY_JOINTLY}")?;
        }
        if self.family == Family::Outlier.word() {
            writeln!(f, "   {}", self.places(12))?;
            if !self.poses.is_empty() {
                let poses: Vec<String> = self.poses.iter().take(6).filter_map(|rows| pose(rows)).collect();
                writeln!(
                    f,
                    "   {} displaced as a whole (rows {}): the robot had not settled, its joint values were stale, or the reflector moved",
                    count(self.poses.len(), "pose measurement"),
                    poses.join("; ")
                )?;
            }
            return Ok(());
        }
        let existence = std::iter::once(p_text(self.p_value));
        let existence: Vec<String> = existence
            .chain(
                self.selection()
                    .into_iter()
                    .map(|words| words.replace("cross-validated RMS", "cross-validated")),
            )
            .collect();
        writeln!(f, "   existence: {}", existence.join(", "))?;
        writeln!(f, "   name (probability): {}", self.names())?;
        if let Some(assumption) = self.assumption() {
            writeln!(f, "   {assumption}")?;
        }
        let listed = self.alternatives.iter().enumerate().filter(|(k, other)| *k < 2 || other.simplest);
        for (_, other) in listed {
            let relation = match (other.simplest, other.equivalent) {
                (true, _) => "simplest that is not distinguishable:",
                (false, true) => "not distinguishable from",
                (false, false) => "competing hypothesis:",
            };
            writeln!(
                f,
                "   {relation} {} ({} mm held out)",
                other.name(),
                significant(other.holdout_rms_mm, 3)
            )?;
        }
        Ok(())
    }
}

/// `13–15`, or `13, 20` where other rows are between.
fn pose(rows: &[usize]) -> Option<String> {
    let (first, last) = (rows.first()?, rows.last()?);
    Some(match last - first + 1 == rows.len() && rows.len() > 1 {
        true => format!("{first}–{last}"),
        false => rows.iter().map(ToString::to_string).collect::<Vec<_>>().join(", "),
    })
}

//! A discovery as a story for a terminal: before, each effect, after.

use super::{
    DiscoverySummary, FindingSummary, NestedSummary, NoiseFloorSummary, Reference, WithdrawnSummary,
};
use crate::{PositionSpread, count, significant};
use std::fmt;
use truepose_discover::{Check, Doubt, Family, FloorSource, Stop, Verdict};

/// Width of the longest bar of the waterfall.
const BAR: f64 = 34.0;

impl fmt::Display for DiscoverySummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{}: {}, {}",
            self.robot,
            count(self.rows, "row"),
            count(self.visits, "pose measurement")
        )?;
        writeln!(f, "\n{}", self.question())?;
        if let Some(few) = &self.too_few_poses {
            writeln!(f, "{}", few.words())?;
        }
        let judged = self.before.judged();
        writeln!(
            f,
            "\nRMS of the 3-D position error on the held-out test set ({}), mm\n",
            count(judged.count, "row")
        )?;
        self.waterfall(f)?;
        for (number, effect) in (1..).zip(&self.effects) {
            writeln!(f, "\n{number}. {}", effect.words())?;
            effect.story(f)?;
        }
        writeln!(f, "\n{}", self.ending())?;
        if let Some(nested) = &self.nested {
            writeln!(f, "{}", nested.words())?;
            for (number, (found, after)) in (1..).zip(nested.found.iter().zip(&nested.after_by_fold)) {
                let words = if found.is_empty() { "nothing".into() } else { found.join(", ") };
                writeln!(f, "  fold {number}, {} mm: {words}", significant(after.rms_mm, 3))?;
            }
        }
        for refused in self.refused.iter().take(6) {
            let words = format!("{} {}", refused.family, refused.place.words());
            writeln!(f, "  refused: {} – {}", words.trim_end(), refused.reason)?;
        }
        if !self.not_testable.is_empty() {
            let words: Vec<String> = self
                .not_testable
                .iter()
                .take(6)
                .map(|u| format!("{} {}", u.family, u.place.words()).trim_end().to_owned())
                .collect();
            let more = self.not_testable.len().saturating_sub(words.len());
            let rest = if more > 0 { format!(" and {more} more") } else { String::new() };
            writeln!(f, "  this data cannot test: {}{rest}", words.join(", "))?;
        }
        Ok(())
    }
}

impl NestedSummary {
    /// Before and after in whole runs with a fold left out, and what that means.
    pub(crate) fn words(&self) -> String {
        let (before, after) = (self.before.rms_mm, self.after.rms_mm);
        let worse = if after > before {
            " The declared model alone predicts better: do not rely on what was found."
        } else {
            ""
        };
        format!(
            "The whole loop inside each fold ({}): {} → {} mm RMS on rows that no choice has seen.{worse}",
            self.folds,
            significant(before, 3),
            significant(after, 3)
        )
    }
}

impl DiscoverySummary {
    /// What the declared model leaves, and against what that is held.
    pub(crate) fn question(&self) -> String {
        let left = significant(self.before.judged_train().rms_mm, 3);
        match (self.lack_of_fit.against, self.lack_of_fit.before, self.lack_of_fit.pure_error_mm) {
            (Reference::Repeats, Some(p), Some(pure)) => format!(
                "Residual of the declared model: {left} mm RMS. Repeatability (pure error): {} mm (lack of fit p = {}).",
                significant(pure, 3),
                significant(p, 2)
            ),
            _ => format!(
                "Residual of the declared model: {left} mm RMS. No repeated poses: significance comes from a resampling test (sign \
                 flips of whole poses)."
            ),
        }
    }

    fn waterfall(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut lines = vec![("declared model".to_owned(), self.before.judged().rms_mm)];
        let found: Vec<_> = self.effects.iter().filter(|e| e.family != Family::Outlier.word()).collect();
        for (k, effect) in found.iter().enumerate() {
            let last = k + 1 == found.len();
            let after = if last { self.after.judged().rms_mm } else { effect.holdout_rms_mm.after };
            lines.push((format!("+ {}", effect.words()), after));
        }
        if let Some(floor) = self.noise_floor_mm {
            lines.push((self.noise_floor.name().to_owned(), floor));
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

    fn ending(&self) -> String {
        let specification = self.specification.map_or_else(String::new, |s| format!("\n{}", s.words()));
        format!("{}{specification}\n{}", self.result(), self.why())
    }

    /// Before and after on the held-out test set, with the repeatability limit.
    pub(crate) fn result(&self) -> String {
        let pair = |before: PositionSpread, after: PositionSpread| {
            format!("{} → {} mm", significant(before.rms_mm, 3), significant(after.rms_mm, 3))
        };
        let all = pair(self.before.holdout, self.after.holdout);
        let figures = match (self.before.holdout_without_outliers, self.after.holdout_without_outliers) {
            (Some(before), Some(after)) => format!(
                "{} on the held-out test set without {}, {all} with {}",
                pair(before, after),
                count(self.after.holdout.count - after.count, "row that is reported as an outlier"),
                if self.after.holdout.count - after.count == 1 { "it" } else { "them" }
            ),
            _ => format!("{all} on the held-out test set"),
        };
        format!("{figures}. {}", self.noise_floor.words())
    }

    /// Why the loop stopped, and what that means.
    pub(crate) fn why(&self) -> String {
        let p = format!("(p = {})", significant(self.unexplained.p_value, 2));
        let found = self.effects.iter().filter(|e| e.family != Family::Outlier.word()).count();
        let why = match self.stopped {
            Stop::NothingLeft if found == 0 => {
                format!("No effect beyond the declared model is significant {p}.")
            }
            Stop::NothingLeft => format!("No further effect is significant {p}."),
            Stop::NothingConvincing => {
                format!("Something is left {p}, but no candidate passed all tests.")
            }
            Stop::Circling => format!(
                "Something is left {p}, and the search came back to the same candidates: which of them it is stays undecided."
            ),
            Stop::Withdrawn => self.withdrawn.as_ref().map_or_else(String::new, WithdrawnSummary::words),
            Stop::Interrupted => "The run was ended before its end; something may be left.".into(),
            Stop::Limit => format!("As many effects as were allowed were added {p}; something may be left."),
            _ => String::new(),
        };
        let verdict = match (self.verdict, self.unexplained.rms_mm) {
            (Verdict::Adequate, _) => "The model is adequate: what is left is not significant against repeatability.".into(),
            (Verdict::Unexplained, Some(left)) if left > 0.0 => format!(
                "{} mm of {} mm are not explained by any effect of the model.",
                significant(left, 2),
                significant(self.after.judged_train().rms_mm, 3)
            ),
            (Verdict::Unexplained, _) => match self.lack_of_fit.after {
                Some(p) if self.stopped == Stop::NothingLeft => {
                    format!("The lack of fit against repeated poses is significant (p = {}): something is left.", significant(p, 2))
                }
                _ => "What is left is more than noise.".into(),
            },
            (Verdict::Undecided, _) if self.noise_floor.source == FloorSource::Unknown => {
                "Whether anything is left cannot be decided without repeated poses: measure ten or more of them twice.".into()
            }
            _ => "Whether anything is left is not decided.".to_owned(),
        };
        format!("{why} {verdict}").trim().to_owned()
    }
}

impl NoiseFloorSummary {
    fn name(&self) -> &'static str {
        match self.source {
            FloorSource::Stated => "instrument",
            _ => "repeatability",
        }
    }

    /// The limit with its source, in a sentence.
    pub(crate) fn words(&self) -> String {
        let Some(rms) = self.rms_mm else {
            return "Repeatability limit: unknown (no repeated poses, no stated accuracy).".into();
        };
        let rms = significant(rms, 3);
        match (self.source, self.ci95_mm) {
            (FloorSource::Repeats, Some([lower, upper])) => format!(
                "Repeatability limit: {rms} mm ({} to {} mm; from repeats).",
                significant(lower, 2),
                significant(upper, 2)
            ),
            (FloorSource::Stated, _) => {
                format!(
                    "Repeatability limit: at least {rms} mm (stated accuracy of the instrument; no repeated poses)."
                )
            }
            _ => format!("Repeatability limit: {rms} mm (from repeats)."),
        }
    }
}

impl WithdrawnSummary {
    /// What was withdrawn, where it failed, and what stands.
    pub(crate) fn words(&self) -> String {
        let rows = match self.check {
            Check::Refits => "in cross-validation by refits",
            Check::UnsearchedRows => "on training rows outside of the sample that was searched",
            Check::NestedFolds => "in nested cross-validation of the whole search",
            Check::TestSet => "on the held-out test set",
        };
        format!(
            "Withdrawn: {}. With {}, the model predicts unseen data worse than the declared model ({} → {} mm {rows}). The declared model stands.",
            self.findings.join(", "),
            if self.findings.len() == 1 { "it" } else { "them" },
            significant(self.declared_rms_mm, 3),
            significant(self.enlarged_rms_mm, 3),
        )
    }
}

impl FindingSummary {
    fn story(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "   {}", self.meaning)?;
        for parameter in self.parameters.iter().take(4) {
            let (value, unit) = crate::parameter_words(parameter);
            writeln!(f, "   {} = {value} {unit}", parameter.name)?;
        }
        if self.parameters.len() > 4 {
            writeln!(f, "   and {} more coefficients", self.parameters.len() - 4)?;
        }
        if self.family == Family::Outlier.word() {
            let rows: Vec<String> = self.rows.iter().take(12).map(ToString::to_string).collect();
            return writeln!(f, "   rows {}", rows.join(", "));
        }
        writeln!(
            f,
            "   p = {}, selected in {} % of half-samples, cross-validated {} → {} mm",
            significant(self.p_value, 2),
            significant(100.0 * self.stability, 3),
            significant(self.cross_validated_rms_mm.before, 3),
            significant(self.cross_validated_rms_mm.after, 3)
        )?;
        for other in self.alternatives.iter().take(2) {
            let words = format!("{} {}", other.family, other.place.words());
            let told = if other.equivalent { "not distinguishable from" } else { "competing hypothesis:" };
            writeln!(
                f,
                "   {told} {} ({} mm held out)",
                words.trim_end(),
                significant(other.holdout_rms_mm, 3)
            )?;
        }
        Ok(())
    }
}

/// Why a candidate was refused.
pub(super) fn doubt_words(doubt: Doubt) -> &'static str {
    match doubt {
        Doubt::Chance => "not significant",
        Doubt::NotPredictive => "no better on configurations that it has not seen (cross-validation)",
        Doubt::TooSmall => "gain too small to matter",
        Doubt::Unstable => "not selected in every half of the data",
        Doubt::NothingNew => "the model has it already",
        Doubt::NotConverged => "the fit with it does not converge",
        Doubt::WorseFit => "the fit with it leaves a larger training error",
        Doubt::WorseUnseen => "refitted with it, the model predicts unseen poses no better",
        Doubt::NotSignificant => "its coefficients are not significant in the refitted model",
        Doubt::NotPhysical => "its sign or size is one that no mechanism has",
        _ => "refused",
    }
}

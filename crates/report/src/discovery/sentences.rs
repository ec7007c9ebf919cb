//! The sentences of a discovery, which terminal and page share.

use super::{DiscoverySummary, FindingSummary, NestedSummary, NoiseReference, WithdrawnSummary};
use crate::statistics::interval_text;
use crate::wording::p_text;
use crate::{PositionStatistics, count, significant};
use truepose_discover::{Check, Family, HeldOut, Termination};

impl DiscoverySummary {
    /// The verdict: what the declared model lacks.
    pub(crate) fn answer(&self) -> String {
        let named = |effect: &&FindingSummary| effect.family != Family::Outlier.word();
        let names: Vec<String> = self.effects.iter().filter(named).map(FindingSummary::claim).collect();
        let answer = match (names.len(), self.stopped) {
            (0, Termination::NothingLeft) => "No effect beyond the declared model was found.".to_owned(),
            (0, Termination::Withdrawn) => {
                "The declared model is kept: the findings did not hold on unseen data.".to_owned()
            }
            (0, _) => {
                "No effect was found that can be added to the declared model with confidence.".to_owned()
            }
            (1, _) => format!("The declared model lacks one effect: {}.", names.join(", ")),
            (count, _) => format!("The declared model lacks {count} effects: {}.", names.join(", ")),
        };
        let answer = match self.data_check.in_doubt && !names.is_empty() {
            true => format!(
                "With the data as it is the search adds {}; that is no finding about the robot.",
                names.join(", ")
            ),
            false => answer,
        };
        let outliers =
            self.effects.iter().filter(|effect| !named(effect)).map(|effect| effect.rows.len()).sum();
        let answer = match outliers {
            0 => answer,
            1 => format!("{answer} 1 row is reported as an outlier."),
            rows => format!("{answer} {rows} rows are reported as outliers."),
        };
        let (word, numbers): (_, Vec<String>) = match self.suspect_lines.len() == self.suspect_rows.len() {
            true => ("line", self.suspect_lines.iter().take(12).map(ToString::to_string).collect()),
            false => ("row", self.suspect_rows.iter().take(12).map(ToString::to_string).collect()),
        };
        match self.suspect_rows.len() {
            0 => answer,
            1 => format!("{answer} The row in {word} {} is suspect: no fit uses it.", numbers[0]),
            count => {
                format!(
                    "{answer} {count} rows are suspect ({word}s {}): no fit uses them.",
                    numbers.join(", ")
                )
            }
        }
    }

    /// Residual of the declared model, and the noise estimate behind each significance.
    pub(crate) fn residual(&self) -> String {
        let rms = significant(self.before.train_used().rms_mm, 3);
        match (self.lack_of_fit.against, self.lack_of_fit.before, self.lack_of_fit.pure_error_mm) {
            (NoiseReference::Repeats, Some(p), Some(_)) => format!(
                "Residual of the declared model: {rms} mm RMS. Lack of fit against repeats: {}.",
                p_text(p)
            ),
            _ => format!(
                "Residual of the declared model: {rms} mm RMS. No repeated poses: significance comes from a rotation test of the \
                 residual."
            ),
        }
    }

    /// Position error before and after, on held-out rows.
    pub(crate) fn result(&self) -> String {
        let pair = |before: PositionStatistics, after: PositionStatistics| match self.effects.is_empty() {
            true => after.rms_text(),
            false => {
                let ends = |s: PositionStatistics| interval_text(s.ci95_mm);
                let (from, to) = (significant(before.rms_mm, 3), significant(after.rms_mm, 3));
                format!("{from}{} → {to}{} mm", ends(before), ends(after))
            }
        };
        let rows = self.held_out_rows();
        let all = pair(self.before.holdout, self.after.holdout);
        let figures = match (self.before.holdout_without_outliers, self.after.holdout_without_outliers) {
            (Some(before), Some(after)) => format!(
                "{} {rows} without {} that no fit uses, {all} with {}",
                pair(before, after),
                count(self.after.holdout.count - after.count, "row"),
                if self.after.holdout.count - after.count == 1 { "it" } else { "them" }
            ),
            _ => format!("{all} {rows}"),
        };
        format!("Position error ({}): {figures}.", crate::PartialRows::rms(self.partial_rows.as_ref()))
    }

    /// Where the held-out errors come from.
    pub(crate) fn held_out_rows(&self) -> &'static str {
        match self.held_out {
            HeldOut::NestedFolds => "in nested cross-validation",
            HeldOut::Refits => "in cross-validation of the findings",
            _ => "on the held-out test set",
        }
    }

    /// Why the search ended.
    pub(crate) fn termination(&self) -> String {
        let p = format!("({})", p_text(self.unexplained.p_value));
        let found = self.effects.iter().filter(|e| e.family != Family::Outlier.word()).count();
        match self.stopped {
            Termination::NothingLeft if found == 0 => {
                format!("No effect beyond the declared model is significant {p}.")
            }
            Termination::NothingLeft => format!("No further effect is significant {p}."),
            Termination::NothingConvincing => {
                format!("The residual is significant {p}, but no candidate passed all tests.")
            }
            Termination::Circling => format!(
                "The residual is significant {p}, but the search returned to the same candidates, which it cannot decide between."
            ),
            Termination::Withdrawn => {
                self.withdrawn.as_ref().map_or_else(String::new, WithdrawnSummary::sentence)
            }
            Termination::Interrupted => {
                "The run was ended before the search was complete; further effects are possible.".into()
            }
            Termination::Limit => {
                format!(
                    "The largest permitted number of effects was added {p}; further effects are possible."
                )
            }
            _ => String::new(),
        }
    }
}

impl NestedSummary {
    /// Before and after in nested cross-validation, and the conclusion.
    pub(crate) fn sentence(&self) -> String {
        let (before, after) = (self.before.rms_mm, self.after.rms_mm);
        let worse = if after > before {
            " The declared model alone predicts better: do not rely on the findings."
        } else {
            ""
        };
        let gain = self.gain.map_or_else(String::new, |gain| format!(" {}", gain.sentence()));
        format!(
            "Nested cross-validation of the whole search ({}): {}{} → {}{} mm RMS on the folds left out.{worse}{gain}",
            self.folds,
            significant(before, 3),
            interval_text(self.before.ci95_mm),
            significant(after, 3),
            interval_text(self.after.ci95_mm)
        )
    }
}

impl DiscoverySummary {
    /// The same, and why it is not the position error above where the two differ by more than a tenth.
    pub(crate) fn nested_sentence(&self) -> Option<String> {
        const ALIKE: f64 = 0.1;
        let (nested, above) = (self.nested.as_ref()?, self.after.holdout_used());
        let apart = (nested.after.rms_mm / above.rms_mm.max(f64::MIN_POSITIVE)).ln().abs();
        let why = match self.held_out != HeldOut::NestedFolds && apart > ALIKE {
            true => format!(
                " It is not the position error above ({} mm): that is of {} {}, with the findings of the whole search; this is of {}, each predicted by a search with fewer poses.",
                significant(above.rms_mm, 3),
                count(above.count, "row"),
                self.held_out_rows(),
                count(nested.after.count, "row"),
            ),
            false => String::new(),
        };
        Some(nested.sentence() + &why)
    }
}

impl WithdrawnSummary {
    /// The withdrawn findings, the check that they failed, and the model that is kept.
    pub(crate) fn sentence(&self) -> String {
        let rows = match self.check {
            Check::Refits => "in cross-validation by refits",
            Check::UnsearchedRows => "on training rows outside of the sample that was searched",
            Check::NestedFolds => "in nested cross-validation of the whole search",
            Check::TestSet => "on the held-out test set",
        };
        format!(
            "Withdrawn: {}. With {}, the model predicts unseen data worse than the declared model ({} → {} mm {rows}). The declared \
             model is kept.",
            self.findings.join(", "),
            if self.findings.len() == 1 { "it" } else { "them" },
            significant(self.declared_rms_mm, 3),
            significant(self.enlarged_rms_mm, 3),
        )
    }
}

impl DiscoverySummary {
    /// Gain, errors beside that of random poses, and stated deviations that were scaled: one sentence each.
    pub(crate) fn beside(&self) -> Vec<String> {
        let random = self.after.holdout_used();
        let gain = self.gain.iter().map(|gain| gain.sentence());
        let parts = self.extrapolation.iter().map(|part| part.sentence(&random));
        let scaled = self.stated_sd_scaled_by.iter().map(|scaled| scaled.sentence());
        gain.chain(parts).chain(scaled).collect()
    }
}

//! A discovery as a story for a terminal: before, each effect, after.

use super::{DiscoverySummary, FindingSummary, Reference};
use crate::{count, significant};
use std::fmt;
use truepose_discover::{Doubt, Family, Finding, Stop};

/// Width of the longest bar of the waterfall.
const BAR: f64 = 34.0;

impl fmt::Display for DiscoverySummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: {}, {}", self.robot, count(self.rows, "row"), count(self.visits, "visit"))?;
        writeln!(f, "\n{}", self.question())?;
        writeln!(f, "\nRMS of the 3-D position error on {} that took part in nothing, mm\n", {
            count(self.before.holdout.count, "row")
        })?;
        self.waterfall(f)?;
        for (number, effect) in (1..).zip(&self.effects) {
            writeln!(f, "\n{number}. {}", effect.words())?;
            effect.story(f)?;
        }
        writeln!(f, "\n{}", self.ending())?;
        if let Some(nested) = &self.nested {
            writeln!(
                f,
                "The whole loop inside each fold ({}): {} → {} mm RMS on rows that no choice has seen.",
                nested.folds,
                significant(nested.before.rms_mm, 3),
                significant(nested.after.rms_mm, 3)
            )?;
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

impl DiscoverySummary {
    /// Is anything left after the declared model?
    pub(crate) fn question(&self) -> String {
        match (self.lack_of_fit.against, self.lack_of_fit.before, self.lack_of_fit.pure_error_mm) {
            (Reference::Repeats, Some(p), Some(pure)) => format!(
                "The declared model leaves {} mm; a repeated visit scatters by {} mm (lack of fit p = {}).",
                significant(self.before.train.rms_mm, 3),
                significant(pure, 3),
                significant(p, 2)
            ),
            _ => format!(
                "The declared model leaves {} mm. No configuration was visited twice: what is noise is told by flipping signs \
                 of whole visits.",
                significant(self.before.train.rms_mm, 3)
            ),
        }
    }

    fn waterfall(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut lines = vec![("declared model".to_owned(), self.before.holdout.rms_mm)];
        lines.extend(
            self.effects
                .iter()
                .filter(|e| e.family != Family::Outlier.word())
                .map(|e| (format!("+ {}", e.words()), e.holdout_rms_mm.after)),
        );
        lines.push(("noise floor".to_owned(), self.noise_floor_mm));
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
        let result = format!(
            "{} → {} mm on held-out visits; noise floor {} mm.",
            significant(self.before.holdout.rms_mm, 3),
            significant(self.after.holdout.rms_mm, 3),
            significant(self.noise_floor_mm, 3)
        );
        let verdict = self.specification.map_or_else(String::new, |s| format!("\n{}", s.words()));
        format!("{result}{verdict}\n{}", self.why())
    }

    /// Why the loop stopped.
    pub(crate) fn why(&self) -> String {
        let found = self.effects.len();
        let why = match self.stopped {
            Stop::NothingLeft if found == 0 => {
                "Nothing was found: what the declared model leaves is what chance leaves".to_owned()
            }
            Stop::NothingLeft => "Nothing more is left that chance would not do as well".to_owned(),
            Stop::NothingConvincing => format!(
                "Something is left ({} % of the variance), but nothing that passed all tests",
                significant(100.0 * self.unexplained.share_of_variance, 2)
            ),
            Stop::Interrupted => "The run was ended before its end; something may be left".to_owned(),
            Stop::Limit => "As many effects as were allowed; something may be left".to_owned(),
        };
        format!("{why} (p = {}).", significant(self.unexplained.p_value, 2))
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
            "   p = {}, there in {} % of half samples, cross-validated {} → {} mm",
            significant(self.p_value, 2),
            significant(100.0 * self.stability, 3),
            significant(self.cross_validated_rms_mm.before, 3),
            significant(self.cross_validated_rms_mm.after, 3)
        )?;
        for other in self.alternatives.iter().take(2) {
            let words = format!("{} {}", other.family, other.place.words());
            let told = if other.equivalent { "this data cannot tell it from" } else { "rival:" };
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

/// Why a candidate was not believed.
pub(super) fn doubt_words(doubt: Doubt) -> &'static str {
    match doubt {
        Doubt::Chance => "chance would do as well",
        Doubt::NotPredictive => "it does not predict configurations that it has not seen",
        Doubt::TooSmall => "its gain is too small to matter",
        Doubt::Unstable => "it is not there in every half of the data",
    }
}

/// What a finding is, and where a mechanic would look.
pub(super) fn meaning(finding: &Finding) -> String {
    let place = &finding.candidate.place;
    let joint = place.joint.as_deref().unwrap_or("the robot");
    match finding.candidate.family {
        Family::Outlier => {
            "These rows are explained by no repeatable effect: look at the instrument's log.".into()
        }
        Family::Target => format!(
            "Target {} is not where the description has it: measure it again.",
            place.target.as_deref().unwrap_or("")
        ),
        Family::Geometric => format!(
            "The frame of {joint} is not where the description has it: look at its seat and dowels, or correct the description."
        ),
        Family::JointCompliance => {
            format!(
                "{joint} yields in proportion to the load about its axis: gear, bearing or drive stiffness."
            )
        }
        Family::BaseCompliance => "The base tilts or sinks under the load: look at its anchoring.".into(),
        Family::Backlash => format!(
            "{joint} has play: its error switches with the side it comes from. Look at gear backlash, belt tension and preload."
        ),
        Family::Transmission => {
            format!(
                "The drive of {joint} errs periodically: eccentric wheel, gear mesh, strain wave or screw."
            )
        }
        Family::Coupling => format!(
            "{} drags {joint} along: belts, wrist gears or a calibration of coupled axes.",
            place.driver.as_deref().unwrap_or("another joint")
        ),
        Family::Guideway => {
            format!(
                "The rail of {joint} is not straight, or its carriage turns as it travels: look at its bolts, shims and carriage."
            )
        }
        Family::Payload => format!(
            "The payload declared as {} kg is another one: weigh it.",
            place.level.unwrap_or_default()
        ),
        Family::LinkCompliance => format!(
            "The link behind {joint} bends or twists under what it carries: look at its flange bolts and bearings; else it is its stiffness."
        ),
        Family::LoadNonlinearity => format!(
            "{joint} does not yield in proportion to its load: a bearing or gear that takes up play, or a strain wave that stiffens."
        ),
        Family::Shift => format!(
            "{joint} jumped once: something was bumped, changed or mounted anew. Look at what the log has at that time."
        ),
        Family::Thermal => format!(
            "{joint} follows {}: it grows or moves with temperature. Warm up, shield, or read the sensor when commanding.",
            place.channel.as_deref().unwrap_or("a temperature")
        ),
        Family::Drift => format!(
            "{joint} moves slowly with time: warming up, settling, or the instrument. Warm up longer, or measure a fixed point between."
        ),
        Family::Unmodelled
            if place.joint.is_some() && place.joint == place.covariate && place.component.is_none() =>
        {
            format!(
                "The axis of {joint} wanders as it turns: look at its bearings and their seats. Errors of that sort have no name here."
            )
        }
        Family::Unmodelled => format!(
            "Something at {joint} depends on {} in a way that has no name here.",
            [place.covariate.as_deref(), place.covariate2.as_deref()]
                .into_iter()
                .flatten()
                .collect::<Vec<_>>()
                .join(" and ")
        ),
    }
}

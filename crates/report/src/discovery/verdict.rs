//! The first sentence of a discovery: whether the model is adequate, with the figures that decide it.

use super::{DependenceSummary, DiscoverySummary, NoiseFloorSummary, StatedScaleSummary};
use crate::statistics::interval_text;
use crate::wording::p_text;
use crate::{count, significant};
use truepose_discover::{Family, FloorSource, Termination, Verdict};

impl DiscoverySummary {
    /// The verdict.
    pub(crate) fn adequacy(&self) -> String {
        let left = self.unexplained.residual_rms_mm.unwrap_or(self.after.train_used().rms_mm);
        let left = format!("{} mm", significant(left, 3));
        match self.verdict {
            Verdict::Adequate => self.adequate(&left),
            Verdict::Unexplained => self.not_explained(&left),
            _ if self.stopped == Termination::Interrupted => {
                "Undecided: the run was ended before the search was complete.".into()
            }
            _ => self.undecided(&left),
        }
    }

    fn adequate(&self, left: &str) -> String {
        let floor = &self.noise_floor;
        let scatter = match floor.source {
            FloorSource::Stated => {
                let stated = significant(floor.rms_mm.unwrap_or_default(), 3);
                return format!(
                    "Adequate, if the stated accuracy of the instrument is right: the residual ({left}) is consistent with it ({stated} mm)."
                );
            }
            FloorSource::NearRepeats => "repeats of nearly the same pose",
            _ => "repeats of the same pose",
        };
        format!(
            "Adequate: the residual ({left}) is consistent with the scatter of {scatter} ({}).",
            floor.figure()
        )
    }

    fn not_explained(&self, left: &str) -> String {
        let unexplained = &self.unexplained;
        let p = p_text(unexplained.p_value);
        let what = match unexplained.rms_mm {
            Some(rms) if rms > 0.0 => {
                format!(
                    "Not explained: {} mm{} of the residual of {left}",
                    significant(rms, 2),
                    interval_text(unexplained.ci95_mm)
                )
            }
            _ => format!("Not explained: a residual of {left}"),
        };
        let why = match (self.stopped, unexplained.lack_of_fit_p) {
            (Termination::NothingLeft, Some(lack)) => {
                format!("no effect that this program knows explains it (lack of fit {})", p_text(lack))
            }
            (Termination::NothingConvincing, _) => {
                format!(
                    "the residual is significant ({p}), and no effect that this program knows explains it"
                )
            }
            (Termination::Circling, _) => {
                format!(
                    "the residual is significant ({p}), and it cannot be decided which effect explains it"
                )
            }
            (Termination::Limit, _) => {
                format!(
                    "the largest permitted number of effects was added, and the residual is significant ({p})"
                )
            }
            (Termination::Withdrawn, _) => "the effects that were found did not hold on unseen data".into(),
            _ => format!("no effect that this program knows explains it ({p})"),
        };
        format!("{what}; {why}.")
    }

    fn undecided(&self, left: &str) -> String {
        let floor = &self.noise_floor;
        let measure = format!("measure {} a second time", count(floor.missing_repeats.max(1), "pose"));
        if let Some(wander) = self.dependence.as_ref().and_then(|found| found.beyond_half(floor.rms_mm)) {
            return format!(
                "Undecided: the residual ({left}) is no larger than the repeatability limit ({}), but poses depend on those before \
                 them, and most of the limit is a wander ({wander} mm). A drift or a jump looks the same.{}",
                floor.figure(),
                self.dependence.as_ref().map_or("", DependenceSummary::advice)
            );
        }
        if let Some(what) = self.outliers_in_common() {
            return format!(
                "Undecided: the residual without the rows that are kept out is {left}, but {what}: they are perhaps an effect."
            );
        }
        if self.unexplained.held_out_beyond {
            let after = &self.after.holdout_used();
            let what = match self.effects.iter().any(|effect| effect.family != Family::Outlier.word()) {
                true => "the model with the effects found does not carry",
                false => "the declared model does not carry",
            };
            return format!(
                "Undecided: the residual is {left}, and the repeatability limit {}, but poses that were not seen are predicted to {} mm: \
                 {what} over to them. Measure more poses, or declare what is known of the robot and its loads.",
                floor.figure(),
                significant(after.rms_mm, 3)
            );
        }
        match floor.source {
            FloorSource::Repeats | FloorSource::NearRepeats => format!(
                "Undecided: {} ({}) are too few to decide whether the residual ({left}) is noise: {measure}.",
                count(floor.repeats, "repeat"),
                floor.figure()
            ),
            FloorSource::Differences => format!(
                "Undecided: the residual is {left}, and differences between neighbouring poses ({}) are only an upper bound of the noise: {measure}.",
                floor.figure()
            ),
            _ => format!(
                "Undecided: whether the residual ({left}) is noise cannot be decided without repeated poses: {measure}."
            ),
        }
    }
}

impl DiscoverySummary {
    /// What rows that are kept out have in common.
    fn outliers_in_common(&self) -> Option<String> {
        let out = self.effects.iter().find(|effect| effect.family == Family::Outlier.word())?;
        match (out.place.level, &out.place.mode) {
            (Some(level), _) => Some(format!("more of those declare {level} kg than by chance would")),
            (None, Some(_)) => {
                Some("more of those lie close together in the record than by chance would".into())
            }
            (None, None) => None,
        }
    }
}

impl NoiseFloorSummary {
    /// Name of the limit in a chart.
    pub(super) fn name(&self) -> &'static str {
        match self.source {
            FloorSource::Stated => "instrument",
            FloorSource::Differences => "neighbouring poses",
            _ => "repeatability",
        }
    }

    /// Limit, interval and number of repeats, e.g. `0.049 mm, 0.045 to 0.054, 20 repeats`.
    fn figure(&self) -> String {
        let Some(rms) = self.rms_mm else { return "unknown".into() };
        let ends = self.ci95_mm.map_or_else(String::new, |[lower, upper]| {
            format!(", {} to {}", significant(lower, 2), significant(upper, 2))
        });
        format!("{} mm{ends}, {}", significant(rms, 3), count(self.repeats, "repeat"))
    }

    /// The limit with its source.
    pub(crate) fn sentence(&self) -> String {
        let bounds = match (self.at_least_mm, self.at_most_mm) {
            (Some(least), _) => format!(
                " It is at least {} mm (stated accuracy or scatter within a dwell, without the repeatability of the robot).",
                significant(least, 3)
            ),
            (None, Some(most)) => format!(" It is at most {} mm.", significant(most, 3)),
            (None, None) => String::new(),
        };
        let Some(rms) = self.rms_mm else {
            return format!("Repeatability limit: unknown (too few repeated poses).{bounds}");
        };
        let rms = significant(rms, 3);
        let source = match self.source {
            FloorSource::Repeats => "from repeats",
            FloorSource::NearRepeats => "from nearly repeated poses, corrected by the model",
            FloorSource::Differences => "at most: from differences between neighbouring poses",
            _ => "stated accuracy of the instrument, which the residual confirms",
        };
        let ends = self.ci95_mm.map_or_else(String::new, |[lower, upper]| {
            format!("{} to {} mm; ", significant(lower, 2), significant(upper, 2))
        });
        format!("Repeatability limit: {rms} mm ({ends}{source}).")
    }
}

impl StatedScaleSummary {
    /// What was done to stated standard deviations.
    pub(crate) fn sentence(&self) -> String {
        let times = |factor: f64| significant(factor, 2);
        let what = match (self.position < 1.0, self.orientation < 1.0) {
            (true, false) => {
                format!("positions exceed the scatter: they were multiplied by {}", times(self.position))
            }
            (false, _) => {
                format!(
                    "orientations exceed the scatter: they were multiplied by {}",
                    times(self.orientation)
                )
            }
            (true, true) => format!(
                "positions and orientations exceed the scatter: they were multiplied by {} and {}",
                times(self.position),
                times(self.orientation)
            ),
        };
        format!("Warning: the stated standard deviations of {what}. Check what the instrument states.")
    }
}

//! An identification as text for a terminal: verdict first, then figures, noise and groups.

use super::{IdentificationSummary, StageSummary};
use crate::document::{Block, Document, Only};
use crate::layout::Alignment::{Left, Right};
use crate::wording::heading;
use crate::{
    ParameterSummary, PartialRows, SpecificationLines, count, significant, table, value_with_interval,
};
use std::fmt;

/// Grouped errors beyond this many are not printed one by one (they are all in the JSON).
const MOST_GROUPS: usize = 60;
/// Pose measurements with the largest errors that are printed (the JSON has more).
const MOST_WORST: usize = 5;

impl fmt::Display for IdentificationSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let heading = heading(&self.robot, self.rows, self.visits);
        writeln!(f, "{heading}, {}", count(self.configurations, "configuration"))?;
        write!(f, "{}", self.data_check)?;
        write!(f, "\n{}{}", self.judgement(), self.frames())?;
        self.errors(f)?;
        write!(f, "{}\n{}", self.observations(), self.noise())?;
        if let Some(budget) = &self.budget {
            write!(f, "{}", budget.document())?;
        }
        self.reduction(f)?;
        if !self.worst.is_empty() {
            let largest: Vec<String> =
                self.worst.iter().take(MOST_WORST).map(super::LargestError::text).collect();
            writeln!(f, "\npose measurements with the largest errors: {}", largest.join(", "))?;
        }
        Ok(())
    }
}

impl IdentificationSummary {
    fn errors(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let held = self.stages.iter().any(|s| s.held_out.is_some());
        let test_set = self.stages.iter().any(|s| s.test_set.is_some());
        let along = if self.kinds.is_some() { "; of rows with one number, along its direction" } else { "" };
        writeln!(f, "\nposition error, mm ({}{along})", PartialRows::error(self.partial_rows.as_ref()))?;
        let mut header = vec!["", "", "mean", "RMS", "95 %", "max"];
        let mut rows = Vec::new();
        for stage in &self.stages {
            let mut push = |data: &str, cells: Vec<String>| {
                let mut row = vec![stage.name.clone(), data.to_string()];
                row.extend(cells);
                rows.push(row);
            };
            push("training", stage.train.cells());
            if let Some(spread) = &stage.held_out {
                push("held out", spread.cells());
            }
            if let Some(spread) = &stage.test_set {
                push("test set", spread.cells());
            }
        }
        header[1] = "rows";
        write!(f, "{}", table(&header, &[Left, Left, Right, Right, Right, Right], &rows))?;
        if held && let Some(how) = &self.held_out_by {
            writeln!(f, " held out: {how}")?;
            if self.repeated_rms_mm.len() > 1 {
                let n = self.repeated_rms_mm.len() as f64;
                let mean = self.repeated_rms_mm.iter().sum::<f64>() / n;
                let variance =
                    self.repeated_rms_mm.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
                writeln!(
                    f,
                    " declared model over {} such splits: RMS {} ± {} mm (standard deviation between splits)",
                    self.repeated_rms_mm.len(),
                    significant(mean, 4),
                    significant(variance.sqrt(), 2)
                )?;
            }
        }
        if test_set {
            writeln!(
                f,
                " test set: held out before anything is fitted; the model was then fitted again on all rows"
            )?;
        }
        let turned: Vec<Vec<String>> = self
            .stages
            .iter()
            .flat_map(|stage| {
                let row = |data: &str, cells: Vec<String>| {
                    let mut row = vec![stage.name.clone(), data.to_string()];
                    row.extend(cells);
                    row
                };
                let train = stage.train_rotation.map(|s| row("training", s.cells()));
                let held = stage.held_out_rotation.map(|s| row("held out", s.cells()));
                train.into_iter().chain(held)
            })
            .collect();
        if !turned.is_empty() {
            writeln!(f, "\norientation error, mrad")?;
            write!(f, "{}", table(&header, &[Left, Left, Right, Right, Right, Right], &turned))?;
        }
        let mut parts: Vec<Vec<String>> = Vec::new();
        for (axis, spread) in ["x", "y", "z"].iter().zip(&self.axes).filter(|(_, spread)| spread.count > 0) {
            let mut row = vec![format!("axis {axis}"), spread.count.to_string()];
            row.extend(spread.cells());
            parts.push(row);
        }
        for (name, spread) in &self.targets {
            let mut row = vec![format!("target {name}"), spread.count.to_string()];
            row.extend(spread.cells());
            parts.push(row);
        }
        writeln!(
            f,
            "\ndeclared model{} by axis{}, mm",
            if self.converged { "" } else { ", NOT CONVERGED," },
            if self.targets.is_empty() { "" } else { " and target" }
        )?;
        header[1] = "rows";
        write!(f, "{}", table(&header, &[Left, Right, Right, Right, Right, Right], &parts))?;
        Ok(())
    }

    /// The verdict, what it rests on, and what a reader has to be warned of.
    pub(crate) fn judgement(&self) -> Document {
        let mut document = Document::default();
        document.verdict(&self.verdict);
        document.sentence(&self.limit);
        document.sentences(&self.assumed);
        document.sentences(self.partial_rows.as_ref().map(PartialRows::sentence));
        document.sentences(self.landmarks.as_ref().map(crate::LandmarksSummary::sentences));
        SpecificationLines::show(self.specification.as_ref(), &mut document);
        if !self.converged {
            document.sentence(&format!(
                "NOT CONVERGED: the fit still moved after {}; no figure of the declared model below is final",
                count(self.rounds, "iteration")
            ));
        }
        for warning in &self.warnings {
            document.push(Only::Both, Block::Warning(warning.clone()));
        }
        document
    }

    /// Base, tool and targets that were estimated.
    pub(crate) fn frames(&self) -> Document {
        let mut document = Document::default();
        let Some(placement) = &self.placement else { return document };
        let caption = format!(
            "estimated from the data: {} (RMS {} mm with the nominal arm)",
            placement.found.join(", "),
            significant(placement.rms_mm, 3)
        );
        match ParameterSummary::as_places(&caption, &placement.places) {
            Some(table) => document.push(Only::Both, table),
            None => {
                document.push(Only::Both, Block::Gap);
                document.sentence(&caption);
            }
        }
        for line in &placement.undetermined {
            document.push(Only::Both, Block::Item(line.clone()));
        }
        document
    }

    /// What each landmark, each kind of observation and each session leaves.
    pub(crate) fn observations(&self) -> Document {
        let mut document = Document::default();
        if let Some(landmarks) = &self.landmarks {
            landmarks.show(&mut document);
        }
        if let Some(kinds) = &self.kinds {
            kinds.show("", &mut document);
        }
        crate::sessions::show(&self.sessions, &mut document);
        document
    }

    /// Noise, and what repeats show of it.
    pub(crate) fn noise(&self) -> Document {
        let mut document = Document::default();
        let own =
            if self.noise.stated { " in addition to the stated accuracy of the instrument" } else { "" };
        let row = significant(self.noise.position_sd_mm, 3);
        let mut noise = format!("noise standard deviation per component: {row} mm per row{own}");
        if self.noise.visit_sd_mm > 0.0 {
            noise += &format!(
                ", {} mm per pose measurement (repeatability, and what the model lacks)",
                significant(self.noise.visit_sd_mm, 3)
            );
        }
        if let Some(sd) = self.noise.orientation_sd_mrad {
            noise += &format!(", {} mrad in orientation", significant(sd, 3));
        }
        document.sentence(&noise);
        let Some(repeats) = &self.repeats else { return document };
        let lack = repeats.lack_of_fit.map_or_else(String::new, |lack| {
            let p = match lack.p_value {
                p if p < 1e-4 => "p < 0.0001".into(),
                p => format!("p = {}", significant(p, 2)),
            };
            format!("; lack of fit F = {} ({p})", significant(lack.f, 3))
        });
        document.sentence(&format!(
            "repeated pose measurements: {}, pure error {} mm RMS{}{lack}",
            count(repeats.groups, "group"),
            significant(repeats.rms_mm, 3),
            if self.partial_rows.is_none() && self.kinds.is_none() { " (3-D)" } else { "" }
        ));
        if repeats.one_sided {
            document.note("all repeats have the same direction of approach: they do not show backlash");
        }
        document
    }

    fn reduction(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "\n{} of {} unknowns are identifiable: {} are dependent for any data of this kind, {} for this data",
            self.rank, self.unknowns, self.structural, self.unexcited
        )?;
        if self.weak_directions > 0 {
            writeln!(
                f,
                "{}: the standard deviation exceeds that of the prior",
                count(self.weak_directions, "weak direction")
            )?;
        }
        for line in &self.advice {
            writeln!(f, "  {line}")?;
        }
        let o = &self.observability;
        writeln!(
            f,
            "observability O1 {}  O2 {}  O3 {}  O4 {}  O5 {}",
            significant(o.o1, 3),
            significant(o.o2, 3),
            significant(o.o3, 3),
            significant(o.o4, 3),
            significant(o.o5, 3)
        )?;
        let prefix = if self.converged { "" } else { "NOT CONVERGED: " };
        writeln!(f, "\n{prefix}grouped errors, 95 % confidence intervals")?;
        let rows: Vec<Vec<String>> = self
            .groups
            .iter()
            .take(MOST_GROUPS)
            .map(|group| {
                let (value, half, unit) = value_with_interval(group.value, group.half_width, &group.unit);
                vec![value, "±".into(), half, unit, group.words.clone()]
            })
            .collect();
        write!(
            f,
            "{}",
            table(&["value", "", "", "unit", "group"], &[Right, Left, Right, Left, Left], &rows)
        )?;
        if self.groups.len() > MOST_GROUPS {
            writeln!(f, " … and {} more (--json has all)", self.groups.len() - MOST_GROUPS)?;
        }
        if !self.nonlinear_parameters.is_empty() {
            writeln!(f, "\nnonlinear parameters, 95 % confidence intervals")?;
            for parameter in &self.nonlinear_parameters {
                let [value, interval] = parameter.value_and_interval();
                let truncation = parameter.truncation();
                writeln!(
                    f,
                    " {} = {value} {}  {interval}  ({}){}{truncation}",
                    parameter.name,
                    parameter.unit,
                    parameter.effect_name(),
                    if truncation.is_empty() { "" } else { ": " }
                )?;
            }
        }
        Ok(())
    }

    /// Position error as found, after the best base and tool, and calibrated.
    pub(super) fn sentence(&self) -> String {
        let judged = |stage: &StageSummary| stage.test_set.or(stage.held_out).unwrap_or(stage.train);
        if let Some(kinds) = &self.kinds {
            return prefix_of(self.converged).to_owned() + &kinds.verdict();
        }
        if let Some(landmarks) = &self.landmarks {
            let stages: Vec<(f64, &str)> =
                self.stages.iter().map(|stage| (judged(stage).rms_mm, stage.name.as_str())).collect();
            if let Some(verdict) = landmarks.verdict(&stages, self.rows) {
                return prefix_of(self.converged).to_owned() + &verdict;
            }
        }
        let rows = match self.stages.last() {
            Some(last) if last.test_set.is_some() => "on the held-out test set",
            Some(last) if last.held_out.is_some() => "on held-out configurations",
            _ => "on the rows of the fit (no rows were held out)",
        };
        let prefix = prefix_of(self.converged);
        let Some(last) = self.stages.last().map(judged) else { return prefix.trim_end().into() };
        if last.count == 0 {
            return format!(
                "{prefix}No row has a measured position, so that there is no position error {rows}; the errors of what was measured are below."
            );
        }
        let stage =
            |stage: &StageSummary| format!("{} mm ({})", significant(judged(stage).rms_mm, 3), stage.name);
        format!(
            "{prefix}Position error ({}) {rows}: {}; 95th percentile {} mm, largest {} mm.",
            PartialRows::rms(self.partial_rows.as_ref()),
            self.stages.iter().map(stage).collect::<Vec<_>>().join(" → "),
            significant(last.p95_mm, 3),
            significant(last.max_mm, 3)
        )
    }
}

impl IdentificationSummary {
    /// With what each kind of observation leaves: then the verdict is by kind.
    #[must_use]
    pub fn with_kinds(self, kinds: Option<crate::KindsSummary>, whole: bool) -> Self {
        if kinds.is_none() {
            return self;
        }
        let mut summary = IdentificationSummary { kinds, ..self };
        if whole && summary.held_out_by.is_some() {
            summary.held_out_by = Some("each landmark in turn, judged about unknowns of its own".into());
        }
        let verdict = summary.sentence();
        IdentificationSummary { verdict, ..summary }
    }
}

fn prefix_of(converged: bool) -> &'static str {
    if converged { "" } else { "NOT CONVERGED: " }
}

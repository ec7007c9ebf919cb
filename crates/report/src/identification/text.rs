//! An identification as a person reads it in a terminal.

use super::IdentificationSummary;
use crate::layout::Alignment::{Left, Right};
use crate::{count, significant, table, value_with_interval};
use std::fmt;

/// Grouped errors beyond this many are not printed one by one (they are all in the JSON).
const MOST_GROUPS: usize = 60;

impl fmt::Display for IdentificationSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{}: {}, {}, {}",
            self.robot,
            count(self.rows, "row"),
            count(self.visits, "visit"),
            count(self.configurations, "configuration")
        )?;
        if let Some(placement) = &self.placement {
            writeln!(
                f,
                "found from the data: {} (leaves {} mm RMS)",
                placement.found.join(", "),
                significant(placement.rms_mm, 3)
            )?;
            for line in &placement.undetermined {
                writeln!(f, "  {line}")?;
            }
        }
        if !self.converged {
            let rounds = count(self.rounds, "round");
            writeln!(
                f,
                "NOT CONVERGED: the fit still moved after {rounds}; no figure of the declared model below is final"
            )?;
        }
        self.errors(f)?;
        self.noise(f)?;
        self.reduction(f)?;
        if !self.worst.is_empty() {
            let worst = self
                .worst
                .iter()
                .map(|(visit, row, d)| format!("visit {visit} (row {row}) {} mm", significant(*d, 3)));
            writeln!(f, "\nworst visits: {}", worst.collect::<Vec<_>>().join(", "))?;
        }
        writeln!(f, "\n{}", self.verdict())?;
        for warning in &self.warnings {
            writeln!(f, "warning: {warning}")?;
        }
        Ok(())
    }
}

impl IdentificationSummary {
    fn errors(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let held = self.stages.iter().any(|s| s.held_out.is_some());
        let locked = self.stages.iter().any(|s| s.locked.is_some());
        writeln!(f, "\nposition error, mm (3-D distance)")?;
        let mut header = vec!["", "", "mean", "RMS", "95 %", "max"];
        let mut rows = Vec::new();
        for stage in &self.stages {
            let mut push = |data: &str, cells: Vec<String>| {
                let mut row = vec![stage.name.clone(), data.to_string()];
                row.extend(cells);
                rows.push(row);
            };
            push("train", stage.train.cells());
            if let Some(spread) = &stage.held_out {
                push("held out", spread.cells());
            }
            if let Some(spread) = &stage.locked {
                push("locked away", spread.cells());
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
        if locked {
            writeln!(
                f,
                " locked away: drawn first, took part in nothing; the model was then fitted again on all rows"
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
                let train = stage.train_rotation.map(|s| row("train", s.cells()));
                let held = stage.held_out_rotation.map(|s| row("held out", s.cells()));
                train.into_iter().chain(held)
            })
            .collect();
        if !turned.is_empty() {
            writeln!(f, "\norientation error, mrad")?;
            write!(f, "{}", table(&header, &[Left, Left, Right, Right, Right, Right], &turned))?;
        }
        let mut parts: Vec<Vec<String>> = Vec::new();
        for (axis, spread) in ["x", "y", "z"].iter().zip(&self.axes) {
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
        write!(f, "{}", table(&header, &[Left, Right, Right, Right, Right, Right], &parts))
    }

    fn noise(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let own = if self.noise.stated { " on top of what the instrument states" } else { "" };
        write!(f, "\nscatter per component: {} mm a row{own}", significant(self.noise.position_sd_mm, 3))?;
        if self.noise.visit_sd_mm > 0.0 {
            write!(f, ", {} mm shared by a visit (repeatability)", significant(self.noise.visit_sd_mm, 3))?;
        }
        if let Some(sd) = self.noise.orientation_sd_mrad {
            write!(f, ", {} mrad in orientation", significant(sd, 3))?;
        }
        writeln!(f)?;
        if let Some(repeats) = &self.repeats {
            write!(
                f,
                "repeated visits: {}, pure error {} mm 3-D RMS",
                count(repeats.groups, "group"),
                significant(repeats.rms * 1e3, 3)
            )?;
            match &repeats.lack_of_fit {
                Some(l) => {
                    let p = if l.p_value < 1e-4 {
                        "p < 0.0001".into()
                    } else {
                        format!("p = {}", significant(l.p_value, 2))
                    };
                    writeln!(f, "; lack of fit F = {} ({p})", significant(l.f, 3))?;
                }
                None => writeln!(f)?,
            }
            if repeats.one_sided {
                writeln!(f, " all repeats came from one side: they do not show backlash")?;
            }
        }
        Ok(())
    }

    fn reduction(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "\n{} of {} unknowns can be identified: {} depend on others on any data of this kind, {} on this data",
            self.rank, self.unknowns, self.structural, self.unexcited
        )?;
        if self.weak_directions > 0 {
            writeln!(
                f,
                "{} determined worse than by their expected sizes",
                count(self.weak_directions, "direction")
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
        let word = if self.converged { "" } else { "NOT CONVERGED: " };
        writeln!(f, "\n{word}grouped errors, 95 % intervals")?;
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
        if !self.shapes.is_empty() {
            writeln!(f, "\nfound within their ranges, 95 % intervals")?;
            for shape in &self.shapes {
                let [value, interval] = shape.numbers();
                let cut = shape.cut_words();
                writeln!(
                    f,
                    " {} = {value} {}  {interval}  ({}){}{cut}",
                    shape.name,
                    shape.unit,
                    shape.effect_words(),
                    if cut.is_empty() { "" } else { ": " }
                )?;
            }
        }
        Ok(())
    }

    /// Before → after in one sentence, and what limits it.
    pub fn verdict(&self) -> String {
        let pick = |k: usize| self.stages.get(k).map(|s| s.locked.or(s.held_out).unwrap_or(s.train).rms_mm);
        let (before, after) = (pick(0), pick(self.stages.len().saturating_sub(1)));
        let where_from = match self.stages.last() {
            Some(s) if s.locked.is_some() => "on configurations locked away",
            Some(s) if s.held_out.is_some() => "on held-out configurations",
            _ => "on the data of the fit",
        };
        let word = if self.converged { "" } else { "NOT CONVERGED: " };
        match (before, after) {
            (Some(before), Some(after)) => format!(
                "{word}before → after, RMS {where_from}: {} mm → {} mm. {}.",
                significant(before, 3),
                significant(after, 3),
                capitalised(&self.limit)
            ),
            _ => format!("{word}{}", capitalised(&self.limit)),
        }
    }
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters
        .next()
        .map_or_else(String::new, |first| first.to_uppercase().collect::<String>() + letters.as_str())
}

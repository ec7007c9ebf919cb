//! An acceptance as text for a terminal.

use super::{AcceptanceSummary, FigureSummary, StateSummary};
use crate::layout::Alignment::{Left, Right};
use crate::{count, significant, table};
use std::fmt;

impl FigureSummary {
    /// `0.123 ± 0.004`, with the expanded uncertainty; digits follow the uncertainty.
    pub fn text(&self) -> String {
        if self.expanded <= 0.0 {
            return significant(self.value, 3);
        }
        // Two digits of the uncertainty (GUM 7.2.6).
        let decimals = (1 - self.expanded.log10().floor() as i32).clamp(0, 9) as usize;
        format!("{:.decimals$} ± {:.decimals$}", self.value, self.expanded)
    }

    /// `0.038 (0.032 to 0.047)`: figures whose distribution is not symmetric.
    pub fn interval_text(&self) -> String {
        let [low, high] = self.ci95;
        format!("{} ({} to {})", significant(self.value, 3), significant(low, 2), significant(high, 2))
    }

    /// As it is shown: symmetric or not.
    pub fn shown(&self) -> String {
        match self.method {
            "bootstrap" | "chi-squared" => self.interval_text(),
            _ => self.text(),
        }
    }
}

/// Symbols of a state's poses in their order, each once.
pub(crate) fn symbols(state: &StateSummary, wanted: &[&str]) -> Vec<String> {
    let has = |symbol: &str| state.poses.iter().any(|pose| pose.figure(symbol).is_some());
    wanted.iter().filter(|symbol| has(symbol)).map(ToString::to_string).collect()
}

/// Cells of the poses of a state: name, cycles, figures.
pub(crate) fn pose_rows(state: &StateSummary, symbols: &[String]) -> Vec<Vec<String>> {
    let row = |pose: &super::TestPoseSummary| {
        let mut row = vec![pose.name.clone(), pose.cycles.to_string()];
        row.extend(symbols.iter().map(|s| pose.figure(s).map_or_else(|| "–".into(), FigureSummary::shown)));
        row
    };
    state.poses.iter().map(row).collect()
}

/// `AP_p, mm`, with the unit of the figure.
pub(crate) fn heads(state: &StateSummary, symbols: &[String]) -> Vec<String> {
    let unit = |s: &String| state.poses.iter().find_map(|pose| pose.figure(s)).map_or("", |f| f.unit);
    symbols.iter().map(|s| format!("{s}, {}", unit(s))).collect()
}

/// Figures that the terminal shows; the page and the JSON have all.
const SHOWN: [&str; 5] = ["AP_p", "RP_l", "vAP_p", "dAP_p", "dRP_l"];

impl AcceptanceSummary {
    /// One sentence: largest figures, and the verdict.
    pub fn sentence(&self) -> String {
        let of = |state: &StateSummary| -> String {
            let mut parts = Vec::new();
            for symbol in ["AP_p", "RP_l"] {
                if let Some((pose, figure)) = state.worst(symbol) {
                    parts.push(format!("{symbol} {} mm ({pose})", figure.shown()));
                }
            }
            let path = state.path.iter().flat_map(|path| &path.figures);
            parts.extend(path.map(|figure| format!("{} {} mm", figure.symbol, figure.shown())));
            format!("{}: {}", state.name, parts.join(", "))
        };
        let states: Vec<String> = std::iter::once(&self.before).chain(&self.after).map(of).collect();
        format!("Largest figures {}.", states.join("; "))
    }
}

impl fmt::Display for AcceptanceSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: ISO 9283, {}; frames: {}", self.robot, count(self.rows, "row"), self.alignment)?;
        writeln!(f, "\n{}", self.sentence())?;
        if let Some(verdict) = self.verdict {
            writeln!(f, "Verdict: {verdict} (guard bands after ISO 14253-1, 95 % one-sided).")?;
        }
        for remark in &self.remarks {
            writeln!(f, "note: {remark}")?;
        }
        for state in std::iter::once(&self.before).chain(&self.after) {
            show(state, f)?;
        }
        if !self.verdicts.is_empty() {
            writeln!(f, "\nlimits, mm")?;
            let head = ["state", "of", "figure", "value", "guard band", "factor", "limit", "verdict"];
            let alignment = [Left, Left, Left, Right, Right, Right, Right, Left];
            write!(f, "{}", table(&head, &alignment, &self.verdict_rows()))?;
        }
        if let Some(budget) = &self.budget {
            write!(f, "{}", budget.document())?;
        }
        Ok(())
    }
}

impl AcceptanceSummary {
    /// Cells of the limits.
    pub(crate) fn verdict_rows(&self) -> Vec<Vec<String>> {
        let row = |v: &super::VerdictSummary| {
            vec![
                v.state.to_owned(),
                v.of.clone(),
                v.symbol.clone(),
                significant(v.value_mm, 3),
                significant(v.guard_band_mm, 2),
                format!("{:.3}", v.factor),
                significant(v.limit_mm, 3),
                v.verdict.to_owned(),
            ]
        };
        self.verdicts.iter().map(row).collect()
    }
}

fn show(state: &StateSummary, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    writeln!(f, "\n{} (± expanded uncertainty, k = 2; in brackets 95 % interval)", state.name)?;
    if !state.poses.is_empty() {
        let symbols = symbols(state, &SHOWN);
        let mut head = vec!["pose".to_owned(), "cycles".into()];
        head.extend(heads(state, &symbols));
        let mut alignment = vec![Left, Right];
        alignment.extend(symbols.iter().map(|_| Right));
        let head: Vec<&str> = head.iter().map(String::as_str).collect();
        write!(f, "{}", table(&head, &alignment, &pose_rows(state, &symbols)))?;
    }
    for pair in &state.distances {
        let shown: Vec<String> = ["AD_p", "RD_p"]
            .iter()
            .filter_map(|s| pair.figures.iter().find(|figure| figure.symbol == *s))
            .map(|figure| format!("{} {} mm", figure.symbol, figure.shown()))
            .collect();
        let between = pair.between.join("–");
        let distance = significant(pair.commanded_mm, 6);
        writeln!(f, " {between}, {distance} mm, {}: {}", count(pair.cycles, "cycle"), shown.join(", "))?;
    }
    for one in &state.compliance {
        let [low, high] = one.forces_n.map(|v| significant(v, 3));
        writeln!(
            f,
            " static compliance at {} along {}: {} µm/N ({low} to {high} N, {})",
            one.poses.first().map_or("", String::as_str),
            one.direction,
            one.compliance.text(),
            count(one.levels, "level")
        )?;
    }
    if let Some(path) = &state.path {
        let figures: Vec<String> =
            path.figures.iter().map(|figure| format!("{} {} mm", figure.symbol, figure.shown())).collect();
        writeln!(
            f,
            " path, {}, {} of {}: {} (at points {} and {})",
            count(path.cycles, "cycle"),
            path.evaluated,
            count(path.points, "point"),
            figures.join(", "),
            path.at_points[0],
            path.at_points[1]
        )?;
    }
    Ok(())
}

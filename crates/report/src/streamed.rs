//! The result of an identification block by block: one summary, shown as text or as JSON.

use crate::identification::groups;
use crate::layout::Alignment::{Left, Right};
use crate::wording::heading;
use crate::{
    GroupSummary, OrientationStatistics, PositionStatistics, count, significant, table, value_with_interval,
    warning_text,
};
use serde::Serialize;
use std::fmt;
use truepose_identify::Streamed;
use truepose_identify::reduction::Cause;

/// Grouped errors beyond this many are not printed one by one (they are all in the JSON).
const MOST_GROUPS: usize = 60;

/// Everything that is shown of a streamed identification.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StreamedSummary {
    /// Name of the robot.
    pub robot: String,
    /// Rows of data.
    pub rows: usize,
    /// Pose measurements.
    pub visits: usize,
    /// Rows of the sample that determines the structure of the model and the noise.
    pub sampled: usize,
    /// The solver, as it is chosen on the command line.
    pub solver: String,
    /// Base, tool and target frames that were estimated.
    pub found: Vec<String>,
    /// Distances of all rows to the fit.
    pub train: PositionStatistics,
    /// Angles, where orientations were measured.
    pub train_rotation: Option<OrientationStatistics>,
    /// Position errors in cross-validation.
    pub held_out: Option<PositionStatistics>,
    /// Angles in cross-validation.
    pub held_out_rotation: Option<OrientationStatistics>,
    /// RMS of each fold, mm.
    pub fold_rms_mm: Vec<f64>,
    /// Standard deviation of a position's component in the sample, in addition to the stated accuracy of the instrument, mm.
    pub position_sd_mm: f64,
    /// Standard deviation shared by the rows of a pose measurement (repeatability), per component, mm.
    pub visit_sd_mm: f64,
    /// Unknowns before the reduction.
    pub unknowns: usize,
    /// Unknowns that are kept.
    pub rank: usize,
    /// Dropped because they are not identifiable from any data of this kind.
    pub structural: usize,
    /// Dropped because the sample does not excite them.
    pub unexcited: usize,
    /// Scale factor of the prior standard deviations; null without a prior.
    pub prior: Option<f64>,
    /// Whether the normal equations were accurate enough; otherwise triangular factors were merged.
    pub normal_equations: bool,
    /// The grouped errors.
    pub groups: Vec<GroupSummary>,
    /// Warnings.
    pub warnings: Vec<String>,
}

impl StreamedSummary {
    /// Summary of a streamed identification.
    pub fn new(found: &Streamed, solver: &str) -> Self {
        let fit = &found.fit;
        let dropped = |cause: Cause| fit.reduction.dropped.iter().filter(|d| d.cause == cause).count();
        let turned = |spread: truepose_identify::Spread| (spread.count > 0).then(|| spread.into());
        let held = found.held_out.as_ref();
        StreamedSummary {
            robot: fit.fitted.chain().name().into(),
            rows: found.rows,
            visits: found.visits,
            sampled: found.sampled,
            solver: solver.into(),
            found: found.placement.found.clone(),
            train: found.position.into(),
            train_rotation: turned(found.orientation),
            held_out: held.map(|held| held.position.into()),
            held_out_rotation: held.and_then(|held| turned(held.orientation)),
            fold_rms_mm: held.map_or_else(Vec::new, |held| held.fold_rms.iter().map(|r| r * 1e3).collect()),
            position_sd_mm: fit.noise.position_sd * 1e3,
            visit_sd_mm: fit.noise.visit_sd * 1e3,
            unknowns: fit.fitted.coefficients().len(),
            rank: fit.reduction.rank(),
            structural: dropped(Cause::Structural),
            unexcited: dropped(Cause::Unexcited),
            prior: fit.prior.kappa.is_finite().then_some(fit.prior.kappa),
            normal_equations: found.gram,
            groups: groups(fit),
            warnings: fit.warnings.iter().map(warning_text).collect(),
        }
    }
}

impl fmt::Display for StreamedSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", heading(&self.robot, self.rows, self.visits))?;
        writeln!(
            f,
            "read block by block; the structure of the model is from a sample of {}",
            count(self.sampled, "row")
        )?;
        if !self.found.is_empty() {
            writeln!(f, "estimated from the sample: {}", self.found.join(", "))?;
        }
        writeln!(f, "\nposition error, mm (3-D distance)")?;
        let row = |name: &str, cells: Vec<String>| {
            let mut row = vec![name.to_string()];
            row.extend(cells);
            row
        };
        let header = ["rows", "mean", "RMS", "95 %", "max"];
        let alignment = [Left, Right, Right, Right, Right];
        let mut rows = vec![row("training", self.train.cells())];
        rows.extend(self.held_out.map(|held| row("held out", held.cells())));
        write!(f, "{}", table(&header, &alignment, &rows))?;
        let train = self.train_rotation.map(|turned| row("training", turned.cells()));
        let held = self.held_out_rotation.map(|turned| row("held out", turned.cells()));
        let rows: Vec<Vec<String>> = train.into_iter().chain(held).collect();
        if !rows.is_empty() {
            writeln!(f, "\norientation error, mrad")?;
            write!(f, "{}", table(&header, &alignment, &rows))?;
        }
        if !self.fold_rms_mm.is_empty() {
            let rms: Vec<String> = self.fold_rms_mm.iter().map(|rms| significant(*rms, 4)).collect();
            writeln!(
                f,
                " held out: {} folds over configurations; RMS of each, mm: {}",
                rms.len(),
                rms.join("  ")
            )?;
        }
        writeln!(
            f,
            "\n{} of {} unknowns are identifiable: {} are dependent for any data of this kind, {} for the sample",
            self.rank, self.unknowns, self.structural, self.unexcited
        )?;
        writeln!(f, "\ngrouped errors, 95 % confidence intervals")?;
        let group = |group: &GroupSummary| {
            let (value, half, unit) = value_with_interval(group.value, group.half_width, &group.unit);
            vec![value, "±".into(), half, unit, group.words.clone()]
        };
        let rows: Vec<Vec<String>> = self.groups.iter().take(MOST_GROUPS).map(group).collect();
        let header = ["value", "", "", "unit", "group"];
        write!(f, "{}", table(&header, &[Right, Left, Right, Left, Left], &rows))?;
        if self.groups.len() > MOST_GROUPS {
            writeln!(f, " … and {} more (--json has all)", self.groups.len() - MOST_GROUPS)?;
        }
        self.warnings.iter().try_for_each(|warning| writeln!(f, "warning: {warning}"))
    }
}

//! The summary of an acceptance after ISO 9283.

mod budget;
mod remarks;
mod text;
mod verdicts;

pub use budget::{BudgetSummary, ContributionSummary};
pub(crate) use text::{heads, pose_rows, symbols};
pub use verdicts::{Limit, VerdictSummary};

use serde::Serialize;
use truepose_acceptance::{
    Alignment, Assessment, Characteristics, Compliance, DistanceFigures, Figure, NamedFigures, PathFigures,
};

/// One figure.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FigureSummary {
    /// Its symbol in the standard: `AP_p`, `RP_l`, …
    pub symbol: String,
    /// The figure.
    pub value: f64,
    /// mm, mrad or um/N.
    pub unit: &'static str,
    /// Its standard uncertainty.
    pub u: f64,
    /// Its expanded uncertainty, k = 2.
    pub expanded: f64,
    /// Its 95 % interval.
    pub ci95: [f64; 2],
    /// How the uncertainty was found: `Student`, `chi-squared` (both exact for normal scatter), `first order`, `bootstrap`.
    pub method: &'static str,
    /// The figure before its units were changed.
    #[serde(skip)]
    pub figure: Figure,
}

impl FigureSummary {
    fn new(symbol: impl Into<String>, figure: &Figure, unit: &'static str) -> Self {
        let scaled = figure.scaled(if unit == "um/N" { 1e6 } else { 1e3 });
        FigureSummary {
            symbol: symbol.into(),
            value: scaled.value,
            unit,
            u: scaled.u,
            expanded: scaled.expanded(),
            ci95: scaled.ci95,
            method: figure.method.name(),
            figure: *figure,
        }
    }
}

/// One pose.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TestPoseSummary {
    /// `P1`, …
    pub name: String,
    /// Commanded position, base frame, mm.
    pub commanded_mm: [f64; 3],
    /// Cycles, of the direction of approach with the most.
    pub cycles: usize,
    /// Figures of the pose.
    pub figures: Vec<FigureSummary>,
    /// Attained minus commanded of each cycle, base frame, mm.
    pub deviations_mm: Vec<[f64; 3]>,
}

impl TestPoseSummary {
    /// A figure by its symbol.
    pub fn figure(&self, symbol: &str) -> Option<&FigureSummary> {
        self.figures.iter().find(|figure| figure.symbol == symbol)
    }
}

/// A pair of poses.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DistanceSummary {
    /// Their names.
    pub between: [String; 2],
    /// Commanded distance, mm.
    pub commanded_mm: f64,
    /// Cycles in which both were measured.
    pub cycles: usize,
    /// AD and RD.
    pub figures: Vec<FigureSummary>,
}

/// Static compliance in one direction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComplianceSummary {
    /// Poses: one configuration under different loads.
    pub poses: Vec<String>,
    /// `+x` … `-z`, or the components of the direction, base frame.
    pub direction: String,
    /// Smallest and largest force, N.
    pub forces_n: [f64; 2],
    /// Number of different forces.
    pub levels: usize,
    /// Displacement per force, base frame, µm/N.
    pub displacement_um_per_n: [f64; 3],
    /// Its length.
    pub compliance: FigureSummary,
}

/// A path.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PathSummary {
    /// Cycles.
    pub cycles: usize,
    /// Commanded points.
    pub points: usize,
    /// Points at which every cycle was evaluated.
    pub evaluated: usize,
    /// AT_p and RT_p, each at its worst point.
    pub figures: Vec<FigureSummary>,
    /// Numbers of these points, from 1.
    pub at_points: [usize; 2],
    /// Deviation of the mean at each evaluated point, mm.
    pub deviations_mm: Vec<(usize, f64)>,
}

/// All figures of one state of the robot.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StateSummary {
    /// `as measured`, or `with the identified model`.
    pub name: &'static str,
    /// Poses.
    pub poses: Vec<TestPoseSummary>,
    /// Pairs of poses.
    pub distances: Vec<DistanceSummary>,
    /// Static compliance.
    pub compliance: Vec<ComplianceSummary>,
    /// The path, where one was measured.
    pub path: Option<PathSummary>,
}

impl StateSummary {
    /// The figure of this symbol with the largest magnitude, and of what it is.
    pub(crate) fn worst(&self, symbol: &str) -> Option<(String, &FigureSummary)> {
        let poses = self.poses.iter().flat_map(|pose| pose.figures.iter().map(|f| (pose.name.clone(), f)));
        let pairs = self.distances.iter().flat_map(|d| d.figures.iter().map(|f| (d.between.join("–"), f)));
        let path = self.path.iter().flat_map(|path| path.figures.iter().zip(path.at_points));
        let path = path.map(|(figure, point)| (format!("point {point}"), figure));
        let all = poses.chain(pairs).chain(path).filter(|(_, figure)| figure.symbol == symbol);
        all.reduce(|most, next| if next.1.value.abs() > most.1.value.abs() { next } else { most })
    }
}

/// Everything that is shown of an acceptance.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AcceptanceSummary {
    /// The robot's name.
    pub robot: String,
    /// Rows of data.
    pub rows: usize,
    /// `described`, or `best fit`.
    pub alignment: &'static str,
    /// Standard uncertainty of the instrument that readings of a pose share, each axis, mm.
    pub instrument_u_mm: f64,
    /// As measured.
    pub before: StateSummary,
    /// With the identified model; null without a fit.
    pub after: Option<StateSummary>,
    /// Figures against their limits; empty without limits.
    pub verdicts: Vec<VerdictSummary>,
    /// The verdict over all limits: of the state with the model, where there is one; null without limits.
    pub verdict: Option<&'static str>,
    /// Uncertainty budget of a position that the calibrated robot attains once; null without a fit.
    pub budget: Option<BudgetSummary>,
    /// What a reader has to know.
    pub remarks: Vec<String>,
}

impl AcceptanceSummary {
    /// Of an assessment, with limits.
    pub fn new(robot: &str, rows: usize, found: &Assessment, limits: &[Limit]) -> Self {
        let before = state("as measured", &found.before);
        let after = found.after.as_ref().map(|after| state("with the identified model", after));
        let states: Vec<&StateSummary> = std::iter::once(&before).chain(&after).collect();
        let verdicts: Vec<VerdictSummary> =
            states.iter().flat_map(|state| verdicts::verdicts(state, limits)).collect();
        let judged = states.last().map_or("", |state| state.name);
        let verdict = verdicts::overall(&verdicts, judged, limits);
        AcceptanceSummary {
            robot: robot.into(),
            rows,
            alignment: match found.alignment {
                Alignment::Described => "described",
                Alignment::BestFit => "best fit",
            },
            instrument_u_mm: 1e3 * found.common,
            verdicts,
            verdict,
            budget: found.budget.as_ref().map(BudgetSummary::of_assessment),
            remarks: found.remarks.iter().map(remarks::sentence).collect(),
            before,
            after,
        }
    }

    /// Whether some limit is shown not to be kept.
    pub fn fails(&self) -> bool {
        self.verdict == Some("not conform")
    }
}

fn state(name: &'static str, of: &Characteristics) -> StateSummary {
    StateSummary {
        name,
        poses: of.poses.iter().map(pose).collect(),
        distances: of.distances.iter().map(|(a, b, d)| distance(&of.poses[*a], &of.poses[*b], d)).collect(),
        compliance: of.compliance.iter().map(compliance).collect(),
        path: of.path.as_ref().map(path),
    }
}

fn axes(symbols: [&str; 3], figures: &[Figure; 3], unit: &'static str) -> Vec<FigureSummary> {
    symbols
        .into_iter()
        .zip(figures)
        .map(|(symbol, figure)| FigureSummary::new(symbol, figure, unit))
        .collect()
}

fn pose(of: &NamedFigures) -> TestPoseSummary {
    let figures = &of.pose;
    let mut all = vec![FigureSummary::new("AP_p", &figures.ap, "mm")];
    all.extend(axes(["AP_x", "AP_y", "AP_z"], &figures.ap_axes, "mm"));
    all.extend(figures.ap_angles.iter().flat_map(|f| axes(["AP_a", "AP_b", "AP_c"], f, "mrad")));
    all.push(FigureSummary::new("RP_l", &figures.rp, "mm"));
    all.extend(figures.rp_angles.iter().flat_map(|f| axes(["RP_a", "RP_b", "RP_c"], f, "mrad")));
    if let Some(multi) = &of.directions {
        all.push(FigureSummary::new("vAP_p", &multi.vap, "mm"));
        all.extend(multi.vap_angles.iter().flat_map(|f| axes(["vAP_a", "vAP_b", "vAP_c"], f, "mrad")));
    }
    if let Some(drift) = &of.drift {
        all.push(FigureSummary::new("dAP_p", &drift.dap, "mm"));
        all.push(FigureSummary::new("dRP_l", &drift.drp, "mm"));
    }
    TestPoseSummary {
        name: of.name.clone(),
        commanded_mm: of.commanded.map(|v| 1e3 * v),
        cycles: figures.cycles,
        figures: all,
        deviations_mm: of.deviations.iter().map(|d| d.map(|v| 1e3 * v)).collect(),
    }
}

fn distance(a: &NamedFigures, b: &NamedFigures, of: &DistanceFigures) -> DistanceSummary {
    let mut figures = vec![FigureSummary::new("AD_p", &of.ad, "mm")];
    figures.extend(axes(["AD_x", "AD_y", "AD_z"], &of.ad_axes, "mm"));
    figures.push(FigureSummary::new("RD_p", &of.rd, "mm"));
    figures.extend(axes(["RD_x", "RD_y", "RD_z"], &of.rd_axes, "mm"));
    DistanceSummary {
        between: [a.name.clone(), b.name.clone()],
        commanded_mm: 1e3 * of.commanded,
        cycles: of.cycles,
        figures,
    }
}

fn compliance(of: &Compliance) -> ComplianceSummary {
    let axis = (0..3).find(|&k| of.direction[k].abs() > 1.0 - 1e-9);
    let direction = match axis {
        Some(k) => format!("{}{}", if of.direction[k] > 0.0 { '+' } else { '-' }, ["x", "y", "z"][k]),
        None => {
            let [x, y, z]: [f64; 3] = of.direction.into();
            format!("({x:.3}, {y:.3}, {z:.3})")
        }
    };
    ComplianceSummary {
        poses: of.poses.clone(),
        direction,
        forces_n: of.forces,
        levels: of.levels,
        displacement_um_per_n: (of.displacement * 1e6).into(),
        compliance: FigureSummary::new("compliance", &of.compliance, "um/N"),
    }
}

fn path(of: &PathFigures) -> PathSummary {
    PathSummary {
        cycles: of.cycles,
        points: of.points,
        evaluated: of.evaluated,
        figures: vec![FigureSummary::new("AT_p", &of.at, "mm"), FigureSummary::new("RT_p", &of.rt, "mm")],
        at_points: [of.at_point + 1, of.rt_point + 1],
        deviations_mm: of.deviations.iter().map(|(point, d)| (point + 1, 1e3 * d)).collect(),
    }
}

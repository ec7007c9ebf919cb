//! Is it the robot, or what observed it? Score tests of what a landmark or a sensor takes as given: that it stayed where it was, that a table is flat,
//! that a lens is the stated one.
//!
//! ```text
//! r = (I − X C Xᵀ) y,   g = Aᵀ r,   G = Aᵀ (I − X C Xᵀ) A,   δ = G⁻¹ g,   r' = r − (I − X C Xᵀ) A δ
//! F = (gᵀδ/k) / (Σ r'²/(Σ (1 − λ_i) − k)),                   sums over the numbers of the same kind
//! F_ρ = F / max(1, m),   m = Σ_v u_vᵀ G⁻¹ u_v / (k s²) · n_ρ/(f_ρ − k),   u_v = Σ_{i∈v} a_i r'_i
//! ```
//!
//! | symbol | here |
//! | --- | --- |
//! | X, r, C | design matrix and residual of the fit, over the noise of each number; covariance of the coefficients |
//! | A | n × k: what the k further unknowns do to each number: K of a sensor from some row on, the columns of [`Freed`](super::Freed), of tool or base, or a row alone |
//! | λ_i | leverage, x_i C x_iᵀ |
//! | v, a_i, s² | standstills; rows of A − X C XᵀA; the denominator of F |
//! | n_ρ, f_ρ | directions in which standstills can be displaced; degrees of freedom that the fit leaves to them |
//!
//! Where the numbers of a standstill share a displacement, the fit of the test has numbers that share nothing and have the same variance in all: what is
//! wrong throughout looks like a displacement of every standstill, and the estimate of these takes it up. It is tested by F_ρ, of which m is the mean
//! factor by which standstills scatter more than independent numbers (Rao and Scott 1981, first order).
//!
//! Something that moved has to show more than the visits would in any other order (`order`).
//!
//! G allows for all that the robot can take over, so that an arm with errors is not taken for a bent table (Rao 1948; with the prior of the fit as
//! that of a mixed model). p is multiplied by the number of tests. The most significant suspicion joins X and everything is tested again beside it:
//! what is wrong with one thing pulls its neighbours along, and they are not to blame (forward selection).

mod allowed;
mod design;
mod order;

pub use allowed::allowed_for;

use super::Touched;
use crate::{Fit, FitOptions, IdentifyError, NoiseModel, NoiseSource, Residuals, fit_again};
use design::{Design, LEVEL, Shared, Tested};
use std::collections::BTreeMap;
use truepose_errormodel::{Column, Dataset, ErrorModel, own_channel};
use truepose_kinematics::{FrameId, SEEN, Site, ToolId};
use truepose_solvers::PivotedQr;

/// What an observation takes as given, and what is wrong with it.
#[derive(Debug, Clone, PartialEq)]
pub struct Suspect {
    /// The landmark, sensor, tool or base.
    pub name: String,
    /// What is wrong: `moved`, `mounted` where a tool or the base sits differently, `row` where one of its rows is elsewhere, or what was taken as given.
    pub what: &'static str,
    /// The first row from which on it has moved, or the one that is elsewhere; none of what is wrong throughout.
    pub from: Option<usize>,
    /// The landmark that such a row touched, where there is one.
    pub instead: Option<String>,
    /// By how much: name, value, standard deviation, SI unit.
    pub values: Vec<(String, f64, f64, String)>,
    /// RMS over its rows of what that explains, m, or in the unit of the kind.
    pub size: f64,
    /// Of all tests together.
    pub p_value: f64,
}

/// And where it explains so much of the squares of its rows: an arm with errors that the model lacks leaves more than noise, a little of
/// which looks like anything. A convention.
const SHARE: f64 = 0.25;
/// Numbers of a design matrix, at most: beyond, nothing is tested.
const LARGEST: usize = 50_000_000;
/// Suspicions of one campaign, at most.
const MOST: usize = 12;
/// A suspicion explains at least this share of what the largest before it does: of large faults something is left that is not linear. A
/// convention.
const SMALL: f64 = 0.03;

/// Tests every landmark and every sensor of a fit of these rows.
///
/// # Errors
/// When the data does not fit the model.
pub fn suspects(fit: &Fit, data: &Dataset, touched: &Touched) -> Result<Vec<Suspect>, IdentifyError> {
    let derived = &*data.derived_for(fit.fitted.model())?;
    if derived.len() * 3 * fit.fitted.coefficients().len() > LARGEST {
        return Ok(Vec::new());
    }
    // What is wrong throughout looks like a displacement of each standstill: it is tested beside numbers that share nothing.
    let apart = apart(fit, data, derived)?;
    let (base, shared) = apart.as_ref().map_or((fit, None), |(base, shared)| (base, Some(*shared)));
    let mut design = Design::of(base, derived, &touched.standstills, shared)?;
    let ends = ends(fit.fitted.model());
    let mut found: Vec<Suspect> = Vec::new();
    while found.len() < MOST {
        let (tests, best) = worst(&design, derived, (touched, &ends), &found);
        let Some(Named { name, columns, what, from, weight, tested }) = best else { break };
        let p_value = (tested.p_value * tests as f64).min(1.0);
        if p_value >= LEVEL {
            break;
        }
        // A number of a row is in metres of the weighted rows there.
        let by = if what == ROW { weight } else { 1.0 };
        let value = |(column, (value, sd)): (&Column, &(f64, f64))| {
            (column.name.clone(), value / by, sd / by, column.unit.clone())
        };
        let values = columns.iter().zip(&tested.values).map(value).collect();
        let instead = if what == ROW { touched_instead(fit, data, touched, from)? } else { None };
        found.push(Suspect { name, what, from, instead, values, size: tested.size / weight, p_value });
        if !design.join(&tested) {
            break;
        }
    }
    Ok(found)
}

/// The fit again, with numbers that share nothing and have as much noise in all, and what they shared; none where they share nothing.
fn apart(fit: &Fit, data: &Dataset, derived: &Dataset) -> Result<Option<(Fit, Shared)>, IdentifyError> {
    let noise = fit.noise;
    let Some(left) = fit.scatter.filter(|_| noise.visit_sd > 0.0) else { return Ok(None) };
    let rays = || (0..derived.len()).map(|row| derived.ray(row).map_or(1.0, |ray| ray.norm_squared()));
    let typical = (rays().sum::<f64>() / derived.len().max(1) as f64).sqrt();
    let whole =
        NoiseModel { position_sd: noise.position_sd.hypot(noise.visit_sd * typical), visit_sd: 0.0, ..noise };
    let options = FitOptions { noise: NoiseSource::Fixed(whole), ..FitOptions::default() };
    let Ok(again) = fit_again(fit, data, &PivotedQr::default(), &options) else { return Ok(None) };
    let mut rows: BTreeMap<usize, usize> = BTreeMap::new();
    derived.visit.iter().for_each(|&visit| *rows.entry(visit).or_default() += 1);
    let directions = match derived.rays() {
        Some(_) => rows.values().map(|&rows| rows.min(3)).sum(),
        None => 3 * rows.len(),
    };
    let shared = Shared { noise, directions: directions as f64, freedom: left.between };
    Ok(Some((again, shared)))
}

/// The word for what lies elsewhere from some row on.
const MOVED: &str = "moved";
/// And for one row that is elsewhere.
const ROW: &str = "row";
/// And for a tool or a base that sits differently from some row on.
const MOUNTED: &str = "mounted";

/// The base or a tool: columns of the fit that say how it sits, and where they are in it.
struct End {
    name: String,
    columns: Vec<Column>,
    places: Vec<usize>,
    is_tool: bool,
}

/// Of each tool and of the base its six components, and its three translations alone: what is touched with one point shows no more.
fn ends(model: &ErrorModel) -> Vec<End> {
    let chain = model.chain();
    let tools = (0..chain.tools().len()).map(|tool| chain.frame_of_tool(ToolId(tool)));
    let of = |frame: FrameId, turns: bool| {
        let own = |column: &Column| match column.site {
            Some(Site::Frame(at, axis)) => at == frame && (turns || !axis.is_rotation()),
            _ => false,
        };
        let places: Vec<usize> =
            model.columns().iter().enumerate().filter(|(_, column)| own(column)).map(|(k, _)| k).collect();
        let columns = places.iter().map(|&k| model.columns()[k].clone()).collect();
        End { name: chain.frame_word(frame).to_owned(), columns, places, is_tool: frame != FrameId::BASE }
    };
    let both = tools.chain([FrameId::BASE]).flat_map(|frame| [of(frame, true), of(frame, false)]);
    both.filter(|end| !end.columns.is_empty()).collect()
}

/// Whether all these rows are images of one camera on the robot: its tool that sits differently is the camera that moved, and called so.
fn carries_one_camera(data: &Dataset, touched: &Touched, rows: &[usize]) -> bool {
    let targets = touched.chain.targets();
    let seen = |row: usize| {
        let of_row = data.target[row].and_then(|target| targets.get(target.0));
        data.sensor(row).filter(|_| of_row.is_some_and(|target| target.name.starts_with(SEEN)))
    };
    let first = rows.first().and_then(|&row| seen(row));
    first.is_some() && rows.iter().all(|&row| seen(row) == first)
}

/// The landmark at which a row was that named another one: the nearest to where the robot is by a fit of the other rows, much nearer than the one it
/// names.
fn touched_instead(
    fit: &Fit,
    data: &Dataset,
    touched: &Touched,
    row: Option<usize>,
) -> Result<Option<String>, IdentifyError> {
    /// Of the distance to the landmark that it names, at most so much.
    const NEAR: f64 = 0.1;
    let Some((row, own)) = row.and_then(|row| Some((row, data.landmark(row)?))) else { return Ok(None) };
    let others: Vec<usize> = (0..data.len()).filter(|&other| other != row).collect();
    let rest = data.select(&others);
    let Ok(again) = fit_again(fit, &rest, &PivotedQr::default(), &FitOptions::default()) else {
        return Ok(None);
    };
    // Where the robot is beside the place of a landmark, as both are fitted.
    let away = |k: usize| {
        let there = (0..data.len()).find(|&other| other != row && data.landmark(other) == Some(k))?;
        let mut one = data.select(&[row]);
        one.position[0] = data.position[there];
        one.set_landmarks(Some(&[Some(k)]));
        let left = Residuals::of(&again.fitted, &one).ok()?.position[0].norm();
        left.is_finite().then_some((k, left))
    };
    let nearest =
        (0..touched.names.len()).filter(|&k| k != own).filter_map(away).min_by(|a, b| a.1.total_cmp(&b.1));
    let found = nearest.zip(away(own)).filter(|((_, left), (_, named))| *left < NEAR * named);
    Ok(found.map(|((k, _), _)| touched.names[k].clone()))
}

/// A test, and what it says where it is significant.
struct Named {
    name: String,
    columns: Vec<Column>,
    what: &'static str,
    from: Option<usize>,
    weight: f64,
    tested: Tested,
}

/// The number of tests, and the most significant one that explains enough and was not found before.
fn worst(
    design: &Design,
    derived: &Dataset,
    (touched, ends): (&Touched, &[End]),
    found: &[Suspect],
) -> (usize, Option<Named>) {
    let mut tests = 0usize;
    let mut best: Option<Named> = None;
    let largest = found.iter().map(|found| found.size).fold(0.0, f64::max);
    let mut keep = |named: Named| {
        // Faults so large that no p is left are told apart by what they explain.
        let better = |known: &Named| {
            let (p, before) = (named.tested.p_value, known.tested.p_value);
            p.total_cmp(&before).then(known.tested.share.total_cmp(&named.tested.share)).is_lt()
        };
        // One thing at a time of each; several rows may be elsewhere.
        let rows = |found: &Suspect| found.what == ROW && named.what == ROW && found.from != named.from;
        let again = found.iter().any(|found| found.name == named.name && !rows(found));
        let small = named.tested.size / named.weight < SMALL * largest;
        if named.tested.share >= SHARE && !again && !small && best.as_ref().is_none_or(better) {
            best = Some(named);
        }
    };
    for End { name, columns, places, is_tool } in ends {
        let rows = design.rows_of(places);
        if *is_tool && carries_one_camera(derived, touched, &rows) {
            continue;
        }
        let column = |i: usize| places.iter().map(|&place| design.number(i, place)).collect();
        if let Some((tested, from)) = design.moved(columns.len(), &rows, &column, &|_| true, &mut tests) {
            let (name, columns) = (name.clone(), columns.clone());
            keep(Named { name, columns, what: MOUNTED, from: Some(from), weight: 1.0, tested });
        }
    }
    for (k, name) in touched.names.iter().enumerate() {
        let rows: Vec<usize> = (0..derived.len()).filter(|row| derived.landmark(*row) == Some(k)).collect();
        let columns = ["x", "y", "z"].map(|axis| Column::new(format!("{axis}@{name}"), "m", 1.0)).to_vec();
        let column =
            |i: usize| (0..3).map(|axis| if design.component[i] == axis { -1.0 } else { 0.0 }).collect();
        let kind = |row: usize| derived.landmark(row).is_some();
        if let Some((tested, from)) = design.moved(columns.len(), &rows, &column, &kind, &mut tests) {
            let name = name.clone();
            keep(Named {
                name,
                columns: columns.clone(),
                what: MOVED,
                from: Some(from),
                weight: 1.0,
                tested,
            });
        }
        let left = design.left(&kind);
        for &row in &rows {
            tests += 1;
            if let Some(tested) = design.alone(row, &left) {
                let (name, columns) = (name.clone(), columns[..tested.values.len().min(3)].to_vec());
                keep(Named { name, columns, what: ROW, from: Some(row), weight: 1.0, tested });
            }
        }
    }
    let own: Vec<&Vec<f64>> =
        (0..).map_while(|k| derived.schema.channel(&own_channel(k))).map(|k| &derived.channels[k]).collect();
    for (k, sensor) in touched.sensors.iter().enumerate() {
        let (name, weight) = (&sensor.name, sensor.weight);
        let rows: Vec<usize> = (0..derived.len()).filter(|&row| derived.sensor(row) == Some(k)).collect();
        let columns = sensor.observation.unknowns(name, 1.0);
        let column = |i: usize| {
            let row = design.row[i];
            let square = derived.ray(row).map_or(0.0, |w| w.norm_squared());
            own.iter().take(columns.len()).map(|own| own[row] * square).collect()
        };
        let of_kind = |row: usize| {
            let observed = derived.sensor(row).map(|k| &touched.sensors[k].observation);
            observed.is_some_and(|observation| observation.kind() == sensor.observation.kind())
        };
        if let Some((tested, from)) = design.moved(columns.len(), &rows, &column, &of_kind, &mut tests) {
            keep(Named { name: name.clone(), columns, what: MOVED, from: Some(from), weight, tested });
        }
        let left = design.left(&of_kind);
        for &row in &rows {
            tests += 1;
            if let Some(tested) = design.alone(row, &left) {
                let (unit, count) = (sensor.observation.unit(), tested.values.len());
                let columns = (1..=count).map(|k| Column::new(format!("number {k} of {name}"), unit, 1.0));
                let columns = columns.collect();
                keep(Named { name: name.clone(), columns, what: ROW, from: Some(row), weight, tested });
            }
        }
        for freed in touched.freed.iter().filter(|freed| freed.sensor == k) {
            tests += 1;
            let own = design.own(&rows);
            let a = own.columns(freed.columns.len(), |i| {
                let at = freed.rows.binary_search_by_key(&design.row[i], |(row, _)| *row);
                at.map_or_else(|_| vec![0.0; freed.columns.len()], |at| freed.rows[at].1.clone())
            });
            if let Some(tested) = own.throughout(a, &design.left(&of_kind)) {
                let columns = freed.columns.clone();
                keep(Named { name: name.clone(), columns, what: freed.what, from: None, weight, tested });
            }
        }
    }
    (tests, best)
}

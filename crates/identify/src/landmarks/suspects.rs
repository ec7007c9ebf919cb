//! Is it the robot, or what observed it? Score tests of what a landmark or a sensor takes as given: that it stayed where it was, that a table is flat,
//! that a lens is the stated one.
//!
//! ```text
//! r = (I − X C Xᵀ) y,   g = Aᵀ r,   G = Aᵀ (I − X C Xᵀ) A,   δ = G⁻¹ g
//! F = (gᵀδ/k) / ((Σ r² − gᵀδ)/(Σ (1 − λ_i) − k)),            sums over the numbers of the same kind
//! ```
//!
//! | symbol | here |
//! | --- | --- |
//! | X, r, C | design matrix and residual of the fit, over the noise of each number; covariance of the coefficients |
//! | A | n × k: what the k further unknowns do to each number: K of a sensor from some row on, or the columns of [`Freed`] |
//! | λ_i | leverage, x_i C x_iᵀ |
//!
//! G allows for all that the robot can take over, so that an arm with errors is not taken for a bent table (Rao 1948; with the prior of the fit as
//! that of a mixed model). p is multiplied by the number of tests.

use super::Touched;
use crate::linearise::Lineariser;
use crate::{Fit, IdentifyError};
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};
use truepose_errormodel::{Column, Dataset, own_channel};

/// What an observation takes as given, and what is wrong with it.
#[derive(Debug, Clone, PartialEq)]
pub struct Suspect {
    /// The landmark or sensor.
    pub name: String,
    /// What is wrong: `moved`, or what was taken as given.
    pub what: &'static str,
    /// The first row from which on it has moved; none of what is wrong throughout.
    pub from: Option<usize>,
    /// By how much: name, value, standard deviation, SI unit.
    pub values: Vec<(String, f64, f64, String)>,
    /// RMS over its rows of what that explains, m, or in the unit of the kind.
    pub size: f64,
    /// Of all tests together.
    pub p_value: f64,
}

/// A suspicion is reported from this p on, of all tests together. A convention.
const LEVEL: f64 = 1e-3;
/// And where it explains so much of the squares of its rows: an arm with errors that the model lacks leaves more than noise, a little of
/// which looks like anything. A convention.
const SHARE: f64 = 0.25;
/// Places in the order of the rows at which a move is looked for, at most.
const INSTANTS: usize = 24;
/// Share of a column that the robot must leave for a test.
const LEFT: f64 = 1e-4;
/// Numbers of a design matrix, at most.
const LARGEST: usize = 50_000_000;

/// Tests every landmark and every sensor of a fit of these rows.
///
/// # Errors
/// When the data does not fit the model.
pub fn suspects(fit: &Fit, data: &Dataset, touched: &Touched) -> Result<Vec<Suspect>, IdentifyError> {
    let derived = &*data.derived_for(fit.fitted.model())?;
    if derived.len() * 3 * fit.fitted.coefficients().len() > LARGEST {
        return Ok(Vec::new());
    }
    let design = Design::of(fit, derived)?;
    let mut tests = 0usize;
    let mut all = Vec::new();
    let met: Vec<usize> = touched.contacts.iter().flat_map(|contact| contact.rows).collect();
    for (k, name) in touched.names.iter().enumerate() {
        let rows: Vec<usize> =
            (0..data.len()).filter(|row| derived.landmark(*row) == Some(k) && !met.contains(row)).collect();
        let axes = ["x", "y", "z"].map(|axis| Column::new(format!("{axis}@{name}"), "m", 1.0));
        let column =
            |i: usize| (0..3).map(|axis| if design.component[i] == axis { -1.0 } else { 0.0 }).collect();
        let kind = |row: usize| derived.landmark(row).is_some();
        all.extend(design.moved((name.as_str(), &axes, 1.0), &rows, &column, &kind, &mut tests));
    }
    let own: Vec<&Vec<f64>> =
        (0..).map_while(|k| derived.schema.channel(&own_channel(k))).map(|k| &derived.channels[k]).collect();
    for (k, found) in touched.sensors.iter().enumerate() {
        let rows: Vec<usize> = (0..data.len()).filter(|&row| derived.sensor(row) == Some(k)).collect();
        let unknowns = found.observation.unknowns(&found.name, 1.0);
        let column = |i: usize| {
            let row = design.row[i];
            let square = derived.ray(row).map_or(0.0, |w| w.norm_squared());
            own.iter().take(unknowns.len()).map(|own| own[row] * square).collect()
        };
        let of_kind = |row: usize| {
            let sensor = derived.sensor(row).map(|k| &touched.sensors[k].observation);
            sensor.is_some_and(|observation| observation.kind() == found.observation.kind())
        };
        let named = (found.name.as_str(), unknowns.as_slice(), found.weight);
        all.extend(design.moved(named, &rows, &column, &of_kind, &mut tests));
        for freed in touched.freed.iter().filter(|freed| freed.sensor == k) {
            tests += 1;
            let a = design.columns(freed.columns.len(), |i| {
                let own = freed.rows.iter().find(|(row, _)| *row == design.row[i]);
                own.map_or_else(|| vec![0.0; freed.columns.len()], |(_, by)| by.clone())
            });
            if let Some(tested) = design.test(&a, &rows, &of_kind) {
                let named = (found.name.as_str(), freed.columns.as_slice(), found.weight);
                all.extend(tested.suspect(named, freed.what, None));
            }
        }
    }
    all.iter_mut().for_each(|suspect| suspect.p_value = (suspect.p_value * tests as f64).min(1.0));
    all.retain(|suspect| suspect.p_value < LEVEL);
    all.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
    Ok(all)
}

/// The design matrix of a fit, number by number, over their noise.
struct Design<'f> {
    covariance: &'f DMatrix<f64>,
    x: DMatrix<f64>,
    residual: DVector<f64>,
    leverage: Vec<f64>,
    noise: Vec<f64>,
    row: Vec<usize>,
    component: Vec<usize>,
}

/// A test: what it explains of its own rows, and by what.
struct Tested {
    p_value: f64,
    share: f64,
    /// RMS over its rows, in metres of the weighted rows.
    size: f64,
    values: Vec<(f64, f64)>,
}

impl Tested {
    fn suspect(
        self,
        (name, columns, weight): (&str, &[Column], f64),
        what: &'static str,
        from: Option<usize>,
    ) -> Option<Suspect> {
        let value = |(column, (value, sd)): (&Column, &(f64, f64))| {
            (column.name.clone(), *value, *sd, column.unit.clone())
        };
        (self.share >= SHARE).then(|| Suspect {
            name: name.into(),
            what,
            from,
            values: columns.iter().zip(&self.values).map(value).collect(),
            size: self.size / weight,
            p_value: self.p_value,
        })
    }
}

impl<'f> Design<'f> {
    fn of(fit: &'f Fit, data: &Dataset) -> Result<Self, IdentifyError> {
        let covariance = fit.fitted.covariance();
        let mut lineariser = Lineariser::new(fit.fitted.model(), data, fit.noise, fit.fitted.coefficients())?;
        let width = lineariser.width();
        let (mut x, mut residual, mut noise) = (Vec::new(), Vec::new(), Vec::new());
        let (mut row, mut component) = (Vec::new(), Vec::new());
        for at in 0..data.len() {
            let block = lineariser.unweighted(&[at]);
            for (numbers, &(_, which)) in block.rows.chunks_exact(width).zip(block.source) {
                if which > 2 {
                    continue;
                }
                let sd = fit.noise.position(data.position_sd[at][which]).hypot(fit.noise.visit_sd);
                x.extend(numbers[..width - 1].iter().map(|v| v / sd));
                residual.push(numbers[width - 1] / sd);
                noise.push(sd);
                row.push(at);
                component.push(which);
            }
        }
        let x = DMatrix::from_row_iterator(row.len(), width - 1, x);
        let spread = &x * covariance;
        let leverage = (0..row.len()).map(|i| x.row(i).dot(&spread.row(i)).clamp(0.0, 1.0)).collect();
        Ok(Design { covariance, x, residual: DVector::from_vec(residual), leverage, noise, row, component })
    }

    /// Further columns: what a unit of each does to a number.
    fn columns(&self, count: usize, of: impl Fn(usize) -> Vec<f64>) -> DMatrix<f64> {
        let mut a = DMatrix::zeros(self.row.len(), count);
        for i in 0..self.row.len() {
            of(i).into_iter().enumerate().for_each(|(k, v)| a[(i, k)] = v / self.noise[i]);
        }
        a
    }

    /// Whether what these rows share changed from one of them on: the instant that explains most.
    fn moved(
        &self,
        named: (&str, &[Column], f64),
        rows: &[usize],
        column: &dyn Fn(usize) -> Vec<f64>,
        of_kind: &dyn Fn(usize) -> bool,
        tests: &mut usize,
    ) -> Option<Suspect> {
        let width = named.1.len();
        // As many rows on either side as unknowns, and two more.
        let least = width + 2;
        if width == 0 || rows.len() < 2 * least {
            return None;
        }
        let places = rows.len() - 2 * least + 1;
        let instants = (0..INSTANTS.min(places)).map(|k| least + k * places / INSTANTS.min(places));
        let mut best: Option<(Tested, usize)> = None;
        for instant in instants {
            *tests += 1;
            let from = rows[instant];
            let inside = |i: usize| self.row[i] >= from && rows.binary_search(&self.row[i]).is_ok();
            let a = self.columns(width, |i| if inside(i) { column(i) } else { vec![0.0; width] });
            if let Some(tested) = self.test(&a, rows, of_kind)
                && best.as_ref().is_none_or(|(best, _)| tested.p_value < best.p_value)
            {
                best = Some((tested, from));
            }
        }
        best.and_then(|(tested, from)| tested.suspect(named, "moved", Some(from)))
    }

    fn test(&self, a: &DMatrix<f64>, rows: &[usize], of_kind: &dyn Fn(usize) -> bool) -> Option<Tested> {
        let left = a - &self.x * (self.covariance * self.x.tr_mul(a));
        let (g, matrix) = (a.tr_mul(&self.residual), a.tr_mul(&left));
        let whole: Vec<f64> = a.column_iter().map(|column| column.norm_squared()).collect();
        if (0..whole.len()).any(|k| matrix[(k, k)] <= LEFT * whole[k]) {
            return None;
        }
        let inverse = matrix.cholesky()?.inverse();
        let by = &inverse * &g;
        let explained = g.dot(&by);
        let (mut squares, mut freedom, mut own, mut size, mut count) = (0.0, 0.0, 0.0, 0.0, 0usize);
        let fitted = &left * &by;
        for i in 0..self.row.len() {
            let square = self.residual[i] * self.residual[i];
            if of_kind(self.row[i]) {
                squares += square;
                freedom += 1.0 - self.leverage[i];
            }
            if rows.binary_search(&self.row[i]).is_ok() {
                own += square;
                size += (fitted[i] * self.noise[i]).powi(2);
                count += 1;
            }
        }
        let k = a.ncols() as f64;
        if freedom < k + 2.0 || squares <= explained {
            return None;
        }
        let noise = (squares - explained) / (freedom - k);
        let p_value = FisherSnedecor::new(k, freedom - k).ok()?.sf(explained / k / noise);
        let values = by.iter().enumerate().map(|(j, v)| (*v, (noise * inverse[(j, j)]).sqrt()));
        Some(Tested {
            p_value,
            share: explained / own.max(f64::MIN_POSITIVE),
            size: (size / count.max(1) as f64).sqrt(),
            values: values.collect(),
        })
    }
}

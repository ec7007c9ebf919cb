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
/// Numbers of a design matrix, at most: beyond, nothing is tested.
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
    for (k, name) in touched.names.iter().enumerate() {
        let rows: Vec<usize> = (0..data.len()).filter(|row| derived.landmark(*row) == Some(k)).collect();
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
            let own = design.own(&rows);
            let a = own.columns(freed.columns.len(), |i| {
                let at = freed.rows.binary_search_by_key(&design.row[i], |(row, _)| *row);
                at.map_or_else(|_| vec![0.0; freed.columns.len()], |at| freed.rows[at].1.clone())
            });
            if let Some(tested) = own.test(&a, design.left(&of_kind)) {
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

    /// The numbers of some rows, ascending.
    fn own(&self, rows: &[usize]) -> Own<'_> {
        let numbers: Vec<usize> =
            (0..self.row.len()).filter(|&i| rows.binary_search(&self.row[i]).is_ok()).collect();
        Own { design: self, x: self.x.select_rows(&numbers), numbers }
    }

    /// Squares and degrees of freedom that are left to the numbers of a kind.
    fn left(&self, of_kind: &dyn Fn(usize) -> bool) -> (f64, f64) {
        let numbers = (0..self.row.len()).filter(|&i| of_kind(self.row[i]));
        numbers.fold((0.0, 0.0), |(squares, freedom), i| {
            (squares + self.residual[i].powi(2), freedom + 1.0 - self.leverage[i])
        })
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
        let (own, left) = (self.own(rows), self.left(of_kind));
        let mut best: Option<(Tested, usize)> = None;
        for instant in instants {
            *tests += 1;
            let from = rows[instant];
            let a = own.columns(width, |i| if self.row[i] >= from { column(i) } else { vec![0.0; width] });
            if let Some(tested) = own.test(&a, left)
                && best.as_ref().is_none_or(|(best, _)| tested.p_value < best.p_value)
            {
                best = Some((tested, from));
            }
        }
        best.and_then(|(tested, from)| tested.suspect(named, "moved", Some(from)))
    }
}

/// The numbers of one landmark or sensor: further columns are zero in all others.
struct Own<'d> {
    design: &'d Design<'d>,
    numbers: Vec<usize>,
    x: DMatrix<f64>,
}

impl Own<'_> {
    /// Further columns: what a unit of each does to a number of the design.
    fn columns(&self, count: usize, of: impl Fn(usize) -> Vec<f64>) -> DMatrix<f64> {
        let mut a = DMatrix::zeros(self.numbers.len(), count);
        for (at, &i) in self.numbers.iter().enumerate() {
            of(i).into_iter().enumerate().for_each(|(k, v)| a[(at, k)] = v / self.design.noise[i]);
        }
        a
    }

    /// The test of these columns, `left` being the squares and degrees of freedom of their kind.
    fn test(&self, a: &DMatrix<f64>, (squares, freedom): (f64, f64)) -> Option<Tested> {
        let Design { covariance, residual, noise, .. } = self.design;
        let residual = residual.select_rows(&self.numbers);
        let left = a - &self.x * (*covariance * self.x.tr_mul(a));
        let (g, matrix) = (a.tr_mul(&residual), a.tr_mul(&left));
        let whole: Vec<f64> = a.column_iter().map(|column| column.norm_squared()).collect();
        if (0..whole.len()).any(|k| matrix[(k, k)] <= LEFT * whole[k]) {
            return None;
        }
        let inverse = matrix.cholesky()?.inverse();
        let by = &inverse * &g;
        let (explained, k) = (g.dot(&by), a.ncols() as f64);
        if freedom < k + 2.0 || squares <= explained {
            return None;
        }
        let scatter = (squares - explained) / (freedom - k);
        let p_value = FisherSnedecor::new(k, freedom - k).ok()?.sf(explained / k / scatter);
        let fitted = left * &by;
        let size: f64 = self.numbers.iter().zip(fitted.iter()).map(|(&i, v)| (v * noise[i]).powi(2)).sum();
        let values = by.iter().enumerate().map(|(j, v)| (*v, (scatter * inverse[(j, j)]).sqrt()));
        Some(Tested {
            p_value,
            share: explained / residual.norm_squared().max(f64::MIN_POSITIVE),
            size: (size / self.numbers.len().max(1) as f64).sqrt(),
            values: values.collect(),
        })
    }
}

//! The design matrix of a fit, and the score test of further columns beside it.

use super::order::Order;
use crate::linearise::Lineariser;
use crate::noise::{Beside, beside_others};
use crate::{Fit, IdentifyError, NoiseModel};
use nalgebra::{DMatrix, DVector, Vector3};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};
use std::collections::BTreeMap;
use truepose_errormodel::Dataset;

/// A suspicion is reported from this p on, of all tests together. A convention.
pub(super) const LEVEL: f64 = 1e-3;
/// Places in the order of the rows at which a move is looked for, at most.
const INSTANTS: usize = 24;
/// Share of a column that the robot must leave for a test.
const LEFT: f64 = 1e-4;
/// A row alone is tested where its squares are so many times those of a number of its kind.
const FAR: f64 = 12.0;

/// The design matrix of a fit, number by number, over their noise.
pub(super) struct Design {
    covariance: DMatrix<f64>,
    x: DMatrix<f64>,
    residual: DVector<f64>,
    leverage: Vec<f64>,
    noise: Vec<f64>,
    pub(super) row: Vec<usize>,
    visit: Vec<usize>,
    pub(super) component: Vec<usize>,
    /// Each number beside the others of its standstill ([`beside_others`]).
    others: Vec<f64>,
    shared: Option<Shared>,
}

/// What the numbers of a standstill share in a fit.
#[derive(Clone, Copy)]
pub(super) struct Shared {
    pub noise: NoiseModel,
    /// Directions in which standstills can be displaced, of all standstills together.
    pub directions: f64,
    /// Degrees of freedom that the unknowns leave to them.
    pub freedom: f64,
}

/// The numbers of each visit of the data.
fn by_visit(row: &[usize], data: &Dataset) -> Vec<Vec<usize>> {
    let mut visits = vec![Vec::new(); data.visit.iter().max().map_or(0, |last| last + 1)];
    row.iter().enumerate().for_each(|(i, &row)| visits[data.visit[row]].push(i));
    visits
}

/// A test: what it explains of its own numbers, and by what.
pub(super) struct Tested {
    pub p_value: f64,
    /// F, which tells large changes apart where no p is left.
    ratio: f64,
    /// Squares of a number that are left, over its variance.
    scatter: f64,
    pub share: f64,
    /// RMS over its numbers, in metres of the weighted rows.
    pub size: f64,
    pub values: Vec<(f64, f64)>,
    /// Its numbers, and A there.
    numbers: Vec<usize>,
    columns: DMatrix<f64>,
}

impl Design {
    /// Of a fit by numbers that count as independent. `standstills`: that of each row; its visit where there are too few. `shared`: what the fit
    /// that is tested takes the numbers of a standstill to share.
    pub(super) fn of(
        fit: &Fit,
        data: &Dataset,
        standstills: &[usize],
        shared: Option<Shared>,
    ) -> Result<Self, IdentifyError> {
        let visit_sd = shared.map_or(fit.noise.visit_sd, |shared| shared.noise.visit_sd);
        let covariance = fit.fitted.covariance().clone();
        let mut lineariser = Lineariser::new(fit.fitted.model(), data, fit.noise, fit.fitted.coefficients())?;
        let width = lineariser.width();
        let (mut x, mut residual, mut noise) = (Vec::new(), Vec::new(), Vec::new());
        let (mut row, mut component, mut beside) = (Vec::new(), Vec::new(), Vec::new());
        for at in 0..data.len() {
            let block = lineariser.unweighted(&[at]);
            for (numbers, &(_, which)) in block.rows.chunks_exact(width).zip(block.source) {
                if which > 2 {
                    continue;
                }
                let stated = data.position_sd[at][which];
                let w = data.ray(at).unwrap_or_else(|| Vector3::ith(which, 1.0));
                let own = fit.noise.position(stated);
                let sd = own.hypot(fit.noise.visit_sd * w.norm());
                let alone = shared.map_or(own, |shared| shared.noise.position(stated));
                beside.push((numbers[width - 1], alone.powi(-2), w, true));
                x.extend(numbers[..width - 1].iter().map(|v| v / sd));
                residual.push(numbers[width - 1] / sd);
                noise.push(sd);
                row.push(at);
                component.push(which);
            }
        }
        let x = DMatrix::from_row_iterator(row.len(), width - 1, x);
        let spread = &x * &covariance;
        let leverage = (0..row.len()).map(|i| x.row(i).dot(&spread.row(i)).clamp(0.0, 1.0)).collect();
        let visit = row.iter().map(|&row| standstills.get(row).copied().unwrap_or(data.visit[row])).collect();
        let residual = DVector::from_vec(residual);
        let mut others = vec![0.0; row.len()];
        for members in by_visit(&row, data) {
            let numbers: Vec<Beside> = members.iter().map(|&i| beside[i]).collect();
            let each = beside_others(&numbers, visit_sd);
            members.iter().zip(each).for_each(|(&i, e)| others[i] = e);
        }
        Ok(Design { covariance, x, residual, leverage, noise, row, visit, component, others, shared })
    }

    /// Takes a suspicion's columns into X, with coefficients of their own; whether that could be done.
    pub(super) fn join(&mut self, tested: &Tested) -> bool {
        let (own, a) = (&tested.numbers, &tested.columns);
        let k = a.ncols();
        // XᵀA, and A − X C XᵀA in all rows.
        let across = &self.covariance * self.x.select_rows(own).tr_mul(a);
        let mut left = -(&self.x * &across);
        for (at, &i) in own.iter().enumerate() {
            left.row_mut(i).zip_apply(&a.row(at), |left, a| *left += a);
        }
        let matrix = a.tr_mul(&left.select_rows(own));
        let Some(inverse) = matrix.cholesky().map(|factor| factor.inverse()) else { return false };
        let by = &inverse * a.tr_mul(&self.residual.select_rows(own));
        self.residual -= &left * by;
        let through = &left * &inverse;
        for (i, leverage) in self.leverage.iter_mut().enumerate() {
            *leverage = (*leverage + through.row(i).dot(&left.row(i))).clamp(0.0, 1.0);
        }
        let before = self.covariance.nrows();
        let beside = -(&across * &inverse);
        let own_part = &self.covariance - &beside * across.transpose();
        let mut covariance = DMatrix::zeros(before + k, before + k);
        covariance.view_mut((0, 0), (before, before)).copy_from(&own_part);
        covariance.view_mut((0, before), (before, k)).copy_from(&beside);
        covariance.view_mut((before, 0), (k, before)).copy_from(&beside.transpose());
        covariance.view_mut((before, before), (k, k)).copy_from(&inverse);
        self.covariance = covariance;
        let x = std::mem::replace(&mut self.x, DMatrix::zeros(0, 0));
        let mut x = x.insert_columns(before, k, 0.0);
        for (at, &i) in own.iter().enumerate() {
            x.view_mut((i, before), (1, k)).copy_from(&a.row(at));
        }
        self.x = x;
        true
    }

    /// What a unit of a column of the fit does to a number, in its unit.
    pub(super) fn number(&self, i: usize, column: usize) -> f64 {
        self.x[(i, column)] * self.noise[i]
    }

    /// The rows to which some of these columns do something, ascending.
    pub(super) fn rows_of(&self, columns: &[usize]) -> Vec<usize> {
        let mut rows: Vec<usize> = (0..self.row.len())
            .filter(|&i| columns.iter().any(|&column| self.x[(i, column)] != 0.0))
            .map(|i| self.row[i])
            .collect();
        rows.dedup();
        rows
    }

    /// The numbers of some rows, ascending.
    pub(super) fn own(&self, rows: &[usize]) -> Own<'_> {
        let numbers: Vec<usize> =
            (0..self.row.len()).filter(|&i| rows.binary_search(&self.row[i]).is_ok()).collect();
        Own { design: self, x: self.x.select_rows(&numbers), numbers }
    }

    /// Whether a row is elsewhere than all others say, each of its numbers by itself.
    pub(super) fn alone(&self, row: usize, left: &Left) -> Option<Tested> {
        let numbers: Vec<usize> = (self.row.partition_point(|&other| other < row)..self.row.len())
            .take_while(|&i| self.row[i] == row)
            .collect();
        let squares: f64 =
            numbers.iter().map(|&i| self.residual[i].powi(2) / (1.0 - self.leverage[i]).max(1e-3)).sum();
        // Where the whole standstill is elsewhere, the row is not.
        let beside: f64 = numbers.iter().map(|&i| self.others[i].powi(2)).sum();
        if squares * left.freedom <= FAR * left.squares || beside <= FAR {
            return None;
        }
        let own = Own { design: self, x: self.x.select_rows(&numbers), numbers };
        let count = own.numbers.len();
        let columns =
            own.columns(count, |i| own.numbers.iter().map(|&other| f64::from(other == i)).collect());
        own.test(columns, left)
    }

    /// What is left to the numbers of a kind.
    pub(super) fn left(&self, of_kind: &dyn Fn(usize) -> bool) -> Left {
        let numbers: Vec<usize> = (0..self.row.len()).filter(|&i| of_kind(self.row[i])).collect();
        let squares = numbers.iter().map(|&i| self.residual[i].powi(2)).sum();
        let freedom = numbers.iter().map(|&i| 1.0 - self.leverage[i]).sum();
        Left { squares, freedom, numbers }
    }

    /// Whether what these rows share changed from one of them on, the first of its visit: the instant that explains most. The order of the visits has
    /// to matter ([`Order`]).
    pub(super) fn moved(
        &self,
        width: usize,
        rows: &[usize],
        column: &dyn Fn(usize) -> Vec<f64>,
        of_kind: &dyn Fn(usize) -> bool,
        tests: &mut usize,
    ) -> Option<(Tested, usize)> {
        // As many rows on either side as unknowns, and two more.
        let least = width + 2;
        if width == 0 || rows.len() < 2 * least {
            return None;
        }
        let (own, left) = (self.own(rows), self.left(of_kind));
        // Nothing moves within a visit.
        let begins = |instant: &usize| own.visit_of(rows[*instant]) != own.visit_of(rows[*instant - 1]);
        let instants: Vec<usize> = (least..=rows.len() - least).filter(begins).collect();
        let places = instants.len();
        let stride = places.div_ceil(INSTANTS).max(1);
        let at = |instant: usize| {
            let from = rows[instant];
            let a = own.columns(width, |i| if self.row[i] >= from { column(i) } else { vec![0.0; width] });
            own.test(a, &left)
        };
        let mut best: Option<(Tested, usize)> = None;
        let mut take = |place: usize| {
            *tests += 1;
            if let Some(tested) = at(instants[place])
                && best.as_ref().is_none_or(|(best, _)| tested.ratio > best.ratio)
            {
                best = Some((tested, place));
            }
            best.as_ref().map(|(_, place)| *place)
        };
        let rough = (0..places).step_by(stride).map(&mut take).last().flatten()?;
        let near = (rough + 1).saturating_sub(stride)..(rough + stride).min(places);
        near.filter(|&place| place != rough).for_each(|place| {
            take(place);
        });
        let (tested, place) = best?;
        let begins: Vec<usize> = (1..rows.len()).filter(begins).collect();
        // Rows of standstills of their own are as independent as the test takes them to be.
        if tested.p_value < LEVEL && begins.len() + 1 < rows.len() {
            // The rough instants and the best one: in another order the best of them is as much a matter of chance.
            let tried = instants.iter().step_by(stride).chain([&instants[place]]);
            let places: Vec<usize> = tried.map(|&at| begins.partition_point(|&b| b < at) + 1).collect();
            let visits: Vec<usize> = own.numbers.iter().map(|&i| self.visit[i]).collect();
            let residual = self.residual.select_rows(&own.numbers);
            let rows = (&own.x, &residual, &own.columns(width, column));
            if !Order::of(&self.covariance, &visits, rows).matters(&places) {
                return None;
            }
        }
        Some((tested, rows[instants[place]]))
    }
}

/// The numbers of a kind, their squares and degrees of freedom.
pub(super) struct Left {
    squares: f64,
    freedom: f64,
    numbers: Vec<usize>,
}

/// The numbers of one landmark or sensor: further columns are zero in all others.
pub(super) struct Own<'d> {
    design: &'d Design,
    numbers: Vec<usize>,
    x: DMatrix<f64>,
}

impl Own<'_> {
    /// Further columns: what a unit of each does to a number of the design.
    pub(super) fn columns(&self, count: usize, of: impl Fn(usize) -> Vec<f64>) -> DMatrix<f64> {
        let mut a = DMatrix::zeros(self.numbers.len(), count);
        for (at, &i) in self.numbers.iter().enumerate() {
            of(i).into_iter().enumerate().for_each(|(k, v)| a[(at, k)] = v / self.design.noise[i]);
        }
        a
    }

    /// The visit of one of its rows.
    fn visit_of(&self, row: usize) -> Option<usize> {
        let at = self.numbers.partition_point(|&i| self.design.row[i] < row);
        self.numbers.get(at).map(|&i| self.design.visit[i])
    }

    /// The test of these columns; `kind` is what is left to the numbers of their kind.
    pub(super) fn test(&self, a: DMatrix<f64>, kind: &Left) -> Option<Tested> {
        let Design { covariance, residual, noise, .. } = self.design;
        let residual = residual.select_rows(&self.numbers);
        let across = covariance * self.x.tr_mul(&a);
        let left = &a - &self.x * &across;
        let (g, matrix) = (a.tr_mul(&residual), a.tr_mul(&left));
        let whole: Vec<f64> = a.column_iter().map(|column| column.norm_squared()).collect();
        if (0..whole.len()).any(|k| matrix[(k, k)] <= LEFT * whole[k]) {
            return None;
        }
        let inverse = matrix.cholesky()?.inverse();
        let by = &inverse * &g;
        let (explained, k) = (g.dot(&by), a.ncols() as f64);
        if kind.freedom < k + 2.0 {
            return None;
        }
        let squares = self.squares_after(&(&a * &by), &(&across * &by), kind);
        let scatter = squares / (kind.freedom - k);
        let ratio = explained / k / scatter;
        let p_value = FisherSnedecor::new(k, kind.freedom - k).ok()?.sf(ratio);
        let fitted = left * &by;
        let size: f64 = self.numbers.iter().zip(fitted.iter()).map(|(&i, v)| (v * noise[i]).powi(2)).sum();
        let values = by.iter().enumerate().map(|(j, v)| (*v, (scatter * inverse[(j, j)]).sqrt()));
        Some(Tested {
            p_value,
            ratio,
            scatter,
            share: explained / residual.norm_squared().max(f64::MIN_POSITIVE),
            size: (size / self.numbers.len().max(1) as f64).sqrt(),
            values: values.collect(),
            numbers: self.numbers.clone(),
            columns: a,
        })
    }

    /// A test of what holds throughout, where the numbers of a standstill share a displacement: F over the mean of the eigenvalues by which standstills
    /// scatter more than independent numbers would, after what is tested (Rao and Scott 1981, first order).
    pub(super) fn throughout(&self, a: DMatrix<f64>, kind: &Left) -> Option<Tested> {
        let mut tested = self.test(a, kind)?;
        let Some(shared) = self.design.shared else { return Some(tested) };
        let (a, k) = (&tested.columns, tested.columns.ncols());
        let across = &self.design.covariance * self.x.tr_mul(a);
        let left = a - &self.x * &across;
        let by = DVector::from_iterator(k, tested.values.iter().map(|value| value.0));
        let after = self.design.residual.select_rows(&self.numbers) - &left * by;
        let mut scores: BTreeMap<usize, DVector<f64>> = BTreeMap::new();
        for (at, &i) in self.numbers.iter().enumerate() {
            let score = scores.entry(self.design.visit[i]).or_insert_with(|| DVector::zeros(k));
            score.axpy(after[at], &left.row(at).transpose(), 1.0);
        }
        let freedom = shared.freedom - k as f64;
        let inverse = a.tr_mul(&left).cholesky()?.inverse();
        let squares: f64 = scores.values().map(|score| score.dot(&(&inverse * score))).sum();
        let scatter = tested.scatter * k as f64;
        let more = (squares / scatter * shared.directions / freedom).max(1.0);
        tested.ratio /= more;
        tested.p_value =
            if freedom > 0.0 { FisherSnedecor::new(k as f64, freedom).ok()?.sf(tested.ratio) } else { 1.0 };
        tested.values.iter_mut().for_each(|value| value.1 *= more.sqrt());
        Some(tested)
    }

    /// Squares of the numbers of a kind beside what is tested. What it explains is not taken from them: a fault pulls the whole fit along, and what
    /// it explains of other kinds and of the prior can be more than all that they have.
    fn squares_after(&self, own: &DVector<f64>, pulled: &DVector<f64>, kind: &Left) -> f64 {
        let after = |&i: &usize| {
            let moved = self.numbers.binary_search(&i).map_or(0.0, |at| own[at]);
            self.design.residual[i] - moved + self.design.x.row(i).tr_dot(pulled)
        };
        kind.numbers.iter().map(|i| after(i).powi(2)).sum::<f64>().max(f64::MIN_POSITIVE)
    }
}

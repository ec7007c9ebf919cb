//! What an error at a site does, visit by visit: the columns of every candidate are put together from it.
//!
//! | symbol | here | shape |
//! | --- | --- | --- |
//! | J̃ | `jacobian`: whitened error Jacobian | m × sites |
//! | M = J̃ᵀ J̃ of a visit | `squares` | sites × sites |
//! | c = J̃ᵀ r̃ of a visit | `scores` | sites |
//!
//! With a candidate's Φ of each visit: `X̃ = J̃ Φ`, `X_uᵀ r̃ = Σ_{v in u} Φᵀ c`, and for functions φ of the visit at one site
//! `XᵀX = Σ φᵀ M φ`. A visit is one standstill of the robot: Φ is taken at its first row, though its targets were measured some seconds
//! apart. The contest, which decides, takes every row for itself.
//!
//! Scores and squares are ordered by site, then by visit: a candidate asks for few sites, visit after visit.

use crate::problem::evaluated::Entry;
use crate::problem::linearisation::Linearisation;
use crate::problem::whitening::Whitener;
use crate::statistics::product::{cross, gram_matrix};
use nalgebra::{DMatrix, DVector, Dyn, Matrix, Storage};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// Tables of all visits that have data.
#[derive(Debug)]
pub(crate) struct Tables {
    sites: usize,
    /// The first station of each visit.
    pub stations: Vec<usize>,
    /// J̃ of all visits.
    jacobian: Arc<DMatrix<f64>>,
    /// The numbers of each visit.
    observations: Vec<Range<usize>>,
    /// Once they are asked for.
    squares: Arc<OnceLock<Vec<f64>>>,
    scores: Vec<f64>,
}

impl Tables {
    pub fn new(linearisation: &Linearisation<'_>, whitener: &Whitener, residual: &DVector<f64>) -> Self {
        let sites = linearisation.site_count();
        let mut jacobian =
            DMatrix::from_fn(linearisation.len(), sites, |at, site| linearisation.sites(at)[site]);
        whitener.apply(&mut jacobian);
        let (mut stations, mut observations) = (Vec::new(), Vec::new());
        let mut station = 0;
        for visit in linearisation.stations().chunk_by(|a, b| a.visit == b.visit) {
            observations.push(visit[0].observations.start..visit[visit.len() - 1].observations.end);
            stations.push(station);
            station += visit.len();
        }
        let scores = scores(&jacobian, residual, &observations);
        let (jacobian, squares) = (Arc::new(jacobian), Arc::new(OnceLock::new()));
        Tables { sites, stations, jacobian, observations, squares, scores }
    }

    /// With further columns of Q_1, which leave this of r̃.
    pub fn with(&self, residual: &DVector<f64>) -> Self {
        Tables {
            sites: self.sites,
            stations: self.stations.clone(),
            jacobian: Arc::clone(&self.jacobian),
            observations: self.observations.clone(),
            squares: Arc::clone(&self.squares),
            scores: scores(&self.jacobian, residual, &self.observations),
        }
    }

    /// c of a visit at a site.
    pub fn score(&self, visit: usize, site: usize) -> f64 {
        self.scores[site * self.observations.len() + visit]
    }

    /// M between two sites, visit by visit.
    fn squares(&self, a: usize, b: usize) -> &[f64] {
        let squares = self.squares.get_or_init(|| squares(&self.jacobian, &self.observations));
        let visits = self.observations.len();
        &squares[(a * self.sites + b) * visits..][..visits]
    }

    /// Adds to whitened columns (m × k) what a visit's entries say.
    pub fn put(&self, visit: usize, entries: &[Entry], columns: &mut DMatrix<f64>) {
        let own = self.observations[visit].clone();
        for &(column, site, value) in entries {
            let sees = self.jacobian.column(site);
            let mut column = columns.column_mut(column);
            own.clone().for_each(|at| column[at] += value * sees[at]);
        }
    }

    /// XᵀX of functions of the visit (visits × k) at each of these sites times a factor, site by site.
    pub fn products(&self, sites: &[(usize, f64)], functions: &DMatrix<f64>) -> DMatrix<f64> {
        let k = functions.ncols();
        let mut products = DMatrix::zeros(sites.len() * k, sites.len() * k);
        for (a, &(first, factor)) in sites.iter().enumerate() {
            for (b, &(second, other)) in sites.iter().enumerate().skip(a) {
                let weighed = weighed(functions.clone(), self.squares(first, second));
                let block = cross(functions, &weighed) * (factor * other);
                products.view_mut((a * k, b * k), (k, k)).copy_from(&block);
                products.view_mut((b * k, a * k), (k, k)).copy_from(&block);
            }
        }
        products
    }

    /// What one function of the visit does that acts at these sites (site, share), with Q_1 projected out.
    pub fn unit_response(&self, q: &DMatrix<f64>, shares: &[(usize, f64)]) -> UnitResponse {
        let visits = self.stations.len();
        let mut pulse = DVector::zeros(q.nrows());
        shares.iter().for_each(|&(site, share)| pulse.axpy(share, &self.jacobian.column(site), 1.0));
        let mut along = DMatrix::zeros(visits, q.ncols());
        for (mut along, column) in along.column_iter_mut().zip(q.column_iter()) {
            for (sum, own) in along.iter_mut().zip(&self.observations) {
                *sum = own.clone().map(|at| pulse[at] * column[at]).sum();
            }
        }
        let score = |visit: usize| shares.iter().map(|&(site, share)| share * self.score(visit, site)).sum();
        let square = |own: &Range<usize>| own.clone().map(|at| pulse[at] * pulse[at]).sum();
        UnitResponse {
            along: along.transpose(),
            score: (0..visits).map(score).collect(),
            square: self.observations.iter().map(square).collect(),
        }
    }

    /// J̃ᵀz of every visit for each of several z (m × n), site by site: visits × n.
    pub fn at_sites(&self, z: &DMatrix<f32>) -> Vec<DMatrix<f32>> {
        let (m, visits) = (z.nrows(), self.observations.len());
        let at = |site: usize| {
            let sees: Vec<f32> = self.jacobian.column(site).iter().map(|&v| v as f32).collect();
            let mut products = DMatrix::zeros(visits, z.ncols());
            let columns = products.as_mut_slice().chunks_exact_mut(visits.max(1));
            for (products, z) in columns.zip(z.as_slice().chunks_exact(m.max(1))) {
                for (sum, own) in products.iter_mut().zip(&self.observations) {
                    *sum = sees[own.clone()].iter().zip(&z[own.clone()]).map(|(a, b)| a * b).sum();
                }
            }
            products
        };
        (0..self.sites).into_par_iter().map(at).collect()
    }
}

/// Columns with each row times its weight.
fn weighed(mut columns: DMatrix<f64>, weights: &[f64]) -> DMatrix<f64> {
    for column in columns.as_mut_slice().chunks_exact_mut(weights.len().max(1)) {
        column.iter_mut().zip(weights).for_each(|(value, weight)| *value *= weight);
    }
    columns
}

/// c of every visit.
fn scores(jacobian: &DMatrix<f64>, residual: &DVector<f64>, observations: &[Range<usize>]) -> Vec<f64> {
    let mut scores = Vec::with_capacity(jacobian.ncols() * observations.len());
    for column in jacobian.column_iter() {
        let of_visit =
            |own: &Range<usize>| column.rows(own.start, own.len()).dot(&residual.rows(own.start, own.len()));
        scores.extend(observations.iter().map(of_visit));
    }
    scores
}

/// M of every visit.
fn squares(jacobian: &DMatrix<f64>, observations: &[Range<usize>]) -> Vec<f64> {
    let (sites, visits) = (jacobian.ncols(), observations.len());
    let mut squares = vec![0.0; sites * sites * visits];
    for (visit, own) in observations.iter().enumerate() {
        let sees = jacobian.rows(own.start, own.len());
        for (pair, square) in sees.tr_mul(&sees).iter().enumerate() {
            squares[pair * visits + visit] = *square;
        }
    }
    squares
}

/// What a function of the visit that acts at fixed sites does, per unit of it.
#[derive(Debug)]
pub(crate) struct UnitResponse {
    /// Q_1ᵀ of each visit's pulse, r × visits.
    along: DMatrix<f64>,
    /// Its product with r̃.
    score: Vec<f64>,
    /// Its squared length.
    pub square: Vec<f64>,
}

impl UnitResponse {
    /// XᵀX of functions of the visit, visits × k.
    pub fn products<S: Storage<f64, Dyn, Dyn>>(&self, columns: &Matrix<f64, Dyn, Dyn, S>) -> DMatrix<f64> {
        let roots: Vec<f64> = self.square.iter().map(|square| square.sqrt()).collect();
        gram_matrix(&weighed(columns.clone_owned(), &roots))
    }

    /// XᵀX of a sine and a cosine of the same angles, visits × 2.
    pub fn of_wave<S: Storage<f64, Dyn, Dyn>>(&self, wave: &Matrix<f64, Dyn, Dyn, S>) -> DMatrix<f64> {
        let (mut sines, mut mixed) = (0.0, 0.0);
        for ((sine, cosine), square) in wave.column(0).iter().zip(wave.column(1).iter()).zip(&self.square) {
            let weighed = square * sine;
            sines += weighed * sine;
            mixed += weighed * cosine;
        }
        let cosines = self.square.iter().sum::<f64>() - sines;
        DMatrix::from_row_slice(2, 2, &[sines, mixed, mixed, cosines])
    }

    /// Q_1ᵀX and Xᵀr̃ of functions of the visit, visits × k.
    pub fn through(&self, columns: &DMatrix<f64>) -> (DMatrix<f64>, DVector<f64>) {
        let score = DVector::from_column_slice(&self.score);
        (&self.along * columns, columns.tr_mul(&score))
    }
}

/// What is needed of a candidate's columns X, m × k.
#[derive(Debug, Clone)]
pub(crate) struct Sums {
    /// Q_1ᵀ X, r × k.
    pub along: DMatrix<f64>,
    /// XᵀX, k × k.
    pub raw: DMatrix<f64>,
    /// Xᵀr̃, k.
    pub score: DVector<f64>,
}

impl Sums {
    /// Adds those of other visits.
    pub fn merge(&mut self, other: &Sums) {
        self.along += &other.along;
        self.raw += &other.raw;
        self.score += &other.score;
    }
}

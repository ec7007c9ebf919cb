//! The data compressed, visit by visit, to what an error at a site does there: a candidate then costs a few look-ups a visit, not a product
//! over all measured numbers.
//!
//! | symbol | here | shape |
//! | --- | --- | --- |
//! | J̃ | whitened error Jacobian of a visit | numbers × sites |
//! | H = Q_1ᵀ J̃ | `along` | r × sites |
//! | M = J̃ᵀ J̃ | `squares` | sites × sites |
//! | c = J̃ᵀ r̃ | `scores` | sites |
//!
//! With a candidate's Φ of each visit: `Q_1ᵀX = Σ H Φ`, `XᵀX = Σ Φᵀ M Φ`, `X_uᵀ r̃ = Σ_{v in u} Φᵀ c`. A visit is one standstill of the
//! robot: Φ is taken at its first row, though its targets were measured some seconds apart. The contest, which decides, takes
//! every row for itself.

use crate::problem::linearisation::Scene;
use crate::problem::whitening::Whitener;
use crate::statistics::product::cross;
use nalgebra::{DMatrix, DVector, Dyn, Matrix, Storage};
use std::ops::Range;
use std::sync::Arc;

/// Tables of all visits that have data.
#[derive(Debug)]
pub(crate) struct Tables {
    sites: usize,
    rank: usize,
    /// The first station of each visit.
    pub stations: Vec<usize>,
    /// The exchangeable unit of each visit.
    unit: Vec<usize>,
    /// J̃ of all visits.
    jacobian: Arc<DMatrix<f64>>,
    /// The numbers of each visit.
    numbers: Vec<Range<usize>>,
    /// H, in bands of its rows.
    along: Vec<Arc<Band>>,
    squares: Arc<Vec<f64>>,
    scores: Vec<f64>,
}

impl Tables {
    pub fn new(
        scene: &Scene<'_>,
        whitener: &Whitener,
        (q, residual): (&DMatrix<f64>, &DVector<f64>),
        unit: &[usize],
    ) -> Self {
        let (sites, rank) = (scene.site_count(), q.ncols());
        let mut jacobian = DMatrix::from_fn(scene.len(), sites, |at, site| scene.sites(at)[site]);
        whitener.apply(&mut jacobian);
        let (mut stations, mut numbers) = (Vec::new(), Vec::new());
        let (mut along, mut squares) = (Vec::new(), Vec::new());
        let mut station = 0;
        for visit in scene.stations().chunk_by(|a, b| a.visit == b.visit) {
            let own = visit[0].numbers.start..visit[visit.len() - 1].numbers.end;
            let sees = jacobian.rows(own.start, own.len());
            along.extend_from_slice(cross(&q.rows(own.start, own.len()), &sees).as_slice());
            squares.extend_from_slice(cross(&sees, &sees).as_slice());
            stations.push(station);
            numbers.push(own);
            station += visit.len();
        }
        let unit = numbers.iter().map(|own| unit[own.start]).collect();
        let scores = scores(&jacobian, residual, &numbers);
        Tables {
            sites,
            rank,
            stations,
            unit,
            jacobian: Arc::new(jacobian),
            numbers,
            along: vec![Arc::new(Band { sites, rank, along })],
            squares: Arc::new(squares),
            scores,
        }
    }

    /// With further columns of Q_1 (m × k), which leave this of r̃.
    pub fn with(&self, new: &DMatrix<f64>, residual: &DVector<f64>) -> Self {
        let mut along = self.along.clone();
        along.push(Arc::new(self.band(new)));
        Tables {
            sites: self.sites,
            rank: self.rank + new.ncols(),
            stations: self.stations.clone(),
            unit: self.unit.clone(),
            jacobian: Arc::clone(&self.jacobian),
            numbers: self.numbers.clone(),
            along,
            squares: Arc::clone(&self.squares),
            scores: scores(&self.jacobian, residual, &self.numbers),
        }
    }

    /// M between two sites of a visit.
    fn square(&self, visit: usize, a: usize, b: usize) -> f64 {
        self.squares[(visit * self.sites + a) * self.sites + b]
    }

    /// H of further columns of Q_1 (m × k): what [`Tables::with`] appends.
    pub fn band(&self, new: &DMatrix<f64>) -> Band {
        let mut along = Vec::with_capacity(self.numbers.len() * self.sites * new.ncols());
        for own in &self.numbers {
            let sees = self.jacobian.rows(own.start, own.len());
            along.extend_from_slice(cross(&new.rows(own.start, own.len()), &sees).as_slice());
        }
        Band { sites: self.sites, rank: new.ncols(), along }
    }

    /// Adds what a visit's entries (column, site, value) say.
    pub fn add(&self, visit: usize, entries: &[(usize, usize, f64)], sums: &mut Sums) {
        let scores = &self.scores[visit * self.sites..(visit + 1) * self.sites];
        for (k, &(column, site, value)) in entries.iter().enumerate() {
            let mut along = &mut sums.along.as_mut_slice()[column * self.rank..(column + 1) * self.rank];
            for band in &self.along {
                let (own, rest) = along.split_at_mut(band.rank);
                own.iter_mut().zip(band.at(visit, site)).for_each(|(sum, h)| *sum += value * h);
                along = rest;
            }
            sums.by_unit[(self.unit[visit], column)] += value * scores[site];
            sums.raw[(column, column)] += value * value * self.square(visit, site, site);
            for &(other, there, further) in &entries[k + 1..] {
                let both = value * further * self.square(visit, site, there);
                sums.raw[(column, other)] += both;
                sums.raw[(other, column)] += both;
            }
        }
    }

    /// XᵀX of functions of the visit (visits × k) at each of these sites, site by site.
    pub fn products(&self, sites: &[usize], functions: &DMatrix<f64>) -> DMatrix<f64> {
        let (visits, k) = functions.shape();
        let mut products = DMatrix::zeros(sites.len() * k, sites.len() * k);
        for (a, &first) in sites.iter().enumerate() {
            for (b, &second) in sites.iter().enumerate().skip(a) {
                let weights = DVector::from_fn(visits, |visit, _| self.square(visit, first, second));
                let mut weighed = functions.clone();
                weighed.column_iter_mut().for_each(|mut column| column.component_mul_assign(&weights));
                let block = cross(functions, &weighed);
                products.view_mut((a * k, b * k), (k, k)).copy_from(&block);
                products.view_mut((b * k, a * k), (k, k)).copy_from(&block);
            }
        }
        products
    }

    /// What one function of the visit does that acts at these sites (site, share).
    pub fn pulses(&self, shares: &[(usize, f64)]) -> Pulses<'_> {
        let visits = self.stations.len();
        let mut along = vec![0.0; visits * self.rank];
        let mut pulses = Pulses {
            unit: &self.unit,
            along: DMatrix::zeros(0, 0),
            score: vec![0.0; visits],
            square: vec![0.0; visits],
        };
        for visit in 0..visits {
            for &(site, share) in shares {
                let h = self.along.iter().flat_map(|band| band.at(visit, site));
                for (sum, h) in along[visit * self.rank..(visit + 1) * self.rank].iter_mut().zip(h) {
                    *sum += share * h;
                }
                pulses.score[visit] += share * self.scores[visit * self.sites + site];
                pulses.square[visit] += shares
                    .iter()
                    .map(|&(other, more)| share * more * self.square(visit, site, other))
                    .sum::<f64>();
            }
        }
        pulses.along = DMatrix::from_vec(self.rank, visits, along);
        pulses
    }
}

/// H of some columns of Q_1.
#[derive(Debug)]
pub(crate) struct Band {
    sites: usize,
    rank: usize,
    along: Vec<f64>,
}

impl Band {
    /// Of one site of a visit.
    fn at(&self, visit: usize, site: usize) -> &[f64] {
        let first = (visit * self.sites + site) * self.rank;
        &self.along[first..first + self.rank]
    }

    /// The product of these columns with a candidate's, k × width, from its entries (visit, column, site, value).
    pub fn along(&self, said: &[(usize, usize, usize, f64)], width: usize) -> DMatrix<f64> {
        let mut along = DMatrix::zeros(self.rank, width);
        for &(visit, column, site, value) in said {
            let own = &mut along.as_mut_slice()[column * self.rank..(column + 1) * self.rank];
            own.iter_mut().zip(self.at(visit, site)).for_each(|(sum, h)| *sum += value * h);
        }
        along
    }
}

/// c of every visit.
fn scores(jacobian: &DMatrix<f64>, residual: &DVector<f64>, numbers: &[Range<usize>]) -> Vec<f64> {
    let sites = jacobian.ncols();
    let mut scores = vec![0.0; numbers.len() * sites];
    for (own, scores) in numbers.iter().zip(scores.chunks_exact_mut(sites)) {
        let left = residual.rows(own.start, own.len());
        for (site, score) in scores.iter_mut().enumerate() {
            *score = jacobian.column(site).rows(own.start, own.len()).dot(&left);
        }
    }
    scores
}

/// What a function of the visit that acts at fixed sites does, per unit of it.
#[derive(Debug)]
pub(crate) struct Pulses<'t> {
    /// The exchangeable unit of each visit.
    unit: &'t [usize],
    /// Q_1ᵀ of each visit's pulse, r × visits.
    along: DMatrix<f64>,
    /// Its product with r̃.
    score: Vec<f64>,
    /// Its squared length.
    pub square: Vec<f64>,
}

impl Pulses<'_> {
    /// XᵀX of functions of the visit, visits × k.
    pub fn products<S: Storage<f64, Dyn, Dyn>>(&self, columns: &Matrix<f64, Dyn, Dyn, S>) -> DMatrix<f64> {
        let k = columns.ncols();
        let mut products = DMatrix::zeros(k, k);
        let mut weighed = vec![0.0; self.square.len()];
        for (i, a) in columns.column_iter().enumerate() {
            for ((weighed, a), square) in weighed.iter_mut().zip(a.iter()).zip(&self.square) {
                *weighed = a * square;
            }
            for (j, b) in columns.column_iter().enumerate().skip(i) {
                let sum: f64 = weighed.iter().zip(b.iter()).map(|(a, b)| a * b).sum();
                products[(i, j)] = sum;
                products[(j, i)] = sum;
            }
        }
        products
    }

    /// Q_1ᵀX and X̃ ∘ r̃ summed over each unit, of functions of the visit, visits × k.
    pub fn through(&self, columns: &DMatrix<f64>, q_by_unit: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
        let along = &self.along * columns;
        let mut by_unit = q_by_unit * &along;
        by_unit.neg_mut();
        for (mut sums, column) in by_unit.column_iter_mut().zip(columns.column_iter()) {
            for ((&unit, value), score) in self.unit.iter().zip(column.iter()).zip(&self.score) {
                sums[unit] += value * score;
            }
        }
        (along, by_unit)
    }
}

/// What is needed of a candidate's columns X, m × k.
#[derive(Debug, Clone)]
pub(crate) struct Sums {
    /// Q_1ᵀ X, r × k.
    pub along: DMatrix<f64>,
    /// XᵀX, k × k.
    pub raw: DMatrix<f64>,
    /// X ∘ r̃ summed over each unit, units × k.
    pub by_unit: DMatrix<f64>,
}

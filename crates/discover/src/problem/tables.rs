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
//!
//! Tables are ordered by site, then by visit: a candidate asks for few sites, visit after visit.

use crate::problem::linearisation::Linearisation;
use crate::problem::whitening::Whitener;
use crate::statistics::product::cross;
use nalgebra::{DMatrix, DVector, Dyn, Matrix, Storage};
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// Tables of all visits that have data.
#[derive(Debug)]
pub(crate) struct Tables {
    sites: usize,
    rank: usize,
    /// The first station of each visit.
    pub stations: Vec<usize>,
    /// J̃ of all visits.
    jacobian: Arc<DMatrix<f64>>,
    /// The numbers of each visit.
    observations: Vec<Range<usize>>,
    /// H, in bands of its rows.
    along: Vec<Arc<ProjectedSites>>,
    /// Once they are asked for.
    squares: Arc<OnceLock<Vec<f64>>>,
    scores: Vec<f64>,
}

impl Tables {
    pub fn new(
        linearisation: &Linearisation<'_>,
        whitener: &Whitener,
        (q, residual): (&DMatrix<f64>, &DVector<f64>),
    ) -> Self {
        let (sites, rank) = (linearisation.site_count(), q.ncols());
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
        let along = ProjectedSites::new(q, &jacobian, &observations);
        Tables {
            sites,
            rank,
            stations,
            squares: Arc::new(OnceLock::new()),
            jacobian: Arc::new(jacobian),
            observations,
            along: vec![Arc::new(along)],
            scores,
        }
    }

    /// With further columns of Q_1 (m × k), which leave this of r̃.
    pub fn with(&self, new: &DMatrix<f64>, residual: &DVector<f64>) -> Self {
        let mut along = self.along.clone();
        along.push(Arc::new(self.projected_sites(new)));
        Tables {
            sites: self.sites,
            rank: self.rank + new.ncols(),
            stations: self.stations.clone(),
            jacobian: Arc::clone(&self.jacobian),
            observations: self.observations.clone(),
            along,
            squares: Arc::clone(&self.squares),
            scores: scores(&self.jacobian, residual, &self.observations),
        }
    }

    /// c of a visit at a site.
    pub fn score(&self, visit: usize, site: usize) -> f64 {
        self.scores[site * self.observations.len() + visit]
    }

    /// M between two sites of a visit.
    fn square(&self, visit: usize, a: usize, b: usize) -> f64 {
        let squares = self.squares.get_or_init(|| squares(&self.jacobian, &self.observations));
        squares[(a * self.sites + b) * self.observations.len() + visit]
    }

    /// H of further columns of Q_1 (m × k): what [`Tables::with`] appends.
    pub fn projected_sites(&self, new: &DMatrix<f64>) -> ProjectedSites {
        ProjectedSites::new(new, &self.jacobian, &self.observations)
    }

    /// Adds what a visit's entries (column, site, value) say.
    pub fn add(&self, visit: usize, entries: &[(usize, usize, f64)], sums: &mut Sums) {
        for (k, &(column, site, value)) in entries.iter().enumerate() {
            let mut along = &mut sums.along.as_mut_slice()[column * self.rank..(column + 1) * self.rank];
            for projected in &self.along {
                let (own, rest) = along.split_at_mut(projected.rank);
                own.iter_mut().zip(projected.at(visit, site)).for_each(|(sum, h)| *sum += value * h);
                along = rest;
            }
            sums.score[column] += value * self.score(visit, site);
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
    pub fn unit_response(&self, shares: &[(usize, f64)]) -> UnitResponse {
        let visits = self.stations.len();
        let mut along = vec![0.0; visits * self.rank];
        let mut response =
            UnitResponse { along: DMatrix::zeros(0, 0), score: vec![0.0; visits], square: vec![0.0; visits] };
        for visit in 0..visits {
            for &(site, share) in shares {
                let h = self.along.iter().flat_map(|projected| projected.at(visit, site));
                for (sum, h) in along[visit * self.rank..(visit + 1) * self.rank].iter_mut().zip(h) {
                    *sum += share * h;
                }
                response.score[visit] += share * self.score(visit, site);
                response.square[visit] += shares
                    .iter()
                    .map(|&(other, more)| share * more * self.square(visit, site, other))
                    .sum::<f64>();
            }
        }
        response.along = DMatrix::from_vec(self.rank, visits, along);
        response
    }
}

/// H of some columns of Q_1.
#[derive(Debug)]
pub(crate) struct ProjectedSites {
    visits: usize,
    rank: usize,
    along: Vec<f64>,
}

impl ProjectedSites {
    /// Of columns of Q_1 (m × k).
    fn new(columns: &DMatrix<f64>, jacobian: &DMatrix<f64>, observations: &[Range<usize>]) -> Self {
        let (visits, rank, sites) = (observations.len(), columns.ncols(), jacobian.ncols());
        let mut along = vec![0.0; sites * visits * rank];
        if rank > 0 {
            for (visit, own) in observations.iter().enumerate() {
                let sees = jacobian.rows(own.start, own.len());
                let of_visit = cross(&columns.rows(own.start, own.len()), &sees);
                for (site, of_site) in of_visit.as_slice().chunks_exact(rank).enumerate() {
                    let first = (site * visits + visit) * rank;
                    along[first..first + rank].copy_from_slice(of_site);
                }
            }
        }
        ProjectedSites { visits, rank, along }
    }

    /// Of one site of a visit.
    fn at(&self, visit: usize, site: usize) -> &[f64] {
        let first = (site * self.visits + visit) * self.rank;
        &self.along[first..first + self.rank]
    }

    /// The product of these columns with a candidate's, k × width, from its entries (visit, column, site, value).
    pub fn along(&self, emitted: &[(usize, usize, usize, f64)], width: usize) -> DMatrix<f64> {
        let mut along = DMatrix::zeros(self.rank, width);
        for &(visit, column, site, value) in emitted {
            let own = &mut along.as_mut_slice()[column * self.rank..(column + 1) * self.rank];
            own.iter_mut().zip(self.at(visit, site)).for_each(|(sum, h)| *sum += value * h);
        }
        along
    }
}

impl Tables {
    /// J̃ᵀz of every visit for each of several z (m × n), site by site: visits × n.
    pub fn at_sites(&self, z: &DMatrix<f32>) -> Vec<DMatrix<f32>> {
        let jacobian = self.jacobian.map(|v| v as f32);
        let mut sites = vec![DMatrix::zeros(self.observations.len(), z.ncols()); self.sites];
        for (visit, own) in self.observations.iter().enumerate() {
            let seen = jacobian.rows(own.start, own.len()).tr_mul(&z.rows(own.start, own.len()));
            for (site, row) in seen.row_iter().enumerate() {
                sites[site].set_row(visit, &row);
            }
        }
        sites
    }

    /// Whitened columns of a candidate's entries (visit, column, site, value), m × width.
    pub fn whitened(&self, entries: &[(usize, usize, usize, f64)], width: usize) -> DMatrix<f32> {
        let mut columns = DMatrix::<f64>::zeros(self.jacobian.nrows(), width);
        for &(visit, column, site, value) in entries {
            for at in self.observations[visit].clone() {
                columns[(at, column)] += value * self.jacobian[(at, site)];
            }
        }
        columns.map(|v| v as f32)
    }
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
        for (pair, square) in cross(&sees, &sees).iter().enumerate() {
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
    /// Of no visit: r columns of the model, k of the candidate.
    pub fn zeros(r: usize, k: usize) -> Self {
        Sums { along: DMatrix::zeros(r, k), raw: DMatrix::zeros(k, k), score: DVector::zeros(k) }
    }

    /// Adds those of other visits.
    pub fn merge(&mut self, other: &Sums) {
        self.along += &other.along;
        self.raw += &other.raw;
        self.score += &other.score;
    }
}

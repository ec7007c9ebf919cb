//! The numbers of a block, whitened, one after the other and visit by visit: what the model's coefficients and an error at each site do to them, and
//! what is left.

use crate::census::all_rows::AllRows;
use crate::census::blocks::Blocks;
use crate::error::DiscoverError;
use crate::options::DiscoverOptions;
use nalgebra::{DMatrix, DMatrixView, DVector};
use std::ops::Range;
use truepose_errormodel::effects::Geometric;
use truepose_errormodel::{Dataset, ErrorModel, Visits};
use truepose_identify::engine::{ByVisits, by_visits};

/// Numbers of whole visits.
pub(crate) struct Seen {
    /// r unknowns that the data determines.
    pub rank: usize,
    pub sites: usize,
    /// `[A | J̃ | r]` of every number, (r + sites + 1) × m.
    numbers: DMatrix<f64>,
    /// The numbers of each visit that has any.
    pub visits: Vec<Range<usize>>,
    /// The first row of each.
    pub rows: Vec<usize>,
}

impl Seen {
    /// Linearised where the coefficients of all rows were found, with what these leave.
    pub fn of(
        (block, blocks): (&Dataset, &Blocks),
        all: &AllRows,
        options: &DiscoverOptions,
    ) -> Result<Self, DiscoverError> {
        let visits = Visits::of(block);
        let first: Vec<Option<usize>> = visits.rows.iter().map(|rows| rows.first().copied()).collect();
        let (rank, sites) = (all.inverse.nrows(), all.at.fitted.chain().site_count());
        let ByVisits { numbers, visits } = match blocks.joints_scatter() {
            true => together((block, blocks), all, options)?,
            false => {
                let mut seen = in_blocks((block, blocks), all, &visits)?;
                let [at, of] = [&all.at, &all.fit].map(|fit| fit.fitted.coefficients());
                let kept = &all.at.reduction.kept;
                let moved = DVector::from_iterator(rank, kept.iter().map(|&column| of[column] - at[column]));
                for mut number in seen.numbers.column_iter_mut() {
                    number[rank + sites] -= number.rows(0, rank).dot(&moved);
                }
                seen
            }
        };
        let seen = visits.into_iter().zip(first).filter(|(numbers, _)| !numbers.is_empty());
        let (visits, rows) = seen.filter_map(|(numbers, first)| Some((numbers, first?))).unzip();
        Ok(Seen { rank, sites, numbers, visits, rows })
    }

    /// What the model's coefficients do to a number.
    pub fn base(&self, number: usize) -> &[f64] {
        &self.all(number)[..self.rank]
    }

    /// What a unit error at each site does to a number.
    pub fn site(&self, number: usize) -> &[f64] {
        &self.all(number)[self.rank..self.rank + self.sites]
    }

    /// What is left of a number.
    pub fn residual(&self, number: usize) -> f64 {
        self.all(number)[self.rank + self.sites]
    }

    /// The numbers of successive visits.
    pub fn numbers_of(&self, visits: Range<usize>) -> Range<usize> {
        match self.visits.get(visits) {
            Some([first, .., last]) => first.start..last.end,
            Some([one]) => one.clone(),
            _ => 0..0,
        }
    }

    /// What the model's coefficients do to some numbers, r × numbers.
    pub fn bases(&self, numbers: Range<usize>) -> DMatrixView<'_, f64> {
        self.numbers.view((0, numbers.start), (self.rank, numbers.len()))
    }

    /// What is left of some numbers.
    pub fn residuals(&self, numbers: Range<usize>) -> DVector<f64> {
        DVector::from_iterator(numbers.len(), numbers.map(|number| self.residual(number)))
    }

    fn all(&self, number: usize) -> &[f64] {
        let height = self.numbers.nrows();
        &self.numbers.as_slice()[number * height..(number + 1) * height]
    }

    /// J̃ᵀr of every visit, visits × sites.
    pub fn scores(&self) -> DMatrix<f64> {
        let mut scores = DMatrix::zeros(self.sites, self.visits.len());
        for (mut score, numbers) in scores.column_iter_mut().zip(&self.visits) {
            for number in numbers.clone() {
                let residual = self.residual(number);
                score.iter_mut().zip(self.site(number)).for_each(|(score, seen)| *score += seen * residual);
            }
        }
        scores.transpose()
    }
}

/// In blocks of rows, as they are fitted.
fn in_blocks(
    (block, blocks): (&Dataset, &Blocks),
    all: &AllRows,
    visits: &Visits,
) -> Result<ByVisits, DiscoverError> {
    let model = all.at.fitted.model();
    let known = model.columns().len();
    let mut effects = model.effects().to_vec();
    effects.push(Box::new(Geometric::default()));
    let beside = ErrorModel::new(model.shared_chain(), effects)?;
    let mut coefficients = all.at.fitted.coefficients().to_vec();
    coefficients.resize(beside.columns().len(), 0.0);
    let mut wanted = all.at.reduction.kept.clone();
    // A constant error of every site, in their order.
    wanted.extend(known..beside.columns().len());
    let noise = blocks.noise_of(&all.at).rows;
    Ok(by_visits(&beside, block, visits, noise, &coefficients, &wanted)?)
}

/// Where the joints scatter: the numbers of a pose are whitened together.
fn together(
    (block, blocks): (&Dataset, &Blocks),
    all: &AllRows,
    options: &DiscoverOptions,
) -> Result<ByVisits, DiscoverError> {
    let linearisation = blocks.linearised(&all.at, block, options)?;
    let whitener = linearisation.whitener(linearisation.noise);
    let (count, sites) = (linearisation.len(), linearisation.site_count());
    let (rank, residual) = (linearisation.base.ncols(), all.residual_of(&linearisation, &whitener));
    let base = whitener.of(&linearisation.base);
    let seen = whitener.of(&DMatrix::from_fn(count, sites, |at, site| linearisation.sites(at)[site]));
    let numbers = DMatrix::from_fn(rank + sites + 1, count, |k, at| match k.checked_sub(rank) {
        None => base[(at, k)],
        Some(site) if site < sites => seen[(at, site)],
        Some(_) => residual[at],
    });
    let mut visits = vec![0..0; linearisation.visits];
    for stations in linearisation.stations().chunk_by(|a, b| a.visit == b.visit) {
        let ends = [stations[0].observations.start, stations[stations.len() - 1].observations.end];
        visits[stations[0].visit] = ends[0]..ends[1];
    }
    Ok(ByVisits { numbers, visits })
}

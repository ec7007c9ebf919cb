//! Sums of candidates over all rows, put together visit by visit.
//!
//! ```text
//! AᵀX = Σ_v (A_vᵀJ̃_v) Φ_v,   XᵀX = Σ_v Φ_vᵀ (J̃_vᵀJ̃_v) Φ_v,   Xᵀr = Σ_v Φ_vᵀ (J̃_vᵀr_v)
//! ```
//!
//! The products in brackets are made once for all candidates of a pass, at the sites that these touch, and no column of a candidate is formed. Only
//! where unknowns act at more sites than a visit has numbers, the columns of a block are formed, which are fewer numbers. Φ is
//! taken at the first row of a visit, as in a screen ([`crate::problem::tables`]); the tests that decide take every row for itself
//! ([`crate::census::proof`]).

use crate::census::all_rows::AllRows;
use crate::census::blocks::Blocks;
use crate::census::seen::Seen;
use crate::census::white::White;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::options::DiscoverOptions;
use crate::problem::emitted::{Block, Emitted, Said};
use crate::problem::tables::Sums;
use crate::statistics::product::gram_matrix;
use nalgebra::{DMatrix, DVector};
use truepose_errormodel::Dataset;

/// XᵀX, AᵀX and Xᵀr of candidates over every `stride`-th block; none of those that the data lacks a covariate for.
pub(crate) fn sums(
    candidates: &[Candidate],
    (all, blocks): (&AllRows, &Blocks),
    stride: usize,
    options: &DiscoverOptions,
) -> Result<Vec<Option<Sums>>, DiscoverError> {
    let mut each = Vec::with_capacity(candidates.len());
    while each.len() < candidates.len() {
        let rest = &candidates[each.len()..];
        let several = &rest[..blocks.at_once(rest)];
        each.extend(of_several(several, (all, blocks), stride, options)?);
    }
    Ok(each)
}

fn of_several(
    candidates: &[Candidate],
    (all, blocks): (&AllRows, &Blocks),
    stride: usize,
    options: &DiscoverOptions,
) -> Result<Vec<Option<Sums>>, DiscoverError> {
    let effects = candidates.iter().flat_map(|candidate| candidate.effects().iter());
    let derived = blocks.derived(&all.fit, effects);
    let first = blocks.first(&derived);
    let rank = all.inverse.nrows();
    let nothing = |candidate: &Candidate| {
        let width = White::width_of(candidate, &all.at, &first)?;
        let (along, raw) = (DMatrix::zeros(rank, width), DMatrix::zeros(width, width));
        Some(Sums { along, raw, score: DVector::zeros(width) })
    };
    let mut whole: Vec<Option<Sums>> = candidates.iter().map(nothing).collect();
    let present: Vec<(&Candidate, Sums)> = candidates
        .iter()
        .zip(&whole)
        .filter_map(|(candidate, sums)| Some((candidate, sums.clone()?)))
        .collect();
    let asked = Emitted::all(&all.at, &present, |(candidate, _)| candidate.effects())?;
    let of = |block: &Dataset| -> Result<Vec<Sums>, DiscoverError> {
        let seen = Seen::of((block, blocks), all, options)?;
        let mut sums: Vec<Sums> = present.iter().map(|(_, nothing)| nothing.clone()).collect();
        let mut rest = sums.as_mut_slice();
        for (part, asked) in &asked {
            let (sums, others) = rest.split_at_mut(part.len());
            rest = others;
            asked.each(block, &seen.rows, &mut |said| add(sums, &said, &seen))?;
        }
        Ok(sums)
    };
    blocks.each(stride, &derived, &of, &mut |_, part| {
        whole.iter_mut().flatten().zip(&part).for_each(|(sum, more)| sum.merge(more));
    })?;
    Ok(whole)
}

/// A candidate's sums, and what its unknowns, of which `first` is the first, say of a block of visits.
struct Part<'s> {
    sums: &'s mut Sums,
    first: usize,
    entries: &'s [Said<'s>],
}

/// Adds what a block of visits says of candidates whose unknowns stand side by side.
fn add(sums: &mut [Sums], block: &Block<'_>, seen: &Seen) {
    let numbers = seen.numbers_of(block.visits.clone());
    let (mut few, mut first, mut rest) = (Vec::new(), 0, block.beside.as_slice());
    for sums in sums {
        let width = sums.score.len();
        let (entries, others) = rest.split_at(rest.partition_point(|said| said.column < first + width));
        let part = Part { sums, first, entries };
        // Products take each pair of entries of a visit, columns each pair of unknowns in each number.
        match entries.len() * block.visits.len() > width * numbers.len() {
            true => part.add_columns(block, seen),
            false => few.push(part),
        }
        (first, rest) = (first + width, others);
    }
    add_products(&mut few, block, seen);
}

impl Part<'_> {
    /// With the columns of the block, numbers × unknowns.
    fn add_columns(self, block: &Block<'_>, seen: &Seen) {
        let numbers = seen.numbers_of(block.visits.clone());
        let mut columns = DMatrix::zeros(numbers.len(), self.sums.score.len());
        for said in self.entries {
            let mut column = columns.column_mut(said.column - self.first);
            for (visit, value) in block.visits.clone().zip(said.values) {
                let value = said.factor * value;
                if value != 0.0 {
                    for number in seen.visits[visit].clone() {
                        column[number - numbers.start] += value * seen.site(number)[said.site];
                    }
                }
            }
        }
        let Sums { along, raw, score } = self.sums;
        along.gemm(1.0, &seen.bases(numbers.clone()), &columns, 1.0);
        *raw += gram_matrix(&columns);
        score.gemv_tr(1.0, &columns, &seen.residuals(numbers), 1.0);
    }
}

/// Adds what a block of visits says by products of single entries.
fn add_products(parts: &mut [Part<'_>], block: &Block<'_>, seen: &Seen) {
    /// Visits whose products stay in a processor's cache.
    const NEAR: usize = 8;
    let mut touched = vec![None; seen.sites];
    let mut sites = Vec::new();
    for said in parts.iter().flat_map(|part| part.entries) {
        touched[said.site].get_or_insert_with(|| {
            sites.push(said.site);
            sites.len() - 1
        });
    }
    let mut products: Vec<Products> = (0..NEAR).map(|_| Products::new(seen, sites.len())).collect();
    let begin = block.visits.start;
    for from in block.visits.clone().step_by(NEAR) {
        let near = from..(from + NEAR).min(block.visits.end);
        for (products, visit) in products.iter_mut().zip(near.clone()) {
            products.fill(seen, visit, &sites);
        }
        for Part { sums, first, entries } in &mut *parts {
            for (products, visit) in products.iter().zip(near.clone()) {
                products.add(sums, (entries, *first), visit - begin, &touched);
            }
        }
    }
}

/// What the numbers of one visit say of an error at each of some sites.
struct Products {
    /// A_vᵀJ̃_v, site after site.
    along: Vec<f64>,
    /// J̃_vᵀJ̃_v, site after site.
    squares: Vec<f64>,
    /// J̃_vᵀr_v.
    scores: Vec<f64>,
}

impl Products {
    fn new(seen: &Seen, sites: usize) -> Self {
        let zeros = |count: usize| vec![0.0; count];
        Products { along: zeros(seen.rank * sites), squares: zeros(sites * sites), scores: zeros(sites) }
    }

    fn fill(&mut self, seen: &Seen, visit: usize, sites: &[usize]) {
        let all = [&mut self.along, &mut self.squares, &mut self.scores];
        all.into_iter().for_each(|numbers| numbers.fill(0.0));
        let mut at_sites = vec![0.0; sites.len()];
        for number in seen.visits[visit].clone() {
            let (base, site, residual) = (seen.base(number), seen.site(number), seen.residual(number));
            at_sites.iter_mut().zip(sites).for_each(|(at, &of)| *at = site[of]);
            for (k, &by) in at_sites.iter().enumerate().filter(|(_, by)| **by != 0.0) {
                let along = &mut self.along[k * base.len()..][..base.len()];
                along.iter_mut().zip(base).for_each(|(sum, base)| *sum += by * base);
                let squares = &mut self.squares[k * sites.len()..][..sites.len()];
                squares.iter_mut().zip(&at_sites).for_each(|(sum, other)| *sum += by * other);
                self.scores[k] += by * residual;
            }
        }
    }

    /// Adds what a candidate's entries, of which `first` is the first unknown, say of the visit at this place of their block.
    fn add(
        &self,
        sums: &mut Sums,
        (entries, first): (&[Said<'_>], usize),
        at: usize,
        touched: &[Option<usize>],
    ) {
        let (rank, count) = (sums.along.nrows(), self.scores.len());
        for (k, said) in entries.iter().enumerate() {
            let (Some(site), value) = (touched[said.site], said.factor * said.values[at]) else { continue };
            if value == 0.0 {
                continue;
            }
            let a = said.column - first;
            sums.score[a] += value * self.scores[site];
            let into = &mut sums.along.as_mut_slice()[a * rank..(a + 1) * rank];
            let along = &self.along[site * rank..(site + 1) * rank];
            into.iter_mut().zip(along).for_each(|(sum, along)| *sum += value * along);
            let squares = &self.squares[site * count..(site + 1) * count];
            sums.raw[(a, a)] += value * value * squares[site];
            for other in &entries[k + 1..] {
                let Some(there) = touched[other.site] else { continue };
                let product = value * other.factor * other.values[at] * squares[there];
                let b = other.column - first;
                sums.raw[(a, b)] += product;
                sums.raw[(b, a)] += product;
            }
        }
    }
}

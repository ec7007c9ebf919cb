//! Sums of candidates over all rows, put together visit by visit.
//!
//! ```text
//! AᵀX = Σ_v (A_vᵀJ̃_v) Φ_v,   XᵀX = Σ_v Φ_vᵀ (J̃_vᵀJ̃_v) Φ_v,   Xᵀr = Σ_v Φ_vᵀ (J̃_vᵀr_v)
//! ```
//!
//! The products in brackets are made once for all candidates of a pass, at the sites that these touch, and no column of a candidate is formed. Φ is
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

/// Adds what a block of visits says of candidates whose unknowns stand side by side.
fn add(sums: &mut [Sums], block: &Block<'_>, seen: &Seen) {
    let visits = block.visits.clone();
    let touched = Touched::of(block, seen);
    let mut begins = 0;
    let mut rest = block.beside.as_slice();
    let mut columns = Vec::new();
    for (candidate, sums) in sums.iter_mut().enumerate() {
        let end = begins + sums.score.len();
        let (mine, others) = rest.split_at(rest.partition_point(|said| said.column < end));
        rest = others;
        touched.add(sums, mine, begins);
        columns.extend((begins..end).map(|column| (candidate, column - begins)));
        begins = end;
    }
    let mut at_site = vec![Vec::new(); touched.sites.len()];
    for said in &block.beside {
        if let Some(site) = touched.places[said.site] {
            at_site[site].push(said);
        }
    }
    let mut along = DMatrix::zeros(seen.rank, visits.len());
    for (site, entries) in touched.sites.iter().zip(&at_site) {
        along.fill(0.0);
        for (mut along, visit) in along.column_iter_mut().zip(visits.clone()) {
            for number in seen.visits[visit].clone() {
                let by = seen.site(number)[*site];
                if by != 0.0 {
                    along.iter_mut().zip(seen.base(number)).for_each(|(sum, base)| *sum += by * base);
                }
            }
        }
        for entries in entries.chunks(WIDE) {
            let said = DMatrix::from_fn(visits.len(), entries.len(), |visit, k| {
                entries[k].factor * entries[k].values[visit]
            });
            for (product, said) in (&along * said).column_iter().zip(entries) {
                let (candidate, own) = columns[said.column];
                let mut into = sums[candidate].along.column_mut(own);
                into += product;
            }
        }
    }
}

/// Unknowns whose product with a site's sums is one of two matrices that stay in a processor's cache.
const WIDE: usize = 256;

/// What the numbers of a block of visits say of an error at each of the sites that are touched.
struct Touched {
    sites: Vec<usize>,
    /// Where in `sites` each site of the robot is.
    places: Vec<Option<usize>>,
    visits: usize,
    /// J̃_vᵀJ̃_v, visit after visit for each pair of sites.
    squares: Vec<f64>,
    /// J̃_vᵀr_v, visit after visit for each site.
    scores: Vec<f64>,
}

impl Touched {
    fn of(block: &Block<'_>, seen: &Seen) -> Self {
        let (mut places, mut sites) = (vec![None; seen.sites], Vec::new());
        for said in &block.beside {
            places[said.site].get_or_insert_with(|| {
                sites.push(said.site);
                sites.len() - 1
            });
        }
        let (visits, count) = (block.visits.len(), sites.len());
        let (mut squares, mut scores) = (vec![0.0; count * count * visits], vec![0.0; count * visits]);
        let mut by = vec![0.0; count];
        for (at, visit) in block.visits.clone().enumerate() {
            for number in seen.visits[visit].clone() {
                let (site, residual) = (seen.site(number), seen.residual(number));
                by.iter_mut().zip(&sites).for_each(|(by, &of)| *by = site[of]);
                for (first, one) in by.iter().enumerate().filter(|(_, one)| **one != 0.0) {
                    scores[first * visits + at] += one * residual;
                    for (second, other) in by.iter().enumerate() {
                        squares[(first * count + second) * visits + at] += one * other;
                    }
                }
            }
        }
        Touched { sites, places, visits, squares, scores }
    }

    /// Adds what the entries of a candidate, of which `first` is the first unknown, say of its XᵀX and Xᵀr.
    fn add(&self, sums: &mut Sums, entries: &[Said<'_>], first: usize) {
        let (count, visits) = (self.sites.len(), self.visits);
        let mut weighed = vec![0.0; visits];
        let mut acts = Vec::with_capacity(visits);
        for (k, said) in entries.iter().enumerate() {
            let Some(site) = self.places[said.site] else { continue };
            // Pieces of curves are nothing at most postures.
            acts.clear();
            acts.extend((0..visits).filter(|&visit| said.values[visit] != 0.0));
            let sparse = DENSE * acts.len() < visits;
            let a = said.column - first;
            sums.score[a] += said.factor * dot(said.values, &self.scores[site * visits..][..visits]);
            let mut weighed_at = None;
            for (further, other) in entries[k..].iter().enumerate() {
                let Some(there) = self.places[other.site] else { continue };
                let squares = &self.squares[(site * count + there) * visits..][..visits];
                let sum = if sparse {
                    acts.iter().map(|&at| said.values[at] * squares[at] * other.values[at]).sum()
                } else {
                    if weighed_at.replace(there) != Some(there) {
                        (0..visits).for_each(|at| weighed[at] = said.values[at] * squares[at]);
                    }
                    dot(&weighed, other.values)
                };
                let product: f64 = said.factor * other.factor * sum;
                let b = other.column - first;
                sums.raw[(a, b)] += product;
                if further > 0 {
                    sums.raw[(b, a)] += product;
                }
            }
        }
    }
}

/// A function that acts at fewer than one visit in so many is summed over those alone.
const DENSE: usize = 4;

/// Of equally long numbers; in eight sums, which a processor adds at once.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, last), (b, other)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        for k in 0..8 {
            sums[k] += a[k] * b[k];
        }
    }
    let mut sum = sums.iter().sum::<f64>();
    for (a, b) in last.iter().zip(other) {
        sum += a * b;
    }
    sum
}

//! The screen of a sample with the scores of all rows.
//!
//! X̃ᵀr = Xᵀr, since the fit of all rows leaves nothing of r along the model: a candidate costs its entries times `J̃ᵀr` of each visit, a set
//! of functions at all sites one product a block, and all periods of a joint one sum a visit ([`crate::census::waves`]).

use crate::census::all_rows::AllRows;
use crate::census::blocks::Blocks;
use crate::census::waves::MotionBins;
use crate::census::white::White;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use crate::options::DiscoverOptions;
use crate::problem::linearisation::Linearisation;
use crate::problem::tables::{Sums, Tables};
use crate::screen::candidates::Screen;
use crate::screen::functions::Functions;
use crate::statistics::beta::surprisal;
use crate::statistics::product::cross;
use nalgebra::{DMatrix, DVector};
use truepose_errormodel::{AnyEffect, Dataset};

/// Xᵀr of everything that a screen looks at.
struct Scores {
    /// Of candidates that are taken for themselves.
    single: Vec<DVector<f64>>,
    /// Of functions (rows) at sites (columns).
    functions: DMatrix<f64>,
    /// Of the own motion of joints.
    motions: Vec<MotionBins>,
}

/// Puts the scores of all rows in the place of those of the sample.
pub(crate) fn screened(
    screen: &mut Screen,
    sample: &Linearisation<'_>,
    (all, blocks): (&AllRows, &Blocks),
    options: &DiscoverOptions,
) -> Result<(), DiscoverError> {
    let scores = scores(screen, sample, (all, blocks), options)?;
    let rows = all.count as f64;
    // T makes the columns of the sample orthonormal: those of all rows are longer.
    let shorter = sample.len() as f64 / rows;
    let freedom = all.count.saturating_sub(all.inverse.nrows());
    let judged = |basis: &DMatrix<f32>, score: &DVector<f64>| -> (f64, f64) {
        let explained = basis.map(f64::from).tr_mul(score).norm_squared() * shorter;
        let fraction = (explained / all.squares).min(1.0 - 1e-12);
        (-rows * (1.0 - fraction).ln(), surprisal(fraction, basis.ncols(), freedom))
    };
    let mut next = scores.single.iter();
    for k in 0..screen.candidates.len() {
        let candidate = &screen.candidates[k].candidate;
        let at_site = screen.functions().and_then(|f| f.scores_at(sample, candidate, &scores.functions));
        let own = match at_site {
            Some(score) => Some(score),
            None if is_single(screen.functions(), sample, candidate) => next.next().cloned(),
            None => None,
        };
        if let Some(score) = &mut screen.candidates[k].score {
            (score.gain, score.surprisal) = match &own {
                Some(own) if own.len() == score.basis.nrows() => judged(&score.basis, own),
                // Another load, of which the search has seen as much as there is to see.
                _ => (0.0, 0.0),
            };
        }
    }
    for (wave, bins) in screen.periods.iter_mut().zip(&scores.motions) {
        let sums = bins.waves(&wave.periods);
        wave.rejudge(|k, basis| judged(basis, &DVector::from_column_slice(&sums[k])));
    }
    Ok(())
}

/// Whether a candidate is taken for itself.
fn is_single(functions: Option<&Functions>, sample: &Linearisation<'_>, candidate: &Candidate) -> bool {
    matches!(candidate.change, Change::Add(_)) && functions.and_then(|f| f.place(sample, candidate)).is_none()
}

fn scores(
    screen: &Screen,
    sample: &Linearisation<'_>,
    (all, blocks): (&AllRows, &Blocks),
    options: &DiscoverOptions,
) -> Result<Scores, DiscoverError> {
    let functions = screen.functions();
    let single: Vec<&Candidate> = screen
        .candidates
        .iter()
        .map(|screened| &screened.candidate)
        .filter(|candidate| is_single(functions, sample, candidate))
        .collect();
    let chain = sample.chain();
    let motions: Vec<_> = screen.periods.iter().map(|wave| (wave.joint, wave.shares())).collect();
    let empty: Vec<MotionBins> = screen
        .periods
        .iter()
        .map(|wave| {
            let column = chain.coordinate(wave.joint).map_or(&[][..], |k| &blocks.data().joints[k]);
            let ends =
                column.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], &q| [a.min(q), b.max(q)]);
            MotionBins::new(ends, wave.periods.last().copied().unwrap_or(1.0))
        })
        .collect();
    let of = |block: &Dataset| -> Result<Scores, DiscoverError> {
        let linearisation = blocks.linearised(&all.at, block, options)?;
        let whitener = linearisation.whitener(linearisation.noise);
        let residual = all.residual_of(&linearisation, &whitener);
        let tables = Tables::new(&linearisation, &whitener, &residual);
        let stations = || tables.stations.iter().copied();
        let mut sums = Vec::with_capacity(single.len());
        for candidate in &single {
            let mut sum = DVector::zeros(0);
            // A candidate that the data lacks a covariate for has no score in the sample either.
            if let Ok(evaluated) = linearisation.evaluate(candidate.effects()) {
                sum = DVector::zeros(evaluated.width());
                evaluated.each(stations(), &mut |visit, entries| {
                    for &(column, site, value) in entries {
                        sum[column] += value * tables.score(visit, site);
                    }
                })?;
            }
            sums.push(sum);
        }
        let at_sites = match functions {
            Some(functions) => functions.through(&linearisation, &tables)?,
            None => DMatrix::zeros(0, 0),
        };
        let mut bins = empty.clone();
        for ((joint, shares), bins) in motions.iter().zip(&mut bins) {
            for (visit, station) in stations().enumerate() {
                let Some(value) = linearisation.joint_at(station, *joint) else { continue };
                bins.add(value, shares.iter().map(|&(site, share)| share * tables.score(visit, site)).sum());
            }
        }
        Ok(Scores { single: sums, functions: at_sites, motions: bins })
    };
    let derived =
        blocks.derived(&all.fit, screen.candidates.iter().flat_map(|s| s.candidate.effects().iter()));
    let mut whole: Option<Scores> = None;
    blocks.each(1, &derived, &of, &mut |_, part| match &mut whole {
        None => whole = Some(part),
        Some(whole) => {
            for (sum, more) in whole.single.iter_mut().zip(part.single) {
                if sum.len() == more.len() {
                    *sum += more;
                }
            }
            whole.functions += part.functions;
            whole.motions.iter_mut().zip(&part.motions).for_each(|(sum, more)| sum.merge(more));
        }
    })?;
    Ok(whole.unwrap_or(Scores { single: Vec::new(), functions: DMatrix::zeros(0, 0), motions: empty }))
}

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
        each.extend(sums_of_several(several, (all, blocks), stride, options)?);
    }
    Ok(each)
}

/// Columns of candidates that a block has side by side, at least, where there are so many.
const COLUMNS: usize = 256;

fn sums_of_several(
    candidates: &[Candidate],
    (all, blocks): (&AllRows, &Blocks),
    stride: usize,
    options: &DiscoverOptions,
) -> Result<Vec<Option<Sums>>, DiscoverError> {
    let of = |block: &Dataset| -> Result<Vec<Option<Sums>>, DiscoverError> {
        let mut each = Vec::with_capacity(candidates.len());
        while each.len() < candidates.len() {
            let mut widths: Vec<Option<usize>> = Vec::new();
            let mut effects: Vec<Box<dyn AnyEffect>> = Vec::new();
            for candidate in &candidates[each.len()..] {
                let width = White::width_of(candidate, &all.at, block);
                if width.is_some() {
                    effects.extend_from_slice(candidate.effects());
                }
                widths.push(width);
                if widths.iter().flatten().sum::<usize>() >= COLUMNS {
                    break;
                }
            }
            let white = White::of((block, blocks), (&all.at, &all.fit), &effects, options)?;
            let along = cross(&white.base, &white.columns);
            let mut first = 0;
            for width in widths {
                each.push(width.map(|width| {
                    let own = white.columns.columns(first, width);
                    let along = along.columns(first, width).into_owned();
                    first += width;
                    Sums { along, raw: cross(&own, &own), score: own.tr_mul(&white.residual) }
                }));
            }
        }
        Ok(each)
    };
    let derived =
        blocks.derived(&all.fit, candidates.iter().flat_map(|candidate| candidate.effects().iter()));
    let mut whole: Vec<Option<Sums>> = Vec::new();
    blocks.each(stride, &derived, &of, &mut |_, part| {
        if whole.is_empty() {
            whole = part;
            return;
        }
        for (sum, more) in whole.iter_mut().zip(part) {
            match (sum.as_mut(), more) {
                (Some(sum), Some(more)) => sum.merge(&more),
                _ => *sum = None,
            }
        }
    })?;
    Ok(whole)
}

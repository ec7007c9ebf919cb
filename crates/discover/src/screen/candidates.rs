//! One pass over all candidates: no refit, everything that the present model explains projected out.

use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use crate::hypotheses::family::Family;
use crate::hypotheses::library::Library;
use crate::hypotheses::place::Place;
use crate::hypotheses::series::series;
use crate::hypotheses::variant::Variant;
use crate::policy::penalty_per_coefficient;
use crate::problem::linearisation::Linearisation;
use crate::problem::projection::{Projection, Score};
use crate::screen::functions::Functions;
use crate::screen::periodogram;
use crate::screen::periodogram::Periodogram;
use crate::screen::screened::Screened;
use crate::significance::rotation::{Largest, NullDistribution, Rotations};
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, OnceLock};
use truepose_errormodel::AnyEffect;

/// How many separate questions were asked of each family.
pub(crate) type TestCounts = BTreeMap<Family, usize>;

/// All candidates at the present model.
pub(crate) struct Screen {
    pub projection: Projection,
    pub candidates: Vec<Screened>,
    pub periods: Vec<Periodogram>,
    functions: Option<Functions>,
    /// How many separate questions were asked of each family.
    test_counts: TestCounts,
    library: Library,
}

/// A cause at a place with its variants, best first.
pub(crate) struct Cause {
    pub family: Family,
    pub place: Place,
    /// (candidate, gain, freedom), by gain less the price of its unknowns.
    pub variants: Vec<(Arc<Candidate>, f64, usize)>,
    /// Raw columns (m × k) of the best variant, once they are needed.
    columns: OnceLock<DMatrix<f64>>,
}

impl Cause {
    /// Raw columns of the best variant, m × k.
    pub fn columns(&self, linearisation: &Linearisation<'_>) -> Result<&DMatrix<f64>, DiscoverError> {
        match self.columns.get() {
            Some(known) => Ok(known),
            None => {
                let columns = linearisation.columns_of(&self.variants[0].0)?;
                Ok(self.columns.get_or_init(|| columns))
            }
        }
    }
}

/// Whether a candidate asks for a load that stands in the data because it was corrected.
fn is_corrected(candidate: &Candidate, found: &[Candidate]) -> bool {
    /// Masses still move a little while the model is fitted to the data that has them.
    const SAME: f64 = 1e-3;
    let Change::CorrectLoad { level, during: None, .. } = candidate.change else { return false };
    found.iter().any(|other| match other.change {
        Change::CorrectLoad { mass, .. } => (mass - level).abs() <= SAME * level.abs().max(1.0),
        Change::Add(_) | Change::Exclude { .. } => false,
    })
}

/// Whether a candidate consists of constant errors that the model has already. It would only have a wider prior: a model that lacks nothing
/// would be told to measure its targets again.
fn is_declared(candidate: &Candidate, linearisation: &Linearisation<'_>) -> bool {
    let known = |effect: &dyn AnyEffect| {
        let columns = effect.columns(linearisation.chain());
        columns.iter().all(|column| column.site.is_some_and(|site| linearisation.has_constant(site)))
    };
    let effects = candidate.effects();
    // A series in something is no constant.
    series(candidate).is_none_or(|series| series.factors.is_empty())
        && !effects.is_empty()
        && effects.iter().all(|effect| known(&**effect))
}

/// Candidates whose columns stand side by side, so that what is asked of them is one product of matrices.
const TOGETHER: usize = 64;

impl Screen {
    /// Of a whole library; `found` is in the data and the model already.
    pub fn new(linearisation: &Linearisation<'_>, library: &Library, found: &[Candidate]) -> Self {
        let mut all = library.candidates(linearisation.chain(), linearisation.data);
        all.retain(|candidate| !is_corrected(candidate, found) && !is_declared(candidate, linearisation));
        let mut screen = Screen::of(linearisation, all, library);
        let judged = screen.candidates.iter().filter(|s| s.score.is_some());
        judged.for_each(|s| *screen.test_counts.entry(s.candidate.family).or_default() += 1);
        for wave in &screen.periods {
            for hypothesis in library.periodic(wave.joint) {
                *screen.test_counts.entry(hypothesis.family()).or_default() += wave.periods.len() / 4;
            }
        }
        screen
    }

    /// Of all causes with a name and of a short list of others, as part of a larger search.
    pub fn again(
        linearisation: &Linearisation<'_>,
        library: &Library,
        (shortlist, found): (&[Candidate], &[Candidate]),
        test_counts: &TestCounts,
    ) -> Self {
        let mut candidates = library.named(linearisation.chain(), linearisation.data);
        candidates.extend(shortlist.iter().cloned());
        candidates
            .retain(|candidate| !is_corrected(candidate, found) && !is_declared(candidate, linearisation));
        Screen { test_counts: test_counts.clone(), ..Screen::of(linearisation, candidates, library) }
    }

    fn of(linearisation: &Linearisation<'_>, candidates: Vec<Candidate>, library: &Library) -> Self {
        let projection = Projection::new(linearisation);
        // Without them every candidate is taken for itself.
        let functions = Functions::new(linearisation, &projection, &candidates).ok();
        let judged: Vec<(Option<Score>, bool)> = candidates
            .par_chunks(TOGETHER)
            .flat_map_iter(|chunk| {
                let at_site: Vec<Option<Option<Score>>> = chunk
                    .iter()
                    .map(|candidate| functions.as_ref()?.score(linearisation, candidate))
                    .collect();
                let columns: Vec<Option<DMatrix<f64>>> = chunk
                    .iter()
                    .zip(&at_site)
                    .map(|(candidate, at_site)| match at_site {
                        Some(_) => None,
                        None => projection.columns(linearisation, candidate).ok(),
                    })
                    .collect();
                let has_columns: Vec<bool> = columns.iter().map(Option::is_some).collect();
                let mut sums =
                    projection.sums_of(&columns.into_iter().flatten().collect::<Vec<_>>()).into_iter();
                let judged = |(at_site, has_columns)| match at_site {
                    Some(score) => (score, true),
                    None => {
                        let sums = if has_columns { sums.next() } else { None };
                        let acts = sums.as_ref().is_some_and(|sums| sums.raw.trace() > 0.0);
                        (sums.and_then(|sums| projection.score(&sums)), acts)
                    }
                };
                at_site.into_iter().zip(has_columns).map(judged).collect::<Vec<_>>()
            })
            .collect();
        let screened = |(candidate, (score, acts))| Screened { candidate: Arc::new(candidate), score, acts };
        let candidates = candidates.into_iter().zip(judged).map(screened).collect();
        let periods = linearisation
            .chain()
            .movable()
            .iter()
            .filter(|&&joint| library.periodic(joint).next().is_some())
            .filter_map(|&joint| {
                periodogram::scan(linearisation, &projection, joint, &periodogram::grid(linearisation, joint))
            })
            .collect();
        Screen {
            projection,
            candidates,
            periods,
            functions,
            test_counts: BTreeMap::new(),
            library: library.clone(),
        }
    }

    /// The candidates that are functions of the visit at one site.
    pub fn functions(&self) -> Option<&Functions> {
        self.functions.as_ref()
    }

    /// The largest surprisal over everything that was looked at.
    pub fn largest(&self) -> f64 {
        let single = self.candidates.iter().filter_map(|s| s.score.as_ref()).map(|score| score.surprisal);
        let waves = self.periods.iter().flat_map(|p| p.surprisals.iter().copied());
        single.chain(waves).fold(0.0, f64::max)
    }

    /// The distribution of the largest surprisal if nothing were missing.
    pub fn null(
        &self,
        linearisation: &Linearisation<'_>,
        rotations: usize,
        seed: u64,
    ) -> Result<NullDistribution, DiscoverError> {
        let rotations = Rotations::new(&self.projection, rotations, seed);
        let tables = self.projection.tables(linearisation);
        let at = tables.at_sites(&rotations.directions);
        let functions = self.functions.as_ref();
        let mut largest = functions.map_or_else(
            || rotations.nothing(),
            |f| f.largest(linearisation, &self.candidates, &rotations, &at),
        );
        let others: Vec<(&Candidate, &Score)> = self
            .candidates
            .iter()
            .filter_map(|s| Some((&*s.candidate, s.score.as_ref()?)))
            .filter(|(candidate, _)| functions.and_then(|f| f.place(linearisation, candidate)).is_none())
            .collect();
        let parts: Vec<Largest> = others
            .par_chunks(TOGETHER)
            .map(|chunk| -> Result<Largest, DiscoverError> {
                let columns = chunk.iter().map(|(c, _)| self.projection.columns(linearisation, c));
                let columns = columns.collect::<Result<Vec<_>, _>>()?;
                let through = rotations.along(&columns);
                let (mut largest, mut first) = (rotations.nothing(), 0);
                for ((_, score), own) in chunk.iter().zip(&columns) {
                    rotations.add(&mut largest, &through.rows(first, own.ncols()), &score.basis);
                    first += own.ncols();
                }
                Ok(largest)
            })
            .collect::<Result<_, _>>()?;
        for part in parts {
            largest = largest.with(part);
        }
        for wave in &self.periods {
            largest = largest.with(wave.largest(&rotations, &at));
        }
        Ok(largest.distribution(self.projection.freedom))
    }

    /// Causes, best first: each by the variant whose gain best pays for its unknowns.
    pub fn causes(&self, linearisation: &Linearisation<'_>) -> Vec<Cause> {
        let penalty = penalty_per_coefficient(self.projection.len());
        let mut causes: Vec<Cause> = Vec::new();
        let mut known: HashMap<String, usize> = HashMap::new();
        let mut last = 0;
        let mut put = |candidate: Arc<Candidate>, gain: f64, freedom: usize| {
            // Variants of one cause follow each other.
            let same = |cause: &Cause| cause.family == candidate.family && cause.place == candidate.place;
            if !causes.get(last).is_some_and(same) {
                last = *known.entry(candidate.words()).or_insert_with(|| {
                    let (family, place) = (candidate.family, candidate.place.clone());
                    causes.push(Cause { family, place, variants: Vec::new(), columns: OnceLock::new() });
                    causes.len() - 1
                });
            }
            causes[last].variants.push((candidate, gain, freedom));
        };
        for screened in &self.candidates {
            if let Some(score) = &screened.score {
                put(Arc::clone(&screened.candidate), score.gain, score.freedom);
            }
        }
        for wave in &self.periods {
            for hypothesis in self.library.periodic(wave.joint) {
                for (period, gain) in wave.peaks(linearisation.budget.peaks) {
                    let Some(effect) = hypothesis.at_period(wave.joint, period) else { continue };
                    let place = Place::joint(linearisation.chain(), wave.joint);
                    let variant = Variant { place, change: Change::Add(vec![effect]) };
                    put(Arc::new(Candidate::new(Arc::clone(hypothesis), variant)), gain, 2);
                }
            }
        }
        let worth = |(candidate, gain, freedom): &(Arc<Candidate>, f64, usize)| {
            let count = *freedom as f64;
            // By evidence, as if the data knew all of them alike: the law is as wide as they came out.
            let alike = 1.0 + (gain / count).max(1.0).ln();
            gain - count * if candidate.by_evidence() { penalty.min(alike) } else { penalty }
        };
        for cause in &mut causes {
            cause.variants.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
        }
        causes.sort_by(|a, b| worth(&b.variants[0]).total_cmp(&worth(&a.variants[0])));
        causes
    }

    /// Family and place of the smallest p of the screen.
    pub fn opener(&self) -> Option<(Family, Place)> {
        let single = self.candidates.iter().filter_map(|s| Some((s.score.as_ref()?.surprisal, &s.candidate)));
        let (largest, candidate) = single.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let waves = self.periods.iter().any(|p| p.surprisals.iter().any(|&s| s > largest));
        // The best periods of every joint are among the causes in any case.
        (!waves).then(|| (candidate.family, candidate.place.clone()))
    }

    /// How many tests were made: candidates that the data can judge, and periods.
    pub fn tests(&self) -> usize {
        let judged = self.candidates.iter().filter(|s| s.score.is_some()).count();
        judged + self.periods.iter().map(|wave| wave.periods.len()).sum::<usize>()
    }

    /// How many separate questions were asked of a family.
    pub fn tests_of(&self, family: Family) -> usize {
        self.test_counts.get(&family).copied().unwrap_or_default().max(1)
    }

    /// The same of all families.
    pub fn test_counts(&self) -> &TestCounts {
        &self.test_counts
    }
}

//! One pass over all candidates: no refit, everything that the present model explains projected out.

use crate::hypotheses::candidate::{Candidate, Change};
use crate::hypotheses::family::Family;
use crate::hypotheses::library;
use crate::hypotheses::motion::transmission_at;
use crate::hypotheses::penalty::by_evidence;
use crate::hypotheses::place::Place;
use crate::policy::price;
use crate::problem::linearisation::Scene;
use crate::problem::projection::{Projection, Score};
use crate::screen::functions::Functions;
use crate::screen::periodogram;
use crate::screen::periodogram::Periodogram;
use crate::significance::sign_flips::{Block, NullDistribution};
use crate::statistics::surprisal::Surprise;
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::collections::{BTreeMap, HashMap};
use truepose_errormodel::AnyEffect;

/// A candidate and its score; none where the data cannot judge it.
pub(crate) struct Screened {
    pub candidate: Candidate,
    pub score: Option<Score>,
    /// Whether it does anything at all to the measured numbers.
    pub acts: bool,
}

/// How many separate questions were asked of each family.
pub(crate) type Questions = BTreeMap<Family, usize>;

/// All candidates at the present model.
pub(crate) struct Screen {
    pub projection: Projection,
    pub candidates: Vec<Screened>,
    pub periods: Vec<Periodogram>,
    /// How many separate questions were asked of each family.
    asked: Questions,
}

/// A cause at a place with its variants, best first.
pub(crate) struct Cause {
    pub family: Family,
    pub place: Place,
    /// (candidate, gain, freedom), by gain less the price of its unknowns.
    pub variants: Vec<(Candidate, f64, usize)>,
}

/// Whether a candidate asks for a load that stands in the data because it was corrected.
fn is_corrected(candidate: &Candidate, found: &[Candidate]) -> bool {
    /// Masses still move a little while the model is fitted to the data that has them.
    const SAME: f64 = 1e-3;
    let Change::CorrectLoad { level, .. } = candidate.change else { return false };
    found.iter().any(|other| match other.change {
        Change::CorrectLoad { mass, .. } => (mass - level).abs() <= SAME * level.abs().max(1.0),
        Change::Add(_) => false,
    })
}

/// Whether a candidate consists of constant errors that the model has already. It would only have a wider prior: a model that lacks nothing
/// would be told to measure its targets again.
fn is_declared(candidate: &Candidate, scene: &Scene<'_>) -> bool {
    let known = |effect: &dyn AnyEffect| {
        let columns = effect.columns(scene.chain());
        columns.iter().all(|column| column.site.is_some_and(|site| scene.has_constant(site)))
    };
    let effects = candidate.effects();
    !effects.is_empty() && effects.iter().all(|effect| known(&**effect))
}

impl Screen {
    /// Of everything but some families; `found` is in the data and the model already.
    pub fn new(scene: &Scene<'_>, without: &[Family], found: &[Candidate]) -> Self {
        let mut all = library::candidates(scene.chain(), scene.data, without);
        all.retain(|candidate| !is_corrected(candidate, found) && !is_declared(candidate, scene));
        let mut screen = Screen::of(scene, all, without);
        let judged = screen.candidates.iter().filter(|s| s.score.is_some());
        judged.for_each(|s| *screen.asked.entry(s.candidate.family).or_default() += 1);
        let waves: usize = screen.periods.iter().map(|p| p.periods.len() / 4).sum();
        *screen.asked.entry(Family::Transmission).or_default() += waves;
        screen
    }

    /// Of all causes with a name and of a short list of others, as part of a larger search.
    pub fn again(
        scene: &Scene<'_>,
        without: &[Family],
        (shortlist, found): (&[Candidate], &[Candidate]),
        asked: &Questions,
    ) -> Self {
        let mut candidates = library::named(scene.chain(), scene.data, without);
        candidates.extend(shortlist.iter().cloned());
        candidates.retain(|candidate| !is_corrected(candidate, found) && !is_declared(candidate, scene));
        Screen { asked: asked.clone(), ..Screen::of(scene, candidates, without) }
    }

    fn of(scene: &Scene<'_>, candidates: Vec<Candidate>, without: &[Family]) -> Self {
        let projection = Projection::new(scene);
        // Without them every candidate is taken for itself.
        let functions = Functions::new(scene, &projection, &candidates).ok();
        let candidates = candidates
            .into_par_iter()
            .map(|candidate| {
                if let Some(score) =
                    functions.as_ref().and_then(|functions| functions.score(scene, &candidate))
                {
                    return Screened { candidate, acts: true, score };
                }
                let sums = projection.sums(scene, &candidate).ok();
                let acts = sums.as_ref().is_some_and(|sums| sums.raw.trace() > 0.0);
                Screened { candidate, score: sums.and_then(|sums| projection.score(&sums)), acts }
            })
            .collect();
        let periods = scene
            .chain()
            .movable()
            .iter()
            .filter(|_| !without.contains(&Family::Transmission))
            .filter_map(|&joint| {
                periodogram::scan(scene, &projection, joint, &periodogram::grid(scene, joint))
            })
            .collect();
        Screen { projection, candidates, periods, asked: BTreeMap::new() }
    }

    /// The largest statistics over everything that was looked at.
    pub fn largest(&self) -> Surprise {
        let single = self.candidates.iter().filter_map(|s| s.score.as_ref()).map(|score| score.surprise);
        let waves = self.periods.iter().flat_map(|p| p.surprises.iter().copied());
        single.chain(waves).fold(Surprise::NONE, Surprise::max)
    }

    /// What the largest statistic would be if nothing were missing.
    pub fn null(&self, flips: usize, seed: u64) -> NullDistribution {
        /// Columns in one product.
        const WIDTH: usize = 1024;
        let mut joined: Vec<Block> = Vec::new();
        let scores: Vec<&Score> = self.candidates.iter().filter_map(|s| s.score.as_ref()).collect();
        let mut next = 0;
        while next < scores.len() {
            let (mut width, first) = (0, next);
            while next < scores.len() && (width == 0 || width + scores[next].freedom <= WIDTH) {
                width += scores[next].freedom;
                next += 1;
            }
            let mut block = DMatrix::zeros(self.projection.units, width);
            let mut column = 0;
            for score in &scores[first..next] {
                block.columns_mut(column, score.freedom).copy_from(&score.by_unit);
                column += score.freedom;
            }
            let each = scores[first..next].iter().map(|score| (score.freedom, score.law)).collect();
            joined.push(Block { by_unit: block, each });
        }
        for wave in &self.periods {
            let mut first = 0;
            while first < wave.periods.len() {
                let count = (WIDTH / 2).min(wave.periods.len() - first);
                let each = wave.laws[first..first + count].iter().map(|&law| (2, law)).collect();
                joined.push(Block { by_unit: wave.by_unit.columns(2 * first, 2 * count).into_owned(), each });
                first += count;
            }
        }
        NullDistribution::new(&self.projection, &joined, flips, seed)
    }

    /// Causes, best first: each by the variant whose gain best pays for its unknowns.
    pub fn causes(&self, scene: &Scene<'_>) -> Vec<Cause> {
        let price = price(self.projection.len());
        let mut causes: Vec<Cause> = Vec::new();
        let mut known: HashMap<String, usize> = HashMap::new();
        let mut put = |candidate: Candidate, gain: f64, freedom: usize| {
            let at = *known.entry(candidate.words()).or_insert_with(|| {
                let (family, place) = (candidate.family, candidate.place.clone());
                causes.push(Cause { family, place, variants: Vec::new() });
                causes.len() - 1
            });
            causes[at].variants.push((candidate, gain, freedom));
        };
        for screened in &self.candidates {
            if let Some(score) = &screened.score {
                put(screened.candidate.clone(), score.gain, score.freedom);
            }
        }
        for wave in &self.periods {
            for (period, gain) in wave.peaks(3) {
                put(transmission_at(scene.chain(), wave.joint, &[period]), gain, 2);
            }
        }
        let worth = |(candidate, gain, freedom): &(Candidate, f64, usize)| {
            let count = *freedom as f64;
            // By evidence, as if the data knew all of them alike: the law is as wide as they came out.
            let alike = 1.0 + (gain / count).max(1.0).ln();
            gain - count * if by_evidence(candidate) { price.min(alike) } else { price }
        };
        for cause in &mut causes {
            cause.variants.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
        }
        causes.sort_by(|a, b| worth(&b.variants[0]).total_cmp(&worth(&a.variants[0])));
        causes
    }

    /// How many tests were made: candidates that the data can judge, and periods.
    pub fn tests(&self) -> usize {
        let judged = self.candidates.iter().filter(|s| s.score.is_some()).count();
        judged + self.periods.iter().map(|wave| wave.periods.len()).sum::<usize>()
    }

    /// How many separate questions were asked of a family.
    pub fn asked(&self, family: Family) -> usize {
        self.asked.get(&family).copied().unwrap_or_default().max(1)
    }

    /// The same of all families.
    pub fn questions(&self) -> &Questions {
        &self.asked
    }

    /// The best causes without a name, in all their variants: those that may come in for a find when it is looked at again.
    pub fn shortlist(&self, scene: &Scene<'_>) -> Vec<Candidate> {
        const LISTED: usize = 60;
        self.causes(scene)
            .into_iter()
            .filter(|cause| cause.family == Family::Unmodelled)
            .take(LISTED)
            .flat_map(|cause| cause.variants.into_iter().map(|(candidate, ..)| candidate))
            .collect()
    }
}

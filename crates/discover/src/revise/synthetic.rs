//! Models with findings that were put there, for tests of revisions.

use crate::accept::accepted::Accepted;
use crate::accept::evidence::collect;
use crate::accept::model::Model;
use crate::contest::competition::contest;
use crate::contest::competitor::{competitor, with_estimates};
use crate::model::current::Context;
use crate::options::DiscoverOptions;
use crate::problem::dependence::BesideWander;
use crate::problem::linearisation::Linearisation;
use crate::screen::candidates::Screen;
use crate::screen::multiplicity::Multiplicity;
use truepose_errormodel::{AnyEffect, Dataset, Visits};
use truepose_kinematics::Chain;
use truepose_solvers::PivotedQr;

/// A model whose findings are the candidates of these words, given to `see`.
pub(super) fn with_findings(
    (chain, rows): (&Chain, &Dataset),
    declared: &[Box<dyn AnyEffect>],
    words: &[&str],
    see: impl FnOnce(&Context<'_>, &Model, &Multiplicity),
) {
    let options = DiscoverOptions { rotations: 199, ..DiscoverOptions::default() };
    let solver = PivotedQr::default();
    let context = Context {
        chain,
        declared,
        data: rows,
        solver: &solver,
        fit: options.fit.clone(),
        options: &options,
        levels_first: false,
        full_report: true,
    };
    let model = Model::declared(context.fit_model(Vec::new(), &[]).unwrap());
    let current = model.current.clone();
    let linearisation = Linearisation::new(&current.fit, &current.data, &options).unwrap();
    let screen = Screen::new(&linearisation, &options.library, &[]);
    let (multiplicity, _) = Multiplicity::of(&linearisation, &screen, None, &options).unwrap();
    let present = contest(&linearisation, &screen, &[], true).unwrap().present;
    let wander = BesideWander::of(&linearisation, options.seed);
    let causes = screen.causes(&linearisation);
    let finding = |words: &&str| {
        let found = causes.iter().map(|cause| &cause.variants[0].0).find(|c| c.words() == *words);
        let candidate = (**found.expect(words)).clone();
        let one = competitor(&linearisation, &screen, &Visits::of(linearisation.data), candidate);
        let one = one.unwrap().expect(words);
        let evidence = collect((&linearisation, &wander), (&screen, &present), &one, 1e-3, &options).unwrap();
        Accepted {
            candidate: with_estimates(&one),
            evidence,
            competitors: Vec::new(),
            shortlist: Vec::new(),
            instead: Vec::new(),
        }
    };
    let model = model.refitted(&context, words.iter().map(finding).collect()).unwrap();
    see(&context, &model, &multiplicity);
}

//! Reduce and then expand, as the paper does, or expand and then reduce: does it matter?
//!
//! The paper's polynomial in both orders, with and without a prior: on the paper's robot (identified and checked as in the
//! study `pps`), and on two arms that are no models either (three quarters of their visits, judged at the others).
//!
//! | figure | of |
//! | --- | --- |
//! | columns, rank | unknowns declared, and what is left after the fit's own reduction |
//! | error | true plant against model where nothing was fitted: largest of the treatment point, or RMS of the tool |
//! | ms | the identification, on one thread |

use crate::clock::least;
use crate::closed_loop::robots::{self, Measured};
use crate::pps::{Experiment, Strategy, polynomial, reduced_first};
use crate::prelude::*;
use serde_json::json;

/// Plants of each kind.
const PLANTS: u64 = 8;

const ORDERS: [&str; 2] = ["expand_first", "reduce_first"];

/// What one plant shows.
struct Shown {
    columns: usize,
    rank: usize,
    error: f64,
}

/// Runs the study.
pub fn run(_: &[String]) -> Outcome {
    let folder = folder("orders")?;
    let mut table = Table::columns("robot -8|prior -9|order -13|columns 8|rank 6|error 18|ms 7");
    print(&format!("{PLANTS} plants each; error: median [worst], µm\n{}", table.last()));
    let seeds = || (0..PLANTS).into_par_iter();
    let experiments = seeds().map(|seed| Experiment::new(100 + seed)).collect::<Outcome<Vec<_>>>()?;
    let mut line = |robot: &str, prior: &str, order: &str, shown: &[Shown], seconds: f64| {
        let errors = || shown.iter().map(|s| 1e6 * s.error);
        let error = format!("{:.1} [{:.1}]", quantile(errors(), 0.5), quantile(errors(), 1.0));
        let (columns, rank, ms) = (shown[0].columns, shown[0].rank, fixed(1e3 * seconds, 0));
        table.row(&[&robot, &prior, &order, &columns, &rank, &error, &ms]);
        print(table.last());
    };
    for (words, prior) in [("none", PriorStrength::None), ("evidence", PriorStrength::Evidence)] {
        for (order, effects) in ORDERS.into_iter().zip([polynomial as fn(&Chain) -> _, reduced_first]) {
            let strategy = Strategy {
                name: order.into(),
                effects,
                prior,
                solver: SolverSpec::default(),
                refine: true,
                second_reduction: true,
                rounds: 25,
            };
            let shown =
                experiments.par_iter().map(|e| couch(e, &strategy)).collect::<Outcome<Vec<Shown>>>()?;
            line("pps", words, order, &shown, least(2, || experiments[0].fit(&strategy))?);
        }
        for robot in robots::all()?.iter().filter(|robot| ["heavy", "ur10"].contains(&robot.name.as_str())) {
            let measure = |seed| robot.measured(40 + 10 * seed, robot.visits);
            let measured = seeds().map(measure).collect::<Outcome<Vec<Measured>>>()?;
            for order in ORDERS {
                let shown =
                    measured.par_iter().map(|m| shown(m, order, prior)).collect::<Outcome<Vec<Shown>>>()?;
                let seconds = least(1, || polynomial_fit(&measured[0], order, prior))?;
                line(&robot.name, words, order, &shown, seconds);
            }
        }
    }
    let text = format!("{PLANTS} plants each; error: median [worst], µm\n{}", table.text());
    finish("orders", &folder.join("table.txt"), &text)
}

/// The paper's experiment.
fn couch(experiment: &Experiment, strategy: &Strategy) -> Outcome<Shown> {
    let radii = experiment.identify(strategy)?;
    Ok(Shown { columns: radii.columns, rank: radii.rank, error: radii.noise_free })
}

fn polynomial_fit(arm: &Measured, order: &str, prior: PriorStrength) -> Outcome<Fit> {
    let polynomial = json!({"degree": 1, "wrench": ["mx", "my", "mz"], "wrench_of": "frame", "order": order});
    let (chain, last) = (&arm.chain, arm.chain.tool_frame().0);
    let registry = EffectRegistry::builtin();
    let effects = [
        registry.build("geometric", json!({"frames": [0, last - 1, last]}), chain)?,
        registry.build("polynomial", polynomial, chain)?,
    ];
    let options = FitOptions { prior, max_iterations: 25, ..FitOptions::default() };
    fitted(chain, &effects, &arm.data.select(&arm.used), &options)
}

/// What is left at the held-out poses of an arm.
fn shown(arm: &Measured, order: &str, prior: PriorStrength) -> Outcome<Shown> {
    let fit = polynomial_fit(arm, order, prior)?;
    let mut predictor = fit.fitted.bind(&arm.data.schema)?;
    let mut off = Vec::new();
    for &row in arm.held_out.iter().flatten() {
        let (conditions, target) = (arm.data.conditions(row), arm.data.target[row]);
        let predicted = predictor.predict(&conditions, target).translation;
        off.push((arm.plant.true_position(&conditions, target)? - predicted).norm());
    }
    let (columns, rank) = (fit.fitted.coefficients().len(), fit.reduction.rank());
    Ok(Shown { columns, rank, error: rms(off) })
}

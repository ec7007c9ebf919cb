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
use crate::closed_loop::{Robot, robots};
use crate::pps::{Experiment, Strategy, polynomial, reduced_first};
use crate::results::finish;
use crate::{folder, print};
use rayon::prelude::*;
use serde_json::json;
use std::error::Error;
use std::fmt::Write;
use truepose_errormodel::{Dataset, EffectRegistry, ErrorModel, Visits};
use truepose_identify::{Fit, FitOptions, PriorStrength, fit};
use truepose_kinematics::Chain;
use truepose_simulate::{Campaign, Plant};
use truepose_solvers::{PivotedQr, SolverSpec};

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
pub fn run(_: &[String]) -> Result<(), Box<dyn Error>> {
    let folder = folder("orders")?;
    let mut text = String::new();
    writeln!(text, "{PLANTS} plants each; error: median [worst], µm")?;
    writeln!(
        text,
        "{:8} {:9} {:13} {:>8} {:>6} {:>18} {:>7}",
        "robot", "prior", "order", "columns", "rank", "error", "ms"
    )?;
    print(&text);
    let experiments: Vec<Experiment> = (0..PLANTS)
        .into_par_iter()
        .map(|seed| Experiment::new(100 + seed).map_err(|e| e.to_string()))
        .collect::<Result<_, _>>()?;
    let arms: Vec<Robot> =
        robots::all().into_iter().filter(|robot| matches!(robot.name, "heavy" | "ur10")).collect();
    for (words, prior) in [("none", PriorStrength::None), ("evidence", PriorStrength::Evidence)] {
        for (order, effects) in ORDERS.into_iter().zip([polynomial as fn(&Chain) -> _, reduced_first]) {
            let solver = SolverSpec::default();
            let strategy = Strategy {
                name: order.into(),
                effects,
                prior,
                solver,
                refine: true,
                second_reduction: true,
                rounds: 25,
            };
            let shown: Vec<Shown> = experiments
                .par_iter()
                .map(|e| couch(e, &strategy).map_err(|error| error.to_string()))
                .collect::<Result<_, _>>()?;
            let seconds = least(2, || experiments[0].fit(&strategy))?;
            line(&mut text, "pps", words, order, &shown, seconds)?;
        }
        for robot in &arms {
            let measured: Vec<Measured> = (0..PLANTS)
                .into_par_iter()
                .map(|seed| Measured::new(robot, 40 + 10 * seed).map_err(|e| e.to_string()))
                .collect::<Result<_, _>>()?;
            for order in ORDERS {
                let shown: Vec<Shown> = measured
                    .par_iter()
                    .map(|m| m.shown(order, prior).map_err(|error| error.to_string()))
                    .collect::<Result<_, _>>()?;
                let seconds = least(1, || measured[0].fit(order, prior))?;
                line(&mut text, robot.name, words, order, &shown, seconds)?;
            }
        }
    }
    finish("orders", &folder.join("table.txt"), &text)
}

fn line(
    text: &mut String,
    robot: &str,
    prior: &str,
    order: &str,
    shown: &[Shown],
    seconds: f64,
) -> std::fmt::Result {
    let mut errors: Vec<f64> = shown.iter().map(|s| 1e6 * s.error).collect();
    errors.sort_by(f64::total_cmp);
    let median = 0.5 * (errors[(errors.len() - 1) / 2] + errors[errors.len() / 2]);
    writeln!(
        text,
        "{robot:8} {prior:9} {order:13} {:>8} {:>6} {:>18} {:>7.0}",
        shown[0].columns,
        shown[0].rank,
        format!("{median:.1} [{:.1}]", errors[errors.len() - 1]),
        1e3 * seconds
    )?;
    print(text.lines().last().unwrap_or_default());
    Ok(())
}

/// The paper's experiment.
fn couch(experiment: &Experiment, strategy: &Strategy) -> Result<Shown, Box<dyn Error>> {
    let radii = experiment.identify(strategy)?;
    Ok(Shown { columns: radii.columns, rank: radii.rank, error: radii.noise_free })
}

/// An arm's measurements, and the visits that took no part.
struct Measured {
    plant: Plant,
    chain: Chain,
    used: Dataset,
    locked: Dataset,
}

impl Measured {
    fn new(robot: &Robot, seed: u64) -> Result<Self, Box<dyn Error>> {
        let plant = (robot.plant)(seed)?;
        let chain = robot.described(&plant)?;
        let campaign = Campaign::random(&chain, robot.visits, seed + 1)?.with_some_payload(
            robot.payloads,
            robot.com,
            0.02,
            seed + 2,
        );
        let data = plant.measure(&campaign, seed + 3)?;
        let (mut used, mut locked) = (Vec::new(), Vec::new());
        for (k, rows) in Visits::of(&data).rows.into_iter().enumerate() {
            if k % 4 == 3 { locked.extend(rows) } else { used.extend(rows) }
        }
        Ok(Measured { plant, chain, used: data.select(&used), locked: data.select(&locked) })
    }

    fn fit(&self, order: &str, prior: PriorStrength) -> Result<Fit, Box<dyn Error>> {
        let polynomial =
            json!({"degree": 1, "wrench": ["mx", "my", "mz"], "wrench_of": "frame", "order": order});
        let last = self.chain.tool_frame().0;
        let registry = EffectRegistry::builtin();
        let effects = vec![
            registry.build("geometric", json!({"frames": [0, last - 1, last]}), &self.chain)?,
            registry.build("polynomial", polynomial, &self.chain)?,
        ];
        let model = ErrorModel::new(self.chain.clone(), effects)?;
        let options = FitOptions { prior, max_iterations: 25, ..FitOptions::default() };
        Ok(fit(&model, &self.used, &PivotedQr::default(), &options)?)
    }

    fn shown(&self, order: &str, prior: PriorStrength) -> Result<Shown, Box<dyn Error>> {
        let fit = self.fit(order, prior)?;
        let mut predictor = fit.fitted.bind(&self.locked.schema)?;
        let mut squares = 0.0;
        for row in 0..self.locked.len() {
            let (conditions, target) = (self.locked.conditions(row), self.locked.target[row]);
            let predicted = predictor.predict(&conditions, target).translation;
            squares += (self.plant.true_position(&conditions, target)? - predicted).norm_squared();
        }
        Ok(Shown {
            columns: fit.fitted.coefficients().len(),
            rank: fit.reduction.rank(),
            error: (squares / self.locked.len() as f64).sqrt(),
        })
    }
}

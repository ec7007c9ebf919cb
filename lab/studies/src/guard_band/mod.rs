//! Do the one-sided 95 % bounds hold, on which verdicts with guard bands rest?
//!
//! `study guard-band [--robots N]` (2000). Each robot has constant errors, and is measured like this:
//!
//! * five poses, 30 cycles: AP_p, AP_x and AD against the true position of the robot, RP_l against the scatter of 20 000 cycles;
//! * 40 random poses, each twice, for a fit; at 20 further ones the true error of the fit against the uncertainty of its budget
//!   (`model parameters`), axis by axis.
//!
//! | figure | fraction of robots |
//! | --- | --- |
//! | conform | the true value is below the upper bound: what is said to conform at a limit does so with 95 % |
//! | not conform | the true value is above the lower bound |

use crate::prelude::*;
use truepose_acceptance::{Assessment, AssessmentOptions, Figure, assess, one_sided_factor};
use truepose_errormodel::Schema;
use truepose_simulate::PlantDescription;

/// Standard deviations of an axis: what the robot does differently each time, and the instrument; µm.
const REPEATABILITY: f64 = 20.0;
const INSTRUMENT: f64 = 10.0;
const CYCLES: usize = 30;
/// Cycles that stand for all.
const MANY: usize = 20_000;
/// The required range.
const WANTED: [f64; 2] = [0.94, 0.97];

/// How often bounds held, and of how many.
#[derive(Clone, Default)]
struct Held {
    name: &'static str,
    above: usize,
    below: usize,
    all: usize,
}

/// The options of the run.
#[derive(Parser)]
struct Options {
    #[arg(long, default_value_t = 2000)]
    robots: u64,
}

/// Runs the study.
pub fn run(arguments: &[String]) -> Outcome {
    let Options { robots } = parsed(arguments)?;
    let chain = samples::ur10();
    let scatter = scatter(&chain)?;
    let one = |seed| one(&chain, seed, scatter);
    let rows = (0..robots).into_par_iter().map(one).collect::<Outcome<Vec<Vec<Held>>>>()?;
    let mut total: Vec<Held> = rows.first().cloned().unwrap_or_default();
    for row in &rows[1..] {
        for (sum, one) in total.iter_mut().zip(row) {
            (sum.above, sum.below, sum.all) =
                (sum.above + one.above, sum.below + one.below, sum.all + one.all);
        }
    }
    let mut table = Table::columns("figure -28|conform 9|not conform 12|figures 9");
    for Held { name, above, below, all } in total {
        let share = |hits: usize| format!("{:.2} %", Fraction { hits, of: all }.percent());
        table.row(&[&name, &share(above), &share(below), &all]);
    }
    let [low, high] = WANTED.map(|share| 100.0 * share);
    let text = format!(
        "{robots} simulated robots, {CYCLES} cycles; one-sided 95 % bounds hold in (wanted: {low} to {high} %)\n{}",
        table.text()
    );
    finish("guard-band", &folder("guard-band")?.join("table.txt"), &text)
}

/// A robot with constant errors.
fn plant(chain: &Chain, seed: u64) -> Outcome<Plant> {
    let text = format!(
        "[errors.geometric]\nposition_mm = 0.4\nangle_mrad = 0.4\ntarget_mm = 0.1\n\
         [instrument]\nsd_um = {INSTRUMENT}\norientation_urad = 20\n[repeatability]\nsd_um = {REPEATABILITY}\n"
    );
    let PlantDescription { errors, shop, instrument, repeatability, .. } =
        PlantDescription::from_toml(&text)?;
    Ok(Plant::random(chain, &PlantOptions { errors, shop, instrument, repeatability }, seed)?)
}

/// Each posture of a campaign so many times, the tool's origin alone.
fn campaign(chain: &Chain, postures: usize, times: usize, seed: u64) -> Outcome<Campaign> {
    let mut campaign = Campaign::random(chain, postures, seed)?.repeated(times);
    campaign.targets = vec![None];
    Ok(campaign)
}

/// RP_l of very many cycles, m: the scatter is the same for all robots and poses.
fn scatter(chain: &Chain) -> Outcome<f64> {
    let data = plant(chain, 0)?.measure(&campaign(chain, 1, MANY, 1)?, 1)?;
    let found = assess(chain, None, &data, &AssessmentOptions::default())?;
    Ok(found.before.poses[0].pose.rp.value)
}

fn one(chain: &Chain, seed: u64, scatter: f64) -> Outcome<Vec<Held>> {
    let plant = plant(chain, seed)?;
    let poses = campaign(chain, 5, CYCLES, seed)?;
    let found = assess(chain, None, &plant.measure(&poses, seed)?, &AssessmentOptions::default())?;
    let to_base = chain.base().pose.inverse();
    let true_deviation = |pose: usize| -> Outcome<Vector3<f64>> {
        let at = Conditions::at(chain, &poses.visits[pose].joints);
        let nominal = chain.forward(&at.joints).translation;
        Ok(to_base.rotation * (plant.true_position(&at, None)? - nominal))
    };
    let truths: Vec<Vector3<f64>> = (0..5).map(true_deviation).collect::<Result<_, _>>()?;
    let mut rows = figures(&found, &truths, scatter);
    rows.push(budget(chain, &plant, seed)?);
    Ok(rows)
}

fn held(name: &'static str, all: impl Iterator<Item = (Figure, f64)>) -> Held {
    let mut held = Held { name, ..Held::default() };
    for (figure, truth) in all {
        held.above += usize::from(truth <= figure.bounds95[1]);
        held.below += usize::from(truth >= figure.bounds95[0]);
        held.all += 1;
    }
    held
}

fn figures(found: &Assessment, truths: &[Vector3<f64>], scatter: f64) -> Vec<Held> {
    let poses = &found.before.poses;
    let each = || poses.iter().zip(truths);
    let commanded = |k: usize| Vector3::from(poses[k].commanded);
    let distance = found.before.distances.iter().map(|(a, b, distance)| {
        let apart = commanded(*a) - commanded(*b);
        (distance.ad, (apart + truths[*a] - truths[*b]).norm() - apart.norm())
    });
    vec![
        held("AP_p", each().map(|(pose, truth)| (pose.pose.ap, truth.norm()))),
        held("AP_x", each().map(|(pose, truth)| (pose.pose.ap_axes[0], truth.x))),
        held("RP_l", poses.iter().map(|pose| (pose.pose.rp, scatter))),
        held("AD_p", distance),
    ]
}

/// The true error of a fit at poses that it has not seen, against the uncertainty from its coefficients.
fn budget(chain: &Chain, plant: &Plant, seed: u64) -> Outcome<Held> {
    let data = plant.measure(&campaign(chain, 40, 2, seed + 1_000_000)?, seed)?;
    let fitted = fitted(chain, &constant_errors(), &data, &FitOptions::default())?.fitted;
    let mut predictor = fitted.bind(&Schema::default())?;
    let mut held = Held { name: "budget: model parameters", ..Held::default() };
    for visit in &campaign(chain, 20, 1, seed + 2_000_000)?.visits {
        let at = Conditions::at(chain, &visit.joints);
        let (pose, spread) = predictor.with_covariance(&at, None);
        let error = plant.true_position(&at, None)? - pose.translation;
        for axis in 0..3 {
            let bound = one_sided_factor() * spread[(axis, axis)].max(0.0).sqrt();
            held.above += usize::from(error[axis] <= bound);
            held.below += usize::from(error[axis] >= -bound);
            held.all += 1;
        }
    }
    Ok(held)
}

//! A robot with everything declared that is wrong with it, and the numbers that its intervals should hold.
//!
//! | extra | in the plant | declared, with what is left free |
//! | --- | --- | --- |
//! | none | constant errors, a compliance in every joint | the same |
//! | gap | backlash by the direction of approach | `backlash` |
//! | ratio | one joint drags another | `coupling` |
//! | period | a mesh that is no sine, centred (side bands of one that is not are no part of what is declared) | `transmission`, three harmonics, its period |
//! | instant | a bump | `shift`, when |
//! | lag | a joint that follows the air late | `thermal`, its time constant |
//! | settling | a joint that comes to rest | `drift`, its time constant |
//! | flank | backlash by the direction of the load | `backlash`, the load on the flank |

use crate::discovery::robots::{self, Robot, Undeclared};
use crate::prelude::*;
use rand::seq::IndexedRandom;
use std::f64::consts::TAU;
use truepose_errormodel::effects::{
    Backlash, Coupling, Drift, Grows, Shift, Side, Spot, Thermal, Transmission,
};
use truepose_simulate::physics::curve::SmoothCurve;

/// Effects of a robot besides constant errors and joint compliance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Extra {
    None,
    Gap,
    Ratio,
    Period,
    Instant,
    Lag,
    Settling,
    Flank,
}

/// No turn errs by more, rad.
const LARGEST: f64 = 2e-3;

/// In turn; a third has nothing more.
const TURN: [Extra; 10] = {
    use Extra::*;
    [None, Gap, Ratio, None, Period, Instant, None, Lag, Settling, Flank]
};

impl Extra {
    /// Whether it leaves constant errors as they are: a mesh has a mean, a ratio a middle.
    fn keeps_constants(self) -> bool {
        !matches!(self, Extra::Period | Extra::Ratio)
    }
}

/// A robot, measured.
pub struct Made {
    pub robot: String,
    pub extra: Extra,
    pub plant: Plant,
    pub model: ErrorModel,
    pub campaign: Campaign,
    pub data: Dataset,
    /// True coefficients of the model's columns; NaN where they are no number of the plant.
    pub coefficients: Vec<f64>,
    /// The true shape parameter of the last effect.
    pub shape: Option<f64>,
    kind: &'static Robot,
}

/// The extra as it is declared, with its truth: of its columns and of its shape.
struct Declared {
    effect: Option<Box<dyn AnyEffect>>,
    coefficients: Vec<f64>,
    shape: Option<f64>,
}

/// Draws the robot of this seed.
pub fn make(seed: u64) -> Outcome<Made> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let extra = TURN[(seed % 10) as usize];
    let kinds = robots::all()?;
    let kind = &kinds[(seed / 10) as usize % kinds.len()];
    let chain = kind.chain()?;
    let visits = *[60, 90, 120].choose(&mut rng).unwrap_or(&90);
    let campaign = kind.campaign(&chain, visits, seed)?;
    let campaign = match rng.random_range(0..3) {
        // Half of the configurations a second time.
        0 => {
            let mut again = campaign.clone();
            again.visits.truncate(visits / 2);
            campaign.then(again)
        }
        _ => campaign,
    };
    let duration = campaign.duration_s();
    let mut options = kind.options(&chain, &Undeclared::default(), false, duration / 3600.0 + 0.02);
    let noise = *[1.0, 2.0, 4.0].choose(&mut rng).unwrap_or(&1.0);
    options.instrument.sd_um *= noise;
    options.instrument.transverse_um_per_m *= noise;
    options.repeatability.sd_um *= noise;
    options.instrument.states_sd = rng.random();
    // Between three and eight deviations of one row, where the joint moves it.
    let deviation = 1e-6 * options.instrument.sd_um.hypot(options.repeatability.sd_um);
    let size = deviation * (3.0 + 5.0 * rng.random::<f64>());
    let joint = match extra {
        Extra::Flank => loaded(&chain, &campaign)?,
        _ => (*chain.movable().choose(&mut rng).ok_or("no joint")?, 0.0),
    };
    // A joint that no load turns over lies on one flank for ever.
    let extra = if extra == Extra::Flank && joint.1 < 1.0 { Extra::Gap } else { extra };
    let reach = lever(&chain, &campaign, joint.0)?;
    let errors = &mut options.errors;
    let drawing = Drawing { chain: &chain, errors, rng: &mut rng, size, reach, duration, joint };
    let (declared, change) = drawing.extra(extra)?;
    let mut plant = Plant::random(&chain, &options, seed)?;
    let mut truth = plant.truth().clone();
    truth.changes.extend(change);
    for gear in truth.joints.iter_mut().flat_map(|joint| &mut joint.transmission) {
        if let TransmissionError::Mesh { runout, .. } = gear {
            *runout = 0.0;
        }
    }
    plant = plant.with_truth(truth)?;
    let mut effects = Undeclared::default().effects(&chain);
    let mut coefficients = constants(&plant, extra.keeps_constants());
    coefficients
        .extend(chain.movable().iter().map(|j| 1.0 / plant.truth().joints[j.index()].stiffness.drive));
    effects.extend(declared.effect);
    coefficients.extend(declared.coefficients);
    let model = ErrorModel::new(chain, effects)?;
    if model.columns().len() != coefficients.len() {
        return Err(format!("{} columns, {} truths", model.columns().len(), coefficients.len()).into());
    }
    let data = plant.measure(&campaign, seed + 17)?;
    Ok(Made {
        robot: kind.name.clone(),
        extra,
        plant,
        model,
        campaign,
        data,
        coefficients,
        shape: declared.shape,
        kind,
    })
}

impl Made {
    /// Other configurations over the same day, as many as requested and no fewer than were measured.
    pub fn fresh(&self, visits: usize, seed: u64) -> Outcome<Campaign> {
        let visits = visits.max(self.campaign.visits.len());
        let mut campaign = self.kind.campaign(self.model.chain(), visits, seed)?;
        campaign.visits.truncate(visits);
        campaign.visit_s = self.campaign.duration_s() / visits as f64;
        Ok(campaign)
    }
}

/// The true constant errors, in the order of the columns of `geometric`.
fn constants(plant: &Plant, kept: bool) -> Vec<f64> {
    let truth = plant.truth();
    let frames = truth.frames.iter().flatten().copied();
    let all = frames.chain(truth.targets.iter().flat_map(|t| [t.x, t.y, t.z]));
    all.map(|value| if kept { value } else { f64::NAN }).collect()
}

/// How far the first target moves a radian (or metre) of this joint, on the average.
fn lever(chain: &Chain, campaign: &Campaign, joint: JointId) -> Outcome<f64> {
    const STEP: f64 = 1e-5;
    let plant = Plant::perfect(chain)?;
    let k = chain.coordinate(joint).ok_or("a joint that does not move")?;
    let target = (!chain.targets().is_empty()).then_some(TargetId(0));
    let some: Vec<_> = campaign.visits.iter().take(40).collect();
    let mut sum = 0.0;
    for visit in &some {
        let mut at = Conditions::at(chain, &visit.joints);
        let before = plant.true_position(&at, target)?;
        at.joints[k] += STEP;
        sum += (plant.true_position(&at, target)? - before).norm() / STEP;
    }
    Ok((sum / some.len() as f64).max(1e-3))
}

/// The joint whose load swings most, and how far.
fn loaded(chain: &Chain, campaign: &Campaign) -> Outcome<(JointId, f64)> {
    let plant = Plant::perfect(chain)?;
    let mut range = vec![(f64::INFINITY, f64::NEG_INFINITY); chain.movable().len()];
    for visit in &campaign.visits {
        let at = Conditions::at(chain, &visit.joints).with_load(visit.load);
        for (range, load) in range.iter_mut().zip(plant.joint_loads(&at)?) {
            *range = (range.0.min(load), range.1.max(load));
        }
    }
    // A joint that is always loaded from one side never changes its flank.
    let swing = |(low, high): &(f64, f64)| (-low).min(*high).max(0.0);
    let (k, widest) =
        range.iter().enumerate().max_by(|a, b| swing(a.1).total_cmp(&swing(b.1))).ok_or("no joint")?;
    Ok((chain.movable()[k], swing(widest)))
}

struct Drawing<'a> {
    chain: &'a Chain,
    errors: &'a mut Flaws,
    rng: &'a mut ChaCha8Rng,
    /// m, and of a turn at this reach, m.
    size: f64,
    reach: f64,
    duration: f64,
    /// And its load, N·m or N.
    joint: (JointId, f64),
}

impl Drawing<'_> {
    /// Adds the extra effect to the plant and declares it; effects without a flaw are added to the plant afterwards.
    fn extra(self, extra: Extra) -> Outcome<(Declared, Option<Change>)> {
        let Drawing { chain, errors, rng, duration, joint: (joint, load), .. } = self;
        let (named, slide) = (name_of(chain, joint), slides(chain, joint));
        // A joint that hardly moves the point would have to err by tenths of a radian to be seen: no machine does, and no linear model holds.
        let size = if slide { self.size } else { (self.size / self.reach).min(LARGEST) };
        let milli = 1e3 * size;
        let mut between = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
        let mut change = None;
        let (effect, coefficients, shape): (Box<dyn AnyEffect>, Vec<f64>, Option<f64>) = match extra {
            Extra::None => {
                return Ok((Declared { effect: None, coefficients: Vec::new(), shape: None }, None));
            }
            Extra::Gap => {
                errors.backlash.push(backlash(named, slide, milli));
                (Box::new(Backlash::of(joint, Side::Approach)), vec![size], None)
            }
            Extra::Flank => {
                let flank = load * between(0.2, 0.5);
                let (side, flank_load) = (flaws::BacklashSide::Load, Some(flank));
                errors.backlash.push(flaws::Backlash { side, flank_load, ..backlash(named, slide, milli) });
                let flank_range = Some([0.02 * load, 2.0 * load]);
                let of = Backlash::of(joint, Side::Load);
                let effect = Backlash { flank_load: Some(0.5 * load), flank_range, ..of };
                (Box::new(effect), vec![size], Some(flank))
            }
            Extra::Ratio => {
                let others: Vec<JointId> = chain.movable().iter().copied().filter(|j| *j != joint).collect();
                let driver = *others.choose(rng).ok_or("one joint alone")?;
                errors.coupling.push(flaws::Dragging {
                    joint: named,
                    driver: name_of(chain, driver),
                    ratio_milli: milli,
                    eccentricity_mrad: 0.0,
                });
                (Box::new(Coupling::of(joint, driver)), vec![size], None)
            }
            Extra::Period => {
                let cycles = between(6.0, 60.0).round();
                let period = if slide { 0.010 } else { TAU / cycles };
                if slide {
                    let (lead_mm, amplitude_um) = (10.0, 1e3 * milli);
                    errors.lead_screw.push(flaws::LeadScrew { joint: named, lead_mm, amplitude_um });
                } else {
                    errors.transmission.push(gear(named, milli, Some(cycles)));
                }
                let period_range = Some([0.7 * period, 1.4 * period]);
                let of = Transmission::of(joint, 1.1 * period);
                let effect = Transmission { harmonics: vec![1, 2, 3], period_range, ..of };
                (Box::new(effect), vec![f64::NAN; 6], Some(period))
            }
            Extra::Instant => {
                let when_s = duration * between(0.15, 0.85);
                errors.shift.push(flaws::Shift { at: named, when_s, size_mm: milli, size_mrad: milli });
                let of = Shift::of(Spot::Joint(joint), 0.5 * duration);
                (Box::new(Shift { at_range: Some([0.0, duration]), ..of }), vec![size], Some(when_s))
            }
            Extra::Lag => {
                let lag_s = duration * between(0.05, 0.3);
                let (grows, per_kelvin) = (flaws::Growing::Motion, 1e6 * size);
                errors.thermal.push(flaws::Thermal { at: named, grows, per_kelvin, lag_s });
                let effect = Thermal {
                    grows: Some(Grows::Motion),
                    lag: Some(0.1 * duration),
                    lag_range: Some([0.005 * duration, duration]),
                    ..Thermal::of(Spot::Joint(joint), "temperature")
                };
                (Box::new(effect), vec![size], Some(lag_s))
            }
            Extra::Settling => {
                let constant = duration * between(0.1, 0.4);
                let step = duration / 500.0;
                let at_rest = |k: usize| -(-step * k as f64 / constant).exp_m1();
                let curve = SmoothCurve::through(0.0, step, (0..=510).map(at_rest).collect())?;
                let (mover, amount) = (Mover::Joint(joint.index(), size), Amount::Curve(curve));
                change = Some(Change { mover, amount });
                let time_constant_range = Some([0.02 * duration, 2.0 * duration]);
                let of = Drift::settling(Spot::Joint(joint), [0.0, duration], 0.2 * duration);
                (Box::new(Drift { time_constant_range, ..of }), vec![size], Some(constant))
            }
        };
        Ok((Declared { effect: Some(effect), coefficients, shape }, change))
    }
}

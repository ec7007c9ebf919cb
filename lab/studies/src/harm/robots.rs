//! One robot of this study: drawn from its number, measured, with blunders in its record; and the truth at other configurations.

use super::hidden::{HIDDEN, Hidden};
use super::makes::Make;
use super::spoil::{SPOILS, Spoil};
use super::unnamed::Unnamed;
use super::visits::{Region, STYLES, Style};
use crate::prelude::*;
use truepose_simulate::Task;
use truepose_simulate::flaws::Geometric;

/// Configurations at which a result is compared with the plant.
const FRESH: usize = 100;
/// Least and most poses that are measured.
const POSES: (f64, f64) = (15.0, 200.0);
const VISIT_S: f64 = 60.0;
/// Numbers of robots begin here, as seeds.
const SEED: u64 = 7000;
/// All combinations of the four lists in turn: 7 × 13 × 5 × 11. The locked half begins in their middle.
const TURN: u64 = 5005;

/// What a stream is for.
#[derive(Debug, Clone, Copy)]
pub enum Stream {
    Shape = 1,
    Place,
    Known,
    Visits,
    Hidden,
    Unnamed,
    Scatter,
    Seen,
    Spoil,
    Fresh,
}

impl Stream {
    pub fn draw(self, seed: u64) -> Draw {
        Draw::of(seed, self as u64)
    }
}

/// A robot, measured.
pub struct Robot {
    pub number: u64,
    pub make: Make,
    pub hidden: Hidden,
    pub style: Style,
    pub spoil: Spoil,
    /// As the verbs receive it.
    pub described: Chain,
    /// As the verbs receive it.
    pub data: Dataset,
    /// The record without what went wrong with it, where there is such a one.
    pub clean: Option<Dataset>,
    /// Rows at configurations that are not measured, with the true positions, free of noise, of the targets that were measured.
    pub truth: Dataset,
    /// Standard deviation of a measured coordinate, instrument and repeatability, m.
    pub noise: f64,
    pub poses: usize,
    plant: Plant,
    unnamed: Unnamed,
    fresh: Campaign,
    /// The target that is executed.
    pub executed: Option<TargetId>,
}

/// Even numbers are for development, odd ones are a test set.
pub fn locked(number: u64) -> bool {
    number % 2 == 1
}

pub fn seed(number: u64) -> u64 {
    SEED + number
}

impl Robot {
    /// The robot of this number.
    pub fn of(number: u64) -> Outcome<Self> {
        let turn = number / 2 + if locked(number) { TURN / 2 } else { 0 };
        let in_turn = |count: usize| turn as usize % count;
        let (make, hidden) = (Make::all()[in_turn(7)], HIDDEN[in_turn(13)]);
        let (style, spoil) = (STYLES[in_turn(5)], SPOILS[in_turn(11)]);
        let seed = seed(number);
        let draw = |stream: Stream| stream.draw(seed);

        let chain = placed(make, spoil, &mut draw(Stream::Shape), &mut draw(Stream::Place))?;
        let described = described(&chain, spoil, &mut draw(Stream::Known))?;
        let mut of_visits = draw(Stream::Visits);
        let region = Region::of(style, &chain, &mut of_visits);
        let count = of_visits.logarithmic(POSES.0, POSES.1).round() as usize;
        let masses = match (hidden.needs_loads() || of_visits.chance(0.5), make.class().payload) {
            (true, heaviest) => vec![0.0, 0.5 * heaviest, heaviest],
            (false, _) => Vec::new(),
        };
        let mut postures = region.measured(count, &mut of_visits);
        if of_visits.chance(0.3) {
            // Some poses a second time.
            let again = postures[..count / 10].to_vec();
            postures.extend(again);
        }
        if spoil == Spoil::Leverage {
            let place = of_visits.below(postures.len());
            postures[place] = region.far(&mut of_visits);
        }
        let seconds = VISIT_S * postures.len() as f64;
        let channels = channels(hidden, &mut of_visits);
        let campaign = campaign(postures, (&masses, make), VISIT_S, channels.clone(), &mut of_visits);

        let mut of_fresh = draw(Stream::Fresh);
        let postures = region.fresh(FRESH, &mut of_fresh);
        let fresh =
            self::campaign(postures, (&masses, make), seconds / FRESH as f64, channels, &mut of_fresh);

        let mut of_hidden = draw(Stream::Hidden);
        let options = options(make, &mut of_hidden);
        let noise = 1e-6 * options.instrument.sd_um.hypot(options.repeatability.sd_um);
        let mut options = PlantOptions { shop: shop(hidden, seconds, &mut of_hidden), ..options };
        hidden.install(&mut options.errors, (&chain, make), (seconds, &masses), &mut of_hidden);
        let plant = Plant::random(&chain, &options, seed)?;
        let unnamed = hidden.unnamed(&chain, noise, &mut draw(Stream::Unnamed));

        let mut scatter = draw(Stream::Scatter);
        let mut data = observed(&plant, &unnamed, &campaign, Some(&mut scatter), seed)?.0;
        unnamed.wander(&mut data, &mut scatter);
        let data = seen(&data, spoil, &mut draw(Stream::Seen));
        let clean = spoil.has_clean().then(|| Spoil::Nothing.spoiled(&data, &mut draw(Stream::Spoil)));
        let data = spoil.spoiled(&data, &mut draw(Stream::Spoil));
        let (mut truth, positions) = observed(&plant, &unnamed, &fresh, None, seed + 1)?;
        truth.position = positions.iter().map(|p| (*p).into()).collect();
        truth.position_sd.fill([f64::NAN; 3]);
        truth.orientation.fill(None);
        let measured: Vec<usize> =
            (0..truth.len()).filter(|&row| data.target.contains(&truth.target[row])).collect();
        let truth = truth.select(&measured);
        let executed = data.target.iter().copied().min_by_key(|t| t.map(|t| t.0)).flatten();
        Ok(Robot {
            number,
            make,
            hidden,
            style,
            spoil,
            described,
            data,
            clean,
            truth,
            noise,
            poses: campaign.visits.len(),
            plant,
            unnamed,
            fresh,
            executed,
        })
    }

    /// Conditions of the fresh configurations as the verbs receive them: rows of the executed target, one a configuration.
    pub fn requested(&self) -> Vec<usize> {
        (0..self.truth.len()).filter(|&row| self.truth.target[row] == self.executed).collect()
    }

    /// Where the executed target really ends when these joint values are commanded in place of the fresh configurations, m.
    pub fn ends(&self, commands: Vec<Vec<f64>>) -> Outcome<Vec<Vector3<f64>>> {
        let mut campaign = self.fresh.clone();
        for (visit, joints) in campaign.visits.iter_mut().zip(commands) {
            visit.joints = joints;
        }
        let targets = self.described.targets().len().max(1);
        let place = self.executed.map_or(0, |target| target.0);
        let (_, positions) = observed(&self.plant, &self.unnamed, &campaign, None, seed(self.number) + 1)?;
        Ok(positions.into_iter().skip(place).step_by(targets).collect())
    }
}

/// The robot with its base, tool and targets.
fn placed(make: Make, spoil: Spoil, shape: &mut Draw, place: &mut Draw) -> Outcome<Chain> {
    let reach = make.class().reach;
    let chain = make.chain(shape)?;
    let turn = if place.chance(0.8) { 0.05 } else { 1.5 };
    let rpy = [turn * place.normal(), turn * place.normal(), place.between(-3.0, 3.0)];
    let xyz = [0.0; 3].map(|_: f64| place.between(-2.0, 2.0));
    let base = known(Pose::from_xyz_rpy(xyz, rpy));
    let offset = [0.02, 0.02, 0.12].map(|share| share * reach * place.between(0.5, 1.5));
    let rpy = [0.0; 3].map(|_: f64| 0.5 * place.normal());
    let tool = known(Pose::from_xyz_rpy(offset, rpy));
    let count = [0, 1, 1, 2, 3, 3, 4, 5][place.below(8)].max(spoil.targets());
    let targets = (0..count)
        .map(|k| target(format!("T{}", k + 1), place.direction() * reach * place.between(0.04, 0.15)))
        .collect();
    Ok(chain.with_base(base)?.with_tool(tool)?.with_targets(targets)?)
}

/// The robot as its user describes it: what he does not know he leaves to the program.
fn described(chain: &Chain, spoil: Spoil, draw: &mut Draw) -> Outcome<Chain> {
    let unknown = |placed: &Placed| Placed { pose: Pose::IDENTITY, known: !placed.known };
    let (base_known, targets_known, tool_known) = (draw.chance(0.5), draw.chance(0.5), draw.chance(0.8));
    let base = if base_known { *chain.base() } else { unknown(chain.base()) };
    let count = chain.targets().len();
    // Unknown targets say where they are in the tool's frame, whatever that is.
    let tool = if tool_known || count > 0 && !targets_known { *chain.tool() } else { unknown(chain.tool()) };
    let target = |(k, target): (usize, &Target)| {
        let known = targets_known && !(spoil == Spoil::FewRows && k + 1 == count);
        let position = if known { target.position } else { Vector3::zeros() };
        Target { position, known, ..target.clone() }
    };
    let targets = chain.targets().iter().enumerate().map(target).collect();
    Ok(chain.clone().with_base(base)?.with_tool(tool)?.with_targets(targets)?)
}

/// Postures with their loads and directions of approach, on the clock.
fn campaign(
    postures: Vec<Vec<f64>>,
    (masses, make): (&[f64], Make),
    visit_s: f64,
    channels: Vec<ChannelPlan>,
    draw: &mut Draw,
) -> Campaign {
    let reach = make.class().reach;
    let mut approach = vec![0.0; postures.first().map_or(0, Vec::len)];
    let mut last: Option<Vec<f64>> = None;
    let mut visits = Vec::with_capacity(postures.len());
    for joints in postures {
        for (k, side) in approach.iter_mut().enumerate() {
            let step = last.as_ref().map_or(0.0, |last| joints[k] - last[k]);
            if step.abs() > 1e-9 {
                *side = step.signum();
            }
        }
        let load = if masses.is_empty() {
            Load::None
        } else {
            let com = Vector3::new(0.02, -0.01, 0.08) * reach;
            Load::Payload(Payload { mass: masses[draw.below(masses.len())], com })
        };
        visits.push(Visit {
            joints: joints.clone(),
            load,
            approach: Some(approach.clone()),
            task: Task::Positions,
        });
        last = Some(joints);
    }
    Campaign { visits, visit_s, row_s: 1.0, channels, ..Campaign::of(Vec::new()) }
}

fn channels(hidden: Hidden, draw: &mut Draw) -> Vec<ChannelPlan> {
    let heat = matches!(hidden, Hidden::Thermal | Hidden::Several);
    let mut channels = Vec::new();
    if draw.chance(if heat { 0.7 } else { 0.3 }) {
        channels.push(ChannelPlan::Air { name: "temperature".into(), sd: 0.05 });
    }
    if draw.chance(0.3) {
        let (name, unit) = ("humidity".into(), "%".into());
        channels.push(ChannelPlan::Distractor { name, unit, mean: 45.0, sd: 5.0 });
    }
    channels
}

fn shop(hidden: Hidden, seconds: f64, draw: &mut Draw) -> ShopDay {
    let heat = matches!(hidden, Hidden::Thermal | Hidden::Several);
    let rise_k = if heat { draw.between(3.0, 10.0) } else { draw.between(0.0, 2.0) };
    ShopDay { start_c: draw.between(18.0, 23.0), rise_k, wander_k: 0.7, hours: 1.05 * seconds / 3600.0 }
}

/// Constant errors, instrument and repeatability.
fn options(make: Make, draw: &mut Draw) -> PlantOptions {
    let geometric = Geometric {
        position_mm: draw.logarithmic(0.08, 1.0) * make.class().reach.min(1.0),
        angle_mrad: draw.logarithmic(0.15, 2.0),
        target_mm: draw.logarithmic(0.02, 0.3),
        frames: Vec::new(),
    };
    let instrument = InstrumentSize {
        sd_um: draw.logarithmic(10.0, 200.0),
        orientation_urad: draw.chance(0.3).then(|| draw.logarithmic(40.0, 400.0)),
        freedom: draw.chance(0.2).then_some(5.0),
        states_sd: draw.chance(0.3),
        ..InstrumentSize::default()
    };
    let repeatability =
        RepeatabilitySize { sd_um: draw.logarithmic(5.0, 50.0), rotation_urad: draw.between(0.0, 30.0) };
    PlantOptions {
        errors: Flaws { geometric: Some(geometric), ..Flaws::default() },
        instrument,
        repeatability,
        ..PlantOptions::default()
    }
}

/// Rows as they were written down, and the true position of each row's target, m.
type Observed = (Dataset, Vec<Vector3<f64>>);

/// A campaign as it was commanded and measured, with the true positions beside it.
fn observed(
    plant: &Plant,
    unnamed: &Unnamed,
    campaign: &Campaign,
    scatter: Option<&mut Draw>,
    seed: u64,
) -> Outcome<Observed> {
    let commanded: Vec<Vec<f64>> = campaign.visits.iter().map(|visit| visit.joints.clone()).collect();
    let mut performed = campaign.clone();
    for (visit, joints) in performed.visits.iter_mut().zip(unnamed.performed(&commanded, scatter)) {
        visit.joints = joints;
    }
    let mut seen = plant.observe(&performed, seed)?;
    for (k, column) in seen.data.joints.iter_mut().enumerate() {
        for (value, &visit) in column.iter_mut().zip(&seen.data.visit) {
            *value = commanded[visit][k];
        }
    }
    Ok((seen.data, seen.true_positions))
}

/// Which targets are measured at each pose: all of them, or some.
fn seen(data: &Dataset, spoil: Spoil, draw: &mut Draw) -> Dataset {
    let visits = truepose_errormodel::Visits::of(data).rows;
    if draw.chance(0.6) {
        return data.clone();
    }
    let least = spoil.targets().max(1);
    let rows: Vec<usize> = visits
        .iter()
        .flat_map(|rows| {
            let least = least.min(rows.len());
            let count = least + draw.below(rows.len() - least + 1);
            draw.some(count, rows.len()).into_iter().map(|k| rows[k])
        })
        .collect();
    data.select(&rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_a_robot() {
        for number in [0, 5, 12, 31] {
            let (a, b) = (Robot::of(number).expect("a robot"), Robot::of(number).expect("a robot"));
            // NaN is not itself: what was not measured is left out.
            assert_eq!((&a.data.joints, &a.data.target), (&b.data.joints, &b.data.target));
            assert_eq!(a.truth.position, b.truth.position);
            let finite = |data: &Dataset| data.position.iter().flatten().all(|v| v.is_finite());
            assert!(finite(&a.data) && finite(&a.truth));
            assert_ne!(a.truth.position, Robot::of(number + 2).expect("a robot").truth.position);
        }
    }

    #[test]
    fn truth_is_where_the_plant_ends_when_it_is_sent_there() {
        for number in 0..14 {
            let robot = Robot::of(number).expect("a robot");
            let requested = robot.requested();
            assert_eq!(requested.len(), FRESH);
            let commands = requested.iter().map(|&row| robot.truth.conditions(row).joints).collect();
            let ends = robot.ends(commands).expect("positions");
            for (&row, end) in requested.iter().zip(&ends) {
                assert!((robot.truth.measured_position(row) - end).norm() < 1e-12, "{number}");
            }
        }
    }

    #[test]
    fn every_kind_is_there_in_either_half() {
        for half in [false, true] {
            let numbers = (0..220).filter(|&n| locked(n) == half);
            let robots: Vec<Robot> = numbers.map(|n| Robot::of(n).expect("a robot")).collect();
            assert!(Make::all().iter().all(|make| robots.iter().any(|robot| robot.make == *make)));
            assert!(HIDDEN.iter().all(|hidden| robots.iter().any(|robot| robot.hidden == *hidden)));
            assert!(SPOILS.iter().all(|spoil| robots.iter().any(|robot| robot.spoil == *spoil)));
            assert!(STYLES.iter().all(|style| robots.iter().any(|robot| robot.style == *style)));
        }
    }
}

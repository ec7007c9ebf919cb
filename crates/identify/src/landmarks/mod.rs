//! Measurement without an instrument: one point touched again and again from many postures.
//!
//! ```text
//! 0 = l_k − p(q_i; c)           row i touched landmark k
//! |l_j − l_k| = d_jk            where the distance is known
//! ```
//!
//! A row says that its target was at the landmark, and where that is nobody knows: three unknowns a landmark, beside those of the robot. A
//! known distance fixes the scale; it is taken as exact and keeps one landmark on a sphere around the other. Directions on that sphere are
//! angles, in which the fit is not linear: it is made again with the landmarks where it has found them, until they rest. Where nothing says how
//! long anything is, a robot as small as a point would agree with every row: the distance between the two landmarks that are farthest apart is
//! held where the nominal robot has it.
//!
//! A row of another kind measured a number that depends on where its target was: the distance to an anchor, the height above a plane. Such rows are
//! linearised at the robot and the sensors as they are, fitted, and linearised anew until nothing moves.
//!
//! Where two points of the robot met ([`contacts`]), once, the place is eliminated: a row measured their difference.
//!
//! Where nothing outside of the robot was measured, its base has no place: errors of the base are left out, and the arm is described in the
//! frame of its base.

mod carried;
mod contacts;
mod found_in;
mod freed;
mod gauge;
mod hand_eye;
mod held_out;
mod planned;
mod prepared;
mod rounds;
mod sensors;
mod standing;
mod suspects;
mod ties;

pub(crate) use carried::mounted;
pub use contacts::{Contact, ContactRows};
pub use freed::Freed;
pub use held_out::{LandmarkFold, landmark_cross_validation};
pub(crate) use planned::PlannedRows;
pub use planned::unmeasured;
pub use sensors::{SensorFound, leverages, open_variances};
pub use suspects::{Suspect, allowed_for, suspects};

use crate::{FitOptions, IdentifyError, PriorStrength};
use found_in::found_in;
use hand_eye::with_base;
use nalgebra::Vector3;
use prepared::Prepared;
use rounds::{Rounds, State};
use std::collections::BTreeSet;
use ties::Structure;
use truepose_errormodel::effects::{AllTargets, Geometric, Landmarks, Observed, Where};
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel, FittedModel, Surroundings};
use truepose_kinematics::nalgebra::DMatrix;
use truepose_kinematics::{Chain, FrameId, Placed, Pose, Target, ToolId};
use truepose_solvers::Solver;

/// Rows and model of a campaign with landmarks, ready for every step of an identification.
#[derive(Debug, Clone)]
pub struct Touched {
    /// The rows: those that touched a landmark are measured where it was found, those that measured a number along their direction.
    pub data: Dataset,
    /// The robot; all known where nothing outside of it was measured.
    pub chain: Chain,
    /// The declared effects as far as they can be known, the landmarks and the unknowns of sensors.
    pub effects: Vec<Box<dyn AnyEffect>>,
    /// Landmarks of unknown place that were touched, by their number.
    pub names: Vec<String>,
    /// Where they were found, m, measurement frame.
    pub positions: Vec<Vector3<f64>>,
    /// Known distances that the fit keeps: which landmarks, m.
    pub distances: Vec<([usize; 2], f64)>,
    /// Where two points of the robot met.
    pub contacts: Vec<Contact>,
    /// Whether some row says how long anything is.
    pub has_scale: bool,
    /// What measured numbers: sensors, anchors, planes and spheres, by their number.
    pub sensors: Vec<SensorFound>,
    /// What these take as given.
    pub freed: Vec<Freed>,
    /// Of each row: the standstill of the robot in which it was taken. Rows that measured a number are pose measurements of their own in `data`.
    pub standstills: Vec<usize>,
    /// Whether the errors of the arm had to be held to their expected sizes while landmarks and sensors were found.
    pub arm_is_held: bool,
    /// What a user has to know, in sentences.
    pub remarks: Vec<String>,
}

impl Touched {
    /// What these rows are to be fitted with.
    pub fn options(&self, options: &FitOptions) -> FitOptions {
        let prior = if self.arm_is_held { HELD } else { options.prior };
        FitOptions { prior, ..options.clone() }
    }
}

/// The prior of an arm whose errors are held to their expected sizes.
const HELD: PriorStrength = PriorStrength::Fixed(1.0);

/// Makes measurements of the rows that touched landmarks, and of those that measured numbers. The landmark of a row counts in `surroundings`.
///
/// # Errors
/// [`IdentifyError::Landmark`] where one was observed too few times, or cannot be found, or where nothing holds the scale; what a fit refuses.
pub fn touched(
    chain: &Chain,
    effects: &[Box<dyn AnyEffect>],
    data: &Dataset,
    surroundings: &Surroundings,
    (solver, options): (&dyn Solver, &FitOptions),
) -> Result<Touched, IdentifyError> {
    data.validate(chain)?;
    let contacts = contacts::contacts(chain, data)?;
    let whole = (chain, data, surroundings);
    let frozen = arm_is_frozen(chain, effects);
    let mut prepared = Prepared::of(whole, &contacts, (&BTreeSet::new(), frozen))?;
    if prepared.scale_is_open && !contacts.is_empty() {
        // A distance between places is held, which contacts need a place for.
        let nominal = bare(chain)?;
        let at = contacts::places(chain, data, &contacts, |rows| sensors::poses(&nominal, rows))?;
        prepared = Prepared::of(whole, &contacts, (&contacts::spread(&at), frozen))?;
    }
    let Prepared { measured, outside, has_base, has_scale, by_targets, scale_is_open, .. } = prepared;
    let Prepared {
        mut data, surroundings, contacts, mut sensors, carried, mut structure, mut remarks, ..
    } = prepared;
    let described = chain;
    let mut chain = if outside { chain.clone() } else { all_known(chain)? };
    let mut declared = effects.to_vec();
    let left_out = |place: &Where| match place {
        Where::Frame(frame) => !has_base && *frame == FrameId::BASE,
        Where::Targets(_) => by_targets,
    };
    if !has_base || by_targets {
        declared = without(declared, &chain, &left_out);
    }
    if !outside {
        declared.extend(unknown_tool(described, &declared));
    }
    // With measured positions beside the landmarks the base may have to be found from these.
    let mut plain = data.clone();
    carried.set_targets(&chain, &mut plain, false);
    carried.set_targets(&chain, &mut data, true);
    let by_images = !carried.is_empty() && !measured && !chain.base().known;
    if !outside && carried.is_empty() && described.tools().len() == 1 && !described.tool().known {
        let at = sensors::poses(&bare(&chain)?, &plain)?;
        chain = standing::with_tool((&chain, &plain), &carried.images, &mut sensors, &at)?;
    }
    // Nothing places a tool that is not described: the camera's place on it takes that up.
    let images_only = !carried.is_empty() && !measured;
    let mut placed = if images_only { all_known(&chain)? } else { crate::place(&chain, &plain)?.chain };
    let mut poses = sensors::poses(&bare(&placed)?, &plain)?;
    if by_images {
        placed = with_base(&carried, &placed, &mut sensors, &poses)?;
        poses = sensors::poses(&bare(&placed)?, &plain)?;
    }
    sensors.start(&poses, &carried)?;
    let at = start(&poses, &data, structure.points.len(), &surroundings, &structure.declared);
    if scale_is_open {
        remarks.push(structure.hold_scale(&at).ok_or_else(|| alone(&structure, &remarks))?);
    }
    let length = chain.characteristic_length();
    let chain_seen = carried.with_targets(&placed, &poses)?;
    let effects = declared.clone();
    let start = State { data, sensors, structure, at, poses, chain: chain_seen, effects };
    let starting = start.poses.clone();
    let rounds = Rounds {
        declared: &declared,
        carried: &carried,
        contacts: &contacts,
        placed: &placed,
        plain: &plain,
        length,
    };
    let (state, held) = rounds.settled(start, solver, options)?;
    let arm_is_held = held.is_some();
    remarks.extend(held);
    let State { data, sensors, structure, at, poses, chain: seen, effects } = state;
    if !has_scale && contacts.is_empty() {
        same_size(&starting, &poses)?;
    }
    let names = structure.points.iter().map(|point| point.name.clone()).collect();
    let distances = structure.distances.clone();
    let freed = freed::freed(&sensors, &poses, &carried, length);
    let sensors = sensors.found;
    // What stands outside of the robot as described is the fit's to find.
    let chain = if carried.is_empty() { chain } else { seen };
    Ok(Touched {
        data,
        chain,
        effects,
        names,
        positions: at,
        distances,
        contacts,
        has_scale,
        sensors,
        freed,
        standstills: carried.images,
        arm_is_held,
        remarks,
    })
}

/// No robot is a tenth larger or smaller than it is described; one that came out so has shrunk towards a point in which all rows agree.
fn same_size(described: &[Pose], found: &[Pose]) -> Result<(), IdentifyError> {
    const LARGEST: f64 = 0.1;
    let spread = |poses: &[Pose]| {
        let middle =
            poses.iter().map(|pose| pose.translation).sum::<Vector3<f64>>() / poses.len().max(1) as f64;
        poses.iter().map(|pose| (pose.translation - middle).norm_squared()).sum::<f64>().sqrt()
    };
    let (before, after) = (spread(described), spread(found));
    if before > 0.0 && (after / before - 1.0).abs() <= LARGEST {
        return Ok(());
    }
    let why = format!(
        "the fit made the robot {:.2} times as large as it is described: these rows do not determine its scale; add a known distance, or check that rows name what they touched",
        after / before.max(f64::MIN_POSITIVE)
    );
    Err(IdentifyError::Observations { why })
}

/// The only landmark of a campaign that says nothing of lengths.
fn alone(structure: &Structure, remarks: &[String]) -> IdentifyError {
    let names: Vec<&str> = structure.points.iter().map(|point| point.name.as_str()).collect();
    let why = format!("a robot as small as a point would agree with every row: {}", remarks.join("; "));
    IdentifyError::Landmark { name: names.join(", "), why }
}

/// With fewer groups nothing but the rows of another landmark would be left to judge a landmark by: then rows are left out one by one.
const FEWEST_GROUPS: usize = 3;

/// The group of each landmark of a model, which known distances join, and behind these of each sensor; a sensor of which all is known has none, as its
/// rows share nothing that nobody knows. No groups at all without landmarks, or where there are sensors and too few groups to leave out whole ones.
pub fn landmark_groups(effects: &[Box<dyn AnyEffect>]) -> Option<Vec<Option<usize>>> {
    let landmarks = found_in::<Landmarks>(effects);
    let sensors = found_in::<Observed>(effects).map_or(&[][..], |observed| &observed.sensors);
    let mut groups: Vec<Option<usize>> = Vec::new();
    let next = |groups: &[Option<usize>]| groups.iter().flatten().max().map_or(0, |last| last + 1);
    for point in landmarks.iter().flat_map(|landmarks| &landmarks.points) {
        let known = point.tied.filter(|tied| !tied.held).map(|tied| groups[tied.to]);
        groups.push(known.unwrap_or_else(|| Some(next(&groups))));
    }
    for sensor in sensors {
        groups.push((!sensor.unknowns.is_empty()).then(|| next(&groups)));
    }
    let count = next(&groups);
    (count > 0 && (sensors.is_empty() || count >= FEWEST_GROUPS)).then_some(groups)
}

/// A robot without errors.
fn bare(chain: &Chain) -> Result<FittedModel, IdentifyError> {
    Ok(FittedModel::new(ErrorModel::new(chain.clone(), Vec::new())?, Vec::new(), DMatrix::zeros(0, 0))?)
}

/// The robot as described: nothing of it can be found.
fn all_known(chain: &Chain) -> Result<Chain, IdentifyError> {
    let known = |placed: &Placed| Placed { known: true, ..*placed };
    let targets = chain.targets().iter().map(|target| Target { known: true, ..target.clone() }).collect();
    let base = known(chain.base());
    let all =
        chain.clone().with_base(base).and_then(|c| c.map_tools(known)).and_then(|c| c.with_targets(targets));
    all.map_err(|error| IdentifyError::Landmark { name: "all".into(), why: error.to_string() })
}

/// Whether these effects change nothing but base, tools and targets.
fn arm_is_frozen(chain: &Chain, effects: &[Box<dyn AnyEffect>]) -> bool {
    let ends: Vec<FrameId> =
        (0..chain.tools().len()).map(|k| chain.frame_of_tool(ToolId(k))).chain([FrameId::BASE]).collect();
    let outside = |place: &Where| match place {
        Where::Frame(frame) => ends.contains(frame),
        Where::Targets(_) => true,
    };
    effects.iter().all(|effect| {
        let frames = effect.concrete::<Geometric>().and_then(|geometric| geometric.frames.as_ref());
        frames.is_some_and(|frames| frames.iter().all(outside))
    })
}

/// The effects without errors of some places.
fn without(
    effects: Vec<Box<dyn AnyEffect>>,
    chain: &Chain,
    left_out: &dyn Fn(&Where) -> bool,
) -> Vec<Box<dyn AnyEffect>> {
    let one = |effect: Box<dyn AnyEffect>| -> Option<Box<dyn AnyEffect>> {
        let Some(geometric) = effect.concrete::<Geometric>() else { return Some(effect) };
        let all = || {
            let targets = (!chain.targets().is_empty()).then_some(Where::Targets(AllTargets::All));
            chain.frames().map(Where::Frame).chain(targets).collect::<Vec<_>>()
        };
        let frames = geometric.frames.clone().unwrap_or_else(all);
        let frames: Vec<Where> = frames.into_iter().filter(|place| !left_out(place)).collect();
        (!frames.is_empty()).then(|| {
            let rest = Geometric { frames: Some(frames), components: geometric.components.clone() };
            Box::new(rest) as Box<dyn AnyEffect>
        })
    };
    effects.into_iter().filter_map(one).collect()
}

/// Errors of tool and targets, where these are described as unknown and no declared effect has them.
fn unknown_tool(described: &Chain, declared: &[Box<dyn AnyEffect>]) -> Option<Box<dyn AnyEffect>> {
    let has = |wanted: &dyn Fn(&Where) -> bool| {
        declared.iter().any(|effect| {
            let geometric = effect.concrete::<Geometric>();
            geometric.is_some_and(|of| of.frames.as_ref().is_none_or(|frames| frames.iter().any(wanted)))
        })
    };
    let mut missing = Vec::new();
    for (k, tool) in described.tools().iter().enumerate() {
        let frame = Where::Frame(described.frame_of_tool(ToolId(k)));
        if !tool.placed.known && !has(&|place| *place == frame) {
            missing.push(frame);
        }
    }
    let targets = described.targets().iter().any(|target| !target.known);
    if targets && !has(&|place| matches!(place, Where::Targets(_))) {
        missing.push(Where::Targets(AllTargets::All));
    }
    (!missing.is_empty()).then(|| {
        let errors = Geometric { frames: Some(missing), components: None };
        Box::new(errors) as Box<dyn AnyEffect>
    })
}

/// Where the nominal robot touches each landmark in the mean; where it is declared to be, if it is.
fn start(
    poses: &[Pose],
    data: &Dataset,
    points: usize,
    surroundings: &Surroundings,
    declared: &[usize],
) -> Vec<Vector3<f64>> {
    let mut sums = vec![(Vector3::zeros(), 0.0); points];
    for (row, pose) in poses.iter().enumerate() {
        if let Some(k) = data.landmark(row) {
            sums[k].0 += pose.translation;
            sums[k].1 += 1.0;
        }
    }
    let place = |(k, (sum, count)): (usize, &(Vector3<f64>, f64))| {
        surroundings.landmarks[declared[k]].position.unwrap_or(sum / *count)
    };
    sums.iter().enumerate().map(place).collect()
}

#[cfg(test)]
mod contact_tests;
#[cfg(test)]
mod plane_tests;
#[cfg(test)]
mod suspect_tests;
#[cfg(test)]
pub(crate) mod tests;

//! The command that brings the real robot to a pose (method, Figure 2).
//!
//! ```text
//! find q with  f_real(q, ε(q, s)) = X_d,   lower ≤ q ≤ upper
//!
//! seed ──► exact model ──────────────────────────────► ok
//! none, or stuck: nearest starts ──► nominal robot ──► exact model ──► ok
//! stuck again: without limits ──► reached? limit : unreachable
//! ```
//!
//! Every `ok` was held against the exact model at the command that is returned. The same question has the same answer to
//! the last bit: nothing is carried over from one command to the next.

mod entry;
mod many;

use crate::CompensateError;
use crate::arm::{Arm, Reached};
use crate::command::{Command, Extrapolation, MOST, Status, Target, Values};
use crate::lanes::{Block, Kernel};
use crate::options::{Approach, CompensatorOptions};
use crate::position_first::walk_position_first;
use crate::real::RealArm;
use crate::search::{Ending, NominalArm, Robot, Walk, walk};
use crate::starts::Starts;
use crate::step::Limits;
use crate::task::{Columns, Gap, Task};
use nalgebra::Vector3;
use std::f64::consts::TAU;
use truepose_errormodel::{FittedModel, Schema, Signal};
use truepose_kinematics::pulp::Arch;
use truepose_kinematics::{Conditions, Pose, TargetId};

/// Rounds on the nominal robot from one start, and how near is near enough to go on with the exact model.
const NOMINAL_ROUNDS: usize = 60;
const NOMINAL_TOLERANCE: f64 = 1e-5;
const WORTH_A_TRY: f64 = 1e-3;
const NUDGE: f64 = 0.15;

/// Turns desired poses into commands for one robot. One for each thread; a clone is another one.
#[derive(Debug, Clone)]
pub struct Compensator<'m> {
    fitted: &'m FittedModel,
    options: CompensatorOptions,
    real: RealArm<'m>,
    nominal: Arm,
    starts: Starts,
    /// For models that can be asked for several commands at once.
    kernel: Option<Kernel>,
    /// Joint units per unit of the search.
    scale: [f64; MOST],
    limits: Limits,
    length: f64,
    conditions: Conditions,
    at: Reached,
    channels: Vec<String>,
    read: Vec<(Option<usize>, usize)>,
    /// Whether some effect reads the time.
    timed: bool,
}

impl<'m> Compensator<'m> {
    /// Ready for commands under conditions of this schema.
    ///
    /// # Errors
    /// When a signal that the model needs is missing, the robot has too many joints, or an option makes no sense.
    pub fn bind(
        fitted: &'m FittedModel,
        schema: &Schema,
        options: CompensatorOptions,
    ) -> Result<Self, CompensateError> {
        options.validate()?;
        let chain = fitted.chain();
        let n = chain.movable().len();
        if n > MOST {
            return Err(CompensateError::TooManyJoints { have: n, most: MOST });
        }
        let columns = fitted.model().columns().iter().zip(fitted.coefficients());
        if let Some((column, _)) = columns.into_iter().find(|(_, c)| !c.is_finite()) {
            return Err(CompensateError::NotFinite { name: column.name.clone() });
        }
        let real = RealArm::bind(fitted, schema)?;
        let (channels, read) = channels_read(fitted, schema);
        let timed = fitted.model().effects().iter().any(|effect| effect.needs().contains(&Signal::Time));
        if channels.len() > MOST {
            return Err(CompensateError::TooManyChannels { have: channels.len(), most: MOST });
        }
        let nominal = Arm::new(chain, &[], &[]);
        let length = chain.characteristic_length();
        let mut scale = [1.0; MOST];
        let mut limits = Limits::NONE;
        for (k, &joint) in chain.movable().iter().enumerate() {
            if nominal.slides(k) {
                scale[k] = length;
            }
            if let Some((lower, upper)) = chain.joint(joint).limits {
                (limits.lower[k], limits.upper[k]) = (lower / scale[k], upper / scale[k]);
            }
        }
        let conditions = Conditions {
            joints: vec![0.0; n],
            approach: vec![0.0; n],
            channels: vec![0.0; schema.channels.len()],
            ..Conditions::default()
        };
        let starts = Starts::new(&nominal, &limits, &scale);
        let at = Reached::nowhere();
        let kernel = Kernel::of(fitted, real.constant(), &scale, &limits, &options);
        Ok(Compensator {
            fitted,
            options,
            real,
            nominal,
            starts,
            kernel,
            scale,
            limits,
            length,
            conditions,
            at,
            channels,
            read,
            timed,
        })
    }

    /// On these registers, instead of the widest that the processor has: the same commands but for their last digits.
    pub fn on(mut self, arch: Arch) -> Self {
        self.kernel = self.kernel.map(|kernel| kernel.on(arch));
        self
    }

    /// The model.
    pub fn fitted(&self) -> &'m FittedModel {
        self.fitted
    }

    /// The channels that the model reads, in the order of [`Extrapolation::channels`].
    pub fn channels(&self) -> &[String] {
        &self.channels
    }

    /// The command for a desired pose under these conditions; their joints are not read. The search begins at the seed,
    /// and goes on elsewhere when it leads nowhere. Never allocates, never panics: what are no numbers, or has
    /// the wrong length, is answered with [`Status::NotConverged`].
    pub fn command(&mut self, target: &Target, conditions: &Conditions, seed: Option<&[f64]>) -> Command {
        let Some(task) = self.enter(target, conditions, seed) else {
            return self.refused(seed);
        };
        let seed = seed.map(|joints| self.seed(joints));
        let rotation_at_seed = match (target.orientation, &seed) {
            (None, Some(x)) => Some(self.turned(x, &task)),
            _ => None,
        };
        let follow = self.options.approach == Approach::FromSeed && seed.is_some();
        let mut start = seed;
        let mut rounds = 0;
        let mut approach_holds = true;
        let mut found;
        let mut tries = 0;
        loop {
            found = self.find(&task, start.as_ref(), rotation_at_seed.as_ref());
            rounds += found.walk.rounds;
            tries += 1;
            let Some(seed) = seed.filter(|_| follow) else { break };
            approach_holds = !self.sides_differ(&seed, &found.walk.x);
            if approach_holds || tries == 6 {
                break;
            }
            self.take_sides(&seed, &found.walk.x);
            if found.status == Status::Ok {
                start = Some(found.walk.x);
            }
        }
        self.answer(task.rotation.is_some(), &found.walk, found.status, rounds, approach_holds)
    }

    /// Where the real robot's target is under these conditions (joints included), and how the tool is turned: as
    /// `Predictor::predict`. None when the conditions do not fit the model or are no numbers.
    pub fn predict(&mut self, conditions: &Conditions, target: Option<TargetId>) -> Option<Pose> {
        let wanted = Target::at(Vector3::zeros()).of(target);
        let task = self.enter(&wanted, conditions, Some(&conditions.joints))?;
        self.conditions.joints.copy_from_slice(&conditions.joints);
        self.real.reach(&self.conditions, &mut self.at);
        Some(Pose::new(self.at.tool.rotation, self.at.tool.apply(&self.real.point(task.target))))
    }

    fn find(
        &mut self,
        task: &Task,
        seed: Option<&[f64; MOST]>,
        kept: Option<&nalgebra::Matrix3<f64>>,
    ) -> Found {
        let most = self.options.rounds;
        let limits = self.limits;
        let mut rounds = 0;
        let mut best: Option<Walk> = None;
        if let (Some(x), Some(rotation)) = (seed, kept) {
            // Position only: with the seed's orientation if that can be, else as near to it as it goes.
            let whole = Task { rotation: Some(*rotation), ..*task };
            let found = walk(&mut self.exact(), &whole, x, &limits, most);
            if found.ending == Ending::There {
                return Found::ok(found, rounds);
            }
            rounds += found.rounds;
            let ended = walk_position_first(&mut self.exact(), &whole, x, &limits, most);
            if ended.ending == Ending::There {
                return Found::ok(ended, rounds);
            }
            rounds += ended.rounds;
        }
        if let Some(found) = seed.and_then(|x| self.straight(task, x)) {
            return Found::ok(found, rounds);
        }
        if let Some(x) = seed {
            let found = walk(&mut self.exact(), task, x, &limits, most);
            if found.ending == Ending::There {
                return Found::ok(found, rounds);
            }
            rounds += found.rounds;
            best = Some(found);
        }
        let point = self.nominal_point(task.target);
        let nearest = self.starts.nearest(task, &point, self.options.starts.max(1));
        let rough = Task {
            position_tolerance: NOMINAL_TOLERANCE * self.length,
            orientation_tolerance: NOMINAL_TOLERANCE,
            ..*task
        };
        let mut nearest_nominal: Option<Walk> = None;
        let mut stuck = 0;
        for k in 0..self.options.starts {
            let Some(&start) = self.starts.start(&nearest, k).filter(|_| stuck < self.enough()) else {
                break;
            };
            let nominal = walk(&mut self.ideal(&point), &rough, &start, &limits, NOMINAL_ROUNDS);
            if nominal.gap.cost < WORTH_A_TRY {
                let found = walk(&mut self.exact(), task, &nominal.x, &limits, most);
                if found.ending == Ending::There {
                    return Found::ok(found, rounds);
                }
                rounds += found.rounds;
                stuck += usize::from(!self.at_a_limit(&found.x));
                best = nearer(best, found);
            } else {
                nearest_nominal = nearer(nearest_nominal, nominal);
            }
        }
        if best.is_none_or(|walk| walk.gap.cost.is_nan() || walk.gap.cost >= WORTH_A_TRY)
            && let Some(nominal) = nearest_nominal
        {
            let found = walk(&mut self.exact(), task, &nominal.x, &limits, most);
            if found.ending == Ending::There {
                return Found::ok(found, rounds);
            }
            rounds += found.rounds;
            best = nearer(best, found);
        }
        let Some(mut best) = best.or_else(|| {
            let start = self.starts.start(&nearest, 0).copied()?;
            Some(walk(&mut self.exact(), task, &start, &limits, most))
        }) else {
            return Found { walk: Walk::nowhere(), status: Status::NotConverged };
        };
        if task.rotation.is_some() && self.nominal.joints() < 6 {
            // Such a robot cannot have every orientation: the position comes first.
            let found = walk_position_first(&mut self.exact(), task, &best.x, &limits, most);
            rounds += found.rounds;
            if found.ending == Ending::There {
                best = found;
                if task.reached(&best.gap) {
                    return Found::ok(best, rounds);
                }
            }
        }
        // Near, but bent the wrong way: the same posture with one joint nudged.
        if best.gap.cost < WORTH_A_TRY {
            for k in 0..2 * self.nominal.joints() {
                let mut x = best.x;
                x[k / 2] += if k.is_multiple_of(2) { NUDGE } else { -NUDGE };
                let x = self.within(&x);
                let found = walk(&mut self.exact(), task, &x, &limits, most);
                if found.ending == Ending::There {
                    return Found::ok(found, rounds);
                }
                rounds += found.rounds;
            }
        }
        let mut stuck = 0;
        for k in 0..=self.options.starts {
            let start = if k == 0 { Some(best.x) } else { self.starts.start(&nearest, k - 1).copied() };
            let Some(start) = start.filter(|_| stuck < self.enough()) else { break };
            let nominal = walk(&mut self.ideal(&point), &rough, &start, &Limits::NONE, NOMINAL_ROUNDS);
            if nominal.gap.cost.is_nan() || nominal.gap.cost > WORTH_A_TRY {
                continue;
            }
            let free = walk(&mut self.exact(), task, &nominal.x, &Limits::NONE, most);
            rounds += free.rounds;
            if free.ending != Ending::There {
                stuck += 1;
                continue;
            }
            // The same posture a turn further may lie within the limits.
            let turned = self.within(&self.wrapped(&free.x));
            let inside = walk(&mut self.exact(), task, &turned, &limits, most);
            if inside.ending == Ending::There {
                return Found::ok(inside, rounds);
            }
            rounds += inside.rounds;
            best.rounds = rounds;
            return Found { walk: best, status: Status::Limit };
        }
        let status = if best.ending == Ending::GaveUp { Status::NotConverged } else { Status::Unreachable };
        best.rounds = rounds;
        Found { walk: best, status }
    }

    /// The straight way from a seed, as [`Compensator::commands`] takes it for several at once.
    fn straight(&mut self, task: &Task, seed: &[f64; MOST]) -> Option<Walk> {
        let kernel = self.kernel.as_ref()?;
        let mut block = Block::empty();
        let lane = block.push(task, &self.real.still_point(task.target), &self.conditions.load, seed)?;
        kernel.walk(&mut block);
        block.found(lane)
    }

    /// After so many exact walks that began where the nominal robot is there and got stuck, the pose is at the edge of
    /// what can be reached. A robot of fewer joints than six may have to try all its postures: each tilts otherwise.
    fn enough(&self) -> usize {
        if self.nominal.joints() < 6 { usize::MAX } else { 6 }
    }

    fn at_a_limit(&self, x: &[f64; MOST]) -> bool {
        (0..self.nominal.joints()).any(|k| x[k] <= self.limits.lower[k] || x[k] >= self.limits.upper[k])
    }

    fn answer(
        &self,
        turned: bool,
        walk: &Walk,
        status: Status,
        rounds: usize,
        approach_holds: bool,
    ) -> Command {
        let n = self.nominal.joints();
        let mut joints = Values::zeros(n);
        let mut approach = Values::zeros(n);
        for k in 0..n {
            joints[k] = self.joint(k, walk.x[k]);
            approach[k] = self.conditions.approach[k];
        }
        Command {
            joints,
            status,
            position_error: walk.gap.position(self.length),
            orientation_error: if turned { walk.gap.orientation() } else { 0.0 },
            rounds,
            extrapolation: Extrapolation::of(
                &self.fitted.domain,
                &joints,
                &self.conditions,
                &self.read,
                self.timed,
            ),
            approach,
            approach_holds,
        }
    }

    /// A joint's value; exactly its limit where x lies there.
    fn joint(&self, k: usize, x: f64) -> f64 {
        let chain = self.fitted.chain();
        let value = x * self.scale[k];
        chain.joint(chain.movable()[k]).limits.map_or(value, |(lower, upper)| value.clamp(lower, upper))
    }

    /// A seed in units of the search, whole turns off where that brings it within the limits.
    fn seed(&self, joints: &[f64]) -> [f64; MOST] {
        let mut x = [0.0; MOST];
        for (k, &q) in joints.iter().enumerate() {
            x[k] = q / self.scale[k];
        }
        self.within(&self.wrapped(&x))
    }

    fn within(&self, x: &[f64; MOST]) -> [f64; MOST] {
        let mut inside = *x;
        for (k, x) in inside.iter_mut().enumerate().take(self.nominal.joints()) {
            *x = x.clamp(self.limits.lower[k], self.limits.upper[k]);
        }
        inside
    }

    fn wrapped(&self, x: &[f64; MOST]) -> [f64; MOST] {
        let mut inside = *x;
        for (k, x) in inside.iter_mut().enumerate().take(self.nominal.joints()) {
            let (lower, upper) = (self.limits.lower[k], self.limits.upper[k]);
            if self.nominal.slides(k) || (*x >= lower && *x <= upper) {
                continue;
            }
            let goal = if *x < lower { lower } else { upper };
            let off = ((*x - goal) / TAU).abs().ceil() * TAU;
            *x = if *x < lower { *x + off } else { *x - off };
        }
        inside
    }

    fn nominal_point(&self, target: Option<TargetId>) -> Vector3<f64> {
        target.map_or(Vector3::zeros(), |t| self.fitted.chain().targets()[t.0].position)
    }

    fn turned(&mut self, x: &[f64; MOST], task: &Task) -> nalgebra::Matrix3<f64> {
        self.exact().send(x, task);
        self.at.tool.rotation
    }

    fn exact(&mut self) -> ExactArm<'_, 'm> {
        ExactArm {
            real: &mut self.real,
            slides: &self.nominal,
            conditions: &mut self.conditions,
            scale: &self.scale,
            at: &mut self.at,
        }
    }

    fn ideal(&mut self, point: &Vector3<f64>) -> NominalArm<'_> {
        NominalArm { arm: &self.nominal, point: *point, scale: &self.scale, at: &mut self.at }
    }
}

/// The end of a search.
struct Found {
    walk: Walk,
    status: Status,
}

impl Found {
    fn ok(mut walk: Walk, rounds: usize) -> Self {
        walk.rounds += rounds;
        Found { walk, status: Status::Ok }
    }
}

fn nearer(best: Option<Walk>, other: Walk) -> Option<Walk> {
    Some(match best {
        Some(walk) if walk.gap.cost <= other.gap.cost => walk,
        _ => other,
    })
}

/// The channels that some effect reads: names, and where they stand in the fit's domain and in the schema.
fn channels_read(fitted: &FittedModel, schema: &Schema) -> (Vec<String>, Vec<(Option<usize>, usize)>) {
    let mut names: Vec<String> = Vec::new();
    let mut read = Vec::new();
    for need in fitted.model().effects().iter().flat_map(|effect| effect.needs()) {
        if let Signal::Channel(name) = need
            && !names.contains(&name)
            && let Some(given) = schema.channel(&name)
        {
            read.push((fitted.channels.iter().position(|channel| channel.name == name), given));
            names.push(name);
        }
    }
    (names, read)
}

/// The exact model as a robot to walk with.
struct ExactArm<'a, 'm> {
    real: &'a mut RealArm<'m>,
    slides: &'a Arm,
    conditions: &'a mut Conditions,
    scale: &'a [f64; MOST],
    at: &'a mut Reached,
}

impl Robot for ExactArm<'_, '_> {
    fn send(&mut self, x: &[f64; MOST], task: &Task) -> Gap {
        for ((q, x), scale) in self.conditions.joints.iter_mut().zip(x).zip(self.scale) {
            *q = x * scale;
        }
        self.real.reach(self.conditions, self.at);
        task.gap(self.at, &self.real.point(task.target))
    }

    fn columns(&self, task: &Task, columns: &mut Columns) {
        task.columns(self.slides, self.at, columns);
    }

    fn joints(&self) -> usize {
        self.slides.joints()
    }
}

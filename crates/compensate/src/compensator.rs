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
//! Every `ok` is verified with the exact model at the command that is returned. Equal requests give equal commands to
//! the last bit: nothing is carried over from one command to the next.

mod beyond;
mod entry;
mod find;
mod many;
mod relative;
mod robots;
mod scale;

use crate::CompensateError;
use crate::arm::{Arm, Reached};
use crate::command::{Command, Extrapolation, MOST, Status, Target, Values};
use crate::lanes::Kernel;
use crate::options::{Approach, CompensatorOptions};
use crate::real::RealArm;
use crate::search::{Robot, Walk};
use crate::starts::Starts;
use crate::step::Limits;
use crate::task::Task;
use beyond::Beyond;
use nalgebra::Vector3;
use truepose_errormodel::{FittedModel, Schema, Signal};
use truepose_kinematics::pulp::Arch;
use truepose_kinematics::{Conditions, Pose, TargetId};

/// Turns desired poses into commands for one robot. One for each thread; a clone is another one.
#[derive(Debug, Clone)]
pub struct Compensator<'m> {
    fitted: &'m FittedModel,
    options: CompensatorOptions,
    real: RealArm<'m>,
    nominal: Arm,
    starts: Starts,
    /// For models that support batch evaluation.
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
    /// Of a model with findings.
    beyond: Option<Beyond<'m>>,
    /// Joints that a command does not move.
    stays: [bool; MOST],
    /// The other hand, where poses are in its axes.
    other: Option<RealArm<'m>>,
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
        let tool = options.tool;
        if tool.0 >= chain.tools().len() {
            let (value, need) = (tool.0 as f64, "the number of a tool of the robot");
            return Err(CompensateError::Option { option: "tool", value, need });
        }
        relative::can_hold(chain, &options.hold)?;
        let real = RealArm::bind(fitted, schema, tool)?;
        let (channels, read) = channels_read(fitted, schema);
        let timed = fitted.model().effects().iter().any(|effect| effect.needs().contains(&Signal::Time));
        if channels.len() > MOST {
            return Err(CompensateError::TooManyChannels { have: channels.len(), most: MOST });
        }
        let nominal = Arm::to_tool(chain, tool, &[], &[]);
        let length = chain.characteristic_length();
        let mut scale = [1.0; MOST];
        let mut limits = Limits::NONE;
        for (k, &joint) in chain.movable().iter().enumerate() {
            if nominal.slides(k) {
                scale[k] = length;
            }
            // Limits of a joint that follows another one are limits of that one.
            let narrowed = chain.followers().iter().any(|follower| follower.driver == k);
            let own = if narrowed { chain.controller_limits(joint) } else { chain.joint(joint).limits };
            if let Some((lower, upper)) = own.filter(|_| chain.is_commanded(k) && !options.hold.contains(&k))
            {
                (limits.lower[k], limits.upper[k]) = (lower / scale[k], upper / scale[k]);
            }
        }
        let conditions = Conditions {
            tool,
            joints: vec![0.0; n],
            approach: vec![0.0; n],
            channels: vec![0.0; schema.channels.len()],
            ..Conditions::default()
        };
        let starts = Starts::new(chain, &nominal, &limits, &scale);
        let at = Reached::nowhere();
        let beyond = Beyond::bind(fitted, schema, &options)?;
        let other = relative::other(fitted, schema, &options)?;
        let stays = relative::stays(chain, &options);
        let kernel = Kernel::of(fitted, real.constant(), &scale, &limits, &options)
            .filter(|_| chain.followers().is_empty() && other.is_none() && options.hold.is_empty());
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
            beyond,
            stays,
            other,
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
    /// and goes on elsewhere when it leads nowhere. Beyond the data of a fit with findings it falls back to the declared model, as predictions
    /// do. Never allocates, never panics: what are no numbers, or has the wrong length, is answered with [`Status::NotConverged`].
    pub fn command(&mut self, target: &Target, conditions: &Conditions, seed: Option<&[f64]>) -> Command {
        match self.options.relative_to {
            Some(_) => self.relative(target, conditions, seed),
            None => self.absolute(target, conditions, seed),
        }
    }

    fn absolute(&mut self, target: &Target, conditions: &Conditions, seed: Option<&[f64]>) -> Command {
        let found = self.found(target, conditions, seed);
        match &mut self.beyond {
            Some(beyond) => beyond.fallen_back(found, target, conditions),
            None => found,
        }
    }

    /// The command with every finding.
    fn found(&mut self, target: &Target, conditions: &Conditions, seed: Option<&[f64]>) -> Command {
        let held = self.options.hold.is_empty() || seed.is_some();
        let Some(task) = self.enter(target, conditions, seed).filter(|_| held) else {
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
            self.follow(&mut found.walk.x);
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
        if let Some(beyond) = &mut self.beyond {
            return Some(beyond.predict(conditions, target));
        }
        self.conditions.joints.copy_from_slice(&conditions.joints);
        self.real.reach(&self.conditions, &mut self.at);
        Some(Pose::new(self.at.tool.rotation, self.at.tool.apply(&self.real.point(task.target))))
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
        self.fitted.chain().follow(&mut joints);
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

    fn turned(&mut self, x: &[f64; MOST], task: &Task) -> nalgebra::Matrix3<f64> {
        self.exact().send(x, task);
        self.at.tool.rotation
    }
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

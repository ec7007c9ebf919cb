//! Frames and tools that were taught by touching points with the uncorrected robot: the robot's errors are in them.
//!
//! ```text
//! the controller's point   n_i = K⁻¹ · A(q_i) · G · X · 0          its frame  T(n)
//! where it really was      r_i = K⁻¹ · (B E_0)⁻¹ · f(q_i) · (tool E_tool)⁻¹ · G · X · 0
//! real frame               F_r = T(r) · T(n)⁻¹ · F                 real tool  X_r = X moved by t(r) − t(n)
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | f | tool of the measurements, with all errors | m | measurement |
//! | T | frame through three points | m | controller's base |
//! | t | tip that stays at one place, by least squares | m | controller's flange |
//!
//! K, G, A, B E_0, tool E_tool: see `correct`. F and X are those of the program: they have to agree with n.

use super::frames::{Frames, same, used};
use super::lean::{Lean, Seen, derivative};
use super::options::{CorrectOptions, Taught};
use super::outside::outside;
use super::signals::signals;
use super::three_points::Method;
use crate::ControllerError;
use crate::program::Program;
use crate::reference::Reference;
use truepose_compensate::installation_of;
use truepose_errormodel::{Coverage, FittedModel};
use truepose_kinematics::nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use truepose_kinematics::{Conditions, Pose, ToolId, rotation_vector};

/// The controller's frame has to agree with its points within this, m: joints with two decimals of a degree are 0.35 mm at 2 m.
const AGREES: f64 = 1e-3;

/// Corrections of taught frames and tools.
#[derive(Debug, Clone, Default)]
pub(super) struct Learned {
    frames: Vec<Frame>,
    tools: Vec<Tool>,
}

#[derive(Debug, Clone)]
struct Frame {
    name: String,
    /// `T(r) · T(n)⁻¹` in the controller's base.
    shift: Pose,
    order: Method,
    /// The touched points in the measurement frame.
    tips: Vec<Vector3<f64>>,
    leans: Vec<Lean>,
}

#[derive(Debug, Clone)]
struct Tool {
    name: String,
    /// `t(r) − t(n)` in the controller's flange.
    shift: Vector3<f64>,
    /// Of the tip in the controller's flange.
    lean: Lean,
}

/// The controller's flange where something was touched.
struct Flange {
    /// In the controller's base.
    nominal: Pose,
    real: Pose,
    /// The real one in the measurement frame.
    seen: Seen,
}

/// The robot that touched.
pub(super) struct Toucher<'a> {
    pub(super) fitted: &'a FittedModel,
    pub(super) options: &'a CorrectOptions,
    /// Its tool, where it branches.
    pub(super) hand: ToolId,
}

impl Learned {
    /// # Errors
    /// When points make no frame, do not agree with the program's, or are outside of the data of the fit.
    pub(super) fn new(programs: &[Program], toucher: &Toucher<'_>) -> Result<Learned, ControllerError> {
        let options = toucher.options;
        let sd = toucher.fitted.noise.position_sd;
        let mut learned = Learned::default();
        let uses = |which: usize, name: &str| {
            programs.iter().find(|program| used(program)[which].iter().any(|other| same(other, name)))
        };
        // Tools first: they may touch.
        for taught in &options.taught {
            if let Some(program) = uses(1, &taught.name) {
                let flanges = toucher.flanges(taught)?;
                let found = tool(&Frames::new(program, options)?, taught, &flanges, sd);
                learned.tools.push(found.map_err(about(taught))?);
            }
        }
        for taught in &options.taught {
            if let Some(program) = uses(0, &taught.name) {
                let flanges = toucher.flanges(taught)?;
                let frames = Frames::new(program, options)?;
                let found = learned.frame_of(&frames, program, taught, &flanges, sd);
                learned.frames.push(found.map_err(about(taught))?);
            }
        }
        Ok(learned)
    }

    /// Where a frame that the program has really is.
    pub(super) fn frame(&self, name: Option<&str>, stated: Pose) -> Pose {
        self.frame_named(name).map_or(stated, |frame| frame.shift * stated)
    }

    /// The tool that the robot really has.
    pub(super) fn tool(&self, name: Option<&str>, stated: Pose) -> Pose {
        let found = self.tool_named(name);
        found.map_or(stated, |tool| Pose::new(stated.rotation, stated.translation + tool.shift))
    }

    /// How a desired position (measurement frame) leans on the fit, of a point with this frame and tool, and with the controller's flange turned so; none: not at
    /// all.
    pub(super) fn lean(
        &self,
        (frame, tool): (Option<&str>, Option<&str>),
        desired: &Vector3<f64>,
        flange: &Matrix3<f64>,
    ) -> Option<Lean> {
        let (frame, tool) = (self.frame_named(frame), self.tool_named(tool));
        let columns = frame.map(|frame| &frame.leans[0]).or(tool.map(|tool| &tool.lean))?.rows.ncols();
        let mut lean = Lean::none(columns);
        if let Some(frame) = frame {
            let rest = frame.order.frame(&frame.tips).ok()?.inverse().apply(desired);
            for (k, input) in frame.leans.iter().enumerate() {
                let by = derivative(|step| {
                    let mut tips = frame.tips.clone();
                    tips[k] += step;
                    frame.order.frame(&tips).ok().map(|moved| moved.apply(&rest))
                });
                lean.add(&by?, input);
            }
        }
        if let Some(tool) = tool {
            // A tip farther out brings the flange back.
            lean.add(&-flange, &tool.lean);
        }
        Some(lean)
    }

    fn frame_named(&self, name: Option<&str>) -> Option<&Frame> {
        let name = name?;
        self.frames.iter().find(|frame| same(&frame.name, name))
    }

    fn tool_named(&self, name: Option<&str>) -> Option<&Tool> {
        let name = name?;
        self.tools.iter().find(|tool| same(&tool.name, name))
    }

    fn frame_of(
        &self,
        frames: &Frames<'_>,
        program: &Program,
        taught: &Taught,
        flanges: &[Flange],
        sd: f64,
    ) -> Result<Frame, String> {
        let stated = frames.frame(&Reference::Named(taught.name.clone()))?;
        let name = touching(program, taught)?;
        let reference = match name.as_deref() {
            Some("flange") | None => Reference::Identity,
            Some(name) => Reference::Named(name.into()),
        };
        let tool = frames.tool(&reference)?;
        let real = self.tool(name.as_deref(), tool);
        let nominal: Vec<Vector3<f64>> = flanges.iter().map(|at| (at.nominal * tool).translation).collect();
        let found: Vec<Vector3<f64>> = flanges.iter().map(|at| (at.real * real).translation).collect();
        let tips: Vec<Vector3<f64>> = flanges.iter().map(|at| (at.seen.pose * real).translation).collect();
        let order = Method::of(&taught.touched)?;
        for (role, place) in order.roles() {
            let at = stated.inverse().apply(&nominal[place]);
            let off = role.off(&at);
            if off > AGREES {
                let [x, y, z] = [at.x, at.y, at.z].map(|v| 1e3 * v);
                return Err(format!(
                    "line {}: the controller has this point {} at {x:.2}, {y:.2}, {z:.2} mm in the frame of the program, {:.2} mm from \
                     where it has to be: other joints, another frame, or another tool ({}) touched it (--taught NAME=FILE,TOOL)",
                    taught.touched[place].line,
                    role.words(),
                    1e3 * off,
                    name.as_deref().unwrap_or("none"),
                ));
            }
        }
        let shift = order.frame(&found)? * order.frame(&nominal)?.inverse();
        let lean = |(at, tip): (&Flange, &Vector3<f64>)| {
            let mut lean = at.seen.point(tip, sd);
            if let Some(tool) = self.tool_named(name.as_deref()) {
                lean.add(&at.seen.pose.rotation, &tool.lean);
            }
            lean
        };
        let leans = flanges.iter().zip(&tips).map(lean).collect();
        Ok(Frame { name: taught.name.clone(), shift, order, tips, leans })
    }
}

fn about(taught: &Taught) -> impl Fn(String) -> ControllerError + '_ {
    |words| ControllerError::Option(format!("--taught {}: {}: {words}", taught.name, taught.file))
}

impl Toucher<'_> {
    /// The controller's flanges at the joints at which something was touched.
    fn flanges(&self, taught: &Taught) -> Result<Vec<Flange>, ControllerError> {
        let (fitted, options) = (self.fitted, self.options);
        let chain = fitted.chain();
        let (schema, values) = signals(fitted, options)?;
        let mut coverage = Coverage::new(fitted, &schema)?;
        let mut predictor = fitted.bind(&schema)?;
        let installation = installation_of(fitted, self.hand)?;
        let tool = chain.tools()[self.hand.0].placed.pose;
        let (before, behind) = (options.controller_base.inverse(), options.controller_flange);
        let mut all = Vec::with_capacity(taught.touched.len());
        for touched in &taught.touched {
            let load = touched.load.unwrap_or(options.load);
            let mut conditions = Conditions::at(chain, &touched.joints).with_load(load);
            conditions.channels.clone_from(&values);
            conditions.tool = self.hand;
            let here = coverage.judge(&conditions, None);
            outside(fitted, &schema.channels, &conditions, &here.beyond)
                .map_err(|words| about(taught)(format!("line {}: {words}", touched.line)))?;
            let nominal =
                chain.base().pose.inverse() * chain.forward_to(self.hand, &touched.joints) * tool.inverse();
            let flange = here.pose * installation.tool.inverse();
            let real = before * installation.base.inverse() * flange * behind;
            let seen = Seen { pose: here.pose, rows: predictor.sensitivity(&conditions, None) };
            let seen = seen.moved(&(flange * behind));
            all.push(Flange { nominal: before * nominal * behind, real, seen });
        }
        Ok(all)
    }
}

/// The name of the tool that touched; none: no tool.
fn touching(program: &Program, taught: &Taught) -> Result<Option<String>, String> {
    if taught.tool.is_some() {
        return Ok(taught.tool.clone());
    }
    let mut found: Vec<Reference> = Vec::new();
    for point in program.points() {
        let crate::program::Value::Pose { frame: Reference::Named(name), tool, .. } = &point.value else {
            continue;
        };
        if same(program.definitions().last_name(name), &taught.name) && !found.contains(tool) {
            found.push(tool.clone());
        }
    }
    match &found[..] {
        [Reference::Identity] => Ok(None),
        [Reference::Named(name)] => Ok(Some(program.definitions().last_name(name).to_owned())),
        _ => Err(format!(
            "the points in {0} have no tool with a name, or several: name the tool that touched (--taught {0}=FILE,TOOL; flange for none)",
            taught.name
        )),
    }
}

/// Where the tip really is.
fn tool(frames: &Frames<'_>, taught: &Taught, flanges: &[Flange], sd: f64) -> Result<Tool, String> {
    let stated = frames.tool(&Reference::Named(taught.name.clone()))?.translation;
    let (nominal, scatter) = tip(flanges.iter().map(|at| at.nominal))?;
    let (real, _) = tip(flanges.iter().map(|at| at.real))?;
    let off = (nominal - stated).norm();
    // The controller's own method may weigh the points otherwise, by what the uncorrected robot misses.
    if off > AGREES.max(scatter) {
        let [x, y, z] = [nominal.x, nominal.y, nominal.z].map(|v| 1e3 * v);
        return Err(format!(
            "from these joints the controller has the tip at {x:.2}, {y:.2}, {z:.2} mm, {:.2} mm from the tool of the program: other \
             joints, or another tool",
            1e3 * off
        ));
    }
    let poses: Vec<Pose> = flanges.iter().map(|at| at.seen.pose).collect();
    let mut lean = Lean::none(flanges.first().map_or(0, |at| at.seen.rows.ncols()));
    for (k, at) in flanges.iter().enumerate() {
        let with = |moved: Pose| {
            let mut poses = poses.clone();
            poses[k] = moved;
            tip(poses.iter().copied()).ok().map(|(tip, _)| tip)
        };
        let place =
            derivative(|step| with(Pose::new(at.seen.pose.rotation, at.seen.pose.translation + step)));
        let turn = derivative(|step| {
            with(Pose::new(rotation_vector(step) * at.seen.pose.rotation, at.seen.pose.translation))
        });
        let (Some(place), Some(turn)) = (place, turn) else { continue };
        lean.add(&place, &at.seen.point(&at.seen.pose.translation, sd));
        lean.rows += turn * at.seen.turning();
    }
    Ok(Tool { name: taught.name.clone(), shift: real - nominal, lean })
}

/// The tip that is at one place in all postures, and the largest distance from there.
fn tip(flanges: impl Iterator<Item = Pose> + Clone) -> Result<(Vector3<f64>, f64), String> {
    let count = flanges.clone().count();
    if count < 3 {
        return Err(format!("a tool needs three postures at one tip and better four, and {count} are there"));
    }
    let mut left = DMatrix::zeros(3 * count, 6);
    let mut right = DVector::zeros(3 * count);
    for (k, flange) in flanges.clone().enumerate() {
        left.view_mut((3 * k, 0), (3, 3)).copy_from(&flange.rotation);
        left.view_mut((3 * k, 3), (3, 3)).copy_from(&-Matrix3::identity());
        right.rows_mut(3 * k, 3).copy_from(&-flange.translation);
    }
    let svd = left.svd(true, true);
    // Below this a tip 1 m long would be uncertain by more than ten times what the joints are.
    if svd.singular_values.min() < 0.1 {
        return Err("the postures differ too little in orientation to give the tip".into());
    }
    let found = svd.solve(&right, 0.0)?;
    let (tip, place) = (found.fixed_rows::<3>(0).into_owned(), found.fixed_rows::<3>(3).into_owned());
    let off = flanges.map(|flange| (flange.apply(&tip) - place).norm()).fold(0.0, f64::max);
    Ok((tip, off))
}

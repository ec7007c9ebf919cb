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
use super::options::{CorrectOptions, Taught, Touched};
use super::outside::outside;
use super::signals::signals;
use crate::ControllerError;
use crate::program::{Program, Reference};
use truepose_compensate::installation;
use truepose_errormodel::{Coverage, FittedModel};
use truepose_kinematics::nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use truepose_kinematics::{Conditions, Pose};

/// The controller's frame has to agree with its points within this, m: joints with two decimals of a degree are 0.35 mm at 2 m.
const AGREES: f64 = 1e-3;

/// Points that are nearer to each other than this make no axis, m.
const APART: f64 = 5e-3;

/// Corrections of taught frames and tools.
#[derive(Debug, Clone, Default)]
pub(super) struct Learned {
    /// `T(r) · T(n)⁻¹` in the controller's base.
    frames: Vec<(String, Pose)>,
    /// `t(r) − t(n)` in the controller's flange.
    tools: Vec<(String, Vector3<f64>)>,
}

/// Nominal and real place of something.
struct Both<T> {
    nominal: T,
    real: T,
}

impl Learned {
    /// # Errors
    /// When points make no frame, do not agree with the program's, or are outside of the data of the fit.
    pub(super) fn new(
        programs: &[Program],
        fitted: &FittedModel,
        options: &CorrectOptions,
    ) -> Result<Learned, ControllerError> {
        let mut learned = Learned::default();
        let uses = |which: usize, name: &str| {
            programs.iter().find(|program| used(program)[which].iter().any(|other| same(other, name)))
        };
        // Tools first: they may touch.
        for taught in &options.taught {
            if let Some(program) = uses(1, &taught.name) {
                let flanges = flanges(fitted, options, taught)?;
                let shift = tool(&Frames::new(program, options)?, taught, &flanges).map_err(about(taught))?;
                learned.tools.push((taught.name.clone(), shift));
            }
        }
        for taught in &options.taught {
            if let Some(program) = uses(0, &taught.name) {
                let flanges = flanges(fitted, options, taught)?;
                let frames = Frames::new(program, options)?;
                let shift = learned.frame_of(&frames, program, taught, &flanges).map_err(about(taught))?;
                learned.frames.push((taught.name.clone(), shift));
            }
        }
        Ok(learned)
    }

    /// Where a frame that the program has really is.
    pub(super) fn frame(&self, name: Option<&str>, stated: Pose) -> Pose {
        let found = self.frames.iter().find(|(other, _)| name.is_some_and(|name| same(other, name)));
        found.map_or(stated, |(_, shift)| *shift * stated)
    }

    /// The tool that the robot really has.
    pub(super) fn tool(&self, name: Option<&str>, stated: Pose) -> Pose {
        let found = self.tools.iter().find(|(other, _)| name.is_some_and(|name| same(other, name)));
        found.map_or(stated, |(_, shift)| Pose::new(stated.rotation, stated.translation + shift))
    }

    fn frame_of(
        &self,
        frames: &Frames<'_>,
        program: &Program,
        taught: &Taught,
        flanges: &[Both<Pose>],
    ) -> Result<Pose, String> {
        let stated = frames.frame(&Reference::Named(taught.name.clone()))?;
        let name = touching(program, taught)?;
        let reference = match name.as_deref() {
            Some("flange") | None => Reference::Identity,
            Some(name) => Reference::Named(name.into()),
        };
        let tool = frames.tool(&reference)?;
        let real = self.tool(name.as_deref(), tool);
        let tips = flanges
            .iter()
            .map(|at| Both { nominal: (at.nominal * tool).translation, real: (at.real * real).translation });
        let tips: Vec<Both<Vector3<f64>>> = tips.collect();
        let order = Method::of(&taught.touched)?;
        for (role, place) in order.roles() {
            let at = stated.inverse().apply(&tips[place].nominal);
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
        let of = |part: fn(&Both<Vector3<f64>>) -> Vector3<f64>| {
            order.frame(&tips.iter().map(part).collect::<Vec<_>>())
        };
        Ok(of(|tip| tip.real)? * of(|tip| tip.nominal)?.inverse())
    }
}

fn about(taught: &Taught) -> impl Fn(String) -> ControllerError + '_ {
    |words| ControllerError::Option(format!("--taught {}: {}: {words}", taught.name, taught.file))
}

/// Nominal and real flanges of the controller in its base.
fn flanges(
    fitted: &FittedModel,
    options: &CorrectOptions,
    taught: &Taught,
) -> Result<Vec<Both<Pose>>, ControllerError> {
    let chain = fitted.chain();
    let (schema, values) = signals(fitted, options)?;
    let mut coverage = Coverage::new(fitted, &schema)?;
    let installation = installation(fitted)?;
    let (before, behind) = (options.controller_base.inverse(), options.controller_flange);
    let mut all = Vec::with_capacity(taught.touched.len());
    for touched in &taught.touched {
        let load = touched.load.unwrap_or(options.load);
        let mut conditions = Conditions::at(chain, &touched.joints).with_load(load);
        conditions.channels.clone_from(&values);
        let here = coverage.judge(&conditions, None);
        outside(fitted, &schema.channels, &conditions, &here.beyond)
            .map_err(|words| about(taught)(format!("line {}: {words}", touched.line)))?;
        let nominal =
            chain.base().pose.inverse() * chain.forward(&touched.joints) * chain.tool().pose.inverse();
        let real = installation.base.inverse() * here.pose * installation.tool.inverse();
        all.push(Both { nominal: before * nominal * behind, real: before * real * behind });
    }
    Ok(all)
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

/// The place of a point in the three-point method.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Role {
    Origin,
    /// On the x axis, at positive x, or (ABB) anywhere.
    X(bool),
    /// In the half plane of positive y, or (ABB) on the y axis.
    Y(bool),
}

impl Role {
    /// How far a point in the frame is from where it has to be.
    fn off(self, at: &Vector3<f64>) -> f64 {
        match self {
            Role::Origin => at.norm(),
            Role::X(positive) => at.y.hypot(at.z).max(if positive { -at.x } else { 0.0 }),
            Role::Y(axis) => at.z.abs().max(-at.y).max(if axis { at.x.abs() } else { 0.0 }),
        }
    }

    fn words(self) -> &'static str {
        match self {
            Role::Origin => "(its origin)",
            Role::X(_) => "(on its x axis)",
            Role::Y(false) => "(in its x-y plane)",
            Role::Y(true) => "(on its y axis)",
        }
    }
}

/// How three points make a frame: their places in the list.
enum Method {
    Corner([usize; 3]),
    /// ABB: two on the x axis, one on the y axis.
    Axes([usize; 3]),
}

impl Method {
    fn of(touched: &[Touched]) -> Result<Method, String> {
        if touched.len() != 3 {
            return Err(format!(
                "three points make a frame (origin, x, xy), and {} are there",
                touched.len()
            ));
        }
        let find = |word: &str| touched.iter().position(|point| point.word.eq_ignore_ascii_case(word));
        let all = |words: [&str; 3]| Some([find(words[0])?, find(words[1])?, find(words[2])?]);
        if touched.iter().all(|point| point.word.is_empty()) {
            return Ok(Method::Corner([0, 1, 2]));
        }
        if let Some(order) = all(["origin", "x", "xy"]) {
            return Ok(Method::Corner(order));
        }
        all(["x1", "x2", "y1"]).map(Method::Axes).ok_or_else(|| {
            let words: Vec<&str> = touched.iter().map(|point| point.word.as_str()).collect();
            format!("its points are called {}; known are origin, x, xy and x1, x2, y1", words.join(", "))
        })
    }

    fn roles(&self) -> [(Role, usize); 3] {
        match *self {
            Method::Corner([o, x, xy]) => [(Role::Origin, o), (Role::X(true), x), (Role::Y(false), xy)],
            Method::Axes([a, b, y]) => [(Role::X(false), a), (Role::X(false), b), (Role::Y(true), y)],
        }
    }

    fn frame(&self, points: &[Vector3<f64>]) -> Result<Pose, String> {
        let (Method::Corner(order) | Method::Axes(order)) = *self;
        let [first, second, third] = order.map(|k| points[k]);
        let x = second - first;
        let along = x.normalize();
        let origin = match self {
            Method::Corner(_) => first,
            Method::Axes(_) => first + along * along.dot(&(third - first)),
        };
        let y = third - origin - along * along.dot(&(third - origin));
        if !(x.norm() > APART && y.norm() > APART) {
            return Err("its points are at one place or on one line".into());
        }
        let y = y.normalize();
        Ok(Pose::new(Matrix3::from_columns(&[along, y, along.cross(&y)]), origin))
    }
}

/// How far the tip really is from where the program has it, in the controller's flange.
fn tool(frames: &Frames<'_>, taught: &Taught, flanges: &[Both<Pose>]) -> Result<Vector3<f64>, String> {
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
    Ok(real - nominal)
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

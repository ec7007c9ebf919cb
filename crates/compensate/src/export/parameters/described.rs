//! A robot as its description has it, as a function of the numbers of that description.
//!
//! ```text
//! U_0 = base · pre_1,   U_k = post_k · pre_{k+1},   U_n = post_n · tool           from one motion to the next
//! ```
//!
//! | symbol | here | shape | unit | |
//! | --- | --- | --- | --- | --- |
//! | x | `values` | numbers | m, rad | changes: of θ, d, a, α and Hayati's β of a row, else a twist behind the described pose |
//! | U | [`Described::segments`] | pose | m | constants in front of, between and behind the motions, at q = 0 |

use super::super::geometry::split;
use nalgebra::{Unit, Vector3};
use truepose_errormodel::ErrorModel;
use truepose_kinematics::{Axis, Chain, FrameId, JointId, JointKind, Placement, Pose, Site, rotation_vector};

/// A part of a description: base, joint or tool.
#[derive(Debug, Clone, Copy)]
pub(super) enum Form {
    /// A pose; its six numbers are a twist behind it: x y z, then a rotation vector.
    Placed(Pose),
    /// θ, d, a, α, β of `Rz(θ) Tz(d) Tx(a) Rx(α) Ry(β)`.
    Dh([f64; 5]),
    /// θ, d, a, α, β of `Rx(α) Tx(a) Ry(β) Rz(θ) Tz(d)`.
    Mdh([f64; 5]),
    /// A joint that does not move: no numbers.
    Still(Pose),
}

impl Form {
    pub fn count(&self) -> usize {
        match self {
            Form::Placed(_) => 6,
            Form::Dh(_) | Form::Mdh(_) => 5,
            Form::Still(_) => 0,
        }
    }

    /// With changes of its numbers.
    pub fn pose(&self, by: &[f64]) -> Pose {
        let row = |nominal: &[f64; 5]| std::array::from_fn::<f64, 5, _>(|k| nominal[k] + by[k]);
        match self {
            Form::Still(pose) => *pose,
            Form::Placed(pose) => {
                *pose
                    * Pose::new(
                        rotation_vector(&Vector3::new(by[3], by[4], by[5])),
                        Vector3::new(by[0], by[1], by[2]),
                    )
            }
            Form::Dh(nominal) => {
                let [theta, d, a, alpha, beta] = row(nominal);
                Pose::rot(2, theta)
                    * Pose::trans(2, d)
                    * Pose::trans(0, a)
                    * Pose::rot(0, alpha)
                    * Pose::rot(1, beta)
            }
            Form::Mdh(nominal) => {
                let [theta, d, a, alpha, beta] = row(nominal);
                Pose::rot(0, alpha)
                    * Pose::trans(0, a)
                    * Pose::rot(1, beta)
                    * Pose::rot(2, theta)
                    * Pose::trans(2, d)
            }
        }
    }
}

/// Which numbers take up a change that several of them could: the first ones. As in the reduction of a fit: base, tool, motions of joints,
/// lengths, the rest; Hayati's parameter where nothing else does, and a base or tool of which the model has no errors last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Class {
    Base,
    Tool,
    Motion,
    Length,
    Angle,
    Hayati,
    Undeclared,
}

/// One number.
#[derive(Debug, Clone, Copy)]
pub(super) struct Number {
    pub class: Class,
    pub length: bool,
}

/// The description.
pub(super) struct Described<'a> {
    pub chain: &'a Chain,
    /// The base, the joints, the tool.
    pub parts: Vec<Form>,
    pub numbers: Vec<Number>,
    /// Where the numbers of each part begin.
    begins: Vec<usize>,
}

impl<'a> Described<'a> {
    /// `chain` is the robot of the model, as it is described or by origins.
    pub fn new(model: &ErrorModel, chain: &'a Chain) -> Self {
        let mut parts = vec![Form::Placed(chain.base().pose)];
        parts.extend(chain.joints().iter().map(|joint| match joint.placement {
            _ if !joint.moves() => Form::Still(joint.transform(0.0)),
            Placement::Dh { theta, d, a, alpha } => Form::Dh([theta, d, a, alpha, 0.0]),
            Placement::Mdh { alpha, a, theta, d } => Form::Mdh([theta, d, a, alpha, 0.0]),
            Placement::Origin { pose, .. } => Form::Placed(pose),
        }));
        parts.push(Form::Placed(chain.tool().pose));
        let (mut numbers, mut begins) = (Vec::new(), Vec::new());
        for (part, form) in parts.iter().enumerate() {
            begins.push(numbers.len());
            for index in 0..form.count() {
                let length = match form {
                    Form::Placed(_) => index < 3,
                    _ => index == 1 || index == 2,
                };
                let class = class(model, part, form, index, length);
                numbers.push(Number { class, length });
            }
        }
        Described { chain, parts, numbers, begins }
    }

    /// The numbers of one part.
    pub fn of<'v>(&self, part: usize, values: &'v [f64]) -> &'v [f64] {
        &values[self.begins[part]..self.begins[part] + self.parts[part].count()]
    }

    /// Place of a number in the list.
    pub fn place(&self, part: usize, index: usize) -> usize {
        self.begins[part] + index
    }

    /// The constants between motions with changes of all numbers.
    pub fn segments(&self, values: &[f64]) -> Vec<Pose> {
        let mut segments = Vec::new();
        let mut here = Pose::IDENTITY;
        let last = self.parts.len() - 1;
        for (part, form) in self.parts.iter().enumerate() {
            let pose = form.pose(self.of(part, values));
            match form {
                Form::Dh(_) => {
                    segments.push(here);
                    here = pose;
                }
                Form::Mdh(_) | Form::Placed(_) if part != 0 && part != last => {
                    segments.push(here * pose);
                    here = Pose::IDENTITY;
                }
                _ => here = here * pose,
            }
        }
        segments.push(here);
        segments
    }

    /// Kinds and axes of the motions between the segments.
    pub fn motions(&self) -> Vec<(JointKind, Unit<Vector3<f64>>)> {
        let of = |&joint: &JointId| (self.chain.joint(joint).kind, split(self.chain, joint).2);
        self.chain.movable().iter().map(of).collect()
    }
}

fn class(model: &ErrorModel, part: usize, form: &Form, index: usize, length: bool) -> Class {
    let chain = model.chain();
    let declared = |frame: FrameId| {
        model.columns().iter().any(|column| matches!(column.site, Some(Site::Frame(at, _)) if at == frame))
    };
    let joints = chain.joints().len();
    if part == 0 {
        return if declared(FrameId::BASE) { Class::Base } else { Class::Undeclared };
    }
    if part == joints + 1 {
        return if declared(chain.tool_frame()) { Class::Tool } else { Class::Undeclared };
    }
    let joint = JointId(part);
    let slides = chain.joint(joint).kind == JointKind::Prismatic;
    let moves = match form {
        Form::Placed(_) => {
            let axis = split(chain, joint).2;
            length == slides && axis[Axis::ALL[index].direction()].abs() > 1.0 - 1e-12
        }
        _ => index == usize::from(slides),
    };
    match (moves, length) {
        (true, _) => Class::Motion,
        (_, true) => Class::Length,
        _ if index == 4 && !matches!(form, Form::Placed(_)) => Class::Hayati,
        _ => Class::Angle,
    }
}

/// The constants between the motions of a robot of origins and axes.
pub(super) fn segments_of(chain: &Chain) -> Vec<Pose> {
    let mut segments = Vec::new();
    let mut here = chain.base().pose;
    for (k, joint) in chain.joints().iter().enumerate() {
        let (pre, post, _) = split(chain, JointId(k + 1));
        here = here * pre;
        if joint.moves() {
            segments.push(here);
            here = Pose::IDENTITY;
        }
        here = here * post;
    }
    segments.push(here * chain.tool().pose);
    segments
}

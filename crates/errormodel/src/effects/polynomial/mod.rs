//! The paper's ready-made model: every generalized error as a polynomial in its own joint, and in the load times the
//! joints that stand beyond it (Eq. 17 with its sparsity).
//!
//! ```text
//! ε_i = Σ_{a=0}^{d_i} c_a q_i^a  +  Σ_m Σ_{b=1}^{B} w_m^b ( c_{mb0} + Σ_{j>i} Σ_{a=1}^{d_j} c_{mbja} q_j^a )
//!       geometric: its own joint     elastic: the wrench that link i carries
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | d_i | `degree`, or `small_degree` of the joints in `small`, or `degrees` | |
//! | w_m, B | `wrench` (components), `wrench_degree`, measured where `wrench_of` says | N, N·m |
//!
//! **Where a joint's polynomial lives.** On the frame in which the joint's axis stands still: frame i with MDH and
//! origin + axis, frame i − 1 with standard DH, whose axis lies in front of `A_i`. The joints j > i are those that stand
//! beyond that frame. Each of them enters by its own powers; products of joints are `expansion`'s. Base, tool and targets
//! have no joint: declare them beside it with `geometric`.
//!
//! **When the elastic part holds.** The wrench on link i depends on the joints beyond it and on nothing else if w is what
//! a sensor measures in the tool's axes, or if the joints in front of the link do not turn it against gravity (the paper's
//! robot: three slides and a turn about the vertical). On any other arm gravity turns in frame i with the joints in
//! front: say `wrench_of = "frame"`, so that w is the computed wrench in the axes of frame i, or use `joint_compliance`
//! and `link_compliance`.
//!
//! **Two orders.** Every error gets its terms and the fit reduces what they make (`expand_first`), or, as in the paper, constant
//! errors are reduced first and each *grouped* error gets the union of its members' terms (`reduce_first`), which the fit then
//! reduces again. At the nominal robot the grouped errors span all that the others do; where the robot is bent by its errors,
//! columns that were dropped for good may have come to differ by a trifle. Which errors are grouped depends on what was measured: the fit
//! puts it into `groups`.

mod known;
mod term;

pub use term::WrenchComponent;

use super::checks::{bounded, frame_exists, joint_moves, refused};
use super::geometric::EXPECTED_ANGLE;
use super::spot::distinct;
use crate::lanes::{LaneEmission, LanePosture};
use crate::{AnyEffect, Column, Effect, Emission, MOST_UNKNOWNS, ModelError, UNBOUNDED};
use known::Known;
use serde::{Deserialize, Serialize};
use term::{Term, lives};
use truepose_kinematics::{Axis, Chain, FrameId, JointId, Posture, Site};

/// Which wrench the elastic part is a function of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WrenchOf {
    /// What the tool carries, at its origin and in its axes: the paper's sensor.
    #[default]
    Tool,
    /// What each frame carries, link weights included, in its own axes.
    Frame,
}

/// What comes first: the terms of every error, or the reduction to what can be told apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// Every error has its terms; the fit reduces the columns that they make.
    #[default]
    ExpandFirst,
    /// Constant errors are reduced, and each grouped error has the union of its members' terms.
    ReduceFirst,
}

/// A grouped error and the frames whose errors pass into it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GroupedError {
    /// The frame of the error that was kept.
    pub frame: FrameId,
    /// Its component.
    pub component: Axis,
    /// Frames of all members, its own first.
    pub of: Vec<FrameId>,
}

/// Eq. (17) with the paper's sparsity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Polynomial {
    /// Highest power of a joint.
    #[serde(default = "cubic")]
    pub degree: u32,
    /// Joints of small range.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub small: Vec<JointId>,
    /// Highest power of those.
    #[serde(default = "one")]
    pub small_degree: u32,
    /// Highest power of every movable joint, base to tip: in place of `degree` and `small`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub degrees: Option<Vec<u32>>,
    /// Components of the errors; all six when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub components: Option<Vec<Axis>>,
    /// Components of the wrench that the elastic part depends on; none leaves that part out.
    pub wrench: Vec<WrenchComponent>,
    /// Whose wrench.
    #[serde(default)]
    pub wrench_of: WrenchOf,
    /// Highest power of a wrench component.
    #[serde(default = "one")]
    pub wrench_degree: u32,
    /// What comes first.
    #[serde(default, skip_serializing_if = "is_default")]
    pub order: Order,
    /// With `reduce_first`: the grouped errors, once the measurements are known. Without them every error has its own terms.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub groups: Option<Vec<GroupedError>>,
}

fn is_default(order: &Order) -> bool {
    *order == Order::default()
}

fn cubic() -> u32 {
    3
}

fn one() -> u32 {
    1
}

const MAX_DEGREE: u32 = 12;

impl Polynomial {
    /// Of this degree in every joint, linear in these components of the tool's wrench.
    pub fn of(degree: u32, wrench: Vec<WrenchComponent>) -> Self {
        Polynomial {
            degree,
            small: Vec::new(),
            small_degree: one(),
            degrees: None,
            components: None,
            wrench,
            wrench_of: WrenchOf::Tool,
            wrench_degree: one(),
            order: Order::default(),
            groups: None,
        }
    }

    /// The polynomial that an effect is, if it is one.
    pub fn of_effect(effect: &dyn AnyEffect) -> Option<Self> {
        (effect.kind() == Self::FAMILY).then(|| serde_json::from_value(effect.parameters()).ok()).flatten()
    }

    /// The errors that have terms when each has its own, base to tip.
    pub fn errors(&self, chain: &Chain) -> Vec<(FrameId, Axis)> {
        let mut errors = Vec::new();
        self.for_each_place(chain, |place| {
            errors.extend(place.components.iter().map(|&axis| (place.frame, axis)))
        });
        errors
    }

    fn components(&self) -> &[Axis] {
        self.components.as_deref().unwrap_or(&Axis::ALL)
    }

    fn degree(&self, joint: JointId, chain: &Chain) -> u32 {
        let own = self.degrees.as_ref().zip(chain.coordinate(joint)).and_then(|(list, k)| list.get(k));
        match own {
            Some(&degree) => degree,
            None if self.small.contains(&joint) => self.small_degree,
            None => self.degree,
        }
    }

    /// Calls `each` for the terms that the errors of a place have; returns how many.
    fn for_each_term(&self, place: &Place<'_>, chain: &Chain, mut each: impl FnMut(usize, Term)) -> usize {
        let mut count = 0;
        let mut put = |term: Term| {
            each(count, term);
            count += 1;
        };
        let powers = |joint: JointId| (1..=self.degree(joint, chain)).map(move |a| Some((joint, a)));
        put(Term { joint: None, wrench: None });
        for &joint in chain.movable() {
            if place.of.iter().any(|&frame| lives(joint, frame, chain)) {
                powers(joint).for_each(|joint| put(Term { joint, wrench: None }));
            }
        }
        let mut elastic = |first: usize, whose: Option<FrameId>| {
            for &component in &self.wrench {
                for b in 1..=self.wrench_degree {
                    let wrench = Some((component, b, whose));
                    put(Term { joint: None, wrench });
                    for &beyond in chain.movable().iter().filter(|joint| joint.0 > first) {
                        powers(beyond).for_each(|joint| put(Term { joint, wrench }));
                    }
                }
            }
        };
        match self.wrench_of {
            WrenchOf::Tool => elastic(place.of.iter().map(|frame| frame.0).min().unwrap_or(0), None),
            WrenchOf::Frame => {
                place
                    .of
                    .iter()
                    .for_each(|&frame| elastic(frame.0, Some(frame).filter(|&f| f != place.frame)));
            }
        }
        count
    }

    /// Calls `each` for every frame that has a polynomial, or for every grouped error, base to tip.
    fn for_each_place(&self, chain: &Chain, mut each: impl FnMut(&Place<'_>)) {
        if let Some(groups) = &self.groups {
            for GroupedError { frame, component, of } in groups {
                each(&Place { frame: *frame, components: std::slice::from_ref(component), of });
            }
            return;
        }
        for frame in chain.frames() {
            if chain.movable().iter().any(|&joint| lives(joint, frame, chain)) {
                each(&Place { frame, components: self.components(), of: &[frame] });
            }
        }
    }
}

/// Errors that have the same terms: those of these frames.
struct Place<'a> {
    frame: FrameId,
    components: &'a [Axis],
    of: &'a [FrameId],
}

impl Effect for Polynomial {
    const FAMILY: &'static str = "polynomial";
    const ABOUT: &'static str =
        "Eq. (17) ready-made: each error by powers of its own joint, and of the load times the joints beyond";

    fn columns(&self, chain: &Chain) -> Vec<Column> {
        let length = chain.characteristic_length();
        let mut columns = Vec::new();
        self.for_each_place(chain, |place| {
            for &axis in place.components {
                let site = Site::Frame(place.frame, axis);
                let expected = if axis.is_rotation() { EXPECTED_ANGLE } else { EXPECTED_ANGLE * length };
                self.for_each_term(place, chain, |_, term| {
                    let (product, per, size) = term.words(chain);
                    let constant = product.is_empty();
                    let word = chain.site_word(site);
                    columns.push(Column {
                        name: if constant { word } else { format!("{word} · {product}") },
                        unit: match per.contains('*') {
                            _ if constant => axis.unit().into(),
                            true => format!("{}/({per})", axis.unit()),
                            false => format!("{}/{per}", axis.unit()),
                        },
                        scale: expected / size,
                        site: constant.then_some(site),
                        bounds: UNBOUNDED,
                    });
                });
            }
        });
        columns
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        let chain = at.chain();
        let numbers = |frame| {
            let wrench = at.wrench(frame);
            std::array::from_fn(|k| wrench.component(k))
        };
        let at_tool = numbers(chain.tool_frame());
        let mut first = 0;
        self.for_each_place(chain, |place| {
            let wrench = if self.wrench_of == WrenchOf::Tool { at_tool } else { numbers(place.frame) };
            let terms = self.for_each_term(place, chain, |_, _| {});
            self.for_each_term(place, chain, |k, term| {
                let value = term.value(&wrench, at);
                for (c, &axis) in place.components.iter().enumerate() {
                    out.push(first + c * terms + k, Site::Frame(place.frame, axis), value);
                }
            });
            first += place.components.len() * terms;
        });
    }

    fn eval_lanes(&self, at: &LanePosture<'_>, out: &mut LaneEmission) -> bool {
        let chain = at.chain();
        let mut known = Known::default();
        let mut first = 0;
        self.for_each_place(chain, |place| {
            let own = if self.wrench_of == WrenchOf::Tool { chain.tool_frame() } else { place.frame };
            let terms = self.for_each_term(place, chain, |_, _| {});
            self.for_each_term(place, chain, |k, term| {
                let value = known.value(term, own, at, out);
                for (c, &axis) in place.components.iter().enumerate() {
                    out.push(first + c * terms + k, Site::Frame(place.frame, axis), value);
                }
            });
            first += place.components.len() * terms;
        });
        true
    }

    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        let refuse = |reason: String| Err(refused(Self::FAMILY, reason));
        if let Some(list) = &self.components {
            distinct(Self::FAMILY, list)?;
        }
        self.small.iter().try_for_each(|&joint| joint_moves(Self::FAMILY, joint, chain))?;
        if let Some(list) = &self.degrees {
            let movable = chain.movable().len();
            if list.len() != movable {
                return refuse(format!("`degrees` has {} numbers for {movable} movable joints", list.len()));
            }
            if !self.small.is_empty() {
                return refuse("`degrees` and `small` say the same thing twice".into());
            }
        }
        let highest = self.degrees.iter().flatten().copied().chain([self.degree, self.small_degree]).max();
        if highest.unwrap_or(0) > MAX_DEGREE {
            return refuse(format!(
                "degrees above {MAX_DEGREE} are not supported: use splines (`expansion`)"
            ));
        }
        if !(1..=MAX_DEGREE).contains(&self.wrench_degree) {
            return refuse(format!("`wrench_degree` is 1 to {MAX_DEGREE}; an empty `wrench` leaves it out"));
        }
        if (0..self.wrench.len()).any(|k| self.wrench[..k].contains(&self.wrench[k])) {
            return refuse("a component stands twice in `wrench`".into());
        }
        for group in self.groups.iter().flatten() {
            group.of.iter().chain([&group.frame]).try_for_each(|&f| frame_exists(Self::FAMILY, f, chain))?;
            if group.of.is_empty() {
                return refuse("a group has no members".into());
            }
        }
        if self.groups.is_some() && self.order == Order::ExpandFirst {
            return refuse("`groups` belong to `order = \"reduce_first\"`".into());
        }
        let mut unknowns = 0;
        self.for_each_place(chain, |place| {
            if unknowns <= MOST_UNKNOWNS {
                unknowns += place.components.len() * self.for_each_term(place, chain, |_, _| {});
            }
        });
        bounded(Self::FAMILY, unknowns)
    }
}

#[cfg(test)]
mod tests;

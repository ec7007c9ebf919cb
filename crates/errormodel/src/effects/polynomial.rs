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

use super::geometric::EXPECTED_ANGLE;
use super::spot::distinct;
use super::{joint_moves, refused};
use crate::{Column, Effect, Emission, ModelError, UNBOUNDED};
use serde::{Deserialize, Serialize};
use truepose_kinematics::{Axis, Chain, FrameId, JointId, Posture, Site};

/// One of the six numbers of a wrench.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum WrenchComponent {
    /// Force along x, N.
    Fx,
    /// Force along y, N.
    Fy,
    /// Force along z, N.
    Fz,
    /// Moment about x, N·m.
    Mx,
    /// Moment about y, N·m.
    My,
    /// Moment about z, N·m.
    Mz,
}

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
}

fn cubic() -> u32 {
    3
}

fn one() -> u32 {
    1
}

/// One product of Eq. (17): powers of one joint and of one component of the wrench; power 0 is a constant.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Term {
    joint: Option<(JointId, u32)>,
    wrench: Option<(WrenchComponent, u32)>,
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
        }
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

    /// Calls `each` for the terms that every component of this frame has; returns how many.
    fn for_each_term(&self, frame: FrameId, chain: &Chain, mut each: impl FnMut(usize, Term)) -> usize {
        let mut count = 0;
        let mut put = |term: Term| {
            each(count, term);
            count += 1;
        };
        let powers = |joint: JointId| (1..=self.degree(joint, chain)).map(move |a| Some((joint, a)));
        put(Term { joint: None, wrench: None });
        for &joint in chain.movable().iter().filter(|&&joint| lives(joint, frame, chain)) {
            powers(joint).for_each(|joint| put(Term { joint, wrench: None }));
        }
        for &component in &self.wrench {
            for b in 1..=self.wrench_degree {
                let wrench = Some((component, b));
                put(Term { joint: None, wrench });
                for &beyond in chain.movable().iter().filter(|joint| joint.0 > frame.0) {
                    powers(beyond).for_each(|joint| put(Term { joint, wrench }));
                }
            }
        }
        count
    }

    /// Calls `each` for every frame that has a polynomial, base to tip.
    fn for_each_frame(&self, chain: &Chain, mut each: impl FnMut(FrameId)) {
        for frame in chain.frames() {
            if chain.movable().iter().any(|&joint| lives(joint, frame, chain)) {
                each(frame);
            }
        }
    }
}

/// True where this joint's own polynomial acts on this frame.
fn lives(joint: JointId, frame: FrameId, chain: &Chain) -> bool {
    chain.joint_motion(joint).is_some_and(|motion| motion.frame == frame)
}

impl WrenchComponent {
    fn index(self) -> usize {
        self as usize
    }

    fn word(self) -> &'static str {
        ["fx", "fy", "fz", "mx", "my", "mz"][self.index()]
    }

    /// Unit and a typical size.
    fn unit(self) -> (&'static str, f64) {
        if self.index() < 3 { ("N", 500.0) } else { ("(N*m)", 250.0) }
    }
}

impl Term {
    /// Name, unit and typical size of the product.
    fn words(self, chain: &Chain) -> (String, String, f64) {
        let mut factors = Vec::new();
        if let Some((joint, power)) = self.joint {
            let joint = chain.joint(joint);
            let size = match joint.limits {
                Some((lower, upper)) if lower < upper && (upper - lower).is_finite() => {
                    lower.abs().max(upper.abs())
                }
                _ => 1.0,
            };
            factors.push((joint.name.as_str(), joint.unit(), size, power));
        }
        if let Some((component, power)) = self.wrench {
            let (unit, size) = component.unit();
            factors.push((component.word(), unit, size, power));
        }
        let raised =
            |word: &str, power: u32| if power == 1 { word.into() } else { format!("{word}^{power}") };
        (
            factors.iter().map(|f| raised(f.0, f.3)).collect::<Vec<_>>().join("·"),
            factors.iter().map(|f| raised(f.1, f.3)).collect::<Vec<_>>().join("*"),
            factors.iter().map(|f| f.2.powi(f.3 as i32)).product(),
        )
    }

    fn value(self, wrench: &[f64; 6], at: &Posture<'_>) -> f64 {
        let joint = self.joint.map_or(1.0, |(joint, power)| at.joint(joint).powi(power as i32));
        joint * self.wrench.map_or(1.0, |(component, power)| wrench[component.index()].powi(power as i32))
    }
}

impl Effect for Polynomial {
    const KIND: &'static str = "polynomial";
    const ABOUT: &'static str =
        "Eq. (17) ready-made: each error by powers of its own joint, and of the load times the joints beyond";

    fn columns(&self, chain: &Chain) -> Vec<Column> {
        let length = chain.characteristic_length();
        let mut columns = Vec::new();
        self.for_each_frame(chain, |frame| {
            for &axis in self.components() {
                let site = Site::Frame(frame, axis);
                let expected = if axis.is_rotation() { EXPECTED_ANGLE } else { EXPECTED_ANGLE * length };
                self.for_each_term(frame, chain, |_, term| {
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
        let (chain, components) = (at.chain(), self.components());
        let numbers = |frame| {
            let wrench = at.wrench(frame);
            std::array::from_fn(|k| wrench.component(k))
        };
        let at_tool = numbers(chain.tool_frame());
        let mut first = 0;
        self.for_each_frame(chain, |frame| {
            let wrench = if self.wrench_of == WrenchOf::Tool { at_tool } else { numbers(frame) };
            let terms = self.for_each_term(frame, chain, |_, _| {});
            self.for_each_term(frame, chain, |k, term| {
                let value = term.value(&wrench, at);
                for (c, &axis) in components.iter().enumerate() {
                    out.push(first + c * terms + k, Site::Frame(frame, axis), value);
                }
            });
            first += components.len() * terms;
        });
    }

    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        let refuse = |reason: String| Err(refused(Self::KIND, reason));
        if let Some(list) = &self.components {
            distinct(Self::KIND, list)?;
        }
        self.small.iter().try_for_each(|&joint| joint_moves(Self::KIND, joint, chain))?;
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
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::{check_effect, emitted};
    use truepose_kinematics::nalgebra::vector;
    use truepose_kinematics::{Conditions, Load, Payload, samples};

    fn paper() -> Polynomial {
        Polynomial { small: vec![JointId(5), JointId(6)], ..Polynomial::of(3, vec![WrenchComponent::Fy]) }
    }

    #[test]
    fn conforms() {
        for chain in samples::all() {
            check_effect(&Polynomial::of(2, vec![]), &chain);
            let wrench = vec![WrenchComponent::Fz, WrenchComponent::Mx];
            for wrench_of in [WrenchOf::Tool, WrenchOf::Frame] {
                let components = Some(vec![Axis::Tz, Axis::Rx]);
                let of = Polynomial::of(2, wrench.clone());
                check_effect(&Polynomial { wrench_of, components, wrench_degree: 2, ..of }, &chain);
            }
        }
    }

    #[test]
    fn the_papers_robot_has_318_terms() {
        // Six components × (16 + 13 + 10 + 7 + 4 + 3): per joint a constant, its own powers, the load, and the load
        // times the powers of the joints beyond; cubic but for roll and pitch.
        let chain = samples::pps();
        let columns = Effect::columns(&paper(), &chain);
        assert_eq!(columns.len(), 318);
        let per_site = |word: &str| columns.iter().filter(|c| c.name.starts_with(word)).count();
        let counts: Vec<usize> =
            chain.joints().iter().map(|joint| per_site(&format!("rx@{}", joint.name))).collect();
        assert_eq!(counts, [16, 13, 10, 7, 4, 3]);
        let of_roll: Vec<&str> =
            columns.iter().filter(|c| c.name.starts_with("z@roll")).map(|c| c.name.as_str()).collect();
        assert_eq!(of_roll, ["z@roll", "z@roll · roll", "z@roll · fy", "z@roll · pitch·fy"]);
        let degrees = Some(vec![3, 3, 3, 3, 1, 1]);
        let same = Polynomial { degrees, small: Vec::new(), ..paper() };
        assert_eq!(Effect::columns(&same, &chain), columns);
    }

    #[test]
    fn with_standard_dh_a_joint_acts_on_the_frame_in_front_of_it() {
        let chain = samples::ur10();
        let columns = Effect::columns(&Polynomial::of(1, vec![WrenchComponent::Fz]), &chain);
        let at = |word: &str| -> Vec<&str> {
            columns.iter().map(|c| c.name.as_str()).filter(|name| name.starts_with(word)).collect()
        };
        assert_eq!(at("rz@j5"), ["rz@j5", "rz@j5 · j6", "rz@j5 · fz", "rz@j5 · j6·fz"]);
        assert_eq!(at("rz@base")[..2], ["rz@base", "rz@base · j1"]);
        assert!(at("rz@j6").is_empty());
    }

    #[test]
    fn names_and_values_belong_together() {
        let chain = samples::pps();
        let effect = Polynomial { wrench_degree: 2, ..paper() };
        let columns = Effect::columns(&effect, &chain);
        let q = [0.3, 0.1, -0.4, 0.6, 0.02, -0.03];
        let load = Load::Payload(Payload { mass: 70.0, com: vector![0.1, 0.05, -0.8] });
        let conditions = Conditions::at(&chain, &q).with_load(load);
        let tool = chain.forward(&q);
        let fy = (tool.rotation.transpose() * vector![0.0, -9.81 * 70.0, 0.0]).y;
        let entries = emitted(&effect, &chain, &conditions);
        assert_eq!(entries.len(), columns.len());
        let value = |name: &str| {
            let k = columns.iter().position(|c| c.name == name).unwrap();
            entries.iter().find(|e| e.column == k).unwrap().value
        };
        let checks = [
            ("x@d1 · d1^3", 0.3_f64.powi(3)),
            ("ry@d2 · fy", fy),
            ("ry@d2 · theta^2·fy^2", 0.36 * fy * fy),
            ("z@theta · pitch·fy", -0.03 * fy),
        ];
        for (name, expected) in checks {
            assert!((value(name) - expected).abs() < 1e-9 * expected.abs(), "{name}");
        }
    }
}

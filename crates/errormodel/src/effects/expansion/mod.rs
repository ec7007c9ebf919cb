//! The effect that is only data: a generalized error as a series in joints, wrench and channels (Eq. 17).
//!
//! ```text
//! ε_site(s) = Σ_k c_k · b_{k1}(u_1(s)) · b_{k2}(u_2(s)) · …
//! ```
//!
//! | symbol | here | meaning |
//! | --- | --- | --- |
//! | site | [`Place`] | one component of `E_i`, a target's coordinate, or a joint's own motion |
//! | u | [`Input`] | a joint, a component of the wrench that a frame carries, a joint's load, a channel, the time |
//! | b | [`Basis`] | powers, Fourier terms, Chebyshev polynomials, B-splines |
//!
//! The paper's Eq. (17) is the case of powers: `q_1^{a_1} … q_n^{a_n} w_m^b`.

mod basis;
mod factor;

pub use basis::Basis;
pub use factor::{Factor, Input};

use super::checks::{bounded, frame_exists, joint_exists, joint_moves, target_exists};
use super::geometric::EXPECTED_ANGLE;
use crate::lanes::{LaneEmission, LanePosture};
use crate::{Column, Effect, Emission, ModelError, Signal, UNBOUNDED};
use serde::{Deserialize, Serialize};
use truepose_kinematics::{Axis, Chain, FrameId, JointId, Posture, Site, TargetId};

/// Where the series acts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum Place {
    /// Components of one frame's `E_i`.
    Frame {
        /// The frame.
        frame: FrameId,
        /// Which of its six components.
        components: Vec<Axis>,
    },
    /// Coordinates of a target, in the tool's axes.
    Target {
        /// The target.
        target: TargetId,
        /// Which translations.
        components: Vec<Axis>,
    },
    /// The own motion of a joint, along or about its true axis.
    Motion {
        /// The joint.
        joint: JointId,
    },
}

/// A series: every component of the place times every product of one basis function of each factor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expansion {
    /// Where it acts.
    pub at: Place,
    /// What it is a function of; the empty product is the constant.
    #[serde(default)]
    pub factors: Vec<Factor>,
}

impl Expansion {
    fn places(&self) -> usize {
        match &self.at {
            Place::Frame { components, .. } | Place::Target { components, .. } => components.len(),
            Place::Motion { .. } => 1,
        }
    }

    fn products(&self) -> usize {
        self.factors.iter().map(|factor| factor.basis.len()).product()
    }

    /// Emits one product at every component of the place.
    fn put(&self, product: usize, value: f64, at: &Posture<'_>, out: &mut Emission) {
        let products = self.products();
        match &self.at {
            Place::Frame { frame, components } => {
                for (k, &axis) in components.iter().enumerate() {
                    out.push(k * products + product, Site::Frame(*frame, axis), value);
                }
            }
            Place::Target { target, components } => {
                for (k, &axis) in components.iter().enumerate() {
                    out.push(k * products + product, Site::Target(*target, axis), value);
                }
            }
            Place::Motion { joint } => {
                if let Some(motion) = at.chain().joint_motion(*joint) {
                    out.along(product, &motion, value);
                }
            }
        }
    }

    /// Runs through all products of one basis function a factor, the last factor fastest.
    fn walk(
        &self,
        depth: usize,
        signal: usize,
        product: usize,
        value: f64,
        at: &Posture<'_>,
        out: &mut Emission,
    ) {
        let Some(factor) = self.factors.get(depth) else {
            self.put(product, value, at, out);
            return;
        };
        let u = factor.of.value(at, signal);
        let next = signal + usize::from(factor.of.signal().is_some());
        let width = factor.basis.len();
        factor.basis.for_each(u, |index, b| {
            self.walk(depth + 1, next, product * width + index, value * b, at, out);
        });
    }

    /// Words of all products, in the order of the columns.
    fn product_words(&self, chain: &Chain) -> Vec<String> {
        let mut words = vec![String::new()];
        for factor in &self.factors {
            let input = factor.of.word(chain);
            words = words
                .iter()
                .flat_map(|head| {
                    factor.basis.words(&input).into_iter().map(move |tail| {
                        match (head.as_str(), tail.as_str()) {
                            ("", _) => tail,
                            (_, "") => head.clone(),
                            _ => format!("{head}·{tail}"),
                        }
                    })
                })
                .collect();
        }
        words
    }

    /// Units by which each product divides the site's unit.
    fn product_units(&self, chain: &Chain) -> Vec<String> {
        let mut units = vec![String::new()];
        for factor in &self.factors {
            let unit = factor.of.unit(chain);
            units = units
                .iter()
                .flat_map(|head| {
                    factor.basis.units(&unit).into_iter().map(move |tail| {
                        match (head.as_str(), tail.as_str()) {
                            ("", _) => tail,
                            (_, "") => head.clone(),
                            _ => format!("{head}*{tail}"),
                        }
                    })
                })
                .collect();
        }
        units
    }

    /// Sizes of the products at a typical posture: the expected coefficient is the expected error divided by it.
    fn product_sizes(&self, chain: &Chain) -> Vec<f64> {
        let mut sizes = vec![1.0];
        for factor in &self.factors {
            let typical = factor.of.typical(chain);
            let each = factor.basis.sizes(typical);
            sizes = sizes.iter().flat_map(|head| each.iter().map(move |tail| head * tail)).collect();
        }
        sizes
    }
}

impl Effect for Expansion {
    const FAMILY: &'static str = "expansion";
    const ABOUT: &'static str =
        "a generalized error as a series in joints, wrench, channels and time (Eq. 17)";

    fn load_dependent(&self) -> bool {
        self.factors.iter().any(|factor| matches!(factor.of, Input::Wrench { .. } | Input::Load(_)))
    }

    fn columns(&self, chain: &Chain) -> Vec<Column> {
        let (words, units, sizes) =
            (self.product_words(chain), self.product_units(chain), self.product_sizes(chain));
        let length = chain.characteristic_length();
        let mut columns = Vec::with_capacity(self.places() * words.len());
        let mut place = |word: &str, rotation: bool, site: Option<Site>| {
            let (unit, expected) =
                if rotation { ("rad", EXPECTED_ANGLE) } else { ("m", EXPECTED_ANGLE * length) };
            for ((product, per), size) in words.iter().zip(&units).zip(&sizes) {
                columns.push(Column {
                    name: if product.is_empty() { word.into() } else { format!("{word} · {product}") },
                    unit: match per.contains('*') {
                        _ if per.is_empty() => unit.into(),
                        true => format!("{unit}/({per})"),
                        false => format!("{unit}/{per}"),
                    },
                    scale: expected / size,
                    site: site.filter(|_| self.factors.is_empty()),
                    bounds: UNBOUNDED,
                });
            }
        };
        match &self.at {
            Place::Frame { frame, components } => {
                for &axis in components {
                    let site = Site::Frame(*frame, axis);
                    place(&chain.site_word(site), axis.is_rotation(), Some(site));
                }
            }
            Place::Target { target, components } => {
                for &axis in components {
                    let site = Site::Target(*target, axis);
                    place(&chain.site_word(site), false, Some(site));
                }
            }
            Place::Motion { joint } => {
                let rotation = chain.joint(*joint).unit() == "rad";
                let verb = if rotation { "turn" } else { "slide" };
                place(&format!("{verb}({})", chain.joint(*joint).name), rotation, None);
            }
        }
        columns
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        self.walk(0, 0, 0, 1.0, at, out);
    }

    fn eval_lanes(&self, at: &LanePosture<'_>, out: &mut LaneEmission) -> bool {
        let mut products = vec![LaneEmission::ONE];
        let mut signal = 0;
        for factor in &self.factors {
            let functions = factor.of_block(at, signal, out);
            signal += usize::from(factor.of.signal().is_some());
            products = products
                .iter()
                .flat_map(|&product| functions.iter().map(move |&function| (product, function)))
                .map(|(product, function)| out.product(product, function))
                .collect();
        }
        for (product, &value) in products.iter().enumerate() {
            let column = |k: usize| k * products.len() + product;
            match &self.at {
                Place::Frame { frame, components } => (components.iter().enumerate())
                    .for_each(|(k, &axis)| out.push(column(k), Site::Frame(*frame, axis), value)),
                Place::Target { target, components } => (components.iter().enumerate())
                    .for_each(|(k, &axis)| out.push(column(k), Site::Target(*target, axis), value)),
                Place::Motion { joint } => {
                    if let Some(motion) = at.chain().joint_motion(*joint) {
                        out.along(product, &motion, value);
                    }
                }
            }
        }
        true
    }

    fn needs(&self) -> Vec<Signal> {
        self.factors.iter().filter_map(|factor| factor.of.signal()).collect()
    }

    fn without_time(&self) -> Option<Box<dyn crate::AnyEffect>> {
        let of_time = self.factors.iter().all(|factor| matches!(factor.of, Input::Time));
        let constant = || Expansion { at: self.at.clone(), factors: Vec::new() };
        (of_time && !self.factors.is_empty()).then(|| Box::new(constant()) as Box<dyn crate::AnyEffect>)
    }

    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        match &self.at {
            Place::Frame { frame, .. } => frame_exists(Self::FAMILY, *frame, chain)?,
            Place::Target { target, .. } => target_exists(Self::FAMILY, *target, chain)?,
            Place::Motion { joint } => joint_moves(Self::FAMILY, *joint, chain)?,
        }
        let refuse = |reason: String| Err(ModelError::Parameters { kind: Self::FAMILY.into(), reason });
        if let Place::Target { components, .. } = &self.at
            && components.iter().any(|axis| axis.is_rotation())
        {
            return refuse("a target is a point: its components are x, y and z".into());
        }
        let products = self.factors.iter().fold(1, |n: usize, factor| n.saturating_mul(factor.basis.len()));
        bounded(Self::FAMILY, self.places().saturating_mul(products))?;
        for factor in &self.factors {
            match &factor.of {
                Input::Joint(joint) => joint_moves(Self::FAMILY, *joint, chain)?,
                Input::Load(joint) => joint_exists(Self::FAMILY, *joint, chain)?,
                Input::Wrench { frame, component } => {
                    frame_exists(Self::FAMILY, *frame, chain)?;
                    if *component > 5 {
                        return refuse(format!("a wrench has components 0 to 5, not {component}"));
                    }
                }
                Input::Approach(joint) => joint_moves(Self::FAMILY, *joint, chain)?,
                Input::Channel(_) | Input::Time => {}
            }
            if let Err(reason) = factor.basis.check() {
                return refuse(reason);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::check_effect;
    use truepose_kinematics::{Conditions, PostureBuffer, samples};

    fn polynomial() -> Expansion {
        serde_json::from_str(
            r#"{"at": {"frame": {"frame": 1, "components": ["x", "rz"]}},
                "factors": [{"of": {"joint": 2}, "basis": {"powers": [0, 1, 2]}},
                            {"of": {"wrench": {"frame": 7, "component": 1}}, "basis": {"powers": [0, 1]}}]}"#,
        )
        .unwrap()
    }

    #[test]
    fn conforms_with_every_basis() {
        let chain = samples::pps();
        check_effect(&polynomial(), &chain);
        let bases = [
            Basis::Powers(vec![1, 3]),
            Basis::Fourier { period: 0.2, harmonics: vec![1, 4] },
            Basis::Chebyshev { lower: -0.3, upper: 0.3, degrees: vec![0, 2, 3] },
            Basis::Spline { lower: -0.3, upper: 0.3, pieces: 4, degree: 3 },
        ];
        for basis in bases {
            let factors = vec![Factor { of: Input::Joint(JointId(2)), basis }];
            check_effect(&Expansion { at: Place::Motion { joint: JointId(4) }, factors }, &chain);
        }
    }

    #[test]
    fn products_are_in_the_order_of_their_names() {
        let chain = samples::pps();
        let effect = polynomial();
        let names: Vec<String> = Effect::columns(&effect, &chain).into_iter().map(|c| c.name).collect();
        assert_eq!(names[0], "x@d1");
        assert_eq!(names[1], "x@d1 · fy(tool)");
        assert_eq!(names[5], "x@d1 · d2^2·fy(tool)");
        assert_eq!(names[6], "rz@d1");

        let conditions = Conditions::at(&chain, &[0.1, 0.2, 0.3, 0.4, 0.0, 0.0]);
        let mut buffer = PostureBuffer::new(&chain);
        let posture = buffer.update(&chain, &conditions);
        let mut out = Emission::new();
        effect.eval(&posture, &mut out);
        let square = out.entries().iter().find(|entry| entry.column == 4).unwrap();
        assert!((square.value - 0.04).abs() < 1e-15);
    }
}

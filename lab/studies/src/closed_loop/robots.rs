//! The plants of `simulate`, each with the effects that its causes ask for: the words of a model file, in `robots.json`.
//!
//! The plants are not the model: compliances harden by their own equation, guideways are smooth random curves, wheels are eccentric by
//! exact geometry, teeth are no sines.

use crate::prelude::*;
use serde_json::Value;
use truepose_errormodel::effects::{Basis, Expansion, Factor, Input, Place};
use truepose_simulate::{SimulateError, robots};

/// A plant, with its model and its campaign.
#[derive(Deserialize)]
pub struct Robot {
    pub name: String,
    /// The declared effects; joints by name, `teeth` for the harmonics of so many teeth.
    effects: Vec<Value>,
    /// Frames, by number, that give in proportion to every component of the wrench that they carry.
    springs: Vec<usize>,
    /// Payloads, kg, and their centre of gravity in the tool frame, m.
    pub payloads: Vec<f64>,
    pub com: [f64; 3],
    /// Of a thermometer in the lead screw; none has no thermometer.
    screw_lag_s: Option<f64>,
    /// Configurations that are measured.
    pub visits: usize,
    /// How many times its repeatability the plant may deviate from the desired positions. 1.1 is the goal; what is above
    /// it is what this study found, held so that it grows no worse.
    pub within: f64,
}

/// All of them.
pub fn all() -> Outcome<Vec<Robot>> {
    Ok(serde_json::from_str(include_str!("robots.json"))?)
}

/// A plant, measured: every fourth pose measurement is a held-out one.
pub struct Measured {
    pub plant: Plant,
    pub chain: Chain,
    pub data: Dataset,
    /// Rows of the pose measurements that are fitted, and of each held-out one.
    pub used: Vec<usize>,
    pub held_out: Vec<Vec<usize>>,
}

/// Fraction of the pose measurements in the held-out test set: commanded, and compared with the intervals.
const HELD_OUT: usize = 4;

impl Robot {
    /// One of its kind, measured at so many configurations.
    pub fn measured(&self, seed: u64, visits: usize) -> Outcome<Measured> {
        let plant = self.plant(seed)?;
        let chain = described(&plant)?;
        let screw = |lag_s: f64| ChannelPlan::Body { name: "screw".into(), lag_s, sd: 0.05 };
        let campaign = Campaign::random(&chain, visits, seed + 1)?
            .with_some_payload(&self.payloads, self.com, 0.02, seed + 2)
            .with_channels(self.screw_lag_s.map(screw).into_iter().collect());
        let data = plant.measure(&campaign, seed + 3)?;
        let (mut used, mut held_out) = (Vec::new(), Vec::new());
        for (k, rows) in Visits::of(&data).rows.into_iter().enumerate() {
            if k % HELD_OUT == HELD_OUT - 1 { held_out.push(rows) } else { used.extend(rows) }
        }
        Ok(Measured { plant, chain, data, used, held_out })
    }

    fn plant(&self, seed: u64) -> Result<Plant, SimulateError> {
        match self.name.as_str() {
            "pps" => robots::pps_plant(seed),
            "heavy" => robots::heavy_plant(seed),
            "ur10" => robots::ur10_plant(seed),
            "7R" => robots::seven_plant(seed),
            "scara" => robots::scara_plant(seed),
            _ => robots::gantry_plant(seed),
        }
    }

    /// The declared model.
    pub fn model(&self, chain: &Chain) -> Outcome<ErrorModel> {
        let registry = EffectRegistry::builtin();
        let mut effects: Vec<Box<dyn AnyEffect>> = Vec::new();
        for words in &self.effects {
            let family = words["family"].as_str().unwrap_or_default();
            effects.push(registry.build(family, numbered(words.clone(), chain), chain)?);
        }
        for frame in self.springs.iter().copied().map(FrameId) {
            for (component, axis) in Axis::ALL.into_iter().enumerate() {
                let of = Input::Wrench { frame, component };
                effects.push(Box::new(Expansion {
                    at: Place::Frame { frame, components: vec![axis] },
                    factors: vec![Factor { of, basis: Basis::Powers(vec![1]) }],
                }));
            }
        }
        Ok(ErrorModel::new(chain.clone(), effects)?)
    }
}

/// The robot as the identification receives it: its description, with the weights that its maker publishes.
fn described(plant: &Plant) -> Outcome<Chain> {
    let joints = plant.chain().joints().iter().zip(&plant.truth().joints);
    let weighed = joints.map(|(joint, truth)| Joint { link: joint.link.or(truth.link), ..joint.clone() });
    with_joints(plant.chain(), weighed.collect())
}

/// Without the family, with numbers of joints in place of their names, and with the harmonics of a turn that teeth make: they are no
/// sines, and swell once a turn.
fn numbered(mut words: Value, chain: &Chain) -> Value {
    let number = |value: &mut Value| {
        if let Some(JointId(id)) = value.as_str().and_then(|name| chain.joint_named(name)) {
            *value = id.into();
        }
    };
    if let Some(map) = words.as_object_mut() {
        map.remove("family");
        if let Some(teeth) = map.remove("teeth").and_then(|teeth| teeth.as_u64()) {
            let harmonics = (1..=3).flat_map(|k| [k * teeth - 1, k * teeth, k * teeth + 1]);
            map.insert("harmonics".into(), harmonics.collect());
        }
        for (key, value) in map.iter_mut() {
            match (key.as_str(), value) {
                ("joint" | "driver", value) => number(value),
                ("joints", Value::Array(list)) => list.iter_mut().for_each(number),
                _ => {}
            }
        }
    }
    words
}

//! The robots of this study: their description, what is declared of them, how they are measured.
//!
//! The declared model is that of a null: constant errors of every frame and target, and one compliance per joint. The
//! compliances are those of real machines of the type.

use crate::prelude::*;
use truepose_errormodel::effects::{AllTargets, Where};

/// One kind of robot, of `robots.json`.
#[derive(Deserialize)]
pub struct Robot {
    pub name: String,
    /// Of every joint that moves, N·m/rad or N/m.
    pub stiffness: Vec<f64>,
    /// Constant errors, mm and mrad.
    pub constant: [f64; 2],
    /// Instrument and repeatability, µm; growth across the line of sight, µm/m.
    pub noise: [f64; 3],
    /// Of the orientation, µrad; none does not measure it.
    pub orientation: Option<f64>,
    /// kg.
    pub payloads: Vec<f64>,
    /// m, in the tool's frame.
    pub com: [f64; 3],
    /// Masses and centres of the links, kg and m, where the sample has none, and the reach of its frame of three reflectors, m.
    #[serde(default)]
    weights: Vec<(f64, [f64; 3])>,
    reflectors: Option<f64>,
}

/// All of them, for as long as the program runs.
pub fn all() -> Outcome<&'static [Robot]> {
    static ROBOTS: std::sync::OnceLock<Vec<Robot>> = std::sync::OnceLock::new();
    let read: Vec<Robot> = serde_json::from_str(include_str!("robots.json"))?;
    Ok(ROBOTS.get_or_init(|| read))
}

/// What is declared of a robot; what is hidden is left out of it.
#[derive(Debug, Clone, Default)]
pub struct Undeclared {
    /// A frame without constant errors.
    pub frame: Option<FrameId>,
    /// Targets are where they are declared.
    pub targets: bool,
    /// A joint without compliance.
    pub spring: Option<JointId>,
}

impl Undeclared {
    /// The declared effects.
    pub fn effects(&self, chain: &Chain) -> Vec<Box<dyn AnyEffect>> {
        let mut geometric = Geometric::default();
        if self.frame.is_some() || self.targets {
            let mut places: Vec<Where> =
                chain.frames().filter(|frame| Some(*frame) != self.frame).map(Where::Frame).collect();
            if !self.targets && !chain.targets().is_empty() {
                places.push(Where::Targets(AllTargets::All));
            }
            geometric.frames = Some(places);
        }
        let mut springs = JointCompliance::default();
        if self.spring.is_some() {
            let others = chain.movable().iter().copied().filter(|joint| Some(*joint) != self.spring);
            springs.joints = Some(others.collect());
        }
        vec![Box::new(geometric), Box::new(springs)]
    }
}

impl Robot {
    /// The robot as it is described.
    pub fn chain(&self) -> Outcome<Chain> {
        let chain = match self.name.as_str() {
            "ur10" => samples::ur10(),
            "heavy" => samples::heavy(),
            "pps" => samples::pps(),
            "gantry" => truepose_simulate::robots::gantry()?,
            "scara" => samples::scara(),
            _ => samples::seven(),
        };
        let Some(reach) = self.reflectors else { return Ok(chain) };
        let weighed = chain.joints().iter().zip(&self.weights);
        let joints = weighed.map(|(joint, (mass, com))| joint.clone().with_link(*mass, *com)).collect();
        let places =
            [("R1", [1.0, 0.1, 0.5]), ("R2", [-0.6, 0.9, 0.2]), ("R3", [-0.5, -0.8, 0.8])].into_iter();
        let targets = places.map(|(name, at)| target(name, Vector3::from(at) * reach)).collect();
        Ok(with_joints(&chain, joints)?.with_targets(targets)?)
    }

    /// The declared errors of a null: constant errors and joint compliance.
    pub fn options(&self, chain: &Chain, undeclared: &Undeclared, heavy: bool, hours: f64) -> PlantOptions {
        let frames = match undeclared.frame {
            None => Vec::new(),
            Some(hidden) => chain
                .frames()
                .filter(|frame| *frame != hidden)
                .map(|frame| chain.frame_word(frame).to_owned())
                .collect(),
        };
        let geometric = flaws::Geometric {
            position_mm: self.constant[0],
            angle_mrad: self.constant[1],
            target_mm: if undeclared.targets { 0.0 } else { 0.05 },
            frames,
        };
        let springs = chain
            .movable()
            .iter()
            .zip(&self.stiffness)
            .filter(|(joint, _)| undeclared.spring != Some(**joint))
            .map(|(&joint, &stiffness)| spring(name_of(chain, joint), stiffness));
        PlantOptions {
            errors: Flaws {
                geometric: Some(geometric),
                joint_compliance: springs.collect(),
                stiffness_scatter: 0.15,
                ..Flaws::default()
            },
            shop: ShopDay { start_c: 20.0, rise_k: 3.0, wander_k: 1.0, hours },
            instrument: InstrumentSize {
                sd_um: self.noise[0],
                transverse_um_per_m: self.noise[2],
                orientation_urad: self.orientation,
                freedom: heavy.then_some(5.0),
                ..InstrumentSize::default()
            },
            repeatability: RepeatabilitySize { sd_um: self.noise[1], rotation_urad: 0.0 },
        }
    }

    /// Visits within the limits, a tenth of them made twice, with a payload each; a thermometer and three columns that
    /// have nothing to do with the robot, one of them a temperature.
    pub fn campaign(&self, chain: &Chain, visits: usize, seed: u64) -> Outcome<Campaign> {
        let mut campaign = Campaign::random(chain, visits, seed)?.with_some_payload(
            &self.payloads,
            self.com,
            0.02,
            seed + 1,
        );
        let mut again = campaign.clone();
        again.visits.truncate(visits / 10);
        campaign = campaign.then(again);
        campaign.visit_s = 60.0;
        let distractor = |name: &str, unit: &str, mean, sd| ChannelPlan::Distractor {
            name: name.into(),
            unit: unit.into(),
            mean,
            sd,
        };
        Ok(campaign.with_channels(vec![
            ChannelPlan::Air { name: "temperature".into(), sd: 0.05 },
            distractor("cabinet", "degC", 31.0, 1.5),
            distractor("humidity", "%", 45.0, 6.0),
            distractor("pressure", "hPa", 1013.0, 3.0),
        ]))
    }
}

//! The robots of this study: their description, what is declared of them, how they are measured.
//!
//! The declared model is that of a null: constant errors of every frame and target, and one compliance per joint. The
//! compliances are those of real machines of the type.

use std::error::Error;
use truepose_errormodel::AnyEffect;
use truepose_errormodel::effects::{Geometric, JointCompliance, Where};
use truepose_kinematics::nalgebra::Vector3;
use truepose_kinematics::{Chain, FrameId, Joint, JointId, Link, Target, samples};
use truepose_simulate::description::{InstrumentSize, PlantOptions, RepeatabilitySize, ShopDay};
use truepose_simulate::flaws::{self, Flaws};
use truepose_simulate::{Campaign, ChannelPlan, robots};

/// One kind of robot.
pub struct Robot {
    pub name: &'static str,
    pub chain: fn() -> Result<Chain, Box<dyn Error>>,
    /// Of every joint that moves, N·m/rad or N/m.
    pub stiffness: &'static [f64],
    /// Constant errors, mm and mrad.
    pub constant: [f64; 2],
    /// Instrument and repeatability, µm; growth across the line of sight, µm/m.
    pub noise: [f64; 3],
    /// Of the orientation, µrad; none does not measure it.
    pub orientation: Option<f64>,
    /// kg.
    pub payloads: &'static [f64],
    /// m, in the tool's frame.
    pub com: [f64; 3],
}

/// All of them.
pub fn all() -> Vec<Robot> {
    vec![
        Robot {
            name: "ur10",
            chain: ur10,
            stiffness: &[6e4, 4e4, 2.5e4, 1e4, 1e4, 1e4],
            constant: [0.4, 0.8],
            noise: [20.0, 30.0, 5.0],
            orientation: None,
            payloads: &[0.0, 5.0, 9.0],
            com: [0.02, -0.03, 0.12],
        },
        Robot {
            name: "heavy",
            chain: || Ok(samples::heavy()),
            stiffness: &[4e6, 3e6, 2e6, 5e5, 4e5, 2e5],
            constant: [0.4, 0.4],
            noise: [15.0, 25.0, 4.0],
            orientation: None,
            payloads: &[0.0, 50.0, 100.0],
            com: [0.05, -0.03, 0.25],
        },
        Robot {
            name: "pps",
            chain: || Ok(samples::pps()),
            stiffness: &[5e7, 4e7, 4e7, 1.5e6, 3e5, 6e5],
            constant: [0.3, 0.25],
            noise: [40.0, 50.0, 0.0],
            orientation: None,
            payloads: &[0.0, 35.0, 70.0],
            com: [0.05, -0.1, -0.84],
        },
        Robot {
            name: "gantry",
            chain: || Ok(robots::gantry()?),
            stiffness: &[1e8, 1e8, 5e7, 1e5],
            constant: [0.3, 0.3],
            noise: [10.0, 10.0, 3.0],
            orientation: None,
            payloads: &[0.0, 20.0, 40.0],
            com: [0.1, -0.05, 0.1],
        },
        Robot {
            name: "scara",
            chain: scara,
            stiffness: &[1e5, 1e5, 1e6, 1e4],
            constant: [0.2, 0.5],
            noise: [8.0, 8.0, 0.0],
            orientation: None,
            payloads: &[0.0, 2.0, 4.0],
            com: [0.03, 0.01, 0.05],
        },
        Robot {
            name: "seven",
            chain: || Ok(samples::seven()),
            stiffness: &[2e4, 1.5e4, 1.5e4, 1e4, 8e3, 5e3, 5e3],
            constant: [0.2, 0.5],
            noise: [15.0, 20.0, 0.0],
            orientation: Some(40.0),
            payloads: &[0.0, 3.0, 6.0],
            com: [0.02, -0.02, 0.08],
        },
    ]
}

/// The UR10 with its maker's weights and a frame of three reflectors.
fn ur10() -> Result<Chain, Box<dyn Error>> {
    let weights = [
        (7.1, [0.021, 0.0, 0.027]),
        (12.7, [0.38, 0.0, 0.158]),
        (4.27, [0.24, 0.0, 0.068]),
        (2.0, [0.0, 0.007, 0.018]),
        (2.0, [0.0, 0.007, 0.018]),
        (0.365, [0.0, 0.0, -0.026]),
    ];
    weighed(&samples::ur10(), &weights, 0.1)
}

/// The SCARA with its weights and a frame of three reflectors.
fn scara() -> Result<Chain, Box<dyn Error>> {
    let weights = [
        (9.0, [0.17, 0.0, 0.02]),
        (6.0, [0.15, 0.0, 0.03]),
        (1.2, [0.0, 0.0, -0.05]),
        (0.4, [0.0, 0.0, 0.02]),
    ];
    weighed(&samples::scara(), &weights, 0.06)
}

fn weighed(chain: &Chain, weights: &[(f64, [f64; 3])], reach: f64) -> Result<Chain, Box<dyn Error>> {
    let joints = chain.joints().iter().zip(weights).map(|(joint, &(mass, com))| Joint {
        link: Some(Link { mass, com: Vector3::from(com) }),
        ..joint.clone()
    });
    let target = |name: &str, at: [f64; 3]| Target {
        name: name.into(),
        position: Vector3::from(at) * reach,
        known: true,
        tool: truepose_kinematics::ToolId::FIRST,
    };
    Ok(Chain::new(chain.name(), joints.collect())?
        .with_base(*chain.base())?
        .with_tool(*chain.tool())?
        .with_gravity(*chain.gravity())?
        .with_targets(vec![
            target("R1", [1.0, 0.1, 0.5]),
            target("R2", [-0.6, 0.9, 0.2]),
            target("R3", [-0.5, -0.8, 0.8]),
        ])?)
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
                places.push(Where::Targets(truepose_errormodel::effects::AllTargets::All));
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
            .zip(self.stiffness)
            .filter(|(joint, _)| undeclared.spring != Some(**joint))
            .map(|(&joint, &stiffness)| flaws::JointCompliance {
                joint: chain.joint(joint).name.clone(),
                stiffness: Some(stiffness),
                ..flaws::JointCompliance::default()
            });
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
    pub fn campaign(&self, chain: &Chain, visits: usize, seed: u64) -> Result<Campaign, Box<dyn Error>> {
        let mut campaign =
            Campaign::random(chain, visits, seed)?.with_some_payload(self.payloads, self.com, 0.02, seed + 1);
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

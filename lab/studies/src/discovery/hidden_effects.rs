//! Effects that the declared model lacks: one effect at a random place, of a size that is chosen later.

use super::robots::Undeclared;
use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;
use truepose_discover::{Family, Place};
use truepose_kinematics::{Chain, JointId, JointKind, TargetId};
use truepose_simulate::description::PlantOptions;
use truepose_simulate::{flaws, span};

/// The effects that a plant can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HiddenEffect {
    Geometric,
    JointCompliance,
    LinkCompliance,
    BaseCompliance,
    LoadNonlinearity,
    Eccentric,
    Mesh,
    BacklashApproach,
    BacklashLoad,
    Coupling,
    Guideway,
    Thermal,
    ThermalLate,
    Drift,
    Shift,
    Payload,
    Target,
    Outliers,
    /// Error motion of a revolute axis, which no named family describes.
    Wobble,
}

/// All effects with their names.
pub const HIDDEN_EFFECTS: [(HiddenEffect, &str); 19] = [
    (HiddenEffect::Geometric, "geometric"),
    (HiddenEffect::JointCompliance, "joint_compliance"),
    (HiddenEffect::LinkCompliance, "link_compliance"),
    (HiddenEffect::BaseCompliance, "base_compliance"),
    (HiddenEffect::LoadNonlinearity, "load_nonlinearity"),
    (HiddenEffect::Eccentric, "eccentric"),
    (HiddenEffect::Mesh, "mesh"),
    (HiddenEffect::BacklashApproach, "backlash_approach"),
    (HiddenEffect::BacklashLoad, "backlash_load"),
    (HiddenEffect::Coupling, "coupling"),
    (HiddenEffect::Guideway, "guideway"),
    (HiddenEffect::Thermal, "thermal"),
    (HiddenEffect::ThermalLate, "thermal_late"),
    (HiddenEffect::Drift, "drift"),
    (HiddenEffect::Shift, "shift"),
    (HiddenEffect::Payload, "payload"),
    (HiddenEffect::Target, "target"),
    (HiddenEffect::Outliers, "outliers"),
    (HiddenEffect::Wobble, "wobble"),
];

/// One size of the cause, added to a plant: of unit size it is a bit more than machines of the kind have.
type Install = Box<dyn Fn(&mut PlantOptions, f64)>;

/// A cause at its place.
pub struct Hidden {
    pub place: Place,
    pub undeclared: Undeclared,
    pub install: Install,
    /// The turn whose axis wanders.
    pub wobbles: Option<JointId>,
}

impl HiddenEffect {
    pub fn word(self) -> &'static str {
        HIDDEN_EFFECTS.iter().find(|(cause, _)| *cause == self).map_or("", |(_, word)| word)
    }

    pub fn named(word: &str) -> Option<Self> {
        HIDDEN_EFFECTS.iter().find(|(_, known)| *known == word).map(|(cause, _)| *cause)
    }

    /// What it should be called.
    pub fn family(self) -> Family {
        match self {
            HiddenEffect::Geometric => Family::Geometric,
            HiddenEffect::JointCompliance => Family::JointCompliance,
            HiddenEffect::LinkCompliance => Family::LinkCompliance,
            HiddenEffect::BaseCompliance => Family::BaseCompliance,
            HiddenEffect::LoadNonlinearity => Family::LoadNonlinearity,
            HiddenEffect::Eccentric | HiddenEffect::Mesh => Family::Transmission,
            HiddenEffect::BacklashApproach | HiddenEffect::BacklashLoad => Family::Backlash,
            HiddenEffect::Coupling => Family::Coupling,
            HiddenEffect::Guideway => Family::Guideway,
            HiddenEffect::Thermal | HiddenEffect::ThermalLate => Family::Thermal,
            HiddenEffect::Drift => Family::Drift,
            HiddenEffect::Shift => Family::Shift,
            HiddenEffect::Payload => Family::Payload,
            HiddenEffect::Target => Family::Target,
            HiddenEffect::Outliers => Family::Outlier,
            HiddenEffect::Wobble => Family::Unmodelled,
        }
    }

    /// Draws a place; none when this robot has none. `loads` are the largest loads of the movable joints of
    /// the robot as described, N·m or N.
    pub fn draw(
        self,
        chain: &Chain,
        payloads: &[f64],
        loads: &[f64],
        duration: f64,
        rng: &mut ChaCha8Rng,
    ) -> Option<Hidden> {
        let of_kind = |kind: JointKind| -> Vec<JointId> {
            chain.movable().iter().copied().filter(|&j| chain.joint(j).kind == kind).collect()
        };
        let turns = of_kind(JointKind::Revolute);
        let name = |joint: JointId| chain.joint(joint).name.clone();
        let slides = |joint: JointId| chain.joint(joint).kind == JointKind::Prismatic;
        let any = *chain.movable().choose(rng)?;
        // What only its own errors load is no spring that anybody would look for.
        let bears = |k: &usize| loads[*k] > if slides(chain.movable()[*k]) { 10.0 } else { 1.0 };
        let loaded: Vec<usize> = (0..loads.len()).filter(bears).collect();
        let hidden = |joint: JointId, install: Install| {
            Some(Hidden {
                place: Place::joint(chain, joint),
                undeclared: Undeclared::default(),
                install,
                wobbles: None,
            })
        };
        match self {
            HiddenEffect::Geometric => {
                let frame = *chain.frames().collect::<Vec<_>>().choose(rng)?;
                let word = chain.frame_word(frame).to_owned();
                let way: [f64; 6] = std::array::from_fn(|_| 2.0 * rng.random::<f64>() - 1.0);
                let install = move |options: &mut PlantOptions, size: f64| {
                    options.errors.displacement.push(flaws::Displacement {
                        frame: word.clone(),
                        xyz_mm: [way[0] * size, way[1] * size, way[2] * size],
                        turn_mrad: [way[3] * size, way[4] * size, way[5] * size],
                    });
                };
                Some(Hidden {
                    place: Place::frame(chain, frame),
                    undeclared: Undeclared { frame: Some(frame), ..Undeclared::default() },
                    install: Box::new(install),
                    wobbles: None,
                })
            }
            HiddenEffect::JointCompliance => {
                let k = *loaded.choose(rng)?;
                let (joint, load) = (chain.movable()[k], loads[k]);
                let word = name(joint);
                let install = move |options: &mut PlantOptions, size: f64| {
                    // A millimetre or milliradian under the largest load.
                    options.errors.joint_compliance.push(flaws::JointCompliance {
                        joint: word.clone(),
                        stiffness: Some(load / (1e-3 * size)),
                        ..flaws::JointCompliance::default()
                    });
                };
                let mut found = hidden(joint, Box::new(install))?;
                found.undeclared.spring = Some(joint);
                Some(found)
            }
            HiddenEffect::LinkCompliance => {
                let long = |&joint: &JointId| {
                    let (root, tip) = span(chain, joint);
                    (tip - root).norm() > 0.08
                };
                let joint = *chain.movable().iter().copied().filter(long).collect::<Vec<_>>().choose(rng)?;
                let (root, tip) = span(chain, joint);
                let length = (tip - root).norm();
                let largest = loads.iter().copied().fold(1.0, f64::max);
                let (flat, twist) = (0.4 + rng.random::<f64>(), 0.5 + 0.5 * rng.random::<f64>());
                let word = name(joint);
                let install = move |options: &mut PlantOptions, size: f64| {
                    let bending = largest * length / (1e-3 * size);
                    options.errors.link_compliance.push(flaws::LinkCompliance {
                        joint: word.clone(),
                        bending_nm2: [bending, bending * flat],
                        torsion_nm2: bending * twist,
                        ..flaws::LinkCompliance::default()
                    });
                };
                hidden(joint, Box::new(install))
            }
            HiddenEffect::BaseCompliance => {
                let largest = loads.iter().copied().fold(1.0, f64::max);
                let uneven: [f64; 3] = std::array::from_fn(|_| 0.7 + 0.6 * rng.random::<f64>());
                let install = move |options: &mut PlantOptions, size: f64| {
                    options.errors.base_compliance = Some(flaws::BaseCompliance {
                        tilt_stiffness: Some(uneven.map(|u| u * largest / (1e-3 * size))),
                        sink_stiffness: None,
                    });
                };
                let mut found = hidden(any, Box::new(install))?;
                found.place = Place { joint: Some("base".into()), ..Place::default() };
                Some(found)
            }
            HiddenEffect::LoadNonlinearity => {
                let joint = chain.movable()[*loaded.choose(rng)?];
                let (word, slide) = (name(joint), slides(joint));
                let install = move |options: &mut PlantOptions, size: f64| {
                    let list = &mut options.errors.joint_compliance;
                    if let Some(spring) = list.iter_mut().find(|spring| spring.joint == word) {
                        let at = Some(1.0 / size.max(1e-9));
                        if slide { spring.hardens_at_mm = at } else { spring.hardens_at_mrad = at }
                    }
                };
                hidden(joint, Box::new(install))
            }
            HiddenEffect::Eccentric | HiddenEffect::Mesh => {
                let joint = if self == HiddenEffect::Mesh { any } else { *turns.choose(rng)? };
                let (word, slide) = (name(joint), slides(joint));
                let cycles = (self == HiddenEffect::Mesh).then(|| (6.0 + 74.0 * rng.random::<f64>()).round());
                let lead_mm = *[5.0, 10.0, 20.0].choose(rng)?;
                let install = move |options: &mut PlantOptions, size: f64| {
                    if slide {
                        let amplitude_um = 100.0 * size;
                        options.errors.lead_screw.push(flaws::LeadScrew {
                            joint: word.clone(),
                            lead_mm,
                            amplitude_um,
                        });
                    } else {
                        options.errors.transmission.push(flaws::Transmission {
                            joint: word.clone(),
                            wheel: if cycles.is_some() {
                                flaws::Wheel::Mesh
                            } else {
                                flaws::Wheel::Eccentric
                            },
                            amplitude_mrad: size,
                            cycles,
                            phase_deg: None,
                        });
                    }
                };
                hidden(joint, Box::new(install))
            }
            HiddenEffect::BacklashApproach | HiddenEffect::BacklashLoad => {
                let by_load = self == HiddenEffect::BacklashLoad;
                let k = if by_load { *loaded.choose(rng)? } else { chain.coordinate(any)? };
                let joint = chain.movable()[k];
                let flank_load = by_load.then(|| loads[k] * (0.02 + 0.2 * rng.random::<f64>()));
                let side = match (by_load, rng.random::<bool>()) {
                    (false, _) => flaws::BacklashSide::Approach,
                    (true, true) => flaws::BacklashSide::Load,
                    (true, false) => flaws::BacklashSide::LoadThenApproach,
                };
                let (word, slide) = (name(joint), slides(joint));
                let install = move |options: &mut PlantOptions, size: f64| {
                    options.errors.backlash.push(flaws::Backlash {
                        joint: word.clone(),
                        width_mrad: (!slide).then_some(size),
                        width_mm: slide.then_some(size),
                        side,
                        flank_load,
                    });
                };
                hidden(joint, Box::new(install))
            }
            HiddenEffect::Coupling => {
                let driver =
                    *chain.movable().iter().copied().filter(|j| *j != any).collect::<Vec<_>>().choose(rng)?;
                let share = if rng.random::<bool>() || slides(driver) { 0.0 } else { rng.random::<f64>() };
                let (word, by) = (name(any), name(driver));
                let install = move |options: &mut PlantOptions, size: f64| {
                    options.errors.coupling.push(flaws::Dragging {
                        joint: word.clone(),
                        driver: by.clone(),
                        ratio_milli: size,
                        eccentricity_mrad: share * size,
                    });
                };
                let mut found = hidden(any, Box::new(install))?;
                found.place.driver = Some(name(driver));
                Some(found)
            }
            HiddenEffect::Guideway => {
                let joint = *of_kind(JointKind::Prismatic).choose(rng)?;
                let share: [f64; 6] = std::array::from_fn(|_| {
                    if rng.random::<f64>() < 0.6 { 0.3 + rng.random::<f64>() } else { 0.0 }
                });
                let share = if share.iter().sum::<f64>() > 0.0 { share } else { [1.0; 6] };
                let travel = chain.joint(joint).limits.map_or(1.0, |(lower, upper)| upper - lower);
                let correlation_mm = 1e3 * travel * (0.15 + 0.35 * rng.random::<f64>());
                let word = name(joint);
                let install = move |options: &mut PlantOptions, size: f64| {
                    options.errors.guideway.push(flaws::Guideway {
                        joint: word.clone(),
                        xyz_um: std::array::from_fn(|k| 100.0 * size * share[k]),
                        turn_urad: std::array::from_fn(|k| 100.0 * size * share[k + 3]),
                        correlation_mm,
                    });
                };
                hidden(joint, Box::new(install))
            }
            HiddenEffect::Thermal | HiddenEffect::ThermalLate => {
                let (at, grows, place) = match rng.random_range(0..4) {
                    0 => ("base".to_owned(), flaws::Growing::Frame, None),
                    1 => ("tool".to_owned(), flaws::Growing::Frame, None),
                    2 if slides(any) => (name(any), flaws::Growing::Scale, Some(any)),
                    2 => (name(any), flaws::Growing::Length, Some(any)),
                    _ => (name(any), flaws::Growing::Motion, Some(any)),
                };
                let lag_s = if self == HiddenEffect::Thermal {
                    0.0
                } else {
                    duration * (0.05 + 0.3 * rng.random::<f64>())
                };
                let word = at.clone();
                let install = move |options: &mut PlantOptions, size: f64| {
                    let per_kelvin = 100.0 * size;
                    options.errors.thermal.push(flaws::Thermal { at: at.clone(), grows, per_kelvin, lag_s });
                };
                let mut found = hidden(place.unwrap_or(any), Box::new(install))?;
                found.place = Place { joint: Some(word), ..Place::default() }.following("temperature");
                Some(found)
            }
            HiddenEffect::Drift | HiddenEffect::Shift => {
                let at = match rng.random_range(0..3) {
                    0 => "base".to_owned(),
                    1 => "tool".to_owned(),
                    _ => name(any),
                };
                let when_s = duration * (0.15 + 0.7 * rng.random::<f64>());
                let correlation_s = duration * (0.25 + 0.5 * rng.random::<f64>());
                let (word, jumps) = (at.clone(), self == HiddenEffect::Shift);
                let install = move |options: &mut PlantOptions, size: f64| {
                    let at = at.clone();
                    if jumps {
                        let bump = flaws::Shift { at, when_s, size_mm: size, size_mrad: size };
                        options.errors.shift.push(bump);
                    } else {
                        let walk = flaws::Drift { at, size_mm: size, size_mrad: size, correlation_s };
                        options.errors.drift.push(walk);
                    }
                };
                let mut found = hidden(any, Box::new(install))?;
                found.place = Place { joint: Some(word), ..Place::default() };
                Some(found)
            }
            HiddenEffect::Payload => {
                let levels: Vec<f64> = payloads.iter().copied().filter(|mass| *mass > 0.0).collect();
                let declared_kg = *levels.choose(rng)?;
                let sign = if rng.random::<bool>() { 1.0 } else { -1.0 };
                let install = move |options: &mut PlantOptions, size: f64| {
                    // No payload is lighter than nothing.
                    let true_kg = (declared_kg * (1.0 + 0.2 * sign * size)).max(0.0);
                    options.errors.payload.push(flaws::Mislabelled { declared_kg, true_kg });
                };
                let mut found = hidden(any, Box::new(install))?;
                found.place = Place { level: Some(declared_kg), ..Place::default() };
                Some(found)
            }
            HiddenEffect::Target => {
                let count = chain.targets().len();
                let target = TargetId((count > 0).then(|| rng.random_range(0..count))?);
                let way: [f64; 3] = std::array::from_fn(|_| 2.0 * rng.random::<f64>() - 1.0);
                let word = chain.targets()[target.0].name.clone();
                let install = move |options: &mut PlantOptions, size: f64| {
                    options
                        .errors
                        .target
                        .push(flaws::WrongTarget { target: word.clone(), offset_mm: way.map(|w| w * size) });
                };
                Some(Hidden {
                    place: Place::target(chain, target),
                    undeclared: Undeclared { targets: true, ..Undeclared::default() },
                    install: Box::new(install),
                    wobbles: None,
                })
            }
            HiddenEffect::Outliers => {
                let share = 0.005 + 0.015 * rng.random::<f64>();
                let install = move |options: &mut PlantOptions, size: f64| {
                    options.errors.outliers = Some(flaws::Outliers { share, size_mm: size });
                };
                let mut found = hidden(any, Box::new(install))?;
                found.place = Place::default();
                Some(found)
            }
            HiddenEffect::Wobble => {
                let joint = *turns.choose(rng)?;
                let mut found = hidden(joint, Box::new(|_, _| ()))?;
                found.wobbles = Some(joint);
                Some(found)
            }
        }
    }
}

//! Effects that the declared model lacks: one effect at a random place, of a size that is chosen later.

use super::robots::Undeclared;
use crate::prelude::*;
use rand::seq::IndexedRandom;
use std::array::from_fn;
use truepose_discover::{Family, Place};
use truepose_simulate::span;

/// The effects that a plant can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
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

/// One size of the cause, added to a plant: of unit size it is a bit more than machines of the kind have.
type Install = Box<dyn Fn(&mut Flaws, f64)>;

/// A cause at its place.
pub struct Hidden {
    pub place: Place,
    pub undeclared: Undeclared,
    pub install: Install,
    /// The turn whose axis wanders.
    pub wobbles: Option<JointId>,
}

impl Hidden {
    fn at(place: Place, install: impl Fn(&mut Flaws, f64) + 'static) -> Self {
        Hidden { place, undeclared: Undeclared::default(), install: Box::new(install), wobbles: None }
    }

    /// At a frame or joint of this name.
    fn at_word(word: String, install: impl Fn(&mut Flaws, f64) + 'static) -> Self {
        Hidden::at(Place { joint: Some(word), ..Place::default() }, install)
    }
}

/// The name of a cause, `none` of none.
pub fn word_of(cause: Option<HiddenEffect>) -> String {
    cause.map_or("none".into(), |cause| cause.word())
}

impl HiddenEffect {
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
        (payloads, loads): (&[f64], &[f64]),
        duration: f64,
        rng: &mut ChaCha8Rng,
    ) -> Option<Hidden> {
        let of_kind = |prismatic: bool| -> Vec<JointId> {
            chain.movable().iter().copied().filter(|&j| slides(chain, j) == prismatic).collect()
        };
        let any = *chain.movable().choose(rng)?;
        // What only its own errors load is no spring that anybody would look for.
        let bears = |k: &usize| loads[*k] > if slides(chain, chain.movable()[*k]) { 10.0 } else { 1.0 };
        let loaded: Vec<usize> = (0..loads.len()).filter(bears).collect();
        let heaviest = loads.iter().copied().fold(1.0, f64::max);
        let of = |joint: JointId| (Place::joint(chain, joint), name_of(chain, joint), slides(chain, joint));
        Some(match self {
            HiddenEffect::Geometric => {
                let frame = *chain.frames().collect::<Vec<_>>().choose(rng)?;
                let word = chain.frame_word(frame).to_owned();
                let way: [f64; 6] = from_fn(|_| 2.0 * rng.random::<f64>() - 1.0);
                let install = move |errors: &mut Flaws, size: f64| {
                    let (xyz_mm, turn_mrad) = (from_fn(|k| way[k] * size), from_fn(|k| way[k + 3] * size));
                    errors.displacement.push(flaws::Displacement { frame: word.clone(), xyz_mm, turn_mrad });
                };
                let undeclared = Undeclared { frame: Some(frame), ..Undeclared::default() };
                Hidden { undeclared, ..Hidden::at(Place::frame(chain, frame), install) }
            }
            HiddenEffect::JointCompliance => {
                let k = *loaded.choose(rng)?;
                let (load, soft) = (loads[k], chain.movable()[k]);
                let (place, joint, _) = of(soft);
                let install = move |errors: &mut Flaws, size: f64| {
                    // A millimetre or milliradian under the largest load.
                    errors.joint_compliance.push(spring(joint.clone(), load / (1e-3 * size)));
                };
                let undeclared = Undeclared { spring: Some(soft), ..Undeclared::default() };
                Hidden { undeclared, ..Hidden::at(place, install) }
            }
            HiddenEffect::LinkCompliance => {
                let length = |&joint: &JointId| {
                    let (root, tip) = span(chain, joint);
                    (tip - root).norm()
                };
                let long = chain.movable().iter().copied().filter(|joint| length(joint) > 0.08);
                let joint = *long.collect::<Vec<_>>().choose(rng)?;
                let moment = heaviest * length(&joint);
                let (flat, twist) = (0.4 + rng.random::<f64>(), 0.5 + 0.5 * rng.random::<f64>());
                let (place, joint, _) = of(joint);
                Hidden::at(place, move |errors, size| {
                    let bending = moment / (1e-3 * size);
                    errors.link_compliance.push(flaws::LinkCompliance {
                        joint: joint.clone(),
                        bending_nm2: [bending, bending * flat],
                        torsion_nm2: bending * twist,
                        ..Default::default()
                    });
                })
            }
            HiddenEffect::BaseCompliance => {
                let uneven: [f64; 3] = from_fn(|_| 0.7 + 0.6 * rng.random::<f64>());
                Hidden::at_word("base".into(), move |errors, size| {
                    let tilt_stiffness = Some(uneven.map(|u| u * heaviest / (1e-3 * size)));
                    errors.base_compliance =
                        Some(flaws::BaseCompliance { tilt_stiffness, sink_stiffness: None });
                })
            }
            HiddenEffect::LoadNonlinearity => {
                let (place, joint, slide) = of(chain.movable()[*loaded.choose(rng)?]);
                Hidden::at(place, move |errors, size| {
                    let mut springs = errors.joint_compliance.iter_mut();
                    if let Some(spring) = springs.find(|spring| spring.joint == joint) {
                        let at = Some(1.0 / size.max(1e-9));
                        if slide { spring.hardens_at_mm = at } else { spring.hardens_at_mrad = at }
                    }
                })
            }
            HiddenEffect::Eccentric | HiddenEffect::Mesh => {
                let mesh = self == HiddenEffect::Mesh;
                let (place, joint, slide) = of(if mesh { any } else { *of_kind(false).choose(rng)? });
                let cycles = mesh.then(|| (6.0 + 74.0 * rng.random::<f64>()).round());
                let lead_mm = *[5.0, 10.0, 20.0].choose(rng)?;
                Hidden::at(place, move |errors, size| {
                    let (joint, amplitude_um) = (joint.clone(), 100.0 * size);
                    if slide {
                        errors.lead_screw.push(flaws::LeadScrew { joint, lead_mm, amplitude_um });
                    } else {
                        errors.transmission.push(gear(joint, size, cycles));
                    }
                })
            }
            HiddenEffect::BacklashApproach | HiddenEffect::BacklashLoad => {
                let by_load = self == HiddenEffect::BacklashLoad;
                let k = if by_load { *loaded.choose(rng)? } else { chain.coordinate(any)? };
                let flank_load = by_load.then(|| loads[k] * (0.02 + 0.2 * rng.random::<f64>()));
                let side = match (by_load, rng.random::<bool>()) {
                    (false, _) => flaws::BacklashSide::Approach,
                    (true, true) => flaws::BacklashSide::Load,
                    (true, false) => flaws::BacklashSide::LoadThenApproach,
                };
                let (place, joint, slide) = of(chain.movable()[k]);
                Hidden::at(place, move |errors, size| {
                    let of = backlash(joint.clone(), slide, size);
                    errors.backlash.push(flaws::Backlash { side, flank_load, ..of });
                })
            }
            HiddenEffect::Coupling => {
                let others = chain.movable().iter().copied().filter(|j| *j != any);
                let driver = *others.collect::<Vec<_>>().choose(rng)?;
                let alone = rng.random::<bool>() || slides(chain, driver);
                let share = if alone { 0.0 } else { rng.random::<f64>() };
                let ((place, joint, _), driver) = (of(any), name_of(chain, driver));
                let by = driver.clone();
                Hidden::at(Place { driver: Some(driver), ..place }, move |errors, size| {
                    errors.coupling.push(flaws::Dragging {
                        joint: joint.clone(),
                        driver: by.clone(),
                        ratio_milli: size,
                        eccentricity_mrad: share * size,
                    });
                })
            }
            HiddenEffect::Guideway => {
                let joint = *of_kind(true).choose(rng)?;
                let share: [f64; 6] =
                    from_fn(|_| if rng.random::<f64>() < 0.6 { 0.3 + rng.random::<f64>() } else { 0.0 });
                let share = if share.iter().sum::<f64>() > 0.0 { share } else { [1.0; 6] };
                let travel = chain.joint(joint).limits.map_or(1.0, |(lower, upper)| upper - lower);
                let correlation_mm = 1e3 * travel * (0.15 + 0.35 * rng.random::<f64>());
                let (place, joint, _) = of(joint);
                Hidden::at(place, move |errors, size| {
                    let (xyz_um, turn_urad) =
                        (from_fn(|k| 100.0 * size * share[k]), from_fn(|k| 100.0 * size * share[k + 3]));
                    let joint = joint.clone();
                    errors.guideway.push(flaws::Guideway { joint, xyz_um, turn_urad, correlation_mm });
                })
            }
            HiddenEffect::Thermal | HiddenEffect::ThermalLate => {
                let (at, grows) = match rng.random_range(0..4) {
                    0 => ("base".to_owned(), flaws::Growing::Frame),
                    1 => ("tool".to_owned(), flaws::Growing::Frame),
                    2 if slides(chain, any) => (name_of(chain, any), flaws::Growing::Scale),
                    2 => (name_of(chain, any), flaws::Growing::Length),
                    _ => (name_of(chain, any), flaws::Growing::Motion),
                };
                let late = self == HiddenEffect::ThermalLate;
                let lag_s = if late { duration * (0.05 + 0.3 * rng.random::<f64>()) } else { 0.0 };
                let word = at.clone();
                let install = move |errors: &mut Flaws, size: f64| {
                    let (at, per_kelvin) = (at.clone(), 100.0 * size);
                    errors.thermal.push(flaws::Thermal { at, grows, per_kelvin, lag_s });
                };
                let place = Place { joint: Some(word), ..Place::default() };
                Hidden::at(place.following("temperature"), install)
            }
            HiddenEffect::Drift | HiddenEffect::Shift => {
                let at = match rng.random_range(0..3) {
                    0 => "base".to_owned(),
                    1 => "tool".to_owned(),
                    _ => name_of(chain, any),
                };
                let when_s = duration * (0.15 + 0.7 * rng.random::<f64>());
                let correlation_s = duration * (0.25 + 0.5 * rng.random::<f64>());
                let jumps = self == HiddenEffect::Shift;
                Hidden::at_word(at.clone(), move |errors, size| {
                    let (at, size_mm, size_mrad) = (at.clone(), size, size);
                    if jumps {
                        errors.shift.push(flaws::Shift { at, when_s, size_mm, size_mrad });
                    } else {
                        errors.drift.push(flaws::Drift { at, size_mm, size_mrad, correlation_s });
                    }
                })
            }
            HiddenEffect::Payload => {
                let levels: Vec<f64> = payloads.iter().copied().filter(|mass| *mass > 0.0).collect();
                let declared_kg = *levels.choose(rng)?;
                let sign = if rng.random::<bool>() { 1.0 } else { -1.0 };
                let place = Place { level: Some(declared_kg), ..Place::default() };
                Hidden::at(place, move |errors, size| {
                    // No payload is lighter than nothing.
                    let true_kg = (declared_kg * (1.0 + 0.2 * sign * size)).max(0.0);
                    errors.payload.push(flaws::Mislabelled { declared_kg, true_kg });
                })
            }
            HiddenEffect::Target => {
                let count = chain.targets().len();
                let id = TargetId((count > 0).then(|| rng.random_range(0..count))?);
                let way: [f64; 3] = from_fn(|_| 2.0 * rng.random::<f64>() - 1.0);
                let word = chain.targets()[id.0].name.clone();
                let install = move |errors: &mut Flaws, size: f64| {
                    let (target, offset_mm) = (word.clone(), way.map(|w| w * size));
                    errors.target.push(flaws::WrongTarget { target, offset_mm });
                };
                let undeclared = Undeclared { targets: true, ..Undeclared::default() };
                Hidden { undeclared, ..Hidden::at(Place::target(chain, id), install) }
            }
            HiddenEffect::Outliers => {
                let share = 0.005 + 0.015 * rng.random::<f64>();
                Hidden::at(Place::default(), move |errors, size| {
                    errors.outliers = Some(flaws::Outliers { share, size_mm: size });
                })
            }
            HiddenEffect::Wobble => {
                let joint = *of_kind(false).choose(rng)?;
                Hidden { wobbles: Some(joint), ..Hidden::at(of(joint).0, |_, _| ()) }
            }
        })
    }
}

//! Several installations of one arm: their rows in one frame, and what each has of its own.
//!
//! ```text
//! p_0 = X_k p_k,    X_k = B_0 B_k⁻¹        B_k: base of session k, measurement frame k ← frame 0
//! ```
//!
//! Each session is placed from nothing with the nominal arm, all of them with one tool and one set of targets. What the arm's errors leave of
//! B_k are the coefficients of an effect, [`Session`], fitted with everything else.

use crate::{IdentifyError, Undetermined, place};
use truepose_errormodel::effects::{Own, Session};
use truepose_errormodel::{AnyEffect, Dataset, Installed, SessionRules, Visits, own_target};
use truepose_kinematics::{Chain, ChainError, GravityFrame, Placed, Pose, Target, TargetId};

/// A session that was placed.
#[derive(Debug, Clone, PartialEq)]
pub struct SessionPlaced {
    /// Its name.
    pub name: String,
    /// Its rows.
    pub rows: usize,
    /// Its pose measurements.
    pub poses: usize,
    /// 3-D RMS that its placement with the nominal arm leaves, m; none where nothing was to be found.
    pub rms: Option<f64>,
}

/// Measurements of several sessions as those of one installation.
#[derive(Debug, Clone)]
pub struct Unified {
    /// All rows in the measurement frame of the first session.
    pub data: Dataset,
    /// The robot, with the targets that sessions have of their own; base, tool and targets as far known as described.
    pub chain: Chain,
    /// What further sessions have of their own.
    pub effects: Vec<Box<dyn AnyEffect>>,
    /// Names and frames, for the fit.
    pub installed: Vec<Installed>,
    /// How each was placed.
    pub placed: Vec<SessionPlaced>,
    /// What a user has to know, in sentences.
    pub remarks: Vec<String>,
}

/// Rounds between bases and what all sessions share; each leaves a small share of the error of the one before.
const ROUNDS: usize = 3;
/// A session whose residual after its placement is so many times that of the best one, and above [`STRANGE`], is of another arm.
const ANOTHER: f64 = 5.0;
/// Residual of a placement with the nominal arm, in characteristic lengths, that no arm of this kind has (docs/files.md: `check` says so).
const STRANGE: f64 = 0.03;
/// Angle between two verticals, rad, at which weights change by a hundredth.
const TILTED: f64 = 0.01;

/// Brings the rows of all sessions into one frame. `names` are those of the sessions 0, 1, … of `data`, which knows two or more.
///
/// # Errors
/// When a session has too few poses to place it, or cannot be of this arm; names the session.
pub fn unify(
    chain: &Chain,
    data: &Dataset,
    names: &[String],
    rules: SessionRules,
) -> Result<Unified, IdentifyError> {
    data.validate(chain)?;
    let mut data = data.clone();
    let chain = if rules.targets { with_own_targets(chain, &mut data, names)? } else { chain.clone() };
    let rows: Vec<Vec<usize>> = (0..names.len())
        .map(|session| (0..data.len()).filter(|&row| data.session(row) == session).collect())
        .collect();
    let parts: Vec<Dataset> = rows.iter().map(|rows| data.select(rows)).collect();
    let mut bases =
        if rules.base { placed_apart(&chain, &parts, names)? } else { Bases::shared(names.len()) };
    if rules.base {
        same_arm(&chain, &bases.rms, names)?;
    }
    for _ in 1..ROUNDS {
        if !rules.base || (chain.tool().known && chain.targets().iter().all(|t| t.known)) {
            break;
        }
        // Tool and targets from all sessions at once, then the bases with these.
        let together = place(&chain, &common(&data, &bases.frames))?.chain;
        bases = replaced(&together, &parts, names, bases)?;
    }
    let mut remarks = Vec::new();
    let unified = common(&data, &bases.frames);
    let lost = (0..data.len()).filter(|&row| data.seen(row).count() > unified.seen(row).count()).count();
    if lost > 0 {
        remarks.push(format!(
            "{lost} rows of further sessions have a position with a missing component and are not used: it has no axis in the frame of the first session"
        ));
    }
    remarks.extend((1..names.len()).filter_map(|k| tilted(&chain, &bases.frames[k], &names[k])));
    let further = names[1..].to_vec();
    let own = |own: Own| -> Box<dyn AnyEffect> {
        Box::new(Session { own, sessions: further.clone(), chosen: None })
    };
    let mut effects = Vec::new();
    if rules.base {
        effects.push(own(Own::Base));
    }
    if rules.tool {
        effects.push(own(Own::Tool));
    }
    let named = names.iter().zip(&bases.frames);
    let installed = named.map(|(name, &frame)| Installed { name: name.clone(), frame }).collect();
    let placed = (0..names.len()).map(|k| SessionPlaced {
        name: names[k].clone(),
        rows: parts[k].len(),
        poses: Visits::of(&parts[k]).len(),
        rms: bases.rms[k],
    });
    Ok(Unified { data: unified, chain, effects, installed, placed: placed.collect(), remarks })
}

/// Frames X_k of all sessions, and the RMS that each placement left.
struct Bases {
    frames: Vec<Pose>,
    rms: Vec<Option<f64>>,
}

impl Bases {
    fn shared(sessions: usize) -> Self {
        Bases { frames: vec![Pose::IDENTITY; sessions], rms: vec![None; sessions] }
    }
}

/// Each session from nothing: the first with tool and targets, the others with those of the sessions before.
fn placed_apart(chain: &Chain, parts: &[Dataset], names: &[String]) -> Result<Bases, IdentifyError> {
    let (mut known, mut first) = (chain.clone(), Pose::IDENTITY);
    let mut bases = Bases { frames: Vec::new(), rms: Vec::new() };
    for (k, part) in parts.iter().enumerate() {
        let asked = if k == 0 { known.clone() } else { unplaced(&known)? };
        let placement = placed(&asked, part, &names[k])?;
        let base = placement.chain.base().pose;
        if k == 0 {
            first = base;
        }
        let nothing = placement.found.is_empty();
        known = placement.chain;
        bases.frames.push(if k == 0 { Pose::IDENTITY } else { (first * base.inverse()).renormalised() });
        bases.rms.push((!nothing).then_some(placement.rms));
    }
    Ok(bases)
}

/// The bases again, tool and targets being known.
fn replaced(
    known: &Chain,
    parts: &[Dataset],
    names: &[String],
    mut bases: Bases,
) -> Result<Bases, IdentifyError> {
    for k in 1..parts.len() {
        let placement = placed(&unplaced(known)?, &parts[k], &names[k])?;
        let frame = known.base().pose * placement.chain.base().pose.inverse();
        bases.frames[k] = frame.renormalised();
        bases.rms[k] = Some(placement.rms);
    }
    Ok(bases)
}

/// A placement, refused where the session does not determine its own base.
fn placed(chain: &Chain, part: &Dataset, name: &str) -> Result<crate::Placement, IdentifyError> {
    let poses = Visits::of(part).len();
    let of = |what: &str, why: &str| IdentifyError::Placement {
        what: format!("session {name}: {what}"),
        why: format!("it has {poses} pose{}; {why}", if poses == 1 { "" } else { "s" }),
    };
    let placement = place(chain, part).map_err(|error| match error {
        IdentifyError::Placement { what, why } => of(&what, &why),
        error => error,
    })?;
    let base = |open: &&Undetermined| open.what.contains("base");
    match placement.undetermined.iter().find(base) {
        Some(open) => Err(of(&open.what, &open.advice)),
        None => Ok(placement),
    }
}

/// The robot with its base to be found.
fn unplaced(chain: &Chain) -> Result<Chain, IdentifyError> {
    chain.clone().with_base(Placed { pose: Pose::IDENTITY, known: false }).map_err(wrong)
}

fn wrong(error: ChainError) -> IdentifyError {
    IdentifyError::Placement { what: "the sessions' base".into(), why: error.to_string() }
}

/// All rows in the frame of the first session.
fn common(data: &Dataset, frames: &[Pose]) -> Dataset {
    let mut data = data.clone();
    for row in 0..data.len() {
        let session = data.session(row);
        if session > 0 {
            data.carry_row(row, &frames[session]);
        }
    }
    data
}

/// A target of its own for every one that a further session measured.
fn with_own_targets(chain: &Chain, data: &mut Dataset, names: &[String]) -> Result<Chain, IdentifyError> {
    let mut targets = chain.targets().to_vec();
    for row in 0..data.len() {
        let (Some(target), session) = (data.target[row], data.session(row)) else { continue };
        if session == 0 {
            continue;
        }
        let name = own_target(&chain.targets()[target.0].name, &names[session]);
        let at = targets.iter().position(|known| known.name == name).unwrap_or_else(|| {
            let described = targets[target.0].clone();
            targets.push(Target { name, ..described });
            targets.len() - 1
        });
        data.target[row] = Some(TargetId(at));
    }
    chain.clone().with_targets(targets).map_err(wrong)
}

/// Refuses a session that no arm of this description can have measured.
fn same_arm(chain: &Chain, rms: &[Option<f64>], names: &[String]) -> Result<(), IdentifyError> {
    let best = rms.iter().flatten().fold(f64::INFINITY, |a, &b| a.min(b));
    for (name, &rms) in names.iter().zip(rms) {
        let Some(rms) = rms.filter(|&rms| rms > ANOTHER * best) else { continue };
        if rms > STRANGE * chain.characteristic_length() {
            return Err(IdentifyError::Placement {
                what: format!("session {name}: its installation"),
                why: format!(
                    "the best base leaves {:.1} mm there and {:.2} mm in the best session; it is another arm, has other joint columns, or another tool (`[sessions]`, `tool = \"own\"`)",
                    1e3 * rms,
                    1e3 * best
                ),
            });
        }
    }
    Ok(())
}

/// Says where a session has another vertical than the first.
fn tilted(chain: &Chain, frame: &Pose, name: &str) -> Option<String> {
    let gravity = chain.gravity();
    if gravity.frame == GravityFrame::Base {
        return None;
    }
    let down = gravity.vector.try_normalize(1e-12)?;
    let angle = (frame.rotation * down).cross(&down).norm().asin();
    let turned = (frame.rotation * down).dot(&down) < 0.0;
    (angle > TILTED || turned).then(|| {
        format!(
            "the vertical of session {name} is {:.1} degrees from that of the first session: loads are those of the first; give `gravity_frame = \"base\"` where the instrument, not the robot, is tilted",
            if turned { 180.0 - angle.to_degrees() } else { angle.to_degrees() }
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FitOptions, Residuals, fit};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use truepose_errormodel::effects::Geometric;
    use truepose_errormodel::{DatasetBuilder, ErrorModel, FittedModel, Measurement};
    use truepose_kinematics::nalgebra::{DMatrix, Vector3};
    use truepose_kinematics::{Conditions, samples};
    use truepose_solvers::PivotedQr;

    /// An arm with geometric errors, measured in sessions with these bases and so many poses each.
    struct Campaign {
        robot: Chain,
        truth: FittedModel,
        data: Dataset,
        names: Vec<String>,
    }

    fn campaign(poses: &[usize], seed: u64) -> Campaign {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let targets = [[0.12, 0.0, 0.03], [-0.07, 0.09, 0.0], [0.0, -0.1, 0.05]].iter().enumerate();
        let targets = targets.map(|(k, at)| Target {
            name: format!("T{k}"),
            position: Vector3::from(*at),
            known: true,
        });
        let robot = samples::ur10().with_targets(targets.collect()).unwrap();
        let arm: Vec<_> = robot.frames().collect();
        let frames = arm[1..].iter().map(|&f| truepose_errormodel::effects::Where::Frame(f)).collect();
        let errors: Box<dyn AnyEffect> = Box::new(Geometric { frames: Some(frames), components: None });
        let model = ErrorModel::new(robot.clone(), vec![errors]).unwrap();
        let coefficients: Vec<f64> =
            model.columns().iter().map(|c| c.scale * rng.random_range(-1.5..1.5)).collect();
        let count = coefficients.len();
        let truth = FittedModel::new(model, coefficients, DMatrix::zeros(count, count)).unwrap();
        let mut builder = DatasetBuilder::new(&robot);
        let (mut sessions, mut visit) = (Vec::new(), 0);
        for (session, &poses) in poses.iter().enumerate() {
            let t: [f64; 3] = std::array::from_fn(|_| rng.random_range(-3.0..3.0));
            let yaw = rng.random_range(-3.0..3.0);
            // Instruments are levelled.
            let base = Pose::from_xyz_rpy(t, [0.0, 0.0, yaw]);
            let there = robot.clone().with_base(Placed { pose: base, known: true }).unwrap();
            let there = truth.on(there).unwrap();
            let mut predictor = there.bind(&Dataset::default().schema).unwrap();
            for _ in 0..poses {
                let joints: Vec<f64> = (0..6).map(|_| rng.random_range(-2.0..2.0)).collect();
                let at = Conditions { joints: joints.clone(), ..Conditions::default() };
                for target in 0..3 {
                    let target = Some(TargetId(target));
                    let noise = Vector3::from_fn(|_, _| 2e-5 * rng.random_range(-1.7..1.7));
                    let position = predictor.predict(&at, target).translation + noise;
                    let seen = Measurement::at(joints.clone()).position(position).target(target);
                    builder.push(seen.visit(visit)).unwrap();
                    sessions.push(session as f64);
                }
                visit += 1;
            }
        }
        let mut data = builder.finish();
        data.set_sessions(Some(sessions));
        let names = (0..poses.len()).map(|k| format!("S{k}")).collect();
        Campaign { robot: unplaced(&robot).unwrap(), truth, data, names }
    }

    fn fitted(of: &Campaign, rules: SessionRules) -> (Unified, FittedModel) {
        let unified = unify(&of.robot, &of.data, &of.names, rules).unwrap();
        let placed = place(&unified.chain, &unified.data).unwrap().chain;
        let mut effects: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
        effects.extend(unified.effects.iter().cloned());
        let model = ErrorModel::new(placed, effects).unwrap();
        let found = fit(&model, &unified.data, &PivotedQr::default(), &FitOptions::default()).unwrap();
        let fitted = found.fitted.with_sessions(unified.installed.clone());
        (unified, fitted)
    }

    #[test]
    fn three_installations_are_one_arm_and_each_predicts_in_its_own_frame() {
        let of = campaign(&[40, 25, 30], 3);
        let (unified, fitted) = fitted(&of, SessionRules::default());
        assert_eq!(unified.placed.iter().map(|s| s.poses).collect::<Vec<_>>(), [40, 25, 30]);
        for session in 0..3 {
            let there = fitted.in_session(session).unwrap();
            let rows: Vec<usize> = (0..of.data.len()).filter(|&r| of.data.session(r) == session).collect();
            let part = of.data.select(&rows);
            // As it was measured, in the session's own frame, without its number.
            let mut part = part;
            part.set_sessions(None);
            let rms = Residuals::of(&there, &part).unwrap().positions().rms;
            // Noise of 2e-5 · 1.7/√3 a component.
            assert!(rms < 1.1 * 2e-5 * 1.7, "session {session}: {rms}");
        }
        // The arm is that of the truth: between targets of new poses lies what lies there in truth, whatever the installation.
        let (there, mut rng) = (fitted.in_session(2).unwrap(), ChaCha8Rng::seed_from_u64(8));
        let (mut found, mut truth) =
            (there.bind(&Default::default()).unwrap(), of.truth.bind(&Default::default()).unwrap());
        let spots: Vec<[Vector3<f64>; 2]> = (0..20)
            .map(|_| {
                let joints: Vec<f64> = (0..6).map(|_| rng.random_range(-2.0..2.0)).collect();
                let at = Conditions { joints, ..Conditions::default() };
                [&mut found, &mut truth].map(|of| of.predict(&at, Some(TargetId(0))).translation)
            })
            .collect();
        for pair in spots.windows(2) {
            let apart = |k: usize| (pair[1][k] - pair[0][k]).norm();
            assert!((apart(0) - apart(1)).abs() < 6e-5, "{} m", apart(0) - apart(1));
        }
    }

    #[test]
    fn what_cannot_be_placed_is_named() {
        let of = campaign(&[30, 1], 5);
        let mut data = of.data.select(&(0..91).collect::<Vec<_>>());
        data.record = None;
        let error = unify(&of.robot, &data, &of.names, SessionRules::default()).unwrap_err().to_string();
        assert!(error.starts_with("session S1: ") && error.contains("it has 1 pose;"), "{error}");
        // Another arm: the joint columns of the second session are those of no such arm.
        let mut other = campaign(&[30, 20], 7);
        for row in 90..other.data.len() {
            let (a, b) = (other.data.joints[1][row], other.data.joints[2][row]);
            (other.data.joints[1][row], other.data.joints[2][row]) = (b, a);
        }
        let error = unify(&other.robot, &other.data, &other.names, SessionRules::default());
        let error = error.unwrap_err().to_string();
        assert!(error.contains("session S1") && error.contains("another arm"), "{error}");
    }

    #[test]
    fn a_tool_that_was_mounted_anew_has_errors_of_its_own() {
        let mut of = campaign(&[40, 30], 11);
        let moved = Pose::from_xyz_rpy([0.004, -0.002, 0.003], [0.02, -0.03, 0.01]);
        // What the second session measures with the tool as it is mounted there.
        let fitted_truth = &of.truth;
        let chain = fitted_truth.chain().clone();
        let shifted =
            chain.targets().iter().map(|t| Target { position: moved.apply(&t.position), ..t.clone() });
        let there = fitted_truth.on(chain.clone().with_targets(shifted.collect()).unwrap()).unwrap();
        let (mut here, mut there) =
            (fitted_truth.bind(&Default::default()).unwrap(), there.bind(&Default::default()).unwrap());
        // Its base is where the rows say: move each by what the tool moves it, turned into the session's frame.
        let part = of.data.select(&(120..of.data.len()).collect::<Vec<_>>());
        let base = place(&of.robot, &part).unwrap().chain.base().pose;
        for row in 120..of.data.len() {
            let at = of.data.conditions(row);
            let target = of.data.target[row];
            let by = there.predict(&at, target).translation - here.predict(&at, target).translation;
            let p = of.data.measured_position(row) + base.rotation * by;
            of.data.position[row] = p.into();
        }
        let (_, shared) = fitted(&of, SessionRules::default());
        let (_, own) = fitted(&of, SessionRules { tool: true, ..SessionRules::default() });
        let rms = |fit: &FittedModel| {
            let mut part = of.data.select(&(120..of.data.len()).collect::<Vec<_>>());
            part.set_sessions(None);
            Residuals::of(&fit.in_session(1).unwrap(), &part).unwrap().positions().rms
        };
        assert!(rms(&own) < 6e-5 && rms(&shared) > 1e-3, "{} {}", rms(&own), rms(&shared));
    }
}

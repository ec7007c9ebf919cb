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
/// Residual of a placement with the nominal arm, in characteristic lengths, that no arm of this kind has: three times what `check` doubts.
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
    if rules.tool && chain.tools().len() > 1 {
        return Err(IdentifyError::Placement {
            what: "tool".into(),
            why: "`tool = \"own\"` is for robots with one tool; this one has several".into(),
        });
    }
    let shared = apart(chain, data, names, rules, false);
    // A tool that is turned far is no small error of the tool: where its points are is found instead.
    match shared {
        Err(_) if rules.tool && rules.base && !rules.targets && points_alone(data) => {
            apart(chain, data, names, rules, true).or(shared)
        }
        shared => shared,
    }
}

/// Whether all rows of further sessions are positions of named targets.
fn points_alone(data: &Dataset) -> bool {
    let further = (0..data.len()).filter(|&row| data.session(row) > 0);
    further.into_iter().all(|row| data.target[row].is_some() && data.measured_rotation(row).is_none())
}

/// The same; `turned` where a session's own tool is found by its points, each from nothing.
fn apart(
    chain: &Chain,
    data: &Dataset,
    names: &[String],
    rules: SessionRules,
    turned: bool,
) -> Result<Unified, IdentifyError> {
    let mut data = data.clone();
    let chain = match rules.targets || turned {
        true => with_own_targets(chain, &mut data, names, turned)?,
        false => chain.clone(),
    };
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
        if !rules.base || (chain.tools_known() && chain.targets().iter().all(|t| t.known)) {
            break;
        }
        // Tool and targets from all sessions at once, then the bases with these.
        let together = place(&chain, &common(&data, &bases.frames))?.chain;
        bases = replaced(&together, &parts, names, bases)?;
    }
    let mut remarks = Vec::new();
    if turned {
        remarks.push(
            "the tool of a further session is turned by more than an error of a tool: its targets are found there instead, and predicted orientations are those of the tool of the first session".into(),
        );
    }
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
    if rules.tool && !turned {
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

/// A target of its own for every one that a further session measured; `anywhere`, where the described position says nothing.
fn with_own_targets(
    chain: &Chain,
    data: &mut Dataset,
    names: &[String],
    anywhere: bool,
) -> Result<Chain, IdentifyError> {
    let mut targets = chain.targets().to_vec();
    for row in 0..data.len() {
        let (Some(target), session) = (data.target[row], data.session(row)) else { continue };
        if session == 0 {
            continue;
        }
        let name = own_target(&chain.targets()[target.0].name, &names[session]);
        let at = targets.iter().position(|known| known.name == name).unwrap_or_else(|| {
            let described = targets[target.0].clone();
            targets.push(Target { name, known: described.known && !anywhere, ..described });
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
mod tests;

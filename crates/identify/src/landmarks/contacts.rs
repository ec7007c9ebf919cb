//! Two points of one robot that met: a ball on one arm in a socket of the other, a bar of known length between two hands.
//!
//! ```text
//! p_a(q) = l,    p_b(q) = l                        →   (p_a − p_b)/√2 = 0
//! p_a(q) = l_a,  p_b(q) = l_b,  |l_a − l_b| = d    →   uᵀ(p_a − p_b)/√2 = d/√2,    u = (p_a − p_b)/|p_a − p_b|
//! ```
//!
//! Where they met nobody knows. Of six numbers three (five) go into that place; the right side is what is left when it is eliminated by an
//! orthogonal transformation ([`truepose_errormodel::Aim`]): a row that measured a difference of two positions, with the noise of one position and
//! as many numbers as the contact has. The second kind is a row along u, which is found anew where the robot has moved.

use crate::{IdentifyError, Residuals};
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};
use truepose_errormodel::observation::{FRAMES, KINDS};
use truepose_errormodel::{Aim, Dataset, Landmark, Ray, RobotPoint, Surroundings};
use truepose_kinematics::{Chain, Joint, JointKind, Load, Pose, ToolId};

/// A row in which two points met.
#[derive(Debug, Clone, PartialEq)]
pub struct Contact {
    /// The names of the points.
    pub between: [String; 2],
    /// The tools that carry them.
    pub tools: [ToolId; 2],
    /// Its row, or rows.
    pub rows: ContactRows,
    /// How far apart they were, m; zero where they touched.
    pub distance: f64,
}

/// How a contact stands in the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactRows {
    /// As a difference of two positions.
    Difference(usize),
    /// As two positions at a landmark of its own.
    Landmark([usize; 2]),
}

impl Contact {
    /// The rows in which it stands.
    pub fn rows(&self) -> impl Iterator<Item = usize> + use<> {
        let (first, second) = match self.rows {
            ContactRows::Difference(row) => (row, None),
            ContactRows::Landmark([a, b]) => (a, Some(b)),
        };
        std::iter::once(first).chain(second)
    }

    /// The gap between its points, m, measurement frame; where a distance is stated the error of that, along the line between them. Of residuals
    /// of its rows.
    pub fn gap(&self, residuals: &Residuals) -> Vector3<f64> {
        match self.rows {
            ContactRows::Difference(row) => -residuals.position[row] / Aim::CONTRAST,
            ContactRows::Landmark([a, b]) => residuals.position[b] - residuals.position[a],
        }
    }
}

/// The contacts of some rows, in their order.
pub(super) fn contacts(chain: &Chain, data: &Dataset) -> Result<Vec<Contact>, IdentifyError> {
    let mut contacts = Vec::new();
    for row in 0..data.len() {
        let Some(met) = data.meets(row) else { continue };
        let own = data.target[row].map_or(RobotPoint::Tool(data.tool(row)), RobotPoint::Target);
        let (between, tools) =
            ([own, met].map(|point| name(chain, point)), [own, met].map(|p| p.tool(chain)));
        if tools[0] == tools[1] {
            let why = format!(
                "{}: {} and {} are on one tool: that they met says nothing about the joints",
                line(data, row),
                between[0],
                between[1]
            );
            return Err(IdentifyError::Landmark { name: between[1].clone(), why });
        }
        let distance = data.scalar(row, 0).unwrap_or(0.0);
        contacts.push(Contact { between, tools, rows: ContactRows::Difference(row), distance });
    }
    Ok(contacts)
}

/// The rows with those of contacts as differences; `kept` (by their number) are contacts that stay as two rows at a landmark of their own, which
/// can hold a distance to another landmark.
pub(super) fn prepared(
    (chain, data, surroundings): (&Chain, &Dataset, &Surroundings),
    contacts: &[Contact],
    kept: &BTreeSet<usize>,
) -> (Dataset, Surroundings) {
    let apart: BTreeMap<usize, usize> =
        kept.iter().flat_map(|&k| contacts[k].rows().map(move |row| (row, k))).collect();
    let sides = |row: usize| if apart.contains_key(&row) { 2 } else { 1 };
    let source: Vec<usize> = (0..data.len()).flat_map(|row| std::iter::repeat_n(row, sides(row))).collect();
    // They are the whole of the record, not a part of it.
    let mut rows =
        if kept.is_empty() { data.clone() } else { Dataset { record: None, ..data.select(&source) } };
    let mut around = surroundings.clone();
    let mut landmark: Vec<Option<usize>> = source.iter().map(|&row| data.landmark(row)).collect();
    let mut tools: Vec<ToolId> = source.iter().map(|&row| data.tool(row)).collect();
    let mut meets: Vec<Option<RobotPoint>> = source.iter().map(|&row| data.meets(row)).collect();
    for at in 1..source.len() {
        let Some(met) = meets[at].filter(|_| source[at] == source[at - 1]) else { continue };
        let own = rows.target[at - 1].map_or(RobotPoint::Tool(tools[at - 1]), RobotPoint::Target);
        let [a, b] = [own, met].map(|point| name(chain, point));
        let name = format!("{a}–{b}, {}", line(data, source[at]));
        landmark[at - 1] = Some(around.landmarks.len());
        landmark[at] = landmark[at - 1];
        around.landmarks.push(Landmark { name, ..Landmark::default() });
        (meets[at - 1], meets[at]) = (None, None);
        (rows.target[at], tools[at]) = (met.target(), met.tool(chain));
        // What the row carries is on its own tool.
        rows.load[at] = Load::None;
    }
    let of_row: Vec<Option<&Contact>> =
        source.iter().map(|row| apart.get(row).map(|&k| &contacts[k])).collect();
    hold_still(chain, &mut rows, &of_row, &first_stand(contacts, data));
    rows.set_landmarks(Some(&landmark));
    rows.set_tools(chain, &tools);
    rows.set_meets(Some(&meets).filter(|of| of.iter().any(Option::is_some)).map(Vec::as_slice));
    let frames = KINDS.iter().position(|kind| *kind == FRAMES);
    rows.touch(|row| data.kind(source[row]) == frames);
    (rows, around)
}

/// Joints that carry both points move a contact as a whole and are not seen in it: in the rows of these contacts (none: no such row) they stand
/// where they stood at the first one. Otherwise a torso that turns would keep places apart at which an arm as small as a point has its hand.
fn hold_still(chain: &Chain, rows: &mut Dataset, of_row: &[Option<&Contact>], stand: &[f64]) {
    for (k, &joint) in chain.movable().iter().enumerate() {
        let frame = chain.frame_after(joint);
        let carries = |contact: &Contact| contact.tools.iter().all(|tool| chain.carries(frame, *tool));
        for (value, _) in rows.joints[k].iter_mut().zip(of_row).filter(|(_, of)| of.is_some_and(carries)) {
            *value = stand[k];
        }
    }
}

/// Joint values of the first of some contacts in this data.
fn first_stand(contacts: &[Contact], data: &Dataset) -> Vec<f64> {
    let first = contacts.first().and_then(|contact| contact.rows().next()).unwrap_or(0);
    data.joints.iter().map(|column| column[first]).collect()
}

/// Where the first point of each contact nominally is, where joints that carry both points stand still: m, measurement frame.
pub(super) fn places(
    chain: &Chain,
    data: &Dataset,
    contacts: &[Contact],
    poses: impl Fn(&Dataset) -> Result<Vec<Pose>, IdentifyError>,
) -> Result<Vec<Vector3<f64>>, IdentifyError> {
    let rows: Vec<usize> = contacts.iter().flat_map(Contact::rows).collect();
    let mut own = data.select(&rows);
    own.set_meets(None);
    let of_row: Vec<Option<&Contact>> = contacts.iter().map(Some).collect();
    hold_still(chain, &mut own, &of_row, &first_stand(contacts, data));
    Ok(poses(&own)?.iter().map(|pose| pose.translation).collect())
}

/// Takes down the rows in which the contacts stand; `landmark` says whether one of this number is of a contact.
pub(super) fn find_rows(contacts: &mut [Contact], data: &Dataset, landmark: impl Fn(usize) -> bool) {
    let mut rest = contacts.iter_mut();
    let mut first = None;
    for row in 0..data.len() {
        let rows = match data.landmark(row).filter(|k| landmark(*k)) {
            _ if data.meets(row).is_some() => ContactRows::Difference(row),
            None => continue,
            Some(_) => match first.take() {
                Some(first) => ContactRows::Landmark([first, row]),
                None => {
                    first = Some(row);
                    continue;
                }
            },
        };
        if let Some(contact) = rest.next() {
            contact.rows = rows;
        }
    }
}

/// What the rows of contacts measured, the differences of points being here: zero, or a distance along the line between the points.
pub(super) fn measured(contacts: &[Contact], at: &[Pose], data: &mut Dataset, rays: &mut [Option<Ray>]) {
    for contact in contacts {
        let ContactRows::Difference(row) = contact.rows else { continue };
        data.position[row] = [0.0; 3];
        if contact.distance > 0.0 {
            let direction = at[row].translation.try_normalize(0.0).unwrap_or_else(Vector3::x);
            let position = direction * (contact.distance * Aim::CONTRAST);
            rays[row] = Some(Ray { direction, position, sensor: None, own: Vec::new() });
        }
    }
}

/// Contacts that are kept at a landmark of their own where nothing else holds the scale, at most: as many as parts are left out in turn, so that
/// each part leaves some.
const KEPT: usize = 10;

/// Those of some contacts, at these places, that are farthest from each other: the two that are farthest apart, and again and again the
/// one that is farthest from all before.
pub(super) fn spread(at: &[Vector3<f64>]) -> BTreeSet<usize> {
    let apart = |a: usize, b: usize| (at[a] - at[b]).norm();
    let all = 0..at.len();
    let pairs = all.clone().flat_map(|a| (0..a).map(move |b| [a, b]));
    let Some(pair) = pairs.max_by(|x, y| apart(x[0], x[1]).total_cmp(&apart(y[0], y[1]))) else {
        return all.collect();
    };
    let mut nearest: Vec<f64> = all.clone().map(|k| apart(k, pair[0]).min(apart(k, pair[1]))).collect();
    let mut kept = BTreeSet::from(pair);
    while kept.len() < KEPT.min(at.len()) {
        let far =
            all.clone().filter(|k| !kept.contains(k)).max_by(|&a, &b| nearest[a].total_cmp(&nearest[b]));
        let Some(next) = far else { break };
        kept.insert(next);
        all.clone().for_each(|k| nearest[k] = nearest[k].min(apart(k, next)));
    }
    kept
}

/// Branches of the robot whose place on what carries both is taken as described, in a sentence: an error behind their first joint is none in
/// front of it.
pub(super) fn mounts(chain: &Chain, contacts: &[Contact]) -> Option<String> {
    let mut taken: Vec<&str> = Vec::new();
    for contact in contacts {
        let tools = contact.tools.map(|tool| chain.frame_of_tool(tool));
        let [Some(a), Some(b)] = tools.map(|frame| chain.path(frame)) else { continue };
        let first =
            |own: &[bool], other: &[bool]| (0..chain.joints().len()).find(|&k| own[k + 1] && !other[k + 1]);
        let both: Vec<&Joint> =
            [first(a, b), first(b, a)].into_iter().flatten().map(|k| &chain.joints()[k]).collect();
        // One mount with errors is enough: the other may be taken for where the first is.
        if both.iter().all(|joint| joint.kind != JointKind::Fixed) {
            taken.extend(both.iter().map(|joint| joint.name.as_str()));
        }
    }
    taken.dedup();
    let unique: Vec<&str> = taken
        .iter()
        .enumerate()
        .filter(|(k, name)| !taken[..*k].contains(name))
        .map(|(_, name)| *name)
        .collect();
    (!unique.is_empty()).then(|| {
        format!(
            "where {} stand to each other is taken as described: put a joint of type `fixed` in front of one of them, whose frame then has errors",
            unique.join(" and ")
        )
    })
}

fn line(data: &Dataset, row: usize) -> String {
    data.line.get(row).map_or_else(|| format!("row {}", row + 1), |line| format!("line {line}"))
}

fn name(chain: &Chain, point: RobotPoint) -> String {
    match point {
        RobotPoint::Target(target) => chain.targets().get(target.0).map(|target| target.name.clone()),
        RobotPoint::Tool(tool) => chain.tools().get(tool.0).map(|tool| tool.name.clone()),
    }
    .unwrap_or_default()
}

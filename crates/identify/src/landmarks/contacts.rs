//! Two points of one robot that met: a ball on one arm in a socket of the other, a bar of known length between two hands.
//!
//! ```text
//! p_a(q) − p_b(q) = 0            →   p_a = l,    p_b = l            l free, a landmark of this row alone
//! |p_a(q) − p_b(q)| = d          →   p_a = l_a,  p_b = l_b,  |l_a − l_b| = d
//! ```
//!
//! Both sides are rows at a landmark that nobody knows, so that effects, reduction, fit and discovery work as they are. Of six numbers three (five)
//! go into the place where they met: three (one) are left, as many as the contact has. Each side then has half of the gap.

use crate::IdentifyError;
use truepose_errormodel::observation::{FRAMES, KINDS};
use truepose_errormodel::{Dataset, KnownDistance, Landmark, RobotPoint, Surroundings};
use truepose_kinematics::{Chain, Joint, JointKind, Load, ToolId};

/// A row in which two points met.
#[derive(Debug, Clone, PartialEq)]
pub struct Contact {
    /// The names of the points.
    pub between: [String; 2],
    /// The tools that carry them.
    pub tools: [ToolId; 2],
    /// Their rows.
    pub rows: [usize; 2],
    /// How far apart they were, m; zero where they touched.
    pub distance: f64,
}

/// Each row of a contact as two rows at a landmark of its own; none without contacts.
pub(super) fn apart(
    chain: &Chain,
    data: &Dataset,
    surroundings: &Surroundings,
) -> Result<Option<(Dataset, Surroundings, Vec<Contact>)>, IdentifyError> {
    if (0..data.len()).all(|row| data.meets(row).is_none()) {
        return Ok(None);
    }
    let sides = |row: usize| if data.meets(row).is_some() { 2 } else { 1 };
    let source: Vec<usize> = (0..data.len()).flat_map(|row| std::iter::repeat_n(row, sides(row))).collect();
    // They are the whole of the record, not a part of it.
    let mut both = Dataset { record: None, ..data.select(&source) };
    let mut around = surroundings.clone();
    let mut landmark: Vec<Option<usize>> = source.iter().map(|&row| data.landmark(row)).collect();
    let mut tools: Vec<ToolId> = source.iter().map(|&row| data.tool(row)).collect();
    let mut contacts = Vec::new();
    let mut at = 0;
    for row in 0..data.len() {
        let Some(other) = data.meets(row) else {
            at += 1;
            continue;
        };
        let own = data.target[row].map_or(RobotPoint::Tool(data.tool(row)), RobotPoint::Target);
        let between = [own, other].map(|point| name(chain, point));
        let line =
            data.line.get(row).map_or_else(|| format!("row {}", row + 1), |line| format!("line {line}"));
        if tool(chain, own) == tool(chain, other) {
            let why = format!(
                "{line}: {} and {} are on one tool: that they met says nothing about the joints",
                between[0], between[1]
            );
            return Err(IdentifyError::Landmark { name: between[1].clone(), why });
        }
        let distance = data.scalar(row, 0).unwrap_or(0.0);
        let called = format!("{}–{}, {line}", between[0], between[1]);
        let first = around.landmarks.len();
        let mut add = |name: String| {
            around.landmarks.push(Landmark { name, contact: true, ..Landmark::default() });
        };
        if distance > 0.0 {
            add(format!("{} of {called}", between[0]));
            add(format!("{} of {called}", between[1]));
            around.distances.push(KnownDistance { between: [first, first + 1], value: distance, sd: 0.0 });
        } else {
            add(called);
        }
        landmark[at] = Some(first);
        landmark[at + 1] = Some(around.landmarks.len() - 1);
        both.target[at + 1] = match other {
            RobotPoint::Target(target) => Some(target),
            RobotPoint::Tool(_) => None,
        };
        tools[at + 1] = tool(chain, other);
        // What the row carries is on its own tool.
        both.load[at + 1] = Load::None;
        contacts.push(Contact {
            between,
            tools: [tool(chain, own), tool(chain, other)],
            rows: [at, at + 1],
            distance,
        });
        at += 2;
    }
    both.set_landmarks(Some(&landmark));
    both.set_tools(chain, &tools);
    both.set_meets(None);
    let frames = KINDS.iter().position(|kind| *kind == FRAMES);
    both.touch(|row| data.kind(source[row]) == frames);
    Ok(Some((both, around, contacts)))
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

fn tool(chain: &Chain, point: RobotPoint) -> ToolId {
    match point {
        RobotPoint::Target(target) => chain.targets().get(target.0).map_or(ToolId::FIRST, |t| t.tool),
        RobotPoint::Tool(tool) => tool,
    }
}

fn name(chain: &Chain, point: RobotPoint) -> String {
    match point {
        RobotPoint::Target(target) => chain.targets().get(target.0).map(|target| target.name.clone()),
        RobotPoint::Tool(tool) => chain.tools().get(tool.0).map(|tool| tool.name.clone()),
    }
    .unwrap_or_default()
}

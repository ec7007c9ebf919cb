//! What a robot file and a table say of landmarks and sensors, held against each other.

use crate::error::WorkflowError;
use std::any::Any;
use std::path::Path;
use truepose_errormodel::observation::{Camera, FRAMES, KINDS, Sphere, unknown};
use truepose_errormodel::{Dataset, Landmark, RobotPoint, Surroundings};
use truepose_io::CsvInfo;
use truepose_kinematics::{Chain, TargetId, ToolId};

/// What the robot file says of the landmarks of a table; where it names none, all of them are unknown. The rows count as it does.
pub(crate) fn declared(
    mut known: Surroundings,
    file: &Path,
    chain: &Chain,
    data: &mut Dataset,
    info: &CsvInfo,
) -> Result<Surroundings, WorkflowError> {
    let frames = |row: usize| data.kind(row).is_some_and(|kind| KINDS[kind] == FRAMES);
    let met = |k: usize| {
        let mut rows = (0..data.len()).filter(|&row| data.landmark(row) == Some(k)).peekable();
        rows.peek().is_some() && rows.all(frames)
    };
    if known.open || known.landmarks.is_empty() {
        let point = |name: &String| Landmark { name: name.clone(), ..Landmark::default() };
        let names = info.landmarks.iter().enumerate().filter(|(k, _)| !met(*k));
        let further = names.filter(|(_, name)| known.landmarks.iter().all(|known| known.name != **name));
        let further: Vec<Landmark> = further.map(|(_, name)| point(name)).collect();
        known.landmarks.extend(further);
    }
    let mut numbers = Vec::new();
    let mut meets = vec![None; data.len()];
    for (k, name) in info.landmarks.iter().enumerate() {
        let rows = (0..data.len()).filter(|&row| data.landmark(row) == Some(k));
        let first = rows.clone().next().unwrap_or(0);
        let refused = |row: usize, words: String| {
            let line = data.line.get(row).map_or(String::new(), |line| format!("{line}: "));
            WorkflowError::Input(format!("{}:{line}{words}", file.display()))
        };
        if met(k) {
            let point = robot_point(chain, name).map_err(|words| refused(first, words))?;
            rows.for_each(|row| meets[row] = Some(point));
            numbers.push(None);
            continue;
        }
        let Some(number) = known.landmarks.iter().position(|landmark| landmark.name == *name) else {
            let names: Vec<&str> = known.landmarks.iter().map(|landmark| landmark.name.as_str()).collect();
            let words = format!(
                "the robot file has no landmark `{name}`; declare it in [[landmarks]] (its landmarks: {})",
                names.join(", ")
            );
            return Err(refused(first, words));
        };
        if rows.clone().next().is_none() && (0..data.len()).any(|row| data.point(row) == Some(k)) {
            numbers.push(Some(number));
            continue;
        }
        let word = |row: usize| data.kind(row).map_or("same_point", |kind| KINDS[kind]);
        let kind = word(first);
        if let Some(other) = rows.clone().find(|&row| word(row) != kind) {
            let words = format!(
                "landmark `{name}` is of kind `{}` here and of kind `{kind}` before; give each its own name",
                word(other)
            );
            return Err(refused(other, words));
        }
        let landmark = &mut known.landmarks[number];
        let described = landmark.observed.as_ref().map(|observed| observed.kind());
        match (data.kind(first), described) {
            (None, None) => {}
            // A ball may be touched as a point as well.
            (None, Some(Sphere::KIND)) => landmark.observed = None,
            (Some(_), Some(described)) if described == kind => {}
            (Some(number), None) => {
                landmark.observed = unknown(number, landmark.position, landmark.known);
                if landmark.observed.is_none() {
                    let words = format!(
                        "camera `{name}` has to be declared in [[cameras]] of the robot file, with fx, fy, cx, cy"
                    );
                    return Err(refused(first, words));
                }
            }
            (_, Some(described)) => {
                let words = format!(
                    "landmark `{name}` is a `{described}` in the robot file, and the row is of kind `{kind}`"
                );
                return Err(refused(first, words));
            }
        }
        let observed = landmark.observed.as_deref().map(|observed| observed as &dyn Any);
        if let Some(Camera { size: Some(size), .. }) = observed.and_then(|observed| observed.downcast_ref()) {
            for row in rows.clone() {
                for (which, limit) in size.iter().enumerate() {
                    let value = data.scalar(row, which).unwrap_or(0.0);
                    if !(0.0..=*limit).contains(&value) {
                        let column = ["u[px]", "v[px]"][which];
                        let words = format!(
                            "column `{column}`: {value} is outside of the image of camera `{name}` ({} × {} px)",
                            size[0], size[1]
                        );
                        return Err(refused(row, words));
                    }
                }
            }
        }
        numbers.push(Some(number));
    }
    let of_row: Vec<Option<usize>> =
        (0..data.len()).map(|row| data.landmark(row).and_then(|k| numbers[k])).collect();
    data.set_landmarks(Some(&of_row));
    if (0..data.len()).any(|row| data.point(row).is_some()) {
        let points: Vec<Option<usize>> =
            (0..data.len()).map(|row| data.point(row).and_then(|k| numbers[k])).collect();
        data.set_points(Some(&points));
    }
    if meets.iter().any(Option::is_some) {
        data.set_meets(Some(&meets));
    }
    Ok(known)
}

/// The target or the tool of a name.
fn robot_point(chain: &Chain, name: &str) -> Result<RobotPoint, String> {
    let target = chain.targets().iter().position(|target| target.name == *name);
    let tool = || chain.tools().iter().position(|tool| tool.name == *name);
    let point = target.map(|k| RobotPoint::Target(TargetId(k)));
    point.or_else(|| tool().map(|k| RobotPoint::Tool(ToolId(k)))).ok_or_else(|| {
        let targets = chain.targets().iter().map(|target| target.name.as_str());
        let all: Vec<&str> = targets.chain(chain.tools().iter().map(|tool| tool.name.as_str())).collect();
        format!(
            "`{name}` is no point of the robot: a row of kind `frames` names the target or tool that its own met, one of {}",
            all.join(", ")
        )
    })
}

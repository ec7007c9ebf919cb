//! Several points that are read as one: reflectors of which the table does not say which row belongs to which.

use crate::error::WorkflowError;
use truepose_errormodel::{Dataset, configurations};
use truepose_io::CsvInfo;
use truepose_kinematics::Chain;
use truepose_report::count;

/// Part of the arm's length: repeats of one pose that lie farther apart are no repeats of one point.
const APART: f64 = 0.01;

/// Beyond this part of it no robot repeats.
const NO_ROBOT: f64 = 0.05;
/// Points of one tool have the same distances in all poses, to this part of them: what a robot scatters by has not.
const RIGID: f64 = 0.1;

/// Poses that are enough to say so.
const FEWEST: usize = 3;

/// Whether rows of equal joint values, load, target, tool and session measure one point.
///
/// # Errors
/// When in half of the poses that were measured more than once they lie farther apart than [`APART`], and are several points by their distances, or
/// no robot repeats so badly: what could part them is named. Otherwise a robot that scatters by so much is a warning.
pub(super) fn one_point(
    chain: &Chain,
    data: &Dataset,
    info: &CsvInfo,
) -> Result<Option<String>, WorkflowError> {
    let file = &info.file;
    let limit = APART * chain.characteristic_length();
    let of_visit = configurations(data);
    let mut groups: std::collections::BTreeMap<_, Vec<usize>> = std::collections::BTreeMap::new();
    // What was measured along one direction is no position.
    let whole = |row: &usize| data.whole_position(*row);
    for row in (0..data.len()).filter(whole) {
        let point = (data.target[row].map(|target| target.0), data.tool(row));
        let at = (of_visit[data.visit[row]], point, data.session(row));
        groups.entry(at).or_default().push(row);
    }
    groups.retain(|_, rows| rows.len() > 1);
    // All distances of each pose, ascending.
    let distances = |rows: &Vec<usize>| -> Vec<f64> {
        let apart = |a: usize, b: usize| (data.measured_position(a) - data.measured_position(b)).norm();
        let pairs = rows.iter().enumerate().flat_map(|(k, &a)| rows[..k].iter().map(move |&b| apart(a, b)));
        let mut all: Vec<f64> = pairs.collect();
        all.sort_by(f64::total_cmp);
        all
    };
    let widest = |all: &[f64]| all.last().copied().unwrap_or(0.0);
    let each: Vec<Vec<f64>> = groups.values().map(distances).filter(|all| widest(all) > limit).collect();
    if each.len() < FEWEST || 2 * each.len() < groups.len() {
        return Ok(None);
    }
    let mut far: Vec<f64> = each.iter().map(|all| widest(all)).collect();
    far.sort_by(f64::total_cmp);
    let median = far[far.len() / 2];
    if !rigid(&each) && median < NO_ROBOT * chain.characteristic_length() {
        return Ok(Some(format!(
            "{}: in {} of {} that were measured more than once the rows lie {:.1} mm apart (median): the robot repeats no better, or they are several points, which a column `target` names",
            file.display(),
            far.len(),
            count(groups.len(), "pose"),
            1e3 * median,
        )));
    }
    let texts = info.columns.iter().filter(|column| column.range.is_none() && column.meaning == "not read");
    let proposals: Vec<String> =
        texts.filter(|c| !c.name.is_empty()).map(|c| format!("--map \"target={}\"", c.name)).collect();
    let how = match proposals.as_slice() {
        [] => "add a column `target`".to_owned(),
        [one] => format!("say which: {one}"),
        several => format!("say which: one of {}", several.join(", ")),
    };
    Err(WorkflowError::Input(format!(
        "{}: in {} of {} that were measured more than once the rows lie {:.1} mm apart (median): they are several points, or the joint \
         values are not those of the rows; {how}, and declare each point in [[targets]] (with `known = false` where it is to be found)",
        file.display(),
        far.len(),
        count(groups.len(), "pose"),
        1e3 * median,
    )))
}

/// Whether most poses with equally many rows have the same distances.
fn rigid(each: &[Vec<f64>]) -> bool {
    let mut alike = 0;
    for all in each {
        let same = |other: &Vec<f64>| {
            let off = |(a, b): (&f64, &f64)| (a - b).abs() <= RIGID * a.max(*b);
            other.len() == all.len() && all.iter().zip(other).all(off)
        };
        // Itself, and one other of three.
        alike += usize::from(3 * each.iter().filter(|other| same(other)).count() > each.len().max(3));
    }
    2 * alike > each.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_one_tool_keep_their_distances() {
        let off = |k: usize| 1e-3 * ((7 * k) as f64).sin();
        let tool: Vec<Vec<f64>> =
            (0..12).map(|k| vec![0.06 + off(k), 0.1 + off(k + 3), 0.14 + off(k + 5)]).collect();
        assert!(rigid(&tool));
        // Of every other pose one reflector was not seen.
        let part: Vec<Vec<f64>> =
            tool.iter().enumerate().map(|(k, all)| all[..if k % 2 == 0 { 3 } else { 1 }].to_vec()).collect();
        assert!(rigid(&part));
        let scattered: Vec<Vec<f64>> =
            (0..12).map(|k| vec![0.016 * (1.2 + ((5 * k) as f64).sin())]).collect();
        assert!(!rigid(&scattered));
    }
}

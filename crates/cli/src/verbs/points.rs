//! Several points that are read as one: reflectors of which the table does not say which row belongs to which.

use crate::failure::Failure;
use std::path::Path;
use truepose_errormodel::{Dataset, configurations};
use truepose_io::CsvInfo;
use truepose_kinematics::Chain;
use truepose_report::count;

/// Part of the arm's length: repeats of one pose that lie farther apart are no repeats of one point.
const APART: f64 = 0.01;

/// Poses that are enough to say so.
const FEWEST: usize = 3;

/// Whether rows of equal joint values, load, target, tool and session measure one point.
///
/// # Errors
/// When in half of the poses that were measured more than once they lie farther apart than [`APART`]: what could part
/// them is named.
pub(super) fn one_point(chain: &Chain, data: &Dataset, info: &CsvInfo, file: &Path) -> Result<(), Failure> {
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
    let widest = |rows: &Vec<usize>| {
        let apart = |a: usize, b: usize| (data.measured_position(a) - data.measured_position(b)).norm();
        let pairs = rows.iter().flat_map(|&a| rows.iter().map(move |&b| apart(a, b)));
        pairs.fold(0.0, f64::max)
    };
    let mut far: Vec<f64> = groups.values().map(widest).filter(|&distance| distance > limit).collect();
    if far.len() < FEWEST || 2 * far.len() < groups.len() {
        return Ok(());
    }
    far.sort_by(f64::total_cmp);
    let texts = info.columns.iter().filter(|column| column.range.is_none() && column.meaning == "not read");
    let proposals: Vec<String> =
        texts.filter(|c| !c.name.is_empty()).map(|c| format!("--map \"target={}\"", c.name)).collect();
    let how = match proposals.as_slice() {
        [] => "add a column `target`".to_owned(),
        [one] => format!("say which: {one}"),
        several => format!("say which: one of {}", several.join(", ")),
    };
    Err(Failure::Input(format!(
        "{}: in {} of {} that were measured more than once the rows lie {:.1} mm apart (median): they are several points, or the joint \
         values are not those of the rows; {how}, and declare each point in [[targets]] (with `known = false` where it is to be found)",
        file.display(),
        far.len(),
        count(groups.len(), "pose"),
        1e3 * far[far.len() / 2],
    )))
}

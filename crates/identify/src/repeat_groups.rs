//! Which pose measurements repeat a configuration, or nearly so.

use std::collections::{BTreeMap, HashMap};
use truepose_errormodel::{Dataset, Visits, configurations};
use truepose_kinematics::Load;

/// Pose measurements of one configuration, by their number: joints within the tolerance of a dwell and the same load.
pub fn exact_repeats(data: &Dataset) -> Vec<Vec<usize>> {
    let configuration = configurations(data);
    let mut groups = vec![Vec::new(); configuration.iter().max().map_or(0, |last| last + 1)];
    configuration.iter().enumerate().for_each(|(visit, &c)| groups[c].push(visit));
    groups = of_one_session(groups, data);
    groups.retain(|group| group.len() > 1);
    groups
}

/// Groups of pose measurements, each parted by sessions: between two installations lies more than repeatability.
fn of_one_session(groups: Vec<Vec<usize>>, data: &Dataset) -> Vec<Vec<usize>> {
    let Some(session) = data.sessions() else { return groups };
    let visits = Visits::of(data);
    let of = |visit: usize| visits.rows[visit].first().map_or(0, |&row| session[row].to_bits());
    let mut parted = Vec::new();
    for group in groups {
        let mut by_session: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
        group.into_iter().for_each(|visit| by_session.entry(of(visit)).or_default().push(visit));
        parted.extend(by_session.into_values());
    }
    parted
}

/// Pose measurements whose joints are within a tolerance (rad or m, for each movable joint) of the first of their group, under the same
/// load. A pose measurement that follows another one of the same group does not count: the robot has not come to it anew.
pub fn near_repeats(data: &Dataset, tolerance: &[f64]) -> Vec<Vec<usize>> {
    let visits = Visits::of(data);
    // As configurations of a data set are looked up: what is within all tolerances is in the same cell or in one beside it.
    let weight: Vec<f64> =
        (0..data.joints.len()).map(|k| 0.5 + (0.618_033_988_749_895 * k as f64).fract()).collect();
    let width: f64 = weight.iter().sum::<f64>() * (1.0 + 1e-9) + 1e-3;
    let cell = |row: usize| {
        let joints = data.joints.iter().zip(&weight).zip(tolerance);
        (joints.map(|((q, w), tolerance)| w * q[row] / tolerance.max(1e-12)).sum::<f64>() / width).floor()
            as i64
    };
    let near = |a: usize, b: usize| {
        let close = data.joints.iter().zip(tolerance).all(|(q, tolerance)| (q[a] - q[b]).abs() <= *tolerance);
        let loads = (&data.load[a], &data.load[b]);
        close
            && data.same_session(a, b)
            && (matches!(loads, (Load::Wrench(_), Load::Wrench(_))) || loads.0 == loads.1)
    };
    let mut cells: HashMap<i64, Vec<usize>> = HashMap::new();
    let mut groups: Vec<Vec<usize>> = Vec::new();
    // Last pose measurement in the neighbourhood of each group, counted or not.
    let mut last: Vec<usize> = Vec::new();
    for (visit, rows) in visits.rows.iter().enumerate() {
        let Some(&row) = rows.first() else { continue };
        let own = cell(row);
        let beside = (-1..=1).filter_map(|step| cells.get(&own.saturating_add(step))).flatten();
        match beside.copied().filter(|&g| near(visits.rows[groups[g][0]][0], row)).min() {
            Some(group) => {
                if last[group] + 1 != visit {
                    groups[group].push(visit);
                }
                last[group] = visit;
            }
            None => {
                cells.entry(own).or_default().push(groups.len());
                groups.push(vec![visit]);
                last.push(visit);
            }
        }
    }
    groups.retain(|group| group.len() > 1);
    groups
}

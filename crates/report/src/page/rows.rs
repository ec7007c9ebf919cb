//! What a page shows of every row: its errors before and after, and the inputs under which it was measured.

use crate::figure::{range, unit_text};
use crate::largest::label;
use std::collections::BTreeSet;
use truepose_errormodel::{Dataset, is_derived};
use truepose_identify::Residuals;
use truepose_kinematics::{Chain, Load, PostureBuffer};

/// Rows of a data set with their errors; all columns have one length.
#[derive(Debug, Clone, Default)]
pub(crate) struct Rows {
    /// Measured − predicted before, mm; NaN where not measured.
    pub before: Vec<[f64; 3]>,
    /// The same after.
    pub after: Vec<[f64; 3]>,
    /// Measured position, mm.
    pub place: Vec<[f64; 3]>,
    /// Rows with a held-out error.
    pub held_out: Vec<bool>,
    /// Number of the row in the data (0-based).
    pub row: Vec<usize>,
    /// Line of the file, where the data came from one.
    pub line: Vec<Option<u64>>,
    /// Label of the pose measurement in the file.
    pub visit: Vec<String>,
    /// Joints, load, time, channels.
    pub inputs: Vec<Input>,
    /// How many of the inputs, the first ones, are joints.
    pub joints: usize,
    /// True when nothing was added: before and after are the same.
    pub same: bool,
}

/// An input in the unit in which it is shown.
#[derive(Debug, Clone)]
pub(crate) struct Input {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// A value a row.
    pub values: Vec<f64>,
}

impl Input {
    /// Name and unit.
    pub(crate) fn title(&self) -> String {
        if self.unit.is_empty() { self.name.clone() } else { format!("{}, {}", self.name, self.unit) }
    }

    /// Value of a row, rounded to a thousandth of the range.
    pub(crate) fn shown(&self, k: usize) -> String {
        let [low, high] = range(&self.values);
        let decimals = (3.0 - (high - low).max(1e-9).log10().ceil()).clamp(0.0, 6.0) as usize;
        let value = self.values[k];
        if value.is_finite() { format!("{:.decimals$}", value + 0.0) } else { "–".into() }
    }

    /// Whether the input takes more than one value, beyond the rounding of a coupled joint's.
    fn varies(&self) -> bool {
        let mut values = self.values.iter().filter(|v| v.is_finite());
        let first = values.next().copied();
        first.is_some_and(|first| values.any(|v| (v - first).abs() > 1e-12 * first.abs().max(1.0)))
    }
}

/// Where these rows were measured, mm; of two points that met where the first of them nominally is.
fn places(chain: &Chain, data: &Dataset, rows: &[usize]) -> Vec<[f64; 3]> {
    let mut buffer = PostureBuffer::new(chain);
    let mut place = |&row: &usize| -> [f64; 3] {
        let at: [f64; 3] = match data.meets(row) {
            None => data.position[row],
            Some(_) => {
                let conditions = data.conditions(row);
                let tool = buffer.update(chain, &conditions).tool();
                let target = data.target[row].map(|t| chain.targets()[t.0].position);
                target.map_or(tool.translation, |target| tool.apply(&target)).into()
            }
        };
        at.map(|v| v * 1e3)
    };
    rows.iter().map(&mut place).collect()
}

impl Rows {
    /// Errors and inputs of these rows of the data; residuals are in the order of `rows`.
    pub(crate) fn new(
        chain: &Chain,
        data: &Dataset,
        labels: &[i64],
        rows: &[usize],
        held_out: &[bool],
        before: &Residuals,
        after: &Residuals,
    ) -> Self {
        let mm = |r: &Residuals| r.position.iter().map(|v| [v.x * 1e3, v.y * 1e3, v.z * 1e3]).collect();
        let (before, after): (Vec<[f64; 3]>, Vec<[f64; 3]>) = (mm(before), mm(after));
        let bits = |list: &[[f64; 3]]| list.iter().flatten().map(|v| v.to_bits()).collect::<Vec<_>>();
        let same = bits(&before) == bits(&after);
        let (inputs, joints) = inputs(chain, data, rows);
        Rows {
            before,
            after,
            place: places(chain, data, rows),
            held_out: held_out.to_vec(),
            row: rows.to_vec(),
            line: rows.iter().map(|&row| data.line.get(row).copied()).collect(),
            visit: rows.iter().map(|&row| label(data, labels, row)).collect(),
            inputs,
            joints,
            same,
        }
    }

    /// Errors with their titles: before and after, or one of them where both are the same.
    pub(crate) fn shown<'a>(&'a self, titles: [&'a str; 2]) -> Vec<(&'a str, &'a [[f64; 3]])> {
        let both = [(titles[0], self.before.as_slice()), (titles[1], self.after.as_slice())];
        both.into_iter().take(if self.same { 1 } else { 2 }).collect()
    }

    /// Number of rows.
    pub(crate) fn len(&self) -> usize {
        self.row.len()
    }
}

/// Length of an error over its components that were measured; NaN where none was.
pub(crate) fn length(v: &[f64; 3]) -> f64 {
    truepose_identify::distance(&(*v).into()).unwrap_or(f64::NAN)
}

/// Seconds above which a time counts from 1970 and not from the begin of a campaign: three years.
const DATED: f64 = 1e8;

/// Inputs that vary (joints, payload, time or order, channels), and how many of them are joints.
fn inputs(chain: &Chain, data: &Dataset, rows: &[usize]) -> (Vec<Input>, usize) {
    let pick = |column: &[f64], factor: f64| rows.iter().map(|&row| column[row] * factor).collect::<Vec<_>>();
    let mut list = Vec::new();
    // As the controller shows them: a coupled joint's variable has others in it.
    let values = |&row: &usize| -> Vec<f64> {
        let mut values: Vec<f64> = data.joints.iter().map(|column| column[row]).collect();
        chain.joints_to_controller(&mut values);
        values
    };
    let values: Vec<Vec<f64>> = rows.iter().map(values).collect();
    for (k, &joint) in chain.movable().iter().enumerate().take(data.joints.len()) {
        let joint = chain.joint(joint);
        let (factor, unit) = if joint.unit() == "m" { (1e3, "mm") } else { (1f64.to_degrees(), "°") };
        let values = values.iter().map(|values| values[k] * factor).collect();
        list.push(Input { name: joint.name.clone(), unit: unit.into(), values });
    }
    list.retain(Input::varies);
    let joints = list.len();
    let mass: Vec<f64> = data
        .load
        .iter()
        .map(|load| match load {
            Load::Payload(payload) => payload.mass,
            Load::Wrench(_) => f64::NAN,
            Load::None => 0.0,
        })
        .collect();
    list.push(Input { name: "payload".into(), unit: "kg".into(), values: pick(&mass, 1.0) });
    if data.schema.time {
        let first = data.time.iter().copied().fold(f64::INFINITY, f64::min);
        // Dates are seconds since 1970, of which an axis would show nine equal digits.
        let (name, from) = if first > DATED { ("time since the first row", first) } else { ("time", 0.0) };
        let values = pick(&data.time, 1.0).into_iter().map(|time| time - from).collect();
        list.push(Input { name: name.into(), unit: "s".into(), values });
    } else {
        let order: Vec<f64> = data.visit.iter().map(|v| (v + 1) as f64).collect();
        list.push(Input {
            name: "order of pose measurements".into(),
            unit: String::new(),
            values: pick(&order, 1.0),
        });
    }
    for (channel, column) in data.schema.channels.iter().zip(&data.channels) {
        if !is_derived(&channel.name) {
            let (name, unit) = (channel.name.clone(), unit_text(&channel.unit));
            list.push(Input { name, unit, values: pick(column, 1.0) });
        }
    }
    list.retain(Input::varies);
    (list, joints)
}

/// Rows of the data that are not among these, ascending.
pub(crate) fn complement(data: &Dataset, rows: &[usize]) -> Vec<usize> {
    let out: BTreeSet<usize> = rows.iter().copied().collect();
    (0..data.len()).filter(|row| !out.contains(row)).collect()
}

/// Residuals of two parts as one: (row, whether of the second part, number in its part).
pub(crate) fn merged(order: &[(usize, bool, usize)], first: &Residuals, second: &Residuals) -> Residuals {
    let part = |second_part: bool| if second_part { second } else { first };
    Residuals {
        position: order.iter().map(|&(_, of_second, k)| part(of_second).position[k]).collect(),
        orientation: order.iter().map(|&(_, of_second, k)| part(of_second).orientation[k]).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::{Coupling, JointId, samples};

    #[test]
    fn a_coupled_joint_is_shown_as_the_controller_has_it() {
        let coupling = Coupling { joint: JointId(3), driver: JointId(2), factor: 1.0 };
        let chain = samples::ur10().with_couplings(vec![coupling]).unwrap();
        // The controller's third value stays, while the second moves: the variable follows it.
        let mut data = Dataset { joints: vec![vec![0.0; 3]; 6], ..Dataset::default() };
        data.joints[1] = vec![0.1, 0.3, 0.7];
        data.joints[2] = data.joints[1].iter().map(|second| second + 0.4).collect();
        (data.visit, data.load) = (vec![0, 1, 2], vec![Load::None; 3]);
        let (shown, joints) = inputs(&chain, &data, &[0, 1, 2]);
        assert_eq!((joints, shown[0].name.as_str()), (1, "j2"));
        assert_eq!(shown[0].values, [0.1, 0.3, 0.7].map(f64::to_degrees));
        data.joints[2][2] += 0.2;
        let third = inputs(&chain, &data, &[0, 1, 2]).0[1].clone();
        let wanted = [0.4_f64, 0.4, 0.6].map(f64::to_degrees);
        assert_eq!(third.name, "j3");
        assert!(third.values.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-9), "{third:?}");
    }
}

//! Extrapolation: inputs beyond the data of the fit, targets and orientations that were not measured.

use std::collections::BTreeMap;
use truepose_errormodel::{Beyond, Channel, FittedModel, TargetKnown};
use truepose_kinematics::{Chain, TargetId};
use truepose_report::{count, significant};

/// A fit without the range of its data.
pub const NO_RANGE: &str = "the fit does not record the range of its data: extrapolation is not detected";

/// How many rows lie beyond the data of a fit, input by input, and by how much.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    rows: usize,
    beyond: usize,
    inputs: BTreeMap<Beyond, (usize, f64)>,
}

impl Tally {
    /// Takes in a row.
    pub fn add(&mut self, beyond: &[(Beyond, f64)]) {
        self.rows += 1;
        self.beyond += usize::from(!beyond.is_empty());
        for &(what, by) in beyond {
            let (rows, most) = self.inputs.entry(what).or_insert((0, 0.0));
            *rows += 1;
            *most = most.max(by);
        }
    }

    /// Takes in other rows.
    pub fn join(&mut self, other: &Tally) {
        self.rows += other.rows;
        self.beyond += other.beyond;
        for (&what, &(more, by)) in &other.inputs {
            let (rows, most) = self.inputs.entry(what).or_insert((0, 0.0));
            *rows += more;
            *most = most.max(by);
        }
    }

    /// Rows that lie beyond.
    pub fn beyond(&self) -> usize {
        self.beyond
    }

    /// A warning that counts in `thing`s (`row`, `command`, `place`); none where nothing lies beyond.
    pub fn warning(&self, thing: &str, chain: &Chain, channels: &[Channel]) -> Option<String> {
        if self.beyond == 0 {
            return None;
        }
        let one = |(&what, &(rows, by)): (&Beyond, &(usize, f64))| {
            format!("{} in {rows} ({})", name(what, chain, channels), amount(what, by, chain, channels))
        };
        let list: Vec<String> = self.inputs.iter().map(one).collect();
        Some(format!(
            "{} of {} beyond the data of the fit, where the model extrapolates: {}",
            self.beyond,
            count(self.rows, thing),
            list.join(", ")
        ))
    }
}

/// The inputs of a row, as its cell has them.
pub fn words(beyond: &[(Beyond, f64)], chain: &Chain, channels: &[Channel]) -> String {
    let names: Vec<&str> = beyond.iter().map(|&(what, _)| name(what, chain, channels)).collect();
    names.join("; ")
}

fn name<'a>(what: Beyond, chain: &'a Chain, channels: &'a [Channel]) -> &'a str {
    match what {
        Beyond::Joint(k) => &chain.joint(chain.movable()[k]).name,
        Beyond::Payload => "payload",
        Beyond::Time => "time",
        Beyond::Channel(k) => channels.get(k).map_or("channel", |channel| &channel.name),
        Beyond::Leverage => "leverage",
    }
}

fn amount(what: Beyond, by: f64, chain: &Chain, channels: &[Channel]) -> String {
    let (by, unit) = match what {
        Beyond::Joint(k) if chain.joint(chain.movable()[k]).unit() == "m" => (1e3 * by, "mm"),
        Beyond::Joint(_) => (by.to_degrees(), "deg"),
        Beyond::Payload => (by, "kg"),
        Beyond::Time => (by, "s"),
        Beyond::Channel(k) => (by, channels.get(k).map_or("", |channel| channel.unit.as_str())),
        Beyond::Leverage => {
            return format!("standard deviation up to {} × the largest in the data", significant(by, 3));
        }
    };
    format!("by up to {} {unit}", significant(by, 3))
}

/// Whether the position of a target on the tool is known; a warning where it was declared and never measured.
///
/// # Errors
/// When it was to be estimated from the data and was not in it.
pub fn seen(fitted: &FittedModel, target: Option<TargetId>) -> Result<Option<String>, String> {
    let chain = fitted.chain();
    let what = match target {
        Some(t) => format!("target `{}`", chain.targets()[t.0].name),
        None => "the tool's origin".into(),
    };
    match fitted.target_known(target) {
        TargetKnown::Measured => Ok(None),
        TargetKnown::Declared => Ok(Some(format!(
            "{what} was not measured in the data of the fit: its position on the tool is as declared, without an estimated correction"
        ))),
        TargetKnown::Undetermined => Err(format!(
            "{what} was not measured in the data of the fit, and its position was to be estimated from it (`known = false`): \
             it is unknown. Measure it and fit again, or use a target that was measured"
        )),
    }
}

/// Whether the orientation of the tool is known; a warning where it was declared and never measured.
///
/// # Errors
/// When it was to be found from positions that do not determine it.
pub fn oriented(fitted: &FittedModel) -> Result<Option<String>, String> {
    match fitted.orientation_known() {
        TargetKnown::Measured => Ok(None),
        TargetKnown::Declared => Ok(Some(
            "the data of the fit has no orientations: the orientation of the tool is as declared, and not verified".into(),
        )),
        TargetKnown::Undetermined => Err(
            "the data of the fit has no orientations, and the orientation of the tool was to be estimated from it (`known = false`): \
             positions do not determine it. Fit with orientations, or declare the tool"
                .into(),
        ),
    }
}

/// A band, where it has a bound.
pub fn bounded(within_95: f64) -> Option<f64> {
    within_95.is_finite().then_some(within_95)
}

/// What is stated of bands without a bound.
pub fn unbounded(rows: usize, thing: &str) -> Option<String> {
    (rows > 0).then(|| {
        format!(
            "the data of the fit does not determine the orientation of the tool (positions of fewer than three points of it): at a point that was \
             not measured the 95 % band is unbounded in {} (`within_95` is empty). Measure orientations, or three points of the tool",
            count(rows, thing)
        )
    })
}

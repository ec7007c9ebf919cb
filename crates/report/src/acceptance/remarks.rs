//! Remarks in words.

use crate::{count, significant};
use truepose_acceptance::Remark;

/// A sentence or two.
pub(super) fn sentence(remark: &Remark) -> String {
    let mm = |metres: f64| format!("{} mm", significant(1e3 * metres, 2));
    match remark {
        Remark::FewCycles { fewest } => {
            format!("ISO 9283 asks for 30 cycles of each pose; some pose has {fewest}. The intervals take that into account.")
        }
        Remark::NotFivePoses { poses } => {
            format!("ISO 9283 asks for five poses in the plane of a cube; {} measured repeatedly.", were(*poses, "pose"))
        }
        Remark::FewPlaces { poses } => format!(
            "{} too few to judge the accuracy over a workspace: the figures hold at these poses. For a statement about 95 % of the \
             workspace with 95 % confidence, 59 random poses are needed at the least (`identify --spec`).",
            if *poses == 1 { "One pose is".into() } else { format!("{poses} poses are") }
        ),
        Remark::LoadNotStated => {
            "The load is not stated (columns payload, fx …): ISO 9283 asks for the rated load, and optionally 10 % of it.".into()
        }
        Remark::SeveralLoads => "Poses were measured under different loads; ISO 9283 asks for one load in a test.".into(),
        Remark::SpeedNotStated => {
            "The speed is not stated (column `speed`): ISO 9283 asks for 100 % of the rated speed, and optionally 50 % and 10 %."
                .into()
        }
        Remark::BestFit { poses } => format!(
            "Frames were aligned by a best fit of {} to the commanded positions: six unknowns are taken from the same data, and AP is \
             smaller than against an independently measured base. AD does not depend on the alignment.",
            count(*poses, "attained position")
        ),
        Remark::NoCommonUncertainty => {
            "No uncertainty of the instrument is stated (--instrument): the uncertainties below contain the scatter of the cycles alone."
                .into()
        }
        Remark::Instrument { expanded, figure, symbol } => format!(
            "The expanded uncertainty of the instrument ({}) is more than a quarter of the smallest figure ({symbol} = {}), the limit of \
             ISO 9283.",
            mm(*expanded),
            mm(*figure)
        ),
        Remark::Dependent { pose, correlation } => format!(
            "Successive cycles of {pose} are correlated ({}): robot or instrument drifts, and the intervals are too narrow. See dAP.",
            significant(*correlation, 2)
        ),
        Remark::Directions { pose, directions } => format!(
            "{pose} was approached from {directions} directions: AP and RP are of the direction with the most cycles, vAP is the difference."
        ),
        Remark::PartlyMeasured { rows } => {
            format!("{} without a whole position: left out.", count(*rows, "row"))
        }
        Remark::MeasuredOnce { poses } => {
            format!("{} measured once: left out.", were(*poses, "pose"))
        }
        Remark::FewPathCycles { cycles } => {
            format!("ISO 9283 asks for ten cycles of a path; it has {cycles}.")
        }
        other => format!("{other:?}"),
    }
}

fn were(number: usize, noun: &str) -> String {
    format!("{} {}", count(number, noun), if number == 1 { "was" } else { "were" })
}

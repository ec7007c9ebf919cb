//! Folds of the options of a verb.

use crate::args::SplitKind;
use crate::failure::Failure;
use crate::terminal;
use truepose_errormodel::{Dataset, configurations};
use truepose_identify::Split;

/// Different pairs of joint values and load.
pub(super) fn different(data: &Dataset) -> usize {
    configurations(data).iter().max().map_or(0, |last| last + 1)
}

/// The split of the options, with no more folds than configurations.
pub(super) fn split(
    folds: usize,
    kind: SplitKind,
    seed: u64,
    configurations: usize,
) -> Result<Option<Split>, Failure> {
    if folds == 0 {
        return Ok(None);
    }
    if folds == 1 {
        return Err(Failure::Input(
            "--folds: one fold leaves no data to fit; use 2 or more, or 0 for none".into(),
        ));
    }
    if configurations < 2 {
        terminal::log("warning: a single configuration cannot be divided: no cross-validation");
        return Ok(None);
    }
    if configurations < folds {
        terminal::log(&format!(
            "warning: {configurations} configurations make at most {configurations} folds"
        ));
    }
    let folds = folds.min(configurations);
    Ok(Some(match kind {
        SplitKind::Random => Split::Random { folds, seed },
        SplitKind::Time => Split::TimeBlocks { folds },
        SplitKind::Joint => Split::JointBlocks { folds, coordinate: None },
        SplitKind::LeaveOneOut => Split::LeaveOneOut,
    }))
}

/// How a split makes its folds.
pub(crate) fn split_words(split: &Split) -> String {
    match split {
        Split::Random { folds, seed } => format!("{folds} random folds over configurations, seed {seed}"),
        Split::LeaveOneOut => "one configuration at a time".into(),
        Split::TimeBlocks { folds } => format!("{folds} contiguous blocks in time"),
        Split::JointBlocks { folds, .. } => format!("{folds} slabs along the joint that moves most"),
        Split::Given(of_visit) => {
            let folds = of_visit.iter().max().map_or(0, |last| last + 1);
            format!("{folds} folds as given by a channel")
        }
    }
}

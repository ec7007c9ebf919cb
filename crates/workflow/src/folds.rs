//! How configurations are divided into folds.

use crate::error::WorkflowError;
use truepose_errormodel::{Dataset, Visits, configurations};
use truepose_identify::{Split, hold_out};

/// How folds are made of configurations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SplitKind {
    /// At random.
    #[default]
    Random,
    /// Contiguous blocks in time.
    Time,
    /// Slabs along the joint that moves most.
    Joint,
    /// One configuration at a time.
    LeaveOneOut,
}

impl SplitKind {
    /// All, with their words.
    pub const WORDS: [(&str, SplitKind); 4] = [
        ("random", SplitKind::Random),
        ("time", SplitKind::Time),
        ("joint", SplitKind::Joint),
        ("leave-one-out", SplitKind::LeaveOneOut),
    ];

    /// That of a word.
    ///
    /// # Errors
    /// When there is none; names those that there are.
    pub fn named(word: &str) -> Result<Self, WorkflowError> {
        let known = Self::WORDS.iter().find(|(known, _)| *known == word);
        known.map(|(_, kind)| *kind).ok_or_else(|| {
            let words = Self::WORDS.map(|(word, _)| word).join(", ");
            WorkflowError::option("split", format!("unknown `{word}` (known: {words})"))
        })
    }
}

/// The folds of a cross-validation.
#[derive(Debug, Clone, PartialEq)]
pub enum FoldsRequest {
    /// So many, or as many as there are configurations; none of 0.
    Count(usize, SplitKind),
    /// Numbered by a channel of the data, with one value for each pose measurement.
    Channel(String),
    /// Given for each pose measurement.
    Given(Split),
}

impl Default for FoldsRequest {
    fn default() -> Self {
        FoldsRequest::Count(5, SplitKind::Random)
    }
}

/// Different pairs of joint values and load.
pub fn different(data: &Dataset) -> usize {
    configurations(data).iter().max().map_or(0, |last| last + 1)
}

/// The split of a request, and a warning where there are fewer folds than requested. A test set is drawn first where there is one.
///
/// # Errors
/// When there would be one fold, the channel is not there or changes within a pose measurement, or no test set can be drawn.
pub fn split(
    data: &Dataset,
    folds: &FoldsRequest,
    seed: u64,
    holdout: Option<f64>,
) -> Result<(Option<Split>, Option<String>), WorkflowError> {
    let (folds, kind) = match folds {
        FoldsRequest::Channel(name) => return Ok((Some(of_channel(data, name)?), None)),
        FoldsRequest::Given(split) => return Ok((Some(split.clone()), None)),
        FoldsRequest::Count(folds, kind) => (*folds, *kind),
    };
    let have = in_fit(data, holdout, seed)?;
    match folds {
        0 => return Ok((None, None)),
        1 => {
            return Err(WorkflowError::option(
                "folds",
                "one fold leaves no data to fit; use 2 or more, or 0 for none",
            ));
        }
        _ => {}
    }
    if have < 2 {
        return Ok((None, Some("a single configuration cannot be divided: no cross-validation".into())));
    }
    let fewer = (have < folds).then(|| format!("{have} configurations make at most {have} folds"));
    let folds = folds.min(have);
    let split = match kind {
        SplitKind::Random => Split::Random { folds, seed },
        SplitKind::Time => Split::TimeBlocks { folds },
        SplitKind::Joint => Split::JointBlocks { folds, coordinate: None },
        SplitKind::LeaveOneOut => Split::LeaveOneOut,
    };
    Ok((Some(split), fewer))
}

/// Number of configurations that are not in the held-out test set.
fn in_fit(data: &Dataset, holdout: Option<f64>, seed: u64) -> Result<usize, WorkflowError> {
    let Some(fraction) = holdout else { return Ok(different(data)) };
    let (left, _) = hold_out(data, fraction, seed)?;
    let of_visit = configurations(data);
    let mut seen: Vec<usize> = left.iter().map(|&row| of_visit[data.visit[row]]).collect();
    seen.sort_unstable();
    seen.dedup();
    Ok(seen.len())
}

/// Folds numbered by a channel.
fn of_channel(data: &Dataset, channel: &str) -> Result<Split, WorkflowError> {
    let refused = |words: String| WorkflowError::option("fold-by", words);
    let Some(k) = data.schema.channel(channel) else {
        let known: Vec<&str> = data.schema.channels.iter().map(|c| c.name.as_str()).collect();
        let known = match known.is_empty() {
            true => "it has none".into(),
            false => format!("its channels: {}", known.join(", ")),
        };
        return Err(refused(format!("the data has no channel `{channel}` ({known})")));
    };
    let mut numbers: Vec<f64> = Vec::new();
    let mut of_visit = Vec::new();
    for rows in &Visits::of(data).rows {
        let value = data.channels[k][rows[0]];
        if rows.iter().any(|&row| data.channels[k][row].to_bits() != value.to_bits()) {
            let words = "changes within a visit (pose measurement); a fold takes whole visits";
            return Err(refused(format!("`{channel}` {words}")));
        }
        let place = numbers.iter().position(|n| n.to_bits() == value.to_bits()).unwrap_or_else(|| {
            numbers.push(value);
            numbers.len() - 1
        });
        of_visit.push(place);
    }
    if numbers.len() < 2 {
        return Err(refused(format!("`{channel}` has a single value; at least two folds are needed")));
    }
    Ok(Split::Given(of_visit))
}

/// How a split makes its folds, in words.
pub fn split_words(split: &Split) -> String {
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

//! What is wrong with a landmark or a sensor, and not with the robot.

use crate::significant;
use crate::wording::p_text;
use serde::{Deserialize, Serialize};
use truepose_errormodel::Dataset;
use truepose_identify::Suspect;

/// A landmark or a sensor that is not what it was taken for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SuspectSummary {
    /// Its name.
    pub name: String,
    /// `moved`, `mounted` (the tool or the base sits differently), `row` (one row is elsewhere), or what was taken as given: `place`, `direction`, `flatness`, `lens`, `radius`, `gain`, `gain and offset`.
    pub what: String,
    /// The line of the data from which on it has moved, or that is elsewhere; null of what is wrong throughout.
    pub from_line: Option<u64>,
    /// The landmark that such a line touched in truth, where one lies there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instead: Option<String>,
    /// By how much: name, value, half its 95 % interval, unit (mm, mrad, px, 1, 1/m).
    pub values: Vec<(String, f64, f64, String)>,
    /// RMS over its rows of what that explains, in `unit`.
    pub rms: f64,
    /// `mm` or `px`.
    pub unit: String,
    /// Of all such tests together.
    pub p_value: f64,
}

/// Of a normal distribution, 95 % lie within so many standard deviations.
const WITHIN_95: f64 = 1.96;

impl SuspectSummary {
    /// Of rows that measured pixels, or lengths.
    pub fn new(found: &Suspect, data: &Dataset, pixels: bool) -> Self {
        let value = |(name, value, sd, unit): &(String, f64, f64, String)| {
            let (scale, unit) = match unit.as_str() {
                "m" => (1e3, "mm"),
                "rad" => (1e3, "mrad"),
                unit => (1.0, unit),
            };
            (name.clone(), scale * value, WITHIN_95 * scale * sd, unit.to_owned())
        };
        SuspectSummary {
            name: found.name.clone(),
            what: found.what.into(),
            from_line: found.from.map(|row| data.line.get(row).map_or(row as u64 + 1, |&line| line)),
            instead: found.instead.clone(),
            values: found.values.iter().map(value).collect(),
            rms: if pixels { found.size } else { 1e3 * found.size },
            unit: if pixels { "px" } else { "mm" }.into(),
            p_value: found.p_value,
        }
    }

    /// What is wrong, and what to do about it, in two sentences.
    pub fn sentence(&self) -> String {
        let (what, advice) = self.words();
        format!(
            "{what}: {} {} RMS at its rows ({}). {advice}",
            significant(self.rms, 2),
            self.unit,
            p_text(self.p_value)
        )
    }

    /// What is wrong, by how much, and what to do about it.
    fn words(&self) -> (String, &'static str) {
        let name = &self.name;
        let (what, advice) = match self.what.as_str() {
            "moved" => (
                format!(
                    "rows of {name} from about line {} on lie elsewhere than those before",
                    self.from_line.unwrap_or(0)
                ),
                "It may have moved, or been touched otherwise: look at its mount, name it differently from there on, and compare. Where several are told, the robot's base or its tool may have moved.",
            ),
            "mounted" => (
                format!("{name} sits differently from about line {} on", self.from_line.unwrap_or(0)),
                "It was mounted again, or struck: look at its seat, and fit the lines before and after apart.",
            ),
            "row" => {
                let line = self.from_line.unwrap_or(0);
                match &self.instead {
                    Some(other) => (
                        format!("line {line} names {name} and lies at {other}"),
                        "Correct the name, or leave the line out.",
                    ),
                    None => (
                        format!("line {line} lies elsewhere than the other rows of {name}"),
                        "Measure it again, or leave the line out.",
                    ),
                }
            }
            "place" => (
                format!("{name} is not where it is said to be"),
                "Measure its place, or let it be found: leave `known = true` out.",
            ),
            "flatness" => (
                format!("{name} is not flat"),
                "Measure its shape, or probe a smaller part of it; its rows count little as they are.",
            ),
            "lens" => (
                format!("{name} has another lens than stated"),
                "Look whether values are exchanged; calibrate its intrinsics, or free them (free = [\"intrinsics\"]).",
            ),
            "radius" => {
                (format!("{name} has another radius than stated"), "Measure it, or leave `radius` out.")
            }
            other => (
                format!("{name} has another {other} than stated"),
                "Calibrate it, or declare what is unknown of it (`free`).",
            ),
        };
        let value = |(name, value, half, unit): &(String, f64, f64, String)| {
            let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
            format!("{name} {} ± {}{unit}", significant(*value, 3), significant(*half, 2))
        };
        // The three numbers of a bend are none that a person can picture.
        let values: Vec<String> = match self.what.as_str() {
            "flatness" => Vec::new(),
            _ => self.values.iter().map(value).collect(),
        };
        let by = if values.is_empty() { String::new() } else { format!(", by {}", values.join(", ")) };
        (format!("{what}{by}"), advice)
    }
}

/// What observed the robot was allowed not to be as described, and the error of the robot that would explain the same.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AllowedSummary {
    /// What was allowed for, as it was suspected beside the declared model.
    pub suspects: Vec<SuspectSummary>,
    /// What a search finds in the robot where nothing is allowed for; empty: nothing.
    pub instead: Vec<String>,
    /// Error on held-out rows, kind by kind.
    pub kinds: Vec<AllowedKind>,
    /// Of this against an effect of the robot, by how likely each makes the held-out rows.
    pub probability: f64,
    /// Whether the result is that of the search with this allowed for.
    pub preferred: bool,
}

/// A kind of observation on held-out rows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AllowedKind {
    /// `position`, `pixel`, …
    pub kind: String,
    /// `mm` or `px`.
    pub unit: String,
    /// RMS with the observers as described, and the effects of the robot that a search then finds.
    pub as_described: f64,
    /// RMS with what was allowed for, and the effects that a search finds beside it.
    pub allowed: f64,
}

impl AllowedSummary {
    /// Logarithm of the ratio of likelihoods within which both explain the rows alike. A convention.
    pub const ALIKE: f64 = 2.0;

    /// Which of both explains the rows, in a few sentences.
    pub fn sentence(&self) -> String {
        let wrong: Vec<String> = self.suspects.iter().map(|suspect| suspect.words().0).collect();
        let instead = match self.instead.as_slice() {
            [] => "nothing in the robot explains them".to_owned(),
            names => format!("the robot would have {}", names.join(" and ")),
        };
        let kind = |kind: &AllowedKind| {
            let AllowedKind { kind, unit, as_described, allowed } = kind;
            format!("{kind} {} → {} {unit}", significant(*as_described, 3), significant(*allowed, 3))
        };
        let kinds: Vec<String> = self.kinds.iter().map(kind).collect();
        let share = if self.preferred { self.probability } else { 1.0 - self.probability };
        let share = if share > 0.99 { "> 0.99".to_owned() } else { significant(share, 2) };
        let alike = (self.probability / (1.0 - self.probability)).ln().abs() <= Self::ALIKE;
        let verdict = match (alike, self.preferred) {
            (true, _) => {
                "What observed the robot is not as described, or the robot is not: both explain the rows alike"
            }
            (_, true) => "What observed the robot is not as described",
            (_, false) => "The robot is to blame, not what observed it",
        };
        let result = match self.preferred {
            true => {
                "The result is that with this allowed for: mend it, or declare it, before it is used again"
            }
            false => "The result is that without it",
        };
        format!(
            "{verdict} (probability {share}). Tried: {}. Otherwise {instead}. Held-out rows, by which this was decided: {}. {result}.\n",
            wrong.join("; "),
            kinds.join(", ")
        )
    }
}

/// All of them, a line each.
pub(crate) fn sentences(suspects: &[SuspectSummary]) -> String {
    suspects.iter().map(|suspect| format!("Suspect: {}\n", suspect.sentence())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(what: &str, from_line: Option<u64>, values: &[(&str, f64, f64, &str)]) -> SuspectSummary {
        let value =
            |&(name, value, half, unit): &(&str, f64, f64, &str)| (name.into(), value, half, unit.into());
        SuspectSummary {
            name: "A".into(),
            what: what.into(),
            from_line,
            instead: None,
            values: values.iter().map(value).collect(),
            rms: 0.123,
            unit: "mm".into(),
            p_value: 1e-9,
        }
    }

    #[test]
    fn who_is_wrong_is_said_with_both_errors() {
        let mut tried = AllowedSummary {
            suspects: vec![of("lens", None, &[("fx of A", 9.0, 0.4, "px")])],
            instead: vec!["transmission j2".into()],
            kinds: vec![AllowedKind {
                kind: "pixel".into(),
                unit: "px".into(),
                as_described: 0.5,
                allowed: 0.1,
            }],
            probability: 0.996,
            preferred: true,
        };
        let words = "What observed the robot is not as described (probability > 0.99). Tried: A has another lens than stated, by fx of A 9.00 ± 0.40 px. Otherwise the robot would have transmission j2. Held-out rows, by which this was decided: pixel 0.500 → 0.100 px.";
        assert!(tried.sentence().starts_with(words), "{}", tried.sentence());
        tried.probability = 0.4;
        assert!(
            tried.sentence().contains("both explain the rows alike (probability 0.40)"),
            "{}",
            tried.sentence()
        );
        (tried.probability, tried.preferred, tried.instead) = (0.05, false, Vec::new());
        let words = "The robot is to blame, not what observed it (probability 0.95).";
        assert!(tried.sentence().starts_with(words), "{}", tried.sentence());
        assert!(tried.sentence().contains("Otherwise nothing in the robot explains them."));
    }

    #[test]
    fn what_is_wrong_is_said_with_its_size() {
        let moved = of("moved", Some(47), &[("x@A", 0.3, 0.02, "mm")]).sentence();
        assert!(
            moved.starts_with(
                "rows of A from about line 47 on lie elsewhere than those before, by x@A 0.300 ± 0.020 mm: 0.12 mm RMS"
            ),
            "{moved}"
        );
        let flat = of("flatness", None, &[("bend 1 of A", 1.0, 0.1, "1/m")]).sentence();
        assert!(flat.starts_with("A is not flat: 0.12 mm RMS"), "{flat}");
        let gain = of("gain and offset", None, &[("gain of A", 0.01, 0.001, "1")]).sentence();
        let words = "A has another gain and offset than stated, by gain of A 0.0100 ± 0.0010: ";
        assert!(gain.starts_with(words), "{gain}");
    }
}

//! What the program reports, read from `discovery.json`. A field that a version does not write is absent, never an error.
//!
//! One line a robot: what it was, what was reported, what is true. A cell that is missing is not reported, or does not apply.

use super::description::Kind;
use super::stream::Key;
use crate::prelude::*;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// A name that is reported, with its probability where one is.
#[derive(Debug, Clone, PartialEq)]
pub struct Name {
    pub family: String,
    pub joint: Option<String>,
    pub probability: Option<f64>,
    /// Of an alternative: not distinguishable from the finding.
    pub equivalent: bool,
}

/// A finding.
#[derive(Debug, Clone, PartialEq)]
pub struct Effect {
    pub name: Name,
    pub p_value: Option<f64>,
    /// Probability that none of the names is right.
    pub unnamed: Option<f64>,
    pub alternatives: Vec<Name>,
    /// Rows that it is about, 1-based.
    pub rows: Vec<usize>,
    /// Pose measurements that it is about, as the file numbers them.
    pub poses: Vec<usize>,
}

/// A report.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Reported {
    pub verdict: Option<String>,
    pub floor_mm: Option<f64>,
    pub floor_source: Option<String>,
    pub floor_ci95_mm: Option<[f64; 2]>,
    pub significant: Option<bool>,
    pub p_value: Option<f64>,
    pub autocorrelation: Option<f64>,
    pub effects: Vec<Effect>,
    /// Held-out 3-D RMS and its interval, before and after, mm.
    pub holdout: [Option<f64>; 2],
    pub holdout_ci95: [Option<[f64; 2]>; 2],
    /// Interval of the reduction of the held-out RMS, mm.
    pub gain_ci95: Option<[f64; 2]>,
}

impl Effect {
    /// Whether it is a cause, with or without a name; excluded rows are none.
    pub fn is_cause(&self) -> bool {
        self.name.family != "outlier"
    }

    pub fn is_named(&self) -> bool {
        self.is_cause() && self.name.family != "unmodelled"
    }
}

impl Reported {
    pub fn of(json: &Value) -> Self {
        // Without rows that are reported as outliers, where there are any: the figure that is printed.
        let part = |side: &str| {
            let without = format!("/{side}/holdout_without_outliers");
            let there = json.pointer(&without).is_some_and(|value| !value.is_null());
            if there { without } else { format!("/{side}/holdout") }
        };
        let parts = ["before", "after"].map(part);
        Reported {
            verdict: at(json, "/verdict"),
            floor_mm: at(json, "/noise_floor/rms_mm").or_else(|| at(json, "/noise_floor_mm")),
            floor_source: at(json, "/noise_floor/source"),
            floor_ci95_mm: at(json, "/noise_floor/ci95_mm"),
            significant: at(json, "/unexplained/significant"),
            p_value: at(json, "/unexplained/p_value"),
            autocorrelation: at(json, "/dependence/autocorrelation"),
            effects: list(json, "/effects").iter().map(effect).collect(),
            holdout: [0, 1].map(|k| at(json, &format!("{}/rms_mm", parts[k]))),
            holdout_ci95: [0, 1].map(|k| at(json, &format!("{}/ci95_mm", parts[k]))),
            gain_ci95: at(json, "/gain/ci95_mm").or_else(|| at(json, "/gain_ci95_mm")),
        }
    }

    /// The p-value of the first screen: that of the first finding, or of the last screen where nothing is found.
    pub fn first_p(&self) -> Option<f64> {
        self.effects.iter().find(|effect| effect.is_cause()).map_or(self.p_value, |first| first.p_value)
    }
}

/// What is at a place of the report; none where there is nothing, or something else.
fn at<T: DeserializeOwned>(json: &Value, path: &str) -> Option<T> {
    serde_json::from_value(json.pointer(path)?.clone()).ok()
}

fn list(json: &Value, path: &str) -> Vec<Value> {
    at(json, path).unwrap_or_default()
}

fn name(json: &Value, probability: &str) -> Name {
    Name {
        family: at(json, "/family").unwrap_or_default(),
        joint: at(json, "/joint"),
        probability: at(json, probability),
        equivalent: at(json, "/equivalent").unwrap_or(false),
    }
}

fn effect(json: &Value) -> Effect {
    let whole = |path: &str| at::<Vec<usize>>(json, path).unwrap_or_default();
    Effect {
        name: name(json, "/name_probability"),
        p_value: at(json, "/p_value"),
        unnamed: at(json, "/unnamed_probability"),
        alternatives: list(json, "/alternatives").iter().map(|one| name(one, "/probability")).collect(),
        rows: whole("/rows"),
        poses: [whole("/poses"), whole("/visits")].concat(),
    }
}

/// One robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record(BTreeMap<String, String>);

impl Record {
    pub fn new(key: Key, kind: Kind, cell: &str) -> Self {
        let mut record = Record(BTreeMap::new());
        record.set("half", key.half.word());
        record.set("kind", kind.word());
        record.set("cell", cell);
        record.set("number", key.number);
        record
    }

    /// Fills a cell.
    pub fn set(&mut self, column: &str, value: impl ToString) {
        self.0.insert(column.into(), value.to_string().replace([',', '\n', '\r', '"'], " "));
    }

    /// Fills a cell where there is a value.
    pub fn set_some(&mut self, column: &str, value: Option<impl ToString>) {
        if let Some(value) = value {
            self.set(column, value);
        }
    }

    pub fn text(&self, column: &str) -> &str {
        self.0.get(column).map_or("", String::as_str)
    }

    pub fn number(&self, column: &str) -> Option<f64> {
        self.text(column).parse().ok()
    }

    pub fn yes(&self, column: &str) -> Option<bool> {
        self.text(column).parse().ok()
    }

    pub fn is(&self, half: Half, kind: Kind, cell: &str, number: u64) -> bool {
        self.text("half") == half.word()
            && self.text("kind") == kind.word()
            && self.text("cell") == cell
            && self.text("number") == number.to_string()
    }

    /// Whether a plant was made and the search came to its end.
    pub fn ended(&self) -> bool {
        self.text("ended") == "yes"
    }

    /// By half, kind, cell and number: the order of lines does not depend on threads or interruptions.
    pub fn order(&self) -> (String, String, String, u64) {
        let text = |column: &str| self.text(column).to_owned();
        (text("half"), text("kind"), text("cell"), self.text("number").parse().unwrap_or(u64::MAX))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_of_any_version_is_read() {
        let old = serde_json::json!({
            "noise_floor_mm": 0.2,
            "unexplained": { "significant": false, "p_value": 0.3 },
            "effects": [{ "family": "backlash", "joint": "j2", "p_value": 0.001, "alternatives": [
                { "family": "unmodelled", "equivalent": true } ] }],
            "before": { "holdout": { "rms_mm": 0.5 } }, "after": { "holdout": { "rms_mm": 0.2 } },
        });
        let read = Reported::of(&old);
        assert_eq!((read.floor_mm, read.verdict.clone(), read.floor_source.clone()), (Some(0.2), None, None));
        assert_eq!(read.effects[0].name.probability, None);
        assert!(read.effects[0].is_named() && read.effects[0].alternatives[0].equivalent);
        assert_eq!(read.first_p(), Some(0.001));
        assert_eq!(read.holdout, [Some(0.5), Some(0.2)]);
        let new = serde_json::json!({
            "verdict": "undecided",
            "noise_floor": { "rms_mm": null, "source": "unknown", "ci95_mm": null },
            "noise_floor_mm": null,
            "unexplained": { "significant": true, "p_value": 0.0001, "rms_mm": 0.1 },
            "dependence": { "autocorrelation": 0.4 },
            "effects": [{ "family": "outlier", "rows": [4, 5], "poses": [2], "p_value": 0.01,
                "name_probability": 0.9, "unnamed_probability": 0.05,
                "alternatives": [{ "family": "drift", "probability": 0.05 }] }],
            "before": { "holdout": { "rms_mm": 0.5, "ci95_mm": [0.4, 0.6] },
                "holdout_without_outliers": { "rms_mm": 0.45, "ci95_mm": [0.35, 0.55] } },
        });
        let read = Reported::of(&new);
        assert_eq!((read.verdict.as_deref(), read.floor_mm), (Some("undecided"), None));
        assert_eq!(read.autocorrelation, Some(0.4));
        assert_eq!(read.holdout_ci95, [Some([0.35, 0.55]), None]);
        assert_eq!(
            (read.effects[0].rows.as_slice(), read.effects[0].poses.as_slice()),
            (&[4, 5][..], &[2][..])
        );
        assert_eq!(read.effects[0].alternatives[0].probability, Some(0.05));
        // Rows that are excluded are no cause, so that the p is that of the last screen.
        assert_eq!(read.first_p(), Some(0.0001));
    }
}

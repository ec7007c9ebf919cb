//! One line a robot: what it was, what was reported, what is true. A cell that is missing is not reported, or does not apply.

use super::description::Kind;
use super::stream::Key;
use crate::prelude::*;

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

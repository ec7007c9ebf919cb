//! One line a robot: what it was, what was reported, what is true. An empty cell is not reported, or does not apply.

use super::description::Kind;
use super::stream::{Half, Key};
use crate::journal::Line;

/// The columns.
const COLUMNS: [&str; 57] = [
    "half",
    "kind",
    "cell",
    "number",
    "ended",
    "make",
    "cause",
    "inside",
    "size",
    "poses",
    "targets",
    "repeats",
    "order",
    "memory",
    "stated",
    "rows",
    "findings",
    "outliers",
    "found",
    "first",
    "first_right",
    "listed",
    "confident_wrong",
    "names",
    "verdict",
    "significant",
    "left",
    "floor_source",
    "floor_ratio",
    "floor_covered",
    "p_first",
    "alarm",
    "ratio",
    "fresh_ratio",
    "harm",
    "before_covered",
    "after_covered",
    "gain_covered",
    "bad",
    "bad_reported",
    "bad_partly",
    "other_reported",
    "bad_floor_ratio",
    "bad_fresh_ratio",
    "autocorrelation",
    "fresh_mm",
    "floor_mm",
    "words",
    "seconds",
    "declared_ratio",
    "held_ratio",
    "oracle_ratio",
    "bad_known",
    "bad_least",
    "executed_before",
    "executed",
    "executed_refused",
];

/// How many of them tables had that were begun before robots with several causes.
const EARLIER: usize = 54;

const HEADER: &str = "half,kind,cell,number,ended,make,cause,inside,size,poses,targets,repeats,order,memory,stated,rows,\
findings,outliers,found,first,first_right,listed,confident_wrong,names,verdict,significant,left,floor_source,floor_ratio,\
floor_covered,p_first,alarm,ratio,fresh_ratio,harm,before_covered,after_covered,gain_covered,bad,bad_reported,bad_partly,\
other_reported,bad_floor_ratio,bad_fresh_ratio,autocorrelation,fresh_mm,floor_mm,words,seconds,declared_ratio,held_ratio,oracle_ratio,bad_known,bad_least,executed_before,executed,executed_refused";

/// One robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    cells: Vec<String>,
}

impl Record {
    pub fn new(key: Key, kind: Kind, cell: &str) -> Self {
        let mut record = Record { cells: vec![String::new(); COLUMNS.len()] };
        record.set("half", key.half.word());
        record.set("kind", kind.word());
        record.set("cell", cell);
        record.set("number", key.number);
        record
    }

    fn place(column: &str) -> Option<usize> {
        COLUMNS.iter().position(|known| *known == column)
    }

    /// Fills a cell; what would break a row is taken out.
    pub fn set(&mut self, column: &str, value: impl ToString) {
        debug_assert!(Record::place(column).is_some(), "column {column}");
        if let Some(place) = Record::place(column) {
            self.cells[place] = value.to_string().replace([',', '\n', '\r', '"'], " ");
        }
    }

    /// Fills a cell where there is a value.
    pub fn set_some(&mut self, column: &str, value: Option<impl ToString>) {
        if let Some(value) = value {
            self.set(column, value);
        }
    }

    pub fn text(&self, column: &str) -> &str {
        Record::place(column).map_or("", |place| self.cells[place].as_str())
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

impl Line for Record {
    const HEADER: &'static str = HEADER;

    fn row(&self) -> String {
        self.cells.join(",")
    }

    fn of(row: &str) -> Option<Self> {
        let mut cells: Vec<String> = row.split(',').map(str::to_owned).collect();
        let known = [EARLIER, COLUMNS.len()].contains(&cells.len()) && cells[0] != "half";
        cells.resize(COLUMNS.len(), String::new());
        let record = Record { cells };
        (known && !record.text("ended").is_empty()).then_some(record)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_is_the_list_of_columns() {
        assert_eq!(HEADER, COLUMNS.join(","));
        assert!(Record::of(HEADER).is_none());
    }

    #[test]
    fn a_row_comes_back_and_half_a_row_does_not() {
        let key = Kind::Stated.key(Half::Locked, 12);
        let mut record = Record::new(key, Kind::Stated, "1/3");
        record.set("ended", "no: a word, \"quoted\"\n");
        record.set("floor_ratio", 0.1 + 0.2);
        record.set_some("p_first", None::<f64>);
        let back = Record::of(&record.row()).expect("a record");
        assert_eq!(back, record);
        assert!(
            back.is(Half::Locked, Kind::Stated, "1/3", 12) && !back.is(Half::Tuning, Kind::Stated, "1/3", 12)
        );
        assert_eq!(back.number("floor_ratio").map(f64::to_bits), Some((0.1f64 + 0.2).to_bits()));
        assert_eq!((back.number("p_first"), back.ended()), (None, false));
        let row = record.row();
        assert!(Record::of(&row[..row.len() / 2]).is_none());
    }
}
